// The polyhedra that quadrics are drawn by: closed, around all that rays meet of the quadric, and smaller than its box.
#include "roadgen/object/quadric_hull.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/object/rays.h"
#include "tests/object_shapes.h"

namespace roadgen {
namespace {

using test::ShapeRandom;

// Every type, in boxes that cut it off anywhere, and any coefficients at all.
Primitive random_quadric(int i, ShapeRandom& random) {
  for (;;) {
    Quadric q;
    q.coefficients = test::kQuadricFamily[static_cast<std::size_t>(random.index(14))];
    if (i % 3 == 0) {
      q.box_low = {random.uniform(-1, -0.4), random.uniform(-1, -0.4), random.uniform(-1, -0.4)};
      q.box_high = {random.uniform(0.4, 1), random.uniform(0.4, 1), random.uniform(0.4, 1)};
    } else if (i % 3 == 1) {
      for (double& c : q.coefficients) c = random.uniform(-1, 1);
    }
    q.solid = random.index(2) == 0;
    Object object;
    object.shape = q;
    Primitive p = primitive(object);
    if (p.kind != PrimitiveKind::kQuadric) continue;  // an ellipsoid within the box
    p.center_m = glm::dvec3(0);
    p.axes = glm::dmat3(1);
    return p;
  }
}

// How far outside of the hull, at most; of planes of triangles large enough to have one.
double outside(const ConvexHull& hull, glm::dvec3 p) {
  double greatest = -1e9;
  for (const auto& t : hull.triangles) {
    const glm::dvec3 a = hull.corners[t[0]], n = glm::cross(hull.corners[t[1]] - a, hull.corners[t[2]] - a);
    if (glm::length(n) > 1e-4) greatest = std::max(greatest, glm::dot(glm::normalize(n), p - a));
  }
  return greatest;
}

TEST(QuadricHull, HoldsWhatRaysMeet) {
  ShapeRandom random(5);
  long met = 0;
  double worst = -1, corners = 0;
  constexpr int kQuadrics = 2000;
  for (int i = 0; i < kQuadrics; ++i) {
    const Primitive p = random_quadric(i, random);
    const ConvexHull hull = quadric_hull(p.shape);
    corners += static_cast<double>(hull.corners.size()) / kQuadrics;
    for (int k = 0; k < 100; ++k) {
      const glm::dvec3 from(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      for (const ObjectHit& hit : all_hits(p, from, random.direction())) {
        ++met;
        worst = std::max(worst, outside(hull, hit.position_m));
      }
    }
  }
  std::printf("%ld places, outside by %.1e at most; %.1f corners a hull\n", met, worst, corners);
  EXPECT_GT(met, 100000);
  // Planes that are the box's own are where the hits are cut off, to rounding; the others have kHullRoom.
  EXPECT_LT(worst, 1e-12);
}

TEST(QuadricHull, IsClosed) {
  ShapeRandom random(6);
  for (int i = 0; i < 2000; ++i) {
    const ConvexHull hull = quadric_hull(random_quadric(i, random).shape);
    std::map<std::pair<int, int>, int> edges;
    for (const auto& t : hull.triangles) {
      for (int k = 0; k < 3; ++k) ++edges[{t[static_cast<std::size_t>(k)], t[static_cast<std::size_t>((k + 1) % 3)]}];
    }
    EXPECT_GE(hull.triangles.size(), 4u);
    for (const auto& [edge, count] : edges) {
      EXPECT_EQ(count, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1u);
    }
  }
}

// A plane across the box is covered by little more than itself; a ball's part by planes that touch it.
TEST(QuadricHull, IsTight) {
  const auto volume = [](const Quadric& q) {
    Object object;
    object.shape = q;
    const ConvexHull hull = quadric_hull(primitive(object).shape);
    double sum = 0;
    for (const auto& t : hull.triangles) {
      sum += glm::dot(hull.corners[t[0]], glm::cross(hull.corners[t[1]], hull.corners[t[2]])) / 6;
    }
    return sum;
  };
  EXPECT_LT(volume({{0, 0, 0, 0, 0, 0, 0.5, 0.6, 0.3, -0.1}}), 1e-3);
  // Half a ball of radius 1, cut at z = 0: 2.09, of a box of 8 in these units.
  const double half_ball = volume({{1, 1, 1, 0, 0, 0, 0, 0, 0, -1}, {-1.1, -1.1, 0}, {1.1, 1.1, 1.1}, true});
  EXPECT_GT(half_ball, 8 * 2.0944 / (2.2 * 2.2 * 1.1));
  EXPECT_LT(half_ball, 1.35 * 8 * 2.0944 / (2.2 * 2.2 * 1.1));
}

}  // namespace
}  // namespace roadgen
