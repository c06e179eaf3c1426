// Roads through anchors: every polyline gives an admissible road through its anchors, or an Error whose cause is true.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/fit/curvature.h"

namespace roadgen {
namespace {

glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

// Polylines of many kinds, the same in every run.
class Polylines {
 public:
  explicit Polylines(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double normal() { return std::normal_distribution<double>()(random_); }
  std::size_t below(std::size_t n) { return random_() % n; }

  std::vector<Anchor> next() {
    switch (below(6)) {
      case 0: return walk(2 + below(60), 0.2);
      case 1: return walk(2 + below(60), 1.0);
      case 2: return hairpins();
      case 3: return spiral();
      case 4: return walk(2, 0);
      default: return repeating();
    }
  }

  std::vector<Anchor> walk(std::size_t count, double turn_rad) {
    std::vector<Anchor> anchors;
    glm::dvec2 p(1e4 * normal(), 1e4 * normal());
    double heading = uniform(-3, 3), z = 0;
    for (std::size_t i = 0; i < count; ++i) {
      anchors.push_back({p, z, uniform(1.5, 4)});
      heading += turn_rad * normal();
      p += uniform(8, 60) * direction(heading);
      z += normal();
    }
    return anchors;
  }

 private:
  // There and back, with gaps from 4 m.
  std::vector<Anchor> hairpins() {
    std::vector<Anchor> anchors;
    const double gap = uniform(4, 30), leg = uniform(20, 200);
    for (int i = 0; i < 8; ++i) {
      const double x = (i + 1) / 2 % 2 ? leg : 0;
      anchors.push_back({{x, gap * (i / 2) + 0.4 * normal()}, 0.1 * i, 3});
    }
    return anchors;
  }

  std::vector<Anchor> spiral() {
    std::vector<Anchor> anchors;
    const double tightest = uniform(2, 20), pitch = uniform(8, 20);
    for (double angle = 0; angle < 20; angle += uniform(0.2, 0.9)) {
      anchors.push_back({(tightest + pitch * angle / 6.28) * direction(angle), angle, 3});
    }
    return anchors;
  }

  std::vector<Anchor> repeating() {
    std::vector<Anchor> anchors;
    for (const Anchor& a : walk(2 + below(20), 0.3)) {
      for (std::size_t k = 0; k < 1 + below(3); ++k) anchors.push_back(a);
    }
    return anchors;
  }

  std::mt19937_64 random_;
};

AlignmentOptions random_options(Polylines& random, TightPolicy tight) {
  AlignmentOptions options;
  options.tight = tight;
  options.closed = random.below(3) == 0;
  options.tangents = random.below(2) ? Tangents::kUniform : Tangents::kCentripetal;
  return options;
}

CheckReport checked(const Road& road) {
  Network network;
  network.roads.push_back(road);
  return check(network);
}

// Anchors without those within 1 mm of the one before, around the end too where closed.
std::vector<Anchor> distinct(const std::vector<Anchor>& anchors, bool closed) {
  std::vector<Anchor> kept;
  for (const Anchor& a : anchors) {
    if (kept.empty() || glm::length(a.position_m - kept.back().position_m) > 1e-3) kept.push_back(a);
  }
  while (closed && kept.size() > 1 && glm::length(kept.back().position_m - kept.front().position_m) <= 1e-3) {
    kept.pop_back();
  }
  return kept;
}

void expect_road_through(const std::vector<Anchor>& anchors, const Road& road, bool narrowed) {
  const CheckReport report = checked(road);
  ASSERT_TRUE(report.ok()) << report.problems.front();
  ASSERT_LT(report.worst.heading_rad, 1e-9);
  ASSERT_EQ(report.worst.position_m, 0);  // the joint is one point to the last bit
  ASSERT_LT(report.worst.grade, 1e-9);
  std::size_t k = 0;
  for (const Segment& s : road.segments) {
    if (k == anchors.size() || s.start_m != anchors[k].position_m) continue;
    ASSERT_NEAR(s.elevation_m.value(0), anchors[k].elevation_m, 1e-9);
    if (!narrowed) {
      ASSERT_NEAR(s.left_m.value(0), anchors[k].half_width_m, 1e-9);
      ASSERT_NEAR(s.left_m.slope(0), 0, 1e-9);
    }
    ++k;
  }
  if (!road.closed && road.segments.back().end_m == anchors.back().position_m) ++k;
  ASSERT_EQ(k, anchors.size());
}

// Least radius of the curve between two anchors as the header documents it: cubic Hermite, tangents L / cos up to 60
// degrees off the chord and 2 L beyond.
double tightest_radius_m(const Anchor& from, const Anchor& to, double heading0, double heading1) {
  const glm::dvec2 chord = to.position_m - from.position_m;
  const double length = glm::length(chord);
  const auto tangent = [&](double heading) {
    const double cosine = glm::dot(direction(heading), chord) / length;
    return direction(heading) * (cosine > 0.5 ? length / cosine : 2 * length);
  };
  const glm::dvec2 m0 = tangent(heading0), m1 = tangent(heading1);
  double least = 1e300;
  constexpr int kSteps = 20000;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const glm::dvec2 d = chord * (6 * t * (1 - t)) + m0 * (1 - 4 * t + 3 * t * t) + m1 * (3 * t * t - 2 * t);
    const glm::dvec2 dd = chord * (6 - 12 * t) + m0 * (6 * t - 4) + m1 * (6 * t - 2);
    const double speed = glm::length(d), turn = std::abs(d.x * dd.y - d.y * dd.x);
    least = std::min(least, speed * speed * speed / std::max(turn, 1e-300));
  }
  return least;
}

// The Error says where; there, the documented curve must be as tight as it claims.
void expect_true_cause(const std::vector<Anchor>& anchors, const AlignmentOptions& options, const Error& error) {
  std::size_t i = 0, j = 0;
  ASSERT_EQ(error.code, ErrorCode::kGeometry) << error.text();
  ASSERT_EQ(std::sscanf(error.message.c_str(), "between anchors %zu and %zu", &i, &j), 2) << error.text();
  ASSERT_LT(std::max(i, j), anchors.size());
  const std::vector<Anchor> kept = distinct(anchors, options.closed);
  const std::vector<double> headings = catmull_rom_headings(kept, options);
  const auto place = [&](std::size_t given) {
    std::size_t k = 0;
    while (kept[k].position_m != anchors[given].position_m) ++k;
    return k;
  };
  const double radius = tightest_radius_m(anchors[i], anchors[j], headings[place(i)], headings[place(j)]);
  const double width = options.tight == TightPolicy::kError ? std::max(anchors[i].half_width_m, anchors[j].half_width_m)
                                                            : kLeastHalfWidth_m;
  // The mapping wants 5 % more than the half width, and a piece may be that much tighter than the curve.
  EXPECT_LT(radius, 1.15 * width) << error.text();
}

double share_of_roads(TightPolicy tight, unsigned seed) {
  Polylines random(seed);
  constexpr int kPolylines = 1000;
  int roads = 0;
  for (int i = 0; i < kPolylines; ++i) {
    const AlignmentOptions options = random_options(random, tight);
    const std::vector<Anchor> anchors = random.next();
    Diagnostics diagnostics;
    const Result<Road> road = road_from_anchors(anchors, options, &diagnostics);
    SCOPED_TRACE("polyline " + std::to_string(i));
    if (!road.ok()) {
      expect_true_cause(anchors, options, road.error());
    } else {
      const bool narrowed = std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) {
        return d.message.find("narrowed") != std::string::npos;
      });
      expect_road_through(distinct(anchors, options.closed), *road, narrowed);
      ++roads;
    }
    if (testing::Test::HasFatalFailure() || testing::Test::HasNonfatalFailure()) return 0;
  }
  return static_cast<double>(roads) / kPolylines;
}

