// Internal, not installed: a convex polyhedron around the part of a quadric that lies in its box, to draw.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/object/primitive.h"

namespace roadgen {

// In the shape's frame, closed; triangles counter-clockwise from outside.
struct ConvexHull {
  std::vector<glm::dvec3> corners;
  std::vector<std::array<std::uint16_t, 3>> triangles;
};

// How far beyond the quadric the hull's planes are, of the box's half size.
inline constexpr double kHullRoom = 1e-5;

// The planes touch the quadric, or the solid that it and the box enclose, but for kHullRoom: those along the box's axes,
// edges and diagonals and along the quadric's own axes, of which those that cut off little are left out.
// Requires: the shape of a primitive of kind kQuadric. Where it does not meet its box: the box. Cost: about 100 us.
ConvexHull quadric_hull(const ObjectLib::ObjectShape& shape);

}  // namespace roadgen
