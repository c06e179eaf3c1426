// Roads along the lines of OSM ways. Internal to roadgen/import.
#pragma once

#include <string>
#include <vector>

#include "roadgen/fit/fit.h"
#include "roadgen/import/osm_course.h"
#include "roadgen/import/osm_heights.h"
#include "roadgen/road/network.h"

namespace roadgen {

// What is to become roads: a line without what is cut off its ends.
struct LinePlan {
  double cut_start_m = 0, cut_end_m = 0;
  bool joined_start = false, joined_end = false;    // in the area of a junction
  bool touches_start = false, touches_end = false;  // other roads, without an area
  const HeightProfile* heights = nullptr;           // over the line's length; none: level at 0
  std::vector<std::string> ids;                     // of the roads, should they begin with this piece
};

struct LineRoads {
  std::vector<Road> roads;  // along the line; one for each stretch of equal tags
  std::vector<Certificate> certificates;
};

// A corner of a way whose nodes are far apart is rounded so that its node lies at most this far from the road, if the
// road's inner edge then has a radius of kLeastInnerRadius_m; otherwise by that radius, or what fits between the nodes.
inline constexpr double kNodeError_m = 0.5, kLeastInnerRadius_m = 2;

// Through the nodes where they follow a bend; straight between nodes that are far apart, with rounded corners. Points
// that lie within 0.15 m of the way without them are left out. Where tags change the one road goes on as the next, and
// lanes that only one of them has taper away.
// Where one goes on as the next they are linked, lane by lane.
// Findings: bends that no road of this width can follow: nodes are left out, then its lanes are made narrower.
// Errors: as road_from_anchors where this does not help.
Result<LineRoads> make_line_roads(const OsmScene& scene, const Course& course, const OsmLine& line,
                                  const LinePlan& plan, ElementFindings& findings);

// Links an end of a road to an end of another, and the lanes that go on as one another.
void link_roads(Road& a, bool a_at_end, Road& b, bool b_at_end);

}  // namespace roadgen