TEST(Alignment, PolylinesGiveRoadsOrTrueErrors) { EXPECT_GT(share_of_roads(TightPolicy::kError, 101), 0.5); }

TEST(Alignment, NarrowingSavesNearlyAllPolylines) { EXPECT_GT(share_of_roads(TightPolicy::kNarrow, 102), 0.9); }

TEST(Alignment, HundredThousandAnchorsTakeSeconds) {
  Polylines random(103);
  AlignmentOptions options;
  options.tight = TightPolicy::kNarrow;
  const std::vector<Anchor> anchors = random.walk(100000, 0.1);
  const auto start = std::chrono::steady_clock::now();
  const Result<Road> road = road_from_anchors(anchors, options);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(road.ok()) << road.error().text();
  EXPECT_LT(taken.count(), 20);  // 1 s on one slow core without load
  expect_road_through(anchors, *road, true);
}

TEST(Alignment, GentleAnchorsCostOneSegmentEach) {
  Polylines random(104);
  const std::vector<Anchor> anchors = random.walk(1000, 0.05);
  const Result<Road> road = road_from_anchors(anchors, {});
  ASSERT_TRUE(road.ok()) << road.error().text();
  EXPECT_EQ(road->segments.size(), anchors.size() - 1);
}

TEST(Alignment, NarrowedWidthNeverExceedsTheOneAskedFor) {
  Polylines random(105);
  AlignmentOptions options;
  options.tight = TightPolicy::kNarrow;
  int narrowed = 0;
  for (int i = 0; i < 300; ++i) {
    std::vector<Anchor> anchors = random.walk(20, 1);
    for (Anchor& a : anchors) a.half_width_m = 4;
    Diagnostics diagnostics;
    const Result<Road> road = road_from_anchors(anchors, options, &diagnostics);
    if (!road.ok()) continue;
    double least = 4, s_narrow = -1;
    for (const Segment& s : road->segments) {
      ASSERT_LE(s.max_half_width_m(), 4 * (1 + 1e-12));
      const Cubic::Range range = s.left_m.range(s.arc_m);
      ASSERT_GE(range.low, kLeastHalfWidth_m * (1 - 1e-6));
      if (range.low < least) least = range.low, s_narrow = s.s_start_m;
    }
    // One warning per contiguous stretch, and none where nothing was narrowed.
    ASSERT_EQ(diagnostics.empty(), least == 4);
    narrowed += !diagnostics.empty();
    bool told = diagnostics.empty();
    for (const Diagnostic& d : diagnostics) {
      double from = 0, to = 0;
      ASSERT_EQ(std::sscanf(d.message.c_str(), "narrowed from s = %lf m to %lf m", &from, &to), 2) << d.message;
      told = told || (from <= s_narrow + 1e-3 && s_narrow <= to + 1e-3);
    }
    EXPECT_TRUE(told);
  }
  EXPECT_GT(narrowed, 50);
}

