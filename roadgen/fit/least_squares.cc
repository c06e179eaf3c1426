#include "roadgen/fit/least_squares.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <ceres/ceres.h>

#include "shaders/lib/glsl.h"

namespace roadgen {
namespace {

// Cosine of the angle off the chord from which on a tangent makes no usable graph cubic.
constexpr double kLeastCosine = 0.25;
// Joints move by at most this share of the shorter chord beside them, along either axis.
constexpr double kMostShift = 0.25;
// Joints up to which a dense factorization takes less time than a sparse one.
constexpr std::size_t kMostDense = 16;

using std::isfinite;

// Derivatives by the parameters of the two joints, and by the arguments (x, y, a, b) of the road function.
using JointJet = ceres::Jet<double, 6>;
using RoadJet = ceres::Jet<double, 4>;

double scalar(double x) { return x; }
double scalar(const JointJet& x) { return x.a; }

// The graph cubic between two joints, each (x, y, heading).
template <class Real>
struct Graph {
  Real length, slope_start, slope_end;
  bool usable = false;

  Graph(const Real* from, const Real* to) {
    using std::cos, std::sin, std::sqrt;
    const Real x = to[0] - from[0], y = to[1] - from[1], length2 = x * x + y * y;
    if (!(scalar(length2) > 0)) return;
    length = sqrt(length2);
    const auto slope = [&](const Real& heading, Real& out) {
      const Real c = cos(heading), s = sin(heading), along = x * c + y * s;
      if (!(scalar(along) > kLeastCosine * scalar(length))) return false;
      out = (x * s - y * c) / along;
      return true;
    };
    usable = slope(from[2], slope_start) && slope(to[2], slope_end);
  }
};

// A point in the chord frame of two joints.
struct ChordPoint {
  double x, y;
  glm::dvec2 x_by_end, y_by_end;      // derivatives by the position of the end joint
  glm::dvec2 x_by_start, y_by_start;  // and of the start joint

  ChordPoint(glm::dvec2 point, glm::dvec2 start, glm::dvec2 end) {
    const glm::dvec2 c = end - start, d = point - start;
    const double length2 = c.x * c.x + c.y * c.y;
    x = (d.x * c.x + d.y * c.y) / length2;
    y = (d.y * c.x - d.x * c.y) / length2;
    x_by_end = (d - 2 * x * c) / length2;
    y_by_end = (glm::dvec2(d.y, -d.x) - 2 * y * c) / length2;
    // Moving both joints moves the point the other way, by 1 / L along and across the chord.
    x_by_start = -x_by_end - c / length2;
    y_by_start = -y_by_end - glm::dvec2(-c.y, c.x) / length2;
  }
};

// weight * v of all samples of a segment; parameters: the two joints.
class DistanceCost : public ceres::CostFunction {
 public:
  explicit DistanceCost(SegmentSamples samples) : samples_(samples) {
    set_num_residuals(static_cast<int>(samples.position_m.size()));
    *mutable_parameter_block_sizes() = {3, 3};
  }

  bool Evaluate(const double* const* joints, double* residuals, double** jacobians) const override {
    const glm::dvec2 start(joints[0][0], joints[0][1]), end(joints[1][0], joints[1][1]);
    JointJet from[3], to[3];
    for (int i = 0; i < 3; ++i) {
      from[i] = JointJet(joints[0][i], i);
      to[i] = JointJet(joints[1][i], i + 3);
    }
    const Graph<JointJet> graph(from, to);
    if (!graph.usable) return false;
    for (std::size_t k = 0; k < samples_.position_m.size(); ++k) {
      const ChordPoint p(samples_.position_m[k], start, end);
      const double scale = samples_.weight[k] * graph.length.a;
      if (!jacobians) {
        residuals[k] = scale * glsl::Library<double>::road_project(p.x, p.y, graph.slope_start.a, graph.slope_end.a).v;
        if (!std::isfinite(residuals[k])) return false;
        continue;
      }
      const RoadJet v =
          glsl::Library<RoadJet>::road_project(RoadJet(p.x, 0), RoadJet(p.y, 1), RoadJet(graph.slope_start.a, 2),
                                               RoadJet(graph.slope_end.a, 3))
              .v;
      residuals[k] = scale * v.a;
      if (!std::isfinite(v.a)) return false;
      // The chain rule, from the arguments of the road function to the joints.
      Eigen::Matrix<double, 6, 1> g = v.v[2] * graph.slope_start.v + v.v[3] * graph.slope_end.v;
      g[0] += v.v[0] * p.x_by_start.x + v.v[1] * p.y_by_start.x;
      g[1] += v.v[0] * p.x_by_start.y + v.v[1] * p.y_by_start.y;
      g[3] += v.v[0] * p.x_by_end.x + v.v[1] * p.y_by_end.x;
      g[4] += v.v[0] * p.x_by_end.y + v.v[1] * p.y_by_end.y;
      g = scale * g + samples_.weight[k] * v.a * graph.length.v;
      // Far from the footprint equation 3 has no root, and its square root no slope: such a sample does not pull.
      if (!g.allFinite()) g.setZero();
      for (int i = 0; i < 6; ++i) {
        if (double* block = jacobians[i / 3]) block[3 * k + i % 3] = g[i];
      }
    }
    return true;
  }

