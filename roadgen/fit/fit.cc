#include "roadgen/fit/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include <glm/geometric.hpp>

#include "roadgen/fit/curve_fit.h"
#include "roadgen/fit/locate.h"
#include "roadgen/fit/profile.h"
#include "roadgen/fit/solver.h"

namespace roadgen {
namespace {

// Rounds of adding anchors where the heights need knots that the plan view does not.
constexpr int kMostProfileRounds = 12;

void warn(Diagnostics* diagnostics, std::string message) {
  if (diagnostics) diagnostics->push_back({Severity::kWarning, std::move(message)});
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", x);
  return text;
}

Status check_samples(std::span<const Sample> samples, const FitOptions& options) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Sample& s = samples[i];
    for (const double x : {s.position_m.x, s.position_m.y, s.elevation_m, s.half_width_m}) {
      if (std::abs(x) <= kGreatestCoordinate_m) continue;
      return Error{ErrorCode::kData, "sample " + std::to_string(i) +
                                         " has a coordinate, height or width that is not a "
                                         "finite number below " +
                                         number(kGreatestCoordinate_m) + "; correct or remove it"};
    }
    if (!(s.half_width_m > 0)) {
      return Error{ErrorCode::kData, "sample " + std::to_string(i) + " has a half width that is not positive"};
    }
  }
  for (const auto& end : {options.start, options.end}) {
    if (!end) continue;
    if (options.closed || options.tangents != TangentSource::kFit) {
      return Error{ErrorCode::kUsage, "only open roads of fitted tangents have fixed ends"};
    }
    if (!std::isfinite(end->position_m.x + end->position_m.y + end->heading_rad)) {
      return Error{ErrorCode::kUsage, "a fixed end is not finite"};
    }
  }
  if (!(options.max_error_m > 0) || !(options.max_elevation_error_m > 0)) {
    return Error{ErrorCode::kUsage, "the greatest allowed errors must be positive"};
  }
  return Done{};
}

// Without samples that repeat the one before.
std::vector<Sample> distinct(std::span<const Sample> samples, bool closed, Diagnostics* diagnostics) {
  const double least_m = AlignmentOptions{}.least_distance_m;
  std::vector<Sample> kept;
  for (const Sample& s : samples) {
    if (kept.empty() || glm::length(s.position_m - kept.back().position_m) > least_m) kept.push_back(s);
  }
  while (closed && kept.size() > 1 && !(glm::length(kept.back().position_m - kept.front().position_m) > least_m)) {
    kept.pop_back();
  }
  const std::size_t left_out = samples.size() - kept.size();
  if (left_out > 0) {
    warn(diagnostics, std::to_string(left_out) + " of " + std::to_string(samples.size()) +
                          " samples repeat the one before within " + number(least_m) + " m: left out of the fit");
  }
  return kept;
}

// Takes the outliers out of the samples.
std::vector<Sample> taken_out(const FitSolver& solver, std::vector<Sample>& samples, const FitOptions& options,
                              Diagnostics* diagnostics) {
  constexpr std::size_t kMostNamed = 12;
  // Samples that repeat others have no course.
  std::vector<glm::dvec2> positions;
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!positions.empty() && samples[i].position_m == positions.back()) continue;
    positions.push_back(samples[i].position_m);
    of.push_back(i);
  }
  const std::vector<char> outlier = solver.find_outliers(positions, options.closed, options.max_error_m);
  std::vector<char> is_out(samples.size(), 0);
  std::string named;
  std::vector<Sample> out, in;
  for (std::size_t k = 0; k < of.size(); ++k) is_out[of[k]] = outlier[k];
  for (std::size_t i = 0; i < samples.size(); ++i) {
    (is_out[i] ? out : in).push_back(samples[i]);
    if (is_out[i] && out.size() <= kMostNamed) named += (named.empty() ? "" : ", ") + std::to_string(i + 1);
  }
  if (!out.empty()) {
    warn(diagnostics, std::to_string(out.size()) + " of " + std::to_string(samples.size()) +
                          " samples lie off the course of their neighbours: left out of the fit, numbers " + named +
                          (out.size() > kMostNamed ? ", ..." : ""));
  }
  samples = std::move(in);
  return out;
}

AlignmentOptions alignment_options(const FitOptions& options) {
  AlignmentOptions alignment;
  if (options.tangents == TangentSource::kCatmullRom) alignment.tangents = options.catmull_rom;
  alignment.closed = options.closed;
  alignment.mapping_tolerance = options.mapping_tolerance;
  alignment.tight = options.tight;
  // Anchors are chosen from distinct samples but may slide; none is to be lost.
  alignment.least_distance_m = 0;
  return alignment;
}

// Arc length of every anchor on the road that passes them in order.
std::vector<double> stations(const Road& road, std::span<const Anchor> anchors) {
  std::vector<double> s_m;
  for (const Segment& segment : road.segments) {
    if (s_m.size() < anchors.size() && segment.start_m == anchors[s_m.size()].position_m) {
      s_m.push_back(segment.s_start_m);
    }
  }
  if (!road.closed) s_m.push_back(road.length_m());
  return s_m;
}