TEST(Alignment, ReversedAnchorsGiveTheMirroredRoad) {
  Polylines random(106);
  for (int i = 0; i < 100; ++i) {
    std::vector<Anchor> anchors = random.walk(15, 0.3);
    const Result<Road> there = road_from_anchors(anchors, {});
    std::reverse(anchors.begin(), anchors.end());
    const Result<Road> back = road_from_anchors(anchors, {});
    ASSERT_EQ(there.ok(), back.ok());
    if (!there.ok()) continue;
    ASSERT_NEAR(there->length_m(), back->length_m(), 1e-9 * there->length_m());
    for (double s = 0; s < there->length_m(); s += 7) {
      const RoadPose a = pose_at(*there, s, 0), b = pose_at(*back, back->length_m() - s, 0);
      ASSERT_LT(glm::length(a.position_m - b.position_m), 1e-6);
    }
  }
}

// Given headings are kept, and the heading at a free end continues the curve as an arc.
TEST(Alignment, ArcsAreContinuedAtTheEnds) {
  std::vector<Anchor> anchors;
  for (int i = 0; i < 6; ++i) anchors.push_back({100.0 * direction(0.2 * i)});
  const std::vector<double> headings = catmull_rom_headings(anchors, {});
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(headings[i], 0.2 * i + M_PI / 2, 1e-12);
  anchors[2].heading_rad = 1.25;
  EXPECT_EQ(catmull_rom_headings(anchors, {})[2], 1.25);
}

