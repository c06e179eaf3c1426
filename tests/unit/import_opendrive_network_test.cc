// What makes roads a network in OpenDRIVE: structures along them, links between them, junctions and their areas.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "roadgen/export/opendrive.h"
#include "roadgen/fit/catmull_rom.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/query/road_index.h"
#include "roadgen/render/road_instance.h"
#include "roadgen/road/crossing.h"
#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

 private:
  std::mt19937 random_;
};

LaneSection street(Dice& dice, bool sidewalks) {
  LaneSection section;
  for (auto* side : {&section.left, &section.right}) {
    side->push_back({.width_m = {dice.in(2.8, 3.6)}, .mark = {}});
    if (sidewalks) {
      side->push_back({.type = LaneType::kSidewalk,
                       .width_m = {dice.in(1, 2)},
                       .inner_height_m = 0.12,
                       .outer_height_m = 0.12,
                       .mark = {}});
    }
  }
  return section;
}

Sweep random_sweep(Dice& dice, double length_m) {
  Sweep sweep{.s_start_m = dice.in(0, 0.4) * length_m,
              .s_end_m = dice.in(0.6, 1) * length_m,
              .t_m = dice.in(-8, 8),
              .t_slope = dice.pick(2) ? dice.in(-0.01, 0.01) : 0,
              .shape = Pipe{}};
  switch (dice.pick(4)) {
    case 0:
      sweep.shape = Tunnel{.half_width_m = dice.in(5, 8),
                           .wall_height_m = dice.in(0, 3),
                           .arch_rise_m = dice.in(1, 5),
                           .lining_m = dice.in(0.1, 1),
                           .head_wall_m = dice.in(0, 1),
                           .head_margin_m = dice.in(0, 1),
                           .walkway_m = dice.in(0, 2),
                           .lamp_spacing_m = dice.in(3, 20)};
      break;
    case 1:
      sweep.shape = GuardRail{.top_m = dice.in(0.5, 1),
                              .beam_height_m = dice.in(0.2, 0.4),
                              .beam_depth_m = dice.in(0.05, 0.1),
                              .sheet_m = 0.004,
                              .post_spacing_m = dice.pick(2) ? 0 : dice.in(1, 5),
                              .post_along_m = dice.in(0.05, 0.1),
                              .post_across_m = dice.in(0.05, 0.1)};
      break;
    case 2: sweep.shape = Pipe{.radius_m = dice.in(0.1, 1), .height_m = dice.in(-1, 3)}; break;
    default:
      sweep.shape = Cable{.radius_m = dice.in(0.01, 0.05),
                          .height_m = dice.in(5, 9),
                          .span_m = dice.in(5, 50),
                          .sag_m = dice.in(0, 2),
                          .pole_radius_m = dice.in(0, 0.2),
                          .pole_above_m = dice.in(0, 1)};
  }
  if (dice.pick(2)) sweep.albedo = glm::dvec3(dice.in(0, 1), dice.in(0, 1), dice.in(0, 1));
  return sweep;
}

