// Internal, not installed: objects and sets of spheres on the GPU, and their draw, one program a kind of primitive.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "roadgen/object/object.h"
#include "roadgen/object/primitive.h"
#include "roadgen/render/gl.h"
#include "roadgen/render/object_groups.h"
#include "roadgen/render/program.h"
#include "roadgen/render/renderer.h"
#include "roadgen/render/sphere_batch.h"

namespace roadgen {

class ObjectBatch {
 public:
  // Errors: kData: the first object or set that the driver's buffers have no room for. Cost: O(n), no memory.
  static Status check_room(const ObjectScene& scene);
  // Replaces the objects. shadow_kinds: SunGrid::kinds(). Requires: a scene that check() and check_room pass.
  // Cost: O(n log n); 228 bytes an object, for quadrics about 500 and 0.1 ms more, for their hulls; spheres: SphereBatch.
  // Errors: kShader; kIo, kData: of textures.
  Status upload(const ObjectScene& scene, const ObjectOptions& options, unsigned shadow_kinds);
  bool empty() const { return kinds_.empty() && spheres_.empty(); }
  const ObjectStatistics& statistics() const { return statistics_; }

  // Draws what the camera may see, near groups first. Requires: depth test on, the frame's uniforms bound.
  // Errors: kShader.
  Status draw(const ObjectView& view);

 private:
  struct Kind {
    PrimitiveKind kind;
    unsigned materials = 0;  // MATERIALS of shaders/object_light.glsl
    std::vector<ObjectGroup> groups;
    gl::Buffer instances, order, corners, elements;
    gl::VertexArray vertex_array;
    GLsizei element_count = 0;
    std::vector<std::size_t> hull_starts;  // of kHull: each one's first element, and their count
    std::size_t count = 0;
  };
  static void set_arrays(const Kind& kind, const gl::Buffer& indices, GLintptr offset, GLuint divisor, GLsizei stride);
  void add_kind(PrimitiveKind kind, const ObjectScene& scene, std::span<const std::uint32_t> members);
  Result<const Program*> program(const Kind& kind, const ObjectView& view);
  void draw_kind(const Kind& kind, const ObjectView& view, const Program& program);

  ObjectOptions options_;
  unsigned shadow_kinds_ = 0;
  std::vector<Kind> kinds_;
  std::map<std::string, Program> programs_;
  gl::Buffer view_uniforms_, materials_;
  gl::Texture textures_;
  SphereBatch spheres_;
  ObjectStatistics statistics_;
};

}  // namespace roadgen
