#include "roadgen/import/osm_structures.h"

#include <algorithm>

#include "roadgen/road/sweep_piece.h"
#include "roadgen/road/vault_room.h"

namespace roadgen {
namespace {

constexpr double kRailFree_m = 80;                     // from where roads part without an area between them
constexpr double kRailOff_m = 0.2, kWallOff_m = 0.75;  // beyond the edges

void add_where_wide(Road& road, const Sweep& sweep) {
  if (!bad_numbers(road, sweep).empty()) return;
  const std::vector<Sweep> parts = parts_between_tight_bends(road, sweep, kLeastVault_m);
  road.sweeps.insert(road.sweeps.end(), parts.begin(), parts.end());
}

}  // namespace

void add_structures(Road& road, const WayTags& of, bool touches_start, bool touches_end) {
  const double length = road.length_m();
  if (of.bridge) road.bridges.push_back({.s_end_m = length});
  if (!of.bridge && !of.tunnel) return;
  double left = -1e300, right = 1e300;
  for (const Segment& segment : road.segments) {
    left = std::max(left, segment.left_m.range(segment.arc_m).high);
    right = std::min(right, segment.right_m.range(segment.arc_m).low);
  }
  if (of.bridge) {
    const double from = touches_start ? kRailFree_m : 0, to = length - (touches_end ? kRailFree_m : 0);
    for (const double t : {left + kRailOff_m, right - kRailOff_m}) {
      add_where_wide(road, {.s_start_m = from, .s_end_m = to, .t_m = t, .shape = GuardRail{}});
    }
    return;
  }
  const double half = 0.5 * (left - right) + kWallOff_m;
  add_where_wide(road, {.s_start_m = 0,
                        .s_end_m = length,
                        .t_m = 0.5 * (left + right),
                        .shape = Tunnel{.half_width_m = half,
                                        .wall_height_m = 3,
                                        .arch_rise_m = std::min(half, 1.2),
                                        .head_margin_m = 0.3,
                                        .walkway_m = kWallOff_m}});
}

}  // namespace roadgen
