// The road surface's bend along lines and its search for what becomes of a ray, in double, against many plain values.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "shaders/lib/glsl.h"

namespace roadgen {
namespace {

using Lib = glsl::Library<double>;

class Dice {
 public:
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }

 private:
  std::mt19937 engine_{7};
};

// Slopes a, b of the chord frame; straight and of constant length for 0.
Lib::RoadSurface random_surface(Dice& dice, double a, double b, double bank) {
  Lib::RoadSurface r{};
  r.chord = dice(12, 40);
  r.a = a, r.b = b;
  double length = 0;
  constexpr int kSteps = 2000;
  for (int i = 0; i < kSteps; ++i) {
    const double df = Lib::road_df((i + 0.5) / kSteps, a, b);
    length += std::sqrt(1 + df * df) / kSteps;
  }
  r.arc = r.chord * length;
  r.z1 = dice(-0.06, 0.06), r.z2 = dice(-4e-3, 4e-3), r.z3 = dice(-5e-5, 5e-5);
  r.e0 = dice(-bank, bank), r.e1 = dice(-bank, bank) / 40;
  r.left0 = dice(0, bank) / 3, r.right0 = dice(0, bank) / 3;
  return r;
}

// Height of the surface at a place in the chord frame, z of a ray of any height there.
double height_at(const Lib::RoadSurface& r, glm::dvec2 p) {
  double above, climb;
  Lib::surface_step(p.x, p.y, 0.0, 1.0, 0.0, 0.0, 0.0, Lib::road_project(p.x, p.y, r.a, r.b).u, r, above, climb);
  return -above;
}

TEST(Surface, TangentOfTheSuperelevation) {
  for (double e = -2; e <= 2; e += 1e-4) {
    if (std::abs(std::abs(e) - 1.5708) < 0.01) continue;
    const double limit = std::abs(e) < 0.786 ? 2e-15 : std::abs(e) < 1.4 ? 3e-13 : 6e-11;
    EXPECT_NEAR(Lib::surface_tan(e), std::tan(e), limit * std::abs(std::tan(e))) << e;
    Lib::RoadSurface r{};
    r.e0 = e;
    EXPECT_NEAR(Lib::surface_at(0.0, 0.0, r).cosine, std::cos(e), 6e-11) << e;
  }
}

TEST(Surface, BendIsTheSecondDifference) {
  Dice dice;
  for (int i = 0; i < 4000; ++i) {
    // On bends the change of curvature is left out: near the middle of a symmetric one there is none.
    const double a = i % 2 ? 0 : dice(-0.15, 0.15);
    const Lib::RoadSurface r = random_surface(dice, a, -a, 0.1);
    const double u = 0.5, side = dice(0, 1) < 0.5 ? -1 : 1, n = side * dice(1, 5), way = dice(-3.1, 3.1);
    const double turn = Lib::road_ddf(u, a, -a) / r.chord;
    const glm::dvec2 p(u, Lib::road_f(u, a, -a) + n / r.chord), step = glm::dvec2(std::cos(way), std::sin(way));
    const double h = 0.05;
    const glm::dvec2 q = h / r.chord * step;
    const double second = (height_at(r, p + q) - 2 * height_at(r, p) + height_at(r, p - q)) / (h * h);
    const double s = Lib::surface_arc(u, r), ds = step.x / (1 - n * turn), dn = step.y;
    EXPECT_NEAR(Lib::surface_bend(s, n, turn, ds, dn, r), -second, 2e-6 + 0.02 * std::abs(second)) << i;
  }
}

TEST(Surface, MostBendIsABound) {
  Dice dice;
  double closest = 0;
  for (int i = 0; i < 20000; ++i) {
    const Lib::RoadSurface r = random_surface(dice, dice(-0.3, 0.3), dice(-0.3, 0.3), 0.1);
    const double side = 6, n = dice(-side, side), u = dice(0, 1), way = dice(-3.1, 3.1);
    const double df = Lib::road_df(u, r.a, r.b),
                 turn = Lib::road_ddf(u, r.a, r.b) / std::pow(1 + df * df, 1.5) / r.chord;
    if (n * turn > 0.3) continue;  // what the factor in it is for
    const double bend =
        Lib::surface_bend(Lib::surface_arc(u, r), n, turn, std::cos(way) / (1 - n * turn), std::sin(way), r);
    const double most = Lib::surface_most_bend(side, r);
    ASSERT_LE(std::abs(bend), most) << i;
    closest = std::max(closest, std::abs(bend) / most);
  }
  EXPECT_GT(closest, 0.5);
}

// Rays that run nearly along the surface: where they first meet it, or that they pass over a crest and how near.
TEST(Surface, SearchFindsTheFirstMeetingAndTheCrest) {
  Dice dice;
  int meetings = 0, crests = 0;
  for (int i = 0; i < 8000; ++i) {
    const Lib::RoadSurface r = random_surface(dice, dice(-0.1, 0.1), dice(-0.1, 0.1), 0.0);
    const double reach = dice(20, 200), way = dice(-0.1, 0.1);
    const glm::dvec2 aim(dice(0.2, 0.8), dice(-2, 2) / r.chord);
    const glm::dvec3 target(aim, height_at(r, aim) + dice(-0.1, 0.1));
    const glm::dvec2 along(std::cos(way), std::sin(way));
    const glm::dvec3 toward(along / r.chord, dice(-0.02, 0.02));
    const glm::dvec3 from = target - reach * toward;
    // Within the segment.
    const double first = reach - 0.15 * r.chord, last = reach + 0.15 * r.chord;
    constexpr int kSteps = 3000;
    double meets = -1, nearest = 1e9, above_first = 0, before = 0;
    int least = 0;
    for (int j = 0; j <= kSteps; ++j) {
      const double k = first + (last - first) * j / kSteps;
      const glm::dvec3 at = from + k * toward;
      const double above = at.z - height_at(r, glm::dvec2(at));
      if (j == 0) above_first = above;
      if (j > 0 && above * before <= 0 && meets < 0) meets = k;
      if (std::abs(above) < nearest) nearest = std::abs(above), least = j;
      before = above;
    }
    const double tolerance = 5e-4;
    const Lib::RoadSearch found = Lib::surface_search(from.x, from.y, from.z, toward.x, toward.y, toward.z, first, last,
                                                      tolerance, Lib::surface_most_bend(10, r), 1e3, 2, first, last, r);
    if (meets < 0 && nearest < 0.005) continue;  // may touch
    if (meets >= 0) {
      ASSERT_TRUE(found.met) << i;
      EXPECT_LE(found.hit.residual, tolerance) << i;
      const glm::dvec3 at = from + found.hit.k * toward;
      EXPECT_LE(std::abs(at.z - height_at(r, glm::dvec2(at))), tolerance) << i;
      const Lib::RoadCoord c = Lib::road_project(at.x, at.y, r.a, r.b);
      EXPECT_NEAR(found.hit.v, c.v, 1e-6) << i;
      EXPECT_NEAR(found.hit.s, Lib::surface_s(c, at.x, at.y, r), 1e-4) << i;
      // From above it is the first; a hundredth of the tolerance may be millimetres along a ray that grazes.
      EXPECT_TRUE(above_first <= 0 || found.hit.k <= meets + 0.01) << i;
      ++meetings;
    } else {
      EXPECT_FALSE(found.met) << i;
      const bool crest = least > 0 && least < kSteps;
      // Where the surface turns from sag to crest a ray may come near twice, about alike.
      EXPECT_NEAR(std::abs(found.above), nearest, found.crest == crest ? 1e-5 : 1e-3) << i;
      crests += found.crest && crest;
    }
  }
  EXPECT_GT(meetings, 1200);
  EXPECT_GT(crests, 200);
}

}  // namespace
}  // namespace roadgen
