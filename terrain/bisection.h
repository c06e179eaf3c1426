// Adaptive triangulation of a height field without cracks, by bisection of right triangles at their longest edge.
//
// The plane is a rectangle of square tiles, each of 2^k x 2^k lattice cells and cut into two triangles by a diagonal. A
// triangle is refined by halving its hypotenuse; the triangle on the other side of it is halved with it, after having
// been refined itself where it is larger. So every edge has the same two end points on both of its sides.
// Source: Rivara 1984 (longest-edge bisection); Duchaineau et al. 1997 (ROAM: splits forced on the neighbour).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

class Bisection {
 public:
  // A triangle, counter-clockwise seen from above: apex, left, right; the hypotenuse runs from left to right.
  struct Triangle {
    std::uint32_t apex = 0, left = 0, right = 0;                         // vertices
    std::int32_t across_base = -1, across_left = -1, across_right = -1;  // neighbours; -1: border
    std::int32_t level = 0;  // bisections from the tile; the legs halve every two
  };

  using Height = std::function<double(glm::ivec2 lattice)>;
  using Wanted = std::function<bool(const Triangle&)>;

  // Requires: tiles >= 1 each way, 1 <= k <= 14, tiles * 2^k < 2^30. Heights of the corners are asked at once. height and
  // what refine() is given are asked from several threads.
  Bisection(glm::ivec2 tiles, int k, Height height);

  // Splits every triangle that wanted() wants split and that is not of the finest level, until none is or there are
  // more than most_triangles. False in the latter case. Cost: O(triangles).
  bool refine(const Wanted& wanted, std::size_t most_triangles);

  std::size_t leaves() const { return leaves_; }
  std::size_t vertices() const { return lattice_.size(); }
  glm::ivec2 lattice(std::uint32_t vertex) const { return lattice_[vertex]; }
  double height(std::uint32_t vertex) const { return heights_[vertex]; }
  void set_height(std::uint32_t vertex, double height_m) { heights_[vertex] = height_m; }
  const Triangle& triangle(std::int32_t i) const { return triangles_[static_cast<std::size_t>(i)]; }

  // Calls visit(index) for every leaf, in no order.
  template <class Visit>
  void each_leaf(Visit&& visit) const {
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (child_[i] < 0) visit(static_cast<std::int32_t>(i));
    }
  }
  // And for every triangle that was halved.
  template <class Visit>
  void each_halved(Visit&& visit) const {
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      if (child_[i] >= 0) visit(static_cast<std::int32_t>(i));
    }
  }
  std::vector<std::int32_t> all_leaves() const {
    std::vector<std::int32_t> leaves;
    leaves.reserve(leaves_);
    each_leaf([&](std::int32_t i) { leaves.push_back(i); });
    return leaves;
  }
  std::size_t triangle_count() const { return triangles_.size(); }  // halved ones too
  // The first of the two that a triangle was halved into: (middle; apex, left), after it (middle; right, apex). -1: a leaf.
  std::int32_t child(std::int32_t i) const { return child_[static_cast<std::size_t>(i)]; }
  // The first of a tile's two triangles, side by side.
  std::int32_t root(glm::ivec2 tile) const { return 2 * (tile.y * tiles_.x + tile.x); }
  int finest() const { return 2 * k_; }  // level

  glm::ivec2 tiles() const { return tiles_; }
  int cells() const { return 1 << k_; }  // of a tile, each way

 private:
  void split(std::int32_t i);
  void halve(std::int32_t i, std::uint32_t middle);
  void relink(std::int32_t neighbour, std::int32_t from, std::int32_t to);
  Triangle& at(std::int32_t i) { return triangles_[static_cast<std::size_t>(i)]; }

  glm::ivec2 tiles_;
  int k_;
  Height height_;
  std::size_t leaves_ = 0;
  std::vector<Triangle> triangles_;  // the first two of every tile, then children
  std::vector<std::int32_t> child_;  // of each: the first of two, side by side; -1: a leaf
  std::vector<glm::ivec2> lattice_;
  std::vector<double> heights_;
};

}  // namespace roadgen
