// OpenStreetMap: small cities of a few ways, and real extracts where they are at hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <set>

#include <glm/geometric.hpp>

#include "roadgen/export/opendrive.h"
#include "roadgen/import/import.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/import/osm_file.h"
#include "roadgen/import/osm_heights.h"
#include "roadgen/import/osm_road.h"
#include "roadgen/road/crossing.h"
#include "roadgen/road/movement.h"
#include "tests/osm_text.h"
#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

using test::OsmText;
using test::TemporaryFolder;

ImportResult imported(const OsmText& osm, bool left_hand = false) {
  const TemporaryFolder folder;
  ImportOptions options;
  options.origin = OsmText::origin();
  options.left_hand_traffic = left_hand;
  Result<ImportResult> result = import_files({folder.put("city.osm", osm.text())}, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
  if (!result) return {};
  for (const std::string& problem : check(result->network).problems) ADD_FAILURE() << problem;
  return *result;
}

bool mentions(const Diagnostics& diagnostics, const std::string& element, const std::string& what) {
  return std::any_of(diagnostics.begin(), diagnostics.end(), [&](const Diagnostic& d) {
    return d.element == element && d.message.find(what) != std::string::npos;
  });
}

const Road& road_of(const ImportResult& result, const std::string& id) {
  const Road* road = result.network.find_road(id);
  EXPECT_TRUE(road) << "no road " << id;
  static const Road none;
  return road ? *road : none;
}

// Offsets of the carriageway's edges at the road's start.
std::pair<double, double> edges(const Road& road) {
  return {road.segments.front().right_m.c0, road.segments.front().left_m.c0};
}

glm::dvec3 end_point(const Road& road, bool at_end) {
  return pose_at(road, at_end ? road.length_m() : 0, 0).position_m;
}

double steepest(const Road& road) {
  double most = 0;
  for (const Segment& segment : road.segments) {
    for (int i = 0; i <= 8; ++i) most = std::max(most, std::abs(segment.elevation_m.slope(segment.arc_m * i / 8)));
  }
  return most;
}

double least_distance(const Network& network, glm::dvec2 p) {
  double least = 1e9;
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      const double reach = 1.5 * segment.chord_length_m();
      if (glm::length(p - segment.start_m) > reach + least) continue;
      least = std::min(least, nearest(segment, p).distance_m);
    }
  }
  return least;
}

OsmText cross_streets(const test::Tags& tags) {
  OsmText osm;
  osm.node(1, -100, 0).node(2, 0, 0).node(3, 100, 0).node(4, 0, -100).node(5, 0, 100);
  return osm.way(10, {1, 2, 3}, tags).way(11, {4, 2, 5}, tags);
}

TEST(OsmImport, SharedNodeBecomesAnAreaWithCornersByClass) {
  for (const auto& [highway, half, radius] : {std::tuple("residential", 2.75, 5.0), {"primary", 3.75, 10.0}}) {
    const ImportResult result = imported(cross_streets({{"highway", highway}}));
    ASSERT_EQ(result.network.junctions.size(), 1u);
    const Junction& junction = result.network.junctions[0];
    EXPECT_EQ(junction.id, "2");
    EXPECT_EQ(junction.arms.size(), 4u);
    ASSERT_EQ(result.network.roads.size(), 4u);
    for (const Road& road : result.network.roads) {
      EXPECT_NEAR(road.length_m(), 100 - half - radius, 0.02);
      EXPECT_EQ(road.road_class, highway);
      EXPECT_NE(road.joined_start, road.joined_end);
    }
    // The arc of a corner lies within the square that its tangents leave.
    const JunctionSurface surface = junction_surface(junction);
    const double in = half + radius * (1 - std::numbers::sqrt2 / 2);
    EXPECT_NEAR(signed_distance_m(surface, {in, in}), 0, 0.02);
    EXPECT_TRUE(result.diagnostics.empty());
  }
}

TEST(OsmImport, LesserRoadAtAGreaterOneHasThreeArms) {
  OsmText osm;
  osm.node(1, -100, 0).node(2, 0, 0).node(3, 100, 0).node(4, 30, -100);
  osm.way(10, {1, 2, 3}, {{"highway", "primary"}, {"name", "High Street"}}).way(11, {4, 2}, {{"highway", "service"}});
  const ImportResult result = imported(osm);
  ASSERT_EQ(result.network.junctions.size(), 1u);
  EXPECT_EQ(result.network.junctions[0].arms.size(), 3u);
  EXPECT_EQ(road_of(result, "10").name, "High Street");
  EXPECT_EQ(road_of(result, "10.2").name, "High Street");
  EXPECT_EQ(road_of(result, "11").road_class, "service");
}

TEST(OsmImport, RoadGoesOnThroughWaysOfEqualTagsAndPassesTheirNodes) {
  OsmText osm;
  for (int i = 0; i < 12; ++i) osm.node(1 + i, 30 * i, 5 * std::sin(0.5 * i));
  osm.way(10, {1, 2, 3, 4, 5}, {{"highway", "tertiary"}})
      .way(11, {12, 11, 10, 9, 8, 7, 6, 5}, {{"highway", "tertiary"}});
  const ImportResult result = imported(osm);
  ASSERT_EQ(result.network.roads.size(), 1u);
  EXPECT_TRUE(result.network.junctions.empty());
  for (int i = 0; i < 12; ++i) {
    EXPECT_LT(least_distance(result.network, {30 * i, 5 * std::sin(0.5 * i)}), kNodeError_m);
  }
  ASSERT_EQ(result.certificates.size(), 1u);
  EXPECT_LT(result.certificates[0].max_error_m, kNodeError_m);
  EXPECT_GT(result.certificates[0].samples, 10u);
}

