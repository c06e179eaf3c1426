#include "roadgen/import/param_poly3.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kGreatest_m = 1e9;

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

bool is_usable(glm::dvec2 v) { return std::abs(v.x) <= kGreatest_m && std::abs(v.y) <= kGreatest_m; }

}  // namespace

ParametricCubic ParametricCubic::turned(double angle_rad) const {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const auto turn = [&](glm::dvec2 v) { return glm::dvec2(c * v.x - s * v.y, s * v.x + c * v.y); };
  return {start_m, turn(b_m), turn(c_m), turn(d_m)};
}

Result<Segment> segment_from_cubic(const ParametricCubic& curve) {
  if (!is_usable(curve.start_m) || !is_usable(curve.b_m) || !is_usable(curve.c_m) || !is_usable(curve.d_m)) {
    return Error{ErrorCode::kGeometry, "the geometry is beyond 1e9 m"};
  }
  Segment segment;
  segment.start_m = curve.start_m;
  segment.end_m = curve.start_m + (curve.b_m + curve.c_m + curve.d_m);
  const glm::dvec2 chord = segment.chord_m();
  const double length = glm::length(chord);
  if (!(length > 1e-9)) return Error{ErrorCode::kGeometry, "the geometry starts and ends at the same point"};

  // Along the chord the curve must be linear in p: no part of c and d.
  const double ahead = (std::abs(glm::dot(chord, curve.c_m)) + std::abs(glm::dot(chord, curve.d_m))) / length;
  if (ahead > kGraphTolerance_m) {
    return Error{ErrorCode::kGeometry,
                 "a paramPoly3 that is not the graph of a cubic over its chord is not supported yet"};
  }
  const glm::dvec2 tangent = curve.b_m + 2.0 * curve.c_m + 3.0 * curve.d_m;
  segment.slope_start = cross(chord, curve.b_m) / glm::dot(chord, curve.b_m);
  segment.slope_end = cross(chord, tangent) / glm::dot(chord, tangent);
  if (!(std::abs(segment.slope_start) <= kSteepestSlope && std::abs(segment.slope_end) <= kSteepestSlope)) {
    return Error{ErrorCode::kGeometry,
                 "the paramPoly3 turns by nearly 90 degrees or more from its chord, which is not supported yet"};
  }
  set_arc(segment);
  return segment;
}

}  // namespace roadgen
