// The fit recovers known curves from samples with noise, within the error asked for, and its certificate is true.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/fit.h"
#include "roadgen/fit/profile.h"
#include "roadgen/fit/solver.h"

namespace roadgen {
namespace {

glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

// Samples along a curve of given curvature over arc length, integrated in small steps.
std::vector<Sample> curve(double length_m, double spacing_m, const std::function<double(double)>& curvature_per_m) {
  std::vector<Sample> samples;
  constexpr int kSteps = 64;
  glm::dvec2 p(0);
  double heading = 0.3;
  for (double s = 0; s <= length_m; s += spacing_m) {
    samples.push_back({p, 0, 3});
    for (int k = 0; k < kSteps; ++k) {
      const double h = spacing_m / kSteps, at = s + h * (k + 0.5);
      heading += 0.5 * h * curvature_per_m(at);
      p += h * direction(heading);
      heading += 0.5 * h * curvature_per_m(at);
    }
  }
  return samples;
}

std::vector<Sample> circle(double radius_m, std::size_t count) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    samples.push_back({radius_m * direction(2 * M_PI * static_cast<double>(i) / static_cast<double>(count)), 0, 3});
  }
  return samples;
}

// A straight, a clothoid, an arc, a clothoid, a straight.
double bend(double s_m) {
  constexpr double kMost = 1 / 60.0;
  if (s_m < 100 || s_m > 320) return 0;
  return kMost * std::min({1.0, (s_m - 100) / 60, (320 - s_m) / 60});
}

// Straight, half a turn of 12 m radius, straight.
double hairpin(double s_m) { return s_m > 80 && s_m < 80 + M_PI * 12 ? 1 / 12.0 : 0; }

double winding(double s_m) { return 0.02 * std::sin(s_m / 25) + 0.006 * std::cos(s_m / 90); }

void add_noise(std::vector<Sample>& samples, double sigma_m, unsigned seed) {
  std::mt19937_64 random(seed);
  // Cut at 2 sigma: a sample beyond the error allowed must become an anchor, which is another test.
  std::normal_distribution<double> normal(0, sigma_m);
  for (Sample& s : samples) {
    for (int axis = 0; axis < 2; ++axis) s.position_m[axis] += std::clamp(normal(random), -2 * sigma_m, 2 * sigma_m);
  }
}

CheckReport checked(const Road& road) {
  Network network;
  network.roads.push_back(road);
  return check(network);
}

double distance_m(const Road& road, glm::dvec2 p) {
  double least = 1e300;
  for (const Segment& s : road.segments) least = std::min(least, nearest(s, p).distance_m);
  return least;
}

double distance_to_line_m(std::span<const Sample> samples, bool closed, glm::dvec2 p) {
  double least = 1e300;
  for (std::size_t i = 0; i + (closed ? 0 : 1) < samples.size(); ++i) {
    const glm::dvec2 a = samples[i].position_m, e = samples[(i + 1) % samples.size()].position_m - a;
    const double w = std::clamp(glm::dot(p - a, e) / std::max(glm::dot(e, e), 1e-300), 0.0, 1.0);
    least = std::min(least, glm::length(p - a - w * e));
  }
  return least;
}

// No point of the polyline or of the curve is farther from the other than the certificate says, and some is nearly so.
void expect_bounds_hold(const Road& road, std::span<const Sample> samples, const Certificate& c) {
  double from_source = 0, from_curve = 0;
  const std::size_t edges = samples.size() - (road.closed ? 0 : 1);
  for (std::size_t k = 0; k < 2000; ++k) {
    const double at = (static_cast<double>(k) + 0.5) / 2000 * static_cast<double>(edges);
    const auto i = static_cast<std::size_t>(at);
    const glm::dvec2 a = samples[i].position_m, b = samples[(i + 1) % samples.size()].position_m;
    from_source = std::max(from_source, distance_m(road, a + (at - static_cast<double>(i)) * (b - a)));
    const glm::dvec2 p(pose_at(road, (static_cast<double>(k) + 0.5) / 2000 * road.length_m(), 0).position_m);
    from_curve = std::max(from_curve, distance_to_line_m(samples, road.closed, p));
  }
  EXPECT_LE(from_source, c.source_to_curve_m + 1e-9);
  EXPECT_LE(from_curve, c.curve_to_source_m + 1e-9);
  EXPECT_GE(from_source, 0.7 * c.source_to_curve_m - 1e-9);
  EXPECT_GE(from_curve, 0.7 * c.curve_to_source_m - 1e-9);
}

