// The type of a quadric by the inertia of its two matrices.
#include <algorithm>
#include <array>
#include <cmath>

#include "roadgen/object/primitive.h"

namespace roadgen {
namespace {

constexpr double kZero = 1e-12;  // of the greatest eigenvalue

// How many eigenvalues of a symmetric matrix are above and below zero.
struct Inertia {
  int positive = 0, negative = 0;
  int rank() const { return positive + negative; }
  bool definite() const { return positive == 0 || negative == 0; }
};

template <int N>
using Matrix = std::array<std::array<double, N>, N>;

// Jacobi's method: rotations that take the elements off the diagonal to 0, each at most once a sweep. Ten sweeps leave
// nothing of matrices of this size. The eigenvalues come to the diagonal, their vectors are the columns of `vectors`.
template <int N>
void diagonalize(Matrix<N>& m, Matrix<N>& vectors) {
  for (int i = 0; i < N; ++i) {
    for (int k = 0; k < N; ++k) vectors[i][k] = i == k;
  }
  for (int sweep = 0; sweep < 10; ++sweep) {
    for (int i = 0; i < N; ++i) {
      for (int k = i + 1; k < N; ++k) {
        if (m[i][k] == 0) continue;
        const double angle = 0.5 * std::atan2(2 * m[i][k], m[k][k] - m[i][i]);
        const double c = std::cos(angle), s = std::sin(angle);
        const auto turn = [&](double& a, double& b) {
          const double first = c * a - s * b;
          b = s * a + c * b;
          a = first;
        };
        for (int j = 0; j < N; ++j) turn(m[i][j], m[k][j]);
        for (int j = 0; j < N; ++j) turn(m[j][i], m[j][k]);
        for (int j = 0; j < N; ++j) turn(vectors[j][i], vectors[j][k]);
      }
    }
  }
}

template <int N>
Inertia inertia(Matrix<N> m) {
  Matrix<N> vectors;
  diagonalize<N>(m, vectors);
  double greatest = 0;
  for (int i = 0; i < N; ++i) greatest = std::max(greatest, std::abs(m[i][i]));
  Inertia result;
  for (int i = 0; i < N; ++i) {
    if (std::abs(m[i][i]) <= kZero * greatest) continue;
    (m[i][i] > 0 ? result.positive : result.negative)++;
  }
  return result;
}

}  // namespace

QuadricType quadric_type(const std::array<double, 10>& q) {
  using T = QuadricType;
  const Inertia part =
      inertia<3>({{{q[0], q[3] / 2, q[4] / 2}, {q[3] / 2, q[1], q[5] / 2}, {q[4] / 2, q[5] / 2, q[2]}}});
  const Inertia all = inertia<4>({{{q[0], q[3] / 2, q[4] / 2, q[6] / 2},
                                   {q[3] / 2, q[1], q[5] / 2, q[7] / 2},
                                   {q[4] / 2, q[5] / 2, q[2], q[8] / 2},
                                   {q[6] / 2, q[7] / 2, q[8] / 2, q[9]}}});
  switch (part.rank()) {
    case 0: return q[6] == 0 && q[7] == 0 && q[8] == 0 ? T::kNothing : T::kPlane;
    case 1:
      if (all.rank() == 3) return T::kParabolicCylinder;
      if (all.rank() == 1) return T::kDoublePlane;
      return all.definite() ? T::kImaginaryPlanes : T::kParallelPlanes;
    case 2:
      if (all.rank() == 4) return part.definite() ? T::kEllipticParaboloid : T::kHyperbolicParaboloid;
      if (all.rank() == 2) return part.definite() ? T::kLine : T::kIntersectingPlanes;
      if (!part.definite()) return T::kHyperbolicCylinder;
      return all.definite() ? T::kImaginaryCylinder : T::kEllipticCylinder;
    default:
      if (all.rank() == 3) return part.definite() ? T::kPoint : T::kCone;
      if (part.definite()) return all.definite() ? T::kImaginaryEllipsoid : T::kEllipsoid;
      // Rank 4: two signs of each kind are one sheet, else two.
      return all.positive == 2 ? T::kHyperboloidOneSheet : T::kHyperboloidTwoSheets;
  }
}

QuadricAxes quadric_axes(const std::array<double, 10>& q) {
  Matrix<3> m = {{{q[0], q[3] / 2, q[4] / 2}, {q[3] / 2, q[1], q[5] / 2}, {q[4] / 2, q[5] / 2, q[2]}}}, vectors;
  diagonalize<3>(m, vectors);
  QuadricAxes axes;
  std::array<int, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return std::abs(m[a][a]) > std::abs(m[b][b]); });
  for (int i = 0; i < 3; ++i) {
    const int from = order[static_cast<std::size_t>(i)];
    axes.values[i] = m[from][from];
    axes.vectors[i] = {vectors[0][from], vectors[1][from], vectors[2][from]};
    axes.slopes[i] = q[6] * axes.vectors[i].x + q[7] * axes.vectors[i].y + q[8] * axes.vectors[i].z;
  }
  return axes;
}

const char* quadric_type_name(QuadricType type) {
  static constexpr const char* kNames[] = {"ellipsoid",
                                           "imaginary ellipsoid",
                                           "hyperboloid of one sheet",
                                           "hyperboloid of two sheets",
                                           "cone",
                                           "point",
                                           "elliptic paraboloid",
                                           "hyperbolic paraboloid",
                                           "elliptic cylinder",
                                           "imaginary cylinder",
                                           "line",
                                           "hyperbolic cylinder",
                                           "intersecting planes",
                                           "parabolic cylinder",
                                           "parallel planes",
                                           "imaginary planes",
                                           "double plane",
                                           "plane",
                                           "nothing"};
  return kNames[static_cast<int>(type)];
}

}  // namespace roadgen
