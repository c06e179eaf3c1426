// Interval arithmetic: the functions of shaders/lib over whole ranges of their arguments, as glsl::Library<Interval>.
//
// Every operation returns an interval that holds every result for arguments within the given ones; it is widened by more
// than the rounding error of double precision. Requires finite bounds. Comparisons tell how the middles lie: a function
// with branches may be asked only where both branches agree at the boundary between them, or where the argument lies on
// one side of it.
// Source: Moore 1966.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace roadgen {

struct Interval {
  double low = 0, high = 0;

  Interval() = default;
  constexpr Interval(double x) : low(x), high(x) {}  // implicit: literals of shader text are doubles
  constexpr Interval(double l, double h) : low(l), high(h) {}

  double middle() const { return 0.5 * (low + high); }
  double radius() const { return 0.5 * (high - low); }
  // The greatest absolute value.
  double magnitude() const { return std::max(std::abs(low), std::abs(high)); }
  bool holds(double x) const { return x >= low && x <= high; }

  friend Interval operator-(Interval a) { return {-a.high, -a.low}; }
  friend Interval operator+(Interval a, Interval b) { return rounded(a.low + b.low, a.high + b.high); }
  friend Interval operator-(Interval a, Interval b) { return rounded(a.low - b.high, a.high - b.low); }
  friend Interval operator*(Interval a, Interval b) {
    const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
    return rounded(std::min(std::min(p, q), std::min(r, s)), std::max(std::max(p, q), std::max(r, s)));
  }
  // Everything where b holds 0.
  friend Interval operator/(Interval a, Interval b) {
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (b.holds(0)) return {-kInfinite, kInfinite};
    return a * rounded(1 / b.high, 1 / b.low);
  }
  friend bool operator<(Interval a, Interval b) { return a.middle() < b.middle(); }
  friend bool operator>(Interval a, Interval b) { return a.middle() > b.middle(); }

  // The square: never negative, unlike the product of two intervals that happen to be equal.
  friend Interval square(Interval a) {
    const double most = a.magnitude(), least = a.holds(0) ? 0 : std::min(std::abs(a.low), std::abs(a.high));
    const Interval r = rounded(least * least, most * most);
    return {std::max(r.low, 0.0), r.high};
  }
  friend Interval sqrt(Interval a) {
    return rounded(std::sqrt(std::max(a.low, 0.0)), std::sqrt(std::max(a.high, 0.0)));
  }
  friend Interval abs(Interval a) {
    return {a.holds(0) ? 0 : std::min(std::abs(a.low), std::abs(a.high)), a.magnitude()};
  }
  friend Interval clamp(Interval a, double low, double high) {
    return {std::clamp(a.low, low, high), std::clamp(a.high, low, high)};
  }
  // The least interval that holds both.
  friend Interval hull(Interval a, Interval b) { return {std::min(a.low, b.low), std::max(a.high, b.high)}; }

 private:
  // Results of one operation are off by at most half a unit in the last place, 1.2e-16 of them.
  static Interval rounded(double low, double high) {
    constexpr double kUnit = 2.3e-16, kLeast = std::numeric_limits<double>::min();
    return {low - kUnit * std::abs(low) - kLeast, high + kUnit * std::abs(high) + kLeast};
  }
};

}  // namespace roadgen