TEST(OsmImport, TagsOverrideTheDefaultsOfTheClass) {
  const auto one = [](test::Tags tags, bool left_hand = false) {
    OsmText osm;
    osm.node(1, 0, 0).node(2, 200, 0);
    return imported(osm.way(10, {1, 2}, tags), left_hand);
  };
  const auto section = [](const ImportResult& r) { return r.network.roads.at(0).sections.at(0); };
  EXPECT_EQ(section(one({{"highway", "residential"}})).left.size(), 1u);
  EXPECT_EQ(section(one({{"highway", "residential"}, {"lanes", "4"}})).left.size(), 2u);

  const LaneSection uneven = section(one({{"highway", "primary"}, {"lanes", "3"}, {"lanes:backward", "2"}}));
  EXPECT_EQ(uneven.right.front().type, LaneType::kDriving);
  EXPECT_EQ(uneven.left[1].type, LaneType::kDriving);
  EXPECT_EQ(uneven.right[1].type, LaneType::kShoulder);
  EXPECT_EQ(uneven.center_mark.kind, MarkKind::kSolidSolid);

  // One direction: the way is the middle of the carriageway.
  const ImportResult oneway = one({{"highway", "residential"}, {"oneway", "yes"}, {"width", "5"}});
  EXPECT_EQ(edges(oneway.network.roads[0]), std::pair(-2.5, 2.5));
  EXPECT_EQ(section(oneway).right.size(), 1u);
  EXPECT_TRUE(section(oneway).left.empty());
  EXPECT_NEAR(oneway.network.roads[0].segments.front().start_m.x, 0, 0.01);
  // Against the way: the road runs as its traffic does.
  EXPECT_NEAR(one({{"highway", "residential"}, {"oneway", "-1"}}).network.roads[0].segments.front().start_m.x, 200,
              0.01);
  EXPECT_TRUE(section(one({{"highway", "motorway"}})).left.front().type == LaneType::kShoulder);

  EXPECT_EQ(section(one({{"highway", "service"}})).right.front().type, LaneType::kBidirectional);
  EXPECT_EQ(section(one({{"highway", "tertiary"}, {"surface", "sett"}})).right.front().material, Material::kPaving);
  EXPECT_EQ(section(one({{"highway", "tertiary"}, {"sidewalk", "left"}})).left.back().type, LaneType::kSidewalk);
  EXPECT_EQ(section(one({{"highway", "tertiary"}, {"sidewalk", "left"}})).right.back().type, LaneType::kShoulder);
  EXPECT_EQ(section(one({{"highway", "tertiary"}, {"parking:right", "lane"}})).right.back().type, LaneType::kParking);

  // Where traffic keeps left a road of one direction has its lanes on the left.
  const LaneSection left = section(one({{"highway", "residential"}, {"oneway", "yes"}}, true));
  EXPECT_EQ(left.left.size(), 1u);
  EXPECT_TRUE(left.right.empty());

  const ImportResult nonsense = one({{"highway", "residential"}, {"lanes", "many"}, {"width", "-3"}});
  EXPECT_TRUE(mentions(nonsense.diagnostics, "way 10", "lanes=many"));
  EXPECT_TRUE(mentions(nonsense.diagnostics, "way 10", "width=-3"));
  EXPECT_EQ(edges(nonsense.network.roads[0]), std::pair(-2.75, 2.75));
}

TEST(OsmImport, LanesThatEndTaperAtAJointWithoutAnArea) {
  OsmText osm;
  osm.node(1, 0, 0).node(2, 150, 0).node(3, 300, 40);
  osm.way(10, {1, 2}, {{"highway", "primary"}, {"lanes", "4"}}).way(11, {2, 3}, {{"highway", "primary"}});
  const ImportResult result = imported(osm);
  EXPECT_TRUE(result.network.junctions.empty());
  const Road &wide = road_of(result, "10"), &narrow = road_of(result, "11");
  EXPECT_TRUE(wide.joined_end && narrow.joined_start);
  const JointGap gap = joint_gap(wide.segments.back(), narrow.segments.front());
  EXPECT_LT(gap.position_m, 1e-9);
  EXPECT_LT(gap.heading_rad, 1e-9);
  EXPECT_LT(gap.edge_m, 1e-9);
  EXPECT_LT(gap.elevation_m, 1e-9);
  EXPECT_NEAR(edges(wide).second, 2 * 3.5 + 0.25, 1e-6);
}

TEST(OsmImport, RoundaboutIsARingOfOneDirectionAroundAnIsland) {
  OsmText osm;
  std::vector<long> ring;
  for (int i = 0; i < 18; ++i) {
    const double a = i * std::numbers::pi / 9;
    osm.node(1 + i, 25 * std::cos(a), 25 * std::sin(a));
    ring.push_back(1 + i);
  }
  ring.push_back(1);
  osm.node(101, 120, 0).node(102, -60, 104).node(103, -60, -104);
  osm.way(10, ring, {{"highway", "secondary"}, {"junction", "roundabout"}});
  osm.way(11, {101, 1}, {{"highway", "secondary"}});
  osm.way(12, {102, 7}, {{"highway", "secondary"}}).way(13, {103, 13}, {{"highway", "secondary"}});
  const ImportResult result = imported(osm);
  EXPECT_EQ(result.network.roads.size(), 6u);
  ASSERT_EQ(result.network.junctions.size(), 3u);
  for (const Junction& junction : result.network.junctions) {
    EXPECT_EQ(junction.arms.size(), 3u);
    EXPECT_LT(signed_distance_m(junction_surface(junction), {0, 0}), -15);
  }
  for (const char* id : {"10", "10.2", "10.3"}) {
    const Road& arc = road_of(result, id);
    EXPECT_TRUE(arc.sections.front().left.empty() || arc.sections.front().left.front().type != LaneType::kDriving);
    const RoadPose middle = pose_at(arc, 0.5 * arc.length_m(), 0);
    EXPECT_NEAR(middle.curvature_per_m, 1 / 25.0, 0.02) << id;  // counter-clockwise
    EXPECT_NEAR(glm::length(glm::dvec2(middle.position_m)), 25, 0.6);
  }
}

