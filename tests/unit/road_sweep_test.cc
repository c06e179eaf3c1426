// Sweeps in double: the profile functions and the march of shaders/lib/sweep.glsl against surfaces sampled by position
// and against rays stepped finely with the exact nearest point of the curve; the findings about bad sweeps.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/road/network.h"
#include "roadgen/road/sweep_piece.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using glm::dvec2, glm::dvec3;

// A bend of 45 m radius that climbs and falls, in segments of 12 m.
Road bend() {
  constexpr double kRadius = 45;
  return testing::road_along(
      "R", 150, 12, 3.5,
      [](double s) {
        return testing::Station{{kRadius * std::sin(s / kRadius), kRadius * (1 - std::cos(s / kRadius))}, s / kRadius};
      },
      [](double s) { return 20 + 3 * std::sin(s / 25); });
}

struct Named {
  const char* name;
  Sweep sweep;
};

void PrintTo(const Named& named, std::ostream* out) { *out << named.name; }

const Named kSweeps[] = {
    {"Tunnel", {.s_start_m = 5, .s_end_m = 77, .shape = Tunnel{}}},
    {"FlatArch", {.s_start_m = 5, .s_end_m = 77, .t_m = 1, .shape = Tunnel{.wall_height_m = 4, .arch_rise_m = 1.2}}},
    {"RailOutside", {.s_start_m = 5, .s_end_m = 77, .t_m = -4.3, .shape = GuardRail{}}},
    {"RailInside", {.s_start_m = 5, .s_end_m = 77, .t_m = 4.3, .t_slope = 0.01, .shape = GuardRail{}}},
    {"Pipe", {.s_start_m = 5, .s_end_m = 77, .t_m = -6, .t_slope = 0.03, .shape = Pipe{}}},
    {"Cable", {.s_start_m = 5, .s_end_m = 77, .t_m = 6, .shape = Cable{.radius_m = 0.03, .span_m = 30}}},
};

// (s, n, h) of a point against the axis of a part, by the exact nearest point of the centre line.
struct Place {
  double s, n, h;
};
Place place(const Segment& segment, const SweepPart& part, dvec3 p) {
  const Nearest near = nearest(segment, dvec2(p));
  const dvec2 foot = position_m(segment, near.u);
  const double heading = heading_rad(segment, near.u);
  const dvec2 left(-std::sin(heading), std::cos(heading));
  const auto& r = part.piece.path;
  const double s = arc_at(segment, near.u);
  return {s, glm::dot(dvec2(p) - foot, left) - r.n0 - r.n1 * s,
          p.z - segment.elevation_m.c0 - Lib::road_cubic(s, r.z0, r.z1, r.z2, r.z3)};
}

dvec3 world(const Segment& segment, const SweepPart& part, double s, double n, double h) {
  const auto& r = part.piece.path;
  const double u = u_at_arc(segment, s), heading = heading_rad(segment, u), t = n + r.n0 + r.n1 * s;
  return dvec3(position_m(segment, u) + t * dvec2(-std::sin(heading), std::cos(heading)),
               h + segment.elevation_m.c0 + Lib::road_cubic(s, r.z0, r.z1, r.z2, r.z3));
}

// Points of a profile's boundary, found as those of a fine grid where D is smallest in size, moved along its slope.
std::vector<dvec2> boundary(const SweepPart& part, double low_n, double high_n, double low_h, double high_h) {
  std::vector<dvec2> points;
  const auto distance = [&](dvec2 p) { return Lib::sweep_distance(p.x, p.y, part.piece.profile); };
  constexpr int kGrid = 60;
  for (int i = 0; i <= kGrid; ++i) {
    for (int j = 0; j <= kGrid; ++j) {
      dvec2 p(low_n + (high_n - low_n) * i / kGrid, low_h + (high_h - low_h) * j / kGrid);
      for (int k = 0; k < 20; ++k) {
        const auto m = Lib::sweep_profile_normal(p.x, p.y, part.piece.profile);
        p -= distance(p) * dvec2(m.x, m.y);
      }
      if (std::abs(distance(p)) < 1e-5) points.push_back(p);
    }
  }
  return points;
}

class Sweeps : public ::testing::TestWithParam<Named> {
 protected:
  void SetUp() override {
    road_ = bend();
    road_.sweeps.push_back(GetParam().sweep);
    parts_ = sweep_parts(road_, 0);
    ASSERT_FALSE(parts_.empty());
  }
  // A world point around a part, up to `reach` m outside its extent.
  dvec3 around(const SweepPart& part, double reach) {
    const Segment& segment = road_.segments[part.segment];
    const auto& p = part.piece;
    const double s = uniform(arc_at(segment, p.u0), arc_at(segment, p.u1));
    const double width = std::max(Lib::sweep_support(1.0, 0.0, p.profile), Lib::sweep_support(-1.0, 0.0, p.profile));
    const double high = Lib::sweep_support(0.0, 1.0, p.profile), low = Lib::sweep_support(0.0, -1.0, p.profile);
    return world(segment, part, s, uniform(-width - reach, width + reach), uniform(-low - reach, high + reach));
  }
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  std::mt19937_64 random_{7};
  Road road_;
  std::vector<SweepPart> parts_;
};

