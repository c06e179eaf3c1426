#include "terrain/ground_source.h"

#include <limits>

#include <glm/common.hpp>

#include "terrain/detail.h"

namespace roadgen {
namespace {

class InMemory : public GroundSource {
 public:
  explicit InMemory(std::shared_ptr<const std::vector<TerrainMesh>> tiles) : meshes_(std::move(tiles)) {
    whole_.reserve(meshes_->size());
    for (const TerrainMesh& mesh : *meshes_) {
      if (mesh.triangles.empty()) continue;
      GroundTile tile = view_of(mesh);
      const auto vertices = static_cast<std::uint32_t>(mesh.positions_m.size());
      if (tile.nodes.empty()) {
        whole_.push_back({vertices, 0, std::numeric_limits<float>::infinity(), 0});
        tile.bands = std::span(&whole_.back(), 1);
      }
      tiles_.push_back(tile);
    }
  }
  std::span<const GroundTile> tiles() const override { return tiles_; }
  bool is_in_memory() const override { return true; }
  Status load(std::size_t, std::uint32_t, std::uint32_t) const override { return Done{}; }
  void release(std::size_t) const override {}

 private:
  std::shared_ptr<const std::vector<TerrainMesh>> meshes_;
  std::vector<TerrainMesh::Band> whole_;  // of tiles without levels of detail
  std::vector<GroundTile> tiles_;
};

}  // namespace

std::size_t GroundTile::bytes(std::uint32_t band_count) const {
  if (band_count == 0) return 0;
  const TerrainMesh::Band& band = bands[band_count - 1];
  return band.vertices * (2 * sizeof(glm::vec3) + 3 * sizeof(float)) + band.nodes * sizeof(TerrainMesh::Node);
}

GroundTile view_of(const TerrainMesh& mesh) {
  GroundTile tile;
  tile.origin_m = mesh.origin_m;
  tile.low_m = glm::vec3(std::numeric_limits<float>::max());
  tile.high_m = -tile.low_m;
  for (const glm::vec3& p : mesh.positions_m) {
    tile.low_m = glm::min(tile.low_m, p);
    tile.high_m = glm::max(tile.high_m, p);
  }
  tile.positions_m = mesh.positions_m;
  tile.normals = mesh.normals;
  tile.road_m = mesh.road_m;
  tile.vertex_error_m = mesh.error_m;
  tile.vertex_radius_m = mesh.radius_m;
  tile.nodes = mesh.nodes;
  tile.roots = mesh.roots;
  tile.bands = mesh.bands;
  const std::span<const std::uint32_t> triangles(mesh.triangles);
  if (mesh.nodes.empty()) tile.triangles = triangles.first(mesh.whole());
  tile.cut_triangles = triangles.subspan(mesh.whole());
  tile.cuts = mesh.cuts;
  tile.hollows = mesh.hollows;
  return tile;
}

std::shared_ptr<const GroundSource> ground_in_memory(std::shared_ptr<const std::vector<TerrainMesh>> tiles) {
  return std::make_shared<InMemory>(std::move(tiles));
}

std::vector<TerrainMesh> meshes_of(const GroundSource& source) {
  std::vector<TerrainMesh> meshes;
  const auto copy = [](const auto& span) { return std::vector(span.begin(), span.end()); };
  for (const GroundTile& tile : source.tiles()) {
    TerrainMesh& mesh = meshes.emplace_back();
    mesh.origin_m = tile.origin_m;
    mesh.positions_m = copy(tile.positions_m);
    mesh.normals = copy(tile.normals);
    mesh.road_m = copy(tile.road_m);
    mesh.error_m = copy(tile.vertex_error_m);
    mesh.radius_m = copy(tile.vertex_radius_m);
    mesh.nodes = copy(tile.nodes);
    mesh.roots = tile.roots;
    mesh.bands = copy(tile.bands);
    mesh.cuts = copy(tile.cuts);
    mesh.hollows = copy(tile.hollows);
    if (mesh.nodes.empty()) {
      mesh.triangles = copy(tile.triangles);
    } else {
      select_triangles(tile, static_cast<std::uint32_t>(tile.bands.size()), {}, mesh.triangles);
    }
    mesh.triangles.insert(mesh.triangles.end(), tile.cut_triangles.begin(), tile.cut_triangles.end());
  }
  return meshes;
}

}  // namespace roadgen
