// Samples that lie off the course of their neighbours. Internal to roadgen/fit.
#pragma once

#include <span>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

// Curvature changes no faster than this for long: a clothoid of parameter 16 m, tighter than any ramp's.
inline constexpr double kMostCurvatureChange_per_m2 = 0.004;
// A sample this many times the allowed error off the smooth course is an outlier.
inline constexpr double kOutlier = 3;

// 1 for every outlier. The course is that of a point for each sample which minimizes
//   sum over samples of rho(|point - sample| / max_error_m), rho Huber's robust loss,
//   + sum over four points in a row of (third derivative * h^3 / max(max_error_m, kMostCurvatureChange h^3))^2, h their
//     mean distance;
// so what is bent less than roads are costs little, and one bad sample no more than a few good ones give way for. The
// farthest of neighbouring samples is left out, and the course found anew, until none is too far. One that is only too
// far along the course is none. Where samples are so far apart that a road may bend between them as it likes, none is an
// outlier. Cost: about 0.1 ms a sample.
// Source: Huber 1981, robust statistics.
std::vector<char> find_outliers(std::span<const glm::dvec2> samples, bool closed, double max_error_m);

}  // namespace roadgen
