// Puts the objects of a scene onto the roads that their placements name.
#pragma once

#include <span>

#include "roadgen/object/object.h"
#include "roadgen/object/placement.h"
#include "roadgen/query/road_index.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Transforms become world from the shape's frame, by way of the placement's frame. On an error the scene is as it was.
// Requires: indices in the scene. Errors: kData with the placement's file, line and element: no road of this id, one
// without segments, s outside of it. Cost: O(roads + placements log n).
Status place_on_roads(std::span<const Placement> placements, const RoadIndex& index, ObjectScene& scene);

}  // namespace roadgen
