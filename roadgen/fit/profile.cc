#include "roadgen/fit/profile.h"

#include <algorithm>
#include <cmath>

#include <glm/mat2x2.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include "roadgen/road/segment.h"

namespace roadgen {
namespace {

// Greatest and least weight of the second derivative, m^3.
constexpr double kGreatestLambda = 1e7;
constexpr double kLeastLambda = 1e-2;
// Weight of the grade: it levels what lies beyond the samples, and bends what lies between them by no more than the
// grade times the root of this and the samples' distance.
constexpr double kGradeWeight_m = 0.02;

// Values at one place of the four Hermite functions: height and grade at the knot before, and at the knot after.
struct Basis {
  glm::dvec2 before, after;
};

Basis basis(double x, double length_m) {
  const double w = 1 - x;
  return {{w * w * (1 + 2 * x), length_m * x * w * w}, {x * x * (3 - 2 * x), -length_m * x * x * w}};
}

// Unknowns are (z, grade) at every knot, so the normal matrix is block tridiagonal: diagonal[i] at knot i, and
// right[i] couples knot i (rows) with the knot after it (columns).
struct Normal {
  std::vector<glm::dmat2> diagonal, right;
  std::vector<glm::dvec2> rhs;

  // Adds weight * (row . unknowns - target)^2, where the row touches knots i and next.
  void add(std::size_t i, std::size_t next, const Basis& row, double target, double weight) {
    diagonal[i] += weight * glm::outerProduct(row.before, row.before);
    diagonal[next] += weight * glm::outerProduct(row.after, row.after);
    right[i] += weight * glm::outerProduct(row.before, row.after);
    rhs[i] += weight * target * row.before;
    rhs[next] += weight * target * row.after;
  }
};

// Three right-hand sides at once: the loop's closure needs two more than the data.
struct Columns {
  glm::dvec2 data{0};
  glm::dmat2 closure{0};
};

// Block elimination without pivoting, which a positive definite matrix does not need. On a loop the last knot is
// eliminated last: the others are solved for their dependence on it first.
std::vector<glm::dvec2> solve(const Normal& n, bool closed) {
  const std::size_t m = n.diagonal.size(), chain = closed ? m - 1 : m;
  std::vector<glm::dmat2> factor(chain);  // inverse of the eliminated diagonal
  std::vector<Columns> x(chain);
  for (std::size_t i = 0; i < chain; ++i) {
    x[i].data = n.rhs[i];
    if (closed && i == 0) x[i].closure += glm::transpose(n.right[m - 1]);
    if (closed && i + 1 == chain) x[i].closure += n.right[i];
    glm::dmat2 d = n.diagonal[i];
    if (i > 0) {
      const glm::dmat2 lower = glm::transpose(n.right[i - 1]) * factor[i - 1];
      d -= lower * n.right[i - 1];
      x[i].data -= lower * x[i - 1].data;
      x[i].closure -= lower * x[i - 1].closure;
    }
    factor[i] = glm::inverse(d);
  }
  for (std::size_t i = chain; i-- > 0;) {
    if (i + 1 < chain) {
      x[i].data -= n.right[i] * x[i + 1].data;
      x[i].closure -= n.right[i] * x[i + 1].closure;
    }
    x[i].data = factor[i] * x[i].data;
    x[i].closure = factor[i] * x[i].closure;
  }
  std::vector<glm::dvec2> solution(m);
  if (closed) {
    // The last knot's own equation, with the others expressed by it.
    const glm::dmat2 to_first = n.right[m - 1], to_before = glm::transpose(n.right[m - 2]);
    const glm::dmat2 d = n.diagonal[m - 1] - to_first * x.front().closure - to_before * x.back().closure;
    const glm::dvec2 r = n.rhs[m - 1] - to_first * x.front().data - to_before * x.back().data;
    solution[m - 1] = glm::inverse(d) * r;
  }
  for (std::size_t i = 0; i < chain; ++i) {
    solution[i] = x[i].data - (closed ? x[i].closure * solution[m - 1] : glm::dvec2(0));
  }
  return solution;
}

class Profile {
 public:
  Profile(std::span<const double> knots_m, bool closed, double length_m)
      : knots_m_(knots_m), closed_(closed), length_m_(length_m) {}

  struct Place {
    std::size_t knot, next;
    double x, length_m;  // x in [0, 1] between them
  };

  Place place(double s_m) const {
    const auto after = std::upper_bound(knots_m_.begin(), knots_m_.end(), s_m);
    const std::size_t m = knots_m_.size();
    std::size_t knot = after == knots_m_.begin() ? 0 : static_cast<std::size_t>(after - knots_m_.begin()) - 1;
    if (!closed_) knot = std::min(knot, m - 2);
    const double length = length_after(knot);
    return {knot, knot + 1 == m ? 0 : knot + 1, std::clamp((s_m - knots_m_[knot]) / length, 0.0, 1.0), length};
  }

