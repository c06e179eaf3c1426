// The polygons that cover spheres, cylinders, cones and tori on the screen: planes through the eye that hold the whole shape
// and touch it, in double and in single precision.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/object/rays.h"
#include "tests/object_shapes.h"

namespace roadgen {
namespace {

using std::numbers::pi;
using test::ShapeRandom;
using Shape32 = glsl::Library<glsl::Float32>;

enum Kind { kBall, kFrustum, kTube, kKinds };

template <class Lib>
typename Lib::vec3 outline(Kind kind, typename Lib::vec3 corner, typename Lib::vec3 eye,
                           const typename Lib::ObjectShape& s) {
  if (kind == kBall) return Lib::sphere_outline(corner, eye, s);
  return kind == kFrustum ? Lib::cone_outline(corner, eye, s) : Lib::torus_outline(corner, eye, s);
}

bool too_near(Kind kind, glm::dvec3 eye, const ObjectLib::ObjectShape& s) {
  if (kind == kBall) return ObjectLib::sphere_near(eye, s);
  return kind == kFrustum ? ObjectLib::cone_near(eye, s) : ObjectLib::torus_near(eye, s);
}

ObjectLib::ObjectShape random_numbers(Kind kind, ShapeRandom& random) {
  ObjectLib::ObjectShape s = ObjectLib::object_solid();
  if (kind == kFrustum) {
    // Cylinders, cones, frusta, either way up.
    const double narrow = random.index(4) == 0 ? 0 : random.index(3) == 0 ? 1 : random.scale(0.02, 1);
    s.p0 = 0.5 * (1 + narrow), s.p1 = (random.index(2) ? 0.5 : -0.5) * (1 - narrow);
  }
  if (kind == kTube) s.p0 = random.scale(0.01, 0.98);
  return s;
}

// Near, far, and edge-on or along the axis within a millionth.
glm::dvec3 random_eye(ShapeRandom& random) {
  glm::dvec3 eye = random.direction() * random.scale(0.05, 1e3);
  const int special = random.index(5);
  if (special == 0) eye.z *= 1e-6;
  if (special == 1) eye.x *= 1e-6, eye.y *= 1e-6;
  return eye;
}

// Where the eye may see it end: of a frustum the rims.
std::vector<glm::dvec3> surface(Kind kind, const ObjectLib::ObjectShape& s) {
  constexpr int kAround = 96;
  std::vector<glm::dvec3> points;
  for (int i = 0; i < kAround; ++i) {
    const double turn = i * 2 * pi / kAround, x = std::cos(turn), y = std::sin(turn);
    for (int k = 0; k < (kind == kFrustum ? 2 : kAround); ++k) {
      const double other = k * 2 * pi / kAround;
      if (kind == kFrustum) {
        const double z = k == 0 ? -1 : 1, radius = s.p0 + s.p1 * z;
        points.emplace_back(radius * x, radius * y, z);
      } else if (kind == kBall) {
        points.emplace_back(std::sin(other) * x, std::sin(other) * y, std::cos(other));
      } else {
        const double radius = 1 + s.p0 * std::cos(other);
        points.emplace_back(radius * x, radius * y, s.p0 * std::sin(other));
      }
    }
  }
  return points;
}

// Least distance of points from the planes through the eye and two neighbouring corners each, inward; of one plane each.
std::vector<double> clearances(const std::vector<glm::dvec3>& corners, glm::dvec3 eye,
                               const std::vector<glm::dvec3>& points) {
  glm::dvec3 within(0);
  for (const glm::dvec3& c : corners) within += glm::normalize(c - eye);
  std::vector<double> least;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const glm::dvec3 a = corners[i] - eye, b = corners[(i + 1) % corners.size()] - eye;
    glm::dvec3 normal = glm::cross(a, b);
    // Corners that are one.
    if (glm::length(normal) < 1e-9 * glm::length(a) * glm::length(b)) continue;
    normal = glm::normalize(normal) * (glm::dot(normal, within) < 0 ? -1.0 : 1.0);
    least.push_back(1e30);
    for (const glm::dvec3& p : points) least.back() = std::min(least.back(), glm::dot(normal, p - eye));
  }
  return least;
}

TEST(ObjectOutline, HoldsTheShapeAndTouchesIt) {
  ShapeRandom random(3);
  double outside = 0, outside32 = 0, loose = 0;
  int seen = 0;
  for (int i = 0; i < 3000; ++i) {
    const Kind kind = static_cast<Kind>(i % kKinds);
    const ObjectLib::ObjectShape s = random_numbers(kind, random);
    const glm::dvec3 eye = random_eye(random);
    if (too_near(kind, eye, s)) continue;
    ++seen;
    const int count = kind == kTube ? 16 : 5 + random.index(8);
    Shape32::ObjectShape s32 = Shape32::object_solid();
    s32.p0 = s.p0, s32.p1 = s.p1;
    std::vector<glm::dvec3> corners, corners32;
    for (int k = 0; k < count; ++k) {
      corners.push_back(outline<ObjectLib>(kind, {k, count, 1}, eye, s));
      const Shape32::vec3 c = outline<Shape32>(kind, {k, count, 1}, {eye.x, eye.y, eye.z}, s32);
      corners32.emplace_back(static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z));
    }
    const std::vector<glm::dvec3> points = surface(kind, s);
    for (const double x : clearances(corners, eye, points)) {
      outside = std::max(outside, -x);
      // Points are up to half a step of the surface apart, which is 2 (1 - cos(pi / 96)) of sagitta.
      loose = std::max(loose, x - (kind == kTube ? 0.0025 : 0.0015));
    }
    for (const double x : clearances(corners32, eye, points)) outside32 = std::max(outside32, -x);
  }
  std::printf("%d eyes: outside by %.1e, in single precision by %.1e; off its tangents by %.1e\n", seen, outside,
              outside32, loose);
  EXPECT_GT(seen, 1700);
  // Of shapes of about unit size.
  EXPECT_LT(outside, 1e-6);
  EXPECT_LT(outside32, 1e-6);
  EXPECT_LT(loose, 0.01);
}

TEST(ObjectOutline, NothingOfTheTorusIsSeenThroughTheHoleOfItsRing) {
  ShapeRandom random(4);
  Primitive torus;
  torus.kind = PrimitiveKind::kTorus;
  int holes = 0;
  for (int i = 0; i < 4000; ++i) {
    torus.shape = random_numbers(kTube, random);
    const glm::dvec3 eye = random_eye(random);
    if (too_near(kTube, eye, torus.shape)) continue;
    const auto inner = [&](int k) { return ObjectLib::torus_outline({k % 16, 16, 0}, eye, torus.shape); };
    if (glm::length(inner(0)) == 0) continue;
    ++holes;
    for (int k = 0; k < 16; ++k) {
      // To rounding: where the bound is attained the ray touches the tube.
      const glm::dvec3 at = glm::mix(inner(k), inner(k + 1), random.uniform(0, 1)) * 0.99999;
      EXPECT_TRUE(all_hits(torus, eye, at - eye).empty()) << eye.x << "," << eye.y << "," << eye.z;
    }
  }
  EXPECT_GT(holes, 500);
}

}  // namespace
}  // namespace roadgen
