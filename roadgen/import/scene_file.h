// Scenes of objects as JSON files, "props.json", version 1:
//
//   {"version": 1,
//    "materials": {"steel": {"base_color": [0.5, 0.5, 0.52], "metallic": 1, "roughness": 0.4}},
//    "objects": [{"type": "cylinder", "from": [0, 0, 0], "to": [0, 0, 6], "radius": 0.1, "material": "steel",
//                 "instances": [{"place": {"road": "1", "s": 10, "t": 5}}, {"place": {"road": "1", "s": 35, "t": 5}}]}]}
//
// README, "Scene files", has all types and keys.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/object/object.h"
#include "roadgen/object/placement.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Objects whose placements are not yet applied: place_on_roads (roadgen/render/placement.h) does that.
struct SceneFile {
  ObjectScene scene;
  std::vector<Placement> placements;
};

// The objects are sound, as check() of roadgen/object/object.h has it. Files that the scene names are sought from the
// folder of `path`; textures are not opened.
// Errors, each with file, line and path such as "objects[3].center": kIo; kParse: not JSON, a value of another kind;
// kData: an unknown type, key or material, a missing key, too few or many numbers, what no object can be drawn of,
// another version, more than kMostObjects objects or kMostPoints spheres with all instances; and those of point clouds.
// Cost: linear; memory: that of the scene, and of one object's text.
Result<SceneFile> read_scene(const std::string& path);
// The same from a text; `file` is its name for errors and its place.
Result<SceneFile> parse_scene(std::string_view text, const std::string& file);

inline constexpr std::size_t kMostObjects = 10'000'000;

}  // namespace roadgen
