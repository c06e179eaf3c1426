// A static tree of boxes: which of many boxes may be near a point.
//
// Every node holds up to 16 boxes in single precision, relative to the middle of all and rounded outward, so that
// nothing near is missed; a box is an inner node's or one item's own. Distances to them are taken side by side.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/query/large_pages.h"

namespace roadgen {

struct Box {
  glm::dvec3 low_m, high_m;
};

// How far a thing is, where height tells: its vertical distance in steps of kSameHeight_m and, where it is not below or
// above the point, kBeside_m and kPerBeside times its horizontal distance. So a road that holds the point is left for one
// beside it only where that is much nearer in height; slopes below kPerBeside and kerbs never decide.
inline constexpr double kSameHeight_m = 0.01;
inline constexpr double kBeside_m = 1;
inline constexpr double kPerBeside = 2;
inline double beside_cost_m(double horizontal_m) {
  return horizontal_m > 0 ? kBeside_m + kPerBeside * horizontal_m : 0;
}
inline double height_cost_m(double vertical_m) {
  return kSameHeight_m * std::floor(std::abs(vertical_m) * (1 / kSameHeight_m) + 0.5);
}

// What a search still wants: boxes within reach_m horizontally, whose cost is at most cost_m; whether heights count.
struct SearchLimits {
  double reach_m = std::numeric_limits<double>::infinity();
  double cost_m = std::numeric_limits<double>::infinity();
  bool heights = false;
};

// Asks for memory that will soon be read.
inline void prefetch(const void* at, std::size_t bytes) {
  for (std::size_t i = 0; i < bytes; i += 64) __builtin_prefetch(static_cast<const char*>(at) + i);
}

class BoxTree {
 public:
  // Boxes are widened by this, so that a point this near counts as inside.
  static constexpr double kMargin_m = 1e-7;

  BoxTree() = default;
  // Requires: finite boxes, fewer than 2^31 - 1. Cost: O(n log^2 n).
  explicit BoxTree(const std::vector<Box>& boxes);

  std::size_t bytes() const { return nodes_.size() * sizeof(Node); }

  // Calls visit(item) for every item whose box is within the limits of the box `about` (a point, or an item's own box),
  // roughly the cheaper ones first; and for some that are a little farther. visit may lessen the limits. No allocation.
  // Requires: finite `about`. Cost: O(log n) for boxes that do not all overlap.
  template <class Visit>
  void search(const Box& about, const SearchLimits& limits, Visit&& visit) const;

  // The same search step by step, so that several may run in turn and none waits for memory.
  class Walk;

 private:
  static constexpr std::uint32_t kWidth = 16;
  static constexpr std::uint32_t kFours = kWidth / 4;
  static constexpr std::uint32_t kItem = 0x80000000u;     // in a child: not a node but an item
  static constexpr std::uint32_t kNoChild = 0xffffffffu;  // whose box is farther than any
  // Side by side by the compiler's vectors (GCC, Clang), which every processor has in one form or another.
  using Four = float __attribute__((vector_size(16)));
  using Fours = std::int32_t __attribute__((vector_size(16)));  // what comparing them gives: 0 or -1
  static Four greater(Four a, Four b) { return a > b ? a : b; }
  // One bit for each that is -1.
  static std::uint32_t bits(Fours a) {
#if defined(__SSE__)
    return static_cast<std::uint32_t>(__builtin_ia32_movmskps(std::bit_cast<Four>(a)));
#else
    return static_cast<std::uint32_t>((a[0] & 1) | (a[1] & 2) | (a[2] & 4) | (a[3] & 8));
#endif
  }

  struct alignas(64) Node {
    Four low[3][kFours];
    Four high[3][kFours];
    std::uint32_t child[kWidth];
  };
  static_assert(sizeof(Node) == 448);  // seven cache lines
  // A child on the stack, written and read as one vector: where parts of it are read together soon after they were written
  // singly, a processor waits for memory.
  struct Waiting {
    Four all;  // squared horizontal distance; what the vertical one costs; the child
    Waiting() = default;
    Waiting(float plane2, float gap, std::uint32_t child) : all{plane2, gap, std::bit_cast<float>(child), 0} {}
    float plane2() const { return all[0]; }
    float gap() const { return all[1]; }
    std::uint32_t child() const { return std::bit_cast<std::uint32_t>(all[2]); }
  };
  // Deep enough for 2^31 items: of each of 8 levels all but one child wait.
  static constexpr std::size_t kStack = 8 * (kWidth - 1) + 1;

  struct Builder;

  // Single precision that is not above, or not below, x.
  static float below(double x) {
    if (x > 1e30) return 1e30f;
    if (x < -1e30) return -std::numeric_limits<float>::infinity();
    const float f = static_cast<float>(x);
    if (!(static_cast<double>(f) > x)) return f;
    return f - std::max(1e-37f, 1.2e-7f * std::abs(f));
  }
  static float above(double x) { return -below(-x); }

  glm::dvec3 origin_m_{0, 0, 0};
  std::uint32_t root_ = 0;
  LargeVector<Node> nodes_;
};

class BoxTree::Walk {
 public:
  static constexpr std::uint32_t kNode = 0xffffffffu, kDone = 0xfffffffeu;

  // Items' own memory, asked for in advance: item i at first + i * bytes, for i < count.
  struct Memory {
    const void* first = nullptr;
    std::size_t bytes = 0, count = 0;
  };

  // Begins a search. Before the first there is nothing to be stepped.
  void begin(const BoxTree& tree, const Box& about, const SearchLimits& limits, const Memory& memory);
  // An item to visit; kNode: nothing yet, go on; kDone.
  std::uint32_t step();
  // An item to visit; kDone.
  std::uint32_t next();
  // Takes a lessened limit of the cost.
  void limit(double cost_m) { most_ = above(cost_m * kRounding); }

 private:
  static constexpr double kRounding = 1 + 1e-6;  // of the sums and squares in single precision

  std::uint32_t advance();
  void put(std::uint32_t place, const Waiting& child);
  void push(const Node& node, const Four (&plane2)[kFours], const Four (&gap)[kFours], std::uint32_t near);

  const BoxTree* tree_;
  Memory memory_;
  float low_[3], high_[3];
  float reach2_, most_;
  bool heights_;
  std::uint32_t top_;
  Waiting stack_[kStack];
};

template <class Visit>
void BoxTree::search(const Box& about, const SearchLimits& limits, Visit&& visit) const {
  Walk walk;
  walk.begin(*this, about, limits, {});
  for (std::uint32_t item = walk.next(); item != Walk::kDone; item = walk.next()) {
    visit(item);
    walk.limit(limits.cost_m);
  }
}

}  // namespace roadgen
