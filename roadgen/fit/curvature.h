// Headings that make the curvature of a chain of segments continuous. Internal to roadgen/fit.
#pragma once

#include <cstddef>
#include <optional>
#include <span>

#include <glm/vec2.hpp>

namespace roadgen {

// Changes the headings (radians, at every point) so that the graph cubics of shaders/lib/road.glsl between the points
// have the same curvature on both sides of every point, to kCurvatureResidual over the length of a segment. Headings
// marked as fixed stay, and the curvature may jump there. At the ends of an open chain curvature is 0 (the natural
// spline) where the heading is not fixed; a closed chain goes on from the last point to the first.
// Newton's method with halved steps on the tridiagonal (closed: cyclic) system, from the headings given.
// Returns the point whose curvatures differ most, and leaves the headings as they were, where it does not converge in
// kMostCurvatureSteps with tangents at most 60 degrees off their chords. From headings up to some 35 degrees off it
// usually does.
// Requires: at least two points, no two consecutive equal; fixed and headings_rad as many.
// Cost: O(points) for each of usually four steps.
std::optional<std::size_t> equalize_curvature(std::span<const glm::dvec2> points_m, std::span<const char> fixed,
                                              bool closed, std::span<double> headings_rad);
inline constexpr double kCurvatureResidual = 1e-12;
inline constexpr int kMostCurvatureSteps = 50;

}  // namespace roadgen