// A star of roads around a crossing far from the origin, each with structures; another road goes on from the last one.
Network random_star(unsigned seed) {
  Dice dice(seed);
  Network network;
  network.name = "star";
  const glm::dvec3 origin(dice.in(-1e5, 1e5), dice.in(-1e5, 1e5), dice.in(0, 500));
  std::vector<RoadEnd> ends;
  const int count = 3 + dice.pick(3);
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * M_PI * i / count + dice.in(-0.15, 0.15), grade = dice.in(-0.05, 0.05);
    const glm::dvec2 out(std::cos(angle), std::sin(angle));
    const bool at_end = dice.pick(2) != 0;
    const LaneSection section = street(dice, dice.pick(3) != 0);
    const double half = std::max(section.borders_m().back().c0, -section.borders_m().front().c0);
    std::vector<Anchor> anchors;
    for (const double r : {25.0, 60.0, 110.0}) {
      const glm::dvec2 bend = r > 100 ? dice.in(-20, 20) * glm::dvec2(-out.y, out.x) : glm::dvec2(0);
      anchors.push_back({glm::dvec2(origin) + r * out + bend, origin.z + r * grade, half});
    }
    if (at_end) std::reverse(anchors.begin(), anchors.end());
    auto road = road_from_anchors(anchors, {});
    EXPECT_TRUE(road.ok());
    road->id = "arm " + std::to_string(i);
    EXPECT_TRUE(set_sections(*road, {section}).ok());
    for (Segment& s : road->segments) s.crossfall_left = s.crossfall_right = {dice.in(0, 0.03), 0};
    for (int k = dice.pick(4); k > 0; --k) road->sweeps.push_back(random_sweep(dice, road->length_m()));
    network.roads.push_back(std::move(*road));
    ends.push_back({network.roads.back().id, at_end});
  }
  const Status status = add_crossing(network, "J & <1>", ends, {.corner_radius_m = dice.in(2, 12)});
  EXPECT_TRUE(status.ok()) << status.error().text();

  // A road beyond the first arm's free end, linked lane by lane; whether it is joined is told by the file alone.
  Road& arm = network.roads.front();
  const bool from_end = !ends.front().at_end;
  const RoadPose free_end = pose_at(arm, from_end ? arm.length_m() : 0, 0);
  const double heading = free_end.heading_rad + (from_end ? 0 : M_PI);
  Road next;
  next.id = "next";
  next.segments = {make_segment(
      glm::dvec2(free_end.position_m),
      glm::dvec2(free_end.position_m) + 40.0 * glm::dvec2(std::cos(heading), std::sin(heading)), heading, heading, 4)};
  next.segments[0].elevation_m.c0 = free_end.position_m.z;
  two_lane_sections(next);
  next.joined_start = dice.pick(2) != 0;
  next.predecessor = {RoadLink::To::kRoad, arm.id, from_end, {{1, from_end ? 1 : -1}, {-1, from_end ? -1 : 1}}};
  (from_end ? arm.successor : arm.predecessor) = {RoadLink::To::kRoad, "next", false, {{1, 1}, {-1, -1}, {-1, -2}}};
  // And a junction that is a node alone.
  next.successor = {RoadLink::To::kJunction, "node", false};
  network.roads.push_back(std::move(next));
  network.junction_links.push_back({"node", "a place", {{"next", "arm 1", true, {{-1, 1}}}}});
  network.roads[1].junction = "node";
  if (dice.pick(2)) network.junction_links.insert(network.junction_links.begin(), {"J & <1>", "named", {}});
  return network;
}

Network parsed(const std::string& text, Diagnostics* diagnostics = nullptr) {
  const Result<Network> network = parse_opendrive(text, "net.xodr", diagnostics);
  EXPECT_TRUE(network.ok()) << network.error().text();
  return network.ok() ? *network : Network{};
}

std::string written(const Network& network) {
  const Result<std::string> text = opendrive_text(network);
  EXPECT_TRUE(text.ok()) << text.error().text();
  return text.ok() ? *text : "";
}

void expect_same(const Segment& a, const Segment& b) {
  EXPECT_EQ(a.start_m, b.start_m);
  EXPECT_EQ(a.end_m, b.end_m);
  EXPECT_EQ(a.slope_start, b.slope_start);
  EXPECT_EQ(a.slope_end, b.slope_end);
  EXPECT_EQ(a.s_start_m, b.s_start_m);
  EXPECT_EQ(a.arc_m, b.arc_m);
  EXPECT_EQ(a.elevation_m, b.elevation_m);
  EXPECT_EQ(a.superelevation_rad, b.superelevation_rad);
  EXPECT_EQ(a.left_m, b.left_m);
  EXPECT_EQ(a.right_m, b.right_m);
}

