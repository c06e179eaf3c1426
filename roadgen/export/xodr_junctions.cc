#include "roadgen/export/xodr_junctions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "roadgen/export/xodr_records.h"
#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

const char* contact(bool at_end) { return at_end ? "end" : "start"; }

void write_link(XmlWriter& out, const char* element, const RoadLink& link) {
  if (link.to == RoadLink::To::kNothing) return;
  const bool road = link.to == RoadLink::To::kRoad;
  out.raw("      <").raw(element).text("elementType", road ? "road" : "junction").text("elementId", link.id);
  if (road) out.text("contactPoint", contact(link.at_end));
  out.raw("/>\n");
}

void write_arm(XmlWriter& out, const JunctionArm& a) {
  const double numbers[] = {
      a.at_end ? 1.0 : 0.0, a.position_m.x, a.position_m.y, a.heading_rad,    a.left_m,         a.right_m,
      a.elevation_m,        a.grade,        a.tilt,         a.crossfall_left, a.crossfall_right};
  out.user_data("    ", "arm", numbers, a.road);
}

// connections: where they are not those of links.
void write_junction(XmlWriter& out, const JunctionLinks& links, const std::vector<Connection>& connections,
                    const Junction* area) {
  out.raw("  <junction").text("id", links.id).text("name", links.name);
  out.text("type", junction_type_name(links.type));
  const JunctionRecords& records = *links.records;
  if (links.type == JunctionType::kVirtual) {
    out.text("mainRoad", records.main_road).number("sStart", records.s_start_m).number("sEnd", records.s_end_m);
    out.text("orientation", orientation_name(records.orientation));
  }
  out.raw(">\n");
  const char* connecting = links.type == JunctionType::kDirect ? "linkedRoad" : "connectingRoad";
  for (std::size_t i = 0; i < connections.size(); ++i) {
    const Connection& c = connections[i];
    out.raw("    <connection").text("id", std::to_string(i)).text("incomingRoad", c.incoming);
    out.text(connecting, c.connecting).text("contactPoint", contact(c.at_end)).raw(">\n");
    for (const LaneLink& lane : c.lanes) {
      out.raw("      <laneLink").text("from", std::to_string(lane.from)).text("to", std::to_string(lane.to));
      out.raw("/>\n");
    }
    out.raw("    </connection>\n");
  }
  write_kept(out, "    ", records.other_xml);
  if (area) {
    out.user_data("    ", "area", {area->corner_radius_m, area->underlap_m});
    for (const JunctionArm& arm : area->arms) write_arm(out, arm);
  } else {
    out.user_data("    ", "area", {}, "none");
  }
  out.raw("  </junction>\n");
}

// Whether make_junction lays these corners for these arms, to the bit.
bool can_be_laid(const Junction& junction) {
  const Result<Junction> again =
      make_junction(junction.id, junction.arms, {.corner_radius_m = junction.corner_radius_m});
  if (!again || again->corners.size() != junction.corners.size()) return false;
  const auto same = [](const Segment& a, const Segment& b) {
    return a.start_m == b.start_m && a.end_m == b.end_m && a.slope_start == b.slope_start &&
           a.slope_end == b.slope_end && a.s_start_m == b.s_start_m && a.elevation_m == b.elevation_m;
  };
  for (std::size_t i = 0; i < junction.corners.size(); ++i) {
    const auto &a = junction.corners[i], &b = again->corners[i];
    if (!std::equal(a.begin(), a.end(), b.begin(), b.end(), same)) return false;
  }
  return true;
}

}  // namespace

JunctionIds closed_junctions(const Network& network, const RoadsById& roads) {
  const LinksById listed = links_by_id(network);
  std::vector<char> has_ways(network.junctions.size());
  for_chunks(has_ways.size(), 64, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) has_ways[i] = !movements(network, roads, network.junctions[i]).empty();
  });
  JunctionIds open, closed;
  for (std::size_t i = 0; i < has_ways.size(); ++i) (has_ways[i] ? open : closed).insert(network.junctions[i].id);
  for (const JunctionLinks& links : network.junction_links) {
    // One of another type has no connections where it has what is kept as text.
    if (!links.connections.empty() || !links.records->other_xml.empty()) {
      closed.erase(links.id);
    } else if (!open.contains(links.id)) {
      closed.insert(links.id);
    }
  }
  return closed;
}

namespace {

bool is_closed(const RoadLink& link, const JunctionIds& closed) {
  return link.to == RoadLink::To::kJunction && closed.contains(link.id);
}

}  // namespace

void write_links(XmlWriter& out, const Road& road, const JunctionIds& closed) {
  RoadLink before = road.predecessor, after = road.successor;
  if (road.closed) {
    before = {.to = RoadLink::To::kRoad, .id = road.id, .at_end = true};
    after = {.to = RoadLink::To::kRoad, .id = road.id, .at_end = false};
  }
  for (RoadLink* link : {&before, &after}) {
    if (is_closed(*link, closed)) *link = {};
  }
  const std::string& others = road.records->other_links_xml;
  if (before.to == RoadLink::To::kNothing && after.to == RoadLink::To::kNothing && others.empty()) return;
  out.raw("    <link>\n");
  write_link(out, "predecessor", before);
  write_link(out, "successor", after);
  write_kept(out, "      ", others);
  out.raw("    </link>\n");
}

