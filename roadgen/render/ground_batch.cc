#include "roadgen/render/ground_batch.h"

#include <algorithm>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace roadgen {
namespace {

// The layout that shaders/terrain.frag declares.
struct HollowInstance {
  glm::vec4 start, shape, arc, axis, place, box, vault;
};
static_assert(sizeof(HollowInstance) == 112);

HollowInstance instance(const Hollow& hollow, glm::dvec3 origin_m) {
  const Lib::SweepPiece& p = hollow.piece;
  const Lib::SweepPath& r = p.path;
  return {glm::dvec4(hollow.start_m - origin_m, 0),
          glm::dvec4(hollow.segment.chord_m(), r.a, r.b),
          glm::dvec4(r.arc, r.c0, r.c1, p.profile.p4),
          glm::dvec4(r.z0, r.z1, r.z2, r.z3),
          glm::dvec4(r.n0, r.n1, p.u0, p.u1),
          glm::dvec4(p.y0, p.y1, p.z0, p.z1),
          glm::dvec4(p.profile.p0, p.profile.p1, p.profile.p2, 0)};
}

}  // namespace

GroundBatch::Tile GroundBatch::uploaded(const TerrainMesh& mesh) {
  Tile tile;
  tile.vertex_array = gl::VertexArray::create();
  glm::vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
  for (const glm::vec3& p : mesh.positions_m) low = glm::min(low, p), high = glm::max(high, p);
  tile.center_m = 0.5f * (low + high);
  tile.radius_m = 0.5f * glm::length(high - low);
  tile.whole = static_cast<GLsizei>(mesh.whole());
  const auto buffer = [](const auto& data) {
    return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(data[0])), data.data());
  };
  tile.positions = buffer(mesh.positions_m);
  tile.normals = buffer(mesh.normals);
  tile.road = buffer(mesh.road_m.size() == mesh.positions_m.size()
                         ? mesh.road_m
                         : std::vector<float>(mesh.positions_m.size(), static_cast<float>(TerrainMesh::kVerge_m)));
  tile.triangles = buffer(mesh.triangles);
  std::vector<HollowInstance> met;
  for (const TerrainMesh::Cut& cut : mesh.cuts) {
    tile.cuts.push_back({static_cast<GLsizei>(cut.count), cut.first, static_cast<GLuint>(met.size()),
                         static_cast<GLuint>(cut.hollows.size())});
    for (const std::uint32_t i : cut.hollows) met.push_back(instance(mesh.hollows[i], mesh.origin_m));
  }
  if (!met.empty()) tile.hollows = buffer(met);
  const GLuint array = tile.vertex_array.id();
  for (GLuint i = 0; i < 2; ++i) {
    glVertexArrayVertexBuffer(array, i, (i == 0 ? tile.positions : tile.normals).id(), 0, sizeof(glm::vec3));
    glEnableVertexArrayAttrib(array, i);
    glVertexArrayAttribFormat(array, i, 3, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(array, i, i);
  }
  glVertexArrayVertexBuffer(array, 2, tile.road.id(), 0, sizeof(float));
  glEnableVertexArrayAttrib(array, 2);
  glVertexArrayAttribFormat(array, 2, 1, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(array, 2, 2);
  tile.mesh.origin_m = mesh.origin_m;
  tile.mesh.roots = mesh.roots;
  tile.mesh.nodes = mesh.nodes;
  if (mesh.nodes.empty()) return tile;
  tile.mesh.positions_m = mesh.positions_m;
  tile.mesh.error_m = mesh.error_m;
  tile.mesh.radius_m = mesh.radius_m;
  return tile;
}

void GroundBatch::upload(std::span<const TerrainMesh> tiles) {
  *this = {};
  low_m_ = std::numeric_limits<double>::max();
  high_m_ = -low_m_;
  for (const TerrainMesh& mesh : tiles) {
    if (mesh.triangles.empty()) continue;
    tiles_.push_back(uploaded(mesh));
    statistics_.triangles += mesh.triangles.size() / 3;
    for (const glm::vec3& p : mesh.positions_m) {
      low_m_ = std::min(low_m_, mesh.origin_m.z + p.z);
      high_m_ = std::max(high_m_, mesh.origin_m.z + p.z);
    }
  }
  if (tiles_.empty()) low_m_ = high_m_ = 0;
  statistics_.tiles = tiles_.size();
  has_cuts_ = std::any_of(tiles_.begin(), tiles_.end(), [](const Tile& tile) { return !tile.cuts.empty(); });
}

void GroundBatch::choose(Tile& tile) {
  tile.is_chosen = true;
  select_triangles(tile.mesh, detail_, triangles_);
  tile.chosen_count = static_cast<GLsizei>(triangles_.size());
  if (triangles_.empty()) return;
  if (tile.chosen.id() == 0) {
    tile.chosen = gl::Buffer::with_data(static_cast<GLsizeiptr>(sizeof(std::uint32_t)) * tile.whole, nullptr,
                                        GL_DYNAMIC_STORAGE_BIT);
  }
  glNamedBufferSubData(tile.chosen.id(), 0, static_cast<GLsizeiptr>(triangles_.size() * sizeof(triangles_[0])),
                       triangles_.data());
}

void GroundBatch::draw(const Program& ground, const Program& at_tunnels, glm::dvec3 eye_m, double part,
                       const std::function<bool(glm::dvec3, double)>& may_see) {
  if (part > 0 && (part != detail_.part || glm::length(eye_m - detail_.eye_m) > detail_.room_m)) {
    detail_ = {eye_m, kRoom_m, part};
    for (Tile& tile : tiles_) tile.is_chosen = false;
  }
  statistics_.drawn_tiles = statistics_.drawn_triangles = 0;
  std::vector<const Tile*> cut;
  const auto draw_elements = [&](const Tile& tile, const gl::Buffer& triangles, GLsizei count, std::size_t first) {
    const glm::vec3 from_eye = tile.mesh.origin_m - eye_m;
    glUniform3f(0, from_eye.x, from_eye.y, from_eye.z);
    glVertexArrayElementBuffer(tile.vertex_array.id(), triangles.id());
    glBindVertexArray(tile.vertex_array.id());
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
    statistics_.drawn_triangles += static_cast<std::size_t>(count) / 3;
  };
  ground.use();
  for (Tile& tile : tiles_) {
    if (!may_see(tile.mesh.origin_m - eye_m + glm::dvec3(tile.center_m), tile.radius_m)) continue;
    ++statistics_.drawn_tiles;
    if (!tile.cuts.empty()) cut.push_back(&tile);
    const bool all = part == 0 || tile.mesh.nodes.empty();
    if (!all && !tile.is_chosen) choose(tile);
    const GLsizei count = all ? tile.whole : tile.chosen_count;
    if (count > 0) draw_elements(tile, all ? tile.triangles : tile.chosen, count, 0);
  }
  if (cut.empty()) return;
  at_tunnels.use();
  for (const Tile* tile : cut) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, tile->hollows.id());
    for (const Cut& c : tile->cuts) {
      glUniform2ui(1, c.hollow_first, c.hollow_count);
      draw_elements(*tile, tile->triangles, c.count, c.first);
    }
  }
}

}  // namespace roadgen
