// The curves of OpenDRIVE's plan view (line, arc, spiral, poly3, paramPoly3) and their division into segments of the road
// function.
#pragma once

#include <variant>
#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/import/param_poly3.h"
#include "roadgen/road/segment.h"

namespace roadgen {

// A curve whose curvature changes linearly with its length: line, arc and spiral.
struct Clothoid {
  glm::dvec2 start_m{0, 0};
  double heading_rad = 0;
  double length_m = 1;
  double curvature_start_per_m = 0, curvature_end_per_m = 0;  // positive to the left
};

// Either, over p in [0, 1].
class PlanCurve {
 public:
  PlanCurve(const Clothoid& clothoid) : shape_(clothoid) {}
  PlanCurve(const ParametricCubic& cubic) : shape_(cubic) {}

  // Positions to 1e-15 of the length; cost of a spiral: O(its turning).
  glm::dvec2 position_m(double p) const;
  glm::dvec2 derivative_m(double p) const;

  // The polynomial of paramPoly3 and poly3, else null.
  const ParametricCubic* parametric() const { return std::get_if<ParametricCubic>(&shape_); }

  // Arc length between two parameters, and the parameter at an arc length from the start.
  double arc_m(double p0, double p1) const;
  double p_at_arc(double s_m) const;

  // The cubic (u, a + b u + c u^2 + d u^3) of OpenDRIVE's poly3, u from 0 on, turned by the heading, up to the given arc
  // length.
  static PlanCurve poly3(glm::dvec2 start_m, double heading_rad, const Cubic& v, double length_m);

 private:
  std::variant<Clothoid, ParametricCubic> shape_;
};

// A part of a curve as one segment, which has the curve's points and tangents at its ends.
struct CurvePiece {
  Segment segment;  // geometry and arc
  double p0 = 0, p1 = 1;
};

// How far a segment may lie from the curve it stands for, sideways, and how much its arc length may differ.
inline constexpr double kPlanTolerance_m = 1e-3;
inline constexpr double kPlanArcTolerance_m = 1e-6;

// Appends the part p0 <= p <= p1, halved until each piece is within kPlanTolerance_m and kPlanArcTolerance_m of the
// curve, and certified for the half width unless it is shorter than 0.25 m or the half width is about its radius. A graph
// over its chord is taken whole. False where the curve stops, reverses or turns within 2 mm.
// Cost: O(pieces).
bool divide_curve(const PlanCurve& curve, double p0, double p1, double half_width_m, std::vector<CurvePiece>& pieces);

}  // namespace roadgen