TEST(Alignment, UniformTangentsAreParallelToTheNeighboursChord) {
  Polylines random(107);
  AlignmentOptions closed;
  closed.closed = true;
  const std::vector<Anchor> anchors = random.walk(30, 0.5);
  const std::vector<double> headings = catmull_rom_headings(anchors, closed);
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    const glm::dvec2 chord = anchors[(i + 1) % 30].position_m - anchors[(i + 29) % 30].position_m;
    EXPECT_NEAR(glm::dot(direction(headings[i]), chord), glm::length(chord), 1e-9 * glm::length(chord));
  }
}

TEST(Alignment, TwoAnchorsAreAStraightRoadOrACircle) {
  const std::vector<Anchor> anchors = {{{0, 0}, 1}, {{100, 0}, 5}};
  const Result<Road> straight = road_from_anchors(anchors, {});
  ASSERT_TRUE(straight.ok());
  EXPECT_EQ(straight->segments.size(), 1u);
  EXPECT_NEAR(straight->length_m(), 100, 1e-12);
  EXPECT_NEAR(pose_at(*straight, 25, 0).position_m.z, 2, 1e-12);
  AlignmentOptions closed;
  closed.closed = true;
  const Result<Road> circle = road_from_anchors(anchors, closed);
  ASSERT_TRUE(circle.ok()) << circle.error().text();
  EXPECT_GT(circle->length_m(), 250);
}

TEST(Alignment, BadAnchorsAreNamed) {
  const double nan = std::nan("");
  const auto message = [](std::vector<Anchor> anchors) {
    const Result<Road> road = road_from_anchors(anchors, {});
    return road.ok() ? std::string("no error") : road.error().text();
  };
  EXPECT_NE(message({{{0, 0}}, {{5, nan}}, {{9, 9}}}).find("anchor 1"), std::string::npos);
  EXPECT_NE(message({{{0, 0}}, {{5, 1}, HUGE_VAL}}).find("anchor 1"), std::string::npos);
  EXPECT_NE(message({{{0, 0}, 0, -1}, {{5, 1}}}).find("anchor 0"), std::string::npos);
  EXPECT_NE(message({{{0, 0}}, {{1e300, 1}}}).find("anchor 1"), std::string::npos);
  EXPECT_NE(message({}).find("at least two"), std::string::npos);
  EXPECT_NE(message({{{1, 1}}, {{1, 1}}, {{1, 1}}}).find("at least two"), std::string::npos);
}

TEST(Alignment, RepeatedAnchorsAreReportedOnce) {
  Diagnostics diagnostics;
  const std::vector<Anchor> anchors = {{{0, 0}}, {{0, 0}}, {{0, 1e-4}}, {{50, 0}}, {{90, 5}}, {{90, 5}}};
  const Result<Road> road = road_from_anchors(anchors, {}, &diagnostics);
  ASSERT_TRUE(road.ok());
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_NE(diagnostics[0].message.find("anchors 1 to 2"), std::string::npos) << diagnostics[0].message;
  EXPECT_NE(diagnostics[1].message.find("anchor 5"), std::string::npos) << diagnostics[1].message;
}

// There and back on one line: the road turns left in a loop, or is refused.
TEST(Alignment, DoublingBackEnds) {
  const std::vector<Anchor> anchors = {{{0, 0}}, {{50, 0}}, {{0, 0}}, {{50, 0}}};
  for (const TightPolicy tight : {TightPolicy::kError, TightPolicy::kNarrow}) {
    AlignmentOptions options;
    options.tight = tight;
    const Result<Road> road = road_from_anchors(anchors, options);
    if (road.ok()) {
      EXPECT_TRUE(checked(*road).ok());
    } else {
      EXPECT_EQ(road.error().code, ErrorCode::kGeometry);
    }
  }
}

