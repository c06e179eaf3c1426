#include "roadgen/query/road_index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::hairpin_network;
using testing::road_along;
using testing::straight;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// 20 roads of random gentle bends, far apart enough not to overlap.
Network random_network() {
  Network network;
  for (int i = 0; i < 20; ++i) {
    const double phase = 0.7 * i;
    network.roads.push_back(road_along(
        "r" + std::to_string(i), 900, 30, 3.5,
        [=](double s) {
          // A circle of 150 to 340 m radius, each at a place of its own.
          const double radius = 150 + 10 * i, angle = phase + s / radius;
          return testing::Station{
              glm::dvec2(1000.0 * (i % 5), 1000.0 * (i / 5)) + radius * glm::dvec2(std::cos(angle), std::sin(angle)),
              angle + std::numbers::pi / 2};
        },
        [=](double s) { return 0.05 * s + i; }));
  }
  return network;
}

TEST(RoadIndex, ThePictureAgreesWithinItsBounds) {
  const Network network = hairpin_network(0);
  const RoadIndex index(network);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> x(-20, 110), y(-10, 150);
  int on = 0;
  for (int i = 0; i < 3000; ++i) {
    const glm::dvec2 p(x(random), y(random));
    const auto found = index.to_road(p, 0);
    if (!found) continue;
    ++on;
    const Segment& segment = index.segment(found->at);
    const Lib::RoadCoord c = project(segment, p);
    EXPECT_NEAR(found->t_m, c.v * segment.chord_length_m(), 1e-9 + segment.v_bound_m());
    EXPECT_NEAR(found->s_m, segment.s_start_m + arc_at(segment, c.u), 1e-9 + segment.s_bound_m());
  }
  EXPECT_GT(on, 500);
}

TEST(RoadIndex, AgreesWithTheNearestCentreLine) {
  const Network network = random_network();
  const RoadIndex index(network);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> xy(-800, 5000);
  for (int i = 0; i < 800; ++i) {
    const glm::dvec2 p(xy(random), xy(random));
    double least_distance = kInfinity;
    for (const Road& road : network.roads) {
      for (const Segment& segment : road.segments) {
        least_distance = std::min(least_distance, nearest(segment, p).distance_m);
      }
    }
    const auto found = index.to_road(p, kInfinity);
    ASSERT_TRUE(found);
    // Both edges are 3.5 m away everywhere, so nearest to the carriageway is nearest to the line; ends have corners.
    EXPECT_NEAR(found->distance_m, least_distance, found->outside_m > 0 ? 3.5 : 1e-9);
    EXPECT_GE(found->distance_m, least_distance - 1e-6);
    EXPECT_EQ(index.to_road(p, 50).has_value(), found->outside_m <= 50);
  }
}

TEST(RoadIndex, HeightTellsABridgeFromTheRoadBelow) {
  Network network;
  const auto level = [](double z) { return [z](double) { return z; }; };
  network.roads.push_back(road_along(
      "below", 100, 25, 3,
      [](double s) {
        return straight({-50, 0}, 0, s);
      },
      level(0)));
  network.roads.push_back(road_along(
      "above", 100, 25, 3,
      [](double s) {
        return straight({0, -50}, std::numbers::pi / 2, s);
      },
      level(6)));
  const RoadIndex index(network);
  EXPECT_EQ(index.to_road(glm::dvec3(0.5, 1, 0.3), 10)->at.road, 0u);
  EXPECT_EQ(index.to_road(glm::dvec3(0.5, 1, 5.8), 10)->at.road, 1u);
  EXPECT_NEAR(index.to_road(glm::dvec3(0.5, 1, 5.8), 10)->height_m, -0.2, 1e-9);
  // Without a height the smaller |t| wins: t is 1 on the lower road and -0.5 on the upper.
  const auto flat = index.to_road(glm::dvec2(0.5, 1), 10);
  EXPECT_EQ(flat->at.road, 1u);
  EXPECT_NEAR(flat->t_m, -0.5, 1e-9);
}

