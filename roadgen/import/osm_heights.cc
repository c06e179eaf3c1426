#include "roadgen/import/osm_heights.h"

#include <algorithm>

#include "roadgen/road/cubic.h"

namespace roadgen {

HeightProfile::Value HeightProfile::value(double distance_m) const {
  if (at_m.empty()) return {};
  if (at_m.size() == 1 || distance_m <= at_m.front()) return {z_m.front(), 0};
  if (distance_m >= at_m.back()) return {z_m.back(), 0};
  const auto i = static_cast<std::size_t>(std::upper_bound(at_m.begin(), at_m.end(), distance_m) - at_m.begin()) - 1;
  const auto rise = [&](std::size_t k) { return (z_m[k + 1] - z_m[k]) / (at_m[k + 1] - at_m[k]); };
  // Harmonic means keep the cubic monotone. Source: Fritsch and Butland 1984.
  const auto grade = [&](std::size_t k) {
    if (k == 0) return rise(0);
    if (k + 1 == z_m.size()) return rise(k - 1);
    const double a = rise(k - 1), b = rise(k);
    return a * b > 0 ? 2 * a * b / (a + b) : 0.0;
  };
  const double length = at_m[i + 1] - at_m[i];
  const Cubic c = Cubic::hermite(z_m[i], grade(i), z_m[i + 1], grade(i + 1), length);
  return {c.value(distance_m - at_m[i]), c.slope(distance_m - at_m[i])};
}

}  // namespace roadgen
