// Internal, not installed: objects and sets of spheres on the GPU, and their draw, one program a kind of primitive.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/object/object.h"
#include "roadgen/object/primitive.h"
#include "roadgen/render/camera.h"
#include "roadgen/render/frustum.h"
#include "roadgen/render/gl.h"
#include "roadgen/render/program.h"
#include "roadgen/render/renderer.h"

namespace roadgen {

// A frame as objects see it.
struct ObjectView {
  Camera camera;
  int width = 1, height = 1, samples = 1;
  bool channels = false;             // else the picture
  std::uint32_t first_instance = 0;  // of the instance channel
};

class ObjectBatch {
 public:
  // Replaces the objects. Requires: a scene that check() passes. Cost: O(n log n); 228 bytes an object, 28 a sphere.
  // Errors: kShader; kData: more than the driver's buffers hold.
  Status upload(const ObjectScene& scene, const ObjectOptions& options);
  bool empty() const { return kinds_.empty() && sets_.empty(); }
  const ObjectStatistics& statistics() const { return statistics_; }

  // Draws what the camera may see, near groups first. Requires: depth test on, the frame's uniforms bound.
  // Errors: kShader.
  Status draw(const ObjectView& view);

 private:
  // Neighbours in space, which are culled and ordered together.
  struct Group {
    glm::dvec3 center_m;
    double radius_m;
    std::uint32_t first, count;
  };
  struct Kind {
    PrimitiveKind kind;
    std::vector<Group> groups;
    gl::Buffer instances, order, corners, elements;
    gl::VertexArray vertex_array;
    GLsizei element_count = 0;
    std::size_t count = 0;
  };
  struct Set {
    std::vector<Group> groups;
    gl::Buffer spheres, colors;
    glm::dvec3 origin_m;
    std::uint32_t first_instance, material;
    std::size_t count = 0;
  };
  Status add_kind(PrimitiveKind kind, const ObjectScene& scene, std::span<const std::uint32_t> members);
  Status add_set(const SphereSet& set, std::uint32_t first_instance);
  Result<const Program*> program(const PrimitiveRow& row, bool spheres, const ObjectView& view);
  std::vector<const Group*> visible(std::span<const Group> groups, const ObjectView& view) const;
  void draw_kind(const Kind& kind, const ObjectView& view, const Program& program);
  void draw_set(const Set& set, const ObjectView& view, const Program& program);

  ObjectOptions options_;
  std::vector<Kind> kinds_;
  std::vector<Set> sets_;
  std::map<std::string, Program> programs_;
  gl::Buffer view_uniforms_, materials_, sphere_elements_;
  gl::VertexArray sphere_array_;
  ObjectStatistics statistics_;
};

}  // namespace roadgen
