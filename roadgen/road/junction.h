// Junctions: the carriageway where roads meet, bounded by the cut lines across its arms and by corner curves from the
// edge of each arm to that of the next.
//
//   Result<Junction> junction = make_junction("7", arms, {.corner_radius_m = 8}, &diagnostics);
//   const JunctionSurface surface = junction_surface(*junction);
//   double inside_m = signed_distance_m(surface, p);
//   JunctionPoint ground = height_at(surface, p);
//
// The surface meets every arm in height and slope, and every corner curve in height. Its functions are those of the
// pixel shader (shaders/lib/junction.glsl).
#pragma once

#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/result.h"
#include "roadgen/road/segment.h"

namespace roadgen {

// The end of a road at a junction. Left and right are those of one who looks into the junction.
struct JunctionArm {
  std::string road;     // id
  bool at_end = false;  // the road's end touches the junction, otherwise its start
  // Of the reference line at the cut, or of any other line of the road between its carriageway's edges; ENU.
  glm::dvec2 position_m{0, 0};
  double heading_rad = 0;      // into the junction, counter-clockwise from east
  double left_m = 3.5;         // lateral offset of the carriageway's left edge, >= 0
  double right_m = -3.5;       // and of its right edge, <= 0, less than left_m
  double elevation_m = 0;      // of the reference line at the cut
  double grade = 0;            // dz per metre into the junction
  double tilt = 0;             // dz per metre to the left: tangent of the superelevation
  double crossfall_left = 0;   // slope falling outward from the reference line, on its left
  double crossfall_right = 0;  // and on its right
};

// The point of an arm's cut at lateral offset n_m, and the height of the arm's surface there.
glm::dvec2 cut_point_m(const JunctionArm& arm, double n_m);
double cut_height_m(const JunctionArm& arm, double n_m);

struct Junction {
  std::string id;                             // unique in the network
  std::vector<JunctionArm> arms;              // counter-clockwise
  std::vector<std::vector<Segment>> corners;  // [i]: from the right edge of arm i to the left edge of the next arm,
                                              // area on its left; s_start_m from 0, elevation_m set
  double corner_radius_m = 0;                 // that make_junction was asked for: arms and it give the corners again
  double underlap_m = 0;  // how far the area is drawn beyond its corners, under strips that lie along them
};

struct JunctionOptions {
  // Radius of the corners where an edge turns right into the next arm by more than 30 degrees; where it turns left, on
  // the outside of a bend, the width of the wider arm is added. Edges that go nearly straight on have one curve from
  // cut to cut. In [kLeastCornerRadius_m, inf). Default: 6 m, a kerb radius of urban crossings.
  double corner_radius_m = 6;
};

// A corner is never bent more tightly than this.
inline constexpr double kLeastCornerRadius_m = 0.25;

// Sorts the arms and lays the corner curves: a straight, at most two circular arcs, a straight; arcs are cut into cubics
// that turn by at most 31 degrees each (within 8e-4 of the radius of the circle). The curves are G1 at every joint and
// leave the arms along their edges. Heights are cubics in s that start and end with the arms' heights and grades.
// Diagnostics (where wanted): a right-hand corner whose radius does not fit between the cuts gets the greatest that does.
// Errors: kGeometry, naming the junction and the roads: fewer than two arms, numbers that are not finite, edges on the
// wrong side, arms whose cuts cross or which point away from all others, a corner tighter than kLeastCornerRadius_m,
// curves that cross.
// Cost: O(n^2) in the number of pieces.
Result<Junction> make_junction(std::string id, std::vector<JunctionArm> arms, const JunctionOptions& options = {},
                               Diagnostics* diagnostics = nullptr);

// What is wrong with a junction, one line each: "junction J: what"; empty where nothing is. Limits: position 1e-9 m and
// heading 1e-9 rad at joints and arms, relative to the coordinates' size; height 1e-6 m, grade 1e-6; a boundary that
// crosses itself (tested on a polygon within 6e-4 of the corners' radii) or runs clockwise.
std::vector<std::string> problems(const Junction& junction);

// The area and the surface as the shader sees them: pieces in metres from a centre.
struct JunctionSurface {
  glm::dvec3 center_m{0, 0, 0};
  std::vector<Lib::JunctionCut> cuts;
  std::vector<Lib::JunctionCorner> corners;
  // From the centre: bounds of the area and of the surface over it, the latter found by sampling and padded by the
  // steepest slope times half the samples' distance.
  glm::dvec3 low_m{0, 0, 0}, high_m{0, 0, 0};
  // A plane near the surface, z = plane.z + plane.x x + plane.y y from the centre; and how much the surface's gradient
  // departs from the plane's, at most, over the samples; and their heights, padded like the bounds.
  glm::dvec3 plane{0, 0, 0};
  double slope_spread = 0;
  double plane_gap_m = 0;
};

// Requires: problems(junction) is empty. Cost: 1,600 evaluations of the height.
JunctionSurface junction_surface(const Junction& junction);
// The same without what sampling finds: z of the bounds, plane, slope_spread and plane_gap_m stay 0. Cost: O(pieces).
JunctionSurface junction_pieces(const Junction& junction);

// Signed distance of a point (ENU) to the boundary of the area, positive inside. The sign is exact up to rounding,
// also where the area is not convex; the distance is exact to first order at the boundary. Distances beyond most_m come
// as most_m: pieces farther away cost little.
double signed_distance_m(const JunctionSurface& surface, glm::dvec2 point_m, double most_m = 1e6);

// Whether the area holds a point (ENU): the sign of signed_distance_m, at a fraction of its cost.
bool is_inside(const JunctionSurface& surface, glm::dvec2 point_m);

struct JunctionPoint {
  double height_m;      // ENU z of the surface
  glm::dvec2 gradient;  // dz/dx, dz/dy
};

// The surface at a point (ENU); it is defined in the whole plane, and meant for the area. At the cuts it differs from
// the arm's surface by at most 1e-6 m^2 / d^2 of the heights about, d being the distance to other pieces.
JunctionPoint height_at(const JunctionSurface& surface, glm::dvec2 point_m);
// Its height alone, at half the cost.
double height_m_at(const JunctionSurface& surface, glm::dvec2 point_m);

}  // namespace roadgen
