// A stretch: the parametric cubic between two anchors, and its division into segments that the road function maps
// within the certified tolerance. Internal to roadgen/fit.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/road/segment.h"

namespace roadgen {

// The cubic Hermite curve with the given ends and end tangents (metres per unit of t), t in [0, 1].
struct Stretch {
  glm::dvec2 start_m, end_m;
  glm::dvec2 tangent_start_m, tangent_end_m;

  glm::dvec2 position_m(double t) const;  // exactly start_m and end_m at t = 0 and 1
  glm::dvec2 derivative_m(double t) const;
  double curvature_per_m(double t) const;  // positive to the left; infinite at a cusp
};

// Tangents of at most this angle off the chord have length L / cos(angle), so the stretch is the graph cubic of
// shaders/lib/road.glsl exactly; beyond it their length stays 2 L.
inline constexpr double kGraphAngle_rad = 1.0471975511965976;

// The stretch between two anchors with the given headings. Requires: distinct finite points, finite headings.
Stretch make_stretch(glm::dvec2 start_m, glm::dvec2 end_m, double heading_start_rad, double heading_end_rad);

// A part t0 <= t <= t1 of a stretch as one segment, which has the stretch's points and tangent directions at its ends.
struct Piece {
  Segment segment;          // geometry and arc; profiles are set by the caller
  std::size_t stretch = 0;  // the caller's index of the stretch
  double t0 = 0, t1 = 1;
  // Where the curve is tighter than the half width asked for: the greatest half width that is still admissible, or 0
  // where even kLeastHalfWidth_m is not.
  double cap_m = std::numeric_limits<double>::infinity();

  bool tight() const { return cap_m < std::numeric_limits<double>::infinity(); }
};

// Least radius of curvature of the piece's own curve, in metres; infinite where it is straight.
double least_radius_m(const Segment& segment);

// For a segment without a mapping bound at the half width: the greatest half width that is admissible (0 where even
// kLeastHalfWidth_m is not), or none where the segment is not nearly straight, so that halving it may help.
std::optional<double> tight_cap_m(Segment segment, double half_width_m, double mapping_tolerance);

// Where a stretch has no direction: it stops or reverses on the spot.
struct Cusp {
  double t;
};

struct Division {
  std::vector<Piece> pieces;  // in order of t; up to the cusp where there is one
  std::vector<Cusp> cusps;    // empty or one
};

// Halves the part [t0, t1] of the stretch until each piece is admissible for the half width, or is nearly straight and
// yet tighter than the half width allows (Piece::tight). Cost: O(pieces); at most kMostHalvings deep.
Division divide(const Stretch& stretch, double t0, double t1, double half_width_m, double mapping_tolerance);
inline constexpr int kMostHalvings = 24;

// Halves the stretch until each piece's tangents are at most most_slope off its chord, whatever the width. At most
// kMostHalvings deep.
Division divide_into_graphs(const Stretch& stretch, double most_slope);

}  // namespace roadgen
