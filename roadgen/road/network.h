// Roads and the network: the data that import fills, that is written as OpenDRIVE, and that every other part reads.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/junction.h"
#include "roadgen/road/lane.h"
#include "roadgen/road/link.h"
#include "roadgen/road/paint.h"
#include "roadgen/road/rare.h"
#include "roadgen/road/records.h"
#include "roadgen/road/result.h"
#include "roadgen/road/segment.h"
#include "roadgen/road/sweep.h"

namespace roadgen {

struct SweepPart;

// Where the network stands on the Earth: ENU about an origin on the WGS84 ellipsoid, or in a map's projection.
// roadgen/geodesy/local_frame.h goes between the network's coordinates and latitude and longitude.
struct Georeference {
  // The origin; with a projection the place of x = y = 0, or 0, 0 where it has none there.
  double latitude_deg = 0;   // [-90, 90]
  double longitude_deg = 0;  // [-180, 180]
  double height_m = 0;       // of the plane z = 0, in the datum of the source's heights
  // A projected system in metres, as PROJ string, WKT or "EPSG:CODE"; empty: ENU about the origin.
  std::string projection = {};
  // In it the network is turned about its own x = y = 0, counter-clockwise, and then moved.
  glm::dvec2 offset_m{0, 0};
  double offset_heading_rad = 0;
};

// A part of a road that stands over the ground instead of lying on it.
struct Bridge {
  double s_start_m = 0;  // along the road, 0 <= s_start < s_end <= its length
  double s_end_m = 0;
  std::string id = {}, name = {};  // as the source has them
  std::string type = {};           // of OpenDRIVE: "concrete", "steel", ...
  bool operator==(const Bridge&) const = default;
};

// A road: segments one after the other, each starting at the anchor where the one before ends.
struct Road {
  std::string id;  // unique in the network
  std::string name;
  std::string road_class = {};    // as the source calls it: highway=* of OSM; empty where it does not say
  bool keep_left = false;         // traffic keeps left: lanes of positive id lead along the road, "LHT" of OpenDRIVE
  bool closed = false;            // the last segment ends at the first one's start
  bool joined_start = false;      // what lies before the start, a junction or a road, joins it without an edge
  bool joined_end = false;        // and beyond the end
  RoadLink predecessor = {};      // what lies before the start; nothing where the road is closed
  RoadLink successor = {};        // and beyond the end
  std::string junction = {};      // id of the junction that the road leads through, or empty
  std::vector<Segment> segments;  // s_start_m increasing from 0
  // The cross sections, s_m increasing from 0, each from the start of a segment on. Never empty where there are
  // segments: set_sections or two_lane_sections.
  std::vector<LaneSection> sections;
  std::vector<Paint> paint;
  std::vector<Sweep> sweeps;         // tunnels, guard rails, pipes, cables along it
  std::vector<Bridge> bridges = {};  // the terrain is not raised to these
  Rare<RoadRecords> records = {};    // objects, signals, types and speeds; not drawn

  double length_m() const { return segments.empty() ? 0 : segments.back().s_start_m + segments.back().arc_m; }
};

// Whether a bridge has a length and lies within its road.
inline bool is_on(const Bridge& bridge, const Road& road) {
  return bridge.s_start_m >= 0 && bridge.s_start_m < bridge.s_end_m && bridge.s_end_m <= road.length_m();
}

struct Network {
  std::string name;
  std::optional<Georeference> georeference;  // none for plain x, y input
  std::vector<Road> roads;
  std::vector<Junction> junctions;                 // areas
  std::vector<JunctionLinks> junction_links = {};  // the graph's nodes, with or without an area
  std::vector<Controller> controllers = {};        // of signals
  std::string other_xml = {};                      // further elements as the file has them: stations, ...; well-formed

