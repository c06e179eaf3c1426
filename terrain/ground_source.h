// The ground as a renderer takes it: tiles that can be read band by band, from coarse to fine, as the view asks for them.
//
//   renderer.load_ground(terrain.ground());  // in memory, or in the file that --ground-cache keeps
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/result.h"
#include "terrain/terrain.h"

namespace roadgen {

// A TerrainMesh that lies elsewhere. What the spans of vertices and nodes hold may be read as far as bands are loaded;
// bands, cuts and all else always.
struct GroundTile {
  glm::dvec3 origin_m{0, 0, 0};
  glm::vec3 low_m{0, 0, 0}, high_m{0, 0, 0};  // the box of its vertices, relative to the origin
  std::span<const glm::vec3> positions_m, normals;
  std::span<const float> road_m, vertex_error_m, vertex_radius_m;
  std::span<const TerrainMesh::Node> nodes;
  std::array<std::array<std::uint32_t, 3>, 2> roots{};
  std::span<const TerrainMesh::Band> bands;  // at least one; without nodes just one
  std::span<const std::uint32_t> triangles;  // that are not cut, where there are no nodes
  std::span<const std::uint32_t> cut_triangles;
  std::span<const TerrainMesh::Cut> cuts;  // `first` counts from the first of those that are not cut
  std::span<const Hollow> hollows;

  glm::dvec3 center_m() const { return origin_m + 0.5 * (glm::dvec3(low_m) + glm::dvec3(high_m)); }
  double radius_m() const { return 0.5 * glm::length(glm::dvec3(high_m) - glm::dvec3(low_m)); }
  std::size_t triangle_count() const {
    return nodes.empty() ? (triangles.size() + cut_triangles.size()) / 3 : nodes.size() / 2 + 1;
  }
  // Of the first bands, on their way from a file.
  std::size_t bytes(std::uint32_t band_count) const;
};

// The same tile. Requires: it outlives the result; TerrainMesh::bands, where there are nodes.
GroundTile view_of(const TerrainMesh& tile);

class GroundSource {
 public:
  virtual ~GroundSource() = default;
  // The same as long as this lives. None is without vertices.
  virtual std::span<const GroundTile> tiles() const = 0;
  // Whether all is at hand, so that load() has nothing to do.
  virtual bool is_in_memory() const = 0;
  // Reads the bands first to last - 1 of a tile, so that they are at hand; until then reading them may wait for a disk. Any
  // number of threads may. Errors: kData, kIo.
  virtual Status load(std::size_t tile, std::uint32_t first, std::uint32_t last) const = 0;
  // Gives the memory of a tile back; it may be loaded again.
  virtual void release(std::size_t tile) const = 0;
};

// Those that have triangles. Cost: O(vertices).
std::shared_ptr<const GroundSource> ground_in_memory(std::shared_ptr<const std::vector<TerrainMesh>> tiles);

// The way back: all tiles, whole. Empty tiles are left out.
std::vector<TerrainMesh> meshes_of(const GroundSource& source);

}  // namespace roadgen
