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

#include <glm/vec3.hpp>

namespace roadgen {

class Bisection;
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

// From where and how finely the ground is looked at.
struct Detail {
  glm::dvec3 eye_m{0, 0, 0};  // ENU
  double room_m = 0;          // the eye may also be this far from there. >= 0
  double part = 0;            // of its distance from the eye by which the mesh may be off. >= 0; 0: all of it is drawn
};

// Replaces `triangles` by those of the tile that are to be drawn so, counter-clockwise; but for those of its cuts, which are
// always drawn. Tiles that are looked at with the same Detail fit together. Cost: O(triangles).
void select_triangles(const TerrainMesh& tile, const Detail& detail, std::vector<std::uint32_t>& triangles);

// What a renderer holds of the ground, and what the last picture or set of channels took.
struct GroundStatistics {
  std::size_t tiles = 0, triangles = 0;
  std::size_t drawn_tiles = 0, drawn_triangles = 0;
};

}  // namespace roadgen
