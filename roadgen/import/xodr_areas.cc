#include "roadgen/import/xodr_areas.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <glm/geometric.hpp>

#include "roadgen/road/crossing.h"
#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

// How far a road's end may lie from the arm that our own file states.
constexpr double kMovedArm_m = 0.01, kTurnedArm_rad = 1e-3;
constexpr double kMostOutside_m = 0.5;
constexpr double kMostStep_m = 0.3;
constexpr double kMostFree = 0.5;  // part of the area: shoulders and medians that no way leads over
constexpr double kWidest_m = 500;  // area, and carriageway of a connecting road
constexpr double kCell_m = 1;      // of the area, covered where a way leads through
constexpr double kMargin_m = 0.5;  // from the area's edge, where no cell is looked at

const Road* find(const Network& network, const RoadsById& ids, const std::string& id) {
  const auto at = ids.find(id);
  return at == ids.end() ? nullptr : &network.roads[at->second];
}

// Without the junction's name, which the note has already.
std::string plain_message(const std::string& id, const Error& error) {
  const std::string prefix = "junction " + id + ": ";
  return error.message.starts_with(prefix) ? error.message.substr(prefix.size()) : error.message;
}

// The arm as the road has it now, where it is no longer what the file states.
bool take_moved_arm(const Road& road, JunctionArm& arm) {
  const JunctionArm now = arm_of(road, arm.at_end);
  const double turn = std::remainder(now.heading_rad - arm.heading_rad, 2 * M_PI);
  const double off = std::max({glm::length(now.position_m - arm.position_m), std::abs(now.left_m - arm.left_m),
                               std::abs(now.right_m - arm.right_m), std::abs(now.elevation_m - arm.elevation_m)});
  if (off <= kMovedArm_m && std::abs(turn) <= kTurnedArm_rad) return false;
  arm = now;
  return true;
}

void add_own_area(XodrSource& source, const XodrJunction& junction, const RoadsById& ids, Network& network) {
  std::vector<JunctionArm> arms = junction.area->arms;
  bool moved = false;
  for (JunctionArm& arm : arms) {
    const Road* road = find(network, ids, arm.road);
    if (!road) return source.note(junction.line, "the area of a junction at a road that is not there is not kept");
    moved = take_moved_arm(*road, arm) || moved;
  }
  if (moved) source.note(junction.line, "userData roadgen:arm does not agree with its road, whose end is taken");
  auto area = make_junction(junction.links.id, std::move(arms), {.corner_radius_m = junction.area->corner_radius_m});
  if (!area)
    return source.note(junction.line,
                       "the area of the junction is not kept: " + plain_message(junction.links.id, area.error()));
  area->underlap_m = junction.area->underlap_m;
  network.junctions.push_back(std::move(*area));
}

// The ends of roads that meet in a junction, and the roads that lie in it.
struct Meeting {
  std::vector<RoadEnd> ends;
  std::vector<std::size_t> ways;  // of the network's roads
};

using Meetings = std::map<std::string, Meeting>;

Meetings meetings(const Network& network, const RoadsById& ids) {
  Meetings all;
  const auto add = [&](const std::string& junction, const Road& road, bool at_end) {
    std::vector<RoadEnd>& ends = all[junction].ends;
    const bool known = std::any_of(ends.begin(), ends.end(),
                                   [&](const RoadEnd& e) { return e.road == road.id && e.at_end == at_end; });
    if (!known && !road.closed) ends.push_back({road.id, at_end});
  };
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road& road = network.roads[i];
    if (!road.junction.empty()) all[road.junction].ways.push_back(i);
    for (const RoadLink* link : {&road.predecessor, &road.successor}) {
      if (link->to == RoadLink::To::kJunction && road.junction.empty()) add(link->id, road, link == &road.successor);
      const Road* other = link->to == RoadLink::To::kRoad ? find(network, ids, link->id) : nullptr;
      if (!road.junction.empty() && other && other->junction.empty()) add(road.junction, *other, link->at_end);
    }
  }
  return all;
}