// A road beside is taken for one that holds the point only where that is far above or below.
TEST(RoadIndex, ARoadThatHoldsThePointIsNotLeftForOneBeside) {
  Network network;
  const auto level = [](double z) { return [z](double) { return z; }; };
  network.roads.push_back(road_along(
      "steep", 100, 25, 3,
      [](double s) {
        return straight({0, 0}, 0, s);
      },
      [](double s) { return 0.4 * s; }));
  network.roads.push_back(road_along(
      "raised", 100, 25, 3,
      [](double s) {
        return straight({0, 6.01}, 0, s);
      },
      [](double s) { return 0.4 * s + 0.15; }));
  network.roads.push_back(road_along(
      "bridge", 100, 25, 3,
      [](double s) {
        return straight({200, 0}, 0, s);
      },
      level(6)));
  network.roads.push_back(road_along(
      "beside", 100, 25, 3,
      [](double s) {
        return straight({200, 6.5}, 0, s);
      },
      level(0)));
  const RoadIndex index(network);
  for (double x = 1; x < 99; x += 0.37) {
    for (const double above : {-0.3, 0.0, 0.5, 0.9}) {
      const auto found = index.to_road(glm::dvec3(x, 2.9999, 0.4 * x + above), 5);
      ASSERT_TRUE(found);
      EXPECT_EQ(found->at.road, 0u);
      EXPECT_NEAR(found->s_m, x, 1e-9);
      EXPECT_NEAR(found->height_m, above, 1e-9);
    }
    // High above as well: the next segment, nearer in height since the road climbs, does not take it.
    EXPECT_NEAR(index.to_road(glm::dvec3(x, -1, 0.4 * x + 50), 5)->s_m, x, 1e-9);
  }
  // Under the bridge, half a metre beside a road at its height.
  EXPECT_EQ(index.to_road(glm::dvec3(250, 3, 0), 5)->at.road, 3u);
  EXPECT_EQ(index.to_road(glm::dvec3(250, 3, 5.5), 5)->at.road, 2u);
}

TEST(RoadIndex, CandidatesAreAllRoadsInReachBestFirst) {
  Network network;
  for (int i = 0; i < 5; ++i) {
    network.roads.push_back(road_along(
        "r" + std::to_string(i), 100, 10, 3,
        [=](double s) {
          return straight({0, 10.0 * i}, 0, s);
        },
        [](double) { return 0.0; }));
  }
  // Passes twice: out and back, 200 m apart in s.
  network.roads.push_back(road_along(
      "hairpin", 2 * 90 + std::numbers::pi * 6, 6, 3.5,
      [](double s) {
        testing::Station at = testing::hairpins(90, 6, s);
        at.position_m.y -= 100;
        return at;
      },
      [](double) { return 0.0; }));
  const RoadIndex index(network);
  std::array<RoadPoint, 8> found;
  // At a joint of the segments every road is named once.
  for (const double x : {50.0, 53.1}) {
    ASSERT_EQ(index.candidates(glm::dvec2(x, 11), 10, found), 3u);
    EXPECT_EQ(found[0].at.road, 1u);
    EXPECT_EQ(found[0].lane, 1);
    EXPECT_EQ(found[1].at.road, 2u);
    EXPECT_NEAR(found[1].outside_m, 6, 1e-9);
    EXPECT_EQ(found[2].at.road, 0u);
    EXPECT_NEAR(found[2].outside_m, 8, 1e-9);
    EXPECT_NEAR(found[2].s_m, x, 1e-9);
  }
  ASSERT_EQ(index.candidates(glm::dvec2(45, -95), 10, found), 2u);
  EXPECT_EQ(found[0].at.road, 5u);
  EXPECT_EQ(found[1].at.road, 5u);
  EXPECT_NEAR(found[0].s_m, 45, 1e-9);
  EXPECT_NEAR(found[1].s_m, network.roads[5].length_m() - 45, 0.01);
  // Less room: the best, and how many there are.
  ASSERT_EQ(index.candidates(glm::dvec2(53.1, 11), 10, std::span(found).first(1)), 3u);
  EXPECT_EQ(found[0].at.road, 1u);
  EXPECT_EQ(index.candidates(glm::dvec2(53.1, 11), 10, {}), 3u);
  // Beyond an open end the end is the place.
  ASSERT_EQ(index.candidates(glm::dvec2(103, 0), 4, found), 1u);
  EXPECT_NEAR(found[0].s_m, 100, 1e-9);
  // Heights sort.
  ASSERT_EQ(index.candidates(glm::dvec3(53.1, 11, 2), 10, found), 3u);
  EXPECT_NEAR(found[0].height_m, 2, 1e-9);
}

TEST(RoadIndex, BeyondAnOpenEndTheEndAnswers) {
  Network network;
  network.roads.push_back(road_along(
      "r", 100, 25, 3,
      [](double s) {
        return straight({0, 0}, 0, s);
      },
      [](double) { return 0.0; }));
  const RoadIndex index(network);
  const auto found = index.to_road(glm::dvec2(103, 4), 10);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->s_m, 100, 1e-9);
  EXPECT_NEAR(found->t_m, 4, 1e-9);
  EXPECT_NEAR(found->distance_m, 5, 1e-9);
  EXPECT_NEAR(found->outside_m, std::hypot(3, 1), 1e-9);
  EXPECT_FALSE(index.to_road(glm::dvec2(103, 4), 3));
  EXPECT_FALSE(index.to_road(glm::dvec2(50, 4), 0));
}

