// OpenDRIVE: what is written is read back, and what cannot be read is told.
#include <gtest/gtest.h>
#include <algorithm>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "roadgen/export/opendrive.h"
#include "roadgen/fit/catmull_rom.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/import/param_poly3.h"

namespace roadgen {
namespace {

// A road that wanders, or a loop, far from the origin; heights and widths vary.
Road random_road(std::mt19937& random, bool closed) {
  std::uniform_real_distribution<double> unit(0, 1);
  const glm::dvec2 centre = (glm::dvec2(unit(random), unit(random)) - 0.5) * std::pow(10.0, 1 + 6 * unit(random));
  std::vector<Anchor> anchors;
  const int count = 8 + static_cast<int>(12 * unit(random));
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count, radius = 300 * (1 + 0.2 * unit(random));
    const glm::dvec2 p =
        closed ? radius * glm::dvec2(std::cos(angle), std::sin(angle)) : glm::dvec2(100.0 * i, 40 * unit(random));
    anchors.push_back({centre + p, 40 * unit(random), 3 + unit(random)});
  }
  AlignmentOptions options;
  options.closed = closed;
  options.tight = TightPolicy::kNarrow;
  auto road = road_from_anchors(anchors, options);
  EXPECT_TRUE(road.ok());
  return *road;
}

// Lanes, marks, profiles and paint at random, continuous at joints where check() wants it, with every number in use.
void make_rich(std::mt19937& random, Road& road) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto pick = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
  const auto mark = [&] {
    Mark m;
    m.kind = static_cast<MarkKind>(pick(7));
    m.color = static_cast<PaintColor>(pick(6));
    if (pick(2)) m.width_m = 0.2 + 0.1 * unit(random), m.space_m = 0.2 + 0.1 * unit(random);
    if (pick(2)) m.on_m = 3 + unit(random), m.off_m = pick(3) ? 6 + unit(random) : 0;
    if (pick(2)) m.phase_m = 1 + unit(random);
    return m;
  };
  // Lanes share the road's own edges, for which its segments are certified.
  std::vector<LaneSection> sections;
  for (const Segment& segment : road.segments) {
    LaneSection section;
    section.s_m = segment.s_start_m;
    section.center_mark = mark();
    if (pick(2)) section.offset_m = {0.1 * unit(random), 1e-4 * unit(random), 1e-7 * unit(random), 0};
    for (auto* side : {&section.left, &section.right}) {
      const Cubic edge = side == &section.left ? segment.left_m - section.offset_m : section.offset_m - segment.right_m;
      const int count = side == &section.left && pick(4) == 0 ? 0 : 1 + pick(3);
      for (int i = 0; i < count; ++i) {
        Lane lane;
        lane.type = static_cast<LaneType>(pick(kLaneTypes));
        lane.material = pick(2) ? default_material(lane.type) : static_cast<Material>(pick(6));
        lane.width_m = {edge.c0 / count, edge.c1 / count, edge.c2 / count, edge.c3 / count};
        if (pick(3) == 0) lane.inner_height_m = 0.1 * unit(random), lane.outer_height_m = 0.12 * unit(random);
        lane.mark = mark();
        side->push_back(lane);
      }
    }
    sections.push_back(section);
  }
  // Some sections go on over several segments.
  for (Segment& segment : road.segments) segment.superelevation_rad = {};
  ASSERT_TRUE(set_sections(road, sections).ok());

  const std::size_t count = road.segments.size();
  std::vector<double> bank(count + 1), left(count + 1), right(count + 1);
  for (std::size_t i = 0; i <= count; ++i) {
    bank[i] = 0.3 * unit(random), left[i] = 0.1 * unit(random), right[i] = 0.1 * unit(random);
  }
  if (road.closed) bank[count] = bank[0], left[count] = left[0], right[count] = right[0];
  const bool banked = pick(3) != 0, falls = pick(3) != 0, jumps = pick(2) != 0;
  for (std::size_t i = 0; i < count; ++i) {
    Segment& s = road.segments[i];
    if (banked) s.superelevation_rad = Cubic::hermite(bank[i], 0, bank[i + 1], 0, s.arc_m);
    if (!falls) continue;
    s.crossfall_left = {left[i], (left[i + 1] - left[i]) / s.arc_m};
    s.crossfall_right = {right[i], jumps ? 0 : (right[i + 1] - right[i]) / s.arc_m};
  }
  for (int i = pick(6); i > 0; --i) {
    Paint p;
    p.kind = static_cast<PaintKind>(pick(7));
    p.color = static_cast<PaintColor>(pick(6));
    p.s_m = (0.5 + 0.4 * unit(random)) * road.length_m();
    const Segment& under = road.segments[segment_at(road, p.s_m)];
    p.t_m = 0.5 * (under.left_m.c0 + under.right_m.c0);
    p.length_m = 1 + 0.5 * unit(random), p.width_m = 0.3 + 0.2 * unit(random), p.stripe_m = 0.5 + 0.1 * unit(random);
    p.against = pick(2) == 0;
    road.paint.push_back(p);
  }
}

