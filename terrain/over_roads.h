// Where roads pass over others that no bridge is known of: there no ground suits both, and the upper one is taken for a bridge.
#pragma once

#include <vector>

#include "roadgen/query/road_index.h"
#include "terrain/support.h"

namespace roadgen {

// Parts of roads, and areas, that lie over another carriageway by kOverRoad_m or more, but for that of a kept tunnel, seen about
// every metre at the middle and the edges; of roads with what is needed to either side for a slope (height / width) to rise
// from the lower road's shoulder. Roads that are on bridges and in kept tunnels anyway have none. Cost: 5 us a metre of road.
AssumedBridges bridges_over_roads(const RoadIndex& index, const Supports& supports, double shoulder_m, double slope);
inline constexpr double kOverRoad_m = 1;

}  // namespace roadgen