void expect_same(const JunctionArm& a, const JunctionArm& b) {
  EXPECT_EQ(a.road, b.road);
  EXPECT_EQ(a.at_end, b.at_end);
  EXPECT_EQ(a.position_m, b.position_m);
  for (const auto member :
       {&JunctionArm::heading_rad, &JunctionArm::left_m, &JunctionArm::right_m, &JunctionArm::elevation_m,
        &JunctionArm::grade, &JunctionArm::tilt, &JunctionArm::crossfall_left, &JunctionArm::crossfall_right}) {
    EXPECT_EQ(a.*member, b.*member);
  }
}

void expect_same(const Network& a, const Network& b) {
  ASSERT_EQ(a.roads.size(), b.roads.size());
  for (std::size_t r = 0; r < a.roads.size(); ++r) {
    const Road &x = a.roads[r], &y = b.roads[r];
    EXPECT_EQ(x.id, y.id);
    EXPECT_EQ(x.joined_start, y.joined_start) << x.id;
    EXPECT_EQ(x.joined_end, y.joined_end) << x.id;
    EXPECT_EQ(x.predecessor, y.predecessor) << x.id;
    EXPECT_EQ(x.successor, y.successor) << x.id;
    EXPECT_EQ(x.junction, y.junction) << x.id;
    EXPECT_EQ(x.sections, y.sections) << x.id;
    EXPECT_EQ(x.sweeps, y.sweeps) << x.id;
    ASSERT_EQ(x.segments.size(), y.segments.size());
    for (std::size_t i = 0; i < x.segments.size(); ++i) expect_same(x.segments[i], y.segments[i]);
  }
  EXPECT_EQ(a.junction_links, b.junction_links);
  ASSERT_EQ(a.junctions.size(), b.junctions.size());
  for (std::size_t j = 0; j < a.junctions.size(); ++j) {
    const Junction &x = a.junctions[j], &y = b.junctions[j];
    EXPECT_EQ(x.id, y.id);
    EXPECT_EQ(x.corner_radius_m, y.corner_radius_m);
    EXPECT_EQ(x.underlap_m, y.underlap_m);
    ASSERT_EQ(x.arms.size(), y.arms.size());
    ASSERT_EQ(x.corners.size(), y.corners.size());
    for (std::size_t i = 0; i < x.arms.size(); ++i) {
      expect_same(x.arms[i], y.arms[i]);
      ASSERT_EQ(x.corners[i].size(), y.corners[i].size());
      for (std::size_t k = 0; k < x.corners[i].size(); ++k) expect_same(x.corners[i][k], y.corners[i][k]);
    }
  }
}

TEST(OpenDriveNetwork, StructuresLinksAndJunctionsComeBackAsTheyWere) {
  std::size_t sweeps = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    SCOPED_TRACE(seed);
    const Network network = random_star(seed);
    ASSERT_EQ(network.junctions.size(), 1u);
    for (const Road& road : network.roads) sweeps += road.sweeps.size();
    const std::string text = written(network);
    Diagnostics diagnostics;
    const Network back = parsed(text, &diagnostics);
    expect_same(network, back);
    EXPECT_EQ(written(back), text);
    // The star's links are odd on purpose: a road that is an arm of one junction lies in another.
    for (const Diagnostic& d : diagnostics) {
      EXPECT_TRUE(d.message.find("linked to") != d.message.npos || d.message.find("radius of") != d.message.npos)
          << d.text();
    }
  }
  EXPECT_GT(sweeps, 100u);
}

TEST(OpenDriveNetwork, AnAreaThatNoArmsGiveCannotBeWritten) {
  Network network = random_star(1);
  network.junctions[0].corners[0][0].elevation_m.c0 += 1e-9;
  const Result<std::string> text = opendrive_text(network);
  ASSERT_FALSE(text.ok());
  EXPECT_NE(text.error().text().find("junction J"), std::string::npos) << text.error().text();
  network = random_star(1);
  network.junctions.push_back(network.junctions[0]);
  EXPECT_FALSE(opendrive_text(network).ok());
  network = random_star(2);
  network.roads[0].sweeps = {{.s_end_m = 10, .t_m = NAN, .shape = Pipe{}}};
  EXPECT_FALSE(opendrive_text(network).ok());
}

