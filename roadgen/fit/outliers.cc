#include "roadgen/fit/outliers.h"

#include <algorithm>
#include <cmath>

#include <ceres/ceres.h>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

struct SampleCost {
  glm::dvec2 sample_m;
  template <class T>
  bool operator()(const T* point, T* residual) const {
    residual[0] = point[0] - sample_m.x;
    residual[1] = point[1] - sample_m.y;
    return true;
  }
};

// A linear combination of four points.
struct BendCost {
  double factor[4];
  template <class T>
  bool operator()(const T* a, const T* b, const T* c, const T* d, T* residual) const {
    for (int i = 0; i < 2; ++i) residual[i] = factor[0] * a[i] + factor[1] * b[i] + factor[2] * c[i] + factor[3] * d[i];
    return true;
  }
};

constexpr std::size_t kLeastSamples = 5, kNeighbours = 4;
constexpr int kMostRounds = 20;
constexpr double kLeastStep_m = 0.01;  // of the course, however its points are pushed together

// Moves the points to the course of those that stay.
void smooth(const std::vector<glm::dvec2>& measured, const std::vector<std::size_t>& staying, bool closed,
            double max_error_m, std::vector<glm::dvec2>& points) {
  const std::size_t m = staying.size();
  ceres::Problem::Options shared;
  shared.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::HuberLoss huber(max_error_m);
  ceres::Problem problem(shared);
  for (const std::size_t i : staying) {
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<SampleCost, 2, 2>(new SampleCost{measured[i]}), &huber,
                             &points[i].x);
  }
  for (std::size_t k = 0; k + (closed ? 0 : 3) < m; ++k) {
    glm::dvec2* const p[4] = {&points[staying[k]], &points[staying[(k + 1) % m]], &points[staying[(k + 2) % m]],
                              &points[staying[(k + 3) % m]]};
    double s[4] = {0, 0, 0, 0};
    for (int i = 1; i < 4; ++i) s[i] = s[i - 1] + std::max(glm::distance(*p[i], *p[i - 1]), kLeastStep_m);
    const double h = s[3] / 3, h3 = h * h * h;
    const double scale = 6 * h3 / std::max(1.0, kMostCurvatureChange_per_m2 * h3 / max_error_m);
    BendCost* const bend = new BendCost;  // Ceres takes ownership
    for (int i = 0; i < 4; ++i) {
      double product = 1;  // Lagrange's weights of the third divided difference
      for (int l = 0; l < 4; ++l) product *= l == i ? 1 : s[i] - s[l];
      bend->factor[i] = scale / product;
    }
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<BendCost, 2, 2, 2, 2, 2>(bend), nullptr, &p[0]->x,
                             &p[1]->x, &p[2]->x, &p[3]->x);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 25;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;  // the same samples, the same answer
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

// Whether a point lies about as far from a to b as it should, and not far beside that line.
bool on_course(glm::dvec2 p, glm::dvec2 a, glm::dvec2 b, double share, double half_step, double limit_m) {
  const glm::dvec2 d = b - a;
  const double length2 = std::max(glm::dot(d, d), 1e-30), t = glm::dot(p - a, d) / length2;
  return std::abs(t - share) <= half_step && glm::distance(p, a + t * d) <= limit_m;
}

}  // namespace

std::vector<char> find_outliers(std::span<const glm::dvec2> samples, bool closed, double max_error_m) {
  const double limit_m = kOutlier * max_error_m;
  std::vector<glm::dvec2> measured;  // from the first, for precision
  std::vector<std::size_t> staying;
  for (const glm::dvec2& p : samples) {
    staying.push_back(measured.size());
    measured.push_back(p - samples[0]);
  }
  std::vector<glm::dvec2> points;
  for (int round = 0; round < kMostRounds && staying.size() >= kLeastSamples; ++round) {
    const std::size_t m = staying.size();
    points = measured;
    smooth(measured, staying, closed, max_error_m, points);
    const auto off_m = [&](std::size_t k) { return glm::distance(points[staying[k]], measured[staying[k]]); };
    // What is off pulls its neighbours with it: the farthest of them goes first.
    std::vector<std::size_t> stay;
    for (std::size_t k = 0; k < m; ++k) {
      bool farthest = off_m(k) > limit_m;
      for (std::size_t i = 1; farthest && i <= kNeighbours; ++i) {
        if (closed || k + i < m) farthest = off_m(k) >= off_m((k + i) % m);
        if (farthest && (closed || k >= i)) farthest = off_m(k) > off_m((k + m - i) % m);
      }
      if (!farthest) stay.push_back(staying[k]);
    }
    if (stay.size() == m) break;
    staying = std::move(stay);
  }
  std::vector<char> outlier(samples.size(), 1);
  for (const std::size_t i : staying) outlier[i] = 0;
  // What was left out beside something worse may lie on the course of the rest.
  for (std::size_t k = 0; k + (closed ? 0 : 1) < staying.size(); ++k) {
    const std::size_t from = staying[k], to = staying[(k + 1) % staying.size()], n = samples.size();
    const std::size_t steps = (to + n - from) % n;
    for (std::size_t step = 1; step < steps; ++step) {
      const double share = static_cast<double>(step) / static_cast<double>(steps);
      const std::size_t i = (from + step) % n;
      outlier[i] = !on_course(measured[i], points[from], points[to], share, 0.5 / static_cast<double>(steps), limit_m);
    }
  }
  return outlier;
}

}  // namespace roadgen
