#include "roadgen/road/crossing.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string_view>

namespace roadgen {
namespace {

// Pieces of a corner's strips turn by at most this, so that strips as wide as the corner's radius stay certified.
constexpr double kGreatestTurn_rad = 10 * std::numbers::pi / 180;
// Of the radius of a bend, how far strips on its inside may reach: the mapping is certified short of the centre only.
constexpr double kPartOfRadius = 0.9;
constexpr const char* kCorner = ".corner.";
// The junction's area reaches this far under the strips along its corners.
constexpr double kUnderlap_m = 0.1;

bool is_beside(const Lane& lane) {
  return lane.inner_height_m != 0 || lane.outer_height_m != 0 || lane.type == LaneType::kSidewalk ||
         lane.type == LaneType::kCurb || lane.type == LaneType::kNone;
}

// The cross section at a place of a road: its lanes from right to left with their borders' t, one more; those from
// `first` to before `last` are the carriageway.
struct CrossSection {
  std::vector<Lane> lanes;
  std::vector<double> border_m;
  std::size_t rights = 0;  // lanes right of the centre lane
  std::size_t first = 0, last = 0;
};

// A run of lanes without anything beside a carriageway between them: the one that holds the reference line, or else the
// widest with a driving lane.
void find_carriageway(CrossSection& c) {
  double best = -1;
  for (std::size_t i = 0; i < c.lanes.size();) {
    std::size_t end = i;
    bool driven = false;
    for (; end < c.lanes.size() && !is_beside(c.lanes[end]); ++end) driven |= c.lanes[end].type == LaneType::kDriving;
    const double right = c.border_m[i], left = c.border_m[end];
    const double rank = right < 0 && left > 0 ? 1e300 : (driven ? left - right : 0);
    if (end > i && rank > best) best = rank, c.first = i, c.last = end;
    i = std::max(end, i + 1);
  }
  if (best < 0) c.first = c.last = c.rights;
}

CrossSection cross_section(const Road& road, const Segment& segment, double local_s_m) {
  const LaneSection& section = section_of(road, segment);
  const double ds = section_offset_m(road, segment) + local_s_m;
  CrossSection c;
  c.rights = section.right.size();
  c.lanes.assign(section.right.rbegin(), section.right.rend());
  c.lanes.insert(c.lanes.end(), section.left.begin(), section.left.end());
  for (Lane& lane : c.lanes) lane.width_m = {std::max(lane.width_m.value(ds), 0.0)};
  c.border_m.resize(c.lanes.size() + 1);
  c.border_m[c.rights] = section.offset_m.value(ds);
  for (std::size_t i = c.rights; i > 0; --i) c.border_m[i - 1] = c.border_m[i] - c.lanes[i - 1].width_m.c0;
  for (std::size_t i = c.rights; i < c.lanes.size(); ++i) c.border_m[i + 1] = c.border_m[i] + c.lanes[i].width_m.c0;
  find_carriageway(c);
  return c;
}

CrossSection section_at(const Road& road, bool at_end) {
  const Segment& segment = at_end ? road.segments.back() : road.segments.front();
  return cross_section(road, segment, at_end ? segment.arc_m : 0);
}

// What lies beside the carriageway, outward; on the left or on the right of one who looks into the junction.
std::vector<Lane> strips(const Road& road, bool at_end, bool on_left) {
  const CrossSection c = section_at(road, at_end);
  const auto at = [&](std::size_t i) { return c.lanes.begin() + static_cast<std::ptrdiff_t>(i); };
  const bool left = on_left == at_end;
  std::vector<Lane> beside(at(left ? c.last : 0), at(left ? c.lanes.size() : c.first));
  // A lane's inner border is that toward the centre lane, which may lie beyond.
  for (std::size_t i = 0; i < beside.size(); ++i) {
    const bool is_left = (left ? c.last : 0) + i >= c.rights;
    if (is_left != left) std::swap(beside[i].inner_height_m, beside[i].outer_height_m);
  }
  if (!left) std::reverse(beside.begin(), beside.end());
  return beside;
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
    // To both sides, where it is bent like an S.
    const double turn = std::abs(std::atan(whole.slope_start)) + std::abs(std::atan(whole.slope_end));
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

// Greatest width of the strips at every joint of the corner's pieces, the ends included: in a bend to the right they reach
// no farther than shortly before its centre, where the cuts of both arms meet.
std::vector<double> room_m(const std::vector<Segment>& pieces) {
  std::vector<double> room(pieces.size() + 1, 1e300);
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    double most = 0;
    for (int k = 0; k <= 8; ++k) most = std::max(most, -curvature_per_m(pieces[i], k / 8.0));
    if (most > 0) room[i] = std::min(room[i], kPartOfRadius / most), room[i + 1] = kPartOfRadius / most;
  }
  return room;
}

// The strips' section, or one for every piece where the corner has not room for all their width.
std::vector<LaneSection> corner_sections(const std::vector<Segment>& pieces, const std::vector<Lane>& strips) {
  const std::vector<double> room = room_m(pieces);
  const auto part = [&](std::size_t joint) {
    const double s = joint < pieces.size() ? pieces[joint].s_start_m : pieces.back().s_start_m + pieces.back().arc_m;
    double width = 0;
    for (const Lane& lane : strips) width += lane.width_m.value(s);
    return std::min(1.0, room[joint] / std::max(width, 1e-9));
  };
  bool fits = true;
  for (std::size_t i = 0; i <= pieces.size(); ++i) fits = fits && part(i) == 1;
  std::vector<LaneSection> sections(fits ? 1 : pieces.size());
  for (std::size_t i = 0; i < sections.size(); ++i) {
    sections[i].right = strips;
    if (fits) break;
    sections[i].s_m = pieces[i].s_start_m;
    for (Lane& lane : sections[i].right) {
      const Cubic whole = lane.width_m.shifted(pieces[i].s_start_m);
      lane.width_m =
          Cubic::hermite(part(i) * whole.value(0), part(i) * whole.slope(0), part(i + 1) * whole.value(pieces[i].arc_m),
                         part(i + 1) * whole.slope(pieces[i].arc_m), pieces[i].arc_m);
    }
  }
  return sections;
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
  const std::vector<Lane> strips = joined(beside_from, beside_to, road.length_m());
  if (Status s = set_sections(road, corner_sections(road.segments, strips)); !s) return s.error();
  // The slope across goes on from the one arm and into the other, which is seen against its direction.
  const Cubic bank = Cubic::hermite(std::atan(from.tilt + from.crossfall_right), 0,
                                    std::atan(to.crossfall_left - to.tilt), 0, road.length_m());
  for (Segment& segment : road.segments) segment.superelevation_rad = bank.shifted(segment.s_start_m);
  return road;
}

// Puts the arm's origin from the reference line into the middle of a carriageway that lies to one side of it.
void move_to_middle(JunctionArm& arm) {
  const double n = 0.5 * (arm.left_m + arm.right_m);
  arm.position_m = cut_point_m(arm, n);
  arm.elevation_m = cut_height_m(arm, n);
  arm.tilt += n > 0 ? -arm.crossfall_left : arm.crossfall_right;
  arm.crossfall_left = arm.crossfall_right = 0;
  arm.left_m -= n, arm.right_m -= n;
}

}  // namespace

std::vector<bool> corner_roads(const Network& network) {
  std::set<std::string_view> areas;
  for (const Junction& junction : network.junctions) areas.insert(junction.id);
  std::vector<bool> corners;
  for (const Road& road : network.roads) {
    const std::size_t at = road.id.rfind(kCorner);
    corners.push_back(at != road.id.npos && areas.contains(std::string_view(road.id).substr(0, at)));
  }
  return corners;
}

Carriageway carriageway_at(const Road& road, const Segment& segment, double local_s_m) {
  const CrossSection c = cross_section(road, segment, local_s_m);
  return {c.border_m[c.last], c.border_m[c.first]};
}

JunctionArm arm_of(const Road& road, bool at_end) {
  const Segment& segment = at_end ? road.segments.back() : road.segments.front();
  const double s = at_end ? segment.arc_m : 0, sign = at_end ? 1 : -1;
  const Carriageway end = carriageway_at(road, segment, s);
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
  if (arm.left_m < 0 || arm.right_m > 0) move_to_middle(arm);
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
  std::vector<std::size_t> bare;
  for (std::size_t i = 0; i < junction->arms.size(); ++i) {
    const JunctionArm &from = junction->arms[i], &to = junction->arms[(i + 1) % junction->arms.size()];
    const std::vector<Lane> beside_from = strips_of(from, false), beside_to = strips_of(to, true);
    if (beside_from.empty() && beside_to.empty()) continue;
    Result<Road> road =
        corner_road(id + kCorner + std::to_string(i), junction->corners[i], from, to, beside_from, beside_to);
    if (!road) return road.error();
    const auto certified = [](const Segment& segment) { return is_admissible(segment); };
    if (!std::all_of(road->segments.begin(), road->segments.end(), certified)) {
      bare.push_back(i);
      continue;
    }
    road->keep_left = ends.front().road->keep_left;
    corners.push_back(std::move(*road));
  }
  if (!corners.empty()) junction->underlap_m = kUnderlap_m;
  for (const std::size_t i : bare) {
    if (!diagnostics) break;
    const JunctionArm &from = junction->arms[i], &to = junction->arms[(i + 1) % junction->arms.size()];
    diagnostics->push_back(
        {Severity::kWarning,
         "nothing lies along the corner from road " + from.road + " to road " + to.road + ": it is too tight",
         {},
         0,
         "junction " + id});
  }
  return Crossing{std::move(*junction), std::move(corners), std::move(bare)};
}

std::vector<Status> add_crossings(Network& network, std::span<const CrossingPlan> plans, Diagnostics* diagnostics) {
  const RoadsById roads = roads_by_id(network);
  std::set<std::string> corner_ids;
  std::vector<Road> corners;
  const auto add = [&](const CrossingPlan& plan) -> Status {
    const auto error = [&](std::string what) {
      return Error{ErrorCode::kGeometry, std::move(what), {}, 0, "junction " + plan.id};
    };
    std::vector<EndOfRoad> ends;
    for (const RoadEnd& end : plan.ends) {
      const auto found = roads.find(end.road);
      if (found == roads.end()) return error("road " + end.road + " does not exist");
      const Road& road = network.roads[found->second];
      if (road.segments.empty() || road.closed) return error("road " + end.road + " has no end to join");
      ends.push_back({&road, end.at_end});
    }
    Result<Crossing> crossing = make_crossing(plan.id, ends, plan.options, diagnostics);
    if (!crossing) return crossing.error();
    for (const Road& corner : crossing->corners) {
      if (roads.contains(corner.id) || corner_ids.contains(corner.id)) {
        return error("road " + corner.id + ", which is to lie along its corner, is there already");
      }
    }
    for (const RoadEnd& end : plan.ends) {
      Road& road = network.roads[roads.at(end.road)];
      (end.at_end ? road.joined_end : road.joined_start) = true;
      (end.at_end ? road.successor : road.predecessor) = {.to = RoadLink::To::kJunction, .id = plan.id};
    }
    network.junctions.push_back(std::move(crossing->junction));
    for (Road& corner : crossing->corners) {
      corner_ids.insert(corner.id);
      corners.push_back(std::move(corner));
    }
    return Done{};
  };
  std::vector<Status> statuses;
  for (const CrossingPlan& plan : plans) statuses.push_back(add(plan));
  std::move(corners.begin(), corners.end(), std::back_inserter(network.roads));
  return statuses;
}

Status add_crossing(Network& network, std::string id, const std::vector<RoadEnd>& ends, const JunctionOptions& options,
                    Diagnostics* diagnostics) {
  const CrossingPlan plan{std::move(id), ends, options};
  return add_crossings(network, std::span(&plan, 1), diagnostics).front();
}

}  // namespace roadgen
