// Puts the objects of a scene onto the roads that their placements name, and beside them onto the ground.
#pragma once

#include <span>

#include "roadgen/object/object.h"
#include "roadgen/object/placement.h"
#include "roadgen/query/road_index.h"
#include "roadgen/road/result.h"
#include "terrain/terrain.h"

namespace roadgen {

// Transforms become world from the shape's frame, by way of the placement's frame. On an error the scene is as it was.
// Requires: indices in the scene. Errors: kData with the placement's file, line and element: no road of this id, one
// without segments, s outside of it. Cost: O(roads + placements log n).
Status place_on_roads(std::span<const Placement> placements, const RoadIndex& index, ObjectScene& scene);

// Moves what stands off every road up or down to the ground there, h_m above which it then is; a road's own surface ends at
// its edges. What stands beside a bridge or in a tunnel stays at the road's height. Requires: place_on_roads succeeded,
// once. Cost: O(roads + placements log n).
void stand_on_ground(std::span<const Placement> placements, const RoadIndex& index, const Terrain& terrain,
                     ObjectScene& scene);

}  // namespace roadgen
