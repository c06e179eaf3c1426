// The least-squares problem of the fit: joints are moved and turned so that the samples lie on the road function's
// v = 0. Internal to roadgen/fit; the only user of Ceres is least_squares.cc.
#pragma once

#include <span>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

// Where two segments meet.
struct Joint {
  glm::dvec2 position_m{0, 0};
  double heading_rad = 0;
  bool fixed_position = false;
  bool fixed_heading = false;
};

// The samples that the footprint of one segment holds, and the weight of each.
struct SegmentSamples {
  std::span<const glm::dvec2> position_m;
  std::span<const double> weight;  // as many
};

// Minimizes, over the positions and headings of the joints that are not fixed,
//   sum over samples of (weight v)^2, v in metres by the road function (glsl::Library::road_project), differentiated
//     automatically,
//   + sum over joints of (kSlideWeight * shift along the tangent)^2, since samples hardly determine that shift,
//   + sum over inner joints of (max_error_m / kCurvatureScale_m * L L' * curvature jump)^2 and over segments of
//     (max_error_m / kArcScale_m * L^2 * curvature change)^2, which keep the curve fair between sparse samples: a jump
//     by which the curves would part by kCurvatureScale_m / 2 over L counts like a sample at the greatest error.
// segments[i] lies between joints[i] and joints[i + 1]; a closed chain has as many segments as joints and wraps, an open
// one less one. Segments whose tangents are more than about 75 degrees off the chord take no part by their samples.
// No joint moves by more than a quarter of the shorter chord beside it. Deterministic.
// Cost: about 10 passes over the samples.
void solve_joints(std::span<Joint> joints, std::span<const SegmentSamples> segments, bool closed, double max_error_m);

inline constexpr double kSlideWeight = 1;
inline constexpr double kCurvatureScale_m = 2;
inline constexpr double kArcScale_m = 20;

}  // namespace roadgen
