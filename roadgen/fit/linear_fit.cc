#include "roadgen/fit/linear_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/SparseCholesky>

namespace roadgen {
namespace {

using Matrix = Eigen::SparseMatrix<double>;
using Vector = Eigen::VectorXd;

constexpr double kCentering = 0.15;  // of the mean product of a bound's room and force, each step
constexpr double kToBorder = 0.95;   // part of the way to where a room or a force would be 0
constexpr double kSettled = 1e-7;    // of the greatest strength: what that product ends at
constexpr int kFreeSteps = 25;       // from then on doubts are no longer renewed

}  // namespace

// What a bound's numbers are: sum + room = most + excess; 0 <= force <= strength.
class InteriorPoint {
 public:
  explicit InteriorPoint(LinearFit& fit) : fit_(fit), size_(static_cast<Eigen::Index>(fit.unknowns_.size())) {}
  void run();

 private:
  struct State {
    double room, excess, force;
    double step_room = 0, step_excess = 0, step_force = 0;
  };
  void find_pattern();
  void add_square(const LinearSum& sum, double weight, std::size_t& next);
  void weigh();
  bool factorize();
  void start();
  double gap() const;
  bool step(double target);
  bool is_settled() const;

  LinearFit& fit_;
  Eigen::Index size_;
  Matrix matrix_;                    // lower triangle
  std::vector<Eigen::Index> where_;  // in its values, of every product of two terms of a wish or bound
  Eigen::SimplicialLDLT<Matrix, Eigen::Lower> solver_;
  std::vector<double> weight_;  // of the wishes, doubts counted
  std::vector<State> state_;    // of the bounds
};

void InteriorPoint::find_pattern() {
  std::vector<Eigen::Triplet<double>> entries;
  const auto each_pair = [&](const auto& visit) {
    const auto all = [&](const LinearSum& sum) {
      for (const auto& a : sum.terms) {
        for (const auto& b : sum.terms) {
          if (a.unknown >= b.unknown) visit(static_cast<Eigen::Index>(a.unknown), static_cast<Eigen::Index>(b.unknown));
        }
      }
    };
    for (const auto& wish : fit_.wishes_) all(wish.sum);
    for (const auto& bound : fit_.bounds_) all(bound.sum);
  };
  each_pair([&](Eigen::Index row, Eigen::Index column) { entries.emplace_back(row, column, 1.0); });
  for (Eigen::Index i = 0; i < size_; ++i) entries.emplace_back(i, i, 1.0);
  matrix_.resize(size_, size_);
  matrix_.setFromTriplets(entries.begin(), entries.end());
  matrix_.makeCompressed();
  each_pair([&](Eigen::Index row, Eigen::Index column) {
    const auto* first = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column];
    const auto* last = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[column + 1];
    where_.push_back(std::lower_bound(first, last, row) - matrix_.innerIndexPtr());
  });
  solver_.analyzePattern(matrix_);
}

void InteriorPoint::add_square(const LinearSum& sum, double weight, std::size_t& next) {
  for (const auto& a : sum.terms) {
    for (const auto& b : sum.terms) {
      if (a.unknown >= b.unknown) matrix_.valuePtr()[where_[next++]] += weight * a.factor * b.factor;
    }
  }
}

// Huber's weights: as if the difference were the doubt where it is more.
void InteriorPoint::weigh() {
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    const LinearFit::Wish& wish = fit_.wishes_[i];
    const double off = wish.doubt > 0 ? std::abs(fit_.value(wish.sum) - wish.target) : 0;
    weight_[i] = off > wish.doubt ? wish.weight * wish.doubt / off : wish.weight;
  }
}

bool InteriorPoint::factorize() {
  std::fill(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros(), 0.0);
  std::size_t next = 0;
  for (std::size_t i = 0; i < weight_.size(); ++i) add_square(fit_.wishes_[i].sum, weight_[i], next);
  for (std::size_t i = 0; i < state_.size(); ++i) {
    const State& s = state_[i];
    add_square(fit_.bounds_[i].sum, 1 / (s.room / s.force + s.excess / (fit_.bounds_[i].strength - s.force)), next);
  }
  solver_.factorize(matrix_);
  return solver_.info() == Eigen::Success;
}

// From where the wishes alone lead to.
void InteriorPoint::start() {
  weight_.resize(fit_.wishes_.size());
  weigh();
  for (int i = 0; i < 5; ++i) {
    state_.clear();
    std::fill(matrix_.valuePtr(), matrix_.valuePtr() + matrix_.nonZeros(), 0.0);
    std::size_t next = 0;
    Vector right = Vector::Zero(size_);
    for (std::size_t k = 0; k < weight_.size(); ++k) {
      const LinearFit::Wish& wish = fit_.wishes_[k];
      add_square(wish.sum, weight_[k], next);
      for (const auto& term : wish.sum.terms) right[term.unknown] += weight_[k] * term.factor * wish.target;
    }
    solver_.factorize(matrix_);
    if (solver_.info() != Eigen::Success) break;
    const Vector x = solver_.solve(right);
    std::copy(x.begin(), x.end(), fit_.unknowns_.begin());
    weigh();
  }
  for (const LinearFit::Bound& bound : fit_.bounds_) {
    const double now = fit_.value(bound.sum) - bound.most;
    state_.push_back({std::max(-now, 0.1), std::max(now, 0.1), std::min(10.0, 0.5 * bound.strength)});
  }
}

