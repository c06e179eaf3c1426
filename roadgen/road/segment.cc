#include "roadgen/road/segment.h"

#include <algorithm>
#include <array>
#include <cassert>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1] (positive half; Abramowitz and Stegun, table 25.4).
constexpr std::array<double, 4> kGaussNode = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                              0.9602898564975363};
constexpr std::array<double, 4> kGaussWeight = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745,
                                                0.1012285362903763};

// Roundings of the arc length polynomial and of its error's own computation, in units of L.
constexpr double kArcRounding = 1e-14;

// Arc length of the chord-frame curve from u0 to u1, in units of L, by one panel of the rule.
double arc_panel(double u0, double u1, double a, double b) {
  const double half = 0.5 * (u1 - u0), middle = u0 + half;
  double sum = 0;
  for (std::size_t i = 0; i < kGaussNode.size(); ++i) {
    for (const double node : {-kGaussNode[i], kGaussNode[i]}) {
      const double df = Lib::road_df(middle + half * node, a, b);
      sum += kGaussWeight[i] * std::sqrt(1 + df * df);
    }
  }
  return half * sum;
}

// Real roots of f' in (0, 1).
std::array<double, 2> interior_extrema(double a, double b, int& count) {
  // f' = 3 (a + b) x^2 - (4 a + 2 b) x + a, solved without cancellation.
  count = 0;
  std::array<double, 2> roots{};
  const double p = 3 * (a + b), q = -(4 * a + 2 * b), r = a;
  const double discriminant = q * q - 4 * p * r;
  if (discriminant < 0) return roots;
  const double h = -0.5 * (q + std::copysign(std::sqrt(discriminant), q));
  for (const double x : {p != 0 ? h / p : -1.0, h != 0 ? r / h : -1.0}) {
    if (x > 0 && x < 1) roots[count++] = x;
  }
  return roots;
}

// Maxima of |f'|, |f''| and |f'''| on [0, 1].
struct Derivatives {
  double f1, f2, f3;
};

Derivatives greatest_derivatives(double a, double b) {
  double f1 = std::max(std::abs(a), std::abs(b));
  if (a + b != 0) {
    const double x = (4 * a + 2 * b) / (6 * (a + b));  // where f'' = 0
    if (x > 0 && x < 1) f1 = std::max(f1, std::abs(Lib::road_df(x, a, b)));
  }
  return {f1, std::max(std::abs(4 * a + 2 * b), std::abs(2 * a + 4 * b)), 6 * std::abs(a + b)};
}

// Upper bound of what road_arc is off by on [0, 1], in units of L, with the arc length at u = 1/2 by the same
// quadrature; see set_arc.
double arc_error(double a, double b, double arc, double c0, double c1, double half) {
  const auto [f1, f2, f3] = greatest_derivatives(a, b);
  if (f2 == 0) return 0;
  // p - q = u^2 (1 - u)^2 (u - 1/4) (u - 3/4) r, r = r0 + r1 t + r2 t^2 + r3 t^3, t = u - 1/2.
  const auto slope_error = [&](double u) {
    const double df = Lib::road_df(u, a, b);
    return Lib::road_darc(u, a, b, arc, c0, c1) - std::sqrt(1 + df * df);
  };
  const double before = slope_error(0.25) * (-512.0 / 9), after = slope_error(0.75) * (512.0 / 9);
  const double r0 = (Lib::road_arc(0.5, a, b, arc, c0, c1) - half) * -256, r1 = slope_error(0.5) * -256;
  const double r2 = (0.5 * (before + after) - r0) * 16, r3 = (0.5 * (after - before) - 0.25 * r1) * 64;
  // Greatest values of u^2 (1 - u)^2 |u - 1/4| |u - 3/4| |t|^k.
  const double difference =
      std::abs(r0) / 256 + std::abs(r1) * 3.53e-4 + std::abs(r2) * 1.319e-4 + std::abs(r3) * 5.1e-5;

  constexpr double kH5 = 8.07, kH6 = 45, kH7 = 207, kH8 = 1575, kH9 = 10288;  // |hk| for any g
  const double s = f2 * f2, t = f3;
  const double tenth = f2 * ((((kH9 * s + 36 * kH8 * t) * s + 378 * kH7 * t * t) * s + 1260 * kH6 * t * t * t) * s +
                             945 * kH5 * t * t * t * t);

  // (8!)^4 / (17 (16!)^2) = 3.56e-10, and (h / R)^16 with h = 1/4.
  const double ratio = 0.125 * (f2 + std::sqrt(s + 2 * t));
  const double ratio2 = ratio * ratio, ratio4 = ratio2 * ratio2, ratio8 = ratio4 * ratio4;
  const double quadrature = 3.56e-10 * std::sqrt(1 + (f1 + 1) * (f1 + 1)) * ratio8 * ratio8;
  return (difference + 3.47e-12 * tenth + 1.27 * quadrature) * (1 + kRoundingAllowance) + kArcRounding;
}