TEST(OpenDriveNetwork, AnEditedFileHasItsAreaBetweenTheRoadsEnds) {
  const Network network = random_star(3);
  std::string text = written(network);
  // The first arm's stated width.
  const std::size_t at = text.find("code=\"roadgen:arm\" value=\"");
  ASSERT_NE(at, text.npos);
  std::size_t field = text.find('"', at + 20) + 1;
  for (int i = 0; i < 4; ++i) field = text.find(' ', field) + 1;
  text.replace(field, text.find(' ', field) - field, "2");
  Diagnostics diagnostics;
  const Network back = parsed(text, &diagnostics);
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(),
                          [](const Diagnostic& d) { return d.message.find("roadgen:arm") != d.message.npos; }));
  expect_same(network, back);
}

TEST(OpenDriveNetwork, BoundsHoldEverythingThatIsDrawn) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const Network network = random_star(seed);
    const Bounds all = bounds(network);
    for (const Road& road : network.roads) {
      for (std::size_t i = 0; i < road.sweeps.size(); ++i) {
        const Sweep& sweep = road.sweeps[i];
        if (sweep.kind() != SweepKind::kPipe) continue;
        const Pipe& pipe = std::get<Pipe>(sweep.shape);
        for (double s = sweep.s_start_m; s <= sweep.s_end_m; s += 1) {
          const RoadPose pose = pose_at(road, s, 0);
          const glm::dvec2 left(-std::sin(pose.heading_rad), std::cos(pose.heading_rad));
          for (const double n : {-pipe.radius_m, pipe.radius_m}) {
            const double t = sweep.t_m + sweep.t_slope * (s - sweep.s_start_m) + n;
            const glm::dvec2 p = glm::dvec2(pose.position_m) + t * left;
            EXPECT_TRUE(p.x >= all.low_m.x && p.x <= all.high_m.x && p.y >= all.low_m.y && p.y <= all.high_m.y);
          }
        }
      }
    }
  }
  Road road;
  road.id = "1";
  road.segments = {make_segment({0, 0}, {100, 0}, 0, 0, 4)};
  two_lane_sections(road);
  road.sweeps = {{.s_start_m = 10, .s_end_m = 50, .shape = Tunnel{}}};
  Network network;
  network.roads = {road};
  const Bounds b = bounds(network);
  // The head walls stand above arch, lining and margin, and beside half width, lining and margin.
  EXPECT_NEAR(b.high_m.z, 2.6 + 4 + 0.45 + 1.2, 1e-9);
  EXPECT_NEAR(b.high_m.y, 5 + 0.45 + 1.2, 1e-9);
  EXPECT_NEAR(b.low_m.x, 0, 1e-9);
}

// Another program's file: straight roads of two lanes of 3 m, each `id x y hdg length`.
struct Foreign {
  std::string roads, junctions;

  void road(const std::string& id, glm::dvec2 p, double heading, double length, const std::string& inside = "",
            const std::string& junction = "-1", const std::string& shape = "<line/>", double z = 0) {
    char text[400];
    std::snprintf(text, sizeof text,
                  "\" length=\"%.17g\"><planView><geometry s=\"0\" x=\"%.17g\" y=\"%.17g\" hdg=\"%.17g\" "
                  "length=\"%.17g\">",
                  length, p.x, p.y, heading, length);
    const auto lane = [](int lane_id) {
      return "<lane id=\"" + std::to_string(lane_id) +
             "\" type=\"driving\"><width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane>";
    };
    roads += "<road id=\"" + id + "\" junction=\"" + junction + text + shape +
             "</geometry></planView><elevationProfile><elevation s=\"0\" a=\"" + std::to_string(z) +
             "\" b=\"0\" c=\"0\" d=\"0\"/></elevationProfile><lanes><laneSection s=\"0\"><left>" + lane(1) +
             "</left><center><lane id=\"0\" type=\"none\"/></center><right>" + lane(-1) +
             "</right></laneSection></lanes>" + inside + "</road>\n";
  }
  std::string text() const {
    return "<OpenDRIVE><header revMajor=\"1\" revMinor=\"6\"/>\n" + roads + junctions + "</OpenDRIVE>";
  }
};

