// OpenDRIVE: what is written is read back, and what cannot be read is told.
#include <gtest/gtest.h>

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
    anchors.push_back({centre + p, 2000 * unit(random), 3 + unit(random)});
  }
  AlignmentOptions options;
  options.closed = closed;
  options.tight = TightPolicy::kNarrow;
  auto road = road_from_anchors(anchors, options);
  EXPECT_TRUE(road.ok());
  return *road;
}

Network random_network(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  Network network;
  network.name = "a <b> & \"c\" \xC3\xBC";
  if (seed % 3 != 0) network.georeference = Georeference{90 * unit(random), 180 * unit(random), 1000 * unit(random)};
  for (int i = 0; i < 3; ++i) {
    Road road = random_road(random, (seed + i) % 2 == 0);
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
      }
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
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Network network = random_network(seed);
    const Result<Network> back = parse_opendrive(without_user_data(written(network)), "net.xodr");
    ASSERT_TRUE(back.ok()) << back.error().text();
    for (std::size_t r = 0; r < network.roads.size(); ++r) {
      for (std::size_t i = 0; i < network.roads[r].segments.size(); ++i) {
        const Segment &a = network.roads[r].segments[i], &b = back->roads[r].segments[i];
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
      {changed(geometry + "<line/>", geometry + "<arc curvature=\"0.1\"/>"), 6, "<arc> is not supported yet"},
      {changed(geometry + "<line/>", geometry), 6, "no shape"},
      {changed("id=\"7\"", "id=\"\""), 4, "id"},
      {changed("b=\"0.1\"", "b=\"inf\""), 10, "finite"},
      {changed("b=\"0.1\"", "b=\"1e9\""), 10, "1e6"},
      {changed("</elevationProfile>", "<elevation s=\"50\" a=\"1\" b=\"0\" c=\"0\" d=\"0\"/></elevationProfile>"), 11,
       "within a geometry"},
      {changed("<lanes>",
               "<lateralProfile><superelevation s=\"0\" a=\"0.1\" b=\"0\" c=\"0\" "
               "d=\"0\"/></lateralProfile><lanes>"),
       12, "superelevation"},
      {changed("<lanes>", "<lanes><laneOffset s=\"0\" a=\"1\" b=\"0\" c=\"0\" d=\"0\"/>"), 12, "laneOffset"},
      {changed("a=\"3\"", "a=\"4\""), 12, "different widths"},
      {changed("type=\"driving\"", "type=\"sidewalk\""), 13, "sidewalk"},
      {changed("</road>", "</road><junction id=\"1\"/>"), 17, "junction"},
      {changed("junction=\"-1\"", "junction=\"3\""), 4, "junction"},
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
  const std::string text = changed("<lanes>", "<objects/><signals/><lanes>");
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
