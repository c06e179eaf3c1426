#include "roadgen/query/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

// The polynomial p0 + p1 u + ... of the given degree, and its slope.
struct Value {
  double value, slope;
};
Value evaluate(const double* p, int degree, double u) {
  Value v{p[degree], 0};
  for (int i = degree - 1; i >= 0; --i) {
    v.slope = v.slope * u + v.value;
    v.value = v.value * u + p[i];
  }
  return v;
}

// The root between low and high, where `at` has values of different sign: Newton inside a shrinking bracket, until a step
// is below `enough`; the next would be of the order of its square.
constexpr double kEnough = 1e-7;
template <class At>
double bracketed_root(double low, double high, double u, bool rising, double enough, At&& at) {
  for (int i = 0; i < 100; ++i) {
    const Value v = at(u);
    ((v.value > 0) == rising ? high : low) = u;
    double next = v.slope != 0 ? u - v.value / v.slope : 0.5 * (low + high);
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const double step = std::abs(next - u);
    u = next;
    if (step < enough) break;
  }
  return u;
}

// The real roots in (0, 1) at which the polynomial changes its sign, increasing: between the roots of its derivative.
int roots(const double* p, int degree, double* found) {
  if (degree == 0) return 0;
  double derivative[5], inner[5];
  for (int i = 0; i < degree; ++i) derivative[i] = (i + 1) * p[i + 1];
  const int turns = roots(derivative, degree - 1, inner);
  int count = 0;
  double low = 0, at_low = p[0];
  for (int i = 0; i <= turns; ++i) {
    const double high = i < turns ? inner[i] : 1, at_high = evaluate(p, degree, high).value;
    if ((at_low < 0 && at_high >= 0) || (at_low > 0 && at_high <= 0)) {
      found[count++] = bracketed_root(low, high, 0.5 * (low + high), at_low < 0, 1e-10,
                                      [&](double u) { return evaluate(p, degree, u); });
    }
    low = high;
    at_low = at_high;
  }
  return count;
}

// Where (x, y) lies on the normal of the curve: the roots of equation 1 in (0, 1), at most five.
int all_feet(double x, double y, double a, double b, double* found) {
  const double c1 = a, c2 = -(2 * a + b), c3 = a + b;  // f = c1 u + c2 u^2 + c3 u^3
  const double p[6] = {
      x + y * c1,  2 * y * c2 - c1 * c1 - 1, 3 * (y * c3 - c1 * c2), -(4 * c1 * c3 + 2 * c2 * c2), -5 * c2 * c3,
      -3 * c3 * c3};
  return roots(p, 5, found);
}

double greatest_second(double a, double b) { return std::max(std::abs(4 * a + 2 * b), std::abs(2 * a + 4 * b)); }
// Of |f| on [0, 1]: x (1 - x)^2 is at most 4/27.
double greatest_offset(double a, double b) { return 4.0 / 27 * (std::abs(a) + std::abs(b)); }

bool is_zero(const Cubic& c) { return c.c0 == 0 && c.is_constant(); }
bool is_zero(const Linear& c) { return c.c0 == 0 && c.c1 == 0; }

// What single precision takes from a bound in the chord frame.
constexpr double kSingle = 1.2e-7;

bool is_better(const RoadPoint& a, const RoadPoint& b) {
  return a.outside_m < b.outside_m || (a.outside_m == b.outside_m && a.distance_m < b.distance_m);
}

}  // namespace

