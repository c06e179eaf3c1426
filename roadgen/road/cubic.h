// Profiles along a road.
#pragma once

namespace roadgen {

// c0 + c1 s + c2 s^2 + c3 s^3, with s in metres.
struct Cubic {
  double c0 = 0, c1 = 0, c2 = 0, c3 = 0;

  double value(double s_m) const { return c0 + s_m * (c1 + s_m * (c2 + s_m * c3)); }
  double slope(double s_m) const { return c1 + s_m * (2 * c2 + s_m * 3 * c3); }
  double second(double s_m) const { return 2 * c2 + 6 * c3 * s_m; }
  bool is_constant() const { return c1 == 0 && c2 == 0 && c3 == 0; }
  // The same function of s - by_m.
  Cubic shifted(double by_m) const {
    if (by_m == 0) return *this;
    return {value(by_m), slope(by_m), c2 + 3 * c3 * by_m, c3};
  }
  Cubic operator+(const Cubic& o) const { return {c0 + o.c0, c1 + o.c1, c2 + o.c2, c3 + o.c3}; }
  Cubic operator-(const Cubic& o) const { return {c0 - o.c0, c1 - o.c1, c2 - o.c2, c3 - o.c3}; }
  Cubic operator-() const { return {-c0, -c1, -c2, -c3}; }
  bool operator==(const Cubic&) const = default;

  // The cubic with the given values and slopes at 0 and at length_m > 0.
  static Cubic hermite(double value0, double slope0, double value1, double slope1, double length_m);

  // Least and greatest value on [0, length_m], exact up to rounding.
  struct Range {
    double low, high;
  };
  Range range(double length_m) const;
};

// c0 + c1 s.
struct Linear {
  double c0 = 0, c1 = 0;
  double value(double s_m) const { return c0 + c1 * s_m; }
  bool operator==(const Linear&) const = default;
};

}  // namespace roadgen
