// Where one road passes over another. Internal to roadgen/fit.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/road/network.h"

namespace roadgen {

// A place on a road, or in a junction's area.
struct HeightSpot {
  bool is_area = false;
  std::uint32_t index = 0;  // of the network's roads or junctions
  double s_m = 0;           // along the road
  glm::dvec2 at_m{0, 0};    // ENU
};

// One above the other, by the heights that the network has.
struct Passing {
  HeightSpot upper, lower;
  double above_m = 0;
  bool is_middle = true;  // of the two centre lines; elsewhere of the edge of one
  bool is_meant = false;  // by a bridge or a tunnel
};

// Every place where the centre lines of two roads, or of a road and itself, cross, or a road or an area lies in a junction's
// area that it has no arm in, with more than kPassing_m between them, or kMeantPassing_m where the upper one is on a bridge or
// the lower one in a tunnel; and the places on either where the other's edges are.
// skip: roads that take no part. Accuracy: curves count as polylines of legs of 4 m. Cost: O(length) where few roads are
// near one another.
std::vector<Passing> find_passings(const Network& network, const std::vector<bool>& skip);
inline constexpr double kPassing_m = 1, kMeantPassing_m = 0.1;

}  // namespace roadgen
