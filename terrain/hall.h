// Junctions' areas in tunnels, under ground that is higher: the hill is kept over them as over the tunnels that meet there.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/query/box_tree.h"
#include "roadgen/road/junction.h"

namespace roadgen {

// A hall has no vault of its own: between its floor and the ground above there is nothing.
struct Hall {
  JunctionSurface surface;  // its floor
  double height_m = 0;      // of the highest vault that leads into it, outside, above the floor

  // Whether the point is in it: over the area and less than height_m above the floor, however deep.
  bool is_above(glm::dvec3 point_m) const;
  Box box() const;  // z: 0
};

// Whether the ground is cover_m higher than the hall everywhere over its area, seen about every 2 m.
bool is_covered(const Hall& hall, const std::function<double(glm::dvec2)>& ground_m, double cover_m);

}  // namespace roadgen
