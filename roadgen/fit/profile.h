// The vertical part of the fit: heights and grades at the anchors. Internal to roadgen/fit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace roadgen {

// A measured height at an arc length.
struct HeightSample {
  double s_m, z_m;
};

struct ProfileFit {
  std::vector<double> z_m, grade;   // at every knot
  std::vector<double> error_m;      // distance of every sample
  double max_error_m = 0;
};

// The C1 profile, a cubic between each two knots, that minimizes the sum of squared errors plus lambda times the
// integral of z''^2, with the greatest lambda on a scale of powers of ten for which no error is above max_error_m; or the
// smallest lambda where none is. So quantized heights make no steps. Where closed, length_m joins the last knot to the
// first. Requires: knots increasing; samples within [first knot, last knot], or within [0, length_m] where closed.
// Cost: O(knots + samples) per lambda.
ProfileFit fit_profile(std::span<const double> knots_m, std::span<const HeightSample> samples, bool closed,
                       double length_m, double max_error_m);

}  // namespace roadgen
