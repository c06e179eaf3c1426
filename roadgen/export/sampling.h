// How densely a road must be sampled for a stated error.
#pragma once

#include "roadgen/road/segment.h"

namespace roadgen {

// Bounds over one segment of what straight pieces between stations h apart are off by; derivation: see tessellate().
class SegmentError {
 public:
  explicit SegmentError(const Segment& segment);

  // Of the chords of the line at offset t_m on the surface, m.
  double of_line(const Cubic& t_m, double h_m) const;
  // Of the two triangles between stations, m. raised_m: how much higher the left border lies above the surface than the
  // right one.
  double of_strip(const Cubic& right_m, const Cubic& left_m, double raised_m, double h_m) const;
  // Likewise of what is swept along the line at offset t_m, which changes by t_slope per metre of s, and at heights whose
  // second derivative by s is at most height_second: a profile that reaches most_m to either side of it, of straight
  // edges at most edge_m wide.
  double of_sweep(double most_m, double t_slope, double height_second, double edge_m, double h_m) const;

 private:
  // Maxima of a profile and of its derivatives.
  struct Bound {
    double value, slope, second;
  };
  struct Second {
    double plan, z;
  };
  static Bound bound_of(const Cubic& c, double length_m);
  Second second_of(const Bound& t) const;

  double length_m_, curvature_, curvature_slope_;
  Bound height_, turn_, aside_;  // aside: of the slope across
};

// The fewest rows that keep worst(rows) within max_error; where none does, such that they are 1 cm apart. worst does not
// grow with the number of rows. Result >= 1.
template <class Worst>
int fewest_rows(double length_m, double max_error, Worst&& worst) {
  const double closest = length_m / 0.01;
  const int most = closest < 1 ? 1 : (closest > 1e6 ? 1000000 : static_cast<int>(closest));
  int low = 1, high = 1;
  while (high < most && worst(high) > max_error) {
    low = high + 1;
    high = 2 * high < most ? 2 * high : most;
  }
  while (low < high) {
    const int middle = low + (high - low) / 2;
    if (worst(middle) <= max_error) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  return high;
}

}  // namespace roadgen
