#include "roadgen/query/road_index.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr std::uint32_t kLeafSize = 4;

}  // namespace

RoadPoint locate(const Segment& segment, glm::dvec2 point_m) {
  RoadPoint r;
  // Between the end lines and within the width: on the carriageway, where the road function is the truth.
  const glm::dvec2 p = to_chord(segment, point_m);
  const double length = segment.chord_length_m(), a = segment.slope_start, b = segment.slope_end;
  if (p.x + a * p.y >= 0 && p.x + b * p.y <= 1) {
    const Lib::RoadCoord c = Lib::road_project(p.x, p.y, a, b);
    const double local = arc_at(segment, c.u);
    const double t = c.v * length / std::cos(segment.superelevation_rad.value(local));
    if (t <= segment.left_m.value(local) && t >= segment.right_m.value(local)) {
      r.u = c.u;
      r.s_m = segment.s_start_m + local;
      r.t_m = t;
      r.distance_m = std::abs(c.v * length);
      return r;
    }
  }
  const Nearest foot = nearest(segment, point_m);
  const double df = Lib::road_df(foot.u, a, b), local = arc_at(segment, foot.u);
  const glm::dvec2 tangent = glm::dvec2(1, df) / std::sqrt(1 + df * df);
  const glm::dvec2 away = (p - glm::dvec2(foot.u, Lib::road_f(foot.u, a, b))) * length;
  r.u = foot.u;
  r.s_m = segment.s_start_m + local;
  const double n = tangent.x * away.y - tangent.y * away.x;
  const double cosine = std::cos(segment.superelevation_rad.value(local));
  r.t_m = n / cosine;
  r.distance_m = foot.distance_m;
  const double beside =
      std::max({n - segment.left_m.value(local) * cosine, segment.right_m.value(local) * cosine - n, 0.0});
  // Between the ends the foot is perpendicular and what is along is rounding only.
  const bool at_end = foot.u <= 0 || foot.u >= 1;
  r.outside_m = at_end ? std::hypot(glm::dot(tangent, away), beside) : beside;
  return r;
}

void RoadIndex::add_junctions() {
  for (const Junction& junction : network_->junctions) {
    JunctionSurface surface = junction_surface(junction);
    const Box box{surface.center_m + surface.low_m, surface.center_m + surface.high_m};
    const auto index = static_cast<std::uint32_t>(junctions_.size());
    junction_cells_[cell(cell_of(box.low_m.x), cell_of(box.low_m.y))].push_back(index);
    widest_junction_m_ = std::max({widest_junction_m_, box.high_m.x - box.low_m.x, box.high_m.y - box.low_m.y});
    junctions_.push_back({box, std::move(surface)});
  }
}

// A junction's area counts where the point is inside, against roads that pass over or under it by height.
void RoadIndex::consider_junctions(glm::dvec3 point_m, bool with_height, std::optional<RoadPoint>& best) const {
  const glm::dvec2 flat(point_m);
  visit_junctions(flat, 0, [&](std::uint32_t i, const JunctionSurface& surface) {
    if (signed_distance_m(surface, flat) < 0) return;
    RoadPoint r;
    r.junction = static_cast<std::int32_t>(i);
    r.s_m = point_m.x - surface.center_m.x;
    r.t_m = point_m.y - surface.center_m.y;
    if (with_height) r.height_m = point_m.z - height_at(surface, flat).height_m;
    if (!best || std::abs(r.height_m) < std::hypot(best->outside_m, best->height_m) || best->outside_m > 0) best = r;
  });
}

