// Internal, not installed: the ground's tiles on the GPU, and their draw in the level of detail that a view needs.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/render/gl.h"
#include "roadgen/render/program.h"
#include "terrain/detail.h"
#include "terrain/terrain.h"

namespace roadgen {

class GroundBatch {
 public:
  // Replaces the ground. Cost: O(triangles); 40 bytes a vertex and 12 a triangle on the GPU.
  void upload(std::span<const TerrainMesh> tiles);
  bool empty() const { return tiles_.empty(); }
  bool has_cuts() const { return has_cuts_; }
  double low_m() const { return low_m_; }
  double high_m() const { return high_m_; }
  GroundStatistics statistics() const { return statistics_; }

  // Draws the tiles that may_see allows (centre from the eye, radius), each deviating from its mesh by at most `part` of
  // the distance, 0: not at all; at_tunnels is the program for what is cut away there. Requires: depth test on, the
  // frame's uniforms bound. Cost: where part > 0 and the eye has moved by more than kRoom_m, O(triangles drawn) on the CPU.
  void draw(const Program& ground, const Program& at_tunnels, glm::dvec3 eye_m, double part,
            const std::function<bool(glm::dvec3, double)>& may_see);

 private:
  // How far the eye moves before triangles are chosen again.
  static constexpr double kRoom_m = 1;

  struct Cut {
    GLsizei count;
    std::size_t first;
    GLuint hollow_first, hollow_count;
  };
  struct Tile {
    gl::VertexArray vertex_array;
    gl::Buffer positions, normals, road, triangles, hollows;
    TerrainMesh mesh;          // without what only the GPU needs
    GLsizei whole = 0;         // indices of the triangles that meet no tunnel
    gl::Buffer chosen;         // of those that stand for them in the picture, once there was one
    GLsizei chosen_count = 0;  // indices
    bool is_chosen = false;    // for detail_
    std::vector<Cut> cuts;
    glm::vec3 center_m{0, 0, 0};  // of the bounding sphere, from the origin
    float radius_m = 0;
  };
  static Tile uploaded(const TerrainMesh& mesh);
  void choose(Tile& tile);

  std::vector<Tile> tiles_;
  Detail detail_;
  std::vector<std::uint32_t> triangles_;  // of a tile, as chosen
  double low_m_ = 0, high_m_ = 0;
  bool has_cuts_ = false;
  GroundStatistics statistics_;
};

}  // namespace roadgen