Network random_network(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  Network network;
  network.name = "a <b> & \"c\" \xC3\xBC";
  if (seed % 3 != 0) network.georeference = Georeference{90 * unit(random), 180 * unit(random), 1000 * unit(random)};
  for (int i = 0; i < 3; ++i) {
    Road road = random_road(random, (seed + i) % 2 == 0);
    if (seed % 4 != 0) make_rich(random, road);
    road.id = std::to_string(i + 1);
    road.name = "road " + road.id;
    network.roads.push_back(road);
  }
  return network;
}

std::string written(const Network& network) {
  const Result<std::string> text = opendrive_text(network);
  EXPECT_TRUE(text.ok()) << (text.ok() ? "" : text.error().text());
  return text.ok() ? *text : "";
}

void expect_same(const Cubic& a, const Cubic& b) {
  EXPECT_EQ(a.c0, b.c0);
  EXPECT_EQ(a.c1, b.c1);
  EXPECT_EQ(a.c2, b.c2);
  EXPECT_EQ(a.c3, b.c3);
}

TEST(OpenDrive, RoundTripIsExactAndTheSecondFileIsTheFirst) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Network network = random_network(seed);
    const std::string text = written(network);
    Diagnostics diagnostics;
    const Result<Network> back = parse_opendrive(text, "net.xodr", &diagnostics);
    ASSERT_TRUE(back.ok()) << back.error().text();
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.front().text();
    EXPECT_EQ(back->name, network.name);
    EXPECT_EQ(back->georeference.has_value(), network.georeference.has_value());
    ASSERT_EQ(back->roads.size(), network.roads.size());
    for (std::size_t r = 0; r < network.roads.size(); ++r) {
      EXPECT_EQ(back->roads[r].closed, network.roads[r].closed);
      ASSERT_EQ(back->roads[r].segments.size(), network.roads[r].segments.size());
      for (std::size_t i = 0; i < network.roads[r].segments.size(); ++i) {
        const Segment &a = network.roads[r].segments[i], &b = back->roads[r].segments[i];
        EXPECT_EQ(a.start_m, b.start_m);
        EXPECT_EQ(a.end_m, b.end_m);
        EXPECT_EQ(a.slope_start, b.slope_start);
        EXPECT_EQ(a.slope_end, b.slope_end);
        EXPECT_EQ(a.arc_m, b.arc_m);
        EXPECT_EQ(a.s_start_m, b.s_start_m);
        EXPECT_EQ(a.bound.v, b.bound.v);
        expect_same(a.elevation_m, b.elevation_m);
        expect_same(a.left_m, b.left_m);
        expect_same(a.right_m, b.right_m);
        expect_same(a.superelevation_rad, b.superelevation_rad);
        EXPECT_EQ(a.crossfall_left, b.crossfall_left);
        EXPECT_EQ(a.crossfall_right, b.crossfall_right);
        EXPECT_EQ(a.section, b.section);
      }
      EXPECT_EQ(back->roads[r].sections, network.roads[r].sections);
      EXPECT_EQ(back->roads[r].paint, network.roads[r].paint);
    }
    EXPECT_EQ(written(*back), text);
    EXPECT_TRUE(check(*back).ok()) << check(*back).problems.front();
  }
}

// As another program would: by the paramPoly3 alone.
std::string without_user_data(std::string text) {
  for (std::size_t at; (at = text.find("<userData code=\"roadgen:chord\"")) != text.npos;) {
    text.erase(at, text.find("/>", at) + 2 - at);
  }
  return text;
}