INSTANTIATE_TEST_SUITE_P(, Sweeps, ::testing::ValuesIn(kSweeps), [](const auto& i) { return i.param.name; });

TEST_P(Sweeps, HasNoProblems) { EXPECT_TRUE(problems(road_, road_.sweeps[0]).empty()); }

TEST_P(Sweeps, TheProfileChangesByAtMostOnePerMetre) {
  for (const SweepPart& part : parts_) {
    for (int i = 0; i < 3000; ++i) {
      const dvec2 a(uniform(-8, 8), uniform(-2, 9)), b = a + dvec2(uniform(-1, 1), uniform(-1, 1)) * uniform(0, 2);
      const auto& p = part.piece.profile;
      EXPECT_LE(std::abs(Lib::sweep_distance(a.x, a.y, p) - Lib::sweep_distance(b.x, b.y, p)),
                glm::length(a - b) * (1 + 1e-12));
    }
  }
}

TEST_P(Sweeps, SupportIsTheExtentOfTheProfile) {
  const SweepPart& part = parts_[parts_.size() / 2];
  const auto& p = part.piece.profile;
  const auto points = boundary(part, -8, 8, -2, 9);
  ASSERT_GT(points.size(), 100u);
  for (int i = 0; i < 400; ++i) {
    const double angle = uniform(0, 2 * std::numbers::pi), en = std::cos(angle), eh = std::sin(angle);
    double most = -1e9;
    for (const dvec2& q : points) most = std::max(most, en * q.x + eh * q.y);
    const double support = Lib::sweep_support(en, eh, p);
    // The sampled boundary may miss corners, not exceed them.
    EXPECT_LE(most, support + 2e-5);
    EXPECT_GT(most, support - 0.25);
  }
}

// In space the surface is no nearer than D over the stated factor.
TEST_P(Sweeps, TheEstimateIsALowerBoundOfTheDistance) {
  double tightest = 0;
  for (const SweepPart& part : parts_) {
    const Segment& segment = road_.segments[part.segment];
    std::vector<dvec3> surface;
    const auto outline = boundary(part, -8, 8, -2, 9);
    constexpr int kSections = 25;
    for (int i = 0; i <= kSections; ++i) {
      const double s0 = arc_at(segment, part.piece.u0), s1 = arc_at(segment, part.piece.u1);
      for (std::size_t k = 0; k < outline.size(); k += 3) {
        surface.push_back(world(segment, part, s0 + (s1 - s0) * i / kSections, outline[k].x, outline[k].y));
      }
    }
    const double factor = lipschitz(part);
    EXPECT_LT(factor, 1.6);
    for (int i = 0; i < 60; ++i) {
      const dvec3 p = around(part, 2);
      const Place at = place(segment, part, p);
      const double estimate = Lib::sweep_distance(at.n, at.h, part.piece.profile) / factor;
      double least = std::numeric_limits<double>::max();
      for (const dvec3& q : surface) least = std::min(least, glm::length(p - q));
      EXPECT_LE(estimate, least + 1e-5);
      if (estimate > 0.05) tightest = std::max(tightest, estimate / least);
    }
  }
  EXPECT_GT(tightest, 0.7);  // and no idle bound
}

// A part as a solid in space, by the exact nearest point of the centre line and posts as upright prisms.
class Solid {
 public:
  Solid(const Road& road, const SweepPart& part) : segment_(road.segments[part.segment]), part_(part) {}

  // At most the distance from the profile between its end sections.
  double body(dvec3 q) const {
    double outside = -1e9;
    for (const bool at_end : {false, true}) {
      const double u = at_end ? part_.piece.u1 : part_.piece.u0, heading = heading_rad(segment_, u);
      const dvec2 outward = (at_end ? 1.0 : -1.0) * dvec2(std::cos(heading), std::sin(heading));
      outside = std::max(outside, glm::dot(dvec2(q) - position_m(segment_, u), outward));
    }
    if (outside > 5) return outside;
    const Place at = place(segment_, part_, q);
    const double d = std::max(outside, Lib::sweep_distance(at.n, at.h, part_.piece.profile) / lipschitz(part_));
    // Beyond the piece's box, toward the centre of curvature, the nearest point jumps.
    return std::abs(at.n + part_.piece.path.n0) > 15 ? std::max(d, 1.0) : d;
  }