// Headings straight against each other along the chord: the derivative vanishes inside.
TEST(Alignment, CuspsAreErrors) {
  std::vector<Anchor> anchors = {{{0, 0}}, {{50, 0}}};
  anchors[0].heading_rad = M_PI;
  anchors[1].heading_rad = M_PI;
  for (const TightPolicy tight : {TightPolicy::kError, TightPolicy::kNarrow}) {
    AlignmentOptions options;
    options.tight = tight;
    const Result<Road> road = road_from_anchors(anchors, options);
    ASSERT_FALSE(road.ok());
    EXPECT_EQ(road.error().code, ErrorCode::kGeometry);
    EXPECT_NE(road.error().message.find("between anchors 0 and 1"), std::string::npos) << road.error().text();
  }
}

// The stated policy at a bend of 5 m radius: 4 m of half width fit, 6 m do not.
TEST(Alignment, WidthDecidesWhetherABendIsTight) {
  std::vector<Anchor> anchors;
  for (int i = 0; i <= 8; ++i) anchors.push_back({5.0 * direction(M_PI / 8 * i), 0, 4});
  ASSERT_TRUE(road_from_anchors(anchors, {}).ok());
  for (Anchor& a : anchors) a.half_width_m = 6;
  const Result<Road> wide = road_from_anchors(anchors, {});
  ASSERT_FALSE(wide.ok());
  EXPECT_NE(wide.error().message.find("radius"), std::string::npos);
  AlignmentOptions options;
  options.tight = TightPolicy::kNarrow;
  const Result<Road> narrow = road_from_anchors(anchors, options);
  ASSERT_TRUE(narrow.ok());
  for (const Segment& s : narrow->segments) EXPECT_LT(s.max_half_width_m(), 5.2);
}

TEST(Alignment, FarFromTheOriginNothingChanges) {
  Polylines random(108);
  std::vector<Anchor> near;
  for (Anchor a : random.walk(40, 0.3)) {
    a.position_m = glm::round(a.position_m);  // so that the shift is exact
    near.push_back(a);
  }
  std::vector<Anchor> far = near;
  for (Anchor& a : far) a.position_m += glm::dvec2(1e7, -2e7);
  AlignmentOptions options;
  options.tight = TightPolicy::kNarrow;
  const Result<Road> road = road_from_anchors(near, options), shifted = road_from_anchors(far, options);
  ASSERT_TRUE(road.ok() && shifted.ok());
  ASSERT_TRUE(checked(*shifted).ok()) << checked(*shifted).problems.front();
  EXPECT_EQ(road->segments.size(), shifted->segments.size());
  EXPECT_NEAR(road->length_m(), shifted->length_m(), 1e-6);
}

// Heights on a parabola over anchors at equal distances: Catmull-Rom is exact there, the ends included.
TEST(Alignment, ParabolicProfilesAreReproduced) {
  std::vector<Anchor> anchors;
  const auto height = [](double s) { return 3 + 0.04 * s - 2e-4 * s * s; };
  for (int i = 0; i <= 10; ++i) anchors.push_back({{30.0 * i, 0}, height(30.0 * i)});
  const Result<Road> road = road_from_anchors(anchors, {});
  ASSERT_TRUE(road.ok());
  for (double s = 0; s <= 300; s += 1.7) EXPECT_NEAR(pose_at(*road, s, 0).position_m.z, height(s), 1e-10) << s;
}

TEST(Alignment, GivenGradesAreKept) {
  std::vector<Anchor> anchors = {{{0, 0}, 0}, {{60, 5}, 3}, {{120, 0}, 1}};
  anchors[1].grade = -0.05;
  const Result<Road> road = road_from_anchors(anchors, {});
  ASSERT_TRUE(road.ok());
  EXPECT_NEAR(road->segments[1].elevation_m.slope(0), -0.05, 1e-12);
}

// Curvature at both sides of every joint, by the segments' own function.
void expect_smooth(const Road& road) {
  EXPECT_LT(checked(road).worst.curvature_per_m, 1e-9);
  if (road.closed) return;
  EXPECT_NEAR(curvature_per_m(road.segments.front(), 0), 0, 1e-9);
  EXPECT_NEAR(curvature_per_m(road.segments.back(), 1), 0, 1e-9);
}