// The middle sample of every interval between knots that holds one above the error. Halving ends soon, where the worst
// sample, often beside a knot, would not.
std::vector<std::size_t> samples_for_knots(std::span<const double> knots_m, std::span<const HeightSample> samples,
                                           const ProfileFit& fit, double max_error_m) {
  std::vector<std::vector<std::size_t>> held(knots_m.size() + 1);
  std::vector<char> misses(knots_m.size() + 1, 0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto interval =
        static_cast<std::size_t>(std::upper_bound(knots_m.begin(), knots_m.end(), samples[i].s_m) - knots_m.begin());
    held[interval].push_back(i);
    if (fit.error_m[i] > max_error_m) misses[interval] = 1;
  }
  std::vector<std::size_t> middle;
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (misses[k]) middle.push_back(held[k][held[k].size() / 2]);
  }
  return middle;
}

// The measured heights along a road, and which samples they are; without those that no road follows.
struct Heights {
  std::vector<HeightSample> samples;
  std::vector<std::size_t> index;
};

Heights heights_along(const Road& road, std::span<const Sample> samples, double max_error_m) {
  const std::vector<Located> located = locate(road, samples);
  std::vector<HeightSample> all;
  for (std::size_t i = 0; i < samples.size(); ++i) all.push_back({located[i].s_m, samples[i].elevation_m});
  const std::vector<char> plausible = plausible_heights(all, max_error_m);
  Heights heights;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (!plausible[i]) continue;
    heights.samples.push_back(all[i]);
    heights.index.push_back(i);
  }
  return heights;
}

// Gives the anchors heights and grades, and the curve more anchors where the heights need them.
Result<std::vector<Anchor>> fit_heights(CurveFit& curve, std::span<const Sample> samples, const FitOptions& options,
                                        Diagnostics* diagnostics) {
  AlignmentOptions alignment = alignment_options(options);
  std::size_t before = 0;
  for (int round = 0;; ++round) {
    std::vector<Anchor> anchors = curve.anchors();
    Result<Road> road = road_from_anchors(anchors, alignment);
    if (!road) return road.error();
    const std::vector<double> knots = stations(*road, anchors);
    const Heights heights = heights_along(*road, samples, options.max_elevation_error_m);
    const double limit = options.max_elevation_error_m * (1 - 1e-6);
    const ProfileFit fit = fit_profile(knots, heights.samples, options.closed, road->length_m(), limit);
    const bool stuck = round > 0 && anchors.size() == before;
    if (fit.max_error_m <= limit || stuck || round == kMostProfileRounds) {
      for (std::size_t i = 0; i < anchors.size(); ++i) {
        anchors[i].elevation_m = fit.z_m[i];
        anchors[i].grade = fit.grade[i];
      }
      if (const std::size_t wrong = samples.size() - heights.index.size(); wrong > 0) {
        warn(diagnostics, std::to_string(wrong) + " of " + std::to_string(samples.size()) +
                              " heights would make the road steeper than " + number(kSteepestGrade) +
                              ": left out of the fit");
      }
      return anchors;
    }
    before = anchors.size();
    std::vector<std::size_t> added = samples_for_knots(knots, heights.samples, fit, limit);
    for (std::size_t& i : added) i = heights.index[i];
    curve.add_on_curve(added);
  }
}

}  // namespace

Result<FittedRoad> fit_road(std::span<const Sample> all, const FitOptions& options, Diagnostics* diagnostics) {
  if (Status s = check_samples(all, options); !s) return s.error();
  const Result<const FitSolver*> solver = fit_solver();
  if (!solver) return solver.error();
  std::vector<Sample> samples(all.begin(), all.end()), outliers;
  if (options.reject_outliers) outliers = taken_out(**solver, samples, options, diagnostics);
  const std::vector<Sample> kept = distinct(samples, options.closed, diagnostics);
  if (kept.size() < 2) {
    return Error{ErrorCode::kData, "a road needs at least two distinct samples; " + std::to_string(samples.size()) +
                                       " given, " + std::to_string(kept.size()) + " distinct"};
  }
  CurveFit curve(**solver, kept, options);
  curve.run();
  Result<std::vector<Anchor>> anchors = fit_heights(curve, kept, options, diagnostics);
  if (!anchors) return anchors.error();
  Result<Road> road = road_from_anchors(*anchors, alignment_options(options), diagnostics);
  if (!road) return road.error();
  Certificate certificate = certify(*road, samples, anchors->size());
  if (!outliers.empty()) {
    certificate.outliers = outliers.size();
    certificate.greatest_outlier_m = certify(*road, outliers, 0).max_error_m;
  }
  const std::pair<const char*, std::pair<double, double>> promises[] = {
      {"horizontal", {certificate.max_error_m, options.max_error_m}},
      {"vertical", {certificate.max_elevation_error_m, options.max_elevation_error_m}}};
  for (const auto& [what, error] : promises) {
    if (error.first <= error.second) continue;
    warn(diagnostics, std::string("the ") + what + " error reaches " + number(error.first) + " m, above the " +
                          number(error.second) + " m allowed");
  }
  return FittedRoad{std::move(road).value(), std::move(anchors).value(), std::move(certificate)};
}

}  // namespace roadgen