  double posts(dvec3 q) const {
    const auto& p = part_.piece.posts;
    double least = 1e9;
    for (int i = 0; i < p.count; ++i) {
      const double s = p.first + i * p.spacing, heading = heading_rad(segment_, u_at_arc(segment_, s));
      const dvec3 d = q - world(segment_, part_, s, p.n, 0);
      const dvec2 ahead(std::cos(heading), std::sin(heading));
      const double x = glm::dot(dvec2(d), ahead), y = glm::dot(dvec2(d), dvec2(-ahead.y, ahead.x));
      const double level =
          p.half_s < 0 ? std::hypot(x, y) - p.half_n : std::max(std::abs(x) - p.half_s, std::abs(y) - p.half_n);
      least = std::min(least, std::max({level, d.z - p.high, p.low - d.z}));
    }
    return least;
  }

  // Along a ray in steps of a fifth of the distance, at least 0.4 mm.
  struct Hit {
    double k;
    bool post;
  };
  std::optional<Hit> march(dvec3 origin, dvec3 direction, double reach) const {
    for (double k = 0; k < reach;) {
      const dvec3 q = origin + k * direction;
      const double d = body(q), post = posts(q);
      if (d < 1e-4) return Hit{k, false};
      if (post < 0) return Hit{k, true};
      k += std::max(0.2 * std::min(d, post), 4e-4);
    }
    return std::nullopt;
  }

 private:
  const Segment& segment_;
  const SweepPart& part_;
};