TEST(OsmImport, SlipRoadPartsWithALongGore) {
  OsmText osm;
  osm.node(1, -200, 0).node(2, 0, 0).node(3, 400, 0).node(4, 150, -20).node(5, 250, -60);
  osm.way(10, {1, 2, 3}, {{"highway", "motorway"}}).way(11, {2, 4, 5}, {{"highway", "motorway_link"}});
  const ImportResult result = imported(osm);
  ASSERT_EQ(result.network.junctions.size(), 1u);
  for (const JunctionArm& arm : result.network.junctions[0].arms) {
    if (arm.position_m.x > 0) {
      EXPECT_GT(arm.position_m.x, 25);  // where the carriageways are apart
    }
  }
  EXPECT_TRUE(result.diagnostics.empty());
}

TEST(OsmImport, DualCarriagewayCrossesInOneArea) {
  OsmText osm;
  osm.node(1, -150, 5).node(2, 0, 5).node(3, 150, 5).node(4, -150, -5).node(5, 0, -5).node(6, 150, -5);
  osm.node(7, 0, 120).node(8, 0, -120);
  osm.way(10, {3, 2, 1}, {{"highway", "primary"}, {"oneway", "yes"}});
  osm.way(11, {4, 5, 6}, {{"highway", "primary"}, {"oneway", "yes"}});
  osm.way(12, {7, 2, 5, 8}, {{"highway", "secondary"}});
  const ImportResult result = imported(osm);
  ASSERT_EQ(result.network.junctions.size(), 1u);
  EXPECT_EQ(result.network.junctions[0].id, "2");
  EXPECT_EQ(result.network.junctions[0].arms.size(), 6u);
  const JunctionSurface surface = junction_surface(result.network.junctions[0]);
  for (const glm::dvec2 inside : {glm::dvec2(0, 5), glm::dvec2(0, -5), glm::dvec2(0, 0)}) {
    EXPECT_GT(signed_distance_m(surface, inside), 1);
  }
  EXPECT_EQ(result.network.roads.size(), 6u);
}

// A street under or over another, both straight and 600 m long.
ImportResult two_levels(const test::Tags& other) {
  OsmText osm;
  osm.node(1, -300, 0).node(2, -40, 0).node(3, 40, 0).node(4, 300, 0).node(5, 0, -300).node(6, 0, 300);
  test::Tags middle = {{"highway", "secondary"}};
  middle.insert(middle.end(), other.begin(), other.end());
  osm.way(10, {1, 2}, {{"highway", "secondary"}}).way(11, {2, 3}, middle).way(12, {3, 4}, {{"highway", "secondary"}});
  return imported(osm.way(20, {5, 6}, {{"highway", "residential"}}));
}

TEST(OsmImport, BridgeClearsTheRoadBelowWithRampsOfItsClass) {
  const ImportResult result = two_levels({{"bridge", "yes"}});
  EXPECT_TRUE(result.network.junctions.empty());
  const Road& bridge = road_of(result, "11");
  const RoadPose crown = pose_at(bridge, 0.5 * bridge.length_m(), 0);
  EXPECT_NEAR(crown.position_m.x, 0, 0.1);
  EXPECT_GE(crown.position_m.z, kLevel_m - 0.1);
  EXPECT_LE(crown.position_m.z, kLevel_m + 0.1);
  EXPECT_EQ(pose_at(road_of(result, "20"), 300, 0).position_m.z, 0);
  const double ramp = highway_class(Highway::kSecondary).ramp_grade;
  for (const char* id : {"10", "11", "12"}) {
    const Road& road = road_of(result, id);
    for (double s = 0; s < road.length_m(); s += 1) {
      EXPECT_LE(std::abs(std::tan(pose_at(road, s, 0).pitch_rad)), 1.5 * ramp + 1e-6) << id << " " << s;
    }
  }
  // No more than needed: it is level again after the ramp.
  EXPECT_NEAR(pose_at(road_of(result, "10"), 100, 0).position_m.z, 0, 1e-9);
  ASSERT_EQ(bridge.sweeps.size(), 2u);
  EXPECT_EQ(bridge.sweeps[0].kind(), SweepKind::kGuardRail);
  EXPECT_EQ(bridge.bridges, (std::vector{Bridge{.s_start_m = 0, .s_end_m = bridge.length_m()}}));
  EXPECT_TRUE(road_of(result, "10").bridges.empty());
  // The three roads are one line in height too.
  const JointGap gap = joint_gap(road_of(result, "10").segments.back(), bridge.segments.front());
  EXPECT_LT(gap.elevation_m, 1e-9);
  EXPECT_LT(gap.grade, 1e-6);
}

