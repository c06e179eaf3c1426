#include "roadgen/fit/guess.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "roadgen/road/segment.h"

namespace roadgen {
namespace {

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

// Direction of the fitted cubic at one end, scaled by 1 / chord length: on a circle, that is the weight by which the
// directions of two neighbouring chords give the tangent.
glm::dvec2 end_direction(std::span<const glm::dvec2> samples_m, bool at_start) {
  const ChordFit fit = chord_fit(samples_m);
  const glm::dvec2 chord = samples_m.back() - samples_m.front();
  const double slope = !fit.usable ? 0 : at_start ? fit.slope_start : fit.slope_end;
  const glm::dvec2 d = chord + slope * glm::dvec2(-chord.y, chord.x);
  return d / (glm::length(d) * glm::length(chord));
}

}  // namespace

ChordFit chord_fit(std::span<const glm::dvec2> samples_m) {
  const glm::dvec2 start = samples_m.front(), chord = samples_m.back() - start;
  const double length2 = glm::dot(chord, chord), length = std::sqrt(length2);
  const auto inner = samples_m.subspan(1, samples_m.size() - 2);
  ChordFit fit;
  if (!(length2 > 0)) return fit;
  // Normal equations of y = a p(x) - b q(x); a trace of ridge keeps a single sample between solvable.
  double pp = 1e-6, pq = 0, qq = 1e-6, py = 0, qy = 0;
  for (const glm::dvec2 sample : inner) {
    const glm::dvec2 d = sample - start;
    const double x = glm::dot(d, chord) / length2, y = cross(chord, d) / length2;
    if (!(x > 0 && x < 1)) return fit;
    const double p = x * (1 - x) * (1 - x), q = -x * x * (1 - x);
    pp += p * p, pq += p * q, qq += q * q, py += p * y, qy += q * y;
  }
  const double determinant = pp * qq - pq * pq;
  fit.slope_start = (py * qq - qy * pq) / determinant;
  fit.slope_end = (qy * pp - py * pq) / determinant;
  for (const glm::dvec2 sample : inner) {
    const glm::dvec2 d = sample - start;
    const double x = glm::dot(d, chord) / length2, y = cross(chord, d) / length2;
    fit.error_m = std::max(fit.error_m, std::abs(Lib::road_v(x, x, y, fit.slope_start, fit.slope_end)) * length);
  }
  fit.usable = std::max(std::abs(fit.slope_start), std::abs(fit.slope_end)) <= kMostGuessSlope;
  return fit;
}

std::vector<std::size_t> thin(std::span<const glm::dvec2> samples_m, double error_m) {
  std::vector<std::size_t> at{0};
  while (at.back() + 1 < samples_m.size()) {
    const std::size_t from = at.back();
    const auto reaches = [&](std::size_t to) {
      const ChordFit fit = chord_fit(samples_m.subspan(from, to - from + 1));
      return fit.usable && fit.error_m <= error_m;
    };
    // Doubling steps, then bisection.
    std::size_t good = from + 1, bad = samples_m.size();
    for (std::size_t step = 1; good + step < bad; step *= 2) {
      (reaches(good + step) ? good : bad) = good + step;
    }
    while (bad - good > 1) {
      const std::size_t middle = good + (bad - good) / 2;
      (reaches(middle) ? good : bad) = middle;
    }
    at.push_back(good);
  }
  return at;
}

double local_heading(std::span<const glm::dvec2> samples_m, std::size_t at) {
  glm::dvec2 in{0, 0}, out{0, 0};
  if (at > 0) in = end_direction(samples_m.first(at + 1), false);
  if (at + 1 < samples_m.size()) out = end_direction(samples_m.subspan(at), true);
  const glm::dvec2 sum = in + out;
  if (glm::length(sum) > 1e-6 * (glm::length(in) + glm::length(out))) return std::atan2(sum.y, sum.x);
  return std::atan2(in.x, -in.y);
}

}  // namespace roadgen
