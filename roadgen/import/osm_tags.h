// What OSM's tags say of a carriageway, and the cross section that it gets. Internal to roadgen/import.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/road/lane.h"

namespace roadgen {

// The values of highway=* that are driven on.
enum class Highway : std::uint8_t {
  kMotorway,
  kMotorwayLink,
  kTrunk,
  kTrunkLink,
  kPrimary,
  kPrimaryLink,
  kSecondary,
  kSecondaryLink,
  kTertiary,
  kTertiaryLink,
  kUnclassified,
  kResidential,
  kLivingStreet,
  kService,
  kTrack,
  kRoad,
  kBusway,
  kRaceway
};

// What holds for a class where no tag says otherwise.
struct HighwayClass {
  const char* name;        // of highway=*
  int lanes_oneway;        // of a carriageway of one direction
  int lanes_each_way;      // of one of both directions; 0: one lane that both share
  double lane_m;           // width of a lane
  double shoulder_m;       // paved, beyond the outer edge line; that of the inner edge is at most kInnerShoulder_m
  bool center_line;        // where there is one lane each way
  bool edge_lines;         //
  bool oneway;             // without a tag
  double corner_radius_m;  // where it meets a road of its class or a higher one
  double ramp_grade;       // of ramps to bridges and tunnels, on the mean
};
inline constexpr double kInnerShoulder_m = 0.75;
const HighwayClass& highway_class(Highway highway);

struct Sides {
  bool left = false, right = false;
  bool operator==(const Sides&) const = default;
};

// A way's tags, read along its nodes. A way of one direction runs along it: where oneway=-1 the reader turns the way
// around.
struct WayTags {
  Highway highway = Highway::kRoad;
  Material material = Material::kAsphalt;
  std::uint8_t forward = 1, backward = 1;  // lanes; both 0: one that both directions share
  std::int8_t layer = 0;                   // in [-5, 5]; bridges count as 1 and tunnels as -1 where no tag says
  bool bridge = false, tunnel = false, roundabout = false;
  Sides sidewalk, parking;
  float lane_m = 3;
  std::uint32_t name = 0;  // index of the reader's names
  bool operator==(const WayTags&) const = default;

  bool oneway() const { return forward > 0 && backward == 0; }
};

// The value of a tag, or nullptr.
using TagLookup = std::function<const char*(const char* key)>;

struct ParsedTags {
  bool drivable = false;
  bool reversed = false;  // oneway=-1: turn the way around
  WayTags tags;
  std::vector<std::string> faults;  // values that make no sense; the default took their place
};
// Fills all of tags but the name.
ParsedTags parse_tags(const TagLookup& lookup);

// The cross section of a way; along: the road runs as the way does. Lanes run to the right of lane 0 where they go
// along the road, or to the left where traffic keeps left. The reference line is the middle of all driving lanes.
LaneSection section_of_way(const WayTags& tags, bool along, bool keep_left);

// Offsets of the carriageway's edges, without kerbs and sidewalks, and of the whole section's.
struct SectionEdges {
  double left_m = 0, right_m = 0;  // >= 0, <= 0
  double half_m = 0;               // greatest of the whole section's
};
SectionEdges edges_of_way(const WayTags& tags, bool along, bool keep_left);

}  // namespace roadgen
