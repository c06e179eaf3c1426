// Roads and the network: the data that import fills, that is written as OpenDRIVE, and that every other part reads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/result.h"
#include "roadgen/road/segment.h"
#include "roadgen/road/sweep.h"

namespace roadgen {

// Where the network stands on the Earth: ENU about an origin on the WGS84 ellipsoid.
struct Georeference {
  double latitude_deg = 0;   // [-90, 90]
  double longitude_deg = 0;  // [-180, 180]
  double height_m = 0;       // of the plane z = 0, in the datum of the source's heights
};

// A road: segments one after the other, each starting at the anchor where the one before ends.
struct Road {
  std::string id;  // unique in the network
  std::string name;
  bool closed = false;            // the last segment ends at the first one's start
  std::vector<Segment> segments;  // s_start_m increasing from 0
  std::vector<Sweep> sweeps;      // tunnels, guard rails, pipes, cables along it

  double length_m() const { return segments.empty() ? 0 : segments.back().s_start_m + segments.back().arc_m; }
};

struct Network {
  std::string name;
  std::optional<Georeference> georeference;  // none for plain x, y input
  std::vector<Road> roads;

  const Road* find_road(const std::string& id) const;
  std::size_t segment_count() const;
};

// A point of a road: (s, t) plus height above the surface, and the pose there.
struct RoadPose {
  glm::dvec3 position_m{0, 0, 0};
  double heading_rad = 0;      // of the reference line, counter-clockwise from east
  double pitch_rad = 0;        // nose up, along the reference line
  double roll_rad = 0;         // right side down
  double curvature_per_m = 0;  // of the reference line, positive to the left
};

// Index of the segment that holds s_m; s is clamped to the road (wrapped where it is closed). Cost: O(log n).
// Requires: at least one segment.
std::size_t segment_at(const Road& road, double s_m);

// Road to world at arc length s_m and lateral offset t_m (left positive), on the surface.
RoadPose pose_at(const Road& road, double s_m, double t_m);

// Sets s_start_m of every segment from the arc lengths.
void chain_arc_lengths(Road& road);

// Horizontal bounds of all footprints. Empty network: low > high.
struct Bounds {
  glm::dvec3 low_m{1e300, 1e300, 1e300};
  glm::dvec3 high_m{-1e300, -1e300, -1e300};
  void add(glm::dvec3 p);
  bool empty() const { return low_m.x > high_m.x; }
};
Bounds bounds(const Segment& segment);
Bounds bounds(const Network& network);

// What happens at the joint from one segment to the next; all absolute values.
struct JointGap {
  double position_m = 0;  // distance of end and start anchor
  double heading_rad = 0;
  double curvature_per_m = 0;  // curvature may jump: the curve is G1
  double elevation_m = 0;
  double grade = 0;  // dz/ds
  double half_width_m = 0;
};
JointGap joint_gap(const Segment& before, const Segment& after);

// The findings of `roadgen check`.
struct CheckReport {
  std::size_t joints = 0;
  JointGap worst;
  double max_mapping_bound_m = 0;  // proven bound of |v - exact| in metres, over all segments
  double max_arc_error_m = 0;
  std::vector<std::string> problems;  // "road R, s = 123.4 m: what"
  bool ok() const { return problems.empty(); }
};

// Limits: position 1e-9 m and heading 1e-9 rad at joints relative to coordinates' size, mapping bound kMappingTolerance
// of the half width, elevation gap 1e-6 m, widths positive, numbers finite.
CheckReport check(const Network& network);

}  // namespace roadgen
