// Level of detail of the terrain's mesh: triangles joined where nobody sees it, without cracks, and never so that ground
// comes through a road.
//
// The mesh was made by halving triangles. Leaving a halving out joins four triangles about its vertex to two; what that
// changes is known: how far the mesh moves, in height, at most. A vertex is kept if that is more than the eye's distance
// from all that depends on it allows. Both are made to grow from a vertex to those that it depends on, so whatever is kept
// makes a mesh without gaps, also where two tiles meet, which choose each for itself.
// Source: Lindstrom and Pascucci 2002 (nested errors and spheres); Duchaineau et al. 1997.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace roadgen {

class Bisection;
class Horizon;
struct GroundTile;
struct TerrainMesh;

// What each vertex of a bisection's mesh is worth; index: the bisection's vertices.
struct VertexDetail {
  // How far the mesh is from where it would be without the vertex and all that depend on it, at most, m; grows from a
  // vertex to those it depends on. Infinite: never left out.
  std::vector<float> error_m;
  std::vector<float> radius_m;  // of a sphere about the vertex that holds those of all that depend on it
};

// The details of a mesh. unit_m: of its lattice. is_sound: whether a triangle that stands for those it was halved into may
// be drawn; asked from several threads, of triangles whose every part may be.
// Cost: O(triangles) and a question for each.
VertexDetail vertex_detail(const Bisection& mesh, double unit_m, const std::function<bool(std::int32_t)>& is_sound);

// Orders a tile's vertices and nodes as TerrainMesh::bands has it, and the triangles that are not cut as select_triangles()
// gives them all. Requires: nodes, and the vertices' errors and radii; every node after the one it hangs from. Cost:
// O(n log n).
void order_by_error(TerrainMesh& tile);

// A tile of which only the first bands are there.
struct DetailGap {
  glm::dvec2 low_m{0, 0}, high_m{0, 0};  // the tile, ENU
  double error_m = 0, radius_m = 0;      // the greatest of the vertices that are not there
  bool operator==(const DetailGap&) const = default;
};

// From where and how finely the ground is looked at.
struct Detail {
  glm::dvec3 eye_m{0, 0, 0};  // ENU
  double room_m = 0;          // the eye may also be this far from there. >= 0
  double part = 0;            // of its distance from the eye by which the mesh may be off. >= 0; 0: all of it is drawn
  // Tiles that lack vertices: all whose choice could touch them is made without these.
  std::vector<DetailGap> gaps = {};
};

// The gap of a tile of which only the first bands are there. Requires: at least one, and not all.
DetailGap gap_of(const GroundTile& tile, std::uint32_t bands);

// How many bands of a tile the detail asks for, if there are no gaps. Requires: the tile has nodes. Cost: O(bands).
std::uint32_t bands_needed(const GroundTile& tile, const Detail& detail);

// Replaces `triangles` by those of the tile that are to be drawn so, counter-clockwise; but for those of its cuts, which are
// always drawn. Reads the first `bands` of its bands only. Tiles that are looked at with the same Detail fit together.
// Those nearer to the eye come first. With a horizon, what is hidden from its eye is left out, and what is drawn added to it:
// tiles have to be asked for from near to far.
// Requires: as many bands as are needed, or else a gap for the tile in `detail`, of what is not there. Cost: O(triangles).
void select_triangles(const GroundTile& tile, std::uint32_t bands, const Detail& detail,
                      std::vector<std::uint32_t>& triangles, Horizon* horizon = nullptr);

// What a renderer holds of the ground, and what the last picture or set of channels took.
struct GroundStatistics {
  std::size_t tiles = 0, triangles = 0;
  std::size_t drawn_tiles = 0, drawn_triangles = 0;
  std::size_t batches = 0;         // draws of what the GPU held at once; more than one where that was not all
  std::size_t uploaded_bytes = 0;  // of vertices
  std::size_t waiting_tiles = 0;   // drawn coarser than asked for, while the rest was being read
  std::size_t gpu_bytes = 0;       // of vertices and indices; at most RendererOptions::ground_budget_bytes
  std::size_t loaded_bytes = 0;    // read from a file and still held
};

}  // namespace roadgen
