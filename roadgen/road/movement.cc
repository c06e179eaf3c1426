#include "roadgen/road/movement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kLeastLane_m = 0.5;  // narrower ones have tapered away
constexpr double kPiece_rad = 50 * std::numbers::pi / 180;
constexpr int kMostPieces = 16;
constexpr int kMostHalvings = 6;
constexpr double kSteepest = 5;  // slope of a piece against its chord
constexpr double kStraight_rad = std::numbers::pi / 6;

bool is_driven(LaneType type) {
  switch (type) {
    case LaneType::kDriving:
    case LaneType::kBidirectional:
    case LaneType::kBus:
    case LaneType::kTaxi:
    case LaneType::kHov:
    case LaneType::kEntry:
    case LaneType::kExit:
    case LaneType::kOnRamp:
    case LaneType::kOffRamp:
    case LaneType::kConnectingRamp:
    case LaneType::kSlipLane: return true;
    default: return false;
  }
}

// An end of a road.
struct RoadEnd {
  const Road* road;
  bool at_end;

  const Segment& segment() const { return at_end ? road->segments.back() : road->segments.front(); }
  double local_m() const { return at_end ? segment().arc_m : 0; }
  const LaneSection& section() const { return section_of(*road, segment()); }
  double in_section_m() const { return section_offset_m(*road, segment()) + local_m(); }
  // Whether traffic along s leads this way: into the junction at a road's end, out of it at a start.
  bool along(bool into) const { return at_end == into; }
};

// A lane at an end, its borders as t.
struct EndLane {
  int id = 0;
  LaneType type = LaneType::kDriving;
  double right_m = 0, left_m = 0;
};

// The lanes that lead into the junction, or out of it, from the middle of the road outward.
std::vector<EndLane> lanes_of(const RoadEnd& end, bool into) {
  const LaneSection& section = end.section();
  const double ds = end.in_section_m();
  // Traffic along s is on the right side, unless it keeps left.
  const bool on_right = end.along(into) != end.road->keep_left;
  std::vector<EndLane> lanes;
  const auto side = [&](const std::vector<Lane>& of, int sign, bool both_ways) {
    double t = section.offset_m.value(ds);
    for (std::size_t i = 0; i < of.size(); ++i) {
      const double width = std::max(of[i].width_m.value(ds), 0.0), beyond = t + sign * width;
      const bool leads = is_driven(of[i].type) && (!both_ways || of[i].type == LaneType::kBidirectional);
      if (leads && width >= kLeastLane_m) {
        lanes.push_back({sign * static_cast<int>(i + 1), of[i].type, std::min(t, beyond), std::max(t, beyond)});
      }
      t = beyond;
    }
  };
  side(on_right ? section.left : section.right, on_right ? 1 : -1, true);
  std::reverse(lanes.begin(), lanes.end());
  side(on_right ? section.right : section.left, on_right ? -1 : 1, false);
  return lanes;
}

RoadEnd end_of(const Network& network, const RoadsById& roads, const JunctionArm& arm) {
  const auto found = roads.find(arm.road);
  return {found == roads.end() ? nullptr : &network.roads[found->second], arm.at_end};
}

bool leads_to(const RoadEnd& end, const std::string& junction) {
  if (!end.road || end.road->closed || end.road->segments.empty()) return false;
  const RoadLink& link = end.at_end ? end.road->successor : end.road->predecessor;
  return link.to == RoadLink::To::kJunction && link.id == junction;
}

// How traffic stands at an edge of a lane.
struct Pose {
  glm::dvec2 p;
  double heading_rad, z_m, grade;
};

Pose pose(const RoadEnd& end, double t_m, bool into) {
  const Segment& segment = end.segment();
  const double along = heading_rad(segment, end.at_end ? 1 : 0);
  const double n = t_m * std::cos(segment.superelevation_rad.value(end.local_m()));
  const Lib::SurfaceSlope surface = surface_at(segment, end.local_m(), n);
  const double sign = end.along(into) ? 1 : -1;
  return {(end.at_end ? segment.end_m : segment.start_m) + n * glm::dvec2(-std::sin(along), std::cos(along)),
          sign > 0 ? along : along + std::numbers::pi, surface.height, sign * segment.elevation_m.slope(end.local_m())};
}

