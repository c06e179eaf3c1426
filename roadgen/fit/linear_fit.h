// Least squares over sums of unknowns, some of which must stay within bounds. Internal to roadgen/fit.
#pragma once

#include <cstdint>
#include <vector>

namespace roadgen {

// A sum of unknowns, each times a factor.
struct LinearSum {
  struct Term {
    std::uint32_t unknown;
    double factor;
  };
  std::vector<Term> terms;

  void add(std::uint32_t unknown, double factor);
  void add(const LinearSum& other, double factor);
};

// Minimizes, over the unknowns,
//   the sum over wishes of weight / 2 * (sum - target)^2, of those with a doubt rather |sum - target| beyond it (Huber),
//   with every bounded sum within its bounds; but a bound that only more than its strength would keep yields: of such, what
//   they are exceeded by costs its strength a unit. So there is always an answer, the usual one where there is one.
// Method: a primal-dual interior point, for the bounds, with weights renewed on the way, for the doubts. (Ceres, which fits
// the plan, knows bounds of single unknowns only; by penalties it took ten times as long and was not done.) Deterministic.
// Source: Nocedal and Wright 2006, chapters 16.6 and 17.2 (exact penalties); Holland and Welsch 1977.
// Cost: kMostLinearSteps sparse factorizations at most.
class LinearFit {
 public:
  // Requires: finite numbers; every unknown in a wish.
  explicit LinearFit(std::vector<double> start) : unknowns_(std::move(start)) {}

  void wish(const LinearSum& sum, double target, double weight, double doubt = 0);
  // low <= sum <= high, to within tolerance (> 0). Infinite bounds are none. strength > 0: by the sum scaled so that its
  // greatest factor is 1.
  void bound(LinearSum sum, double low, double high, double tolerance, double strength);

  void solve();
  const std::vector<double>& unknowns() const { return unknowns_; }
  double value(const LinearSum& sum) const;

 private:
  struct Wish {
    LinearSum sum;
    double target, weight, doubt;
  };
  // sum <= most
  struct Bound {
    LinearSum sum;
    double most, tolerance, strength;
  };
  friend class InteriorPoint;

  std::vector<double> unknowns_;
  std::vector<Wish> wishes_;
  std::vector<Bound> bounds_;
};
inline constexpr int kMostLinearSteps = 120;

}  // namespace roadgen
