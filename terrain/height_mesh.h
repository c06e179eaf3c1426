// Heights of a bisection's mesh, and nothing else: what wheels ask for, laid out so that a query reads little memory.
//
// A place is carried down the halvings in the coordinates (a, b) of the triangle that holds it, p = apex + a (left - apex)
// + b (right - apex). Halved at the middle of its hypotenuse, they become (1 - a - b, a - b) on the left and (b - a,
// 1 - a - b) on the right: two differences and no multiplication, in fixed point and so without rounding. At the leaf they
// are the weights of its corners' heights, which stand side by side.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

class Bisection;

class HeightMesh {
 public:
  // The heights of a leaf's corners, in quanta.
  struct Leaf {
    std::int32_t apex, left, right;
  };
  HeightMesh() = default;
  // Requires: every height is a multiple of quantum_m, below 2^31 of them. Cost: O(triangles); 20 bytes a triangle.
  HeightMesh(const Bisection& mesh, double quantum_m);
  // One that lies elsewhere, such as in a file; `owner` keeps it there.
  HeightMesh(glm::ivec2 tiles, int k, double quantum_m, std::span<const std::int32_t> nodes,
             std::span<const Leaf> leaves, std::shared_ptr<const void> owner);
  std::span<const std::int32_t> nodes() const { return nodes_; }
  std::span<const Leaf> leaves() const { return leaves_; }
  // Whether every step from any root arrives at a leaf: nodes point onward. Cost: O(nodes).
  bool is_sound() const;

  // The height at a place in lattice units, clamped to the mesh. Cost: O(k), some 50 ns.
  double height_m(glm::dvec2 place) const;
  // Of many places: the next steps of several are fetched while one waits for memory. Requires: as many of both.
  void heights_m(std::span<const glm::dvec2> places, std::span<double> heights_m) const;
  // The slope of the triangle there, m per lattice unit.
  glm::dvec2 gradient(glm::dvec2 place) const;

 private:
  static constexpr int kLanes = 16;  // of heights_m()
  // Where a place is: in the triangle of nodes_[node].
  struct At {
    std::int64_t a, b;
    std::int32_t node;
  };
  At start(glm::dvec2 place) const;
  // Steps into the half that holds the place, of which node is the first; returns which.
  static std::int32_t step(At& at);
  double height_m(const At& at) const;

  glm::ivec2 tiles_{1, 1};
  int k_ = 1;
  double quantum_m_ = 1;
  // The first two of every tile, below its diagonal and above; then those of halved triangles, side by side. Of a triangle
  // that is halved: where its halves are; of a leaf: ~ its place in leaves_.
  std::span<const std::int32_t> nodes_;
  std::span<const Leaf> leaves_;
  std::shared_ptr<const void> owner_;
};

}  // namespace roadgen
