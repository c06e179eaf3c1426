// Internal, not installed: the user's textures of the ground's materials.
#pragma once

#include <array>

#include "roadgen/render/gl.h"
#include "roadgen/render/image.h"
#include "roadgen/render/renderer.h"

namespace roadgen {

class GroundTextures {
 public:
  // Takes the picture in place of the material's own look; with all its smaller versions on the GPU, 5.3 bytes a pixel.
  // Errors: kData for one without pixels.
  Status take(GroundMaterial material, const Image8& picture);
  // For terrain.frag: one bit for each material that has one.
  unsigned mask() const { return mask_; }
  void bind() const;

 private:
  std::array<gl::Texture, 3> textures_;
  unsigned mask_ = 0;
};

}  // namespace roadgen