std::string link(const char* which, const std::string& id, const char* contact) {
  const bool road = *contact != '\0';
  return std::string("<") + which + " elementType=\"" + (road ? "road" : "junction") + "\" elementId=\"" + id + "\"" +
         (road ? std::string(" contactPoint=\"") + contact + "\"" : "") + "/>";
}
std::string links(const std::string& inside) { return "<link>" + inside + "</link>"; }

// Four roads that end so far from the middle of a crossing, and connecting roads straight on and around the corners.
Foreign foreign_crossing(double raised_m = 0, bool turns = true, double reach_m = 20) {
  Foreign file;
  file.junctions = "<junction id=\"5\" name=\"x\">";
  const auto connect = [&](int from, int to, double x, double y, double heading, double length,
                           const std::string& shape, double z) {
    const std::string id = "c" + std::to_string(from) + std::to_string(to);
    file.road(id, {x, y}, heading, length,
              links(link("predecessor", std::to_string(from), "end") + link("successor", std::to_string(to), "end")),
              "5", shape, z);
    file.junctions += "<connection id=\"0\" incomingRoad=\"" + std::to_string(from) + "\" connectingRoad=\"" + id +
                      "\" contactPoint=\"start\"><laneLink from=\"-1\" to=\"-1\"/></connection>";
  };
  for (int i = 0; i < 4; ++i) {
    const double angle = i * M_PI / 2, heading = angle + M_PI;
    const glm::dvec2 out(std::cos(angle), std::sin(angle));
    file.road(std::to_string(i), (reach_m + 50) * out, heading, 50, links(link("successor", "5", "")));
    const glm::dvec2 cut = reach_m * out;
    if (i < 2) connect(i, i + 2, cut.x, cut.y, heading, 2 * reach_m, "<line/>", i == 1 ? raised_m : 0);
    char arc[60];
    std::snprintf(arc, sizeof arc, "<arc curvature=\"%.17g\"/>", -1 / reach_m);
    if (turns) connect(i, (i + 1) % 4, cut.x, cut.y, heading, 0.5 * M_PI * reach_m, arc, 0);
  }
  file.junctions += "</junction>\n";
  return file;
}

TEST(OpenDriveJunctions, AForeignCrossingBecomesOneArea) {
  Diagnostics diagnostics;
  const Network network = parsed(foreign_crossing().text(), &diagnostics);
  for (const Diagnostic& d : diagnostics) ADD_FAILURE() << d.text();
  ASSERT_EQ(network.junctions.size(), 1u);
  const Junction& junction = network.junctions[0];
  EXPECT_EQ(junction.id, "5");
  EXPECT_EQ(junction.arms.size(), 4u);
  // Its corners are the outer edges of the connecting roads, as far as biarcs are arcs.
  for (const auto& corner : junction.corners) {
    for (const Segment& s : corner) EXPECT_GT(glm::length(s.start_m), 3 * std::sqrt(2.0));
  }
  const std::vector<bool> inside = roads_in_areas(network);
  ASSERT_EQ(network.roads.size(), 10u);  // no strips beside the carriageway, no roads around corners
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road& road = network.roads[i];
    EXPECT_EQ(inside[i], road.id[0] == 'c') << road.id;
    EXPECT_EQ(road.joined_start, road.id[0] == 'c') << road.id;
    EXPECT_TRUE(road.joined_end) << road.id;
  }
  ASSERT_EQ(network.junction_links.size(), 1u);
  ASSERT_EQ(network.junction_links[0].connections.size(), 6u);
  EXPECT_EQ(network.junction_links[0].connections[0], (Connection{"0", "c02", false, {{-1, -1}}}));
  // And from our own file it comes back without being laid anew.
  Network back = parsed(written(network));
  expect_same(network, back);
}

