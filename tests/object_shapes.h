// Random shapes of every kind, for tests and benchmarks.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "roadgen/object/object.h"

namespace roadgen::test {

// The same numbers on every machine.
class ShapeRandom {
 public:
  explicit ShapeRandom(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  // Evenly spread in its logarithm.
  double scale(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int index(int count) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(count)); }
  glm::dvec3 direction() {
    for (;;) {
      const glm::dvec3 p(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
      const double size = glm::length(p);
      if (size > 0.1 && size <= 1) return p / size;
    }
  }
  glm::dmat3 rotation() {
    const glm::dvec3 z = direction(), x = glm::normalize(glm::cross(z, direction()));
    return {x, glm::cross(z, x), z};
  }

 private:
  std::mt19937_64 engine_;
};

// Coefficients of every real type of quadric that has area, around the origin, in [-1, 1]^3.
inline constexpr std::array<std::array<double, 10>, 14> kQuadricFamily = {{
    {1, 1.5, 2, 0, 0, 0, 0, 0, 0, -0.8},                     // ellipsoid
    {1, 1, -1, 0, 0, 0, 0, 0, 0, -0.1},                      // hyperboloid of one sheet
    {1, 1, -1, 0, 0, 0, 0, 0, 0, 0.1},                       // hyperboloid of two sheets
    {1, 0.7, -0.8, 0, 0, 0, 0, 0, 0, 0},                     // cone
    {1, 0.6, 0, 0, 0, 0, 0, 0, -0.9, -0.3},                  // elliptic paraboloid
    {1, -1, 0, 0, 0, 0, 0, 0, -0.8, 0},                      // hyperbolic paraboloid
    {1, 0.8, 0, 0, 0, 0, 0, 0, 0, -0.5},                     // elliptic cylinder
    {1, -0.9, 0, 0, 0, 0, 0, 0, 0, -0.1},                    // hyperbolic cylinder
    {1, -0.5, 0, 0, 0, 0, 0, 0, 0, 0},                       // intersecting planes
    {1, 0, 0, 0, 0, 0, 0, -0.7, 0, -0.2},                    // parabolic cylinder
    {1, 0, 0, 0, 0, 0, 0, 0, 0, -0.3},                       // parallel planes
    {0.16, 0.09, 0, 0.24, 0, 0, 0.08, 0.06, 0, 0.01},        // double plane: (0.4 x + 0.3 y + 0.1)^2
    {0, 0, 0, 0, 0, 0, 0.5, 0.6, 0.3, -0.1},                 // plane
    {0.6, -0.4, 0.9, 0.5, -0.3, 0.7, 0.2, -0.1, 0.3, -0.4},  // a general one
}};

inline constexpr int kShapeKinds = static_cast<int>(std::variant_size_v<Shape>);

// A shape of the given alternative of Shape, of about unit size around the origin, in any orientation.
inline Shape random_shape(int kind, ShapeRandom& r) {
  const glm::dmat3 turn = r.rotation();
  const glm::dvec3 x = turn[0], y = turn[1], z = turn[2];
  const auto part = [&] { return r.scale(0.1, 1); };
  const auto corner = [&] { return turn * glm::dvec3(r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1)); };
  switch (kind) {
    case 0: return Circle{{0, 0, 0}, z * part(), 1};
    case 1: return Ellipse{{0, 0, 0}, x, y * part() + x * r.uniform(-0.5, 0.5)};
    case 2:
      return Conic{{0, 0, 0},
                   x,
                   y,
                   {r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1), r.uniform(-1, 1),
                    r.uniform(-0.5, 0)},
                   {r.uniform(-1, -0.5), r.uniform(-1, -0.5)},
                   {r.uniform(0.5, 1), r.uniform(0.5, 1)}};
    case 3: return Triangle{x, x * -0.5 + y * part(), corner()};
    case 4: return Parallelogram{x * -0.5 - y * 0.4, x, y * part() + x * r.uniform(-0.4, 0.4)};
    case 5: return Sphere{{0, 0, 0}, 1};
    case 6: return Ellipsoid{{0, 0, 0}, x, y * part(), z * part()};
    case 7: {
      Quadric q;
      q.coefficients = kQuadricFamily[static_cast<std::size_t>(r.index(kQuadricFamily.size()))];
      q.box_low = {r.uniform(-1, -0.4), r.uniform(-1, -0.4), r.uniform(-1, -0.4)};
      q.box_high = {r.uniform(0.4, 1), r.uniform(0.4, 1), r.uniform(0.4, 1)};
      q.solid = r.uniform(0, 1) < 0.5;
      return q;
    }
    case 8: return Cylinder{z * -part(), z * part(), part()};
    case 9: {
      const double from = r.uniform(0, 1) < 0.3 ? 0 : part();
      return Cone{z * -part(), z * part(), from, part()};
    }
    case 10:
      return Parallelepiped{x * -0.4 - y * 0.3 - z * 0.3, x * part(), y * part() + x * r.uniform(-0.3, 0.3),
                            z * part() + y * r.uniform(-0.3, 0.3)};
    case 11:
      return r.uniform(0, 1) < 0.5 ? Tetrahedron{x, y * part(), z * part(), -x * part() - y * 0.5 - z * 0.4}
                                   : regular_tetrahedron(z * 0.7, -z + x * 0.2, 1.2);
    default: return Torus{{0, 0, 0}, z, 0.7, 0.7 * r.scale(0.02, 0.95)};
  }
}

}  // namespace roadgen::test