TEST(OsmImport, TunnelGoesBelowTheRoadAbove) {
  const ImportResult result = two_levels({{"tunnel", "yes"}});
  const Road& tunnel = road_of(result, "11");
  EXPECT_NEAR(pose_at(tunnel, 0.5 * tunnel.length_m(), 0).position_m.z, -kLevel_m, 0.1);
  EXPECT_EQ(pose_at(road_of(result, "20"), 300, 0).position_m.z, 0);
  ASSERT_EQ(tunnel.sweeps.size(), 1u);
  EXPECT_EQ(tunnel.sweeps[0].kind(), SweepKind::kTunnel);
}

TEST(OsmImport, DeadEndBelowSeveralRoadsHasOneRamp) {
  // A tunnel below a street and then below another tunnel, that ends in the open just behind it.
  OsmText osm;
  osm.node(1, -500, 0).node(2, -60, 0).node(3, 60, 0).node(4, 70, 0).node(5, 20, -90).node(6, 20, 90);
  osm.node(7, 53, -400).node(8, 53, -60).node(9, 53, 30).node(10, 53, 400).node(11, -90, -30).node(12, 190, -30);
  osm.way(10, {1, 2}, {{"highway", "tertiary"}});
  osm.way(11, {2, 3}, {{"highway", "tertiary"}, {"tunnel", "yes"}, {"layer", "-2"}});
  osm.way(12, {3, 4}, {{"highway", "tertiary"}}).way(20, {5, 6}, {{"highway", "primary"}});
  osm.way(21, {7, 8}, {{"highway", "primary"}}).way(23, {9, 10}, {{"highway", "primary"}});
  osm.way(22, {8, 9}, {{"highway", "primary"}, {"tunnel", "yes"}, {"layer", "-1"}});
  osm.way(30, {11, 12}, {{"highway", "primary"}});
  const ImportResult result = imported(osm);
  for (const Road& road : result.network.roads) EXPECT_LT(steepest(road), 1.5 * kGreatestRamp) << road.id;
  EXPECT_LT(end_point(road_of(result, "12"), true).z, -2 * kLevel_m + 20 * kGreatestRamp);
}

TEST(OsmImport, CrossingWithoutRoomForARampIsTold) {
  OsmText osm;
  // One goes over to the other within 30 m.
  osm.node(1, -30, 0).node(2, 8, 0).node(3, 0, -8).node(4, 0, 30);
  osm.way(10, {1, 2, 3}, {{"highway", "residential"}, {"bridge", "yes"}}).way(11, {4, 3}, {{"highway", "residential"}});
  const ImportResult result = imported(osm);
  EXPECT_TRUE(mentions(result.diagnostics, "way 10", "above way 11"));

  // What crosses a tunnel so low that its vault does not fit below it takes the vault away there. Streets
  // lead from the tunnel's ends up to it, too short for 5.5 m; its carriageway is 5.5 m wide.
  OsmText town;
  town.node(1, -200, 0).node(2, 200, 0).node(3, 0, -200).node(4, 0, -25).node(5, 0, 25).node(6, 0, 200).node(7, 22, 0);
  const test::Tags street = {{"highway", "residential"}};
  town.way(20, {1, 7, 2}, street).way(21, {4, 7}, street).way(22, {5, 7}, street);
  town.way(12, {3, 4}, street).way(13, {5, 6}, street);
  town.way(11, {4, 5}, {{"highway", "residential"}, {"tunnel", "yes"}});
  const ImportResult made = imported(town);
  ASSERT_TRUE(mentions(made.diagnostics, "way 20", "above way 11"));
  const Road& tunnel = road_of(made, "11");
  for (const Sweep& vault : tunnel.sweeps) {
    for (double s = vault.s_start_m; s <= vault.s_end_m; s += 0.25) {
      EXPECT_GT(std::abs(pose_at(tunnel, s, 0).position_m.y), 2.75) << s;
    }
  }
  EXPECT_TRUE(mentions(made.diagnostics, "road 11", "no room for its vault"));
}

// A bend that is too tight for the vault takes it away there, not from the whole tunnel.
TEST(OsmImport, VaultsHaveGapsInTightBends) {
  OsmText osm;
  osm.node(1, -100, 0).node(2, 0, 0).node(3, 0, 5).node(4, 100, 5);
  const ImportResult result = imported(osm.way(11, {1, 2, 3, 4}, {{"highway", "residential"}, {"tunnel", "yes"}}));
  const Road& road = road_of(result, "11");
  double vaults_m = 0;
  for (const Sweep& vault : road.sweeps) {
    EXPECT_TRUE(problems(road, vault).empty());
    vaults_m += vault.s_end_m - vault.s_start_m;
  }
  EXPECT_GE(road.sweeps.size(), 2u);
  EXPECT_GT(vaults_m, 0.85 * road.length_m());
}