void expect_good(const Result<FittedRoad>& fitted, const std::vector<Sample>& samples, const FitOptions& options) {
  ASSERT_TRUE(fitted.ok()) << fitted.error().text();
  const CheckReport report = checked(fitted->road);
  ASSERT_TRUE(report.ok()) << report.problems.front();
  ASSERT_EQ(fitted->road.closed, options.closed);
  const Certificate& c = fitted->certificate;
  double worst = 0, sum = 0;
  for (const Sample& s : samples) {
    const double d = distance_m(fitted->road, s.position_m);
    worst = std::max(worst, d), sum += d * d;
  }
  EXPECT_LE(worst, options.max_error_m);
  EXPECT_NEAR(c.max_error_m, worst, 1e-9);
  EXPECT_NEAR(c.rms_error_m, std::sqrt(sum / static_cast<double>(samples.size())), 1e-9);
  EXPECT_GE(c.bound_m, c.max_error_m);
  expect_bounds_hold(fitted->road, samples, c);
  EXPECT_EQ(c.samples, samples.size());
  EXPECT_EQ(c.anchors, fitted->anchors.size());
  EXPECT_EQ(c.segments, fitted->road.segments.size());
  EXPECT_NEAR(c.length_m, fitted->road.length_m(), 1e-9);
  EXPECT_LT(c.max_heading_jump_rad, 1e-9);
}

struct Course {
  const char* name;
  double length_m;
  std::function<double(double)> curvature_per_m;
  std::size_t most_segments;
};

// Segments include those cut for the arc length's certificate.
const Course kCourses[] = {{"bend", 420, bend, 14}, {"hairpin", 200, hairpin, 20}, {"winding", 1500, winding, 68}};

TEST(Fit, RecoversKnownCurvesFromNoisySamples) {
  for (const Course& course : kCourses) {
    for (const double spacing : {1.0, 5.0}) {
      SCOPED_TRACE(testing::Message() << course.name << ", spacing " << spacing);
      const std::vector<Sample> exact = curve(course.length_m, spacing, course.curvature_per_m);
      std::vector<Sample> samples = exact;
      add_noise(samples, 0.02, 7);
      FitOptions options;
      const Result<FittedRoad> fitted = fit_road(samples, options);
      expect_good(fitted, samples, options);
      if (!fitted.ok()) continue;
      EXPECT_LE(fitted->road.segments.size(), course.most_segments);
      // And so the curve itself, which lies within the greatest noise of its samples.
      for (const Sample& s : exact) EXPECT_LT(distance_m(fitted->road, s.position_m), options.max_error_m + 0.04);
      EXPECT_NEAR(fitted->road.length_m(), spacing * static_cast<double>(exact.size() - 1), 0.3);
    }
  }
}

TEST(Fit, ReachesMillimetresOnExactSamples) {
  for (const Course& course : kCourses) {
    SCOPED_TRACE(course.name);
    const std::vector<Sample> samples = curve(course.length_m, 1, course.curvature_per_m);
    FitOptions options;
    options.max_error_m = 0.002;
    expect_good(fit_road(samples, options), samples, options);
  }
}

TEST(Fit, AveragesNoiseOut) {
  const std::vector<Sample> exact = curve(1500, 1, winding);
  std::vector<Sample> samples = exact;
  add_noise(samples, 0.03, 8);
  const Result<FittedRoad> fitted = fit_road(samples, {});
  ASSERT_TRUE(fitted.ok());
  const Certificate truth = certify(fitted->road, exact, 0);
  EXPECT_LT(truth.rms_error_m, 0.75 * fitted->certificate.rms_error_m);
}

TEST(Fit, ClosedCircuitsClose) {
  std::vector<Sample> samples;
  // An eight-cornered closed course: radius varies around the circle.
  for (int i = 0; i < 240; ++i) {
    const double angle = 2 * M_PI * i / 240;
    samples.push_back({(150 + 25 * std::cos(4 * angle)) * direction(angle), 5 * std::sin(angle), 4});
  }
  add_noise(samples, 0.02, 9);
  FitOptions options;
  options.closed = true;
  for (const TangentSource source : {TangentSource::kFit, TangentSource::kCatmullRom}) {
    options.tangents = source;
    const Result<FittedRoad> fitted = fit_road(samples, options);
    expect_good(fitted, samples, options);
    if (!fitted.ok()) continue;
    EXPECT_LE(fitted->certificate.max_elevation_error_m, options.max_elevation_error_m);
    EXPECT_EQ(fitted->road.segments.back().end_m, fitted->road.segments.front().start_m);
  }
}