  const Road* find_road(const std::string& id) const;
  std::size_t segment_count() const;
};

// Index in Network::roads of every id; of one used twice the first. For as long as no road comes or goes. Cost: O(n).
using RoadsById = std::unordered_map<std::string_view, std::size_t>;
RoadsById roads_by_id(const Network& network);

// A point of a surface beside a road, and how the road and the surface run there.
struct RoadPose {
  glm::dvec3 position_m{0, 0, 0};
  double heading_rad = 0;      // of the reference line, counter-clockwise from east, in (-pi, pi]
  double pitch_rad = 0;        // nose up: the surface's slope along the road
  double roll_rad = 0;         // right side down: the surface's slope across
  double curvature_per_m = 0;  // of the reference line, positive to the left
  double grade = 0;            // tangent of the pitch: rise per metre travelled at this t
  glm::dvec3 normal{0, 0, 1};  // of the surface, unit, upward
};

// Rise per metre travelled at n_m to the left of a reference line whose height rises by `slope` per metre of its own.
// Within 5 % of the radius around the centre of curvature, where it means nothing, as at that distance.
inline double grade_at(double slope, double n_m, double curvature_per_m) {
  return slope / std::max(1 - n_m * curvature_per_m, 0.05);
}

// Sets what the surface's gradient (dz/dx, dz/dy) decides: pitch, roll, grade and normal. tangent: unit, of the heading.
void lean(RoadPose& pose, glm::dvec2 tangent, glm::dvec2 gradient);

// Index of the segment that holds s_m; s is clamped to the road (wrapped where it is closed). Cost: O(log n).
// Requires: at least one segment.
std::size_t segment_at(const Road& road, double s_m);

// The height of what is driven and walked on at arc length local_s_m from the segment's start and offset t_m: the
// surface and what the lanes there are raised by.
double surface_height_m(const Road& road, const Segment& segment, double local_s_m, double t_m);

// Road to world at arc length s_m and lateral offset t_m (left positive), on the road's own surface; raised lanes
// included. s_m is clamped to the road (wrapped where it is closed); beyond the edges the surface goes on as it slopes.
// Accuracy: 1e-12 of the segment's length against arc_at. Cost: O(log n). Requires: finite s_m and t_m, a segment.
RoadPose pose_at(const Road& road, double s_m, double t_m);
// The same within a segment of the road: local_s_m from its start, clamped to it. Cost: O(1).
RoadPose pose_in(const Road& road, const Segment& segment, double local_s_m, double t_m);

// Takes the sections into the road: sorts out which segment has which, and sets left_m and right_m of every segment to
// the section's outer borders. Errors: kData where there is none, the first does not start at 0, or one starts
// elsewhere than at a joint (within 1e-6 m).
Status set_sections(Road& road, std::vector<LaneSection> sections);

// So many lanes over the edges that the segments have, with hard shoulders of kEdgeStrip_m beyond solid edge lines: half
// of an even number to each side of the reference line, of equal widths there; of an odd number one more to the right, all
// of one width, lane 0 where they part. The line between the directions is broken, two solid ones from four lanes on.
// Segments of one constant width share a section. Requires: lanes in [1, kMostLanes].
void divide_into_lanes(Road& road, int lanes);
inline constexpr int kMostLanes = 20;
inline void two_lane_sections(Road& road) { divide_into_lanes(road, 2); }
inline constexpr double kEdgeStrip_m = 0.26;

// The segment's cross section; one without lanes where the road has none.
const LaneSection& section_of(const Road& road, const Segment& segment);
// Arc length from the start of the segment's lane section to the start of the segment.
double section_offset_m(const Road& road, const Segment& segment);

// Sets s_start_m of every segment from the arc lengths.
void chain_arc_lengths(Road& road);

// Bounds of all footprints, junction areas and sweeps. Empty network: low > high.
struct Bounds {
  glm::dvec3 low_m{1e300, 1e300, 1e300};
  glm::dvec3 high_m{-1e300, -1e300, -1e300};
  void add(glm::dvec3 p);
  bool empty() const { return low_m.x > high_m.x; }
};
Bounds bounds(const Segment& segment);
Bounds bounds(const Junction& junction);                 // of its outline
Bounds bounds(const Road& road, const SweepPart& part);  // of its box
Bounds bounds(const Network& network);

// What happens at the joint from one segment to the next; all absolute values.
struct JointGap {
  double position_m = 0;  // distance of end and start anchor
  double heading_rad = 0;
  double curvature_per_m = 0;  // curvature may jump: the curve is G1
  double elevation_m = 0;
  double grade = 0;  // dz/ds
  double superelevation_rad = 0;
  double edge_m = 0;  // of the left or the right edge; may jump where lanes begin or end
};
JointGap joint_gap(const Segment& before, const Segment& after);

// The findings of `roadgen check`.
struct CheckReport {
  std::size_t joints = 0;
  JointGap worst;
  double max_mapping_bound_m = 0;     // proven bound of |v - exact| in metres, over all segments
  double max_s_bound_m = 0;           // likewise of |s - exact|
  double max_arc_error_m = 0;         // the part of it that the arc length polynomial has
  std::vector<std::string> problems;  // "road R, s = 123.4 m: what"
  std::vector<std::string> warnings;  // likewise; see OddValues
  bool ok() const { return problems.empty(); }
};

// True where every number of the road is.
bool is_finite(const Road& road);

// What no real road has, as "road R, s = 123.4 m: what", those of a kind counted; all of it is drawn nevertheless.
struct OddValues {
  // Lanes of negative width, no lane of any width, bends tighter than the road is wide to their inner edge, paint outside
  // the road or without size, numbers that are not finite, lane sections that do not start at joints.
  std::vector<std::string> problems;
  // Superelevation beyond 45 degrees, grades and crossfalls beyond 100 %: measured profiles may have them.
  std::vector<std::string> warnings;
};
// Cost: O(segments log segments).
OddValues odd_values(const Road& road);

// The above for every road, the problems() of junctions and sweeps, the link_problems(), and what roadgen promises of
// every road. Limits: position 1e-9 m and heading 1e-9 rad at joints relative to coordinates' size, mapping bounds
// kMappingTolerance of the half width, elevation gap 1e-6 m, widths positive, numbers finite.
CheckReport check(const Network& network);

}  // namespace roadgen