// Upper bound of |f f'| on [0, 1]: values at midpoints plus a Lipschitz constant.
double max_residual(double a, double b, double f0, double f1, double f2) {
  constexpr int kPieces = 32;
  double worst = 0;
  for (int i = 0; i < kPieces; ++i) {
    const double x = (i + 0.5) / kPieces;
    worst = std::max(worst, std::abs(Lib::road_f(x, a, b) * Lib::road_df(x, a, b)));
  }
  return std::min(worst + (f1 * f1 + f0 * f2) * 0.5 / kPieces, f0 * f1);
}

// The minimum of the distance from p in [low, high], from u: Newton inside a shrinking bracket.
double refined_nearest(glm::dvec2 p, double a, double b, double low, double u, double high) {
  for (int i = 0; i < 60; ++i) {
    const double d = p.y - Lib::road_f(u, a, b), df = Lib::road_df(u, a, b);
    const double toward = p.x - u + d * df;  // positive: the nearest point lies at greater u
    (toward > 0 ? low : high) = u;
    const double slope = d * Lib::road_ddf(u, a, b) - df * df - 1;
    double next = slope < 0 ? u - toward / slope : 0.5 * (low + high);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool still = std::abs(next - u) < 1e-15;
    u = next;
    if (still) break;
  }
  return u;
}

}  // namespace

double Segment::max_half_width_m() const {
  const Cubic::Range l = left_m.range(arc_m), r = right_m.range(arc_m);
  return std::max({l.high, -l.low, r.high, -r.low});
}

Lib::RoadSurface surface(const Segment& segment) {
  const Cubic &z = segment.elevation_m, &e = segment.superelevation_rad;
  const Linear &l = segment.crossfall_left, &r = segment.crossfall_right;
  return {segment.chord_length_m(),
          segment.slope_start,
          segment.slope_end,
          segment.arc_m,
          segment.arc_c0,
          segment.arc_c1,
          z.c1,
          z.c2,
          z.c3,
          e.c0,
          e.c1,
          e.c2,
          e.c3,
          l.c0,
          l.c1,
          r.c0,
          r.c1};
}

Cubic::Range height_range_m(const Segment& segment) {
  Cubic::Range z = segment.elevation_m.range(segment.arc_m);
  const Cubic::Range e = segment.superelevation_rad.range(segment.arc_m);
  const auto tilt = [](double angle_rad) { return std::tan(std::clamp(angle_rad, -1.4, 1.4)); };
  const auto greatest = [&](const Linear& fall) { return std::max(fall.c0, fall.value(segment.arc_m)); };
  const auto least = [&](const Linear& fall) { return std::min(fall.c0, fall.value(segment.arc_m)); };
  const double left = std::max(segment.left_m.range(segment.arc_m).high, 0.0);
  const double right = std::max(-segment.right_m.range(segment.arc_m).low, 0.0);
  z.low += std::min({0.0, left * (tilt(e.low) - greatest(segment.crossfall_left)),
                     -right * (tilt(e.high) + greatest(segment.crossfall_right))});
  z.high += std::max({0.0, left * (tilt(e.high) - least(segment.crossfall_left)),
                      -right * (tilt(e.low) + least(segment.crossfall_right))});
  return z;
}

Lib::SurfaceSlope surface_at(const Segment& segment, double local_s_m, double n_m) {
  Lib::SurfaceSlope slope = Lib::surface_at(local_s_m, n_m, surface(segment));
  slope.height += segment.elevation_m.c0;
  return slope;
}

double Segment::chord_length_m() const { return glm::length(chord_m()); }

