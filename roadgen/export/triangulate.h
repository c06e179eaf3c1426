// Triangles of polygons, by GEOS. Internal to roadgen/export.
#pragma once

#include <array>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

// Constrained Delaunay triangles of a simple polygon, counter-clockwise; no vertices but the ring's, which keep their
// bits. Empty where GEOS finds none.
std::vector<std::array<glm::dvec2, 3>> triangulated(const std::vector<glm::dvec2>& ring);

}  // namespace roadgen
