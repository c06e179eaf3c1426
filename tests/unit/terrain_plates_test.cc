// What is proven of the carriageways' heights: no sample may be outside of it.
#include "terrain/plates.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/road/interval.h"
#include "roadgen/road/junction.h"
#include "tests/junction_scenes.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

TEST(Interval, HoldsEveryResult) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-3, 3), part(0, 1);
  for (int i = 0; i < 20000; ++i) {
    const double a = uniform(random), b = uniform(random), c = uniform(random), d = uniform(random);
    const Interval x(std::min(a, b), std::max(a, b)), y(std::min(c, d), std::max(c, d));
    const double p = std::lerp(x.low, x.high, part(random)), q = std::lerp(y.low, y.high, part(random));
    EXPECT_TRUE((x + y).holds(p + q) && (x - y).holds(p - q) && (x * y).holds(p * q) && (-x).holds(-p));
    EXPECT_TRUE((x / y).holds(p / q)) << p << " / " << q;
    EXPECT_TRUE(square(x).holds(p * p) && abs(x).holds(std::abs(p)) && clamp(x, -1, 1).holds(std::clamp(p, -1.0, 1.0)));
    EXPECT_TRUE(sqrt(abs(x)).holds(std::sqrt(std::abs(p))));
    EXPECT_TRUE(hull(x, y).holds(p) && hull(x, y).holds(q));
  }
}

// A road with hills, superelevation and crossfall, and bends down to a radius of 12 m.
Network mountain_road(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Anchor> anchors;
  glm::dvec2 p(0, 0);
  double heading = 0;
  for (int i = 0; i < 20; ++i) {
    anchors.push_back({.position_m = p, .elevation_m = 300 + 2.5 * i + uniform(random)});
    heading += 0.9 * uniform(random);
    p += (14 + 8 * std::abs(uniform(random))) * glm::dvec2(std::cos(heading), std::sin(heading));
  }
  Network network;
  auto road = road_from_anchors(anchors, {});
  EXPECT_TRUE(road.ok());
  network.roads.push_back(std::move(*road));
  for (Segment& segment : network.roads[0].segments) {
    segment.superelevation_rad = {0.05 * uniform(random), 0.004 * uniform(random), 0, 0};
    segment.crossfall_left = {0.02 + 0.02 * uniform(random), 0.0005 * uniform(random)};
    segment.crossfall_right = {0.02 + 0.02 * uniform(random), 0};
  }
  return network;
}

// Points of the carriageways, with their heights.
std::vector<glm::dvec3> points_of(const Network& network, int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<glm::dvec3> points;
  for (const Road& road : network.roads) {
    for (int i = 0; i < count; ++i) {
      const Segment& segment = road.segments[random() % road.segments.size()];
      const double s = uniform(random) * segment.arc_m;
      const double cosine = std::cos(segment.superelevation_rad.value(s));
      const double n = cosine * std::lerp(segment.right_m.value(s), segment.left_m.value(s), uniform(random));
      const double u = u_at_arc(segment, s), heading = heading_rad(segment, u);
      const glm::dvec2 p = position_m(segment, u) + n * glm::dvec2(-std::sin(heading), std::cos(heading));
      points.emplace_back(p, surface_at(segment, s, n).height);
    }
  }
  for (const Junction& junction : network.junctions) {
    const JunctionSurface surface = junction_surface(junction);
    for (int i = 0; i < count;) {
      const glm::dvec2 p =
          glm::dvec2(surface.center_m) +
          glm::mix(glm::dvec2(surface.low_m), glm::dvec2(surface.high_m), glm::dvec2(uniform(random), uniform(random)));
      if (!is_inside(surface, p)) continue;
      points.emplace_back(p, height_m_at(surface, p));
      ++i;
    }
  }
  return points;
}

// Triangles of ground near the points: what each point's height over them is must lie within the proven bounds.
void expect_bounds_hold(const Network& network, std::uint32_t seed) {
  const Plates plates(network);
  const std::vector<glm::dvec3> points = points_of(network, 4000, seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  double looseness = 0;
  for (int i = 0; i < 1500; ++i) {
    const glm::dvec3 at = points[random() % points.size()];
    const double size = 0.3 + 4 * std::abs(uniform(random));
    std::array<glm::dvec3, 3> t;
    for (glm::dvec3& corner : t) {
      corner = at + glm::dvec3(size * uniform(random), size * uniform(random), 0.2 * uniform(random) - 0.3);
    }
    const ClearanceBounds bounds = plates.over(t);
    // The plane of the triangle and barycentric coordinates.
    const glm::dvec2 a(t[0]), u = glm::dvec2(t[1]) - a, v = glm::dvec2(t[2]) - a;
    const double area = u.x * v.y - u.y * v.x;
    if (std::abs(area) < 1e-3) continue;
    double least = 1e300, most = -1e300;
    for (const glm::dvec3& p : points) {
      const glm::dvec2 d = glm::dvec2(p) - a;
      const double k = (d.x * v.y - d.y * v.x) / area, l = (u.x * d.y - u.y * d.x) / area;
      if (k < 0 || l < 0 || k + l > 1) continue;
      const double over = p.z - (t[0].z + k * (t[1].z - t[0].z) + l * (t[2].z - t[0].z));
      least = std::min(least, over), most = std::max(most, over);
    }
    if (least > most) continue;
    ASSERT_TRUE(bounds.touches());
    ASSERT_LE(bounds.least_m, least) << "seed " << seed << " triangle " << i;
    ASSERT_GE(bounds.most_m, most) << "seed " << seed << " triangle " << i;
    looseness = std::max(looseness, bounds.error_m);
  }
  double worst = 0;
  for (const Plate& plate : plates.all()) worst = std::max(worst, plate.error_m);
  std::printf("seed %u: %zu plates, worst error %.4f m, under the triangles %.4f m\n", seed, plates.all().size(), worst,
              looseness);
}

TEST(Plates, BoundRoads) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) expect_bounds_hold(mountain_road(seed), seed);
}

TEST(Plates, BoundJunctions) {
  std::mt19937 random(11);
  int made = 0;
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    auto junction = make_junction("j", seed == 1   ? test::crossing_arms()
                                       : seed == 2 ? test::skewed_arms()
                                                   : test::random_arms(random, {50, 20, 7}));
    if (!junction.ok()) continue;
    ++made;
    Network network;
    network.junctions.push_back(std::move(*junction));
    expect_bounds_hold(network, seed);
  }
  EXPECT_GE(made, 6);
}

TEST(Plates, AFlatRoadNeedsFew) {
  Network network;
  network.roads.push_back(testing::road_along(
      "1", 1000, 20, 4,
      [](double s) {
        return testing::straight({0, 0}, 0.3, s);
      },
      [](double s) { return 0.04 * s; }));
  const Plates plates(network);
  EXPECT_LE(plates.all().size(), 2 * 1000 / 5u);
  for (const Plate& plate : plates.all()) EXPECT_LT(plate.error_m, 1e-4);
}

}  // namespace
}  // namespace roadgen
