// The terrain of a road network: natural ground levelled along the roads, as a mesh without cracks that lies below
// every carriageway, and the height of that very mesh for contact queries.
//
//   auto dem = Elevation::open("dem.tif");
//   auto terrain = Terrain::build(network, &*dem, {});
//   for (const TerrainMesh& tile : terrain->tiles()) draw(tile);
//   double z = terrain->height_m({x, y});          // seen from above
//   double below = terrain->height_m({x, y, z0});  // of a wheel, perhaps in a tunnel
//
// Source: Loviscach 2005, section 4 and figure 6.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/network.h"
#include "roadgen/road/result.h"
#include "terrain/elevation.h"
#include "terrain/hollow.h"
#include "terrain/levelling.h"
#include "terrain/natural.h"
#include "terrain/overlap.h"

namespace roadgen {

class GroundSource;

struct TerrainOptions {
  // How far the terrain reaches beyond the roads' bounds; less where the elevation ends before. > 0. Default: 1.5 km
  double margin_m = 1500;
  // Distance of the mesh's posts under the carriageways, about; where roads at different heights lie side by side, and
  // in ditches, down to an eighth of it, but not below 0.2 m. [0.25, 16]. Default: 2 m
  double spacing_m = 2;
  LevellingOptions
      levelling;  // shoulder_m is raised to 1.5 spacing_m where it is less, lest triangles bend under a road
  // The guarantee: how far at least every carriageway lies above the ground, and how far at most where the ground is
  // levelled to it. 0 < least < most. The ground is aimed at levelling.gap_m below the road; triangles whose proven
  // clearance is less than the least are lowered, those of which some would then come to more than the most are divided
  // as long as spacing_m allows. Defaults: 2 cm, 12 cm
  double least_clearance_m = 0.02;
  double most_clearance_m = 0.12;
  // What the mesh may deviate from the levelled ground: tolerance_m at the roads, and tolerance_per_m more for every
  // metre away from them. > 0. Default: 0.12 m and 2 mm per metre, about 2 pixels at 60 degrees and 1080 lines
  double tolerance_m = 0.12;
  double tolerance_per_m = 0.002;
  // The tolerances are raised until the mesh has no more triangles. Where the carriageways alone would take more than
  // half of them, spacing_m is raised too, to at most 4 m; beyond that the mesh is larger: the claim goes first.
  std::size_t max_triangles = 400000;
  double rolling_m = 40;  // height of the hills away from the roads where there is no elevation. >= 0
  std::function<void(double fraction)> progress;  // called now and then with 0 to 1; may be empty
};

// A square tile of the mesh, 0.5 to 1 km wide (more in worlds beyond 50 km). Positions are floats relative to the origin
// and exact: multiples of kQuantum_m, as origins are, so that neighbouring tiles meet without a gap.
struct TerrainMesh {
  static constexpr double kQuantum_m = 1.0 / 1024;
  static constexpr double kVerge_m = 16;
  glm::dvec3 origin_m{0, 0, 0};
  std::vector<glm::vec3> positions_m;    // relative to origin_m
  std::vector<glm::vec3> normals;        // unit, of the levelled ground itself, not of the triangles
  std::vector<float> road_m;             // from the nearest carriageway on the ground, at most kVerge_m; empty: far
  std::vector<std::uint32_t> triangles;  // three vertices each, counter-clockwise seen from above
  // Triangles that may reach into tunnels come last, in groups: what of a group lies in one of its hollows is cut away.
  struct Cut {
    std::uint32_t first = 0, count = 0;  // of triangles, as indices into it
    std::vector<std::uint32_t> hollows;  // of the tile's
  };
  std::vector<Cut> cuts;
  std::vector<Hollow> hollows;
  // How many of the indices in `triangles` come before those of the cuts.
  std::size_t whole() const { return cuts.empty() ? triangles.size() : cuts.front().first; }

