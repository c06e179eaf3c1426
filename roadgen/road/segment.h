// One road segment: a cubic over the chord between two anchors, with its elevation and width, and the mapping between
// the world and (s, t). Everything here is the double-precision twin of what the pixel shader evaluates
// (shaders/lib/road.glsl).
//
// Frames. World: ENU metres (x east, y north, z up). Chord frame: origin at the start anchor, x along the chord to
// (1, 0) at the end anchor, y to the left, divided by the chord length L.
#pragma once

#include <cstdint>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/cubic.h"
#include "shaders/lib/glsl.h"

namespace roadgen {

// What the mapping can be wrong by, over a whole footprint; proven, not sampled. See mapping_bound.
struct MappingBound {
  double v = 0;      // of |v - exact| / L
  double u = 0;      // of |u - exact|
  double along = 0;  // of the arc length between the two points of the centre line at these u, / L
};

struct Segment {
  glm::dvec2 start_m{0, 0};  // anchors, ENU
  glm::dvec2 end_m{1, 0};
  double slope_start = 0;         // a: tangent slope against the chord at the start
  double slope_end = 0;           // b: and at the end
  double s_start_m = 0;           // arc length of the road at the start anchor
  double arc_m = 1;               // arc length of this segment; its error is part of arc_error_m
  double arc_c0 = 0, arc_c1 = 0;  // inner coefficients of road_arc, per L
  double arc_error_m = 0;         // proven upper bound of |s(u) - exact arc length|, see set_arc
  // Profiles over s - s_start. Heights and slopes as in shaders/lib/surface.glsl.
  Cubic elevation_m;
  Cubic superelevation_rad;      // the cross section's turn, its left side up
  Linear crossfall_left{0, 0};   // slope falling outward from the reference line, on its left
  Linear crossfall_right{0, 0};  // and on its right
  Cubic left_m{3.5, 0, 0, 0};    // t of the left edge
  Cubic right_m{-3.5, 0, 0, 0};  // t of the right edge, below left_m
  std::uint32_t section = 0;     // of Road::sections, whose outer borders the edges are
  MappingBound bound;            // for max_half_width_m