// The edge that the connecting road's reference line begins or ends at: the inner one of the lane.
double inner_edge_m(const EndLane& lane, const RoadEnd& end, bool into) {
  return end.along(into) != end.road->keep_left ? lane.left_m : lane.right_m;
}

const EndLane& lane_of(const std::vector<EndLane>& lanes, int id) {
  return *std::find_if(lanes.begin(), lanes.end(), [&](const EndLane& lane) { return lane.id == id; });
}

glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

// The segments of a Bezier curve that is nearly a circle's where there is one.
std::vector<Segment> curve(const Pose& from, const Pose& to) {
  const glm::dvec2 chord = to.p - from.p;
  const double turn = std::abs(std::remainder(to.heading_rad - from.heading_rad, 2 * std::numbers::pi));
  const double arm = glm::length(chord) * (turn > 1e-3 ? 2.0 / 3 * std::tan(turn / 4) / std::sin(turn / 2) : 1.0 / 3);
  const glm::dvec2 b[] = {from.p, from.p + arm * direction(from.heading_rad), to.p - arm * direction(to.heading_rad),
                          to.p};
  const double bearing = std::atan2(chord.y, chord.x);
  const double off = std::abs(std::remainder(bearing - from.heading_rad, 2 * std::numbers::pi)) +
                     std::abs(std::remainder(bearing - to.heading_rad, 2 * std::numbers::pi));
  const int count = std::clamp(static_cast<int>(std::ceil(std::max(turn, off) / kPiece_rad)), 1, kMostPieces);
  const auto point = [&](double x) {
    const double y = 1 - x;
    return y * y * y * b[0] + 3 * x * y * y * b[1] + 3 * x * x * y * b[2] + x * x * x * b[3];
  };
  const auto tangent = [&](double x) {
    const double y = 1 - x;
    const glm::dvec2 d = y * y * (b[1] - b[0]) + 2 * x * y * (b[2] - b[1]) + x * x * (b[3] - b[2]);
    return std::atan2(d.y, d.x);
  };
  // Pieces that bend more than a graph may are halved: arms are short where a way leads aside.
  std::vector<Segment> segments;
  const auto add = [&](auto&& self, double x0, double x1, int depth) -> void {
    Segment segment;
    segment.start_m = segments.empty() ? from.p : segments.back().end_m;
    segment.end_m = x1 == 1 ? to.p : point(x1);
    const glm::dvec2 leg = segment.end_m - segment.start_m;
    const auto turned = [&](double heading) {
      return std::remainder(heading - std::atan2(leg.y, leg.x), 2 * std::numbers::pi);
    };
    const double start = turned(x0 == 0 ? from.heading_rad : tangent(x0));
    const double end = turned(x1 == 1 ? to.heading_rad : tangent(x1));
    const double steepest = std::atan(kSteepest), most = std::max(std::abs(start), std::abs(end));
    if (most > steepest && depth < kMostHalvings) {
      self(self, x0, 0.5 * (x0 + x1), depth + 1);
      self(self, 0.5 * (x0 + x1), x1, depth + 1);
      return;
    }
    segment.slope_start = std::tan(std::clamp(start, -steepest, steepest));
    segment.slope_end = std::tan(std::clamp(end, -steepest, steepest));
    set_arc(segment);
    segments.push_back(segment);
  };
  for (int i = 0; i < count; ++i) add(add, static_cast<double>(i) / count, (i + 1.0) / count, 0);
  return segments;
}

}  // namespace

