// First guesses of the fit from samples alone: one cubic over a run of samples, and the heading at a sample.
// Internal to roadgen/fit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

// The graph cubic through the first and last of a run of samples, nearest in least squares to those between.
struct ChordFit {
  double slope_start = 0, slope_end = 0;
  double error_m = 0;   // greatest distance of a sample, to first order
  bool usable = false;  // the samples advance along the chord, and the slopes are at most kMostGuessSlope
};
inline constexpr double kMostGuessSlope = 0.8;  // leaves room for the joints to turn

// Requires: at least two samples. Cost: O(samples).
ChordFit chord_fit(std::span<const glm::dvec2> samples_m);

// Indices of samples to begin with as anchors, first and last among them: each next one is the farthest that a cubic
// reaches within error_m. Cost: O(n log n).
std::vector<std::size_t> thin(std::span<const glm::dvec2> samples_m, double error_m);

// Heading at samples_m[at] of a curve through it, the first and the last; one-sided where it is one of them. Where the
// samples double back it turns left. Requires: distinct samples.
double local_heading(std::span<const glm::dvec2> samples_m, std::size_t at);

}  // namespace roadgen
