// Internal, not installed: the textures of a scene's materials as the layers of one array.
#pragma once

#include <string>
#include <vector>

#include "roadgen/object/object.h"
#include "roadgen/render/gl.h"
#include "roadgen/road/result.h"

namespace roadgen {

struct ObjectTextures {
  gl::Texture layers;         // none: no material has a texture
  std::vector<int> layer_of;  // of each material: 1 + its layer, 0: none
};

// Images of different sizes are brought to the size of the largest, rounded up to a power of two, at most
// kMostTextureSize: uv knows no sizes. Errors: kIo and kData with the file: not readable, no image, too many or too
// large for the driver. Cost: the files.
inline constexpr int kMostTextureSize = 2048;
Result<ObjectTextures> load_textures(const std::vector<ObjectMaterial>& materials);

}  // namespace roadgen
