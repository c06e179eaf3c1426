// Objects that stand on roads, and what moves them there.
#pragma once

#include <cstddef>
#include <string>

#include <glm/mat4x4.hpp>

#include "roadgen/object/object.h"
#include "roadgen/road/network.h"

namespace roadgen {

// A place on a road, for an object or a sphere set of a scene. The frame there stands upright however the road is banked:
// z up, x along the road's heading turned by heading_rad, the origin h_m above the surface.
struct Placement {
  enum class Kind { kObject, kSphereSet };
  Kind kind = Kind::kObject;
  std::size_t index = 0;   // in ObjectScene::objects or sphere_sets
  std::string road;        // id
  double s_m = 0;          // on the road: 0 to its length
  double t_m = 0;          // left positive
  double h_m = 0;          // above the surface
  double heading_rad = 0;  // counter-clockwise from the road's
  // Where it was read, for errors.
  std::string file = {};
  int line = 0;
  std::string element = {};
};

// World from the placement's frame.
glm::dmat4 placement_frame(const RoadPose& pose, const Placement& placement);

// Whether the map keeps spheres: it moves, turns, mirrors and scales evenly, to 1e-6.
bool is_similarity(const glm::dmat4& map);

// Moves all spheres of a set. Requires: is_similarity(world_from_set).
void transform(SphereSet& set, const glm::dmat4& world_from_set);

}  // namespace roadgen