  glm::dvec2 chord_m() const { return end_m - start_m; }
  double chord_length_m() const;
  // Proven upper bounds, over the footprint, of |v - exact| and |s - exact| of the mapping, in metres.
  double v_bound_m() const { return bound.v * chord_length_m(); }
  double s_bound_m() const { return bound.along * chord_length_m() + arc_error_m; }
  // Greatest |t| of the edges: the W of the footprint |v| <= W / L.
  double max_half_width_m() const;
  void set_half_width_m(const Cubic& w) { left_m = w, right_m = -w; }
};

// The surface as the pixel shader has it; heights from elevation_m.c0.
using Lib = glsl::Library<double>;
Lib::RoadSurface surface(const Segment& segment);
// Bounds of the surface's height over the footprint, lanes' own heights not counted; exact for level cross sections,
// else an enclosure. Superelevation beyond 80 degrees counts as 80.
Cubic::Range height_range_m(const Segment& segment);
// At local_s_m from the segment's start and n_m horizontally from the reference line: height in world z, slopes.
Lib::SurfaceSlope surface_at(const Segment& segment, double local_s_m, double n_m);

// The default of what a segment may be wrong by, as a part of the half width W: |v - exact| and |s - exact| <= 1e-4 W.
inline constexpr double kMappingTolerance = 1e-4;

// Fills arc_m, arc_c0, arc_c1 and arc_error_m from the anchors and slopes. Requires: distinct finite anchors.
//
// Derivation of arc_error_m, in units of L. Let S(u) be the exact arc length, p(u) the polynomial of degree 5 that
// road_arc evaluates, and q(u) that of degree 9 which has S and S' at 0, 1/4, 1/2, 3/4 and 1. p has S and S' at 0 and 1
// and S at 1/4 and 3/4, so p - q is u^2 (1 - u)^2 (u - 1/4) (u - 3/4) times a cubic, which its value at 1/2 and its
// slopes at 1/4, 1/2 and 3/4 determine. q - S is at most max |S^(10)| / 10! times the greatest
// (u (u - 1/4) (u - 1/2) (u - 3/4) (u - 1))^2. And S' = h(g), h(g) = sqrt(1 + g^2), where g = f' is quadratic:
//
//   S^(10) = h9 g'^9 + 36 h8 g'^7 g'' + 378 h7 g'^5 g''^2 + 1260 h6 g'^3 g''^3 + 945 h5 g' g''^4,
//
// hk the k-th derivative of h, whose maximum over all g is a constant.
// The values of S come from four panels of the 8-point Gauss-Legendre rule. Within R = 2 / (F2 + sqrt(F2^2 + 2 F3)) of
// any u in [0, 1], F1 to F3 the maxima of |f'| to |f'''|, g(z) differs by at most 1 from the real g(u), so S' is
// analytic there and at most sqrt(1 + (F1 + 1)^2); Cauchy's estimate of its 16th derivative in the rule's remainder
// h^17 (8!)^4 / (17 (16!)^3) S^(17) bounds the error of each value. An error of all values of at most e moves q by at
// most 1.27 e, and leaves p - q.
// Source: Stoer and Bulirsch 2002, theorem 2.1.5.9, and Abramowitz and Stegun 25.4.30 for the two remainders; Faa di
// Bruno's formula.
void set_arc(Segment& segment);

// Fills bound from the slopes and the greatest half width. Requires: set_arc and half_width_m done.
void set_bound(Segment& segment);

// A segment between two anchors with the headings (radians, counter-clockwise from east) of the centre line there,
// level at elevation 0, with constant half width. Requires: distinct finite anchors, headings less than 90 degrees off
// the chord.
Segment make_segment(glm::dvec2 start_m, glm::dvec2 end_m, double heading_start_rad, double heading_end_rad,
                     double half_width_m);

// Proven upper bound of the error of road_project over the footprint 0 <= u <= 1, |v| <= half_width / L; infinity where
// no bound can be given (the segment is then inadmissible and must be split). Proven in real arithmetic, and larger by
// kRoundingAllowance than the formulas, which covers their rounding. road_project in double adds up to 1e-14 to u and v,
// and to_chord the rounding of coordinates; single precision on the GPU adds some 1e-7 (road_shader_test).
//
// Derivation. Let w = half_width / L, and F0, F1, F2, F3 the maxima of |f|, |f'|, |f''|, |f'''| on [0, 1].
// Equation 2 is equation 1, F(u) = x - u + (y - f) f' = 0, without the term -f f', so F(u1) = -f(u1) f'(u1), and
// |F(u1)| <= E = max |f f'|. |F'| = |1 + f'^2 - (y - f) f''| >= 1 - (w + F1 e) F2 wherever |u - u*| <= e, so the error e
// of u1 satisfies e (1 - (w + F1 e) F2) <= E. A Newton step leaves e' <= M e^2 / (2 m) with M = 3 F1 F2 + (w + F1 e) F3
// >= |F''| and m the lower bound of |F'|, and the second one e'' <= M e'^2 / (2 m); clamping u to [0, 1], where u* is,
// only lessens them. dv/du = -f'' F / (1 + f'^2)^(3/2), so |v - v*| <= F2 (1 + F1^2 + (w + F1 e'') F2) e''^2 / 2, and
// the arc length between u and u* is at most sqrt(1 + F1^2) e''. Equation 3 picks the right root where (F0 + w) F2 < 1.
MappingBound mapping_bound(double slope_start, double slope_end, double half_width_over_chord);
inline constexpr double kRoundingAllowance = 1e-9;  // relative

// True where the bounds of both v and s are at most tolerance * W. Requires: set_arc and set_bound done.
bool is_admissible(const Segment& segment, double tolerance = kMappingTolerance);

// Chord frame <-> world, horizontally.
glm::dvec2 to_chord(const Segment& segment, glm::dvec2 point_m);
glm::dvec2 from_chord(const Segment& segment, glm::dvec2 point);

// The centre line at u in [0, 1].
glm::dvec2 position_m(const Segment& segment, double u);
double heading_rad(const Segment& segment, double u);      // in (-pi, pi]
double curvature_per_m(const Segment& segment, double u);  // positive to the left

// Arc length in metres from the segment's start at u, by the polynomial that the shader uses; and its inverse, for
// s in [0, arc_m] (clamped), to 1e-12 of arc_m.
double arc_at(const Segment& segment, double u);
double u_at_arc(const Segment& segment, double s_m);

// (u, v) of a point by the road function, v in units of L: what the pixel shader computes.
Lib::RoadCoord project(const Segment& segment, glm::dvec2 point_m);

// The truly nearest point of the segment's centre line to a point, anywhere in the plane; by bracketing and Newton in
// double, not by the road function. distance_m is unsigned; u in [0, 1].
struct Nearest {
  double u, distance_m;
};
Nearest nearest(const Segment& segment, glm::dvec2 point_m);

// The four corners of the fitted quad (paper, Fig. 5) in the chord frame: start right, start left, end right, end left.
// Its start and end sides run through the anchors perpendicular to the tangents; the two others are parallel to the
// chord, shifted to the extrema of f plus the greatest half width. It covers the segment with 0 <= u <= 1.
struct Quad {
  glm::dvec2 corner[4];
  double y_low, y_high;
};
Quad fitted_quad(const Segment& segment);

// Least and greatest value of f on [0, 1].
Cubic::Range curve_range(double slope_start, double slope_end);

}  // namespace roadgen
