// World to road: which road, and where along and across it, a point of the world belongs to.
//
// A static tree of boxes over the footprints of all segments; roads in a junction's area are left out, since the area
// is the ground there. On a carriageway the answer is the road function's own (project(), what the pixel shader
// evaluates), so a query and the picture agree; beside it, the truly nearest point.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "roadgen/road/network.h"

namespace roadgen {

// Which segment: network.roads[road].segments[segment].
struct SegmentRef {
  std::uint32_t road = 0;
  std::uint32_t segment = 0;
  bool operator==(const SegmentRef&) const = default;
};

// Where a point stands against a segment.
struct RoadPoint {
  SegmentRef at;
  double u = 0;           // of the segment, [0, 1]
  double s_m = 0;         // arc length along the road
  double t_m = 0;         // across, in the tilted cross section, positive to the left
  double distance_m = 0;  // from the reference line, horizontally
  double outside_m = 0;   // from the carriageway, horizontally; 0 on it
  double height_m = 0;    // of the point above the surface, raised lanes included; 0 where the query gave no height
  int lane = 0;           // id of the lane there, left positive; 0 outside all lanes
  // In the area of network.junctions[junction], else -1. There s_m and t_m are metres east and north of the junction's
  // centre, as in the picture's road channel, and `at` means nothing.
  std::int32_t junction = -1;
};

// How the point stands against one segment, however far away. Accuracy: on the carriageway |t - exact| is at most
// segment.v_bound_m() and |s - exact| at most segment.s_bound_m(); elsewhere 1e-9 m and arc_error_m. Cost: O(1).
RoadPoint locate(const Segment& segment, glm::dvec2 point_m);

// Immutable after construction: any number of threads may ask. No allocation per query but in within().
class RoadIndex {
 public:
  // Requires: the network stays where it is and unchanged while the index is used. Cost: O(n log n), n segments.
  explicit RoadIndex(const Network& network);

  // The nearest place on a road whose carriageway is within reach_m of the point, horizontally; none where there is
  // none. Of several roads at the point (reach 0: crossing, overlapping) the one with the smaller |t| is taken, or
  // where a height is given, the one whose surface is nearest in height: nearest is what minimises
  // hypot(outside_m, height_m), then distance_m. Requires: reach_m >= 0, may be infinite.
  // Cost: O(log n) for roads that do not all overlap.
  std::optional<RoadPoint> to_road(glm::dvec2 point_m, double reach_m) const;
  std::optional<RoadPoint> to_road(glm::dvec3 point_m, double reach_m) const;

  // The segments whose footprint's box is within reach_m of the point, in no order; a superset of the segments whose
  // carriageway is.
  std::vector<SegmentRef> within(glm::dvec2 point_m, double reach_m) const;

  // The same by call-back: visit(SegmentRef, const Segment&) for each, without allocation.
  template <class Visit>
  void visit_within(glm::dvec2 point_m, double reach_m, Visit&& visit) const;

  // Calls visit(index of the junction, const JunctionSurface&) for every junction whose bounds are within reach_m of
  // the point, horizontally. Requires: reach_m finite. Cost: O(1 + (reach / 64 m)^2) and the junctions about.
  template <class Visit>
  void visit_junctions(glm::dvec2 point_m, double reach_m, Visit&& visit) const;

  const Segment& segment(SegmentRef ref) const { return network_->roads[ref.road].segments[ref.segment]; }
  const Network& network() const { return *network_; }
  std::size_t size() const { return refs_.size(); }

 private:
  struct Box {
    glm::dvec3 low_m, high_m;
  };
  struct Node {
    Box box;
    std::uint32_t first = 0;  // leaf: of refs_; inner: the left child, the right one after it
    std::uint32_t count = 0;  // leaf: number of segments; inner: 0
  };
  static constexpr int kStack = 64;  // the tree is balanced, its depth at most log2(2^32)

  std::optional<RoadPoint> nearest_road(glm::dvec3 point_m, bool with_height, double reach_m) const;
  std::optional<RoadPoint> search(glm::dvec3 point_m, bool with_height, double reach_m) const;
  // Squared horizontal distance of a point from a box; 0 inside.
  static double distance2(const Box& box, glm::dvec2 p) {
    const double dx = p.x < box.low_m.x ? box.low_m.x - p.x : (p.x > box.high_m.x ? p.x - box.high_m.x : 0);
    const double dy = p.y < box.low_m.y ? box.low_m.y - p.y : (p.y > box.high_m.y ? p.y - box.high_m.y : 0);
    return dx * dx + dy * dy;
  }

  // Junctions in square cells by the low corner of their bounds.
  struct JunctionBox {
    Box box;
    JunctionSurface surface;
  };
  static constexpr double kCell_m = 64;
  static std::int64_t cell(int x, int y) {
    return (static_cast<std::int64_t>(x) << 32) ^ static_cast<std::uint32_t>(y);
  }
  static int cell_of(double x_m) { return static_cast<int>(std::floor(x_m / kCell_m)); }
  void add_junctions();
  void consider_junctions(glm::dvec3 point_m, bool with_height, std::optional<RoadPoint>& best) const;

  const Network* network_;
  std::vector<JunctionBox> junctions_;
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> junction_cells_;
  double widest_junction_m_ = 0;
  std::vector<Node> nodes_;
  std::vector<SegmentRef> refs_;
  std::vector<Box> boxes_;  // of refs_
};

template <class Visit>
void RoadIndex::visit_junctions(glm::dvec2 point_m, double reach_m, Visit&& visit) const {
  if (junctions_.empty()) return;
  const double back = reach_m + widest_junction_m_;
  for (int x = cell_of(point_m.x - back); x <= cell_of(point_m.x + reach_m); ++x) {
    for (int y = cell_of(point_m.y - back); y <= cell_of(point_m.y + reach_m); ++y) {
      const auto at = junction_cells_.find(cell(x, y));
      if (at == junction_cells_.end()) continue;
      for (const std::uint32_t i : at->second) {
        if (distance2(junctions_[i].box, point_m) <= reach_m * reach_m) visit(i, junctions_[i].surface);
      }
    }
  }
}

template <class Visit>
void RoadIndex::visit_within(glm::dvec2 point_m, double reach_m, Visit&& visit) const {
  if (nodes_.empty()) return;
  const double reach2 = reach_m * reach_m;
  std::uint32_t stack[kStack];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    if (distance2(node.box, point_m) > reach2) continue;
    if (node.count == 0) {
      stack[top++] = node.first;
      stack[top++] = node.first + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      if (distance2(boxes_[i], point_m) <= reach2) visit(refs_[i], segment(refs_[i]));
    }
  }
}

}  // namespace roadgen