void set_arc(Segment& segment) {
  const double a = segment.slope_start, b = segment.slope_end, length = segment.chord_length_m();
  assert(length > 0 && std::isfinite(length));
  const double first = arc_panel(0, 0.25, a, b), half = first + arc_panel(0.25, 0.5, a, b);
  const double to_last = half + arc_panel(0.5, 0.75, a, b), arc = to_last + arc_panel(0.75, 1, a, b);
  // Two conditions, at u = 1/4 and 3/4, where u^2 (1 - u)^2 = 9/256.
  const double quarter = first - Lib::road_arc(0.25, a, b, arc, 0.0, 0.0);
  const double three_quarters = to_last - Lib::road_arc(0.75, a, b, arc, 0.0, 0.0);
  segment.arc_c0 = (quarter + three_quarters) * 0.5 * 256.0 / 9.0;
  segment.arc_c1 = (three_quarters - quarter) * 2.0 * 256.0 / 9.0;
  segment.arc_m = arc * length;
  segment.arc_error_m = arc_error(a, b, arc, segment.arc_c0, segment.arc_c1, half) * length;
}

void set_bound(Segment& segment) {
  segment.bound =
      mapping_bound(segment.slope_start, segment.slope_end, segment.max_half_width_m() / segment.chord_length_m());
}

Segment make_segment(glm::dvec2 start_m, glm::dvec2 end_m, double heading_start_rad, double heading_end_rad,
                     double half_width_m) {
  Segment s;
  s.start_m = start_m;
  s.end_m = end_m;
  const glm::dvec2 chord = s.chord_m();
  const double chord_heading = std::atan2(chord.y, chord.x);
  assert(std::cos(heading_start_rad - chord_heading) > 0 && std::cos(heading_end_rad - chord_heading) > 0);
  s.slope_start = std::tan(heading_start_rad - chord_heading);
  s.slope_end = std::tan(heading_end_rad - chord_heading);
  s.set_half_width_m({half_width_m, 0, 0, 0});
  set_arc(s);
  set_bound(s);
  return s;
}

Cubic::Range curve_range(double slope_start, double slope_end) {
  Cubic::Range r{0, 0};
  int count = 0;
  const auto roots = interior_extrema(slope_start, slope_end, count);
  for (int i = 0; i < count; ++i) {
    const double f = Lib::road_f(roots[i], slope_start, slope_end);
    r.low = std::min(r.low, f);
    r.high = std::max(r.high, f);
  }
  return r;
}

MappingBound mapping_bound(double a, double b, double w) {
  const MappingBound none{kInfinity, kInfinity, kInfinity};
  if (!std::isfinite(a) || !std::isfinite(b) || !(w >= 0) || !std::isfinite(w)) return none;
  const Cubic::Range f = curve_range(a, b);
  const double f0 = std::max(-f.low, f.high);
  const auto [f1, f2, f3] = greatest_derivatives(a, b);
  if (f2 == 0) return {0, 0, 0};  // straight: the mapping is exact
  if ((f0 + w) * f2 >= 1) return none;

  // e (p - F1 F2 e) <= E, and e grows from 0 at the joints: e is at most the smaller root.
  const double p = 1 - w * f2, residual = max_residual(a, b, f0, f1, f2);
  const double discriminant = p * p - 4 * f1 * f2 * residual;
  if (p <= 0 || discriminant < 1e-6 * p * p) return none;  // near a double root rounding would count
  const double e = 2 * residual / (p + std::sqrt(discriminant));

  const double reach = w + f1 * e;
  const double least_slope = 1 - reach * f2;
  if (least_slope <= 0.05) return none;  // road_newton's own limit
  const double most_second = 3 * f1 * f2 + reach * f3;
  const auto after_step = [&](double error) {
    return std::min(error, most_second * error * error / (2 * least_slope));
  };
  const double left = after_step(after_step(e)) * (1 + kRoundingAllowance);
  return {f2 * (1 + f1 * f1 + reach * f2) * left * left / 2, left, std::sqrt(1 + f1 * f1) * left};
}

bool is_admissible(const Segment& segment, double tolerance) {
  const double most_m = tolerance * segment.max_half_width_m();
  return segment.v_bound_m() <= most_m && segment.s_bound_m() <= most_m;
}

glm::dvec2 to_chord(const Segment& segment, glm::dvec2 point_m) {
  const glm::dvec2 c = segment.chord_m(), d = point_m - segment.start_m;
  const double inverse = 1 / glm::dot(c, c);
  return glm::dvec2(glm::dot(c, d), c.x * d.y - c.y * d.x) * inverse;
}

glm::dvec2 from_chord(const Segment& segment, glm::dvec2 point) {
  const glm::dvec2 c = segment.chord_m();
  return segment.start_m + c * point.x + glm::dvec2(-c.y, c.x) * point.y;
}

glm::dvec2 position_m(const Segment& segment, double u) {
  if (u == 1) return segment.end_m;
  return from_chord(segment, {u, Lib::road_f(u, segment.slope_start, segment.slope_end)});
}

