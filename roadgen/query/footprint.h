// One segment as a query sees it: the exact place of a point against it. A part of RoadIndex (road_index.h).
//
// The pixel shader stops after two Newton steps, within the segment's certified bounds (mapping_bound). A query goes on
// from the same start to the exact foot of the perpendicular, so that world to road and road to world are inverse to one
// another; what it answers and what the picture shows differ by at most those bounds.
#pragma once

#include <cstdint>

#include <glm/vec2.hpp>

#include "roadgen/query/box_tree.h"
#include "roadgen/road/network.h"

namespace roadgen {

// Which segment: network.roads[road].segments[segment].
struct SegmentRef {
  static constexpr std::uint32_t kNoRoad = 0xffffffffu;
  std::uint32_t road = kNoRoad;
  std::uint32_t segment = 0;
  bool operator==(const SegmentRef&) const = default;
};

// Where a point stands against a road.
struct RoadPoint {
  SegmentRef at;
  double u = 0;           // of the segment, [0, 1]
  double s_m = 0;         // arc length along the road
  double t_m = 0;         // across, in the tilted cross section, positive to the left
  double distance_m = 0;  // from the reference line, horizontally
  double outside_m = 0;   // from the carriageway or the junction's area, horizontally; 0 on it
  // Of the point above what is driven on there: the carriageway, raised lanes included, or the junction's area; beside the
  // carriageway above its edge. 0 where the query gave no height.
  double height_m = 0;
  int lane = 0;  // id of the lane there, left positive; 0 outside all lanes
  // The point lies in the area of network.junctions[junction], which is the ground there; else -1. The road is then one
  // of those that lead through, the one that holds the point, else the nearest; none where none does.
  std::int32_t junction = -1;

  bool has_road() const { return at.road != SegmentRef::kNoRoad; }
};

// A point this near to a carriageway, horizontally, is on it: room for the rounding of coordinates below 10^7 m.
inline constexpr double kTouch_m = 1e-8;

// What a query reads of a segment, together in memory; the segment itself is read where something is out of the
// ordinary. Requires: road and segment stay where they are, and every function gets the same road.
class alignas(64) Footprint {
 public:
  // area: index of the junction whose area the road leads through, or -1.
  Footprint(const Road& road, const Segment& segment, SegmentRef at, std::int32_t area);

  // How the point stands against the segment, however far away: of all places of the segment whose cross section
  // goes through the point the one on the carriageway with the smallest |t|, else the one nearest to the carriageway.
  // Without height and lane. Accuracy: 1e-12 of the chord and the rounding of coordinates. Cost: O(1).
  RoadPoint locate(const Road& road, glm::dvec2 point_m) const;

  // pose_in of this segment, to 1e-12 of its chord; local_s_m from its start, clamped to it.
  RoadPose pose(const Road& road, double local_s_m, double t_m) const;

  // The height of the road at a place found by locate, at the carriageway's edge where it is beside.
  double ground_m(const Road& road, const RoadPoint& place) const;

  // False where the point is off the carriageway for certain, or farther than most_m from the reference line.
  bool may_hold(glm::dvec2 point_m, double most_m) const;
  // Negative: before the start's cross section; positive: beyond the end's; else 0. By more than kTouch_m.
  int beyond(glm::dvec2 point_m) const;

  // Of the carriageway and the surface on it.
  Box bounds(const Road& road) const;

  SegmentRef at() const { return at_; }
  std::int32_t area() const { return area_; }
  const LaneSection& section() const { return *section_; }
  double s_start_m() const { return s_start_m_; }
  // What pose reads on level ground. s_start_m is on the second of the two.
  static constexpr std::size_t kPoseBytes = 128;

 private:
  enum Flags : std::uint32_t {
    kConstantEdges = 1,  // left_m_ and right_m_ are the edges
    kLevelAcross = 2,    // no superelevation
    kFlatAcross = 4,     // nor crossfall, nor raised lanes: elevation_m_ is the height
    kLevelAlong = 8,     // elevation_m_ is constant
    kFolded = 16         // cross sections may meet on the carriageway: a bend tighter than the road is wide
  };
  struct Local {
    double x, y;
  };
  Local local(glm::dvec2 point_m) const {
    const double dx = point_m.x - start_m_.x, dy = point_m.y - start_m_.y;
    return {axis_.x * dx + axis_.y * dy, axis_.x * dy - axis_.y * dx};
  }
  const Segment& segment(const Road& road) const { return road.segments[at_.segment]; }
  RoadPoint place_at(const Road& road, Local p, double u) const;
  // Arc length in metres at u, and its slope.
  double arc(double u) const { return u * (arc_[0] + u * (arc_[1] + u * (arc_[2] + u * (arc_[3] + u * arc_[4])))); }
  double arc_slope(double u) const {
    return arc_[0] + u * (2 * arc_[1] + u * (3 * arc_[2] + u * (4 * arc_[3] + u * 5 * arc_[4])));
  }
  // The inverse of arc, for s in [0, end], end = arc(1); the last step was below 1e-7, the next would be its square.
  double u_at(double s, double end) const;
  double u_at_bend(double s, double start) const;

  // For may_hold.
  glm::dvec2 start_m_;
  glm::dvec2 axis_;       // chord / L^2
  double a_, b_;          // slopes
  float y_low_, y_high_;  // of the carriageway in the chord frame, rounded outward
  std::int32_t area_;
  std::uint32_t flags_ = 0;
  // For the pose.
  double s_start_m_;
  double arc_[5];       // L road_arc in powers of u, from the first
  double heading_rad_;  // of the chord
  Cubic elevation_m_;   // its higher coefficients on the third cache line
  // For the place.
  double length_m_;  // L
  double left_m_, right_m_;
  SegmentRef at_;
  const LaneSection* section_;
};
static_assert(sizeof(Footprint) == 192);  // three cache lines: may_hold reads the first, pose on level ground two

}  // namespace roadgen
