// Sweeps cut into pieces of one segment each, as the shader draws them; and rays cast at them in double.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/road/network.h"
#include "roadgen/road/sweep.h"

namespace roadgen {

// Lib::SweepPiece is what is traced; the rest is for looks.
struct SweepPart {
  Lib::SweepPiece piece{};
  std::size_t segment = 0;  // of the road
  std::size_t sweep = 0;    // of Road::sweeps
  double s_from_m = 0;  // s of the segment's start from the sweep's start, and up to the sweep's end: the depth into
  double s_left_m = 0;  // a tunnel
  glm::dvec3 albedo{0.5, 0.5, 0.5};
  double lamp_spacing_m = 0;  // 0: none
  double least_stretch = 1;   // of 1 - n curvature over its box
  double steepest = 0;        // greatest slope of the axis against the plane, up and aside together
};

// The pieces of a sweep: of each segment that it runs over, and of each span of a cable. None for a sweep with a bad
// number; where the road is too tightly bent, none of that segment. Cost: O(segments and spans of it).
std::vector<SweepPart> sweep_parts(const Road& road, std::size_t sweep);

// Where the road bends too tightly for a sweep with good numbers: s of the starts of the segments without it.
std::vector<double> tight_places(const Road& road, const Sweep& sweep);
// The part of problems() that keeps a sweep from being drawn at all.
std::vector<std::string> bad_numbers(const Road& road, const Sweep& sweep);

// Rounding and the arc length's polynomial may bend a ray by this factor more than the bounds of SweepPath say.
inline constexpr double kBendMargin = 1.1;

// Greatest factor by which D(n, h) of a piece can change faster in space than in its cross section: the true distance
// of a point from the piece is at least D divided by it. With q the least stretch and m the greatest slope of the axis
// against the road (dz/ds and dn/ds together), the map from space to (s, n, h) is a scaling by 1/q of s followed by a
// shear by m, whose norm is m/2 + sqrt(1 + m^2/4).
double lipschitz(const SweepPart& part);

// The nearest meeting of a ray with a part, in world coordinates and double: what the pixel shader computes.
struct SweepMeeting {
  double distance_m;
  glm::dvec3 normal;
  bool post;
};
// direction: unit. pixel: a pixel's size at distance 1 (0: none). from_m: where the ray starts.
std::optional<SweepMeeting> cast(const Road& road, const SweepPart& part, glm::dvec3 origin_m, glm::dvec3 direction,
                                 double pixel, double from_m = 0);

}  // namespace roadgen