double heading_rad(const Segment& segment, double u) {
  const glm::dvec2 c = segment.chord_m();
  const double df = Lib::road_df(u, segment.slope_start, segment.slope_end);
  return std::atan2(c.y + c.x * df, c.x - c.y * df);
}

double curvature_per_m(const Segment& segment, double u) {
  const double df = Lib::road_df(u, segment.slope_start, segment.slope_end);
  const double q = 1 + df * df;
  return Lib::road_ddf(u, segment.slope_start, segment.slope_end) / (q * std::sqrt(q) * segment.chord_length_m());
}

double arc_at(const Segment& segment, double u) {
  const double length = segment.chord_length_m();
  return length * Lib::road_arc(u, segment.slope_start, segment.slope_end, segment.arc_m / length, segment.arc_c0,
                                segment.arc_c1);
}

double u_at_arc(const Segment& segment, double s_m) {
  if (s_m <= 0) return 0;
  if (s_m >= segment.arc_m) return 1;
  const double length = segment.chord_length_m(), arc = segment.arc_m / length, target = s_m / length;
  const double a = segment.slope_start, b = segment.slope_end;
  // From the cubic with the inverse's values and slopes at both ends, Newton inside a shrinking bracket; road_arc increases
  // with u.
  const double q = s_m / segment.arc_m, p = 1 - q;
  double u = q * p * (p * arc / std::sqrt(1 + a * a) - q * arc / std::sqrt(1 + b * b)) + q * q * (3 - 2 * q);
  if (!(u > 0 && u < 1)) u = q;
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double miss = Lib::road_arc(u, a, b, arc, segment.arc_c0, segment.arc_c1) - target;
    (miss > 0 ? high : low) = u;
    const double slope = Lib::road_darc(u, a, b, arc, segment.arc_c0, segment.arc_c1);
    double next = slope > 0 ? u - miss / slope : 0.5 * (low + high);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    // The error after a step is of the order of its square.
    if (std::abs(next - u) < 1e-8) return next;
    u = next;
  }
  return u;
}

Lib::RoadCoord project(const Segment& segment, glm::dvec2 point_m) {
  const glm::dvec2 p = to_chord(segment, point_m);
  return Lib::road_project(p.x, p.y, segment.slope_start, segment.slope_end);
}

Nearest nearest(const Segment& segment, glm::dvec2 point_m) {
  const glm::dvec2 p = to_chord(segment, point_m);
  const double a = segment.slope_start, b = segment.slope_end;
  const auto distance2 = [&](double u) {
    const double dx = p.x - u, dy = p.y - Lib::road_f(u, a, b);
    return dx * dx + dy * dy;
  };
  // The squared distance is a polynomial of degree 6: each of its minima, at most three, that samples show is refined.
  constexpr int kSamples = 12;
  std::array<double, kSamples + 1> sample;
  for (int i = 0; i <= kSamples; ++i) sample[i] = distance2(static_cast<double>(i) / kSamples);
  double best = 0, least = kInfinity;
  for (int i = 0; i <= kSamples; ++i) {
    if ((i > 0 && sample[i - 1] < sample[i]) || (i < kSamples && sample[i + 1] < sample[i])) continue;
    const double u = refined_nearest(p, a, b, std::max(0.0, (i - 1.0) / kSamples), static_cast<double>(i) / kSamples,
                                     std::min(1.0, (i + 1.0) / kSamples));
    const double d = distance2(u);
    if (d < least) least = d, best = u;
  }
  return {best, std::sqrt(least) * segment.chord_length_m()};
}

Quad fitted_quad(const Segment& segment) {
  const double a = segment.slope_start, b = segment.slope_end;
  const double w = segment.max_half_width_m() / segment.chord_length_m();
  const Cubic::Range f = curve_range(a, b);
  // Where both slopes have one sign the offset curve's extremum lies at a joint, at f = 0: the shift by W covers it.
  Quad quad;
  quad.y_low = f.low - w;
  quad.y_high = f.high + w;
  // The line u = 0 is x = -a y, the line u = 1 is x = 1 - b y.
  quad.corner[0] = {-a * quad.y_low, quad.y_low};
  quad.corner[1] = {-a * quad.y_high, quad.y_high};
  quad.corner[2] = {1 - b * quad.y_low, quad.y_low};
  quad.corner[3] = {1 - b * quad.y_high, quad.y_high};
  return quad;
}

}  // namespace roadgen