  ProfileFit fit(std::span<const HeightSample> samples, std::span<const double> lambda) const {
    const std::size_t m = knots_m_.size();
    Normal n{std::vector<glm::dmat2>(m, glm::dmat2(0)), std::vector<glm::dmat2>(m, glm::dmat2(0)),
             std::vector<glm::dvec2>(m, glm::dvec2(0))};
    const double base = samples.empty() ? 0 : samples.front().z_m;  // keeps the numbers small
    for (const HeightSample& sample : samples) {
      const Place p = place(sample.s_m);
      n.add(p.knot, p.next, basis(p.x, p.length_m), sample.z_m - base, 1);
    }
    for (std::size_t i = 0; i < (closed_ ? m : m - 1); ++i) {
      add_bending(n, i, lambda[i]);
      add_grade(n, i);
    }
    // A trace of pull to level ground, for a loop without samples.
    for (glm::dmat2& d : n.diagonal) d += glm::dmat2(1e-9, 0, 0, 1e-9);
    const std::vector<glm::dvec2> unknowns = solve(n, closed_);
    ProfileFit fit;
    for (const glm::dvec2 u : unknowns) {
      fit.z_m.push_back(u.x + base);
      fit.grade.push_back(u.y);
    }
    for (const HeightSample& sample : samples) {
      const Place p = place(sample.s_m);
      const Cubic c =
          Cubic::hermite(fit.z_m[p.knot], fit.grade[p.knot], fit.z_m[p.next], fit.grade[p.next], p.length_m);
      fit.error_m.push_back(std::abs(c.value(p.x * p.length_m) - sample.z_m));
      fit.max_error_m = std::max(fit.max_error_m, fit.error_m.back());
    }
    return fit;
  }

 private:
  double length_after(std::size_t knot) const {
    return knot + 1 < knots_m_.size() ? knots_m_[knot + 1] - knots_m_[knot] : length_m_ - knots_m_[knot] + knots_m_[0];
  }

  // lambda times the integral of z''^2, exactly: z'' is linear, so the integral is h (mean^2 + difference^2 / 12).
  void add_bending(Normal& n, std::size_t i, double lambda) const {
    const double h = length_after(i);
    const Basis first{{-6 / (h * h), -4 / h}, {6 / (h * h), -2 / h}}, last{{6 / (h * h), 2 / h}, {-6 / (h * h), 4 / h}};
    const Basis mean{0.5 * (first.before + last.before), 0.5 * (first.after + last.after)};
    const Basis difference{last.before - first.before, last.after - first.after};
    const std::size_t next = i + 1 == knots_m_.size() ? 0 : i + 1;
    n.add(i, next, mean, 0, lambda * h);
    n.add(i, next, difference, 0, lambda * h / 12);
  }

  // kGradeWeight_m times the integral of z'^2, by Gauss's rule with three points, which is exact.
  void add_grade(Normal& n, std::size_t i) const {
    const double h = length_after(i);
    const std::size_t next = i + 1 == knots_m_.size() ? 0 : i + 1;
    for (const double node : {-1.0, 0.0, 1.0}) {
      const double x = 0.5 + node * 0.5 * std::sqrt(0.6), w = 1 - x, weight = (node == 0 ? 8 : 5) / 18.0;
      const Basis slope{{-6 * x * w / h, w * (w - 2 * x)}, {6 * x * w / h, x * (x - 2 * w)}};
      n.add(i, next, slope, 0, kGradeWeight_m * weight * h);
    }
  }

  std::span<const double> knots_m_;
  bool closed_;
  double length_m_;
};

}  // namespace

std::vector<char> plausible_heights(std::span<const HeightSample> samples, double max_error_m) {
  const std::size_t n = samples.size();
  // The longest chain that ends at each sample, and the sample before it there.
  std::vector<int> length(n, 1);
  std::vector<std::size_t> before(n, n);
  for (std::size_t i = 1; i < n; ++i) {
    for (std::size_t j = i - std::min(i, kStepReach); j < i; ++j) {
      const double run = std::abs(samples[i].s_m - samples[j].s_m), rise = std::abs(samples[i].z_m - samples[j].z_m);
      const int cost = rise <= kSteepestGrade * run + 2 * max_error_m ? 0 : kStepCost;
      if (length[j] + 1 - cost <= length[i]) continue;
      length[i] = length[j] + 1 - cost;
      before[i] = j;
    }
  }
  std::vector<char> plausible(n, 0);
  if (n == 0) return plausible;
  std::size_t i = static_cast<std::size_t>(std::max_element(length.begin(), length.end()) - length.begin());
  for (; i < n; i = before[i]) plausible[i] = 1;
  return plausible;
}

ProfileFit fit_profile(std::span<const double> knots_m, std::span<const HeightSample> samples, bool closed,
                       double length_m, double max_error_m) {
  const Profile profile(knots_m, closed, length_m);
  const std::size_t m = knots_m.size();
  std::vector<double> lambda(m, kGreatestLambda);
  for (;;) {
    ProfileFit fit = profile.fit(samples, lambda);
    std::vector<char> softer(m, 0);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      if (fit.error_m[i] > max_error_m) softer[profile.place(samples[i].s_m).knot] = 1;
    }
    bool changed = false;
    for (std::size_t i = 0; i < m; ++i) {
      // The neighbours yield too: a bend at a knot takes both sides.
      const std::size_t before = i > 0 ? i - 1 : closed ? m - 1 : 0, after = i + 1 < m ? i + 1 : closed ? 0 : i;
      if (!(softer[i] || softer[before] || softer[after]) || lambda[i] <= kLeastLambda) continue;
      lambda[i] /= 10;
      changed = true;
    }
    if (!changed) return fit;
  }
}

}  // namespace roadgen