TEST(OsmImport, WaysThatOverlapAreTold) {
  const auto told = [](glm::dvec2 from, glm::dvec2 to, const test::Tags& more) {
    OsmText osm;
    osm.node(1, -200, 0).node(2, 0, 0).node(3, 200, 0).node(4, from.x, from.y).node(5, to.x, to.y);
    test::Tags tags = {{"highway", "residential"}};
    tags.insert(tags.end(), more.begin(), more.end());
    Diagnostics of_both;
    for (const Diagnostic& d :
         imported(osm.way(10, {1, 2, 3}, {{"highway", "residential"}}).way(11, {4, 5}, tags)).diagnostics) {
      if (d.message.find("overlap") != std::string::npos) of_both.push_back(d);
    }
    return of_both;
  };
  const Diagnostics crossing = told({20, -100}, {30, 100}, {});
  ASSERT_EQ(crossing.size(), 1u);
  EXPECT_TRUE(mentions(crossing, "way 10", "crosses way 11"));
  const Diagnostics beside = told({-150, 3}, {150, 3.5}, {});
  ASSERT_EQ(beside.size(), 1u);
  EXPECT_TRUE(mentions(beside, "way 10", "lies 3.0 m beside way 11"));
  EXPECT_EQ(told({50, 1}, {50, 100}, {}).size(), 1u);  // ends on the other
  EXPECT_EQ(told({50, 8}, {50, 100}, {}).size(), 0u);
  EXPECT_EQ(told({-150, 6}, {150, 6}, {}).size(), 0u);
  EXPECT_EQ(told({20, -300}, {30, 300}, {{"bridge", "yes"}}).size(), 0u);
}

TEST(OsmImport, MissingNodesCutAWay) {
  OsmText osm;
  osm.node(1, 0, 0).node(2, 100, 0).node(4, 200, 0).node(5, 300, 0).node_at(6, "95", "11");
  osm.way(10, {1, 2, 3, 4, 5, 6}, {{"highway", "residential"}}).way(11, {7, 8}, {{"highway", "residential"}});
  const ImportResult result = imported(osm);
  ASSERT_EQ(result.network.roads.size(), 2u);
  EXPECT_NEAR(result.network.roads[0].length_m(), 100, 0.02);
  EXPECT_NEAR(result.network.roads[1].length_m(), 100, 0.02);
  EXPECT_EQ(result.network.roads[1].id, "10.2");
  EXPECT_TRUE(mentions(result.diagnostics, "way 10", "2 of its 6 nodes are missing"));
  EXPECT_TRUE(mentions(result.diagnostics, "way 10", "node 3"));
  EXPECT_TRUE(mentions(result.diagnostics, "way 11", "left out"));
}

TEST(OsmImport, WaysThatTouchThemselvesAreRoadsThatMeet) {
  OsmText eight;  // an eight, through node 3 twice
  eight.node(1, -80, 60).node(2, -80, -60).node(3, 0, 0).node(4, 80, 60).node(5, 80, -60);
  const ImportResult result = imported(eight.way(10, {3, 1, 2, 3, 4, 5, 3}, {{"highway", "residential"}}));
  EXPECT_EQ(result.network.roads.size(), 2u);
  ASSERT_EQ(result.network.junctions.size(), 1u);
  EXPECT_EQ(result.network.junctions[0].arms.size(), 4u);

  OsmText lollipop;
  lollipop.node(1, -100, 0).node(2, 0, 0).node(3, 60, 40).node(4, 100, 0).node(5, 60, -40);
  EXPECT_EQ(imported(lollipop.way(10, {1, 2, 3, 4, 5, 2}, {{"highway", "residential"}})).network.roads.size(), 2u);

  OsmText ring;
  for (int i = 0; i < 8; ++i) ring.node(1 + i, 60 * std::cos(i * M_PI / 4), 60 * std::sin(i * M_PI / 4));
  const ImportResult loop = imported(ring.way(10, {1, 2, 3, 4, 5, 6, 7, 8, 1}, {{"highway", "residential"}}));
  ASSERT_EQ(loop.network.roads.size(), 1u);
  EXPECT_TRUE(loop.network.roads[0].closed);

  OsmText back;  // out and back on itself
  back.node(1, 0, 0).node(2, 100, 0).node(3, 50, 0.5);
  EXPECT_TRUE(
      mentions(imported(back.way(10, {1, 2, 3}, {{"highway", "residential"}})).diagnostics, "way 10", "turns back"));
}

TEST(OsmImport, RepeatedElementsHoldOnce) {
  OsmText osm;
  osm.node(1, 0, 0).node(2, 100, 0).node(2, 500, 500).node(3, 100, 0);
  osm.way(10, {1, 1, 2, 3}, {{"highway", "residential"}}).way(10, {2, 1}, {{"highway", "primary"}});
  const ImportResult result = imported(osm);
  ASSERT_EQ(result.network.roads.size(), 1u);
  EXPECT_NEAR(result.network.roads[0].length_m(), 100, 0.02);
  EXPECT_TRUE(mentions(result.diagnostics, "way 10", "occurs twice"));
  EXPECT_TRUE(mentions(result.diagnostics, "node 2", "occurs twice"));
}

TEST(OsmImport, OddFilesAreErrorsOfOneLine) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& name, const std::string& text) {
    const auto result = import_files({folder.put(name, text)}, {});
    EXPECT_FALSE(result.ok());
    return result.ok() ? std::string() : result.error().text();
  };
  EXPECT_NE(error_of("a.osm", "<osm version=\"0.6\"><node id=\"1\" lat=\"1\"").find("cannot be read"),
            std::string::npos);
  EXPECT_NE(error_of("b.osm", OsmText().node(1, 0, 0).text()).find("no way to drive on"), std::string::npos);
  EXPECT_NE(error_of("c.osm.pbf", "not a pbf").find("cannot be read"), std::string::npos);
  EXPECT_NE(error_of("d.osm.gz", "not a gz").find("cannot be read"), std::string::npos);
  const OsmText same = OsmText().node(1, 0, 0).node(2, 0, 0);
  EXPECT_NE(error_of("e.osm", OsmText(same).way(1, {1, 2}, {{"highway", "road"}}).text()).find("no road"),
            std::string::npos);
  EXPECT_EQ(import_files({folder.path("none.osm")}, {}).error().code, ErrorCode::kIo);
  const std::string two = folder.put("f.osm", cross_streets({{"highway", "road"}}).text());
  EXPECT_EQ(import_files({two, two}, {}).error().code, ErrorCode::kUsage);
}