double InteriorPoint::gap() const {
  double sum = 0;
  for (std::size_t i = 0; i < state_.size(); ++i) {
    const State& s = state_[i];
    sum += s.room * s.force + s.excess * (fit_.bounds_[i].strength - s.force);
  }
  return state_.empty() ? 0 : sum / static_cast<double>(2 * state_.size());
}

// Newton's step to where room * force and excess * (strength - force) are both the target.
bool InteriorPoint::step(double target) {
  if (!factorize()) return false;
  Vector right = Vector::Zero(size_);
  for (std::size_t i = 0; i < weight_.size(); ++i) {
    const LinearFit::Wish& wish = fit_.wishes_[i];
    const double pull = weight_[i] * (wish.target - fit_.value(wish.sum));
    for (const auto& term : wish.sum.terms) right[term.unknown] += pull * term.factor;
  }
  std::vector<double> lack(state_.size());
  for (std::size_t i = 0; i < state_.size(); ++i) {
    const LinearFit::Bound& bound = fit_.bounds_[i];
    const State& s = state_[i];
    const double left = bound.strength - s.force;
    const double off = bound.most + s.excess - fit_.value(bound.sum) - s.room;
    lack[i] = target / s.force - s.room - target / left + s.excess - off;
    const double push = s.force + lack[i] / (s.room / s.force + s.excess / left);
    for (const auto& term : bound.sum.terms) right[term.unknown] -= push * term.factor;
  }
  const Vector x = solver_.solve(right);
  double longest = 1;
  const auto keep_positive = [&](double value, double by) {
    if (by < 0) longest = std::min(longest, -kToBorder * value / by);
  };
  for (std::size_t i = 0; i < state_.size(); ++i) {
    const LinearFit::Bound& bound = fit_.bounds_[i];
    State& s = state_[i];
    const double left = bound.strength - s.force;
    double moved = lack[i];
    for (const auto& term : bound.sum.terms) moved += term.factor * x[term.unknown];
    s.step_force = moved / (s.room / s.force + s.excess / left);
    s.step_room = (target - s.room * s.force - s.room * s.step_force) / s.force;
    s.step_excess = (target - s.excess * left + s.excess * s.step_force) / left;
    keep_positive(s.room, s.step_room);
    keep_positive(s.excess, s.step_excess);
    keep_positive(s.force, s.step_force);
    keep_positive(left, -s.step_force);
  }
  for (Eigen::Index i = 0; i < size_; ++i) fit_.unknowns_[static_cast<std::size_t>(i)] += longest * x[i];
  for (State& s : state_) {
    s.room += longest * s.step_room;
    s.excess += longest * s.step_excess;
    s.force += longest * s.step_force;
  }
  return true;
}

bool InteriorPoint::is_settled() const {
  for (std::size_t i = 0; i < state_.size(); ++i) {
    const LinearFit::Bound& bound = fit_.bounds_[i];
    const bool yields = state_[i].force > 0.99 * bound.strength;
    if (!yields && fit_.value(bound.sum) > bound.most + bound.tolerance) return false;
  }
  return true;
}

void InteriorPoint::run() {
  find_pattern();
  start();
  double strongest = 0;
  for (const LinearFit::Bound& bound : fit_.bounds_) strongest = std::max(strongest, bound.strength);
  for (int i = 0; i < kMostLinearSteps && !state_.empty(); ++i) {
    if (i < kFreeSteps) weigh();
    const double now = gap();
    if (now < kSettled * strongest && is_settled()) return;
    if (!step(kCentering * now)) return;
  }
}

void LinearSum::add(std::uint32_t unknown, double factor) {
  const auto same = std::find_if(terms.begin(), terms.end(), [&](const Term& term) { return term.unknown == unknown; });
  if (same != terms.end()) {
    same->factor += factor;
  } else {
    terms.push_back({unknown, factor});
  }
}

void LinearSum::add(const LinearSum& other, double factor) {
  for (const Term& term : other.terms) add(term.unknown, factor * term.factor);
}

double LinearFit::value(const LinearSum& sum) const {
  double value = 0;
  for (const LinearSum::Term& term : sum.terms) value += term.factor * unknowns_[term.unknown];
  return value;
}

void LinearFit::wish(const LinearSum& sum, double target, double weight, double doubt) {
  if (weight > 0 && !sum.terms.empty()) wishes_.push_back({sum, target, weight, doubt});
}

void LinearFit::bound(LinearSum sum, double low, double high, double tolerance, double strength) {
  double most = 0;
  for (const LinearSum::Term& term : sum.terms) most = std::max(most, std::abs(term.factor));
  if (!(most > 0)) return;
  for (LinearSum::Term& term : sum.terms) term.factor /= most;
  if (std::isfinite(high)) bounds_.push_back({sum, high / most, tolerance / most, strength});
  for (LinearSum::Term& term : sum.terms) term.factor = -term.factor;
  if (std::isfinite(low)) bounds_.push_back({std::move(sum), -low / most, tolerance / most, strength});
}

void LinearFit::solve() { InteriorPoint(*this).run(); }

}  // namespace roadgen
