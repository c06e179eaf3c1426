// Bridges and tunnels of OSM ways. Internal to roadgen/import.
#pragma once

#include "roadgen/import/osm_tags.h"
#include "roadgen/road/network.h"

namespace roadgen {

// A bridge with guard rails, or the vault of a tunnel, all along the road but where it bends too tightly for them, and where
// less than kLeastVault_m of roadgen/road/vault_room.h would be left.
// touches_*: other roads part from it there without an area between them; there is no rail across those.
void add_structures(Road& road, const WayTags& of, bool touches_start, bool touches_end);

}  // namespace roadgen
