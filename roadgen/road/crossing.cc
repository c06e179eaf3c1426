#include "roadgen/road/crossing.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace roadgen {
namespace {

// Pieces of a corner's strips turn by at most this, so that strips as wide as the corner's radius stay certified.
constexpr double kGreatestTurn_rad = 10 * std::numbers::pi / 180;
// The junction's area reaches this far under the strips along its corners.
constexpr double kUnderlap_m = 0.1;

bool is_beside(const Lane& lane) {
  return lane.inner_height_m != 0 || lane.outer_height_m != 0 || lane.type == LaneType::kSidewalk ||
         lane.type == LaneType::kCurb || lane.type == LaneType::kNone;
}

std::size_t carriageway_lanes(const std::vector<Lane>& side) {
  return static_cast<std::size_t>(std::find_if(side.begin(), side.end(), is_beside) - side.begin());
}

// The cross section at an end of a road, with every width a number.
struct EndSection {
  LaneSection section;
  double left_m, right_m;  // t of the carriageway's edges along the road
};

std::vector<Lane> frozen(std::vector<Lane> lanes, double ds_m) {
  for (Lane& lane : lanes) lane.width_m = {std::max(lane.width_m.value(ds_m), 0.0)};
  return lanes;
}

EndSection section_at(const Road& road, bool at_end) {
  const Segment& segment = at_end ? road.segments.back() : road.segments.front();
  const double ds = section_offset_m(road, segment) + (at_end ? segment.arc_m : 0);
  EndSection end;
  end.section = section_of(road, segment);
  end.section.left = frozen(end.section.left, ds);
  end.section.right = frozen(end.section.right, ds);
  end.left_m = end.right_m = end.section.offset_m.value(ds);
  for (std::size_t i = 0; i < carriageway_lanes(end.section.left); ++i) end.left_m += end.section.left[i].width_m.c0;
  for (std::size_t i = 0; i < carriageway_lanes(end.section.right); ++i) end.right_m -= end.section.right[i].width_m.c0;
  return end;
}

// What lies beside the carriageway, outward; on the left or on the right of one who looks into the junction.
std::vector<Lane> strips(const Road& road, bool at_end, bool on_left) {
  const LaneSection section = section_at(road, at_end).section;
  const std::vector<Lane>& side = on_left == at_end ? section.left : section.right;
  return {side.begin() + static_cast<std::ptrdiff_t>(carriageway_lanes(side)), side.end()};
}

// Strips of one type go from one width to the other; what only one side has tapers away.
std::vector<Lane> joined(const std::vector<Lane>& from, const std::vector<Lane>& to, double length_m) {
  std::vector<Lane> all;
  const auto add = [&](const Lane& lane, double width0, double width1) {
    all.push_back(lane);
    all.back().width_m = Cubic::hermite(width0, 0, width1, 0, length_m);
    all.back().mark = {};
  };
  std::size_t next = 0;
  for (const Lane& lane : from) {
    const auto match = std::find_if(to.begin() + static_cast<std::ptrdiff_t>(next), to.end(),
                                    [&](const Lane& other) { return other.type == lane.type; });
    if (match == to.end()) {
      add(lane, lane.width_m.c0, 0);
      continue;
    }
    for (; to.begin() + static_cast<std::ptrdiff_t>(next) != match; ++next) add(to[next], 0, to[next].width_m.c0);
    add(lane, lane.width_m.c0, match->width_m.c0);
    ++next;
  }
  for (; next < to.size(); ++next) add(to[next], 0, to[next].width_m.c0);
  return all;
}

// The corner's curve in pieces that turn less, with its heights.
std::vector<Segment> fine_pieces(const std::vector<Segment>& corner, double width_m) {
  std::vector<Segment> pieces;
  for (const Segment& whole : corner) {
    const double turn = std::abs(std::remainder(heading_rad(whole, 1) - heading_rad(whole, 0), 2 * std::numbers::pi));
    const int count = std::max(1, static_cast<int>(std::ceil(turn / kGreatestTurn_rad)));
    for (int i = 0; i < count; ++i) {
      const double u0 = static_cast<double>(i) / count, u1 = static_cast<double>(i + 1) / count;
      const double s0 = arc_at(whole, u0), s1 = arc_at(whole, u1);
      Segment piece = make_segment(position_m(whole, u0), position_m(whole, u1), heading_rad(whole, u0),
                                   heading_rad(whole, u1), width_m);
      const Cubic& z = whole.elevation_m;
      piece.elevation_m = Cubic::hermite(z.value(s0), z.slope(s0), z.value(s1), z.slope(s1), piece.arc_m);
      pieces.push_back(piece);
    }
  }
  return pieces;
}

Result<Road> corner_road(std::string id, const std::vector<Segment>& corner, const JunctionArm& from,
                         const JunctionArm& to, const std::vector<Lane>& beside_from,
                         const std::vector<Lane>& beside_to) {
  const auto total = [](const std::vector<Lane>& lanes) {
    double width = 0;
    for (const Lane& lane : lanes) width += lane.width_m.c0;
    return width;
  };
  Road road;
  road.id = std::move(id);
  road.joined_start = road.joined_end = true;
  road.segments = fine_pieces(corner, std::max(total(beside_from), total(beside_to)));
  chain_arc_lengths(road);
  LaneSection section;
  section.right = joined(beside_from, beside_to, road.length_m());
  if (Status s = set_sections(road, {section}); !s) return s.error();
  // The slope across goes on from the one arm and into the other, which is seen against its direction.
  const Cubic bank = Cubic::hermite(std::atan(from.tilt + from.crossfall_right), 0,
                                    std::atan(to.crossfall_left - to.tilt), 0, road.length_m());
  for (Segment& segment : road.segments) segment.superelevation_rad = bank.shifted(segment.s_start_m);
  return road;
}

Road* find(Network& network, const std::string& id) {
  const auto at = std::find_if(network.roads.begin(), network.roads.end(), [&](const Road& r) { return r.id == id; });
  return at == network.roads.end() ? nullptr : &*at;
}

}  // namespace