// It does not matter where the samples of a loop begin.
TEST(Fit, CirclesTakeFewSegmentsWhereverTheyBegin) {
  FitOptions options;
  options.closed = true;
  std::vector<Sample> samples = circle(80, 150);
  for (int shift = 0; shift < 4; ++shift) {
    std::rotate(samples.begin(), samples.begin() + 31, samples.end());
    const Result<FittedRoad> fitted = fit_road(samples, options);
    expect_good(fitted, samples, options);
    if (!fitted.ok()) continue;
    // An arc of 45 degrees, which is 8 of them, is as far as a cubic stays within 0.1 m of this circle.
    // Longer pieces of it are cut for the arc length's certificate.
    EXPECT_LE(fitted->road.segments.size(), 14u);
    EXPECT_NEAR(fitted->road.length_m(), 2 * M_PI * 80, 0.2);
  }
}

TEST(Fit, NeedsFewerSegmentsThanCatmullRom) {
  std::vector<Sample> samples = curve(1500, 2, winding);
  add_noise(samples, 0.02, 10);
  FitOptions options;
  const Result<FittedRoad> fit = fit_road(samples, options);
  options.tangents = TangentSource::kCatmullRom;
  const Result<FittedRoad> catmull_rom = fit_road(samples, options);
  expect_good(fit, samples, options);
  expect_good(catmull_rom, samples, options);
  EXPECT_LT(2 * fit->road.segments.size(), catmull_rom->road.segments.size());
}

// Samples far apart: the curve between them must not swing. Its bend stays that of the arc, but for the free ends.
TEST(Fit, StaysFairBetweenSparseSamples) {
  for (const double radius : {40.0, 100.0, 300.0}) {
    std::vector<Sample> samples;
    for (int i = 0; i < 24; ++i) samples.push_back({radius * direction(35 / radius * i), 0, 3});
    add_noise(samples, 0.03, 11);
    const Result<FittedRoad> fitted = fit_road(samples, {});
    expect_good(fitted, samples, {});
    if (!fitted.ok()) continue;
    for (double s = 35; s < fitted->road.length_m() - 35; s += 1) {
      ASSERT_NEAR(pose_at(fitted->road, s, 0).curvature_per_m, 1 / radius, 0.6 / radius) << radius << ' ' << s;
    }
  }
}

TEST(Fit, AnchorsGiveTheRoadAgain) {
  std::vector<Sample> samples = curve(1500, 3, winding);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].elevation_m = std::sin(0.02 * static_cast<double>(i));
  const Result<FittedRoad> fitted = fit_road(samples, {});
  ASSERT_TRUE(fitted.ok());
  AlignmentOptions options;
  options.tight = TightPolicy::kNarrow;
  const Result<Road> again = road_from_anchors(fitted->anchors, options);
  ASSERT_TRUE(again.ok());
  ASSERT_EQ(again->segments.size(), fitted->road.segments.size());
  for (std::size_t i = 0; i < again->segments.size(); ++i) {
    const Segment &a = again->segments[i], &b = fitted->road.segments[i];
    EXPECT_EQ(a.start_m, b.start_m);
    EXPECT_EQ(a.slope_start, b.slope_start);
    EXPECT_EQ(a.elevation_m.c0, b.elevation_m.c0);
    EXPECT_EQ(a.elevation_m.c1, b.elevation_m.c1);
  }
}

TEST(Fit, IsTheSameInEveryRun) {
  std::vector<Sample> samples = curve(600, 2, winding);
  add_noise(samples, 0.02, 12);
  const Result<FittedRoad> first = fit_road(samples, {}), second = fit_road(samples, {});
  ASSERT_TRUE(first.ok() && second.ok());
  ASSERT_EQ(first->anchors.size(), second->anchors.size());
  for (std::size_t i = 0; i < first->anchors.size(); ++i) {
    EXPECT_EQ(first->anchors[i].position_m, second->anchors[i].position_m);
    EXPECT_EQ(first->anchors[i].heading_rad, second->anchors[i].heading_rad);
  }
}