Footprint::Footprint(const Road& road, const Segment& segment, SegmentRef at, std::int32_t area)
    : start_m_(segment.start_m),
      a_(segment.slope_start),
      b_(segment.slope_end),
      area_(area),
      s_start_m_(segment.s_start_m),
      elevation_m_(segment.elevation_m),
      length_m_(segment.chord_length_m()),
      left_m_(segment.left_m.c0),
      right_m_(segment.right_m.c0),
      at_(at),
      section_(&section_of(road, segment)) {
  const glm::dvec2 chord = segment.chord_m();
  heading_rad_ = std::atan2(chord.y, chord.x);
  axis_ = chord / glm::dot(chord, chord);
  const double at_start = std::sqrt(1 + a_ * a_), at_end = std::sqrt(1 + b_ * b_), arc = segment.arc_m / length_m_;
  const double c = segment.arc_c0 - 0.5 * segment.arc_c1, c1 = segment.arc_c1;
  arc_[0] = length_m_ * at_start;
  arc_[1] = length_m_ * (3 * arc - 2 * at_start - at_end + c);
  arc_[2] = length_m_ * (at_start + at_end - 2 * arc - 2 * c + c1);
  arc_[3] = length_m_ * (c - 2 * c1);
  arc_[4] = length_m_ * c1;
  const double width = segment.max_half_width_m() / length_m_;
  const Cubic::Range f = curve_range(a_, b_);
  const double low = f.low - width - kTouch_m / length_m_, high = f.high + width + kTouch_m / length_m_;
  y_low_ = static_cast<float>(low - kSingle * std::abs(low));
  y_high_ = static_cast<float>(high + kSingle * std::abs(high));
  if (segment.left_m.is_constant() && segment.right_m.is_constant()) flags_ |= kConstantEdges;
  if (elevation_m_.is_constant()) flags_ |= kLevelAlong;
  if (is_zero(segment.superelevation_rad)) flags_ |= kLevelAcross;
  const Cubic::Range raised = lane_height_range_m(*section_);
  if ((flags_ & kLevelAcross) && is_zero(segment.crossfall_left) && is_zero(segment.crossfall_right) &&
      raised.low == 0 && raised.high == 0) {
    flags_ |= kFlatAcross;
  }
  if ((greatest_offset(a_, b_) + width) * greatest_second(a_, b_) >= 0.99) flags_ |= kFolded;
}

bool Footprint::may_hold(glm::dvec2 point_m, double most_m) const {
  const Local p = local(point_m);
  if (p.y < y_low_ || p.y > y_high_) return false;
  const double inverse2 = glm::dot(axis_, axis_);
  const double off = std::abs(p.y) - greatest_offset(a_, b_);
  const double most = most_m + kTouch_m;
  if (off > 0 && off * off > most * most * inverse2) return false;
  if (flags_ & kFolded) return true;
  const double before = p.x + a_ * p.y, after = p.x - 1 + b_ * p.y, touch2 = 16 * kTouch_m * kTouch_m * inverse2;
  return !(before < 0 && before * before > touch2 * (1 + a_ * a_)) &&
         !(after > 0 && after * after > touch2 * (1 + b_ * b_));
}

int Footprint::beyond(glm::dvec2 point_m) const {
  const Local p = local(point_m);
  if ((p.x + a_ * p.y) * length_m_ < -kTouch_m) return -1;
  return (p.x - 1 + b_ * p.y) * length_m_ > kTouch_m ? 1 : 0;
}

RoadPoint Footprint::place_at(const Road& road, Local p, double u) const {
  RoadPoint r;
  r.at = at_;
  r.u = u;
  const double df = Lib::road_df(u, a_, b_), scale = length_m_ / std::sqrt(1 + df * df);
  const double dx = p.x - u, dy = p.y - Lib::road_f(u, a_, b_);
  const double n = (dy - dx * df) * scale;
  // Between the ends the foot is perpendicular and what is along is rounding only.
  const double along = u > 0 && u < 1 ? 0 : (dx + dy * df) * scale;
  const double local_s = arc(u);
  r.s_m = s_start_m_ + local_s;
  const double cosine = flags_ & kLevelAcross ? 1 : std::cos(segment(road).superelevation_rad.value(local_s));
  const double left = flags_ & kConstantEdges ? left_m_ : segment(road).left_m.value(local_s);
  const double right = flags_ & kConstantEdges ? right_m_ : segment(road).right_m.value(local_s);
  r.t_m = n / cosine;
  const double beside = std::max({n - left * cosine, right * cosine - n, 0.0});
  r.outside_m = along == 0 ? beside : std::sqrt(along * along + beside * beside);
  if (r.outside_m <= kTouch_m) r.outside_m = 0;
  r.distance_m = along == 0 ? std::abs(n) : std::sqrt(along * along + n * n);
  return r;
}

