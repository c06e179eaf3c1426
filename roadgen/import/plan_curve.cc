#include "roadgen/import/plan_curve.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

// Nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1] (positive half; Abramowitz and Stegun, table 25.4).
constexpr std::array<double, 4> kNode = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                         0.9602898564975363};
constexpr std::array<double, 4> kWeight = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                           0.1012285362903763};

// Integral of f over [x0, x1] in that many equal panels.
template <class F>
auto integral(const F& f, double x0, double x1, int panels) {
  decltype(f(x0)) sum{};
  const double half = (x1 - x0) / (2 * panels);
  for (int panel = 0; panel < panels; ++panel) {
    const double middle = x0 + half * (2 * panel + 1);
    for (std::size_t i = 0; i < kNode.size(); ++i) {
      sum += (half * kWeight[i]) * (f(middle - half * kNode[i]) + f(middle + half * kNode[i]));
    }
  }
  return sum;
}

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }
glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

double heading_at(const Clothoid& c, double p) {
  const double s = p * c.length_m;
  return c.heading_rad + s * (c.curvature_start_per_m + 0.5 * p * (c.curvature_end_per_m - c.curvature_start_per_m));
}

glm::dvec2 position_at(const Clothoid& c, double p) {
  const double s = p * c.length_m;
  if (c.curvature_start_per_m == c.curvature_end_per_m) {
    const double half = 0.5 * s * c.curvature_start_per_m;
    return c.start_m + direction(c.heading_rad + half) * (half == 0 ? s : s * std::sin(half) / half);
  }
  // A panel turns by at most 0.5 rad, where the rule's error is below 1e-16.
  const double turning = std::abs(s) * std::max(std::abs(c.curvature_start_per_m), std::abs(c.curvature_end_per_m));
  const int panels = 1 + static_cast<int>(2 * turning);
  return c.start_m + c.length_m * integral([&](double q) { return direction(heading_at(c, q)); }, 0, p, panels);
}

// The speed of a parametric cubic is smooth but where it nearly stops, hence so many panels.
constexpr int kArcPanels = 16;

// The pieces of one curve.
class Divider {
 public:
  Divider(const PlanCurve& curve, double half_width_m, std::vector<CurvePiece>& pieces)
      : curve_(curve), half_width_m_(half_width_m), pieces_(pieces) {}

  bool run(double p0, double p1, int depth) {
    CurvePiece piece;
    piece.p0 = p0;
    piece.p1 = p1;
    const bool follows = is_followed(piece);
    const double length_m = curve_.arc_m(p0, p1);
    if (follows && (length_m < kLeastCertified_m || is_certified(piece.segment))) {
      pieces_.push_back(piece);
      return true;
    }
    if (depth == kMostHalvings || length_m < kLeastFollowed_m) return false;
    const double middle = 0.5 * (p0 + p1);
    return run(p0, middle, depth + 1) && run(middle, p1, depth + 1);
  }

 private:
  static constexpr int kMostHalvings = 40;
  // Shorter pieces are not halved for a road that is too wide for its bend, nor for a curve that turns within them.
  static constexpr double kLeastCertified_m = 0.25, kLeastFollowed_m = 2e-3;
  // Tangents further off the chord than this (cosine) make no good segment.
  static constexpr double kLeastCosine = 0.25;
  // Halving certifies no road that is wider than this part of its radius (road_newton's limit is 0.95).
  static constexpr double kTight = 0.94;
  // Ends may still be moved a little to meet the next curve.
  static constexpr double kJoinShare = 0.9;

  // Fills the segment; false where it is not within the tolerances of the curve.
  bool is_followed(CurvePiece& piece) const {
    Segment& s = piece.segment;
    s.start_m = curve_.position_m(piece.p0);
    s.end_m = curve_.position_m(piece.p1);
    const glm::dvec2 chord = s.chord_m(), d0 = curve_.derivative_m(piece.p0), d1 = curve_.derivative_m(piece.p1);
    const double length = glm::length(chord), along0 = glm::dot(chord, d0), along1 = glm::dot(chord, d1);
    if (!(length > 1e-9) || !(along0 > kLeastCosine * length * glm::length(d0)) ||
        !(along1 > kLeastCosine * length * glm::length(d1))) {
      return false;
    }
    s.slope_start = cross(chord, d0) / along0;
    s.slope_end = cross(chord, d1) / along1;
    if (deviation_m(piece) > kPlanTolerance_m) return false;
    set_arc(s);
    return std::abs(s.arc_m - curve_.arc_m(piece.p0, piece.p1)) <= kPlanArcTolerance_m;
  }