// Joints pushed off a known chain of cubics return to it, when its points are the samples.
TEST(SolveJoints, ReturnToTheCurveOfTheSamples) {
  std::mt19937_64 random(15);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const bool closed : {false, true}) {
    std::vector<Joint> joints;
    for (int i = 0; i < 8; ++i) {
      const double angle = 2 * M_PI * i / 8;
      joints.push_back({(60 + 5 * uniform(random)) * direction(angle), angle + M_PI / 2 + 0.1 * uniform(random)});
    }
    std::vector<std::vector<glm::dvec2>> points;
    const std::vector<double> weight(30, 1);
    std::vector<SegmentSamples> samples;
    for (std::size_t i = 0; i + (closed ? 0 : 1) < joints.size(); ++i) {
      const Joint &from = joints[i], &to = joints[(i + 1) % joints.size()];
      const Segment s = make_segment(from.position_m, to.position_m, from.heading_rad, to.heading_rad, 3);
      points.emplace_back();
      for (int k = 0; k < 30; ++k) points.back().push_back(position_m(s, (k + 0.5) / 30));
    }
    for (const std::vector<glm::dvec2>& p : points) samples.push_back({p, weight});
    std::vector<Joint> pushed = joints;
    for (Joint& j : pushed) {
      j.position_m += 0.3 * uniform(random) * direction(j.heading_rad + M_PI / 2);
      j.heading_rad += 0.03 * uniform(random);
    }
    // A small error leaves next to nothing to fairness.
    fit_solver().value()->solve_joints(pushed, samples, closed, 1e-5);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      // Along the curve a joint may stay where it was pushed.
      const glm::dvec2 normal = direction(joints[i].heading_rad + M_PI / 2);
      EXPECT_NEAR(glm::dot(pushed[i].position_m - joints[i].position_m, normal), 0, 2e-4);
      EXPECT_NEAR(pushed[i].heading_rad, std::remainder(joints[i].heading_rad, 2 * M_PI), 2e-4);
    }
  }
}

// A ring's profile does not know where s begins.
TEST(FitProfile, OfARingDoesNotDependOnItsStart) {
  constexpr double kLength = 1200;
  constexpr int kKnots = 12, kSamples = 240;
  const auto height = [](double s) { return 10 + 8 * std::sin(2 * M_PI * s / kLength) + std::cos(s / 31); };
  const auto fitted = [&](double start) {
    std::vector<double> knots;
    for (int i = 0; i < kKnots; ++i) knots.push_back(std::fmod(100.0 * i + 1200 - start, kLength));
    std::sort(knots.begin(), knots.end());
    std::vector<HeightSample> samples;
    for (int i = 0; i < kSamples; ++i) {
      const double s = 5.0 * i + 2;
      samples.push_back({std::fmod(s + kLength - start, kLength), height(s)});
    }
    return fit_profile(knots, samples, true, kLength, 1.2);
  };
  const ProfileFit first = fitted(0), other = fitted(300);
  EXPECT_LE(first.max_error_m, 1.2);
  for (std::size_t i = 0; i < kKnots; ++i) {
    EXPECT_NEAR(first.z_m[(i + 3) % kKnots], other.z_m[i], 1e-9);
    EXPECT_NEAR(first.grade[(i + 3) % kKnots], other.grade[i], 1e-11);
  }
}

TEST(FitHeights, QuantizedStepsMakeNoBumps) {
  // A constant slope of 3 %, measured in whole metres: the true profile has no bends.
  std::vector<Sample> samples = curve(1500, 5, winding);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].elevation_m = std::round(0.15 * static_cast<double>(i));
  const Result<FittedRoad> fitted = fit_road(samples, {});
  ASSERT_TRUE(fitted.ok());
  EXPECT_LE(fitted->certificate.max_elevation_error_m, 1.0);
  for (double s = 0; s < fitted->road.length_m(); s += 3) {
    EXPECT_NEAR(std::tan(pose_at(fitted->road, s, 0).pitch_rad), 0.03, 0.006) << s;
  }
}

TEST(FitHeights, FollowHillsThatThePlanViewDoesNotShow) {
  std::vector<Sample> samples;
  for (int i = 0; i <= 400; ++i) samples.push_back({{5.0 * i, 0}, 20 * std::sin(i / 20.0), 3});
  FitOptions options;
  options.max_elevation_error_m = 0.3;
  const Result<FittedRoad> fitted = fit_road(samples, options);
  expect_good(fitted, samples, options);
  EXPECT_LE(fitted->certificate.max_elevation_error_m, 0.3);
  EXPECT_LT(fitted->anchors.size(), 80u);
  EXPECT_LT(checked(fitted->road).worst.grade, 1e-9);
}

