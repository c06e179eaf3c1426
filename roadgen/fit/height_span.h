// The height of one segment of a road as sums of unknowns. Internal to roadgen/fit.
#pragma once

#include "roadgen/fit/linear_fit.h"

namespace roadgen {

// A segment between two joints, as sums of unknowns.
struct HeightSpan {
  LinearSum z0, g0, z1, g1;
  double length_m;

  LinearSum z_at(double s_m) const {
    const double x = s_m / length_m, w = 1 - x;
    LinearSum z;
    z.add(z0, w * w * (1 + 2 * x));
    z.add(g0, length_m * x * w * w);
    z.add(z1, x * x * (3 - 2 * x));
    z.add(g1, -length_m * x * x * w);
    return z;
  }
  // Second derivative at the start (0) or the end (1).
  LinearSum bend_at(int end) const {
    const double h = length_m, sign = end == 0 ? 1 : -1;
    LinearSum bend;
    bend.add(z1, sign * 6 / (h * h));
    bend.add(z0, -sign * 6 / (h * h));
    bend.add(g0, -sign * (end == 0 ? 4 : 2) / h);
    bend.add(g1, -sign * (end == 0 ? 2 : 4) / h);
    return bend;
  }
  // The Bernstein coefficient of the grade between those at both ends.
  LinearSum middle_grade() const {
    LinearSum grade;
    grade.add(z1, 3 / length_m);
    grade.add(z0, -3 / length_m);
    grade.add(g0, -1);
    grade.add(g1, -1);
    return grade;
  }
};

}  // namespace roadgen
