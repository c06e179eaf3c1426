#include "roadgen/road/cubic.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace roadgen {

Cubic Cubic::hermite(double value0, double slope0, double value1, double slope1, double length_m) {
  assert(length_m > 0);
  const double rise = (value1 - value0) / length_m;
  return {value0, slope0, (3 * rise - 2 * slope0 - slope1) / length_m,
          (slope0 + slope1 - 2 * rise) / (length_m * length_m)};
}

Cubic::Range Cubic::range(double length_m) const {
  Range r{std::min(c0, value(length_m)), std::max(c0, value(length_m))};
  if (c2 == 0 && c3 == 0) return r;
  // Stationary points: 3 c3 s^2 + 2 c2 s + c1 = 0.
  const double discriminant = c2 * c2 - 3 * c3 * c1;
  if (discriminant < 0) return r;
  const double h = -(c2 + std::copysign(std::sqrt(discriminant), c2));
  for (const double s : {c3 != 0 ? h / (3 * c3) : -1.0, h != 0 ? c1 / h : -1.0}) {
    if (s > 0 && s < length_m) {
      r.low = std::min(r.low, value(s));
      r.high = std::max(r.high, value(s));
    }
  }
  return r;
}

}  // namespace roadgen
