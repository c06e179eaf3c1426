// What a Terrain holds, for terrain.cc, which builds it, and terrain_file.cc, which keeps it. Internal to terrain.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "terrain/bisection.h"
#include "terrain/detail.h"
#include "terrain/ground_source.h"
#include "terrain/height_mesh.h"
#include "terrain/plates.h"
#include "terrain/terrain.h"

namespace roadgen {

constexpr double kQuantum_m = TerrainMesh::kQuantum_m;

// Heights of the levelled ground near roads, where they take long and are asked for again and again: by the triangles
// on both sides of an edge, for its vertex when it is halved, by neighbours for normals. Any number of threads may ask.
class KnownHeights {
 public:
  explicit KnownHeights(const Levelling& ground) : ground_(ground) {}
  // quarters: of the lattice's unit, the place in which that is point_m.
  double height_m(glm::ivec2 quarters, glm::dvec2 point_m) const {
    if (ground_.is_natural(point_m)) return ground_.height_m(point_m);
    const std::uint64_t key = static_cast<std::uint64_t>(static_cast<std::uint32_t>(quarters.x)) << 32 |
                              static_cast<std::uint32_t>(quarters.y);
    Shelf& shelf = shelves_[(key * 0x9e3779b97f4a7c15u) >> 56];
    {
      const std::lock_guard<std::mutex> lock(shelf.mutex);
      const auto found = shelf.heights.find(key);
      if (found != shelf.heights.end()) return found->second;
    }
    const double height = ground_.height_m(point_m);
    const std::lock_guard<std::mutex> lock(shelf.mutex);
    shelf.heights.emplace(key, height);
    return height;
  }
  const Levelling& ground() const { return ground_; }

 private:
  struct Shelf {
    std::mutex mutex;
    std::unordered_map<std::uint64_t, double> heights;
  };
  const Levelling& ground_;
  mutable std::array<Shelf, 256> shelves_;
};

struct Terrain::Impl {
  TerrainOptions options;
  TerrainReport report;
  std::vector<TerrainMesh> tiles;  // while they are made
  std::shared_ptr<const GroundSource> stored;
  std::shared_ptr<const std::vector<TerrainMesh>> meshes;  // its tiles; of a file, once they were asked for
  std::once_flag meshes_read;
  double unit_m = 1;  // of the lattice
  glm::dvec2 origin_m{0, 0};
  int k = 9;
  int finer = 0;  // how often posts may be divided that are options.spacing_m apart
  glm::ivec2 tile_count{1, 1};
  std::unique_ptr<Bisection> mesh;  // while it is built
  HeightMesh heights;
  std::vector<Hollow> hollows;
  std::vector<Hall> halls;
  BoxTree hollow_tree, hall_tree;

  double post_m() const { return unit_m * (1 << finer); }
  bool is_finer(const Bisection::Triangle& t) const { return t.level >= mesh->finest() - 2 * finer; }
  glm::dvec2 to_world(glm::dvec2 lattice) const { return origin_m + unit_m * lattice; }
  glm::dvec2 to_lattice(glm::dvec2 point_m) const { return (point_m - origin_m) / unit_m; }

  void keep(std::shared_ptr<const std::vector<TerrainMesh>> all);
  void lay_out(const Network& network, const Elevation* elevation);
  Grid natural_ground(const Network& network, const Elevation* elevation) const;
  std::array<glm::dvec3, 3> corners(const Bisection::Triangle& t) const;
  double height_m(const KnownHeights& ground, glm::dvec2 lattice) const {
    return ground.height_m(glm::ivec2(4.0 * lattice), to_world(lattice));
  }
  bool is_wanted(const KnownHeights& ground, const Plates& roads, const Bisection::Triangle& t, double factor) const;
  bool may_divide(const Bisection::Triangle& t, const std::optional<Overlap>& overlap) const;
  std::optional<Overlap> overlap(const Plates& roads, const Bisection::Triangle& t) const;
  void triangulate(const KnownHeights& ground, const Plates& roads);
  void guarantee(const Plates& roads);
  void bound_clearances(const Plates& roads, std::vector<ClearanceBounds>& aimed) const;
  std::vector<double> lower(const std::vector<ClearanceBounds>& aimed);
  std::vector<std::int32_t> prove(const Plates& roads, const std::vector<ClearanceBounds>& aimed,
                                  const std::vector<double>& lowered);
  void tell_overlaps(const Plates& roads, std::vector<Overlap> found);
  void measure(const Network& network, const Supports& supports, const Grid& natural);
  void index_hollows();
  std::vector<std::uint32_t> hollows_met(const std::array<glm::dvec3, 3>& triangle) const;
  const Hollow* hollow_above(glm::dvec3 point_m) const;
  const Hall* hall_above(glm::dvec3 point_m) const;
  void add_cuts(const std::map<std::vector<std::uint32_t>, std::vector<std::uint32_t>>& cut, TerrainMesh& out);
  VertexDetail detail(const Plates& roads);
  void emit(const KnownHeights& ground, const VertexDetail& detail);
  void tell(double fraction) const {
    if (options.progress) options.progress(fraction);
  }
};

}  // namespace roadgen