TEST(FitHeights, ImpossibleOnesAreLeftOutWithAWarning) {
  std::vector<Sample> samples = curve(1000, 10, winding);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i].elevation_m = 100 + 0.2 * static_cast<double>(i);
  samples[0].elevation_m = 0;
  samples[40].elevation_m = 0;
  samples[41].elevation_m = 300;
  Diagnostics diagnostics;
  const Result<FittedRoad> fitted = fit_road(samples, {}, &diagnostics);
  ASSERT_TRUE(fitted.ok());
  for (double s = 0; s < fitted->road.length_m(); s += 3) {
    EXPECT_NEAR(pose_at(fitted->road, s, 0).position_m.z, 100 + 0.02 * s, 1.5) << s;
  }
  const bool told = std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) {
    return d.message.find("3 of 101 heights") != std::string::npos;
  });
  EXPECT_TRUE(told);
}

TEST(Certify, MeasuresAShiftedRoad) {
  const std::vector<Sample> samples = curve(500, 2, bend);
  FitOptions options;
  options.max_error_m = 0.01;
  const Result<FittedRoad> fitted = fit_road(samples, options);
  ASSERT_TRUE(fitted.ok());
  std::vector<Sample> shifted;
  for (std::size_t i = 1; i + 1 < samples.size(); ++i) {
    const glm::dvec2 d = glm::normalize(samples[i + 1].position_m - samples[i - 1].position_m);
    shifted.push_back({samples[i].position_m + 2.5 * glm::dvec2(-d.y, d.x), 0.7, 3});
  }
  const Certificate c = certify(fitted->road, shifted, 5);
  EXPECT_NEAR(c.max_error_m, 2.5, 0.011);
  EXPECT_NEAR(c.rms_error_m, 2.5, 0.011);
  EXPECT_NEAR(c.max_elevation_error_m, 0.7, 1e-6);
  EXPECT_EQ(c.anchors, 5u);
  EXPECT_NEAR(c.source_to_curve_m, 2.5, 0.02);
  // The road goes on for two metres beyond the first and the last sample.
  EXPECT_NEAR(c.curve_to_source_m, std::hypot(2.5, 2), 0.05);
}

// A figure of eight with a bridge: heights are compared on the strand that the sample belongs to.
TEST(Certify, KeepsToItsStrandWhereTheRoadCrossesItself) {
  std::vector<Sample> samples;
  for (int i = 0; i < 300; ++i) {
    const double t = 2 * M_PI * i / 300;
    samples.push_back({{150 * std::sin(t), 80 * std::sin(2 * t)}, 6 * std::cos(t), 3});
  }
  FitOptions options;
  options.closed = true;
  const Result<FittedRoad> fitted = fit_road(samples, options);
  expect_good(fitted, samples, options);
  EXPECT_LT(fitted->certificate.max_elevation_error_m, 1.0);
}

// Random walks with repetitions, some of them sharp zigzags, and rough loops.
std::vector<Sample> random_samples(std::mt19937_64& random, bool loop, double turn_rad) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(0, 1);
  const double repeat = 0.2 * uniform(random), radius = 100 + 200 * uniform(random);
  const auto count = static_cast<std::size_t>((loop ? 8 : 1) + 80 * uniform(random));
  std::vector<Sample> samples;
  glm::dvec2 p(0);
  double heading = 0, angle = 0;
  for (std::size_t k = 0; k < count; ++k) {
    samples.push_back({p, 3 * normal(random), 2 + uniform(random)});
    if (uniform(random) < repeat) continue;
    heading += turn_rad * normal(random);
    angle += 2 * M_PI / static_cast<double>(count);
    p = loop ? radius * (1 + 0.1 * turn_rad * normal(random)) * direction(angle)
             : p + (1 + 40 * uniform(random)) * direction(heading);
  }
  return samples;
}