TEST(OpenDriveJunctions, RoadsInAnAreaAreNeitherDrawnNorDrivenOn) {
  const Network network = parsed(foreign_crossing().text());
  std::size_t outside = 0, drawn = 0;
  for (const Road& road : network.roads) outside += road.junction.empty() ? road.segments.size() : 0;
  const RoadScene scene = road_scene(network);
  for (const auto& instances : scene.instances) drawn += instances.size();
  EXPECT_EQ(drawn, outside);
  const RoadIndex index(network);
  EXPECT_EQ(index.within({0, 0}, 1e6).size(), outside);
  const auto middle = index.to_road(glm::dvec3(1, 1, 0.5), 1);
  ASSERT_TRUE(middle);
  EXPECT_EQ(middle->junction, 0);
  EXPECT_NEAR(middle->height_m, 0.5, 1e-9);
  // By name they still are.
  ASSERT_TRUE(middle->has_road());
  EXPECT_EQ(network.roads[middle->at.road].junction, network.junctions[0].id);
  // For routes they are still there.
  ASSERT_TRUE(network.find_road("c02"));
  EXPECT_LT(glm::length(pose_at(*network.find_road("c02"), 20, 0).position_m), 1e-9);
}

TEST(OpenDriveJunctions, RoadsStayWhereAnAreaWouldNotBeTheirs) {
  struct Case {
    std::string text;
    const char* says;
  };
  Foreign lost = foreign_crossing();
  lost.road("9", {70, 5}, 0, 30, links(link("predecessor", "5", "")));  // turned away
  Foreign empty;
  empty.road("1", {0, 0}, 0, 50, links(link("successor", "5", "")));
  empty.junctions = "<junction id=\"5\" name=\"\"/>";
  std::string other = foreign_crossing().text();
  other.replace(other.find("<junction id"), 9, "<junction type=\"virtual\" mainRoad=\"0\"");
  const Case cases[] = {
      {foreign_crossing(4).text(), "different heights"},
      {foreign_crossing(0, false, 50).text(), "leave much of the area free"},
      {lost.text(), "keeps its roads: the area's edges cross"},
      {empty.text(), "no connecting roads"},
      {other, "another type"},
  };
  for (const Case& c : cases) {
    Diagnostics diagnostics;
    const Network network = parsed(c.text, &diagnostics);
    EXPECT_TRUE(network.junctions.empty()) << c.says;
    ASSERT_EQ(diagnostics.size(), 1u) << c.says;
    EXPECT_NE(diagnostics[0].message.find(c.says), std::string::npos) << diagnostics[0].text();
    EXPECT_EQ(diagnostics[0].element, "junction 5");
    // Written and read, it still has none, and nothing is asked twice.
    Diagnostics again;
    expect_same(network, parsed(written(network), &again));
    for (const Diagnostic& d : again) ADD_FAILURE() << d.text();
  }
}

