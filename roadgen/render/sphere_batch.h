// Internal, not installed: sets of spheres on the GPU, and their draw.
//
// First every sphere that may be seen writes its index, then what is seen is lit once a pixel: in a molecule a dozen
// spheres lie behind one another in every pixel.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
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
  // Replaces the sets. first_instance: number of the first sphere; shadow_kinds: SunGrid::kinds(); materials:
  // the scene's, of so many bytes each. Cost: O(n log n); 24 bytes a sphere on the CPU, on the GPU 32 for each that is
  // drawn.
  void upload(const ObjectScene& scene, std::uint32_t first_instance, const ObjectOptions& options,
              unsigned shadow_kinds, const gl::Buffer& materials, std::size_t material_bytes);
  bool empty() const { return sets_.empty(); }
  std::size_t spheres() const { return spheres_; }
  std::size_t drawn() const { return drawn_; }  // in the last frame

  // Requires: as ObjectBatch::draw, whose uniforms and materials are bound. Leaves the view's framebuffer bound.
  // Errors: kShader; kContext: the driver refuses the index target.
  Status draw(const ObjectView& view, std::span<const glm::vec2> sample_places);

 private:
  // What a frame fills, as large as one had to be.
  struct FrameBuffer {
    gl::Buffer buffer;
    gl::Texture texels;
    GLsizeiptr room = 0;
    template <class T>
    void bind(GLuint unit, GLenum format, const std::vector<T>& data);
  };
  struct Set {
    std::vector<ObjectGroup> groups;
    std::vector<glm::vec4> data;    // centre from the origin, radius
    std::vector<glm::uvec2> looks;  // colour; number within the set
    FrameBuffer places, drawn_looks;
    gl::Buffer material;
    glm::dvec3 origin_m;
    double largest_m = 0, extent_m = 0;  // the largest radius; no centre is farther from the origin
    std::uint32_t first_instance;
    unsigned parts;  // MATERIALS of shaders/object_light.glsl
  };
  // For one kind of frame.
  struct IndexPrograms {
    int samples;
    Program far, near, rectangle;
  };
  struct LightProgram {
    bool channels;
    int samples;
    unsigned parts;  // MATERIALS
    bool near;       // some are near
    Program program;
  };
  void add(const ObjectScene& scene, const SphereSet& set, std::uint32_t first_instance);
  Result<const IndexPrograms*> index_programs(int samples);
  Result<const Program*> light_program(const ObjectView& view, unsigned parts, bool near);
  Status ensure_target(const ObjectView& view);
  // The spheres that may be seen into lists_, and the tiles of the screen that they touch into runs_. choose_all: all of
  // the groups that may be seen, and the whole screen.
  void choose(const Set& set, const ObjectView& view);
  void choose_all(const Set& set, const ObjectView& view);
  std::vector<std::uint32_t>& list_of(double radius_px, bool near);
  void draw_indices(const Program& program, int corners, std::size_t first, std::size_t count) const;
  int corners_of(std::size_t list) const;
  // Of lists_, list by list, as shaders/spheres.glsl has them.
  void take_places(const Set& set, const ObjectView& view);
  Status draw_set(Set& set, const ObjectView& view, const IndexPrograms& index,
                  std::span<const glm::vec2> sample_places);
  void light_tiles(const Set& set, const ObjectView& view, const Program& light) const;

  ObjectOptions options_;
  unsigned shadow_kinds_ = 0;
  std::vector<Set> sets_;
  std::vector<IndexPrograms> index_programs_;
  std::vector<LightProgram> light_programs_;
  Occlusion occlusion_;
  // Of the set that is drawn, by the number of their polygon's corners: triangles, squares, larger ones; large polygons at
  // the picture's edge; the near ones.
  std::array<std::vector<std::uint32_t>, 5> lists_;
  std::vector<glm::vec4> places_;
  std::vector<glm::uvec4> looks_;
  std::vector<Occlusion::Run> runs_;
  gl::Buffer runs_buffer_;
  std::array<gl::Buffer, 2> elements_;  // of polygons with 4 corners, and with those of lists_[2]
  gl::VertexArray array_;
  gl::Texture indices_;
  gl::Framebuffer target_;
  int width_ = 0, height_ = 0, samples_ = 0;
  unsigned depth_ = 0;
  std::size_t spheres_ = 0, drawn_ = 0;
};

}  // namespace roadgen
