#include "terrain/support.h"

#include <algorithm>
#include <array>

namespace roadgen {
namespace {

// Parts whose ends lie nearer to one another, or to a joint, than this meet there.
constexpr double kMeet_m = 1e-3;
constexpr double kRounding_m = 1e-6;  // of joints
constexpr double kJoinedPart = 0.4;   // of the least length of a hill where it may go on over the next road

// Of a segment on the ground as a whole: by whether its road starts and ends with it.
constexpr std::array<SupportedPart, 4> whole_parts() {
  std::array<SupportedPart, 4> all;
  for (int i = 0; i < 4; ++i) {
    all[static_cast<std::size_t>(i)] = {.s1_m = 1e300, .starts_here = (i & 1) != 0, .ends_here = (i & 2) != 0};
  }
  return all;
}
constexpr std::array<SupportedPart, 4> kWhole = whole_parts();

// s within the road, moved to the nearest joint of the road or end of it where that is next to it.
double snapped_m(const Road& road, double s_m) {
  s_m = std::clamp(s_m, 0.0, road.length_m());
  const Segment& segment = road.segments[segment_at(road, s_m)];
  for (const double joint : {segment.s_start_m, segment.s_start_m + segment.arc_m}) {
    if (std::abs(s_m - joint) < kMeet_m) return joint;
  }
  return s_m;
}

bool is_on_bridge(const std::vector<Bridge>& bridges, double s_m) {
  return std::any_of(bridges.begin(), bridges.end(),
                     [&](const Bridge& b) { return b.s_start_m <= s_m + kMeet_m && s_m - kMeet_m <= b.s_end_m; });
}

// Of the outside of the vault at s, above the road; 0 where there is none.
double vault_height_m(const Road& road, double s_m) {
  double height = 0;
  for (const Sweep& sweep : road.sweeps) {
    const auto* tunnel = std::get_if<Tunnel>(&sweep.shape);
    if (!tunnel || s_m < sweep.s_start_m - kMeet_m || s_m > sweep.s_end_m + kMeet_m) continue;
    height = std::max(height, tunnel->wall_height_m + tunnel->arch_rise_m + tunnel->lining_m);
  }
  return height;
}

// The road as a row of parts without gaps: on the ground but for the given ones, of which later ones win.
std::vector<Supports::Part> parts_of(const Road& road, const std::vector<Supports::Part>& raised) {
  std::vector<double> ends = {0, road.length_m()};
  for (const Supports::Part& part : raised) ends.insert(ends.end(), {part.s_start_m, part.s_end_m});
  std::sort(ends.begin(), ends.end());
  std::vector<Supports::Part> parts;
  for (const double end : ends) {
    const double from = parts.empty() ? 0 : parts.back().s_end_m, middle = 0.5 * (from + end);
    if (end - from <= kMeet_m) continue;
    Supports::Part next{Support::kGround, from, end};
    for (const Supports::Part& part : raised) {
      if (!(part.s_start_m < middle && middle < part.s_end_m)) continue;
      next.support = part.support;
      next.is_assumed = part.is_assumed;
    }
    if (!parts.empty() && parts.back().support == next.support && parts.back().is_assumed == next.is_assumed) {
      parts.back().s_end_m = end;
    } else {
      parts.push_back(next);
    }
  }
  if (parts.empty()) parts.push_back({Support::kGround, 0, 0});
  parts.back().s_end_m = road.length_m();
  return parts;
}

// Whether the carriageway is within the walls of a tunnel's piece everywhere from s0 to s1 from its segment's start.
bool is_within_walls(const Road& road, const SweepPart& piece, double s0, double s1) {
  const Segment& segment = road.segments[piece.segment];
  const double half = std::get<Tunnel>(road.sweeps[piece.sweep].shape).half_width_m + kMeet_m;
  const Cubic axis{piece.piece.path.n0, piece.piece.path.n1, 0, 0};
  return (segment.left_m - axis).shifted(s0).range(s1 - s0).high <= half &&
         (segment.right_m - axis).shifted(s0).range(s1 - s0).low >= -half;
}

// Whether the ground covers the vault of a tunnel's piece at s from its segment's start.
bool is_covered(const Road& road, const SweepPart& piece, double s, const Supports::Ground& ground_m, double cover_m) {
  const Segment& segment = road.segments[piece.segment];
  const auto& tunnel = std::get<Tunnel>(road.sweeps[piece.sweep].shape);
  const Lib::SweepPath& path = piece.piece.path;
  const double axis = path.n0 + path.n1 * s;
  const double crown = segment.elevation_m.c0 + Lib::road_cubic(s, path.z0, path.z1, path.z2, path.z3) +
                       tunnel.wall_height_m + tunnel.arch_rise_m + tunnel.lining_m;
  const double u = u_at_arc(segment, s), heading = heading_rad(segment, u);
  for (const double side : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    const double n = axis + side * (tunnel.half_width_m + tunnel.lining_m);
    const glm::dvec2 at = position_m(segment, u) + n * glm::dvec2(-std::sin(heading), std::cos(heading));
    if (!(ground_m(at) >= crown + cover_m)) return false;
  }
  return true;
}

// Appends where a piece is covered, seen every metre, to the hills before it.
void add_hills(const Road& road, const SweepPart& piece, const Supports::Ground& ground_m, double cover_m,
               std::vector<Supports::Part>& hills) {
  const Segment& segment = road.segments[piece.segment];
  const double from = arc_at(segment, piece.piece.u0), to = arc_at(segment, piece.piece.u1);
  const int steps = std::max(1, static_cast<int>(std::ceil(to - from)));
  const auto at = [&](int i) { return from + (to - from) * i / steps; };
  bool before = is_covered(road, piece, from, ground_m, cover_m);
  for (int i = 0; i < steps; ++i) {
    const bool after = is_covered(road, piece, at(i + 1), ground_m, cover_m);
    const double s0 = segment.s_start_m + at(i), s1 = segment.s_start_m + at(i + 1);
    if (before && after && is_within_walls(road, piece, at(i), at(i + 1))) {
      if (!hills.empty() && s0 - hills.back().s_end_m < kMeet_m) {
        hills.back().s_end_m = s1;
      } else {
        hills.push_back({Support::kTunnel, s0, s1});
      }
    }
    before = after;
  }
}

}  // namespace

Supports::Supports(const Network& network, const Ground& ground_m, double cover_m, double least_m)
    : Supports(network, ground_m, cover_m, least_m, AssumedBridges{}) {}

Supports::Supports(const Network& network, const Ground& ground_m, double cover_m, double least_m,
                   const AssumedBridges& assumed) {
  first_.assign(network.roads.size(), kPlain);
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road& road = network.roads[i];
    if (road.segments.empty()) continue;
    std::vector<Part> raised;
    if (i < assumed.of_road.size()) {
      for (const Part& part : assumed.of_road[i]) {
        raised.push_back({Support::kBridge, snapped_m(road, part.s_start_m), snapped_m(road, part.s_end_m), true});
      }
    }
    for (const Bridge& bridge : road.bridges) {
      if (!(bridge.s_end_m > bridge.s_start_m)) continue;
      raised.push_back({Support::kBridge, snapped_m(road, bridge.s_start_m), snapped_m(road, bridge.s_end_m)});
    }
    add_tunnels(road, ground_m, cover_m, least_m, raised);
    if (raised.empty()) continue;
    first_[i] = static_cast<std::uint32_t>(segments_.size());
    cut(road, parts_of(road, raised));
  }
  add_junctions(network, ground_m, cover_m, assumed);
}

