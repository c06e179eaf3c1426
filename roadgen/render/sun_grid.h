// Internal, not installed: the objects of a scene in a grid across the sun's direction, for the shadows that
// shaders/shadows.glsl takes from them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/object/object.h"
#include "roadgen/render/gl.h"
#include "roadgen/render/shader_source.h"
#include "roadgen/road/result.h"

namespace roadgen {

// What fragment programs are compiled with for shadows of such kinds, see SunGrid::kinds.
inline void add_shadows(ShaderDefines& defines, unsigned kinds) {
  if (kinds != 0) defines.push_back({"SUN_KINDS", std::to_string(kinds)});
}

class SunGrid {
 public:
  // Replaces the objects. What lets more than half of the light through casts the shadow of that; such sets of spheres
  // cast none. Cost: O(n); 128 bytes an object, 32 a sphere. Errors: kData: more than the driver's buffers hold.
  Status upload(const ObjectScene& scene);
  bool empty() const { return kinds_ == 0; }
  // Of SUN_KINDS, which programs must be compiled with: what casts shadows.
  unsigned kinds() const { return kinds_; }

  // Binds the uniform block SunGrid (3) and the buffers 7 to 9 for a frame, after sorting the objects anew where the sun
  // has moved. toward_sun: unit. Requires: not empty. Errors: kData, as upload. Cost: O(n) where it has moved.
  Status bind(glm::dvec3 toward_sun, glm::dvec3 eye_m);

 private:
  // From the origin, m.
  struct Box {
    glm::vec3 low, high;
  };
  struct Range {
    int left, right, bottom, top;  // cells
  };
  Status sort(glm::dvec3 toward_sun);
  Range cells_of(const Box& box) const;
  Box box_of(std::size_t number) const;

  glm::dvec3 origin_m_{0}, toward_sun_{0}, across_{1, 0, 0}, along_{0, 1, 0};
  glm::dvec2 corner_m_{0};
  double cell_m_ = 1;
  int columns_ = 0, rows_ = 0;
  unsigned kinds_ = 0;
  std::vector<Box> boxes_;
  std::vector<glm::vec4> spheres_;
  gl::Buffer cells_, objects_, sphere_buffer_, uniforms_;
  gl::Texture cell_texels_, object_texels_, sphere_texels_;
};

}  // namespace roadgen