TEST(OsmImport, NodesAllOverTheGlobeGiveFiniteRoads) {
  OsmText osm;
  osm.node_at(1, "90", "180").node_at(2, "-90", "-180").node_at(3, "0", "0").node_at(4, "0.0000001", "0");
  osm.way(10, {1, 2, 3, 4}, {{"highway", "residential"}});
  const TemporaryFolder folder;
  const auto result = import_files({folder.put("a.osm", osm.text())}, {});
  if (!result) return;
  for (const Road& road : result->network.roads) EXPECT_TRUE(is_finite(road));
}

// --- links

const RoadLink& link_of(const Road& road, bool at_end) { return at_end ? road.successor : road.predecessor; }

// Every end of a road is linked, or nothing is near it that it could be linked to; what is linked meets.
void expect_linked(const Network& network) {
  std::map<std::string, const Junction*> areas;
  for (const Junction& junction : network.junctions) areas.emplace(junction.id, &junction);
  const std::vector<bool> corners = corner_roads(network);
  std::vector<std::pair<glm::dvec3, bool>> ends;  // and whether linked
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road& road = network.roads[i];
    if (road.closed || corners[i]) continue;
    for (const bool at_end : {false, true}) {
      const RoadLink& link = link_of(road, at_end);
      ends.emplace_back(end_point(road, at_end), link.to != RoadLink::To::kNothing);
      if (link.to == RoadLink::To::kRoad) {
        const Road* other = network.find_road(link.id);
        ASSERT_TRUE(other) << link.id;
        EXPECT_LT(glm::length(end_point(road, at_end) - end_point(*other, link.at_end)), 1e-9) << road.id;
        const RoadLink& back = link_of(*other, link.at_end);
        EXPECT_EQ(back.lanes.size(), link.lanes.size());
        for (const LaneLink& lane : link.lanes) {
          EXPECT_EQ(std::count(back.lanes.begin(), back.lanes.end(), LaneLink{lane.to, lane.from}), 1) << road.id;
        }
      } else if (link.to == RoadLink::To::kJunction && areas.contains(link.id)) {
        const auto& arms = areas.at(link.id)->arms;
        EXPECT_TRUE(std::any_of(arms.begin(), arms.end(), [&](const JunctionArm& arm) {
          return arm.road == road.id && arm.at_end == at_end;
        })) << road.id;
      }
    }
  }
  for (const auto& [p, linked] : ends) {
    if (linked) continue;
    const auto near = std::count_if(ends.begin(), ends.end(),
                                    [&, q = p](const auto& end) { return glm::length(end.first - q) < 0.1; });
    EXPECT_EQ(near, 1) << p.x << " " << p.y;
  }
  for (const Junction& junction : network.junctions) {
    for (const JunctionArm& arm : junction.arms) {
      const Road* road = network.find_road(arm.road);
      ASSERT_TRUE(road);
      EXPECT_EQ(link_of(*road, arm.at_end).id, junction.id);
    }
  }
}

// As another program reads it: the roads through the areas are roads, and all links agree both ways.
Network as_others_read(const Network& network) {
  std::string text = *opendrive_text(network);
  for (std::size_t at = 0; (at = text.find("roadgen:", at)) != text.npos;) text.replace(at, 7, "unknown");
  Diagnostics diagnostics;
  const Result<Network> read = parse_opendrive(text, "f", &diagnostics);
  EXPECT_TRUE(read.ok()) << (read.ok() ? "" : read.error().text());
  if (!read) return {};
  EXPECT_TRUE(link_problems(*read).empty()) << link_problems(*read).front();
  return *read;
}

TEST(OsmLinks, AllEndsThatMeetAreLinked) {
  std::vector<OsmText> cities;
  cities.push_back(cross_streets({{"highway", "residential"}}));
  OsmText tags;  // that change along the road, on a loop and where it turns back
  tags.node(1, -200, 0)
      .node(2, -100, 0)
      .node(3, 0, 0)
      .node(4, 100, 30)
      .node(5, 40, 20)
      .node(6, 0, 200)
      .node(7, 100, 200);
  tags.node(8, 50, 300).way(10, {1, 2}, {{"highway", "primary"}, {"lanes", "4"}});
  tags.way(11, {3, 2}, {{"highway", "primary"}}).way(12, {3, 4}, {{"highway", "tertiary"}});
  tags.way(13, {4, 5}, {{"highway", "tertiary"}}).way(14, {6, 7}, {{"highway", "residential"}});
  tags.way(15, {7, 8}, {{"highway", "service"}}).way(16, {8, 6}, {{"highway", "residential"}, {"lanes", "4"}});
  cities.push_back(tags);
  OsmText tight;  // too tight for an area
  tight.node(1, 0, 0).node(2, 100, 0).node(3, 100, 1).node(4, 100, 2).node(5, -50, 0);
  tight.way(10, {1, 2}, {{"highway", "primary"}}).way(11, {1, 3}, {{"highway", "primary"}});
  cities.push_back(tight.way(12, {1, 4}, {{"highway", "primary"}}).way(13, {5, 1}, {{"highway", "primary"}}));
  for (const OsmText& city : cities) {
    for (const bool left_hand : {false, true}) {
      const Network network = imported(city, left_hand).network;
      expect_linked(network);
      (void)as_others_read(network);
      const Result<Network> back = parse_opendrive(*opendrive_text(network), "f");
      ASSERT_TRUE(back.ok());
      ASSERT_EQ(back->roads.size(), network.roads.size());
      EXPECT_EQ(back->junction_links, network.junction_links);
      for (std::size_t i = 0; i < network.roads.size(); ++i) {
        EXPECT_EQ(back->roads[i].predecessor, network.roads[i].predecessor);
        EXPECT_EQ(back->roads[i].successor, network.roads[i].successor);
        EXPECT_EQ(back->roads[i].keep_left, left_hand);
      }
    }
  }
}