// Calls visit(segment, local s, signed offset n, place, whether it is an edge) for places of a connecting road's
// carriageway, at most across_m apart across it and along_m along the reference line, its ends included; until visit
// returns false, as then does this.
template <class Visit>
bool visit_carriageway(const Road& road, double along_m, double across_m, const Visit& visit) {
  const auto visit_across = [&](const Segment& segment, double local) {
    const double u = u_at_arc(segment, local), heading = heading_rad(segment, u);
    const Carriageway c = carriageway_at(road, segment, local);
    const glm::dvec2 middle = position_m(segment, u), left(-std::sin(heading), std::cos(heading));
    const double cosine = std::cos(segment.superelevation_rad.value(local));
    const int across = 1 + static_cast<int>((c.left_m - c.right_m) / across_m);
    for (int j = 0; j <= across; ++j) {
      const double n = cosine * (c.right_m + (c.left_m - c.right_m) * j / across);
      if (!visit(segment, local, n, middle + n * left, j == 0 || j == across)) return false;
    }
    return true;
  };
  double next_m = 0;  // from the segment's start
  for (const Segment& segment : road.segments) {
    for (; next_m < segment.arc_m; next_m += along_m) {
      if (!visit_across(segment, next_m)) return false;
    }
    next_m -= segment.arc_m;
  }
  return visit_across(road.segments.back(), road.segments.back().arc_m);
}

// Whether all of the area and of the road are level and near one another in height.
bool are_level(const Junction& area, const Road& road) {
  const double z = area.arms.front().elevation_m;
  return std::all_of(area.arms.begin(), area.arms.end(),
                     [&](const JunctionArm& arm) {
                       return arm.elevation_m == z && arm.grade == 0 && arm.tilt == 0 && arm.crossfall_left == 0 &&
                              arm.crossfall_right == 0;
                     }) &&
         std::all_of(road.segments.begin(), road.segments.end(), [&](const Segment& segment) {
           const Bounds b = bounds(segment);
           return std::max(b.high_m.z - z, z - b.low_m.z) <= kMostStep_m;
         });
}

// Where the connecting roads' carriageways are not the area's surface; empty where they are. Places may be as far apart as
// they are: surfaces are smooth, and of a bend of radius 5 m that reaches beyond the area by 0.5 m, 4.5 m of edge are outside.
std::string departure(const Junction& area, const JunctionSurface& surface, const Network& network,
                      const std::vector<std::size_t>& ways) {
  constexpr double kAlong_m = 3, kAcross_m = 2;
  constexpr double kFar_m = 2 * kMostOutside_m;  // which distances beyond need not be told apart
  const char* why = "";
  for (const std::size_t way : ways) {
    const bool level = are_level(area, network.roads[way]);
    const bool agrees = visit_carriageway(
        network.roads[way], kAlong_m, kAcross_m,
        [&](const Segment& segment, double local, double n, glm::dvec2 p, bool is_edge) {
          if (level && !is_edge) return true;
          if (!is_inside(surface, p)) {
            if (!is_edge || signed_distance_m(surface, p, kFar_m) >= -kMostOutside_m) return true;
            why = "its roads reach beyond the area between the ends";
            return false;
          }
          if (level || std::abs(surface_at(segment, local, n).height - height_m_at(surface, p)) <= kMostStep_m)
            return true;
          why = "its roads lie at different heights";
          return false;
        });
    if (!agrees) break;
  }
  return why;
}

// Whether the connecting roads leave much of the area free. Requires: area and roads of sane sizes.
bool is_mostly_free(const JunctionSurface& surface, const Network& network, const std::vector<std::size_t>& ways) {
  const glm::dvec2 low = glm::dvec2(surface.center_m) + glm::dvec2(surface.low_m);
  const glm::dvec2 size = glm::dvec2(surface.high_m) - glm::dvec2(surface.low_m);
  const int columns = 1 + static_cast<int>(size.x / kCell_m), rows = 1 + static_cast<int>(size.y / kCell_m);
  std::vector<char> covered(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  const auto at = [&](int x, int y) -> char& {
    return covered[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(x)];
  };
  // Closer than the cells are wide, so that none of those that a road covers is missed. Edges are left out: as many cells
  // are half covered as are half missed.
  for (const std::size_t way : ways) {
    visit_carriageway(network.roads[way], 0.4 * kCell_m, 0.5 * kCell_m,
                      [&](const Segment&, double, double, glm::dvec2 p, bool is_edge) {
                        const glm::dvec2 cell = (p - low) / kCell_m;
                        if (!is_edge && cell.x >= 0 && cell.y >= 0 && cell.x < columns && cell.y < rows)
                          at(static_cast<int>(cell.x), static_cast<int>(cell.y)) = 1;
                        return true;
                      });
  }
  std::size_t inside = 0, free = 0;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (signed_distance_m(surface, low + kCell_m * glm::dvec2(x + 0.5, y + 0.5), kMargin_m) < kMargin_m) continue;
      ++inside;
      free += at(x, y) ? 0 : 1;
    }
  }
  return static_cast<double>(free) > kMostFree * static_cast<double>(inside);
}