RoadPoint Footprint::locate(const Road& road, glm::dvec2 point_m) const {
  const Local p = local(point_m);
  const double before = p.x + a_ * p.y, after = p.x - 1 + b_ * p.y;  // equation 1 at both ends
  if ((std::abs(p.y) + greatest_offset(a_, b_)) * greatest_second(a_, b_) < 0.99) {
    // Equation 1 falls from 0 to 1: there is one foot.
    if (before <= 0) return place_at(road, p, 0);
    if (after >= 0) return place_at(road, p, 1);
    if (a_ == 0 && b_ == 0) return place_at(road, p, p.x);
    const double start = std::clamp(
        Lib::road_u1(Lib::road_alpha(p.y, a_, b_), Lib::road_beta(p.y, a_, b_), Lib::road_gamma(p.x, p.y, a_)), 0.0,
        1.0);
    return place_at(road, p, bracketed_root(0, 1, start, false, kEnough, [&](double u) {
                      const double d = p.y - Lib::road_f(u, a_, b_), df = Lib::road_df(u, a_, b_);
                      return Value{p.x - u + d * df, d * Lib::road_ddf(u, a_, b_) - df * df - 1};
                    }));
  }
  std::array<double, 7> feet;
  int count = all_feet(p.x, p.y, a_, b_, feet.data());
  if (before <= 0) feet[count++] = 0;
  if (after >= 0) feet[count++] = 1;
  RoadPoint best = place_at(road, p, count > 0 ? feet[0] : 0);
  for (int i = 1; i < count; ++i) {
    const RoadPoint other = place_at(road, p, feet[i]);
    if (is_better(other, best)) best = other;
  }
  return best;
}

double Footprint::u_at(double s, double end) const {
  const auto newton = [&](double u) { return (arc(u) - s) / arc_slope(u); };
  const double start = s / end, once = start - newton(start), step = newton(once), twice = once - step;
  if (std::abs(step) < kEnough && twice >= 0 && twice <= 1) return twice;
  return u_at_bend(s, start);
}

// Bends so tight that two steps are too few.
double Footprint::u_at_bend(double s, double start) const {
  return bracketed_root(0, 1, start, true, kEnough, [&](double u) { return Value{arc(u) - s, arc_slope(u)}; });
}

RoadPose Footprint::pose(const Road& road, double local_s_m, double t_m) const {
  if (!(flags_ & kFlatAcross)) return pose_in(road, segment(road), local_s_m, t_m);
  const double end = arc(1), s = std::clamp(local_s_m, 0.0, end), u = u_at(s, end);
  const double df = Lib::road_df(u, a_, b_), steep2 = 1 + df * df, length2 = 1 / glm::dot(axis_, axis_);
  const glm::dvec2 chord = axis_ * length2, aside(-chord.y, chord.x), along = chord + aside * df;
  const double length = std::sqrt(length2 * steep2);
  const glm::dvec2 tangent = along / length, left(-tangent.y, tangent.x);
  RoadPose pose;
  constexpr double kPi = std::numbers::pi;
  const double heading = heading_rad_ + std::atan(df);
  pose.heading_rad = heading > kPi ? heading - 2 * kPi : heading <= -kPi ? heading + 2 * kPi : heading;
  pose.curvature_per_m = Lib::road_ddf(u, a_, b_) / (steep2 * length);
  pose.position_m = glm::dvec3(start_m_ + chord * u + aside * Lib::road_f(u, a_, b_) + left * t_m, elevation_m_.c0);
  if (flags_ & kLevelAlong) return pose;
  pose.position_m.z = elevation_m_.value(s);
  const double slope = elevation_m_.slope(s);
  if (slope != 0) lean(pose, tangent, tangent * grade_at(slope, t_m, pose.curvature_per_m));
  return pose;
}

double Footprint::ground_m(const Road& road, const RoadPoint& place) const {
  const double local_s = place.s_m - s_start_m_;
  if (flags_ & kFlatAcross) return elevation_m_.value(local_s);
  const double t = place.outside_m == 0 ? place.t_m
                                        : std::max(std::min(place.t_m, segment(road).left_m.value(local_s)),
                                                   segment(road).right_m.value(local_s));
  return surface_height_m(road, segment(road), local_s, t);
}

Box Footprint::bounds(const Road& road) const {
  Bounds b = roadgen::bounds(segment(road));
  if (flags_ & kFolded) {
    // The fitted quad's ends need not hold cross sections that cross: a margin of the width all around the curve.
    const double width = segment(road).max_half_width_m() / length_m_;
    for (const double x : {-width, 1 + width}) {
      for (const float y : {y_low_, y_high_}) b.add(glm::dvec3(from_chord(segment(road), {x, y}), b.low_m.z));
    }
  }
  const Cubic::Range lanes = lane_height_range_m(*section_);
  b.low_m.z += lanes.low;
  b.high_m.z += lanes.high;
  return {b.low_m, b.high_m};
}

}  // namespace roadgen