TEST(OpenDriveLinks, LinkedEndsThatMeetAreJoined) {
  Foreign file;
  file.road("a", {0, 0}, 0, 50, links(link("successor", "b", "start")));
  file.road("b", {50, 0}, 0, 50, links(link("predecessor", "a", "end") + link("successor", "c", "end")));
  file.road("c", {150, 0.02}, M_PI, 50, links(link("successor", "b", "end")));  // 2 cm aside
  file.road("d", {0, 9}, 0, 50, links(link("successor", "e", "start")));
  file.road("e", {50, 9}, 0, 50, links(link("predecessor", "d", "end")), "-1", "<line/>", 0.02);  // 2 cm above
  Diagnostics diagnostics;
  const Network network = parsed(file.text(), &diagnostics);
  for (const Diagnostic& d : diagnostics) ADD_FAILURE() << d.text();
  const bool start[] = {false, true, false, false, false}, end[] = {true, false, false, false, false};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(network.roads[i].joined_start, start[i]) << i;
    EXPECT_EQ(network.roads[i].joined_end, end[i]) << i;
  }
  EXPECT_EQ(network.roads[1].successor, (RoadLink{RoadLink::To::kRoad, "c", true}));
  EXPECT_TRUE(check(network).ok());
  expect_same(network, parsed(written(network)));
}

TEST(OpenDriveLinks, WhatDoesNotAgreeIsToldAndWhatIsNotThereDropped) {
  Foreign file;
  file.road("a", {0, 0}, 0, 50, links(link("successor", "b", "start") + link("predecessor", "nowhere", "end")));
  file.road("b", {50, 0}, 0, 50, links(link("predecessor", "c", "end") + link("successor", "99", "")));
  file.road("c", {0, 9}, 0, 50, links("<successor elementType=\"road\" elementId=\"b\"/>"), "77");
  file.junctions =
      "<junction id=\"3\" name=\"\"><connection id=\"0\" incomingRoad=\"a\" connectingRoad=\"nowhere\" "
      "contactPoint=\"start\"/><connection id=\"1\" incomingRoad=\"a\" connectingRoad=\"c\" contactPoint=\"start\"/>"
      "<connection id=\"1\" incomingRoad=\"a\"/></junction>";
  Diagnostics diagnostics;
  const Network network = parsed(file.text(), &diagnostics);
  const auto told = [&](const char* what) {
    return std::count_if(diagnostics.begin(), diagnostics.end(),
                         [&](const Diagnostic& d) { return d.message.find(what) != d.message.npos; });
  };
  EXPECT_EQ(told("a link to a road that is not there"), 1);
  EXPECT_EQ(told("a link to a junction that is not there"), 1);
  EXPECT_EQ(told("roads of a junction that is not there"), 1);
  EXPECT_EQ(told("a connection of a road that is not there"), 1);
  EXPECT_EQ(told("a connection without"), 1);
  EXPECT_EQ(told("a link without a road and its contact point"), 1);
  EXPECT_EQ(told("road a: its end is linked to the start of road b, which is linked to the end of road c"), 1);
  const std::vector<std::string> problems = check(network).problems;
  ASSERT_EQ(problems.size(), 3u);
  EXPECT_EQ(problems[0], "road a: its end is linked to the start of road b, which is linked to the end of road c");
  EXPECT_EQ(problems[1], "road b: its start is linked to the end of road c, which is linked to nothing");
  EXPECT_EQ(problems[2], "junction 3: connects by way of road c, which does not lie in it");
}

Network with_objects(const std::string& objects, Diagnostics* diagnostics) {
  Foreign file;
  file.road("1", {0, 0}, 0, 100, "<objects>" + objects + "</objects>");
  return parsed(file.text(), diagnostics);
}

