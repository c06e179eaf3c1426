// The type of a quadric by the inertia of its two matrices.
#include <algorithm>
#include <array>
#include <cmath>

#include "roadgen/object/object.h"

namespace roadgen {
namespace {

constexpr double kZero = 1e-12;  // of the greatest eigenvalue

// How many eigenvalues of a symmetric matrix are above and below zero.
struct Inertia {
  int positive = 0, negative = 0;
  int rank() const { return positive + negative; }
  bool definite() const { return positive == 0 || negative == 0; }
};

// Jacobi's method: rotations that take the elements off the diagonal to 0, each at most once a sweep. Ten sweeps leave
// nothing of matrices of this size.
template <int N>
Inertia inertia(std::array<std::array<double, N>, N> m) {
  for (int sweep = 0; sweep < 10; ++sweep) {
    for (int i = 0; i < N; ++i) {
      for (int k = i + 1; k < N; ++k) {
        if (m[i][k] == 0) continue;
        const double angle = 0.5 * std::atan2(2 * m[i][k], m[k][k] - m[i][i]);
        const double c = std::cos(angle), s = std::sin(angle);
        for (int j = 0; j < N; ++j) {
          const double a = m[i][j], b = m[k][j];
          m[i][j] = c * a - s * b;
          m[k][j] = s * a + c * b;
        }
        for (int j = 0; j < N; ++j) {
          const double a = m[j][i], b = m[j][k];
          m[j][i] = c * a - s * b;
          m[j][k] = s * a + c * b;
        }
      }
    }
  }
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
