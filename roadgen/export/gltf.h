// A mesh as a glTF 2.0 file.
#pragma once

#include <string>

#include "roadgen/export/mesh.h"

namespace roadgen {

// Binary glTF (.glb; Khronos glTF 2.0, 2021): one node an item, one primitive a part, materials by name with the linear
// albedo as base colour. Vertices are ENU metres about each node's translation; the root node turns ENU into glTF's y-up
// frame, so (east, north, up) stands at (x, -z, y). asset.extras holds "error_m", and "origin" (latitude and longitude in
// degrees, height) where there is a georeference.
// Errors: kData where it would be 4 GiB or more, the format's limit.
Result<std::string> gltf_binary(const NetworkMesh& mesh, const std::optional<Georeference>& origin);

}  // namespace roadgen
