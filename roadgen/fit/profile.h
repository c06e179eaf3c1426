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

// No public street is steeper than 0.35; a measured height that needs more than this is wrong.
inline constexpr double kSteepestGrade = 0.5;

// Which heights a road can follow: 1 for those of the largest set in which neighbours differ by at most kSteepestGrade
// times their distance plus 2 max_error_m, where a larger step counts as kStepCost samples. Cost: O(n kStepReach).
std::vector<char> plausible_heights(std::span<const HeightSample> samples, double max_error_m);
inline constexpr int kStepCost = 20;            // so that a true step, a bridge's end, does not cost half the road
inline constexpr std::size_t kStepReach = 100;  // samples that a run of wrong heights may have

struct ProfileFit {
  std::vector<double> z_m, grade;  // at every knot
  std::vector<double> error_m;     // distance of every sample
  double max_error_m = 0;
};

// The C1 profile, a cubic between each two knots, that minimizes the sum of squared errors plus the integral of
// lambda z''^2 (and of z'^2, a little, so that ends without samples level off). lambda is one number between two knots;
// it falls by powers of ten where an error is above max_error_m and stays great elsewhere, so that neither quantized
// heights nor one bad place make bumps. Where closed, length_m joins the last knot to the first.
// Requires: at least two knots, increasing; samples within [first knot, last knot], or [0, length_m] where closed.
// Cost: O(knots + samples), some 10 times.
ProfileFit fit_profile(std::span<const double> knots_m, std::span<const HeightSample> samples, bool closed,
                       double length_m, double max_error_m);

}  // namespace roadgen