TEST(OpenDrive, ThePolynomialAloneGivesTheCurveToNanometres) {
  std::size_t compared = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Network network = random_network(seed);
    const Result<Network> back = parse_opendrive(without_user_data(written(network)), "net.xodr");
    ASSERT_TRUE(back.ok()) << back.error().text();
    for (std::size_t r = 0; r < network.roads.size(); ++r) {
      const std::vector<Segment>& read = back->roads[r].segments;
      for (const Segment& a : network.roads[r].segments) {
        // Random lanes may be too wide for a segment; the reader divides it then.
        const auto found = std::find_if(read.begin(), read.end(), [&](const Segment& segment) {
          return glm::length(segment.start_m - a.start_m) + glm::length(segment.end_m - a.end_m) < 1e-6;
        });
        if (found == read.end()) continue;
        const Segment& b = *found;
        ++compared;
        // Coordinates up to 5e6 m step by 1e-9 m.
        const double size = std::max({1.0, std::abs(a.start_m.x), std::abs(a.start_m.y)});
        for (double u = 0; u <= 1; u += 0.125) {
          EXPECT_LT(glm::length(position_m(a, u) - position_m(b, u)), 1e-9 + 4e-16 * size);
        }
        EXPECT_NEAR(a.slope_start, b.slope_start, 1e-12 + 1e-15 * size);
        EXPECT_NEAR(a.slope_end, b.slope_end, 1e-12 + 1e-15 * size);
      }
    }
  }
  EXPECT_GT(compared, 500u);
}

TEST(ParamPoly3, AGraphOverItsChordIsReadInEveryTurnAndRange) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> slope(-1.5, 1.5), angle(-4, 4), metre(-1000, 1000);
  for (int i = 0; i < 200; ++i) {
    const double a = slope(random), b = slope(random), length = 1 + std::abs(metre(random));
    // (x, f(x)) over a chord of that length along x.
    ParametricCubic curve{
        {metre(random), metre(random)}, {length, a * length}, {0, -(2 * a + b) * length}, {0, (a + b) * length}};
    curve = curve.rescaled(1 / length).rescaled(length).turned(angle(random));
    const Result<Segment> segment = segment_from_cubic(curve);
    ASSERT_TRUE(segment.ok()) << segment.error().message;
    EXPECT_NEAR(segment->slope_start, a, 1e-12);
    EXPECT_NEAR(segment->slope_end, b, 1e-12);
    EXPECT_NEAR(segment->chord_length_m(), length, 1e-12 * length);
  }
}

TEST(ParamPoly3, OtherCurvesAreErrors) {
  const auto fails = [](ParametricCubic curve) { return !segment_from_cubic(curve).ok(); };
  EXPECT_TRUE(fails({{0, 0}, {0, 0}, {0, 0}, {0, 0}}));      // no length
  EXPECT_TRUE(fails({{0, 0}, {10, 0}, {-3, 1}, {3, 1}}));    // not linear along the chord
  EXPECT_TRUE(fails({{0, 0}, {1e200, 0}, {0, 0}, {0, 0}}));  // beyond 1e9 m
  EXPECT_TRUE(fails({{NAN, 0}, {1, 0}, {0, 0}, {0, 0}}));
  EXPECT_TRUE(fails({{0, 0}, {1, 1000}, {0, -2000}, {0, 1000}}));  // nearly across the chord
}

// A small file of two straight geometries, to be damaged.
std::string small_file() {
  return R"(<?xml version="1.0"?>
<OpenDRIVE>
<header revMajor="1" revMinor="6"><geoReference><![CDATA[+proj=ortho +lat_0=50 +lon_0=11 +ellps=WGS84]]></geoReference></header>
<road name="r" length="150" id="7" junction="-1">
<planView>
<geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>
<geometry s="100" x="100" y="0" hdg="0" length="50"><line/></geometry>
</planView>
<elevationProfile>
<elevation s="0" a="1" b="0.1" c="0" d="0"/>
</elevationProfile>
<lanes><laneSection s="0">
<left><lane id="1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
<center><lane id="0" type="none"/></center>
<right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right>
</laneSection></lanes>
</road>
</OpenDRIVE>
)";
}

