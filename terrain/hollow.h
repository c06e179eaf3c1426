// The clear space of a tunnel under ground that is higher: what of the ground's mesh lies in it is cut away.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/query/box_tree.h"
#include "roadgen/road/network.h"
#include "roadgen/road/sweep_piece.h"

namespace roadgen {

// Up to 8 m of one segment's part of a tunnel. What is cut away lies below the vault, up to the middle of its lining,
// and above the road: not lower than kFloor_m below the carriageway's surface where that is lowest, so that ground which
// is proven to lie below the road stays.
struct Hollow {
  static constexpr double kLongest_m = 8;
  static constexpr double kFloor_m = 0.01;

  glm::dvec3 start_m{0, 0, 0};  // ENU: origin of the frame of `piece`
  glm::dvec2 axis{1, 0};        // and its x direction, unit
  Lib::SweepPiece piece{};      // profile: p0 to p2 the vault, p4 the depth of the floor; for Lib::sweep_hollow
  Segment segment{};
  double s0_m = 0, s1_m = 0;  // from the segment's start
  // From where the hill over the tunnel begins, along the road, to the piece, and from it to where the hill ends.
  double from_start_m = 0, to_end_m = 0;
  double half_width_m = 0, height_m = 0;  // of the vault's outside, at its sides and crown, from the axis
  double half_walkways_m = 0;             // half the width between the walkways

  glm::dvec3 local(glm::dvec3 point_m) const;
  // Whether ground at the point is cut away: what the pixel shader computes.
  bool holds(glm::dvec3 point_m) const;
  // Whether the point lies below the vault, however deep.
  bool is_above(glm::dvec3 point_m) const;
  // The tunnel's floor: the walkways' top, between them the carriageway's surface, level from its edges.
  struct Floor {
    double height_m;
    glm::dvec2 gradient;  // dz/dx, dz/dy
  };
  Floor floor_at(glm::dvec2 point_m) const;
  // False only where holds() is false everywhere on the triangle, by more than the rounding of single precision.
  bool may_meet(const std::array<glm::dvec3, 3>& triangle) const;
  Box box() const;  // z: 0
};

// The hollow of a tunnel's part over the given s of the road, in pieces. Requires: part is of the road's tunnel.
void add_hollows(const Road& road, const SweepPart& part, double s_from_m, double s_to_m, std::vector<Hollow>& hollows);

}  // namespace roadgen