TEST(OsmLinks, LanesGoOnWhereTheyDo) {
  OsmText osm;
  osm.node(1, 0, 0).node(2, 150, 0).node(3, 300, 0);
  osm.way(10, {1, 2}, {{"highway", "primary"}, {"lanes", "4"}}).way(11, {2, 3}, {{"highway", "primary"}});
  const ImportResult result = imported(osm);
  const RoadLink expected{RoadLink::To::kRoad, "11", false, {{3, 2}, {1, 1}, {-1, -1}, {-3, -2}}};
  EXPECT_EQ(road_of(result, "10").successor, expected);

  // Turned back on the spot: the right lane of the one is the left lane of the other.
  OsmText back;
  back.node(1, 0, 0).node(2, 100, 0).node(3, 50, 1);
  const ImportResult turned = imported(back.way(10, {1, 2, 3}, {{"highway", "residential"}}));
  const RoadLink around{RoadLink::To::kRoad, "10.2", false, {{1, 1}, {-1, -1}}};
  EXPECT_EQ(road_of(turned, "10").successor, around);
}

// The lanes of the ways through a junction's area lie in it, and start and end where lanes of its arms do.
void expect_ways_fit(const Network& network) {
  const RoadsById roads = roads_by_id(network);
  for (const Junction& junction : network.junctions) {
    const JunctionSurface surface = junction_surface(junction);
    for (const Movement& movement : movements(network, roads, junction)) {
      const Road way = connecting_road(network, roads, junction, movement, "way");
      for (const bool at_end : {false, true}) {
        const RoadLink& link = link_of(way, at_end);
        const Road& other = *network.find_road(link.id);
        const RoadPose own = pose_at(way, at_end ? way.length_m() : 0, 0),
                       arm = pose_at(other, link.at_end ? other.length_m() : 0, 0);
        const double turned = own.heading_rad - arm.heading_rad + (link.at_end == at_end ? M_PI : 0);
        EXPECT_NEAR(std::remainder(turned, 2 * M_PI), 0, 1e-6) << junction.id;
        // Every lane of the way has the other one's width and place.
        const auto borders = [&](const Road& road, bool end, int id) {
          const LaneSection& section = end ? road.sections.back() : road.sections.front();
          const double ds = end ? road.length_m() - section.s_m : 0;
          const std::vector<Cubic> all = section.borders_m();
          const std::size_t i = section.right.size() + static_cast<std::size_t>(id > 0 ? id - 1 : id);
          const double s = end ? road.length_m() : 0;
          return std::pair(pose_at(road, s, all[i].value(ds)).position_m,
                           pose_at(road, s, all[i + 1].value(ds)).position_m);
        };
        ASSERT_FALSE(link.lanes.empty());
        for (const LaneLink& lane : link.lanes) {
          auto [right, left] = borders(way, at_end, lane.from);
          const auto [a, b] = borders(other, link.at_end, lane.to);
          if (link.at_end == at_end) std::swap(right, left);
          EXPECT_LT(glm::length(glm::dvec2(right - a)), 1e-6) << junction.id;
          EXPECT_LT(glm::length(glm::dvec2(left - b)), 1e-6) << junction.id;
        }
      }
      for (double s = 0.05; s < way.length_m(); s += 0.5) {
        const std::vector<Cubic> borders = way.sections[0].borders_m();
        const double middle = 0.5 * (borders.front().value(s) + borders.back().value(s));
        EXPECT_GT(signed_distance_m(surface, glm::dvec2(pose_at(way, s, middle).position_m)), 0)
            << junction.id << " " << s;
      }
    }
  }
}

