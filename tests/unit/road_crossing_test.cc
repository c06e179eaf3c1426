// Crossings: roads joined by an area, kerbs and sidewalks carried around its corners; queries and ground agree with them.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/query/road_index.h"
#include "roadgen/road/crossing.h"
#include "terrain/terrain.h"

namespace roadgen {
namespace {

constexpr double kKerb_m = 0.12;

LaneSection street(int lanes) {
  LaneSection section;
  for (int i = 0; i < lanes; ++i) section.left.push_back({.width_m = {3.25}, .mark = {}});
  section.left.push_back({.type = LaneType::kSidewalk,
                          .material = Material::kPaving,
                          .width_m = {2},
                          .inner_height_m = kKerb_m,
                          .outer_height_m = kKerb_m,
                          .mark = {}});
  section.right = section.left;
  return section;
}

// Four arms of differing widths and grades about the origin; the third arm has no sidewalk.
Network crossing() {
  Network network;
  std::vector<RoadEnd> ends;
  for (int i = 0; i < 4; ++i) {
    const double angle = i * M_PI / 2 + 0.1 * i;
    const glm::dvec2 out(std::cos(angle), std::sin(angle));
    const int lanes = i % 2 + 1;
    LaneSection section = street(lanes);
    if (i == 2) section.left.pop_back(), section.right.pop_back();
    const double half = section.borders_m().back().c0, grade = 0.02 * (i - 1.5);
    const std::vector<Anchor> anchors = {{20.0 * out, 20 * grade, half}, {60.0 * out, 60 * grade, half}};
    auto road = road_from_anchors(anchors, {});
    EXPECT_TRUE(road.ok());
    road->id = std::to_string(i);
    EXPECT_TRUE(set_sections(*road, {section}).ok());
    for (Segment& s : road->segments) s.crossfall_left = s.crossfall_right = {0.02, 0};
    network.roads.push_back(std::move(*road));
    ends.push_back({std::to_string(i), false});
  }
  const Status status = add_crossing(network, "J", ends, {.corner_radius_m = 6});
  EXPECT_TRUE(status.ok()) << status.error().text();
  return network;
}

TEST(Crossing, IsFreeOfProblemsAndCarriesSidewalksAroundEveryCorner) {
  const Network network = crossing();
  ASSERT_EQ(network.junctions.size(), 1u);
  ASSERT_EQ(network.roads.size(), 8u);
  for (const std::string& problem : check(network).problems) ADD_FAILURE() << problem;
  const Junction& junction = network.junctions[0];
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(network.roads[i].joined_start);
    EXPECT_FALSE(network.roads[i].joined_end);
    const Road& corner = network.roads[4 + i];
    EXPECT_TRUE(corner.joined_start && corner.joined_end);
    // It begins at the right edge of arm i's carriageway and ends at the left one of the next, at their heights.
    const JunctionArm &from = junction.arms[i], &to = junction.arms[(i + 1) % 4];
    const RoadPose start = pose_at(corner, 0, 1e-9), end = pose_at(corner, corner.length_m(), 1e-9);
    EXPECT_LT(glm::length(glm::dvec2(start.position_m) - cut_point_m(from, from.right_m)), 1e-6);
    EXPECT_LT(glm::length(glm::dvec2(end.position_m) - cut_point_m(to, to.left_m)), 1e-6);
    EXPECT_NEAR(surface_at(corner.segments.front(), 0, 0).height, cut_height_m(from, from.right_m), 1e-6);
    EXPECT_NEAR(surface_at(corner.segments.back(), corner.segments.back().arc_m, 0).height, cut_height_m(to, to.left_m),
                1e-6);
    // Across the joint the sidewalk's far edge is at one height and place, where both sides have one.
    if (from.road == "2") continue;
    const Road& arm = *network.find_road(from.road);
    const double edge =
        arm.segments.front().left_m.value(0);  // arms start here: their left is the right of who looks in
    const glm::dvec3 outer = pose_at(arm, 0, edge - 1e-6).position_m;
    const glm::dvec3 rim = pose_at(corner, 0, -2 + 1e-6).position_m;
    EXPECT_LT(glm::length(outer - rim), 2e-3);
  }
}

TEST(Crossing, QueryAndGroundKnowTheArea) {
  const Network network = crossing();
  const RoadIndex index(network);
  const JunctionSurface surface = junction_surface(network.junctions[0]);
  const auto ground = Terrain::build(network, nullptr);
  ASSERT_TRUE(ground.ok()) << ground.error().text();
  int inside = 0;
  for (double x = -18; x <= 18; x += 1.5) {
    for (double y = -18; y <= 18; y += 1.5) {
      if (signed_distance_m(surface, {x, y}) < 0.2) continue;
      ++inside;
      const double z = height_at(surface, {x, y}).height_m;
      const auto point = index.to_road(glm::dvec3(x, y, z + 0.3), 5);
      ASSERT_TRUE(point);
      EXPECT_EQ(point->junction, 0);
      EXPECT_NEAR(point->height_m, 0.3, 1e-9);
      const double clearance = z - ground->height_m({x, y});
      EXPECT_GT(clearance, 0) << x << ", " << y;
      EXPECT_LT(clearance, 0.25) << x << ", " << y;
    }
  }
  EXPECT_GT(inside, 100);
  // On a raised sidewalk of a corner, wheels stand at its height.
  const Road& corner = network.roads[4];
  const RoadPose pose = pose_at(corner, 0.5 * corner.length_m(), -0.5);
  const auto point = index.to_road(pose.position_m, 1);
  ASSERT_TRUE(point);
  EXPECT_EQ(network.roads[point->at.road].id, corner.id);
  EXPECT_EQ(point->lane, -1);
  EXPECT_NEAR(point->height_m, 0, 1e-4);
}

// Sidewalks wider than the corners' radius narrow around them, where both cuts meet, and are whole at the arms with room.
TEST(Crossing, StripsThatACornerHasNoRoomForNarrow) {
  Network network = crossing();
  network.junctions.clear();
  network.roads.resize(4);
  for (Road& road : network.roads) {
    LaneSection section = road.sections[0];
    for (auto* side : {&section.left, &section.right}) {
      if (side->back().type == LaneType::kSidewalk) side->back().width_m = {4};
    }
    ASSERT_TRUE(set_sections(road, {section}).ok());
  }
  ASSERT_TRUE(add_crossing(network, "K", {{"0"}, {"1"}, {"2"}, {"3"}}, {.corner_radius_m = 2.5}).ok());
  for (const std::string& problem : check(network).problems) ADD_FAILURE() << problem;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& arms = network.junctions[0].arms;
    if (arms[i].road == "2" || arms[(i + 1) % 4].road == "2") continue;  // without sidewalks
    const Road& corner = *network.find_road("K.corner." + std::to_string(i));
    double narrowest = 1e300;
    for (const Segment& s : corner.segments) narrowest = std::min(narrowest, -s.right_m.value(0));
    // A cubic that turns by 30 degrees bends by up to 3.5 % more than its circle.
    EXPECT_LT(narrowest, 0.9 * 2.5);
    EXPECT_GT(narrowest, 0.9 * 2.5 / 1.036);
    EXPECT_NEAR(corner.segments.front().right_m.value(0), -4, 1e-9);
    EXPECT_NEAR(corner.segments.back().right_m.value(corner.segments.back().arc_m), -4, 1e-9);
  }
}

