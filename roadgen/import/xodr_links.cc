#include "roadgen/import/xodr_links.h"

#include <cstring>
#include <pugixml.hpp>
#include <set>

#include "roadgen/import/xodr_records.h"

namespace roadgen {
namespace {

bool is_element(const pugi::xml_node& node) { return node.type() == pugi::node_element; }

// "start" or "end"; none for anything else.
std::optional<bool> contact_at_end(const pugi::xml_node& node) {
  const std::string_view contact = node.attribute("contactPoint").value();
  if (contact != "start" && contact != "end") return {};
  return contact == "end";
}

RoadLink read_link(XodrSource& source, const pugi::xml_node& node) {
  const std::string_view type = node.attribute("elementType").value();
  RoadLink link{.to = RoadLink::To::kNothing, .id = node.attribute("elementId").value()};
  const std::optional<bool> at_end = contact_at_end(node);
  if (type == "junction" && !link.id.empty()) {
    link.to = RoadLink::To::kJunction;
  } else if (type == "road" && !link.id.empty() && at_end) {
    link.to = RoadLink::To::kRoad;
    link.at_end = *at_end;
  } else {
    source.note(node, "a link without a road and its contact point, or a junction, is not kept");
    return {};
  }
  return link;
}

// The links of the lanes of a section, by <predecessor> or <successor>.
std::vector<LaneLink> lane_links(const pugi::xml_node& section, const char* element) {
  std::vector<LaneLink> links;
  for (const char* side : {"left", "right"}) {
    for (const pugi::xml_node lane : section.child(side).children("lane")) {
      for (const pugi::xml_node link : lane.child("link").children(element)) {
        links.push_back({lane.attribute("id").as_int(), link.attribute("id").as_int()});
      }
    }
  }
  return links;
}

std::optional<Connection> read_connection(XodrSource& source, const pugi::xml_node& node, bool direct) {
  Connection connection;
  connection.incoming = node.attribute("incomingRoad").value();
  connection.connecting = node.attribute(direct ? "linkedRoad" : "connectingRoad").value();
  const std::optional<bool> at_end = contact_at_end(node);
  if (connection.incoming.empty() || connection.connecting.empty() || !at_end) {
    source.note(node, std::string("a connection without incomingRoad, ") + (direct ? "linkedRoad" : "connectingRoad") +
                          " and contactPoint is not kept");
    return {};
  }
  connection.at_end = *at_end;
  for (const pugi::xml_node lane : node.children("laneLink")) {
    connection.lanes.push_back({lane.attribute("from").as_int(), lane.attribute("to").as_int()});
  }
  return connection;
}

// "END X Y HEADING LEFT RIGHT Z GRADE TILT FALL_LEFT FALL_RIGHT ROAD".
std::optional<JunctionArm> read_arm(std::string_view text) {
  constexpr int kNumbers = 11;
  std::size_t end = 0;
  for (int i = 0; i < kNumbers && end != text.npos; ++i) end = text.find(' ', i == 0 ? 0 : end + 1);
  if (end == text.npos) return {};
  const std::vector<double> x = numbers_in(text.substr(0, end));
  if (x.size() != kNumbers) return {};
  return JunctionArm{.road = std::string(text.substr(end + 1)),
                     .at_end = x[0] != 0,
                     .position_m = {x[1], x[2]},
                     .heading_rad = x[3],
                     .left_m = x[4],
                     .right_m = x[5],
                     .elevation_m = x[6],
                     .grade = x[7],
                     .tilt = x[8],
                     .crossfall_left = x[9],
                     .crossfall_right = x[10]};
}

std::optional<XodrJunction::Area> read_area(XodrSource& source, const pugi::xml_node& node, const std::string& text) {
  const std::vector<double> numbers = numbers_in(text);
  XodrJunction::Area area;
  for (const pugi::xml_node data : node.children("userData")) {
    if (std::strcmp(data.attribute("code").value(), "roadgen:arm") != 0) continue;
    if (const auto arm = read_arm(data.attribute("value").value())) area.arms.push_back(*arm);
  }
  if (numbers.size() != 2 || !(numbers[1] >= 0) || area.arms.empty()) {
    source.note(node, "userData roadgen:area is not a radius and an underlap with arms");
    return {};
  }
  area.corner_radius_m = numbers[0], area.underlap_m = numbers[1];
  return area;
}

}  // namespace

void read_links(XodrSource& source, const pugi::xml_node& node, Road& road) {
  const std::string junction = node.attribute("junction").value();
  if (junction != "-1") road.junction = junction;
  for (const pugi::xml_node part : node.child("link").children()) {
    if (!is_element(part)) continue;
    const std::string name = part.name();
    // To a place on a road, in a virtual junction; beside the road, of old files.
    if (part.attribute("elementS") || name == "neighbor") {
      road.records.edit().other_links_xml += element_xml(part);
      continue;
    }
    if (name != "predecessor" && name != "successor") {
      source.note(part, "<" + name + "> in links is not kept");
      continue;
    }
    const RoadLink link = read_link(source, part);
    if (link.to == RoadLink::To::kRoad && link.id == road.id) road.closed = true;
    (name == "successor" ? road.successor : road.predecessor) = link;
  }
  if (road.closed) {
    road.predecessor = road.successor = {};
    return;
  }
  const pugi::xml_node closed = node.find_child_by_attribute("userData", "code", "roadgen:link");
  if (const pugi::xml_node part = closed.child("predecessor")) road.predecessor = read_link(source, part);
  if (const pugi::xml_node part = closed.child("successor")) road.successor = read_link(source, part);
  const pugi::xml_node lanes = node.child("lanes");
  const pugi::xml_node first = lanes.child("laneSection");
  pugi::xml_node last = lanes.last_child();
  while (last && std::strcmp(last.name(), "laneSection") != 0) last = last.previous_sibling();
  if (road.predecessor.to == RoadLink::To::kRoad) road.predecessor.lanes = lane_links(first, "predecessor");
  if (road.successor.to == RoadLink::To::kRoad) road.successor.lanes = lane_links(last, "successor");
}

bool read_joined(XodrSource& source, const pugi::xml_node& node, Road& road) {
  const std::string text = user_data(node, "roadgen:joined");
  if (text.empty()) return false;
  const std::vector<double> joined = numbers_in(text);
  if (joined.size() != 2) {
    source.note(node, "userData roadgen:joined is not two numbers");
    return false;
  }
  road.joined_start = joined[0] != 0, road.joined_end = joined[1] != 0;
  return true;
}

bool holds_junction(const pugi::xml_node& user_data) {
  return !std::strcmp(user_data.attribute("code").value(), "roadgen:junction") && user_data.child("junction");
}

XodrJunction read_junction(XodrSource& source, const pugi::xml_node& outer) {
  const pugi::xml_node inner = outer.child("junction"), node = inner ? inner : outer;
  XodrJunction junction;
  if (inner) {
    const std::vector<double> place = numbers_in(outer.attribute("value").value());
    if (place.size() == 1 && place[0] >= 0 && place[0] < 1e9) junction.place = static_cast<std::size_t>(place[0]);
  }
  junction.links.id = source.word(node, "id");
  junction.links.name = node.attribute("name").value();
  junction.line = source.line(node);
  const std::string type = node.attribute("type").as_string("default");
  const std::optional<JunctionType> known = junction_type(type);
  if (!known) source.note(node, "the junction type \"" + type + "\" is read as default");
  junction.links.type = known.value_or(JunctionType::kDefault);
  JunctionRecords records;
  for (const pugi::xml_node part : node.children("connection")) {
    // Between places on roads, which no connecting road joins.
    if (part.child("predecessor") || part.child("successor")) {
      records.other_xml += element_xml(part);
    } else if (auto connection = read_connection(source, part, junction.links.type == JunctionType::kDirect)) {
      junction.links.connections.push_back(std::move(*connection));
    }
  }
  records.other_xml += other_xml(source, node, "junctions",
                                 {"priority", "controller", "surface", "planView", "boundary", "elevationGrid",
                                  "roadSection", "crossPath", "objects", "userData"},
                                 {"connection"});
  if (junction.links.type == JunctionType::kVirtual) {
    records.main_road = node.attribute("mainRoad").value();
    records.s_start_m = source.number_or(node, "sStart", 0), records.s_end_m = source.number_or(node, "sEnd", 0);
    records.orientation = orientation_of(node);
  }
  if (records != JunctionRecords{}) junction.links.records.edit() = std::move(records);
  const std::string area = user_data(node, "roadgen:area");
  junction.own = !area.empty();
  if (junction.own && area != "none") junction.area = read_area(source, node, area);
  return junction;
}

void settle_links(XodrSource& source, Network& network) {
  std::set<std::string_view> roads, junctions;
  for (const Road& road : network.roads) roads.insert(road.id);
  for (const Junction& junction : network.junctions) junctions.insert(junction.id);
  for (const JunctionLinks& junction : network.junction_links) junctions.insert(junction.id);
  for (Road& road : network.roads) {
    source.set_element("road " + road.id);
    for (RoadLink* link : {&road.predecessor, &road.successor}) {
      const bool to_road = link->to == RoadLink::To::kRoad;
      if (link->to == RoadLink::To::kNothing || (to_road ? roads : junctions).contains(link->id)) continue;
      source.note(0, std::string("a link to a ") + (to_road ? "road" : "junction") + " that is not there is dropped");
      *link = {};
    }
    if (!road.junction.empty() && !junctions.contains(road.junction)) {
      source.note(0, "roads of a junction that is not there are read as others");
      road.junction.clear();
    }
  }
  for (JunctionLinks& junction : network.junction_links) {
    source.set_element("junction " + junction.id);
    const auto lost = [&](const Connection& c) { return !roads.contains(c.incoming) || !roads.contains(c.connecting); };
    const std::size_t count = std::erase_if(junction.connections, lost);
    for (std::size_t i = 0; i < count; ++i) source.note(0, "a connection of a road that is not there is dropped");
    const std::string& main_road = junction.records->main_road;
    if (junction.type == JunctionType::kVirtual && !roads.contains(main_road)) {
      source.note(0, "the mainRoad of a virtual junction is not there");
      if (!main_road.empty()) junction.records.edit().main_road.clear();
    }
  }
  source.set_element("");
  const std::vector<std::string> odd = link_problems(network);
  if (odd.empty()) return;
  source.note(0, odd.front() + (odd.size() > 1 ? " (and " + std::to_string(odd.size() - 1) + " more such links)" : ""));
}

}  // namespace roadgen
