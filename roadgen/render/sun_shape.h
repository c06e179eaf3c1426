// Internal, not installed: what shadows are taken from. No OpenGL.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "roadgen/object/primitive.h"

namespace roadgen {

// A primitive as a quadric in the box [-1, 1]^3 of its own frame, or as the torus that it is: one intersection for all,
// where programs would have to hold one a kind. Flat shapes are kSunThickness of their size thick.
struct SunShape {
  bool torus = false;
  glm::dvec3 center_m;
  glm::dmat3 axes;  // p_world = center_m + axes p
  ObjectLib::ObjectShape shape;
};
inline constexpr double kSunThickness = 1e-4;
SunShape sun_shape(const Primitive& primitive);

}  // namespace roadgen