TEST(Fit, EndsMayBeFixed) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const std::vector<Sample> truth = curve(600, 5, winding);
    std::vector<Sample> samples = truth;
    add_noise(samples, 0.03, seed);
    FitOptions options{.max_error_m = 0.1};
    const auto pose = [&](std::size_t from, std::size_t to, std::size_t at) {
      const glm::dvec2 d = truth[to].position_m - truth[from].position_m;
      return FixedEnd{truth[at].position_m, std::atan2(d.y, d.x) + 0.01};
    };
    options.start = pose(0, 1, 0);
    options.end = pose(truth.size() - 2, truth.size() - 1, truth.size() - 1);
    const auto fitted = fit_road(samples, options);
    ASSERT_TRUE(fitted.ok()) << fitted.error().text();
    const Road& road = fitted->road;
    EXPECT_LT(glm::distance(road.segments.front().start_m, options.start->position_m), 1e-12);
    EXPECT_LT(glm::distance(road.segments.back().end_m, options.end->position_m), 1e-12);
    EXPECT_NEAR(std::remainder(heading_rad(road.segments.front(), 0) - options.start->heading_rad, 2 * M_PI), 0, 1e-12);
    EXPECT_NEAR(std::remainder(heading_rad(road.segments.back(), 1) - options.end->heading_rad, 2 * M_PI), 0, 1e-12);
    EXPECT_LE(fitted->certificate.max_error_m, 0.1);
    EXPECT_TRUE(checked(road).problems.empty());
  }
  FitOptions closed{.closed = true};
  closed.start = FixedEnd{};
  EXPECT_FALSE(fit_road(circle(40, 60), closed).ok());
}

// Five samples in a hundred are off by 1 to 8 m, some side by side, up to 60 degrees askew to the road's normal: one that
// is only too far along the road is still on it.
struct Spoilt {
  std::vector<Sample> samples, clean;
  std::vector<std::size_t> bad;
};
Spoilt spoilt(const std::function<double(double)>& curvature, double spacing_m, unsigned seed) {
  Spoilt s;
  s.samples = curve(600, spacing_m, curvature);
  add_noise(s.samples, 0.02, seed);
  s.clean = s.samples;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (std::size_t i = 1; i + 1 < s.samples.size(); ++i) {
    if (uniform(random) > 0.05) continue;
    const glm::dvec2 ahead = s.clean[i + 1].position_m - s.clean[i - 1].position_m;
    const double across = std::atan2(ahead.y, ahead.x) + (uniform(random) < 0.5 ? -M_PI / 2 : M_PI / 2);
    s.samples[i].position_m += (1 + 7 * uniform(random)) * direction(across + M_PI / 3 * (2 * uniform(random) - 1));
    s.bad.push_back(i);
  }
  return s;
}

TEST(Fit, OutliersMayBeLeftOut) {
  std::size_t planted = 0, found = 0, wrongly = 0;
  for (const auto& curvature : {std::function<double(double)>(bend), std::function<double(double)>(winding)}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const Spoilt s = spoilt(curvature, 4, seed);
      Diagnostics diagnostics;
      const auto fitted = fit_road(s.samples, {.max_error_m = 0.1, .reject_outliers = true}, &diagnostics);
      ASSERT_TRUE(fitted.ok()) << fitted.error().text();
      // The certificate is that of the rest, and of the truth.
      EXPECT_LE(fitted->certificate.max_error_m, 0.1);
      EXPECT_EQ(fitted->certificate.samples + fitted->certificate.outliers, s.samples.size());
      const Certificate truth = certify(fitted->road, s.clean, 0);
      EXPECT_LT(truth.max_error_m, 0.5) << "seed " << seed;
      if (!s.bad.empty()) {
        EXPECT_GT(fitted->certificate.greatest_outlier_m, 0.9);
        ASSERT_FALSE(diagnostics.empty());
        EXPECT_NE(diagnostics[0].message.find("left out of the fit, numbers "), std::string::npos);
      }
      // Which they are, by the numbers that users are told.
      std::vector<glm::dvec2> positions;
      for (const Sample& sample : s.samples) positions.push_back(sample.position_m);
      const std::vector<char> outlier = fit_solver().value()->find_outliers(positions, false, 0.1);
      planted += s.bad.size();
      for (std::size_t i = 0; i < outlier.size(); ++i) {
        const bool bad = std::binary_search(s.bad.begin(), s.bad.end(), i);
        found += bad && outlier[i];
        wrongly += !bad && outlier[i];
      }
      // Without it the road passes them all.
      const auto plain = fit_road(s.samples, {.max_error_m = 0.1});
      if (plain.ok() && !s.bad.empty()) {
        EXPECT_GT(certify(plain->road, s.clean, 0).max_error_m, 0.5);
      }
    }
  }
  std::printf("%zu outliers planted, %zu found, %zu wrongly\n", planted, found, wrongly);
  EXPECT_GE(static_cast<double>(found), 0.97 * static_cast<double>(planted));
  EXPECT_EQ(wrongly, 0u);
}

