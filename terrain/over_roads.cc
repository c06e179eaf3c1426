#include "terrain/over_roads.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/road/link.h"
#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

constexpr double kStep_m = 1, kAreaStep_m = 2;
constexpr double kOwnLeg_m = 20;     // along one road that passes over itself
constexpr double kMostSlope_m = 20;  // of the length of a slope to either side

class Finder {
 public:
  Finder(const RoadIndex& index, const Supports& supports)
      : index_(index), supports_(supports), in_area_(roads_in_areas(index.network())) {}

  // How far a point of a road (s) or an area lies above the lowest carriageway below it. road, junction: of itself.
  double over_m(glm::dvec3 point_m, std::uint32_t road, double s_m, std::int32_t junction) const {
    std::array<RoadPoint, 12> found;
    const std::size_t count = std::min(index_.candidates(point_m, 0, found), found.size());
    double over = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const RoadPoint& at = found[i];
      if (at.outside_m > 0 || at.height_m <= over) continue;
      if (at.junction >= 0) {
        const bool is_kept = supports_.of_junction(static_cast<std::size_t>(at.junction)) == Support::kTunnel;
        if (at.junction != junction && !is_kept) over = at.height_m;
      } else if (!in_area_[at.at.road] && !(at.at.road == road && std::abs(at.s_m - s_m) < kOwnLeg_m) &&
                 support_at(at.at, at.s_m) != Support::kTunnel) {
        over = at.height_m;
      }
    }
    return over;
  }

  std::vector<Supports::Part> over_roads(std::uint32_t road, double shoulder_m, double slope) const {
    std::vector<Supports::Part> parts;
    const Road& of = index_.network().roads[road];
    if (in_area_[road]) return parts;
    for (const Segment& segment : of.segments) {
      const int steps = std::max(1, static_cast<int>(std::ceil(segment.arc_m / kStep_m)));
      for (int i = 0; i <= steps; ++i) {
        const double local = segment.arc_m * i / steps, s = segment.s_start_m + local;
        const double left = segment.left_m.value(local), right = segment.right_m.value(local);
        double over = 0;
        for (const double t : {left, 0.5 * (left + right), right}) {
          over = std::max(over, over_m(pose_in(of, segment, local, t).position_m, road, s, -1));
        }
        if (over < kOverRoad_m) continue;
        const double beside = shoulder_m + std::min(over / slope, kMostSlope_m);
        const double from = std::max(s - beside, 0.0), to = std::min(s + beside, of.length_m());
        if (!parts.empty() && from <= parts.back().s_end_m) {
          parts.back().s_start_m = std::min(parts.back().s_start_m, from);
          parts.back().s_end_m = std::max(parts.back().s_end_m, to);
        } else {
          parts.push_back({Support::kBridge, from, to});
        }
      }
    }
    return parts;
  }

  bool is_over_roads(std::uint32_t junction) const {
    const JunctionSurface surface = junction_pieces(index_.network().junctions[junction]);
    const glm::dvec2 center(surface.center_m), low = center + glm::dvec2(surface.low_m);
    const glm::dvec2 size = glm::dvec2(surface.high_m - surface.low_m);
    const glm::ivec2 count(glm::ceil(size / kAreaStep_m));
    for (int i = 0; i <= count.x; ++i) {
      for (int j = 0; j <= count.y; ++j) {
        const glm::dvec2 at = low + size * glm::dvec2(i, j) / glm::dvec2(glm::max(count, 1));
        if (!is_inside(surface, at)) continue;
        const double z = height_m_at(surface, at);
        const auto own = static_cast<std::int32_t>(junction);
        if (over_m({at, z}, SegmentRef::kNoRoad, 0, own) >= kOverRoad_m) return true;
      }
    }
    return false;
  }

 private:
  Support support_at(SegmentRef at, double s_m) const {
    const Segment& segment = index_.segment(at);
    for (const SupportedPart& part : supports_.of(index_.network(), at)) {
      if (s_m - segment.s_start_m <= part.s1_m) return part.support;
    }
    return Support::kGround;
  }

  const RoadIndex& index_;
  const Supports& supports_;
  std::vector<bool> in_area_;
};

}  // namespace

AssumedBridges bridges_over_roads(const RoadIndex& index, const Supports& supports, double shoulder_m, double slope) {
  const Network& network = index.network();
  const Finder finder(index, supports);
  AssumedBridges found;
  found.of_road.resize(network.roads.size());
  found.junctions.assign(network.junctions.size(), 0);
  for_each_index(found.of_road.size(), [&](std::size_t i) {
    found.of_road[i] = finder.over_roads(static_cast<std::uint32_t>(i), shoulder_m, slope);
  });
  for_each_index(found.junctions.size(), [&](std::size_t i) {
    const bool is_kept = supports.of_junction(i) == Support::kTunnel;
    found.junctions[i] = !is_kept && finder.is_over_roads(static_cast<std::uint32_t>(i));
  });
  return found;
}

}  // namespace roadgen