 private:
  SegmentSamples samples_;
};

// Shift of a joint along its tangent at the start.
struct SlideCost {
  glm::dvec2 position_m, along;  // along: the tangent times the weight

  template <class T>
  bool operator()(const T* joint, T* residual) const {
    *residual = (joint[0] - position_m.x) * along.x + (joint[1] - position_m.y) * along.y;
    return true;
  }
};

// Angles of the tangents off the chord, and how its direction turns with the joint at its end (with the one at its start
// the other way). For small angles the curvatures at the ends are -(4 start + 2 end) / L and (2 start + 4 end) / L; angles
// stay finite where slopes do not. L is kept from the start: else sliding the joints together would be rewarded.
struct ChordAngles {
  double start, end;
  glm::dvec2 turn;

  ChordAngles(const double* from, const double* to) {
    const double x = to[0] - from[0], y = to[1] - from[1], direction = std::atan2(y, x);
    start = std::remainder(from[2] - direction, 2 * std::numbers::pi);
    end = std::remainder(to[2] - direction, 2 * std::numbers::pi);
    turn = glm::dvec2(-y, x) / (x * x + y * y);
  }
};

// L L' times the jump of curvature at the middle one of three joints.
class CurvatureCost : public ceres::SizedCostFunction<1, 3, 3, 3> {
 public:
  CurvatureCost(double weight, double in_m, double out_m) : in_(weight * in_m), out_(weight * out_m) {}

  bool Evaluate(const double* const* joints, double* residual, double** jacobians) const override {
    const ChordAngles in(joints[0], joints[1]), out(joints[1], joints[2]);
    *residual = (4 * out.start + 2 * out.end) * in_ + (2 * in.start + 4 * in.end) * out_;
    if (!std::isfinite(*residual)) return false;
    if (!jacobians) return true;
    const glm::dvec2 before = 6 * out_ * in.turn, after = -6 * in_ * out.turn, joint = -before - after;
    const auto set = [&](int i, glm::dvec2 by_position, double by_heading) {
      if (jacobians[i]) jacobians[i][0] = by_position.x, jacobians[i][1] = by_position.y, jacobians[i][2] = by_heading;
    };
    set(0, before, 2 * out_);
    set(1, joint, 4 * (in_ + out_));
    set(2, after, 2 * in_);
    return true;
  }

 private:
  double in_, out_;
};

// L^2 times the change of curvature along a segment: 0 for an arc.
class ArcCost : public ceres::SizedCostFunction<1, 3, 3> {
 public:
  explicit ArcCost(double weighted_length_m) : factor_(6 * weighted_length_m) {}

  bool Evaluate(const double* const* joints, double* residual, double** jacobians) const override {
    const ChordAngles angles(joints[0], joints[1]);
    *residual = (angles.start + angles.end) * factor_;
    if (!std::isfinite(*residual)) return false;
    for (int i = 0; jacobians && i < 2; ++i) {
      if (!jacobians[i]) continue;
      const glm::dvec2 by_position = (i == 0 ? 2 : -2) * factor_ * angles.turn;
      jacobians[i][0] = by_position.x, jacobians[i][1] = by_position.y, jacobians[i][2] = factor_;
    }
    return true;
  }

 private:
  double factor_;
};

// Joints as Ceres' parameter blocks.
class Chain {
 public:
  Chain(std::span<Joint> joints, bool closed, double max_error_m)
      : joints_(joints), closed_(closed), max_error_m_(max_error_m), blocks_(3 * joints.size()) {
    for (std::size_t i = 0; i < joints.size(); ++i) {
      const Joint& j = joints[i];
      double* b = block(i);
      b[0] = j.position_m.x, b[1] = j.position_m.y, b[2] = j.heading_rad;
      problem_.AddParameterBlock(b, 3);
      if (j.fixed_position && j.fixed_heading) {
        problem_.SetParameterBlockConstant(b);
      } else if (j.fixed_position) {
        problem_.SetManifold(b, new ceres::SubsetManifold(3, {0, 1}));
      } else if (j.fixed_heading) {
        problem_.SetManifold(b, new ceres::SubsetManifold(3, {2}));
      }
    }
  }

