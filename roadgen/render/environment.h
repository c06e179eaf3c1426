// Internal, not installed: the light that comes to objects from all around, on the GPU.
//
// A cube map whose levels hold what a surface of rising roughness mirrors, so that the longitude's seam and the poles of a
// panorama are no place of it; nine harmonics for what diffuse surfaces get; and what of the mirrored light a rough surface
// returns, by the angle to the eye. Sources: B. Karis, Real Shading in Unreal Engine 4, 2013 (split sum); R. Ramamoorthi, P.
// Hanrahan, An Efficient Representation for Irradiance Environment Maps, 2001.
#pragma once

#include <array>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/render/gl.h"
#include "roadgen/render/image.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Coefficients of the harmonics of shaders/lib/light.glsl: their sum at a normal is the radiance of a white diffuse
// surface there. Within 3 % of the greatest for light that is itself smooth, exact for a gradient over the height.
using Harmonics = std::array<glm::dvec3, 9>;
// Requires: three channels.
Harmonics harmonics_of(const ImageF& panorama);
// sky_ambient of shaders/lib/sky.glsl, the light that falls on roads and ground.
Harmonics harmonics_of_sky();

// What a surface of this roughness returns of even light mirrored toward an eye at this cosine: x of f0, y besides.
// Accuracy: 3e-3, by 512 samples.
glm::dvec2 split_sum(double cosine, double roughness);

class Environment {
 public:
  // The procedural sky with plain ground, without the sun. toward_sun: unit. Errors: kShader.
  static Result<Environment> of_sky(glm::vec3 toward_sun);
  // Requires: an image as read_panorama gives it. Errors: kShader. Cost: some 2e7 samples of a texture.
  static Result<Environment> of_panorama(const ImageF& panorama);

  Environment() = default;
  explicit operator bool() const { return static_cast<bool>(cube_); }

  // Binds the cube (unit 6), the table of split_sum (7) and the uniform block EnvironmentLight (2).
  void bind() const;

  GLuint cube() const { return cube_.id(); }
  int levels() const { return levels_; }
  int size() const { return size_; }

 private:
  Status filter(gl::Texture source, const Harmonics& harmonics);

  gl::Texture cube_, table_;
  gl::Buffer light_;
  int size_ = 0, levels_ = 0;
};

}  // namespace roadgen