JunctionArm arm_of(const Road& road, bool at_end) {
  const Segment& segment = at_end ? road.segments.back() : road.segments.front();
  const double s = at_end ? segment.arc_m : 0, sign = at_end ? 1 : -1;
  const EndSection end = section_at(road, at_end);
  const double bank = segment.superelevation_rad.value(s);
  const Linear &left = at_end ? segment.crossfall_left : segment.crossfall_right,
               &right = at_end ? segment.crossfall_right : segment.crossfall_left;
  JunctionArm arm;
  arm.road = road.id;
  arm.at_end = at_end;
  arm.position_m = at_end ? segment.end_m : segment.start_m;
  arm.heading_rad =
      std::remainder(heading_rad(segment, at_end ? 1 : 0) + (at_end ? 0 : std::numbers::pi), 2 * std::numbers::pi);
  arm.left_m = std::cos(bank) * (at_end ? end.left_m : -end.right_m);
  arm.right_m = std::cos(bank) * (at_end ? end.right_m : -end.left_m);
  arm.elevation_m = segment.elevation_m.value(s);
  arm.grade = sign * segment.elevation_m.slope(s);
  arm.tilt = sign * std::tan(bank);
  arm.crossfall_left = left.value(s);
  arm.crossfall_right = right.value(s);
  return arm;
}

Result<Crossing> make_crossing(const std::string& id, std::span<const EndOfRoad> ends, const JunctionOptions& options,
                               Diagnostics* diagnostics) {
  std::vector<JunctionArm> arms;
  for (const EndOfRoad& end : ends) arms.push_back(arm_of(*end.road, end.at_end));
  Result<Junction> junction = make_junction(id, std::move(arms), options, diagnostics);
  if (!junction) return junction.error();
  const auto strips_of = [&](const JunctionArm& arm, bool on_left) {
    const auto end = std::find_if(ends.begin(), ends.end(),
                                  [&](const EndOfRoad& e) { return e.road->id == arm.road && e.at_end == arm.at_end; });
    return strips(*end->road, end->at_end, on_left);
  };
  std::vector<Road> corners;
  for (std::size_t i = 0; i < junction->arms.size(); ++i) {
    const JunctionArm &from = junction->arms[i], &to = junction->arms[(i + 1) % junction->arms.size()];
    const std::vector<Lane> beside_from = strips_of(from, false), beside_to = strips_of(to, true);
    if (beside_from.empty() && beside_to.empty()) continue;
    Result<Road> road =
        corner_road(id + ".corner." + std::to_string(i), junction->corners[i], from, to, beside_from, beside_to);
    if (!road) return road.error();
    corners.push_back(std::move(*road));
  }
  if (!corners.empty()) junction->underlap_m = kUnderlap_m;
  return Crossing{std::move(*junction), std::move(corners)};
}

Status add_crossing(Network& network, std::string id, const std::vector<RoadEnd>& ends, const JunctionOptions& options,
                    Diagnostics* diagnostics) {
  std::vector<EndOfRoad> found;
  for (const RoadEnd& end : ends) {
    const Road* road = find(network, end.road);
    if (!road || road->segments.empty() || road->closed) {
      return Error{ErrorCode::kGeometry,
                   "road " + end.road + (road ? " has no end to join" : " does not exist"),
                   {},
                   0,
                   "junction " + id};
    }
    found.push_back({road, end.at_end});
  }
  Result<Crossing> crossing = make_crossing(id, found, options, diagnostics);
  if (!crossing) return crossing.error();
  for (const RoadEnd& end : ends) {
    Road& road = *find(network, end.road);
    (end.at_end ? road.joined_end : road.joined_start) = true;
  }
  network.junctions.push_back(std::move(crossing->junction));
  std::move(crossing->corners.begin(), crossing->corners.end(), std::back_inserter(network.roads));
  return Done{};
}

}  // namespace roadgen