  // Greatest sideways distance, by probes and a margin for what lies between them; infinite where the curve leaves the
  // chord's ends.
  double deviation_m(const CurvePiece& piece) const {
    constexpr int kProbes = 8;
    constexpr double kBetweenProbes = 1.2;
    double worst = 0;
    for (int i = 1; i < kProbes; ++i) {
      const double p = piece.p0 + (piece.p1 - piece.p0) * i / kProbes;
      const glm::dvec2 q = to_chord(piece.segment, curve_.position_m(p));
      if (!(q.x > 0 && q.x < 1)) return std::numeric_limits<double>::infinity();
      worst = std::max(worst, std::abs(q.y - Lib::road_f(q.x, piece.segment.slope_start, piece.segment.slope_end)));
    }
    return kBetweenProbes * worst * piece.segment.chord_length_m();
  }

  bool is_certified(Segment& segment) const {
    segment.set_half_width_m({half_width_m_, 0, 0, 0});
    set_bound(segment);
    if (is_admissible(segment, kJoinShare * kMappingTolerance)) return true;
    double most = 0;
    for (const double u : {0.0, 0.5, 1.0}) most = std::max(most, std::abs(curvature_per_m(segment, u)));
    return most * half_width_m_ >= kTight;
  }

  const PlanCurve& curve_;
  double half_width_m_;
  std::vector<CurvePiece>& pieces_;
};

}  // namespace

glm::dvec2 PlanCurve::position_m(double p) const {
  if (const auto* clothoid = std::get_if<Clothoid>(&shape_)) return position_at(*clothoid, p);
  const auto& c = std::get<ParametricCubic>(shape_);
  return c.start_m + p * (c.b_m + p * (c.c_m + p * c.d_m));
}

glm::dvec2 PlanCurve::derivative_m(double p) const {
  if (const auto* clothoid = std::get_if<Clothoid>(&shape_)) {
    return clothoid->length_m * direction(heading_at(*clothoid, p));
  }
  const auto& c = std::get<ParametricCubic>(shape_);
  return c.b_m + p * (2.0 * c.c_m + p * 3.0 * c.d_m);
}

double PlanCurve::arc_m(double p0, double p1) const {
  if (const auto* clothoid = std::get_if<Clothoid>(&shape_)) return clothoid->length_m * (p1 - p0);
  return integral([&](double p) { return glm::length(derivative_m(p)); }, p0, p1, kArcPanels);
}

double PlanCurve::p_at_arc(double s_m) const {
  const double whole = arc_m(0, 1);
  if (!(s_m > 0)) return 0;
  if (s_m >= whole) return 1;
  if (std::holds_alternative<Clothoid>(shape_)) return s_m / whole;
  // Newton inside a shrinking bracket; the arc length increases with p.
  double low = 0, high = 1, p = s_m / whole;
  for (int i = 0; i < 60; ++i) {
    const double miss = arc_m(0, p) - s_m;
    (miss > 0 ? high : low) = p;
    const double speed = glm::length(derivative_m(p));
    double next = speed > 0 ? p - miss / speed : 0.5 * (low + high);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (std::abs(next - p) < 1e-15) return next;
    p = next;
  }
  return p;
}

PlanCurve PlanCurve::poly3(glm::dvec2 start_m, double heading_rad, const Cubic& v, double length_m) {
  const auto up_to = [&](double u) {
    return ParametricCubic{{0, v.c0}, {u, v.c1 * u}, {0, v.c2 * (u * u)}, {0, v.c3 * (u * u * u)}};
  };
  // The arc is at least as long as u.
  double low = 0, high = length_m;
  for (int i = 0; i < 100 && high - low > 1e-16 * length_m; ++i) {
    const double middle = 0.5 * (low + high);
    (PlanCurve(up_to(middle)).arc_m(0, 1) > length_m ? high : low) = middle;
  }
  ParametricCubic curve = up_to(0.5 * (low + high)).turned(heading_rad);
  curve.start_m = start_m + glm::dvec2(-std::sin(heading_rad), std::cos(heading_rad)) * v.c0;
  return curve;
}

bool divide_curve(const PlanCurve& curve, double p0, double p1, double half_width_m, std::vector<CurvePiece>& pieces) {
  return Divider(curve, half_width_m, pieces).run(p0, p1, 0);
}

}  // namespace roadgen