TEST(OsmLinks, LanesLeadThroughAreas) {
  // West to east one way with three lanes; north to south two-way with two lanes south.
  OsmText osm;
  osm.node(1, -100, 0).node(2, 0, 0).node(3, 100, 0).node(4, 0, -100).node(5, 0, 100);
  osm.way(10, {1, 2, 3}, {{"highway", "primary"}, {"oneway", "yes"}, {"lanes", "3"}});
  osm.way(11, {5, 2, 4}, {{"highway", "primary"}, {"lanes", "3"}, {"lanes:forward", "2"}});
  for (const bool left_hand : {false, true}) {
    const Network network = imported(osm, left_hand).network;
    ASSERT_EQ(network.junctions.size(), 1u);
    expect_ways_fit(network);
    // From the west in all directions; from the north and the south on and to the east.
    const Junction& junction = network.junctions[0];
    std::map<std::pair<std::string, std::string>, std::vector<LaneLink>> lanes;
    for (const Movement& m : movements(network, roads_by_id(network), junction)) {
      lanes[{junction.arms[m.from].road, junction.arms[m.to].road}] = m.lanes;
    }
    EXPECT_EQ(lanes.size(), 7u);
    const int side = left_hand ? 1 : -1;  // of lanes that lead along the road
    const auto along = [&](std::initializer_list<std::pair<int, int>> pairs) {
      std::vector<LaneLink> links;
      for (const auto& [a, b] : pairs) links.push_back({side * a, side * b});
      return links;
    };
    const auto of = [&](const char* from, const char* to) { return lanes[{from, to}]; };
    // A turn across the oncoming lanes comes from the inner lane, one to the outside from the outer ones.
    const auto &to_south = of("10", "11.2"), &to_north = of("10", "11");
    EXPECT_EQ(of("10", "10.2"), along({{1, 1}, {2, 2}, {3, 3}}));
    EXPECT_EQ(of("11", "11.2"), along({{1, 1}, {2, 2}}));
    EXPECT_EQ(of("11.2", "11"), along({{-1, -1}}));
    EXPECT_EQ(to_south, left_hand ? along({{1, 1}, {2, 2}}) : along({{2, 1}, {3, 2}}));
    EXPECT_EQ(to_north, left_hand ? along({{3, -1}}) : along({{1, -1}}));
    EXPECT_EQ(of("11.2", "10.2"), left_hand ? along({{-1, 1}}) : along({{-1, 3}}));
    EXPECT_EQ(of("11", "10.2"), left_hand ? along({{1, 2}, {2, 3}}) : along({{1, 1}, {2, 2}}));
    // The file has a road for each, which others read and we leave out.
    const Network others = as_others_read(network);
    EXPECT_EQ(
        std::count_if(others.roads.begin(), others.roads.end(), [](const Road& r) { return !r.junction.empty(); }), 7);
    const auto node = std::find_if(others.junction_links.begin(), others.junction_links.end(),
                                   [](const JunctionLinks& l) { return l.id == "2"; });
    ASSERT_NE(node, others.junction_links.end());
    EXPECT_EQ(node->connections.size(), 7u);
  }
}

// --- real extracts

struct Extract {
  const char* path;
  std::size_t roads, areas;
  double most_without_area;  // part of junctions
};

class OsmExtract : public testing::TestWithParam<Extract> {};

TEST_P(OsmExtract, EveryDrivableWayIsARoadAndNetworksAreSound) {
  const std::string path = std::string(ROADGEN_SOURCE_DIR "/../shared/data/road-geo/") + GetParam().path;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "needs " << path;
  const auto result = import_files({path}, {});
  ASSERT_TRUE(result.ok()) << result.error().text();
  const Network& network = result->network;
  for (const std::string& problem : check(network).problems) ADD_FAILURE() << problem;
  expect_linked(network);
  (void)as_others_read(network);
  // Where a line both rises and sinks the ramps add up.
  for (const Road& road : network.roads) EXPECT_LT(steepest(road), 2 * 1.5 * kGreatestRamp) << road.id;
  for (const Junction& junction : network.junctions) {
    for (const JunctionArm& arm : junction.arms) {
      EXPECT_NEAR(arm.elevation_m, junction.arms[0].elevation_m, 1e-4) << junction.id << " " << arm.road;
    }
  }
  EXPECT_GE(network.roads.size(), GetParam().roads);
  EXPECT_GE(network.junctions.size(), GetParam().areas);
  std::size_t without_area = 0;
  for (const Diagnostic& d : result->diagnostics) {
    EXPECT_NE(d.severity, Severity::kError) << d.text();
    EXPECT_FALSE(d.element.empty()) << d.text();
    without_area += d.message.find("no area fits") != std::string::npos;
  }
  EXPECT_LE(without_area, GetParam().most_without_area * network.junctions.size());

  // Nodes lie on roads within what the certificates say, or in areas.
  double worst = kNodeError_m;
  for (const Certificate& c : result->certificates) worst = std::max(worst, c.max_error_m);
  std::vector<JunctionSurface> areas;
  for (const Junction& junction : network.junctions) areas.push_back(junction_surface(junction));
  ElementFindings findings(path);
  const auto data = read_osm(path, findings);
  ASSERT_TRUE(data.ok());
  const LocalFrame frame(*network.georeference);
  std::size_t far = 0;
  for (const OsmLocation& at : data->locations) {
    const glm::dvec2 p(frame.to_local_m({1e-7 * at.latitude, 1e-7 * at.longitude, 0}));
    const double distance = least_distance(network, p);
    if (distance <= kNodeError_m) continue;
    double inside = -1e9;
    for (const JunctionSurface& area : areas) inside = std::max(inside, signed_distance_m(area, p));
    far += inside < -1;
    EXPECT_TRUE(distance <= worst || inside > -worst)
        << at.latitude << " " << at.longitude << " is " << distance << " m from the next road";
  }
  // Corners so sharp that the radius that a road of this width needs keeps it further away.
  EXPECT_LT(static_cast<double>(far), 0.08 * static_cast<double>(data->locations.size()) + 2);
  RecordProperty("nodes_off_roads", static_cast<int>(far));

  // The result does not depend on the threads' order.
  const auto again = import_files({path}, {});
  EXPECT_TRUE(*opendrive_text(again->network) == *opendrive_text(network));
}

INSTANTIATE_TEST_SUITE_P(Shared, OsmExtract,
                         testing::Values(Extract{"osm-graphhopper/monaco.osm.gz", 600, 280, 0.08},
                                         Extract{"osm2streets/i5_exit_ramp.osm", 60, 18, 0.15},
                                         Extract{"osm2streets/tiny_roundabout.osm", 4, 2, 0}),
                         [](const auto& extract) {
                           std::string name = std::filesystem::path(extract.param.path).stem().stem();
                           return name;
                         });

}  // namespace
}  // namespace roadgen