RoadIndex::RoadIndex(const Network& network) : network_(&network) {
  add_junctions();
  const std::vector<bool> in_area = roads_in_areas(network);
  for (std::uint32_t road = 0; road < network.roads.size(); ++road) {
    if (in_area[road]) continue;
    const auto& segments = network.roads[road].segments;
    for (std::uint32_t i = 0; i < segments.size(); ++i) {
      Bounds b = bounds(segments[i]);
      const Cubic::Range lanes = lane_height_range_m(section_of(network.roads[road], segments[i]));
      b.low_m.z += lanes.low;
      b.high_m.z += lanes.high;
      refs_.push_back({road, i});
      boxes_.push_back({b.low_m, b.high_m});
    }
  }
  if (refs_.empty()) return;
  nodes_.reserve(refs_.size());
  nodes_.emplace_back();
  // Sorted by way of an order, since box and reference must move together.
  std::vector<std::uint32_t> order(refs_.size());
  std::iota(order.begin(), order.end(), 0u);
  const std::vector<SegmentRef> refs = refs_;
  const std::vector<Box> boxes = boxes_;
  struct Work {
    std::uint32_t node, begin, end;
  };
  std::vector<Work> work{{0, 0, static_cast<std::uint32_t>(order.size())}};
  while (!work.empty()) {
    const Work w = work.back();
    work.pop_back();
    Box all = boxes[order[w.begin]];
    for (std::uint32_t i = w.begin; i < w.end; ++i) {
      all.low_m = glm::min(all.low_m, boxes[order[i]].low_m);
      all.high_m = glm::max(all.high_m, boxes[order[i]].high_m);
    }
    nodes_[w.node].box = all;
    if (w.end - w.begin <= kLeafSize) {
      nodes_[w.node].first = w.begin;
      nodes_[w.node].count = w.end - w.begin;
      continue;
    }
    // Halved at the median along the longer side.
    const int axis = all.high_m.x - all.low_m.x >= all.high_m.y - all.low_m.y ? 0 : 1;
    const std::uint32_t middle = (w.begin + w.end) / 2;
    std::nth_element(
        order.begin() + w.begin, order.begin() + middle, order.begin() + w.end, [&](std::uint32_t i, std::uint32_t j) {
          return boxes[i].low_m[axis] + boxes[i].high_m[axis] < boxes[j].low_m[axis] + boxes[j].high_m[axis];
        });
    const auto left = static_cast<std::uint32_t>(nodes_.size());
    nodes_[w.node].first = left;
    nodes_.resize(nodes_.size() + 2);
    work.push_back({left, w.begin, middle});
    work.push_back({left + 1, middle, w.end});
  }
  for (std::size_t i = 0; i < order.size(); ++i) {
    refs_[i] = refs[order[i]];
    boxes_[i] = boxes[order[i]];
  }
}

std::vector<SegmentRef> RoadIndex::within(glm::dvec2 point_m, double reach_m) const {
  std::vector<SegmentRef> found;
  visit_within(point_m, reach_m, [&](SegmentRef ref, const Segment&) { found.push_back(ref); });
  return found;
}

std::optional<RoadPoint> RoadIndex::to_road(glm::dvec2 point_m, double reach_m) const {
  return search(glm::dvec3(point_m, 0), false, reach_m);
}

std::optional<RoadPoint> RoadIndex::to_road(glm::dvec3 point_m, double reach_m) const {
  return search(point_m, true, reach_m);
}

std::optional<RoadPoint> RoadIndex::search(glm::dvec3 point_m, bool with_height, double reach_m) const {
  std::optional<RoadPoint> best = nearest_road(point_m, with_height, reach_m);
  consider_junctions(point_m, with_height, best);
  return best;
}

std::optional<RoadPoint> RoadIndex::nearest_road(glm::dvec3 point_m, bool with_height, double reach_m) const {
  std::optional<RoadPoint> best;
  if (nodes_.empty()) return best;
  const glm::dvec2 flat(point_m);
  double least2 = std::numeric_limits<double>::infinity();
  // The least that any point of the box can cost; the first is of reach, the second of nearness.
  const auto floor2 = [&](const Box& box, double plane2) {
    if (!with_height) return plane2;
    const double dz = std::max({box.low_m.z - point_m.z, point_m.z - box.high_m.z, 0.0});
    return plane2 + dz * dz;
  };
  std::uint32_t stack[kStack];
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    const double plane2 = distance2(node.box, flat);
    if (plane2 > reach_m * reach_m || floor2(node.box, plane2) > least2) continue;
    if (node.count == 0) {
      // The nearer child is looked at first.
      const std::uint32_t near = distance2(nodes_[node.first].box, flat) <= distance2(nodes_[node.first + 1].box, flat)
                                     ? node.first
                                     : node.first + 1;
      stack[top++] = node.first + node.first + 1 - near;
      stack[top++] = near;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
      const double own2 = distance2(boxes_[i], flat);
      if (own2 > reach_m * reach_m || floor2(boxes_[i], own2) > least2) continue;
      const Segment& candidate = segment(refs_[i]);
      RoadPoint r = locate(candidate, flat);
      if (r.outside_m > reach_m) continue;
      r.at = refs_[i];
      if (with_height) {
        const Road& road = network_->roads[refs_[i].road];
        r.height_m = point_m.z - surface_height_m(road, candidate, r.s_m - candidate.s_start_m, r.t_m);
      }
      const double cost2 = r.outside_m * r.outside_m + r.height_m * r.height_m;
      if (cost2 < least2 || (cost2 == least2 && best && r.distance_m < best->distance_m)) {
        least2 = cost2;
        best = r;
      }
    }
  }
  if (best) {
    const Road& road = network_->roads[best->at.road];
    const LaneSection& section = section_of(road, segment(best->at));
    best->lane = lane_at(section, best->s_m - section.s_m, best->t_m);
  }
  return best;
}

}  // namespace roadgen
