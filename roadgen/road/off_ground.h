// Where a road leaves the ground: on its bridges and in its tunnels.
#pragma once

#include "roadgen/road/network.h"

namespace roadgen {

// Whether the road's height at s_m is not the ground's: on a bridge or in a tunnel. Their ends count, within 1 µm, since
// another may follow there. Cost: O(bridges and structures of the road).
bool is_off_ground(const Road& road, double s_m);

}  // namespace roadgen
