// A segment as the GPU sees it: one instance's attributes.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/road/network.h"

namespace roadgen {

// A double as the sum of two floats, exact to 48 bits: coordinates 1e7 m from the origin keep 1e-7 m.
struct SplitPosition {
  glm::vec3 high, low;
};
SplitPosition split(glm::dvec3 p);

// The layout that shaders/road.vert declares; 112 bytes.
struct RoadInstance {
  glm::vec3 start_high, start_low;
  glm::vec4 shape;       // chord x, y (m), slopes a, b
  glm::vec4 arc;         // arc length (m), c0, c1, s at the start (m)
  glm::vec4 height;      // z1, z2, z3, s at the start modulo kNoisePeriod_m
  glm::vec4 half_width;  // cubic in s
  glm::vec4 box;         // y low, y high (chord frame), z low, z high (m above the start anchor)
  glm::vec2 road;        // index of the road, s at the start modulo kDashPeriod_m
};
static_assert(sizeof(RoadInstance) == 112);

// Patterns along s repeat, so s is reduced by their periods in double before it becomes a float: NOISE_PERIOD of
// shaders/lib/noise.glsl, and the broken line of shaders/road.frag.
inline constexpr double kNoisePeriod_m = 4096;
inline constexpr double kDashPeriod_m = 9;

RoadInstance road_instance(const Segment& segment, std::size_t road_index);

// A segment whose surface departs from a plane by at most this is drawn as the paper's single quad.
inline constexpr double kPlanarTolerance_m = 1e-3;

// Upper bound of the distance in height between the surface over the footprint and the plane through the start anchor
// that rises along the chord to the end anchor. Proven: by the range of the cubic's deviation along s, and the lean
// of the lines u = const.
double planar_deviation_m(const Segment& segment);

}  // namespace roadgen