TEST(Fit, NoGoodSampleIsAnOutlier) {
  for (const auto& curvature : {std::function<double(double)>(bend), std::function<double(double)>(hairpin),
                                std::function<double(double)>(winding)}) {
    for (const double spacing : {2.0, 5.0, 12.0, 40.0}) {
      std::vector<Sample> samples = curve(600, spacing, curvature);
      add_noise(samples, 0.03, 5);
      const auto fitted = fit_road(samples, {.max_error_m = 0.1, .reject_outliers = true});
      ASSERT_TRUE(fitted.ok()) << fitted.error().text();
      EXPECT_EQ(fitted->certificate.outliers, 0u) << spacing;
    }
  }
  const auto ring = fit_road(circle(40, 60), {.closed = true, .reject_outliers = true});
  ASSERT_TRUE(ring.ok());
  EXPECT_EQ(ring->certificate.outliers, 0u);
}

TEST(Fit, AnyFiniteSamplesGiveARoadOrAnError) {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> uniform(0, 1);
  int tame = 0, tame_roads = 0;
  for (int i = 0; i < 400; ++i) {
    FitOptions options;
    options.closed = i % 3 == 0;
    options.tangents = i % 4 == 0 ? TangentSource::kCatmullRom : TangentSource::kFit;
    const double turn = std::pow(10, -2 + 2.3 * uniform(random));
    // Every tenth loop is no loop at all.
    const std::vector<Sample> samples = random_samples(random, options.closed && i % 10 != 0, turn);
    const Result<FittedRoad> fitted = fit_road(samples, options);
    const bool is_tame = turn < 0.3 && samples.size() > 4 && !(options.closed && i % 10 == 0);
    tame += is_tame;
    if (!fitted.ok()) {
      EXPECT_FALSE(fitted.error().message.empty());
      continue;
    }
    tame_roads += is_tame;
    const CheckReport report = checked(fitted->road);
    ASSERT_TRUE(report.ok()) << i << ": " << report.problems.front();
    EXPECT_LE(fitted->certificate.max_error_m, options.max_error_m) << i << ", turn " << turn;
  }
  EXPECT_GT(tame_roads, 0.95 * tame);
}

TEST(Fit, BadInputIsNamed) {
  const auto message = [](std::vector<Sample> samples, FitOptions options = {}) {
    const Result<FittedRoad> fitted = fit_road(samples, options);
    return fitted.ok() ? std::string("no error") : fitted.error().text();
  };
  EXPECT_NE(message({{{0, 0}}, {{1, std::nan("")}}}).find("sample 1"), std::string::npos);
  EXPECT_NE(message({{{0, 0}}, {{5, 5}, 0, 0}}).find("sample 1"), std::string::npos);
  EXPECT_NE(message({{{3, 3}}, {{3, 3}}}).find("at least two"), std::string::npos);
  EXPECT_NE(message({}).find("at least two"), std::string::npos);
  FitOptions options;
  options.max_error_m = 0;
  EXPECT_NE(message({{{0, 0}}, {{1, 1}}}, options).find("positive"), std::string::npos);
}

TEST(Fit, TwoSamplesAreAStraightRoad) {
  const std::vector<Sample> samples = {{{0, 0}, 1, 3}, {{30, 40}, 2, 3}};
  const Result<FittedRoad> fitted = fit_road(samples, {});
  expect_good(fitted, samples, {});
  EXPECT_EQ(fitted->road.segments.size(), 1u);
  EXPECT_NEAR(fitted->road.length_m(), 50, 1e-6);
}

TEST(Fit, HundredThousandSamplesTakeSeconds) {
  std::vector<Sample> samples = curve(100000, 1, winding);
  add_noise(samples, 0.02, 14);
  const auto start = std::chrono::steady_clock::now();
  const Result<FittedRoad> fitted = fit_road(samples, {});
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  ASSERT_TRUE(fitted.ok()) << fitted.error().text();
  EXPECT_LE(fitted->certificate.max_error_m, 0.1);
  EXPECT_TRUE(checked(fitted->road).ok());
  EXPECT_LT(taken.count(), 60);  // 8 s on one slow core without load, without optimization
}

}  // namespace
}  // namespace roadgen