// A one-way road whose lanes all lie right of its reference line, a sidewalk first: the arm's origin is in the middle
// of the lanes, and its cut lies on the road's surface.
TEST(Crossing, ACarriagewayBesideTheReferenceLineIsAnArm) {
  const std::vector<Anchor> anchors = {{{0, 0}, 3, 11}, {{60, 5}, 5, 11}};
  const auto road = road_from_anchors(anchors, {});
  ASSERT_TRUE(road.ok());
  for (const bool at_end : {false, true}) {
    Road one_way = *road;
    LaneSection section;
    const Lane sidewalk{
        .type = LaneType::kSidewalk, .width_m = {2}, .inner_height_m = 0.1, .outer_height_m = 0.15, .mark = {}};
    section.right = {sidewalk, {.width_m = {3}, .mark = {}}, {.width_m = {3.5}, .mark = {}}, sidewalk};
    ASSERT_TRUE(set_sections(one_way, {section}).ok());
    for (Segment& s : one_way.segments) {
      s.superelevation_rad = {0.02, 0, 0, 0};
      s.crossfall_left = {0.01, 0}, s.crossfall_right = {0.03, 0};
    }
    const JunctionArm arm = arm_of(one_way, at_end);
    EXPECT_NEAR(arm.left_m, 3.25 * std::cos(0.02), 1e-12);
    EXPECT_NEAR(arm.right_m, -3.25 * std::cos(0.02), 1e-12);
    const double s = at_end ? one_way.length_m() : 0, side = at_end ? 1 : -1;
    for (const double n : {-3.0, 0.0, 3.0}) {
      const RoadPose pose = pose_at(one_way, s, -5.25 + side * n / std::cos(0.02));
      EXPECT_LT(glm::length(glm::dvec2(pose.position_m) - cut_point_m(arm, n)), 1e-9) << n;
      EXPECT_NEAR(pose.position_m.z, cut_height_m(arm, n), 1e-9) << n;
    }
  }
}

// Its sidewalk on the left goes around the corner at its own height, which is told from the other side there.
TEST(Crossing, StripsBetweenReferenceLineAndCarriagewayAreCarriedAround) {
  Network network = crossing();
  network.junctions.clear();
  network.roads.resize(4);
  for (Road& road : network.roads) {
    LaneSection section = road.sections[0];
    const double left = section.borders_m().back().c0;
    Lane inner =
        section.left.back().type == LaneType::kSidewalk ? section.left.back() : Lane{.width_m = {2}, .mark = {}};
    inner.type = LaneType::kSidewalk, inner.inner_height_m = 0.15, inner.outer_height_m = 0.1;
    section.right = {inner};
    for (const Lane& lane : section.left) section.right.push_back(lane);
    section.left.clear();
    section.offset_m = {left};
    ASSERT_TRUE(set_sections(road, {section}).ok());
    road.joined_start = false;
  }
  const Status status = add_crossing(network, "K", {{"0"}, {"1"}, {"2"}, {"3"}});
  ASSERT_TRUE(status.ok()) << status.error().text();
  // Roads start here, so their left is the right of who looks in: corner i begins along the inner sidewalk of arm i.
  for (const JunctionArm& arm : network.junctions[0].arms) {
    const std::size_t i = static_cast<std::size_t>(&arm - network.junctions[0].arms.data());
    const Road* corner = network.find_road("K.corner." + std::to_string(i));
    ASSERT_NE(corner, nullptr);
    const Lane& strip = corner->sections[0].right[0];
    EXPECT_EQ(strip.inner_height_m, 0.1);
    EXPECT_EQ(strip.outer_height_m, 0.15);
  }
}

TEST(Crossing, EndsThatDoNotExistAreNamed) {
  Network network = crossing();
  const std::size_t roads = network.roads.size();
  const Status status = add_crossing(network, "K", {{"0", true}, {"nowhere", false}});
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.error().text().find("nowhere"), std::string::npos);
  EXPECT_EQ(network.roads.size(), roads);
  EXPECT_EQ(network.junctions.size(), 1u);
}

}  // namespace
}  // namespace roadgen
