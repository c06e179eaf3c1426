// A static tree of boxes: which of many boxes may be near a point.
//
// Every node holds up to eight boxes in single precision, relative to the middle of all and rounded outward, so that
// nothing near is missed; a box is an inner node's or one item's own. Distances to the eight are taken side by side.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <glm/vec3.hpp>

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

class BoxTree {
 public:
  // Boxes are widened by this, so that a point this near counts as inside.
  static constexpr double kMargin_m = 1e-7;

  BoxTree() = default;
  // Requires: finite boxes, fewer than 2^31. Cost: O(n log^2 n).
  explicit BoxTree(const std::vector<Box>& boxes);

  std::size_t bytes() const { return nodes_.size() * sizeof(Node); }

  // Calls visit(item) for every item whose box is within the limits of the box `about` (a point, or an item's own box),
  // roughly the cheaper ones first; and for some that are a little farther. visit may lessen the limits. No allocation.
  // Requires: finite `about`. Cost: O(log n) for boxes that do not all overlap.
  template <class Visit>
  void search(const Box& about, const SearchLimits& limits, Visit&& visit) const;

 private:
  static constexpr std::uint32_t kWidth = 8;
  static constexpr std::uint32_t kItem = 0x80000000u;  // in a child: not a node but an item
  struct alignas(64) Node {
    float low[3][kWidth];
    float high[3][kWidth];
    std::uint32_t child[kWidth];
    std::uint32_t count;
  };
  struct Waiting {
    float cost;
    std::uint32_t child;
  };
  // Deep enough for 2^31 items: of each of 11 levels all but one child wait.
  static constexpr std::size_t kStack = 11 * (kWidth - 1) + 1;

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
  std::vector<Node> nodes_;
};

template <class Visit>
void BoxTree::search(const Box& about, const SearchLimits& limits, Visit&& visit) const {
  if (nodes_.empty()) return;
  float low[3], high[3];
  for (int k = 0; k < 3; ++k) {
    low[k] = below(about.low_m[k] - origin_m_[k]);
    high[k] = above(about.high_m[k] - origin_m_[k]);
  }
  float reach2 = 0, most = 0;
  const auto take_limits = [&] {
    constexpr double kRounding = 1 + 1e-6;  // of the sums and squares in single precision
    reach2 = above(limits.reach_m * limits.reach_m * kRounding);
    most = above(limits.cost_m * kRounding);
  };
  take_limits();
  Waiting stack[kStack];
  std::size_t top = 0;
  stack[top++] = {0, root_};
  while (top > 0) {
    const Waiting at = stack[--top];
    if (at.cost > most) continue;
    if (at.child & kItem) {
      visit(at.child & ~kItem);
      take_limits();
      continue;
    }
    const Node& node = nodes_[at.child];
    float plane2[kWidth], cost[kWidth];
    for (std::uint32_t i = 0; i < kWidth; ++i) {
      const float dx = std::max(std::max(node.low[0][i] - high[0], low[0] - node.high[0][i]), 0.0f);
      const float dy = std::max(std::max(node.low[1][i] - high[1], low[1] - node.high[1][i]), 0.0f);
      plane2[i] = dx * dx + dy * dy;
      cost[i] =
          plane2[i] > 0 ? static_cast<float>(kBeside_m) + static_cast<float>(kPerBeside) * std::sqrt(plane2[i]) : 0;
    }
    if (limits.heights) {
      for (std::uint32_t i = 0; i < kWidth; ++i) {
        const float gap = std::max(node.low[2][i] - high[2], low[2] - node.high[2][i]);
        cost[i] += std::max(gap - static_cast<float>(kSameHeight_m), 0.0f);  // at least, whichever way it is rounded
      }
    }
    // Into the stack by cost, the least on top.
    const std::size_t bottom = top;
    for (std::uint32_t i = 0; i < node.count; ++i) {
      if (plane2[i] > reach2 || cost[i] > most) continue;
      std::size_t place = top++;
      for (; place > bottom && stack[place - 1].cost < cost[i]; --place) stack[place] = stack[place - 1];
      stack[place] = {cost[i], node.child[i]};
    }
  }
}

}  // namespace roadgen