// Corners as wide as the arms allow: connecting roads begin to turn at the cuts.
constexpr JunctionOptions kWidestCorners{.corner_radius_m = 1e3};

// Why the junction keeps its roads; empty where it can have an area.
std::string roads_kept_why(const Network& network, const RoadsById& ids, const std::string& id,
                           const Meeting& meeting) {
  if (meeting.ways.empty()) return "it has no connecting roads";
  std::vector<JunctionArm> arms;
  for (const RoadEnd& end : meeting.ends) arms.push_back(arm_of(*find(network, ids, end.road), end.at_end));
  const Result<Junction> area = make_junction(id, std::move(arms), kWidestCorners);
  if (!area) return plain_message(id, area.error());
  const JunctionSurface surface = junction_pieces(*area);
  const glm::dvec3 size = surface.high_m - surface.low_m;
  bool vast = std::max(size.x, size.y) > kWidest_m;
  for (const std::size_t way : meeting.ways) {
    const Road& road = network.roads[way];
    vast = vast || road.length_m() > 2 * kWidest_m;
    for (const Segment& segment : road.segments) vast = vast || segment.max_half_width_m() > kWidest_m;
  }
  if (vast) return "it is too large";
  if (std::string why = departure(*area, surface, network, meeting.ways); !why.empty()) return why;
  return is_mostly_free(surface, network, meeting.ways) ? "its roads leave much of the area free" : "";
}

// The same for every junction that could have an area, on all cores.
std::vector<std::string> roads_kept_why(const Network& network, const RoadsById& ids,
                                        const std::vector<XodrJunction>& junctions, const Meetings& all) {
  std::vector<std::string> reasons(junctions.size());
  for_chunks(junctions.size(), 1, [&](std::size_t, std::size_t i, std::size_t) {
    const XodrJunction& junction = junctions[i];
    if (junction.own || junction.links.type != JunctionType::kDefault) return;
    const auto meeting = all.find(junction.links.id);
    reasons[i] =
        meeting == all.end() ? "no roads meet in it" : roads_kept_why(network, ids, junction.links.id, meeting->second);
  });
  return reasons;
}

}  // namespace

void add_areas(XodrSource& source, const std::vector<XodrJunction>& junctions, Network& network) {
  const RoadsById ids = roads_by_id(network);
  const Meetings all = meetings(network, ids);
  std::vector<CrossingPlan> plans;
  std::vector<const XodrJunction*> planned;
  const auto keep_roads = [&](const XodrJunction& junction, const std::string& why) {
    source.set_element("junction " + junction.links.id);
    source.note(junction.line, "a junction keeps its roads: " + why);
  };
  const std::vector<std::string> reasons = roads_kept_why(network, ids, junctions, all);
  for (std::size_t i = 0; i < junctions.size(); ++i) {
    const XodrJunction& junction = junctions[i];
    source.set_element("junction " + junction.links.id);
    if (junction.area) add_own_area(source, junction, ids, network);
    if (junction.own) continue;
    if (junction.links.type != JunctionType::kDefault) {
      source.note(junction.line, "a junction of another type than default keeps its roads");
      continue;
    }
    if (!reasons[i].empty()) {
      keep_roads(junction, reasons[i]);
      continue;
    }
    plans.push_back({junction.links.id, all.at(junction.links.id).ends, kWidestCorners});
    planned.push_back(&junction);
  }
  const std::vector<Status> added = add_crossings(network, plans);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const XodrJunction& junction = *planned[i];
    if (!added[i]) {
      keep_roads(junction, plain_message(junction.links.id, added[i].error()));
      continue;
    }
    const auto painted = [&](std::size_t way) { return !network.roads[way].paint.empty(); };
    if (const auto& ways = all.at(junction.links.id).ways; std::any_of(ways.begin(), ways.end(), painted)) {
      source.set_element("junction " + junction.links.id);
      source.note(junction.line, "paint of roads that lie in a junction's area is not drawn");
    }
  }
}

}  // namespace roadgen