void write_closed_links(XmlWriter& out, const Road& road, const JunctionIds& closed) {
  const bool before = is_closed(road.predecessor, closed), after = is_closed(road.successor, closed);
  if (road.closed || (!before && !after)) return;
  out.raw("    <userData code=\"roadgen:link\">\n");
  if (before) write_link(out, "predecessor", road.predecessor);
  if (after) write_link(out, "successor", road.successor);
  out.raw("    </userData>\n");
}

void write_joined(XmlWriter& out, const Road& road) {
  const bool linked = road.predecessor.to != RoadLink::To::kNothing || road.successor.to != RoadLink::To::kNothing;
  if (!linked && !road.joined_start && !road.joined_end) return;
  out.user_data("    ", "joined", {road.joined_start ? 1.0 : 0.0, road.joined_end ? 1.0 : 0.0});
}

LinksById links_by_id(const Network& network) {
  LinksById links;
  for (const JunctionLinks& l : network.junction_links) links.emplace(l.id, &l);
  return links;
}

std::vector<DerivedWay> derived_ways(const Network& network, const RoadsById& roads, const LinksById& listed,
                                     const Junction& area) {
  const auto links = listed.find(area.id);
  if (links != listed.end() && !links->second->connections.empty()) return {};
  std::vector<DerivedWay> ways;
  std::size_t number = 0;
  for (Movement& movement : movements(network, roads, area)) {
    std::string id;
    do {
      id = area.id + ".way." + std::to_string(number++);
    } while (roads.contains(id));
    ways.push_back({std::move(movement), std::move(id)});
  }
  return ways;
}

void write_junctions(XmlWriter& out, const Network& network, const RoadsById& roads, const JunctionIds& closed,
                     bool closed_ones) {
  const LinksById listed = links_by_id(network);
  std::size_t place = 0;  // among all
  const auto write = [&](const JunctionLinks& links, const Junction* area) {
    const std::size_t here = place++;
    if (closed.contains(links.id) != closed_ones) return;
    std::vector<Connection> connections = links.connections;
    if (area && connections.empty() && !closed_ones) {
      for (DerivedWay& way : derived_ways(network, roads, listed, *area)) {
        const Road& from = network.roads[roads.at(area->arms[way.movement.from].road)];
        connections.push_back(connection_of(*area, way.movement, from.keep_left, std::move(way.id)));
      }
    }
    if (closed_ones) out.raw("  <userData code=\"roadgen:junction\"").text("value", std::to_string(here)).raw(">\n");
    write_junction(out, links, connections, area);
    if (closed_ones) out.raw("  </userData>\n");
  };
  std::map<std::string_view, std::size_t> areas;
  for (std::size_t i = 0; i < network.junctions.size(); ++i) areas.emplace(network.junctions[i].id, i);
  // Areas alone keep their place among those that are nodes too.
  std::size_t next = 0;
  const auto write_lone_areas = [&](std::size_t end) {
    for (; next < end; ++next) {
      const Junction& area = network.junctions[next];
      if (!listed.contains(area.id)) write({.id = area.id, .name = {}}, &area);
    }
  };
  for (const JunctionLinks& links : network.junction_links) {
    const auto area = areas.find(links.id);
    if (area != areas.end()) write_lone_areas(area->second);
    write(links, area == areas.end() ? nullptr : &network.junctions[area->second]);
  }
  write_lone_areas(network.junctions.size());
}

Status check_junctions(const Network& network) {
  const auto error = [](const std::string& id, const char* what) {
    return Error{ErrorCode::kData, what, {}, 0, "junction " + id};
  };
  std::set<std::string_view> areas, nodes;
  for (const JunctionLinks& links : network.junction_links) {
    if (!std::isfinite(links.records->s_start_m + links.records->s_end_m))
      return error(links.id, "a number is not finite");
    if (links.id.empty()) return error("", "a junction has no id; give every junction one");
    if (!nodes.insert(links.id).second) return error(links.id, "the id is used twice");
  }
  for (const Junction& area : network.junctions) {
    if (area.id.empty()) return error("", "a junction has no id; give every junction one");
    if (!areas.insert(area.id).second) return error(area.id, "the id is used twice");
  }
  std::vector<char> laid(network.junctions.size());
  for_chunks(laid.size(), 16, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) laid[i] = can_be_laid(network.junctions[i]);
  });
  for (std::size_t i = 0; i < laid.size(); ++i) {
    if (laid[i]) continue;
    return error(network.junctions[i].id, "the area is not one that make_junction lays for its arms and radius");
  }
  return Done{};
}

}  // namespace roadgen