TEST(RoadIndex, WithinHoldsEverySegmentInReach) {
  const Network network = random_network();
  const RoadIndex index(network);
  EXPECT_EQ(index.size(), network.segment_count());
  const glm::dvec2 p(1000, 1000);
  const auto near = index.within(p, 300);
  std::size_t expected = 0;
  for (std::uint32_t road = 0; road < network.roads.size(); ++road) {
    for (std::uint32_t i = 0; i < network.roads[road].segments.size(); ++i) {
      if (nearest(network.roads[road].segments[i], p).distance_m > 300 + 3.5) continue;
      ++expected;
      EXPECT_NE(std::find(near.begin(), near.end(), SegmentRef{road, i}), near.end());
    }
  }
  EXPECT_GT(expected, 0u);
  EXPECT_LT(near.size(), network.segment_count() / 2);
}

TEST(RoadIndex, PointsThatAreNoneHaveNoRoad) {
  const Network network = hairpin_network(0);
  const RoadIndex index(network);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), kInfinity, -kInfinity}) {
    EXPECT_FALSE(index.to_road(glm::dvec2(bad, 0), kInfinity));
    EXPECT_FALSE(index.to_road(glm::dvec3(0, 0, bad), kInfinity));
    EXPECT_EQ(index.candidates(glm::dvec2(0, bad), kInfinity, {}), 0u);
  }
  EXPECT_FALSE(index.to_road(glm::dvec2(1e300, -1e300), 1e6));
  const auto far = index.to_road(glm::dvec2(1e12, 0), kInfinity);
  ASSERT_TRUE(far);
  EXPECT_TRUE(std::isfinite(far->s_m) && std::isfinite(far->t_m));
  // Hints that name nothing.
  for (const SegmentRef at : {SegmentRef{7, 0}, SegmentRef{0, 100000}, SegmentRef{}}) {
    RoadHint hint{at};
    EXPECT_NEAR(index.to_road(glm::dvec2(10, 1), 1, &hint)->t_m, 1, 1e-9);
    EXPECT_EQ(hint.at.road, 0u);
  }
}

// A road around a circle, of segments from 1 cm to 40 m in runs of equal ones: hundreds begin where the road's mean length
// has one begin, and none where it has many.
TEST(RoadIndex, EveryJointOfSegmentsOfManyLengthsIsFound) {
  constexpr double kRadius_m = 1000;
  Network network;
  Road& road = network.roads.emplace_back();
  const auto place = [&](double angle) { return kRadius_m * glm::dvec2(std::cos(angle), std::sin(angle)); };
  double angle = 0;
  for (const auto& [length, count] : {std::pair(0.01, 300), std::pair(40.0, 60), std::pair(0.1, 700),
                                      std::pair(3.0, 40), std::pair(0.01, 5), std::pair(40.0, 80)}) {
    for (int i = 0; i < count; ++i) {
      const double next = angle + length / kRadius_m, quarter = std::numbers::pi / 2;
      road.segments.push_back(make_segment(place(angle), place(next), angle + quarter, next + quarter, 3.5));
      angle = next;
    }
  }
  chain_arc_lengths(road);
  two_lane_sections(road);
  const RoadIndex index(network);
  const auto check = [&](double s) {
    const RoadPose found = index.to_world({0, s, 1.5}), due = pose_at(road, s, 1.5);
    ASSERT_LT(glm::distance(found.position_m, due.position_m), 1e-9) << s;
    ASSERT_LT(std::abs(std::remainder(found.heading_rad - due.heading_rad, 2 * std::numbers::pi)), 1e-12) << s;
    ASSERT_LE(found.heading_rad, std::numbers::pi) << s;
    ASSERT_GT(found.heading_rad, -std::numbers::pi) << s;
    ASSERT_NEAR(found.curvature_per_m, due.curvature_per_m, 1e-9) << s;
  };
  for (const Segment& segment : road.segments) {
    for (const double off_m : {-1e-3, -1e-12, 0.0, 1e-12, 1e-3}) check(segment.s_start_m + off_m);
    check(segment.s_start_m + 0.5 * segment.arc_m);
  }
  check(road.length_m());
  std::array<RoadPlace, 100> places;
  std::array<RoadPose, 100> poses;
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = {0, road.length_m() * static_cast<double>(i) / 99, -1};
  index.to_world(places, poses);
  for (std::size_t i = 0; i < places.size(); ++i) {
    EXPECT_EQ(poses[i].position_m, index.to_world(places[i]).position_m) << i;
  }
}

TEST(RoadIndex, AnEmptyNetworkHasNoRoads) {
  const Network network;
  const RoadIndex index(network);
  EXPECT_FALSE(index.to_road(glm::dvec2(0, 0), kInfinity));
  EXPECT_TRUE(index.within({0, 0}, kInfinity).empty());
}

}  // namespace
}  // namespace roadgen