  // How `triangles` came about, from the tile's two halves on, for select_triangles() of terrain/detail.h; empty where
  // there is one level of detail only.
  struct Node {
    static constexpr std::int32_t kLeaf = -1, kCut = -2;  // one of `triangles`; among those of the cuts
    std::int32_t child;    // of two, side by side: (middle; apex, left), (middle; right, apex)
    std::uint32_t middle;  // vertex, halfway from left to right
  };
  std::vector<Node> nodes;
  std::array<std::array<std::uint32_t, 3>, 2> roots{};  // vertices of nodes[0] and nodes[1]: apex, left, right
  std::vector<float> error_m, radius_m;                 // of the vertices, as in VertexDetail
  // Where there are nodes, vertices go from those whose lack would be seen most to those whose lack least, and nodes with
  // them: a band is as many as make the mesh finer by about two, and what is up to its end is a mesh of its own. The first
  // holds what is never left out, and all of the cuts.
  struct Band {
    std::uint32_t vertices, nodes;  // up to its end
    float error_m, radius_m;        // the greatest of its own vertices
  };
  std::vector<Band> bands;
};

struct TerrainReport {
  // Of the carriageways above the triangles, by bounds that hold everywhere, not by samples (terrain/plates.h). Least: at
  // least least_clearance_m, of all carriageways, at every level of detail. Greatest: of those that the ground is levelled
  // to, which bridges and roads over others are not; more than most_clearance_m where roads overlap at different heights
  // or lie closer than the finest posts. Coarser levels come to more by at most what they deviate from the finest.
  double clearance_min_m = 0, clearance_max_m = 0;
  glm::dvec2 clearance_max_at_m{0, 0};  // a corner of the triangle where that is
  // Of the triangles under roads, by area, the part that exceeds most_clearance_m; that of it next to two carriageways above
  // one another, where no ground is just below both; and how many triangles these are.
  double too_deep = 0, too_deep_by_overlap = 0;
  std::size_t triangles_too_deep = 0, triangles_too_deep_by_overlap = 0;
  // Carriageways over others, on no bridge, that the ground is not levelled to; places of these and of the overlaps above,
  // more than kOverlapPlaces_m apart, worst first; how many there are of them.
  static constexpr double kOverlapPlaces_m = 30;
  double over_others_m2 = 0;
  std::array<Overlap, 16> overlaps{};
  std::size_t overlap_places = 0;
  std::size_t triangles_under_roads = 0;  // that the guarantee was proven for
  std::size_t triangles_lowered = 0;      // of them, and how far at most
  double lowered_max_m = 0;
  // Of the carriageways on the ground against the natural one, along the centre.
  double deepest_cut_m = 0, highest_fill_m = 0;
  std::size_t bridge_parts = 0;  // parts of roads on bridges, and their length
  double bridge_m = 0;
  // The same of roads over others that the network knows no bridge of.
  std::size_t assumed_bridge_parts = 0;
  double assumed_bridge_m = 0;
  std::size_t tunnel_parts = 0;  // in tunnels under a hill that is kept, and their length
  double tunnel_m = 0;
  std::size_t tunnel_areas = 0;   // junctions' areas in such tunnels
  std::size_t triangles_cut = 0;  // that reach into these tunnels
  std::size_t voids_filled = 0;
  std::size_t triangles = 0, vertices = 0, tiles = 0;
  std::size_t triangles_coarsest = 0;  // at the coarsest level that leaves every road above the ground
  double spacing_m = 0;                // of the mesh's posts under the carriageways, as used
  double finest_spacing_m = 0;         // and of those between roads at different heights
  double natural_spacing_m = 0;  // of the posts that the natural ground was sampled at: 0.6 of the elevation's own,
                                 // more where the area is greater than 2048 of them
  double tolerance_factor = 1;   // what max_triangles has raised the tolerances by
  Rectangle area;                // of the mesh
  double seconds = 0;            // wall clock of the build
};

// Immutable after build(): any number of threads may ask.
class Terrain {
 public:
  // The terrain of a network; without elevation (nullptr) the roads' own heights make the ground.
  // No terrain shows through any carriageway: at every point of it the mesh is at least least_clearance_m lower. Where a
  // hill covers a tunnel, no triangle but those of TerrainMesh::cuts reaches into the tunnel's clear space.
  // Errors: no roads; the elevation does not cover them (both extents in degrees); options out of range (kUsage).
  // Cost: about 1 s per 100 000 triangles.
  static Result<Terrain> build(const Network& network, const Elevation* elevation, const TerrainOptions& options = {});

  ~Terrain();
  Terrain(Terrain&&) noexcept;
  Terrain& operator=(Terrain&&) noexcept;

  // Of a terrain that was read from a file they are read when first asked for, all of them.
  const std::vector<TerrainMesh>& tiles() const;
  // The same for a renderer, which reads what it draws; it may outlive this.
  std::shared_ptr<const GroundSource> ground() const;
  const TerrainReport& report() const;

  // Height of the mesh, as drawn; outside its area that of the nearest place of its border. Over tunnels the hill's; at
  // their portals also where a part of a triangle is cut away, to be looked through. Cost: O(log), some 0.1 us.
  double height_m(glm::dvec2 point_m) const;
  // Of many points, the same heights in less time. Requires: as many of both.
  void heights_m(std::span<const glm::dvec2> points_m, std::span<double> heights_m) const;
  // Unit normal of the triangle there.
  glm::dvec3 normal(glm::dvec2 point_m) const;

  // The same under a point whose height tells the hill over a tunnel from the tunnel: where the point lies below the
  // vault, the tunnel's floor, which is the walkways' top and between them the carriageway's surface without raised
  // lanes; in a junction's area in tunnels its surface; elsewhere the mesh. So of a place of the mesh that is cut away the floor is told. Tunnels that are cut open have
  // no floor but the ground. Cost: as above, and 1 us near tunnels.
  double height_m(glm::dvec3 point_m) const;
  glm::dvec3 normal(glm::dvec3 point_m) const;

 private:
  friend Status write_terrain_file(const Terrain& terrain, std::uint64_t key, const std::string& path);
  friend Result<Terrain> read_terrain_file(const std::string& path, std::uint64_t key);
  struct Impl;
  explicit Terrain(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// The terrain's heights in the datum of the network, on a longitude/latitude grid with posts post_m apart, as GeoTIFF.
// Errors: no georeference; more than 2^28 posts; not writable.
// datum, geoid: what the heights are measured from, for the file to say.
Status write_terrain(const Terrain& terrain, const Network& network, double post_m, const std::string& path,
                     VerticalDatum datum = VerticalDatum::kUnknown, const std::string& geoid = {});

}  // namespace roadgen
