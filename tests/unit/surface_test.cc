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

// As the renderer asks: rays from an eye near the road, over crests and sags of any height, bounded by the segment's box
// and continued over its joints. What they first meet between the joints, coming from above, is found.
TEST(Surface, SearchFindsWhatComesFirstOnCrestsAndSags) {
  Dice dice;
  int meetings = 0, comes_out = 0;
  for (int i = 0; i < 20000; ++i) {
    Lib::RoadSurface r = random_surface(dice, dice(-0.1, 0.1), dice(-0.1, 0.1), i % 2 ? 0.1 : 0.0);
    const double scale = dice(1, 3);
    r.chord *= scale, r.arc *= scale;
    // Grades of up to a third, anyhow between the joints.
    const double g0 = dice(-0.35, 0.35), g1 = dice(-0.35, 0.35), rise = r.arc * dice(-0.35, 0.35);
    r.z1 = g0;
    r.z2 = (3 * rise / r.arc - 2 * g0 - g1) / r.arc;
    r.z3 = (g0 + g1 - 2 * rise / r.arc) / (r.arc * r.arc);
    const double half = 4;
    double low = 1e9, high = -1e9;
    for (int j = 0; j <= 100; ++j) {
      for (const double v : {-half, 0.0, half}) {
        const double u = j / 100.0, df = Lib::road_df(u, r.a, r.b), across = v / r.chord / std::sqrt(1 + df * df);
        const double x = u - across * df;
        const double z = Lib::surface_at(Lib::surface_arc(u, r), v, r).height - rise * x;
        low = std::min(low, z - 0.05), high = std::max(high, z + 0.05);
      }
    }
    const glm::dvec2 below(dice(-0.5, 1), dice(-half, half) / r.chord);
    const double base = below.x < 0 ? g0 * r.chord * below.x : height_at(r, below);
    const glm::dvec3 from(below, base + 0.4 * std::pow(30, dice(0, 1)));
    const glm::dvec2 aim(dice(0, 1), dice(-half, half) / r.chord);
    const glm::dvec3 target(aim, height_at(r, aim) + dice(-1, 0.2));
    glm::dvec3 toward = target - from;
    toward /= glm::length(glm::dvec3(r.chord * glm::dvec2(toward), toward.z));

    glm::dvec2 range(0.1, 1e6);
    const auto clip = [](glm::dvec2& k, double value, double slope) {
      (slope > 0 ? k.x : k.y) = slope > 0 ? std::max(k.x, -value / slope) : std::min(k.y, -value / slope);
    };
    const double above_chord = from.z - rise * from.x, climb = toward.z - rise * toward.x;
    clip(range, from.y + half / r.chord + 0.1, toward.y);
    clip(range, half / r.chord + 0.1 - from.y, -toward.y);
    clip(range, above_chord - low, climb);
    clip(range, high - above_chord, -climb);
    glm::dvec2 inner = range;
    const double x0 = from.x + r.a * from.y, x1 = 1 - from.x - r.b * from.y;
    const glm::dvec2 ends(toward.x + r.a * toward.y, -toward.x - r.b * toward.y);
    clip(range, x0 + 1.2, ends.x), clip(range, x1 + 1.2, ends.y);
    clip(inner, x0, ends.x), clip(inner, x1, ends.y);
    if (!(inner.x < inner.y)) continue;
    // The first meeting between the joints, if the ray comes from above.
    constexpr int kSteps = 2000;
    double meets = -1, before = 0;
    int sides = 0;
    for (int j = 0; j <= kSteps; ++j) {
      const glm::dvec3 at = from + (inner.x + (inner.y - inner.x) * j / kSteps) * toward;
      const double above = at.z - height_at(r, glm::dvec2(at));
      if (j == 0 && above <= 0) break;
      sides += j > 0 && above * before <= 0;
      if (meets < 0 && above <= 0) meets = inner.x + (inner.y - inner.x) * j / kSteps;
      before = above;
    }
    if (meets < 0) continue;
    const glm::dvec3 end = from + meets * toward;
    if (std::abs(Lib::road_project(end.x, end.y, r.a, r.b).v) * r.chord > half) continue;
    const Lib::RoadSearch found =
        Lib::surface_search(from.x, from.y, from.z, toward.x, toward.y, toward.z, range.x, range.y, 5e-4,
                            Lib::surface_most_bend(half, r), half, 1, inner.x, inner.y, r);
    ASSERT_TRUE(found.met) << i;
    ASSERT_NEAR(found.hit.k, meets, 2 * (inner.y - inner.x) / kSteps + 0.02) << i;
    ++meetings;
    comes_out += sides > 1;
  }
  EXPECT_GT(meetings, 15000);
  EXPECT_GT(comes_out, 2000);
}

// Rays that graze a banked road from the side, in boxes that are wider than it: however long they run along the surface as
// it goes on beside the road, what they meet on it is found.
TEST(Surface, SearchArrivesAtTheRoadAlongItsSurfaceBeside) {
  Dice dice;
  int meetings = 0;
  for (int i = 0; i < 20000; ++i) {
    Lib::RoadSurface r = random_surface(dice, 0, i % 2 ? 0 : dice(-0.02, 0.02), 0.2);
    r.left0 = r.right0 = r.e1 = 0;
    r.e2 = dice(-1e-3, 1e-3), r.e3 = dice(-2e-5, 2e-5);
    const double half = 3.75, margin = 0.02 + 20 * dice(0, 1) * dice(0, 1);
    const glm::dvec2 aim(dice(0.2, 0.8), dice(-3, 3) / r.chord);
    const double way = (dice(0, 1) < 0.5 ? 1 : -1) * dice(0.9, 2.2);
    const glm::dvec2 along = glm::dvec2(std::cos(way), std::sin(way)) / r.chord;
    const double slope = height_at(r, aim + 0.5 * along) - height_at(r, aim - 0.5 * along);
    const glm::dvec3 toward(along, slope - 0.03 * dice(0, 1) * dice(0, 1)), target(aim, height_at(r, aim));
    const double reach = dice(25, 60);
    const glm::dvec3 from = target - reach * toward;
    // In the box, and between the joints.
    double first = 0, last = 1e6;
    const auto clip = [&](double value, double change) {
      (change > 0 ? first : last) = change > 0 ? std::max(first, -value / change) : std::min(last, -value / change);
    };
    clip(from.y + (half + margin) / r.chord, toward.y), clip((half + margin) / r.chord - from.y, -toward.y);
    clip(from.x + r.a * from.y, toward.x + r.a * toward.y), clip(1 - from.x - r.b * from.y, -toward.x - r.b * toward.y);
    if (!(first < reach - 1 && reach + 1 < last)) continue;
    // It comes down through the road there, and does not only touch it.
    const auto above = [&](double k) {
      const glm::dvec3 at = from + k * toward;
      return at.z - height_at(r, glm::dvec2(at));
    };
    if (!(above(reach - 0.5) > 1e-3 && above(reach + 0.5) < -1e-3)) continue;
    const Lib::RoadSearch found =
        Lib::surface_search(from.x, from.y, from.z, toward.x, toward.y, toward.z, first, last, 5e-4,
                            Lib::surface_most_bend(half, r), half, i % 3, first, last, r);
    ASSERT_TRUE(found.met) << i;
    EXPECT_LE(std::abs(found.hit.v) * r.chord, half + 0.05) << i;
    EXPECT_LE(std::abs(above(found.hit.k)), 1e-3) << i;
    ++meetings;
  }
  EXPECT_GT(meetings, 5000);
}

}  // namespace
}  // namespace roadgen