TEST(OpenDriveStructures, ForeignTunnelsAndGuardRailsAreRead) {
  Diagnostics diagnostics;
  const Network network = with_objects(
      R"(<object id="1" type="barrier" name="guard rail" s="5" t="-4" zOffset="0" hdg="0" length="2">
<repeat s="10" length="30" distance="0" tStart="-4" tEnd="-5" heightStart="0.9" zOffsetStart="0"/>
<repeat s="50" length="40" distance="4"/></object>
<object id="2" type="barrier" subtype="guardRail" s="20" t="4" hdg="3.14159" length="10" width="0.1" height="0.1"/>
<object id="3" type="barrier" name="Wall" s="20" t="8"/><object id="4" type="barrier" name="Wall" s="30" t="8"/>
<tunnel id="5" s="60" length="30" name="t" type="standard" lighting="0.5" daylight="0.5"/>
<bridge id="6" s="0" length="5"/>)",
      &diagnostics);
  const std::vector<Sweep>& sweeps = network.roads[0].sweeps;
  ASSERT_EQ(sweeps.size(), 4u);
  EXPECT_EQ(sweeps[0], (Sweep{10, 40, -4, -1.0 / 30, GuardRail{.top_m = 0.9}, {}}));
  EXPECT_EQ(sweeps[1], (Sweep{50, 90, -4, 0, GuardRail{}, {}}));
  EXPECT_EQ(sweeps[2], (Sweep{15, 25, 4, 0, GuardRail{}, {}}));
  EXPECT_EQ(sweeps[3], (Sweep{60, 90, 0, 0, Tunnel{}, {}}));
  for (const Diagnostic& d : diagnostics) ADD_FAILURE() << d.text();
  EXPECT_EQ(network.roads[0].records->objects.size(), 2u);  // the walls
  EXPECT_EQ(network.roads[0].bridges.size(), 1u);
  EXPECT_TRUE(check(network).ok());
}

TEST(OpenDriveStructures, BadOnesAreCutOffOrDroppedWithANote) {
  struct Case {
    const char* object;
    std::size_t kept;
    const char* says;
  };
  const Case cases[] = {
      {R"(<tunnel id="1" s="10" length="-5"/>)", 0, "not positive"},
      {R"(<tunnel id="1" s="10" length="0"/>)", 0, "not positive"},
      {R"(<tunnel id="1" s="500" length="50"/>)", 0, "cut off"},
      {R"(<tunnel id="1" s="-50" length="1e9"/>)", 1, "cut off"},
      {R"(<object type="barrier" name="guardRail" s="0" t="0"><repeat s="0" length="1e9" distance="1e-9"/></object>)",
       1, "cut off"},
      {R"(<object type="barrier" name="guardRail" s="0" t="1e300"><repeat s="0" length="10" distance="1"/></object>)",
       0, "impossible"},
      {R"(<tunnel s="10" length="50"><userData code="roadgen:sweep" value="0 10 60 0 0 -1 1 1 1 1 1 1 1"/></tunnel>)",
       0, "impossible"},
      {R"(<tunnel s="10" length="50"><userData code="roadgen:sweep" value="0 10 60 0 0 5 1"/></tunnel>)", 1,
       "does not hold"},
      {R"(<tunnel s="10" length="50"><userData code="roadgen:sweep" value="0 nan 60"/></tunnel>)", 1, "does not hold"},
      {R"(<tunnel s="10" length="50"><userData code="roadgen:sweep" value="0 0 9 0 0 6 1 1 1 1 1 1 1"/></tunnel>)", 1,
       "does not agree"},
  };
  for (const Case& c : cases) {
    Diagnostics diagnostics;
    const Network network = with_objects(c.object, &diagnostics);
    EXPECT_EQ(network.roads[0].sweeps.size(), c.kept) << c.object;
    ASSERT_EQ(diagnostics.size(), 1u) << c.object;
    EXPECT_NE(diagnostics[0].message.find(c.says), std::string::npos) << diagnostics[0].text();
    for (const Sweep& sweep : network.roads[0].sweeps) {
      EXPECT_TRUE(problems(network.roads[0], sweep).empty()) << c.object;
      EXPECT_LT(sweep_parts(network.roads[0], 0).size(), 100u);
    }
  }
  Foreign file;
  file.road("1", {0, 0}, 0, 100, R"(<objects><tunnel id="1" s="nan" length="5"/></objects>)");
  const Result<Network> network = parse_opendrive(file.text(), "n.xodr");
  ASSERT_FALSE(network.ok());
  EXPECT_NE(network.error().text().find("finite"), std::string::npos) << network.error().text();
}

}  // namespace
}  // namespace roadgen