TEST(CurvatureTangents, JoinPolylinesWithoutJumpsOfCurvature) {
  Polylines random(201);
  constexpr int kPolylines = 1000;
  int roads = 0;
  for (int i = 0; i < kPolylines; ++i) {
    AlignmentOptions options = random_options(random, TightPolicy::kNarrow);
    options.tangents = Tangents::kCurvature;
    const std::vector<Anchor> anchors = random.next();
    Diagnostics diagnostics;
    const Result<Road> road = road_from_anchors(anchors, options, &diagnostics);
    SCOPED_TRACE("polyline " + std::to_string(i));
    if (!road.ok()) {
      EXPECT_EQ(road.error().code, ErrorCode::kGeometry) << road.error().text();
      continue;
    }
    ++roads;
    const bool narrowed = std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) {
      return d.message.find("narrowed") != std::string::npos;
    });
    expect_road_through(distinct(anchors, options.closed), *road, narrowed);
    expect_smooth(*road);
    if (testing::Test::HasFatalFailure() || testing::Test::HasNonfatalFailure()) return;
  }
  EXPECT_GT(roads, kPolylines * 9 / 10);
}

TEST(CurvatureTangents, CloseCircuits) {
  Polylines random(202);
  AlignmentOptions options;
  options.tangents = Tangents::kCurvature;
  options.closed = true;
  for (int i = 0; i < 200; ++i) {
    std::vector<Anchor> anchors;
    const double radius = random.uniform(40, 400), phase = random.uniform(0, 6);
    for (double angle = 0; angle < 5.9; angle += random.uniform(0.25, 0.9)) {
      anchors.push_back({radius * (1 + 0.15 * std::sin(3 * angle + phase)) * direction(angle), 0, 4});
    }
    const Result<Road> road = road_from_anchors(anchors, options);
    ASSERT_TRUE(road.ok()) << road.error().text();
    expect_road_through(anchors, *road, false);
    expect_smooth(*road);
  }
}

// On a circle the tangents are the circle's by symmetry, and a segment with the slopes tan(angle) and -tan(angle) over a
// chord of 2 R sin(angle) has the curvature cos(angle)^2 / R at its ends.
TEST(CurvatureTangents, KeepTheCurvatureOfACircle) {
  AlignmentOptions options;
  options.tangents = Tangents::kCurvature;
  options.closed = true;
  for (const int count : {2, 3, 4, 6, 8, 16, 64}) {
    std::vector<Anchor> anchors;
    for (int i = 0; i < count; ++i) anchors.push_back({100.0 * direction(2 * M_PI * i / count), 0, 4});
    const Result<Road> road = road_from_anchors(anchors, options);
    ASSERT_TRUE(road.ok()) << road.error().text();
    expect_smooth(*road);
    const bool whole = road->segments.size() == anchors.size();
    EXPECT_TRUE(whole || count < 12) << count;
    if (!whole) continue;
    for (const Segment& s : road->segments) {
      EXPECT_NEAR(100 * curvature_per_m(s, 0), std::pow(std::cos(M_PI / count), 2), 1e-9) << count;
    }
  }
}

// Where slopes are small the road is the cubic spline, and the clamped spline of a cubic is that cubic: slopes of 1e-4
// leave differences of their cube.
TEST(CurvatureTangents, AreThoseOfTheCubicSplineWhereSlopesAreSmall) {
  const auto y = [](double x) { return 1e-4 * x * (1 - 0.02 * x + 1e-4 * x * x); };
  const auto dy = [](double x) { return 1e-4 * (1 - 0.04 * x + 3e-4 * x * x); };
  std::vector<glm::dvec2> points;
  std::vector<double> headings;
  for (const double x : {0.0, 10.0, 35.0, 41.0, 60.0, 100.0}) {
    points.push_back({x, y(x)});
    headings.push_back(0);
  }
  std::vector<char> fixed(points.size(), 0);
  fixed.front() = fixed.back() = 1;
  headings.front() = std::atan(dy(0));
  headings.back() = std::atan(dy(100));
  ASSERT_FALSE(equalize_curvature(points, fixed, false, headings));
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(headings[i], std::atan(dy(points[i].x)), 1e-11) << i;
}