std::string changed(const std::string& from, const std::string& to) {
  std::string text = small_file();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(OpenDrive, ForeignLinesProfilesAndGeoreferenceAreRead) {
  const Result<Network> network = parse_opendrive(small_file(), "n.xodr");
  ASSERT_TRUE(network.ok()) << network.error().text();
  const Road& road = network->roads[0];
  EXPECT_EQ(road.id, "7");
  EXPECT_DOUBLE_EQ(road.length_m(), 150);
  EXPECT_NEAR(road.segments[1].elevation_m.value(0), 11, 1e-12);
  EXPECT_EQ(road.segments[1].left_m.c0, 3);
  EXPECT_EQ(network->georeference->latitude_deg, 50);
  EXPECT_TRUE(check(*network).ok());
}

TEST(OpenDrive, DamageIsAnErrorWithFileAndLine) {
  struct Case {
    std::string text;
    int line;
    const char* says;
  };
  const std::string geometry = "<geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"100\">";
  const Case cases[] = {
      {small_file().substr(0, 700), 15, "truncated"},
      {"", 1, "XML"},
      {"<kml/>", 1, "OpenDRIVE"},
      {"<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/></OpenDRIVE>", 0, "no roads"},
      {changed("revMajor=\"1\"", "revMajor=\"2\""), 3, "version"},
      {changed("x=\"100\" ", ""), 7, "lacks the attribute x"},
      {changed("x=\"100\"", "x=\"nan\""), 7, "finite"},
      {changed("x=\"100\"", "x=\"12,5\""), 7, "finite"},
      {changed("x=\"100\"", "x=\"1e300\""), 7, "1e9"},
      {changed("length=\"50\"", "length=\"0\""), 7, "positive"},
      {changed("length=\"50\"", "length=\"-1\""), 7, "positive"},
      {changed("s=\"100\"", "s=\"90\""), 7, "does not start where"},
      {changed(geometry + "<line/>", geometry), 6, "no shape"},
      {changed("id=\"7\"", "id=\"\""), 4, "id"},
      {changed("b=\"0.1\"", "b=\"inf\""), 10, "finite"},
      {changed("b=\"0.1\"", "b=\"1e9\""), 10, "1e6"},
      {changed("name=\"r\"", "name=\"\xFF\""), 4, "UTF-8"},
  };
  for (const Case& c : cases) {
    const Result<Network> network = parse_opendrive(c.text, "n.xodr");
    ASSERT_FALSE(network.ok()) << c.says;
    EXPECT_EQ(network.error().file, "n.xodr");
    EXPECT_EQ(network.error().line, c.line) << network.error().text();
    EXPECT_NE(network.error().text().find(c.says), std::string::npos) << network.error().text();
  }
}

TEST(OpenDrive, WhatIsNotKeptIsToldOncePerKind) {
  Diagnostics diagnostics;
  const std::string text =
      changed("<lanes>", "<objects><object/><object/></objects><signals><signal/></signals><lanes>");
  ASSERT_TRUE(parse_opendrive(text, "n.xodr", &diagnostics).ok());
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_EQ(diagnostics[0].line, 12);
  EXPECT_EQ(diagnostics[0].element, "road 7");
}

TEST(OpenDrive, AnEditedFileFollowsItsGeometryNotTheUserData) {
  Network network = random_network(1);
  network.roads.resize(1);
  network.roads[0].segments.resize(1);
  network.roads[0].closed = false;
  network.roads[0].paint.clear();
  two_lane_sections(network.roads[0]);
  std::string text = written(network);
  const std::size_t at = text.find("roadgen:chord\" value=\"") + 22;
  text.insert(at, "9");
  Diagnostics diagnostics;
  const Result<Network> back = parse_opendrive(text, "n.xodr", &diagnostics);
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(diagnostics.size(), 1u);
  EXPECT_LT(glm::length(back->roads[0].segments[0].end_m - network.roads[0].segments[0].end_m), 1e-6);
}

TEST(OpenDrive, ANetworkThatCannotBeWrittenIsAnError) {
  Network network = random_network(2);
  network.roads[1].id = network.roads[0].id;
  EXPECT_FALSE(opendrive_text(network).ok());
  network = random_network(2);
  network.roads[1].segments[0].elevation_m.c1 = NAN;
  EXPECT_FALSE(opendrive_text(network).ok());
  network = random_network(2);
  network.roads[1].segments.clear();
  EXPECT_FALSE(opendrive_text(network).ok());
}

}  // namespace
}  // namespace roadgen
