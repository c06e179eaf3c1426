#include "roadgen/export/sampling.h"

#include <algorithm>
#include <cmath>

namespace roadgen {
namespace {

double greatest(Cubic::Range range) { return std::max(std::abs(range.low), std::abs(range.high)); }

}  // namespace

SegmentError::Bound SegmentError::bound_of(const Cubic& c, double length_m) {
  return {greatest(c.range(length_m)), greatest(Cubic{c.c1, 2 * c.c2, 3 * c.c3}.range(length_m)),
          std::max(std::abs(c.second(0)), std::abs(c.second(length_m)))};
}

SegmentError::SegmentError(const Segment& segment) : length_m_(segment.arc_m) {
  const double a = segment.slope_start, b = segment.slope_end, chord = segment.chord_length_m();
  const double f1 = greatest(Cubic{a, -4 * a - 2 * b, 3 * a + 3 * b}.range(1));
  const double f2 = std::max(std::abs(4 * a + 2 * b), std::abs(2 * a + 4 * b)), f3 = std::abs(6 * a + 6 * b);
  curvature_ = f2 / chord;
  curvature_slope_ = (f3 + 3 * f1 * f2 * f2) / (chord * chord);
  height_ = bound_of(segment.elevation_m, length_m_);
  turn_ = bound_of(segment.superelevation_rad, length_m_);
  const double tilt = std::tan(std::min(turn_.value, 1.5)), more = 1 + tilt * tilt;
  const auto most = [&](const Linear& fall) {
    return std::max(std::abs(fall.value(0)), std::abs(fall.value(length_m_)));
  };
  aside_ = {tilt + std::max(most(segment.crossfall_left), most(segment.crossfall_right)),
            turn_.slope * more + std::max(std::abs(segment.crossfall_left.c1), std::abs(segment.crossfall_right.c1)),
            (turn_.second + 2 * tilt * turn_.slope * turn_.slope) * more};
}

SegmentError::Second SegmentError::second_of(const Bound& t) const {
  const double n1 = t.slope + t.value * turn_.slope;
  const double n2 = t.second + 2 * t.slope * turn_.slope + t.value * (turn_.slope * turn_.slope + turn_.second);
  const double k = curvature_;
  return {k + n2 + 2 * n1 * k + t.value * (curvature_slope_ + k * k),
          height_.second + n2 * aside_.value + 2 * n1 * aside_.slope + t.value * aside_.second};
}

double SegmentError::of_line(const Cubic& t_m, double h_m) const {
  const Second second = second_of(bound_of(t_m, length_m_));
  return std::hypot(second.plan, second.z) * h_m * h_m / 8;
}

double SegmentError::of_sweep(double most_m, double t_slope, double height_second, double edge_m, double h_m) const {
  const double k = curvature_, plan = k + 2 * t_slope * k + most_m * (curvature_slope_ + k * k);
  return std::hypot(plan * h_m * h_m / 8 + edge_m * k * h_m / 4, height_second * h_m * h_m / 8);
}

double SegmentError::of_strip(const Cubic& right_m, const Cubic& left_m, double raised_m, double h_m) const {
  const Bound right = bound_of(right_m, length_m_), left = bound_of(left_m, length_m_);
  const Bound t = {std::max(right.value, left.value), std::max(right.slope, left.slope),
                   std::max(right.second, left.second)};
  const Bound width = bound_of(left_m - right_m, length_m_);
  const Second second = second_of(t);
  const double across1 = width.slope + width.value * turn_.slope;
  const double plan = second.plan * h_m * h_m / 8 + (across1 + width.value * curvature_) * h_m / 4;
  const double z = second.z * h_m * h_m / 8 + (across1 * aside_.value + width.value * aside_.slope) * h_m / 4;
  const double edge = second.plan * h_m * h_m / 8;
  const double bend = std::max(1 - t.value * curvature_, 0.05);
  const double narrowest = std::max((left_m - right_m).range(length_m_).low, 1e-6);
  const double slope =
      std::hypot((height_.slope + t.value * aside_.slope) / bend, aside_.value + std::abs(raised_m) / narrowest);
  return std::min(std::hypot(plan, z), z + slope * plan + edge * (1 + slope));
}

}  // namespace roadgen