TEST(CurvatureTangents, GivenHeadingsAreKept) {
  Polylines random(203);
  std::vector<Anchor> anchors = random.walk(20, 0.2);
  AlignmentOptions options;
  options.tangents = Tangents::kCurvature;
  const std::vector<double> headings = catmull_rom_headings(anchors, options);
  for (const std::size_t i : {std::size_t{0}, std::size_t{9}, std::size_t{19}})
    anchors[i].heading_rad = headings[i] + 0.1;
  const Result<Road> road = road_from_anchors(anchors, options);
  ASSERT_TRUE(road.ok()) << road.error().text();
  const auto& segments = road->segments;
  EXPECT_NEAR(std::remainder(heading_rad(segments.front(), 0) - *anchors[0].heading_rad, 2 * M_PI), 0, 1e-12);
  EXPECT_NEAR(std::remainder(heading_rad(segments.back(), 1) - *anchors[19].heading_rad, 2 * M_PI), 0, 1e-12);
  for (std::size_t k = 1; k < segments.size(); ++k) {
    const double gap = joint_gap(segments[k - 1], segments[k]).curvature_per_m;
    if (segments[k].start_m != anchors[9].position_m) {
      EXPECT_LT(gap, 1e-9);
      continue;
    }
    EXPECT_GT(gap, 1e-4);
    EXPECT_NEAR(std::remainder(heading_rad(segments[k], 0) - *anchors[9].heading_rad, 2 * M_PI), 0, 1e-12);
  }
}

// Any points and headings: a solution, or the point where there is none and the headings as they were.
TEST(CurvatureTangents, ConvergeOrSayWhereTheyDoNot) {
  Polylines random(204);
  int solved = 0, refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::vector<glm::dvec2> points;
    for (const Anchor& a : random.walk(2 + random.below(12), random.uniform(0, 0.4))) points.push_back(a.position_m);
    const bool closed = random.below(2);
    std::vector<double> headings;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const glm::dvec2 d = k + 1 < points.size() ? points[k + 1] - points[k] : points[k] - points[k - 1];
      headings.push_back(std::atan2(d.y, d.x) + random.uniform(-0.5, 0.5));
    }
    const std::vector<double> before = headings;
    const std::optional<std::size_t> jump =
        equalize_curvature(points, std::vector<char>(points.size(), 0), closed, headings);
    if (jump) {
      ++refused;
      ASSERT_LT(*jump, points.size());
      ASSERT_EQ(headings, before);
      continue;
    }
    ++solved;
    for (std::size_t k = closed ? 0 : 1; k + (closed ? 0 : 1) < points.size(); ++k) {
      const std::size_t last = k == 0 ? points.size() - 1 : k - 1, next = k + 1 == points.size() ? 0 : k + 1;
      const Segment in = make_segment(points[last], points[k], headings[last], headings[k], 1);
      const Segment out = make_segment(points[k], points[next], headings[k], headings[next], 1);
      ASSERT_NEAR(curvature_per_m(in, 1), curvature_per_m(out, 0), 1e-11);
    }
  }
  EXPECT_GT(solved, 500);
  EXPECT_GT(refused, 500);
}

// There is no curve without a cusp or a jump here, or it is found; either way the search ends.
TEST(CurvatureTangents, DoublingBackEnds) {
  AlignmentOptions options;
  options.tangents = Tangents::kCurvature;
  for (const bool closed : {false, true}) {
    options.closed = closed;
    const std::vector<Anchor> anchors = {{{0, 0}}, {{50, 0}}, {{0, 0}}, {{50, 0.5}}, {{0, 1}}, {{50, 0}}};
    const Result<Road> road = road_from_anchors(anchors, options);
    if (road.ok()) {
      EXPECT_TRUE(checked(*road).ok());
    } else {
      EXPECT_EQ(road.error().code, ErrorCode::kGeometry);
      EXPECT_NE(road.error().message.find("between anchors"), std::string::npos) << road.error().text();
    }
  }
}

}  // namespace
}  // namespace roadgen