void Supports::add_junctions(const Network& network, const Ground& ground_m, double cover_m,
                             const AssumedBridges& assumed) {
  const RoadsById by_id = roads_by_id(network);
  for (const Junction& junction : network.junctions) {
    const auto all_arms = [&](const auto& is_one) {
      return !junction.arms.empty() &&
             std::all_of(junction.arms.begin(), junction.arms.end(), [&](const JunctionArm& arm) {
               const auto found = by_id.find(arm.road);
               return found != by_id.end() && !network.roads[found->second].segments.empty() &&
                      is_one(static_cast<std::uint32_t>(found->second), arm.at_end);
             });
    };
    const bool on_bridges = all_arms([&](std::uint32_t i, bool at_end) {
      return is_on_bridge(network.roads[i].bridges, at_end ? network.roads[i].length_m() : 0);
    });
    Hall hall;
    const bool in_tunnels = all_arms([&](std::uint32_t i, bool at_end) {
      const Road& road = network.roads[i];
      const auto segment = static_cast<std::uint32_t>(at_end ? road.segments.size() - 1 : 0);
      const std::span<const SupportedPart> parts = of(network, {i, segment});
      hall.height_m = std::max(hall.height_m, vault_height_m(road, at_end ? road.length_m() : 0));
      return (at_end ? parts.back() : parts.front()).support == Support::kTunnel;
    });
    if (in_tunnels) hall.surface = junction_surface(junction);
    const bool is_hall = in_tunnels && is_covered(hall, ground_m, cover_m);
    const bool is_assumed = !on_bridges && !is_hall && junctions_.size() < assumed.junctions.size() &&
                            assumed.junctions[junctions_.size()] != 0;
    assumed_.push_back(is_assumed);
    junctions_.push_back(on_bridges || is_assumed ? Support::kBridge : is_hall ? Support::kTunnel : Support::kGround);
    if (is_hall) halls_.push_back(std::move(hall));
  }
}