TEST_P(Sweeps, TheMarchFindsWhatAFineMarchFinds) {
  constexpr int kRays = 2000;  // of each sweep
  constexpr double kReach_m = 40;
  // The march ends within half a millimetre of the profile, and pieces overlap by a millimetre; posts are met as if the road were straight beside them.
  constexpr double kBody_m = 1.01e-3, kPost_m = 2e-3;
  int hits = 0, posts = 0, grazing = 0;
  double worst = 0;
  for (int i = 0; i < kRays; ++i) {
    const SweepPart& part = parts_[static_cast<std::size_t>(i) % parts_.size()];
    const Segment& segment = road_.segments[part.segment];
    // By turns: toward the piece, anywhere, from near the axis outward, along the road near the surface.
    dvec3 origin = around(part, 4), direction = glm::normalize(around(part, 0.3) - origin);
    const dvec3 any(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    if (i % 4 == 1) direction = glm::normalize(any);
    if (i % 4 == 2) {
      origin = world(segment, part, uniform(0, segment.arc_m), uniform(-0.4, 0.4), uniform(0, 1));
      direction = glm::normalize(around(part, 0.5) - origin);
    }
    if (i % 4 == 3) {
      origin = around(part, 0.4);
      const double heading = heading_rad(segment, 0.5) + (uniform(0, 1) < 0.5 ? std::numbers::pi : 0);
      direction = glm::normalize(dvec3(std::cos(heading), std::sin(heading), 0.05) + 0.05 * any);
    }
    const Solid solid(road_, part);
    const auto found = cast(road_, part, origin, direction, 0);
    const auto fine = solid.march(origin, direction, kReach_m);
    if (found && found->distance_m < kReach_m) {
      // What is found is there.
      const dvec3 q = origin + found->distance_m * direction;
      EXPECT_LE(found->post ? solid.posts(q) : solid.body(q), found->post ? kPost_m : kBody_m) << "ray " << i;
      EXPECT_NEAR(glm::length(found->normal), 1, 1e-9);
    }
    if (!fine) continue;
    ++hits;
    posts += fine->post;
    // And nothing before it: what the fine march finds is found, or missed by so little that it grazes.
    const double late = found ? found->distance_m - fine->k : kReach_m;
    if (late < 5e-3) {
      worst = std::max(worst, late);
      continue;
    }
    ++grazing;
    double deepest = 0;
    const double until = std::min(fine->k + late, fine->k + 3.0);
    for (double k = fine->k; k < until; k += 1e-3) {
      const dvec3 q = origin + k * direction;
      deepest = std::min(deepest, fine->post ? solid.posts(q) : solid.body(q));
    }
    EXPECT_GT(deepest, fine->post ? -kPost_m : -kBody_m) << "ray " << i << " missed what begins at " << fine->k;
  }
  std::printf("%d hits, %d of posts, %d grazing; later than the fine march by at most %.2g m\n", hits, posts, grazing,
              worst);
  EXPECT_GT(hits, kRays / 20);
  EXPECT_LE(grazing, hits / 50);
}

TEST(SweepProblems, NamesTheRoadThePlaceAndTheFault) {
  Road road = bend();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const struct {
    Sweep sweep;
    const char* text;
  } cases[] = {
      {{.s_start_m = 10, .s_end_m = 50, .shape = Pipe{.radius_m = 0}},
       "road R, s = 10.000 m: the pipe's radius must be above 0, is 0"},
      {{.s_start_m = 10, .s_end_m = 50, .shape = Pipe{.radius_m = nan}}, "the pipe's radius must be above 0, is nan"},
      {{.s_start_m = 50, .s_end_m = 10, .shape = GuardRail{}}, "s = 50.000 m: the sweep ends before it starts"},
      {{.s_start_m = -20, .s_end_m = 10, .shape = GuardRail{}}, "s = -20.000 m: the sweep starts before the road"},
      {{.s_start_m = 10, .s_end_m = 500, .shape = GuardRail{}}, "the sweep ends beyond the road"},
      {{.s_start_m = nan, .s_end_m = 500, .shape = GuardRail{}}, "not finite"},
      {{.s_start_m = 10, .s_end_m = 50, .t_m = 44, .shape = Pipe{}}, "the road bends too tightly here"},
      {{.s_start_m = 10, .s_end_m = 50, .shape = Cable{.span_m = 0}}, "the cable's span must be at least 1, is 0"},
      {{.s_start_m = 10, .s_end_m = 50, .shape = Cable{.sag_m = 9}}, "the cable's sag must be at most its height, 7"},
      {{.s_start_m = 10, .s_end_m = 50, .shape = Tunnel{.arch_rise_m = 6}}, "at most its half width, 5, is 6"},
      {{.s_start_m = 10, .s_end_m = 50, .shape = Pipe{}, .albedo = dvec3(2, 0, 0)}, "albedo must lie in 0 to 1"},
  };
  for (const auto& c : cases) {
    const auto list = problems(road, c.sweep);
    ASSERT_FALSE(list.empty()) << c.text;
    EXPECT_NE(list[0].find(c.text), std::string::npos) << list[0];
    EXPECT_NE(list[0].find("road R, s = "), std::string::npos) << list[0];
  }
  EXPECT_FALSE(problems(Road{.id = "E", .name = {}, .segments = {}, .sections = {}, .paint = {}, .sweeps = {}}, Sweep{}).empty());
}

TEST(SweepProblems, BadSweepsHaveNoPartsAndLongOnesAreCutOff) {
  Road road = bend();
  const double infinity = std::numeric_limits<double>::infinity();
  road.sweeps = {{.s_start_m = 10, .s_end_m = 50, .shape = Pipe{.radius_m = -1}},
                 {.s_start_m = 10, .s_end_m = infinity, .shape = Pipe{}},
                 {.s_start_m = 10, .s_end_m = 50, .t_m = 44, .shape = Pipe{}},
                 {.s_start_m = -1e12, .s_end_m = 1e300, .t_m = -5, .shape = Cable{}}};
  EXPECT_TRUE(sweep_parts(road, 0).empty());
  EXPECT_TRUE(sweep_parts(road, 1).empty());
  EXPECT_TRUE(sweep_parts(road, 2).empty());
  const auto parts = sweep_parts(road, 3);
  EXPECT_GE(parts.size(), road.segments.size());
  EXPECT_LE(parts.size(), road.segments.size() + 4);
}

TEST(SweepParts, NeighboursMeetInPlaceAndSlope) {
  Road road = bend();
  for (const Named& named : kSweeps) {
    road.sweeps = {named.sweep};
    const auto parts = sweep_parts(road, 0);
    for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
      if (parts[i + 1].piece.profile.kind != parts[i].piece.profile.kind ||
          parts[i + 1].segment != parts[i].segment + 1)
        continue;
      const Segment &a = road.segments[parts[i].segment], &b = road.segments[parts[i + 1].segment];
      const dvec3 p = world(a, parts[i], a.arc_m, 0, 0), q = world(b, parts[i + 1], 0, 0, 0);
      EXPECT_LT(glm::length(p - q), 1e-9) << named.name;
    }
  }
}

TEST(SweepParts, ACableHangsItsSagBelowTheLineBetweenThePoles) {
  Road road = testing::road_along(
      "C", 100, 10, 3.5,
      [](double s) {
        return testing::straight({0, 0}, 0.3, s);
      },
      [](double s) { return 0.05 * s; });
  const Cable cable{.span_m = 40, .sag_m = 1.5};
  road.sweeps = {{.s_start_m = 10, .s_end_m = 90, .t_m = 5, .shape = cable}};
  for (const SweepPart& part : sweep_parts(road, 0)) {
    const Segment& segment = road.segments[part.segment];
    for (const double u : {part.piece.u0, part.piece.u1}) {
      const double s = arc_at(segment, u), along = std::fmod(segment.s_start_m + s - 10 + 1e-9, 40) / 40;
      const double expected = 0.05 * (segment.s_start_m + s) + 7 - 4 * 1.5 * along * (1 - along);
      EXPECT_NEAR(world(segment, part, s, 0, 0).z, expected, 1e-6);
    }
  }
}

}  // namespace
}  // namespace roadgen
