#include "roadgen/query/box_tree.h"

#include <cassert>
#include <numeric>

#include <glm/common.hpp>

namespace roadgen {
namespace {

constexpr Box kNothing{glm::dvec3(std::numeric_limits<double>::infinity()),
                       glm::dvec3(-std::numeric_limits<double>::infinity())};

void add(Box& all, const Box& box) {
  all.low_m = glm::min(all.low_m, box.low_m);
  all.high_m = glm::max(all.high_m, box.high_m);
}

// How likely a point within about a metre of the box is to be asked for.
double weight(const Box& box) {
  const glm::dvec3 size = box.high_m - box.low_m;
  return (size.x + 1) * (size.y + 1);
}

}  // namespace

struct BoxTree::Builder {
  BoxTree& tree;
  const std::vector<Box>& boxes;
  std::vector<std::uint32_t> order;

  std::uint32_t divide(std::uint32_t begin, std::uint32_t end, std::uint32_t unit);
  std::uint32_t build(std::uint32_t begin, std::uint32_t end);
};

BoxTree::BoxTree(const std::vector<Box>& boxes) {
  if (boxes.empty()) return;
  assert(boxes.size() < kItem - 1);
  Box all = kNothing;
  for (const Box& box : boxes) add(all, box);
  origin_m_ = 0.5 * (all.low_m + all.high_m);
  nodes_.reserve(boxes.size() / (kWidth - 1) + 2);
  Builder builder{*this, boxes, std::vector<std::uint32_t>(boxes.size())};
  std::iota(builder.order.begin(), builder.order.end(), 0u);
  root_ = builder.build(0, static_cast<std::uint32_t>(boxes.size()));
}

// Orders [begin, end) so that the boxes before and after a middle, a multiple of unit from the begin, lie apart: by their
// centres along the axis that leaves the smaller boxes. Returns the middle.
std::uint32_t BoxTree::Builder::divide(std::uint32_t begin, std::uint32_t end, std::uint32_t unit) {
  const std::uint32_t units = (end - begin + unit - 1) / unit, middle = begin + units / 2 * unit;
  const auto halve = [&](int axis) {
    std::nth_element(
        order.begin() + begin, order.begin() + middle, order.begin() + end, [&](std::uint32_t i, std::uint32_t j) {
          return boxes[i].low_m[axis] + boxes[i].high_m[axis] < boxes[j].low_m[axis] + boxes[j].high_m[axis];
        });
    Box before = kNothing, after = kNothing;
    for (std::uint32_t i = begin; i < middle; ++i) add(before, boxes[order[i]]);
    for (std::uint32_t i = middle; i < end; ++i) add(after, boxes[order[i]]);
    return weight(before) + weight(after);
  };
  const double by_x = halve(0), by_y = halve(1);
  if (by_x < by_y) halve(0);
  return middle;
}

std::uint32_t BoxTree::Builder::build(std::uint32_t begin, std::uint32_t end) {
  // Children of as many items as fill their subtrees.
  std::uint32_t unit = 1;
  while (static_cast<std::uint64_t>(unit) * kWidth < end - begin) unit *= kWidth;
  std::uint32_t bounds[kWidth + 1] = {begin, end};
  std::uint32_t count = 1;
  for (std::uint32_t i = 0; i < count;) {
    if (bounds[i + 1] - bounds[i] <= unit) {
      ++i;
      continue;
    }
    const std::uint32_t middle = divide(bounds[i], bounds[i + 1], unit);
    std::copy_backward(bounds + i + 1, bounds + count + 1, bounds + count + 2);
    bounds[i + 1] = middle;
    ++count;
  }
  Node node;
  for (std::uint32_t i = 0; i < kWidth; ++i) {
    Box all = kNothing;
    if (i < count) {
      for (std::uint32_t k = bounds[i]; k < bounds[i + 1]; ++k) add(all, boxes[order[k]]);
      node.child[i] = bounds[i + 1] - bounds[i] == 1 ? order[bounds[i]] | kItem : build(bounds[i], bounds[i + 1]);
    } else {
      node.child[i] = kNoChild;
    }
    for (int k = 0; k < 3; ++k) {
      node.low[k][i / 4][i % 4] = below(all.low_m[k] - tree.origin_m_[k] - kMargin_m);
      node.high[k][i / 4][i % 4] = above(all.high_m[k] - tree.origin_m_[k] + kMargin_m);
    }
  }
  tree.nodes_.push_back(node);
  return static_cast<std::uint32_t>(tree.nodes_.size() - 1);
}

void BoxTree::Walk::begin(const BoxTree& tree, const Box& about, const SearchLimits& limits, const Memory& memory) {
  tree_ = &tree;
  memory_ = memory;
  heights_ = limits.heights;
  top_ = 0;
  for (int k = 0; k < 3; ++k) {
    low_[k] = below(about.low_m[k] - tree.origin_m_[k]);
    high_[k] = above(about.high_m[k] - tree.origin_m_[k]);
  }
  // Finite, so that children that are not there, infinitely far away, are never near.
  reach2_ = std::min(above(limits.reach_m * limits.reach_m * kRounding), std::numeric_limits<float>::max());
  limit(limits.cost_m);
  if (!tree.nodes_.empty()) stack_[top_++] = {0, 0, tree.root_};
}

inline void BoxTree::Walk::put(std::uint32_t place, const Waiting& child) {
  stack_[place] = child;
  const std::uint32_t item = child.child() & ~kItem;
  if (!(child.child() & kItem)) {
    prefetch(&tree_->nodes_[item], sizeof(Node));
  } else if (item < memory_.count) {
    prefetch(static_cast<const char*>(memory_.first) + item * memory_.bytes, memory_.bytes);
  }
}

// Puts the children that are near (a bit for each) on the stack, the nearest on top.
inline void BoxTree::Walk::push(const Node& node, const Four (&plane2)[kFours], const Four (&gap)[kFours],
                                std::uint32_t near) {
  const auto child = [&](std::uint32_t i) -> Waiting {
    return {plane2[i / 4][i % 4], gap[i / 4][i % 4], node.child[i]};
  };
  const auto first = [&] { return static_cast<std::uint32_t>(std::countr_zero(near)); };
  if (near != 0 && (near & (near - 1)) == 0) {
    put(top_++, child(first()));
    return;
  }
  // What a child costs, as an integer of the same order, told from others' by its place; less than any where it is far.
  Fours key[kFours];
  for (std::uint32_t four = 0; four < kFours; ++four) {
    const auto at = static_cast<std::int32_t>(4 * four);
    const auto cost = std::bit_cast<Fours>(plane2[four] + gap[four]);
    const Fours own_bit = Fours{1, 2, 4, 8} << at;
    key[four] = ((cost & ~15) | Fours{at, at + 1, at + 2, at + 3}) | ((static_cast<std::int32_t>(near) & own_bit) == 0);
  }
  const std::uint32_t bottom = top_;
  for (; near != 0; near &= near - 1) {
    const std::uint32_t i = first();
    // Without a branch, which would be guessed wrong every other time: above those that are farther.
    const std::int32_t own = key[i / 4][i % 4];
    const Fours farther = (key[0] > own) + (key[1] > own) + (key[2] > own) + (key[3] > own);
    put(bottom - static_cast<std::uint32_t>(farther[0] + farther[1] + farther[2] + farther[3]), child(i));
    ++top_;
  }
}

inline std::uint32_t BoxTree::Walk::advance() {
  constexpr auto kSame = static_cast<float>(kSameHeight_m), kBeside = static_cast<float>(kBeside_m);
  constexpr auto kPer2 = static_cast<float>(1.000001 / (kPerBeside * kPerBeside));
  if (top_ == 0) return kDone;
  const Waiting at = stack_[--top_];
  const float rest = most_ - at.gap(), around = std::max(rest - kBeside, 0.0f);
  if (rest < 0 || at.plane2() > around * around * kPer2) return kNode;
  if (at.child() & kItem) return at.child() & ~kItem;
  const Node& node = tree_->nodes_[at.child()];
  Four plane2[kFours], gap[kFours] = {};
  std::uint32_t far = 0;  // a bit for each
  for (std::uint32_t four = 0; four < kFours; ++four) {
    const Four dx = greater(greater(node.low[0][four] - high_[0], low_[0] - node.high[0][four]), Four{});
    const Four dy = greater(greater(node.low[1][four] - high_[1], low_[1] - node.high[1][four]), Four{});
    plane2[four] = dx * dx + dy * dy;
    if (heights_) {
      const Four dz = greater(node.low[2][four] - high_[2], low_[2] - node.high[2][four]);
      gap[four] = greater(dz - kSame, Four{});  // at least, whichever way the height is rounded
    }
    // Whether height and distance together cost too much; without a root.
    const Four left = most_ - gap[four], beside = greater(left - kBeside, Four{});
    far |= bits((left < 0) | (plane2[four] > beside * beside * kPer2) | (plane2[four] > reach2_)) << (4 * four);
  }
  push(node, plane2, gap, ~far & ((1u << kWidth) - 1));
  return kNode;
}

std::uint32_t BoxTree::Walk::step() { return advance(); }

std::uint32_t BoxTree::Walk::next() {
  while (true) {
    const std::uint32_t item = advance();
    if (item != kNode) return item;
  }
}

}  // namespace roadgen