  void add_samples(std::span<const SegmentSamples> segments) {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      double *from = block(i), *to = block(i + 1);
      const bool constant = is_constant(i) && is_constant(i + 1);
      if (constant || segments[i].position_m.empty() || !Graph<double>(from, to).usable) continue;
      problem_.AddResidualBlock(new DistanceCost(segments[i]), nullptr, from, to);
    }
  }

  void add_regularity(std::size_t segment_count) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (joints_[i].fixed_position) continue;
      const double heading = joints_[i].heading_rad;
      const SlideCost slide{joints_[i].position_m, kSlideWeight * glm::dvec2(std::cos(heading), std::sin(heading))};
      problem_.AddResidualBlock(new ceres::AutoDiffCostFunction<SlideCost, 1, 3>(new SlideCost(slide)), nullptr,
                                block(i));
    }
    for (std::size_t i = 0; i < segment_count; ++i) {
      if (is_constant(i) && is_constant(i + 1)) continue;
      problem_.AddResidualBlock(new ArcCost(max_error_m_ / kArcScale_m * length_m(i)), nullptr, block(i), block(i + 1));
      if ((!closed_ && i + 1 == segment_count) || joints_.size() < 3) continue;
      problem_.AddResidualBlock(new CurvatureCost(max_error_m_ / kCurvatureScale_m, length_m(i), length_m(i + 1)),
                                nullptr, block(i), block(i + 1), block(i + 2));
    }
  }

  // No joint may run past its neighbours, whatever the samples say. Hardly any would: bounds, which cost a search along
  // every step, are set where one has.
  void solve(std::size_t segment_count) {
    const std::vector<double> start = blocks_, room_m = rooms_m(segment_count);
    if (!try_solve()) return;
    if (!is_within(start, room_m)) {
      blocks_ = start;
      set_bounds(room_m);
      if (!try_solve()) return;
    }
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const double* b = block(i);
      joints_[i].position_m = {b[0], b[1]};
      joints_[i].heading_rad = std::remainder(b[2], 2 * std::numbers::pi);
    }
  }

 private:
  double* block(std::size_t i) { return &blocks_[3 * (i % joints_.size())]; }
  double length_m(std::size_t i) {
    const double *from = block(i), *to = block(i + 1);
    return std::hypot(to[0] - from[0], to[1] - from[1]);
  }
  // How far each joint may move along either axis.
  std::vector<double> rooms_m(std::size_t segment_count) {
    std::vector<double> room_m(joints_.size(), std::numeric_limits<double>::infinity());
    for (std::size_t i = 0; i < segment_count; ++i) {
      double &from = room_m[i], &to = room_m[(i + 1) % joints_.size()];
      from = std::min(from, kMostShift * length_m(i));
      to = std::min(to, kMostShift * length_m(i));
    }
    return room_m;
  }
  bool is_within(const std::vector<double>& start, const std::vector<double>& room_m) const {
    for (std::size_t i = 0; i < 3 * joints_.size(); ++i) {
      if (i % 3 < 2 && !(std::abs(blocks_[i] - start[i]) <= room_m[i / 3])) return false;
    }
    return true;
  }
  void set_bounds(const std::vector<double>& room_m) {
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      if (joints_[i].fixed_position) continue;
      for (int axis = 0; axis < 2; ++axis) {
        problem_.SetParameterLowerBound(block(i), axis, block(i)[axis] - room_m[i]);
        problem_.SetParameterUpperBound(block(i), axis, block(i)[axis] + room_m[i]);
      }
    }
  }
  bool try_solve() {
    ceres::Solver::Options options;
    options.linear_solver_type =
        joints_.size() <= kMostDense ? ceres::DENSE_NORMAL_CHOLESKY : ceres::SPARSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 8;
    options.function_tolerance = 1e-4;
    options.logging_type = ceres::SILENT;
    options.num_threads = 1;  // sums in one order: the same input gives the same road
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem_, &summary);
    return summary.IsSolutionUsable();
  }
  bool is_constant(std::size_t i) const {
    const Joint& j = joints_[i % joints_.size()];
    return j.fixed_position && j.fixed_heading;
  }

  std::span<Joint> joints_;
  bool closed_;
  double max_error_m_;
  std::vector<double> blocks_;
  ceres::Problem problem_;
};

}  // namespace

void solve_joints(std::span<Joint> joints, std::span<const SegmentSamples> segments, bool closed, double max_error_m) {
  assert(segments.size() + (closed ? 0 : 1) == joints.size());
  Chain chain(joints, closed, max_error_m);
  chain.add_samples(segments);
  chain.add_regularity(segments.size());
  chain.solve(segments.size());
}

}  // namespace roadgen
