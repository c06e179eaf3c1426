#include "roadgen/fit/curvature.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace roadgen {
namespace {

// Cosine of how far a tangent may be off its chord, 60 degrees: halves of such a segment keep to it too, so that a
// search can begin from them.
constexpr double kLeastCosine = 0.5;
constexpr int kMostStepHalvings = 20;
// A pivot smaller than this part of its row counts as none.
constexpr double kLeastPivot = 1e-9;

struct Chord {
  double length_m, heading_rad;
};

// The curvature at one end of a segment with the slopes near and far: (4 near + 2 far) / ((1 + near^2)^(3/2) L) to the
// right at the start, to the left at the end, and its derivatives by the headings.
struct EndCurvature {
  double value, by_near, by_far;

  EndCurvature(double near, double far, double length_m) {
    const double q = 1 + near * near, p = 4 * near + 2 * far, scale = 1 / (q * std::sqrt(q) * length_m);
    value = p * scale;
    by_near = (4 * q - 3 * near * p) * scale;
    by_far = 2 * (1 + far * far) * scale;
  }
};

// Row i: lower x[i - 1] + diagonal x[i] + upper x[i + 1] = right, indices cyclic where closed.
struct Row {
  double lower = 0, diagonal = 1, upper = 0, right = 0;
};

// Solves in place; the solution is in right. False where a pivot vanishes. The last unknown of a cyclic system borders
// a tridiagonal one, which is solved for the right side and for that unknown's column at once.
bool solve(std::vector<Row>& rows, bool closed) {
  const std::size_t n = rows.size() - (closed ? 1 : 0);
  std::vector<double> column(n, 0);
  if (closed) {
    column[0] += rows[0].lower;
    column[n - 1] += rows[n - 1].upper;
  }
  for (std::size_t i = 0; i < n; ++i) {
    Row& row = rows[i];
    const double size = std::abs(row.lower) + std::abs(row.diagonal) + std::abs(row.upper);
    if (i > 0) {
      const double factor = row.lower / rows[i - 1].diagonal;
      row.diagonal -= factor * rows[i - 1].upper;
      row.right -= factor * rows[i - 1].right;
      column[i] -= factor * column[i - 1];
    }
    if (!(std::abs(row.diagonal) > kLeastPivot * size)) return false;
  }
  for (std::size_t i = n; i-- > 0;) {
    Row& row = rows[i];
    if (i + 1 < n) {
      row.right -= row.upper * rows[i + 1].right;
      column[i] -= row.upper * column[i + 1];
    }
    row.right /= row.diagonal;
    column[i] /= row.diagonal;
  }
  if (!closed) return true;
  Row& last = rows[n];
  const double size = std::abs(last.lower) + std::abs(last.diagonal) + std::abs(last.upper);
  const double pivot = last.diagonal - last.lower * column[n - 1] - last.upper * column[0];
  if (!(std::abs(pivot) > kLeastPivot * size)) return false;
  last.right = (last.right - last.lower * rows[n - 1].right - last.upper * rows[0].right) / pivot;
  for (std::size_t i = 0; i < n; ++i) rows[i].right -= column[i] * last.right;
  return true;
}

class Chain {
 public:
  Chain(std::span<const glm::dvec2> points_m, std::span<const char> fixed, bool closed)
      : fixed_(fixed), closed_(closed), rows_(points_m.size()) {
    for (std::size_t i = 0; i + (closed ? 0 : 1) < points_m.size(); ++i) {
      const glm::dvec2 d = points_m[next(i)] - points_m[i];
      chords_.push_back({std::hypot(d.x, d.y), std::atan2(d.y, d.x)});
    }
  }

  // Sets up the rows of Newton's step; false where a tangent is too far off its chord.
  bool linearize(std::span<const double> headings_rad) {
    std::fill(rows_.begin(), rows_.end(), Row{0, 0, 0, 0});
    for (std::size_t k = 0; k < chords_.size(); ++k) {
      const std::size_t j = next(k);
      const auto [length, heading] = chords_[k];
      const double from = std::remainder(headings_rad[k] - heading, 2 * M_PI);
      const double to = std::remainder(headings_rad[j] - heading, 2 * M_PI);
      if (!(std::cos(from) > kLeastCosine && std::cos(to) > kLeastCosine)) return false;
      const double a = std::tan(from), b = std::tan(to);
      const EndCurvature start(a, b, length), end(b, a, length);
      rows_[k].right -= start.value;
      rows_[k].diagonal += start.by_near;
      rows_[k].upper += start.by_far;
      rows_[j].right -= end.value;
      rows_[j].diagonal += end.by_near;
      rows_[j].lower += end.by_far;
    }
    squares_ = greatest_ = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (fixed_[i]) rows_[i] = Row{};
      const double turn = std::abs(rows_[i].right) * reach_m(i);
      squares_ += turn * turn;
      if (turn > greatest_) greatest_ = turn, worst_ = i;
    }
    return true;
  }

  bool step() { return solve(rows_, closed_); }
  const std::vector<Row>& rows() const { return rows_; }
  double squares() const { return squares_; }
  double greatest() const { return greatest_; }
  std::size_t worst() const { return worst_; }

 private:
  std::size_t next(std::size_t i) const { return i + 1 == rows_.size() ? 0 : i + 1; }
  // The longer of the segments at a point.
  double reach_m(std::size_t i) const {
    const bool starts = i<chords_.size(), ends = i> 0 || closed_;
    const double ahead = starts ? chords_[i].length_m : 0;
    return std::max(ahead, ends ? chords_[i == 0 ? chords_.size() - 1 : i - 1].length_m : 0);
  }

  std::span<const char> fixed_;
  bool closed_;
  std::vector<Chord> chords_;
  std::vector<Row> rows_;
  double squares_ = 0, greatest_ = 0;  // of the jumps of curvature times the length of the segment there
  std::size_t worst_ = 0;
};

}  // namespace

std::optional<std::size_t> equalize_curvature(std::span<const glm::dvec2> points_m, std::span<const char> fixed,
                                              bool closed, std::span<double> headings_rad) {
  assert(points_m.size() >= 2 && fixed.size() == points_m.size() && headings_rad.size() == points_m.size());
  Chain chain(points_m, fixed, closed);
  std::vector<double> at(headings_rad.begin(), headings_rad.end()), tried(at.size());
  if (!chain.linearize(at)) return 0;
  for (int i = 0; i < kMostCurvatureSteps; ++i) {
    if (chain.greatest() <= kCurvatureResidual) {
      std::copy(at.begin(), at.end(), headings_rad.begin());
      return std::nullopt;
    }
    const double before = chain.squares();
    const std::size_t worst = chain.worst();
    if (!chain.step()) return worst;
    std::vector<double> step;
    for (const Row& row : chain.rows()) step.push_back(row.right);
    bool better = false;
    for (int halvings = 0; !better && halvings < kMostStepHalvings; ++halvings) {
      const double share = std::ldexp(1, -halvings);
      for (std::size_t k = 0; k < at.size(); ++k) tried[k] = at[k] + share * step[k];
      better = chain.linearize(tried) && chain.squares() < before;
    }
    if (!better) return worst;
    std::swap(at, tried);
  }
  return chain.worst();
}

}  // namespace roadgen
