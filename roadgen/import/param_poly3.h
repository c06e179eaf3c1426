// OpenDRIVE's parametric cubic as a segment of the road function.
#pragma once

#include <glm/vec2.hpp>

#include "roadgen/road/result.h"
#include "roadgen/road/segment.h"

namespace roadgen {

// start + b p + c p^2 + d p^3 for p in [0, 1], in world metres.
struct ParametricCubic {
  glm::dvec2 start_m{0, 0};
  glm::dvec2 b_m{0, 0}, c_m{0, 0}, d_m{0, 0};

  // The curve with p = k q instead of p, so that p in [0, k] becomes q in [0, 1].
  ParametricCubic rescaled(double k) const { return {start_m, b_m * k, c_m * (k * k), d_m * (k * k * k)}; }
  // Turned about its start by angle_rad, counter-clockwise.
  ParametricCubic turned(double angle_rad) const;
};

// How far, in metres, a parametric cubic may run ahead of or behind the graph over its chord that a segment is.
inline constexpr double kGraphTolerance_m = 1e-7;
// Steepest tangent against the chord that is read (89.4 degrees).
inline constexpr double kSteepestSlope = 100;

// The segment that is this curve, without profiles: arc set, bound not. The curve must be the graph of a cubic over its
// chord, that is, advance along the chord in proportion to p.
// Errors: kGeometry where it has no length, is not such a graph within kGraphTolerance_m, is steeper than
// kSteepestSlope, or is not finite or beyond 1e9 m.
Result<Segment> segment_from_cubic(const ParametricCubic& curve);

}  // namespace roadgen
