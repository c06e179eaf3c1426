// How roads are connected: what lies beyond their ends, and which roads lead through a junction.
//
// Source: ASAM OpenDRIVE 1.7, clauses 8.2 (linkage of roads), 9.5 and 11.4 (of lanes), 12 (junctions).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/road/rare.h"
#include "roadgen/road/records.h"

namespace roadgen {

struct Network;

// Lanes that go on into one another, by their ids.
struct LaneLink {
  int from = 0, to = 0;
  bool operator==(const LaneLink&) const = default;
};

// What lies beyond an end of a road.
struct RoadLink {
  enum class To { kNothing, kRoad, kJunction };
  To to = To::kNothing;
  std::string id;                    // of that road or junction
  bool at_end = false;               // of a road: its end is met, otherwise its start
  std::vector<LaneLink> lanes = {};  // to a road: from lanes of this one
  bool operator==(const RoadLink&) const = default;
};

// A way through a junction: from the incoming road into a road that lies in the junction, or, where that is direct, into
// a road beyond it.
struct Connection {
  std::string incoming, connecting;  // ids of roads
  bool at_end = false;               // the connecting road's end is met, otherwise its start
  std::vector<LaneLink> lanes = {};  // from lanes of the incoming road
  bool operator==(const Connection&) const = default;
};

// Of OpenDRIVE 1.8: where roads meet; a place on a road where others branch off; where roads go on into one another
// without roads between; where others only cross.
enum class JunctionType : std::uint8_t { kDefault, kVirtual, kDirect, kCrossing };
// The file's word for a type; and back, none for unknown words ("common" is default).
std::string_view junction_type_name(JunctionType type);
std::optional<JunctionType> junction_type(std::string_view name);

// What few junctions have.
struct JunctionRecords {
  // Of a virtual junction, the part of a road along which it lies; no id elsewhere.
  std::string main_road = {};
  double s_start_m = 0, s_end_m = 0;
  Orientation orientation = Orientation::kAll;
  std::string other_xml = {};  // further elements as the file has them: priorities, controllers, ...; well-formed
  bool operator==(const JunctionRecords&) const = default;
};

// A junction as a node of the road graph; its area, where it has one, is the Junction of the same id.
struct JunctionLinks {
  std::string id;  // unique among these
  std::string name;
  std::vector<Connection> connections = {};
  JunctionType type = JunctionType::kDefault;
  Rare<JunctionRecords> records = {};
  bool operator==(const JunctionLinks&) const = default;
};

// Links to roads and junctions that the network lacks, links that the other side does not return, and connections of
// roads that do not lie in the junction: "road R: its end is linked to the start of road Q, which is linked to
// nothing". Cost: O(n log n).
std::vector<std::string> link_problems(const Network& network);

// For every road of the network whether it lies in a junction that has an area: the area is what is drawn and driven
// on, the road is for routes and poses only. Cost: O(n log n).
std::vector<bool> roads_in_areas(const Network& network);

// Marks ends that are linked to roads' ends as joined, on both sides, where they lie within kJoinedGap_m of one another
// in the plane and in height.
void join_linked_ends(Network& network, const std::vector<bool>& skip);
inline constexpr double kJoinedGap_m = 0.01;

}  // namespace roadgen
