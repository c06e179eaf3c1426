// What else a file says along a road: objects and signals beside it, its types, and how fast one may drive.
//
// Source: ASAM OpenDRIVE 1.7, clauses 10.3 (road types), 11.7.4 (lane speed), 13 (objects) and 14 (signals); where 1.8 has
// more, 1.8. Angles in radians, lengths in metres; s is the road's own.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace roadgen {

// Whom an object or a signal is for: those that drive along s ("+"), against it ("-"), or all ("none").
enum class Orientation : std::uint8_t { kAll, kAlong, kAgainst };

// The lanes from one id to another, both included.
struct LaneValidity {
  int from = 0, to = 0;
  bool operator==(const LaneValidity&) const = default;
};

struct SpeedLimit {
  enum class Kind : std::uint8_t { kNone, kMax, kNoLimit, kUndefined };
  enum class Unit : std::uint8_t { kMetresPerSecond, kKilometresPerHour, kMilesPerHour };
  Kind kind = Kind::kNone;
  Unit unit = Unit::kMetresPerSecond;
  double value = 0;  // of kMax, in its unit; >= 0

  // In m/s; none unless kMax.
  std::optional<double> metres_per_second() const;
  bool operator==(const SpeedLimit&) const = default;
};

// From s on, up to the next.
struct RoadType {
  double s_m = 0;
  std::string type = {};     // the file's word: "town", "motorway", ...
  std::string country = {};  // ISO 3166-1, or empty
  SpeedLimit speed = {};
  bool operator==(const RoadType&) const = default;
};

// What holds for a lane in all of one section.
struct LaneRecord {
  std::uint32_t section = 0;  // in Road::sections
  int lane = 0;               // its id
  SpeedLimit speed = {};
  std::string access_xml = {}, rule_xml = {};  // <access> and <rule> as the file has them; well-formed
  bool operator==(const LaneRecord&) const = default;
};

// A corner of an outline: (s, t, height above the road), or (u, v, z) in the object's own axes, and how high the object
// stands over it.
struct OutlineCorner {
  double along_m = 0, across_m = 0, up_m = 0, height_m = 0;
  int id = -1;  // none below 0
  bool operator==(const OutlineCorner&) const = default;
};

struct Outline {
  bool on_road = false;       // corners are (s, t), else (u, v)
  std::optional<bool> outer;  // where the file says
  std::optional<bool> closed;
  std::string id = {}, fill = {}, lane_type = {};  // as the file has them
  std::vector<OutlineCorner> corners = {};
  bool operator==(const Outline&) const = default;
};

struct ObjectSize {
  double length_m = 0, width_m = 0, height_m = 0, radius_m = 0;  // >= 0; 0: not stated
  bool operator==(const ObjectSize&) const = default;
};

// Copies of an object every distance_m from s_m on; at distance 0 the object is drawn out along all of it. What has two
// values changes linearly between them.
struct ObjectRepeat {
  double s_m = 0, length_m = 0, distance_m = 0;  // length and distance >= 0
  double t_start_m = 0, t_end_m = 0, z_offset_start_m = 0, z_offset_end_m = 0;
  ObjectSize start = {}, end = {};
  bool straight = false;  // from end to end instead of along the reference line
  bool operator==(const ObjectRepeat&) const = default;
};

struct RoadObject {
  std::string id, name = {}, type = {}, subtype = {};
  double s_m = 0, t_m = 0, z_offset_m = 0;              // of its origin; z from the road's surface
  double heading_rad = 0, pitch_rad = 0, roll_rad = 0;  // against the road's, counter-clockwise
  Orientation orientation = Orientation::kAll;
  bool dynamic = false;        // moves
  bool perpendicular = false;  // stands square on the road's surface, so that pitch and roll are against that
  double valid_length_m = 0;   // along s; 0: a point
  ObjectSize size = {};        // of a box, or of a cylinder where there is a radius
  std::vector<ObjectRepeat> repeats = {};
  std::vector<Outline> outlines = {};
  std::vector<LaneValidity> validities = {};
  // Further elements as the file has them: <material>; parking spaces, markings, borders, ...; well-formed.
  std::string material_xml = {}, other_xml = {};
  bool operator==(const RoadObject&) const = default;
};

struct RoadSignal {
  std::string id, name = {}, type = {}, subtype = {}, country = {}, country_revision = {};
  double s_m = 0, t_m = 0, z_offset_m = 0;              // of its lower edge's middle
  double heading_rad = 0, pitch_rad = 0, roll_rad = 0;  // against the direction of its orientation
  Orientation orientation = Orientation::kAll;
  bool dynamic = false;  // changes: a traffic light
  std::optional<double> value = {};
  std::string unit = {}, text = {};
  double length_m = 0, width_m = 0, height_m = 0;  // >= 0; 0: not stated
  bool is_painted = false;                         // the stop line that it stands for is among the road's paint
  std::vector<LaneValidity> validities = {};
  std::string other_xml = {};  // dependencies, references, ...
  bool operator==(const RoadSignal&) const = default;
};

// Signals that are switched together.
struct Controller {
  struct Control {
    std::string signal, type = {};  // id of the signal
    bool operator==(const Control&) const = default;
  };
  std::string id, name = {};
  std::optional<int> sequence = {};
  std::vector<Control> controls = {};
  bool operator==(const Controller&) const = default;
};

struct RoadRecords {
  std::vector<RoadType> types = {};    // s increasing
  std::vector<LaneRecord> lanes = {};  // by section, and in it from left to right
  std::vector<RoadObject> objects = {};
  std::vector<RoadSignal> signals = {};
  // Elements of the road, of its <link>, <objects> and <signals> that have no place here, as the file has them: railroad,
  // links to places on roads, references, boards, ...; well-formed.
  std::string other_xml = {}, other_links_xml = {}, other_objects_xml = {}, other_signals_xml = {};
  bool operator==(const RoadRecords&) const = default;
};

// Whether numbers are finite and sizes not negative.
bool is_sound(const RoadObject& object);
bool is_sound(const RoadSignal& signal);
bool is_sound(const RoadRecords& records);

// One of the places of an object.
struct ObjectPlace {
  double s_m = 0, t_m = 0, z_offset_m = 0;
  ObjectSize size = {};
};

// How many places an object has: 1 without repeats, else those of its repeats. A repeat is a few numbers however many
// there are, and place_of finds each of them at once. Saturates at 2^53. Cost: O(repeats).
std::uint64_t place_count(const RoadObject& object);
// Requires: index < place_count(object). An object that is drawn out has its place at the repeat's start.
ObjectPlace place_of(const RoadObject& object, std::uint64_t index);

}  // namespace roadgen
