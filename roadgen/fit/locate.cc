#include "roadgen/fit/locate.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Segments ahead of the last sample's where the next one is looked for first.
constexpr std::size_t kAhead = 3;

struct Box {
  glm::dvec2 low{kInfinity}, high{-kInfinity};

  void add(glm::dvec2 p) { low = glm::min(low, p), high = glm::max(high, p); }
  double distance_m(glm::dvec2 p) const { return glm::length(glm::max(glm::max(low - p, p - high), glm::dvec2(0))); }
};

// A binary tree of boxes over the segments, halved at the median of the longer side: node i has the children 2 i and
// 2 i + 1. The halves follow the plane, not the road, which may fill it like a knot.
class SegmentTree {
 public:
  explicit SegmentTree(const Road& road) : road_(road), order_(road.segments.size()), of_segment_(order_.size()) {
    for (std::size_t i = 0; i < order_.size(); ++i) {
      order_[i] = i;
      const Segment& s = road.segments[i];
      const Cubic::Range f = curve_range(s.slope_start, s.slope_end);
      for (const double x : {0.0, 1.0}) {
        for (const double y : {f.low, f.high}) of_segment_[i].add(from_chord(s, {x, y}));
      }
    }
    boxes_.resize(4 * order_.size());
    build(1, 0, order_.size());
  }

  struct Hit {
    std::size_t segment = 0;
    Nearest nearest{0, kInfinity};
  };

  // Takes what is nearer than the hit at hand. Boxes are exact up to rounding of their corners.
  void improve(Hit& best, glm::dvec2 point_m) const { improve(best, point_m, 1, 0, order_.size()); }

  void take(Hit& best, glm::dvec2 point_m, std::size_t segment) const {
    const Nearest here = nearest(road_.segments[segment], point_m);
    if (here.distance_m < best.nearest.distance_m) best = {segment, here};
  }

 private:
  void build(std::size_t node, std::size_t begin, std::size_t end) {
    Box& box = boxes_[node];
    for (std::size_t i = begin; i < end; ++i) {
      box.add(of_segment_[order_[i]].low);
      box.add(of_segment_[order_[i]].high);
    }
    if (end - begin == 1) return;
    const glm::dvec2 size = box.high - box.low;
    const int axis = size.x > size.y ? 0 : 1;
    const auto place = [&](std::size_t i) { return of_segment_[i].low[axis] + of_segment_[i].high[axis]; };
    const std::size_t middle = begin + (end - begin) / 2;
    const auto first = order_.begin();
    std::nth_element(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(middle),
                     first + static_cast<std::ptrdiff_t>(end),
                     [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
    build(2 * node, begin, middle);
    build(2 * node + 1, middle, end);
  }

  void improve(Hit& best, glm::dvec2 point_m, std::size_t node, std::size_t begin, std::size_t end) const {
    if (end - begin == 1) return take(best, point_m, order_[begin]);
    const std::size_t middle = begin + (end - begin) / 2;
    const double left = boxes_[2 * node].distance_m(point_m), right = boxes_[2 * node + 1].distance_m(point_m);
    for (const bool second : {false, true}) {
      const bool to_left = second != (left <= right);
      if (!((to_left ? left : right) < best.nearest.distance_m)) continue;
      if (to_left)
        improve(best, point_m, 2 * node, begin, middle);
      else
        improve(best, point_m, 2 * node + 1, middle, end);
    }
  }

  const Road& road_;
  std::vector<std::size_t> order_;  // of segments; each node holds a range of it
  std::vector<Box> of_segment_, boxes_;
};

}  // namespace

std::vector<Located> locate(const Road& road, std::span<const Sample> samples) {
  const SegmentTree tree(road);
  const std::size_t count = road.segments.size();
  std::vector<Located> all;
  all.reserve(samples.size());
  // The first joint of a loop may have slid past the first sample.
  std::size_t last = road.closed ? count - 1 : 0;
  for (const Sample& sample : samples) {
    SegmentTree::Hit near;
    for (std::size_t k = 0; k <= kAhead; ++k) {
      const std::size_t i = last + k;
      if (i < count || road.closed) tree.take(near, sample.position_m, i % count);
    }
    SegmentTree::Hit best = near;
    tree.improve(best, sample.position_m);
    // Another strand may be nearer where the road crosses itself, but by no more than its width.
    const bool stays = near.nearest.distance_m <= best.nearest.distance_m + sample.half_width_m;
    const SegmentTree::Hit& place = stays ? near : best;
    const Segment& segment = road.segments[place.segment];
    all.push_back({best.nearest.distance_m, place.segment, place.nearest.u,
                   segment.s_start_m + std::min(arc_at(segment, place.nearest.u), segment.arc_m)});
    last = place.segment;
  }
  return all;
}

}  // namespace roadgen
