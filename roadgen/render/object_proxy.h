// Internal, not installed: the meshes that cover primitives on the screen, in the primitives' own frames.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/object/primitive.h"

namespace roadgen {

// Closed hulls have their triangles counter-clockwise from outside.
struct ProxyMesh {
  std::vector<glm::vec3> corners;
  std::vector<std::uint16_t> elements;
};
// Empty for kHull, which is not one for all. sides: of polygons, >= 3; 4 gives squares whose sides follow the axes. Corners of
// kOutline and kRing are what NAME_outline takes.
ProxyMesh proxy_mesh(Proxy proxy, int sides);

// Triangles of `count` polygons of that many corners each, whose vertices follow one another. Requires: at most 65,536
// vertices.
std::vector<std::uint16_t> polygon_elements(int corners, std::uint32_t count);

}  // namespace roadgen
