// Movements: how traffic passes the area of a junction, from the lanes that lead into it to those that lead out.
//
//   const RoadsById roads = roads_by_id(network);
//   for (const Movement& m : movements(network, roads, junction)) {
//     const Road way = connecting_road(network, roads, junction, m, id);
//   }
//
// They follow from the arms and their lanes, so a network does not hold them: twelve connecting roads a crossing are more
// than all its other roads. Where a network lists connections of its own (JunctionLinks), those hold instead.
#pragma once

#include <string>
#include <vector>

#include "roadgen/road/network.h"

namespace roadgen {

// From one arm of a junction to another; arms as in Junction::arms.
struct Movement {
  std::size_t from = 0, to = 0;
  // From lanes of the road at `from` to lanes of the road at `to`, from the middle of the road outward.
  std::vector<LaneLink> lanes = {};
};

// Between every two different arms, where a lane leads in at the one and one leads out at the other: as many lanes as
// both have, from the middle of the road on, or from its outside where the turn is to the side that traffic keeps to.
// Empty where an arm's road is missing or not linked to the junction, since no traffic passes then.
// Cost: O(arms^2 lanes).
std::vector<Movement> movements(const Network& network, const RoadsById& roads, const Junction& junction);

// The connecting road of a movement, as OpenDRIVE has it: from cut to cut, tangent and level with both roads, its
// reference line along the inner edge of the innermost lane, its lanes -1, -2, ... (1, 2, ... where traffic keeps left)
// those of the movement; linked to both roads. For routes and poses: the area is what is drawn.
// The curve is a Bezier curve's, near a circle's where one fits, cut into cubics that turn by at most 50 degrees or so.
// Requires: a movement of the junction.
Road connecting_road(const Network& network, const RoadsById& roads, const Junction& junction, const Movement& movement,
                     std::string id);

// What the junction says about it: `connecting` is the connecting road's id, its lanes those of connecting_road.
Connection connection_of(const Junction& junction, const Movement& movement, bool keep_left, std::string connecting);

}  // namespace roadgen