std::vector<Movement> movements(const Network& network, const RoadsById& roads, const Junction& junction) {
  std::vector<RoadEnd> ends;
  std::vector<std::vector<EndLane>> in, out;
  for (const JunctionArm& arm : junction.arms) {
    ends.push_back(end_of(network, roads, arm));
    if (!leads_to(ends.back(), junction.id)) return {};
    in.push_back(lanes_of(ends.back(), true));
    out.push_back(lanes_of(ends.back(), false));
  }
  std::vector<Movement> all;
  for (std::size_t i = 0; i < ends.size(); ++i) {
    for (std::size_t j = 0; j < ends.size(); ++j) {
      const std::size_t count = std::min(in[i].size(), out[j].size());
      if (i == j || count == 0) continue;
      const double turn = std::remainder(junction.arms[j].heading_rad + std::numbers::pi - junction.arms[i].heading_rad,
                                         2 * std::numbers::pi);
      const bool outer = ends[i].road->keep_left ? turn > kStraight_rad : turn < -kStraight_rad;
      Movement movement{i, j};
      for (std::size_t k = 0; k < count; ++k) {
        movement.lanes.push_back(
            {in[i][k + (outer ? in[i].size() - count : 0)].id, out[j][k + (outer ? out[j].size() - count : 0)].id});
      }
      all.push_back(std::move(movement));
    }
  }
  return all;
}

Road connecting_road(const Network& network, const RoadsById& roads, const Junction& junction, const Movement& movement,
                     std::string id) {
  const JunctionArm &from_arm = junction.arms[movement.from], &to_arm = junction.arms[movement.to];
  const RoadEnd from = end_of(network, roads, from_arm), to = end_of(network, roads, to_arm);
  const std::vector<EndLane> in = lanes_of(from, true), out = lanes_of(to, false);
  const EndLane &first_in = lane_of(in, movement.lanes.front().from),
                &first_out = lane_of(out, movement.lanes.front().to);
  const Pose start = pose(from, inner_edge_m(first_in, from, true), true);
  const Pose end = pose(to, inner_edge_m(first_out, to, false), false);
  Road road;
  road.id = std::move(id);
  road.name = from.road->name == to.road->name ? from.road->name : "";
  road.junction = junction.id;
  road.keep_left = from.road->keep_left;
  road.predecessor = {RoadLink::To::kRoad, from_arm.road, from_arm.at_end};
  road.successor = {RoadLink::To::kRoad, to_arm.road, to_arm.at_end};
  road.segments = curve(start, end);
  chain_arc_lengths(road);
  const double length = road.length_m();
  const Cubic height = Cubic::hermite(start.z_m, start.grade, end.z_m, end.grade, length);
  for (Segment& segment : road.segments) segment.elevation_m = height.shifted(segment.s_start_m);
  LaneSection section;
  std::vector<Lane>& side = road.keep_left ? section.left : section.right;
  for (std::size_t k = 0; k < movement.lanes.size(); ++k) {
    const LaneLink& link = movement.lanes[k];
    const EndLane &a = lane_of(in, link.from), &b = lane_of(out, link.to);
    Lane lane;
    lane.type = a.type == LaneType::kBidirectional ? LaneType::kDriving : a.type;
    lane.width_m = Cubic::hermite(a.left_m - a.right_m, 0, b.left_m - b.right_m, 0, length);
    side.push_back(lane);
    const int own = static_cast<int>(k + 1) * (road.keep_left ? 1 : -1);
    road.predecessor.lanes.push_back({own, link.from});
    road.successor.lanes.push_back({own, link.to});
  }
  (void)set_sections(road, {section});  // one, from 0 on
  return road;
}

Connection connection_of(const Junction& junction, const Movement& movement, bool keep_left, std::string connecting) {
  Connection connection{junction.arms[movement.from].road, std::move(connecting), false, {}};
  for (std::size_t k = 0; k < movement.lanes.size(); ++k) {
    connection.lanes.push_back({movement.lanes[k].from, static_cast<int>(k + 1) * (keep_left ? 1 : -1)});
  }
  return connection;
}

}  // namespace roadgen