// The hills over a road's tunnels, and the hollows in them.
void Supports::add_tunnels(const Road& road, const Ground& ground_m, double cover_m, double least_m,
                           std::vector<Part>& raised) {
  for (std::size_t k = 0; k < road.sweeps.size(); ++k) {
    if (road.sweeps[k].kind() != SweepKind::kTunnel) continue;
    std::vector<SweepPart> pieces = sweep_parts(road, k);
    const auto start_m = [&](const SweepPart& p) {
      return road.segments[p.segment].s_start_m + arc_at(road.segments[p.segment], p.piece.u0);
    };
    std::sort(pieces.begin(), pieces.end(),
              [&](const SweepPart& a, const SweepPart& b) { return start_m(a) < start_m(b); });
    std::vector<Part> hills;
    for (const SweepPart& piece : pieces) add_hills(road, piece, ground_m, cover_m, hills);
    for (Part& hill : hills) {
      hill.s_start_m = snapped_m(road, hill.s_start_m);
      hill.s_end_m = snapped_m(road, hill.s_end_m);
      // Where the road is joined to others the hill may go on over them.
      const bool from_start = hill.s_start_m == 0, to_end = hill.s_end_m == snapped_m(road, road.length_m());
      const bool goes_on = (from_start && road.joined_start) || (to_end && road.joined_end);
      const double least = goes_on ? kJoinedPart * least_m : least_m;
      if (!(from_start && to_end) && hill.s_end_m - hill.s_start_m < least) continue;
      raised.push_back(hill);
      for (const SweepPart& piece : pieces) add_hollows(road, piece, hill.s_start_m, hill.s_end_m, hollows_);
    }
  }
}

void Supports::cut(const Road& road, const std::vector<Part>& parts) {
  const bool goes_around = road.closed && parts.front().support == parts.back().support;
  for (const Part& part : parts) {
    if (part.is_assumed) {
      ++assumed_count_;
      assumed_length_m_ += part.s_end_m - part.s_start_m;
      continue;
    }
    ++count_[static_cast<std::size_t>(part.support)];
    length_m_[static_cast<std::size_t>(part.support)] += part.s_end_m - part.s_start_m;
  }
  for (const Segment& segment : road.segments) {
    const double s0 = segment.s_start_m, s1 = s0 + segment.arc_m;
    const auto first = static_cast<std::uint32_t>(stretches_.size());
    for (const Part& part : parts) {
      double from = std::max(part.s_start_m, s0), to = std::min(part.s_end_m, s1);
      if (!(to - from > 0.5 * std::min(kMeet_m, segment.arc_m))) continue;
      // Joints as the neighbours have them may differ by rounding.
      const bool at_start = part.s_start_m > s0 - kRounding_m, at_end = part.s_end_m < s1 + kRounding_m;
      if (from < s0 + kRounding_m) from = s0;
      if (to > s1 - kRounding_m) to = s1;
      stretches_.push_back({.support = part.support,
                            .is_assumed = part.is_assumed,
                            .s0_m = from - s0,
                            .s1_m = to == s1 ? segment.arc_m : to - s0,
                            .u0 = from == s0 ? 0 : u_at_arc(segment, from - s0),
                            .u1 = to == s1 ? 1 : u_at_arc(segment, to - s0),
                            .starts_here = at_start && !(goes_around && part.s_start_m <= 0),
                            .ends_here = at_end && !(goes_around && part.s_end_m >= road.length_m())});
    }
    segments_.push_back({first, static_cast<std::uint32_t>(stretches_.size()) - first});
  }
}

std::span<const SupportedPart> Supports::of(const Network& network, SegmentRef at) const {
  if (at.road < first_.size() && first_[at.road] != kPlain) {
    const Range range = segments_[first_[at.road] + at.segment];
    return {stretches_.data() + range.first, range.count};
  }
  const Road& road = network.roads[at.road];
  const bool first = !road.closed && at.segment == 0, last = !road.closed && at.segment + 1 == road.segments.size();
  return {&kWhole[(first ? 1u : 0u) + (last ? 2u : 0u)], 1};
}

}  // namespace roadgen
