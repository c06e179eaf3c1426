// <lateralProfile> of an OpenDRIVE road: superelevation, crossfall (1.4) and shape (1.5 and later). Internal to
// roadgen/import.
//
// The house surface falls from the reference line to both sides by slopes that are linear over a segment. Crossfall and
// shape are brought to that form: at both ends of a segment the slopes are those of the least-squares lines through the
// reference line's height, so that the surface stays continuous at joints; a shape's height at the reference line is
// added to the elevation.
// Source: ASAM OpenDRIVE 1.7, clause 10.5; OpenDRIVE 1.4H, clause 5.3.6.2 (crossfall).
#pragma once

#include <array>
#include <vector>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/segment.h"

namespace roadgen {

// The height across the road at one s, linear in s to the next.
struct XodrShape {
  double s_m = 0;
  std::vector<From<Cubic>> across;  // s_m: the t where each begins
};

struct XodrLateral {
  Profile superelevation, crossfall_left, crossfall_right;  // rad
  std::vector<XodrShape> shapes;
  // userData roadgen:crossfall: left c0, c1, right c0, c1 of Segment.
  std::vector<From<std::array<double, 4>>> exact;

  // Where a segment must begin, in no order.
  std::vector<double> changes_m() const;
  // Of the first shape or crossfall; 0 where there is none.
  int first_line() const;
};

// Errors (in source): kParse for missing or malformed attributes and records out of order.
XodrLateral read_lateral(XodrSource& source, const pugi::xml_node& road);

// Sets superelevation and crossfall of a segment that stands for [from_m, to_m] of the file, length_m by its geometry,
// and adds a shape's height to its elevation. Requires: arc, elevation and edges set. Returns the greatest difference of
// the surface's height from the file's, sampled over the segment. Errors (in source): kData where one is beyond 1e6.
double set_lateral(XodrSource& source, const XodrLateral& lateral, const Stations& stations, double from_m, double to_m,
                   double length_m, Segment& segment);

// The profile over s of a segment of length arc_m where the file's s runs over length_m.
inline Cubic scaled(const Cubic& c, double length_m, double arc_m) {
  if (length_m == arc_m) return c;
  const double k = length_m / arc_m;
  return {c.c0, c.c1 * k, c.c2 * (k * k), c.c3 * (k * k * k)};
}

}  // namespace roadgen
