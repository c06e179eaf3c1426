// Internal, not installed: sets of spheres on the GPU, and their draw.
//
// First every sphere that may be seen writes its index, then what is seen is lit once a pixel: in a molecule a dozen
// spheres lie behind one another in every pixel.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/object/object.h"
#include "roadgen/render/gl.h"
#include "roadgen/render/object_groups.h"
#include "roadgen/render/occlusion.h"
#include "roadgen/render/program.h"
#include "roadgen/render/renderer.h"

namespace roadgen {

class SphereBatch {
 public:
  // Replaces the sets. first_instance: number of the first sphere; shadow_kinds: SunGrid::kinds(). Cost: O(n log n); 28 bytes a sphere on the GPU, 16 on
  // the CPU. Errors: kData: a set is larger than the driver's buffers.
  Status upload(const ObjectScene& scene, std::uint32_t first_instance, const ObjectOptions& options,
                unsigned shadow_kinds);
  bool empty() const { return sets_.empty(); }
  std::size_t spheres() const { return spheres_; }
  std::size_t drawn() const { return drawn_; }  // in the last frame

  // Requires: as ObjectBatch::draw, whose uniforms and materials are bound. Leaves the view's framebuffer bound.
  // Errors: kShader; kContext: the driver refuses the index target.
  Status draw(const ObjectView& view, std::span<const glm::vec2> sample_places);

 private:
  struct Set {
    std::vector<ObjectGroup> groups;
    std::vector<glm::vec4> data;  // centre from the origin, radius
    gl::Buffer spheres, colors, order;
    glm::dvec3 origin_m;
    std::uint32_t first_instance, material;
  };
  // For one kind of frame.
  struct Programs {
    bool channels;
    int samples;
    Program index, index_near, light;
  };
  int corners() const { return options_.rectangle ? 4 : options_.polygon; }
  Status add(const SphereSet& set, std::uint32_t first_instance);
  Result<Programs*> programs(const ObjectView& view);
  Status ensure_target(const ObjectView& view);
  // The spheres that may be seen, those last that are near (shaders/spheres.glsl); how many are not.
  std::size_t choose(const Set& set, const ObjectView& view);
  void draw_indices(const Program& program, std::size_t first, std::size_t count) const;
  void draw_set(const Set& set, const ObjectView& view, const Programs& with);

  ObjectOptions options_;
  unsigned shadow_kinds_ = 0;
  std::vector<Set> sets_;
  std::vector<Programs> programs_;
  Occlusion occlusion_;
  std::vector<std::uint32_t> seen_;  // of the set that is drawn
  gl::Buffer elements_;
  gl::VertexArray array_;
  gl::Texture indices_;
  gl::Framebuffer target_;
  int width_ = 0, height_ = 0, samples_ = 0;
  unsigned depth_ = 0;
  std::size_t spheres_ = 0, drawn_ = 0;
};

}  // namespace roadgen
