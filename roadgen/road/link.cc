#include "roadgen/road/link.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include <glm/geometric.hpp>

#include "roadgen/road/network.h"

namespace roadgen {
namespace {

const RoadLink& link_of(const Road& road, bool at_end) { return at_end ? road.successor : road.predecessor; }

std::string described(const RoadLink& link) {
  switch (link.to) {
    case RoadLink::To::kNothing: return "nothing";
    case RoadLink::To::kJunction: return "junction " + link.id;
    case RoadLink::To::kRoad: return (link.at_end ? "the end of road " : "the start of road ") + link.id;
  }
  return {};
}

// Where an end of a road lies.
glm::dvec3 end_m(const Road& road, bool at_end) {
  const Segment& segment = at_end ? road.segments.back() : road.segments.front();
  return {at_end ? segment.end_m : segment.start_m, segment.elevation_m.value(at_end ? segment.arc_m : 0)};
}

// Why a link of a road's end is wrong; empty where it is not.
// junctions: their types.
using JunctionTypes = std::map<std::string_view, JunctionType>;
std::string link_fault(const Network& network, const RoadsById& roads, const JunctionTypes& junctions, const Road& road,
                       bool at_end) {
  const RoadLink& link = link_of(road, at_end);
  if (link.to == RoadLink::To::kJunction) return junctions.contains(link.id) ? "" : "which does not exist";
  if (link.to == RoadLink::To::kNothing) return {};
  const auto found = roads.find(link.id);
  if (found == roads.end()) return "which does not exist";
  const Road& other = network.roads[found->second];
  const RoadLink& back = link_of(other, link.at_end);
  if (back.to == RoadLink::To::kRoad && back.id == road.id && back.at_end == at_end) return {};
  if (back.to == RoadLink::To::kJunction && !road.junction.empty() && back.id == road.junction) return {};
  // A road that goes on into several is linked to the direct junction between, and they to it.
  const auto between = back.to == RoadLink::To::kJunction ? junctions.find(back.id) : junctions.end();
  if (between != junctions.end() && between->second == JunctionType::kDirect) return {};
  return "which is linked to " + (other.closed ? "itself" : described(back));
}

constexpr std::string_view kJunctionTypes[] = {"default", "virtual", "direct", "crossing"};

}  // namespace

std::string_view junction_type_name(JunctionType type) { return kJunctionTypes[static_cast<std::size_t>(type)]; }

std::optional<JunctionType> junction_type(std::string_view name) {
  if (name == "common") return JunctionType::kDefault;
  const auto found = std::find(std::begin(kJunctionTypes), std::end(kJunctionTypes), name);
  if (found == std::end(kJunctionTypes)) return {};
  return static_cast<JunctionType>(found - std::begin(kJunctionTypes));
}

std::vector<std::string> link_problems(const Network& network) {
  const RoadsById roads = roads_by_id(network);
  JunctionTypes junctions;
  for (const JunctionLinks& junction : network.junction_links) junctions.emplace(junction.id, junction.type);
  for (const Junction& junction : network.junctions) junctions.emplace(junction.id, JunctionType::kDefault);
  std::vector<std::string> found;
  for (const Road& road : network.roads) {
    for (const bool at_end : {false, true}) {
      const std::string fault = link_fault(network, roads, junctions, road, at_end);
      if (fault.empty()) continue;
      found.push_back("road " + road.id + ": its " + (at_end ? "end" : "start") + " is linked to " +
                      described(link_of(road, at_end)) + ", " + fault);
    }
    if (!road.junction.empty() && !junctions.contains(road.junction)) {
      found.push_back("road " + road.id + ": lies in junction " + road.junction + ", which does not exist");
    }
  }
  for (const JunctionLinks& junction : network.junction_links) {
    const std::string name = "junction " + junction.id + ": ";
    for (const Connection& c : junction.connections) {
      for (const std::string& id : {c.incoming, c.connecting}) {
        if (!roads.contains(id)) found.push_back(name + "connects road " + id + ", which does not exist");
      }
      const auto connecting = roads.find(c.connecting);
      if (connecting == roads.end()) continue;
      if (junction.type != JunctionType::kDirect && network.roads[connecting->second].junction != junction.id) {
        found.push_back(name + "connects by way of road " + c.connecting + ", which does not lie in it");
      }
    }
  }
  return found;
}

std::vector<bool> roads_in_areas(const Network& network) {
  std::set<std::string_view> areas;
  for (const Junction& junction : network.junctions) areas.insert(junction.id);
  std::vector<bool> inside;
  for (const Road& road : network.roads) inside.push_back(!road.junction.empty() && areas.contains(road.junction));
  return inside;
}

void join_linked_ends(Network& network, const std::vector<bool>& skip) {
  const RoadsById roads = roads_by_id(network);
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    Road& road = network.roads[i];
    if (skip[i] || road.segments.empty()) continue;
    for (const bool at_end : {false, true}) {
      const RoadLink& link = link_of(road, at_end);
      const auto found = link.to == RoadLink::To::kRoad ? roads.find(link.id) : roads.end();
      if (found == roads.end()) continue;
      Road& other = network.roads[found->second];
      if (skip[found->second] || other.closed || other.segments.empty()) continue;
      const glm::dvec3 gap = end_m(road, at_end) - end_m(other, link.at_end);
      if (!(glm::length(glm::dvec2(gap)) <= kJoinedGap_m && std::abs(gap.z) <= kJoinedGap_m)) continue;
      (at_end ? road.joined_end : road.joined_start) = true;
      (link.at_end ? other.joined_end : other.joined_start) = true;
    }
  }
}

}  // namespace roadgen
