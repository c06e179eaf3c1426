#include "roadgen/query/road_index.h"

#include <cmath>
#include <numbers>
#include <random>
#include <thread>

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

TEST(RoadIndex, PoseAndBackGivesTheSamePlace) {
  const Network network = random_network();
  const RoadIndex index(network);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> along(0, 1), across(-3.49, 3.49);
  for (int i = 0; i < 4000; ++i) {
    const std::uint32_t road = static_cast<std::uint32_t>(i % 20);
    const double length = network.roads[road].length_m();
    // A circle closes over itself after its circumference: stay below it.
    const double s = along(random) * std::min(length, 0.9 * 2 * std::numbers::pi * (150 + 10 * road));
    const double t = across(random);
    const auto found = index.to_road(glm::dvec2(pose_at(network.roads[road], s, t).position_m), 0);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->at.road, road);
    EXPECT_NEAR(found->s_m, s, 1e-6);
    EXPECT_NEAR(found->t_m, t, 1e-6);
    EXPECT_EQ(found->outside_m, 0);
  }
}

TEST(RoadIndex, PoseAndBackKeepsTheMappingBoundInTightBends) {
  const Network network = hairpin_network(0.08);
  const RoadIndex index(network);
  const Road& road = network.roads[0];
  for (double s = 0; s < road.length_m(); s += 0.37) {
    for (double t = -3.45; t < 3.5; t += 0.3) {
      const RoadPose pose = pose_at(road, s, t);
      const auto found = index.to_road(pose.position_m, 0);
      ASSERT_TRUE(found);
      const Segment& segment = road.segments[found->at.segment];
      const double length = segment.chord_length_m();
      EXPECT_NEAR(found->t_m, t, 1e-6 + segment.bound.v * length);
      EXPECT_NEAR(found->s_m, s, 1e-6 + 1.5 * segment.bound.u * length);
      EXPECT_LE(std::abs(found->height_m), 1e-6 + 0.15 * segment.bound.u * length);
    }
  }
}

TEST(RoadIndex, OnACarriagewayTheRoadFunctionAnswers) {
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
    EXPECT_EQ(found->t_m, c.v * segment.chord_length_m());
    EXPECT_EQ(found->u, c.u);
  }
  EXPECT_GT(on, 500);
}

TEST(RoadIndex, AgreesWithTryingEverySegment) {
  const Network network = random_network();
  const RoadIndex index(network);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> xy(-800, 5000);
  for (int i = 0; i < 800; ++i) {
    const glm::dvec2 p(xy(random), xy(random));
    double least = kInfinity, least_distance = kInfinity;
    for (const Road& road : network.roads) {
      for (const Segment& segment : road.segments) {
        least = std::min(least, locate(segment, p).outside_m);
        least_distance = std::min(least_distance, nearest(segment, p).distance_m);
      }
    }
    const auto found = index.to_road(p, kInfinity);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->outside_m, least);
    // The nearest carriageway's centre line is the nearest one, give or take the width.
    EXPECT_NEAR(found->distance_m, least_distance, 3.5);
    EXPECT_GE(found->distance_m, least_distance - 1e-6);
    const auto within = index.to_road(p, 50);
    EXPECT_EQ(within.has_value(), found->outside_m <= 50);
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
      if (locate(network.roads[road].segments[i], p).outside_m > 300) continue;
      ++expected;
      EXPECT_NE(std::find(near.begin(), near.end(), SegmentRef{road, i}), near.end());
    }
  }
  EXPECT_GT(expected, 0u);
  EXPECT_LT(near.size(), network.segment_count() / 2);
}

TEST(RoadIndex, AnEmptyNetworkHasNoRoads) {
  const Network network;
  const RoadIndex index(network);
  EXPECT_FALSE(index.to_road(glm::dvec2(0, 0), kInfinity));
  EXPECT_TRUE(index.within({0, 0}, kInfinity).empty());
}

}  // namespace
}  // namespace roadgen
