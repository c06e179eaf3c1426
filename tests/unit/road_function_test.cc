// The road function of shaders/lib/road.glsl: tangent continuity at joints, accuracy, agreement between its scalars.
#include <array>
#include <cmath>
#include <random>

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "roadgen/road/segment.h"

namespace roadgen {
namespace {

using Jet = ceres::Jet<double, 2>;
using JetLib = glsl::Library<Jet>;
using FloatLib = glsl::Library<glsl::Float32>;

// One end of a random segment: slopes in the paper's range, and a half width that both ends allow.
struct End {
  double a, b, width;
  bool at_start;

  double x(double v) const { return at_start ? -slope() * v / norm() : 1 - slope() * v / norm(); }
  double y(double v) const { return v / norm(); }
  double slope() const { return at_start ? a : b; }
  double norm() const { return std::sqrt(1 + slope() * slope()); }
};

class Ends {
 public:
  End next() {
    std::uniform_real_distribution<double> slope(-1, 1), share(0.02, 1);
    End end{slope(random_), slope(random_), 0, random_() % 2 == 0};
    end.width = share(random_) * (end.a * end.b < 0 ? 0.3 : 0.2);
    return end;
  }
  double offset(double width) { return std::uniform_real_distribution<double>(-width, width)(random_); }

 private:
  std::mt19937_64 random_{20050131};
};

// One-sided difference quotient of third order, by Richardson extrapolation of the one of second order.
template <class F>
double one_sided_slope(F f, double h) {
  const auto second_order = [&](double step) { return (-3 * f(0) + 4 * f(step) - f(2 * step)) / (2 * step); };
  const double coarse = second_order(h), middle = second_order(h / 2), fine = second_order(h / 4);
  const double first = (4 * middle - coarse) / 3, second = (4 * fine - middle) / 3;
  return (8 * second - first) / 7;
}

constexpr int kJoints = 10000;

TEST(RoadFunction, OffsetLinesMeetAtJointsExactly) {
  Ends ends;
  for (int i = 0; i < kJoints; ++i) {
    const End e = ends.next();
    const double v = ends.offset(e.width);
    for (const Lib::RoadCoord c :
         {Lib::road_project_paper(e.x(v), e.y(v), e.a, e.b), Lib::road_project(e.x(v), e.y(v), e.a, e.b)}) {
      ASSERT_NEAR(c.v, v, 1e-12);
      ASSERT_NEAR(c.u, e.at_start ? 0 : 1, 1e-12);
    }
  }
}

// The paper's proof: the gradient of v at both joints is the unit normal, for every v.
TEST(RoadFunction, GradientOfVIsTheNormalAtJoints) {
  Ends ends;
  for (int i = 0; i < kJoints; ++i) {
    const End e = ends.next();
    const double v = ends.offset(e.width);
    const Jet x(e.x(v), 0), y(e.y(v), 1), a(e.a), b(e.b);
    // Clamping u has no slope beyond the joint, but dv/du = 0 there, so v keeps its own.
    for (const auto& c : {JetLib::road_project_paper(x, y, a, b), JetLib::road_project(x, y, a, b)}) {
      const double across = c.v.v[1] - e.slope() * c.v.v[0], along = c.v.v[0] + e.slope() * c.v.v[1];
      ASSERT_NEAR(across / e.norm(), 1, 1e-9);
      ASSERT_LT(std::abs(std::atan2(along, across)), 1e-9);
    }
  }
}

// The same without derivatives of the text: the values alone. With h = 2e-4 the quotient's error is of order h^4 / 64 =
// 3e-17 times fifth derivatives, up to 1e6 where the paper's range ends; rounding gives 1e-16 / h = 5e-13 times 40.
TEST(RoadFunction, OffsetLinesAreTangentAtJointsByFiniteDifferences) {
  Ends ends;
  for (int i = 0; i < kJoints; ++i) {
    const End e = ends.next();
    const double v = ends.offset(e.width);
    const double into = e.at_start ? 1 : -1, tx = 1 / e.norm(), ty = e.slope() / e.norm();
    const auto paper = [&](double s) {
      return Lib::road_project_paper(e.x(v) + into * s * tx, e.y(v) + into * s * ty, e.a, e.b).v;
    };
    const auto step = [&](double s) {
      return Lib::road_project(e.x(v) + into * s * tx, e.y(v) + into * s * ty, e.a, e.b).v;
    };
    ASSERT_LT(std::abs(one_sided_slope(paper, 2e-4)), 1e-9) << e.a << ' ' << e.b << ' ' << v;
    ASSERT_LT(std::abs(one_sided_slope(step, 2e-4)), 1e-9) << e.a << ' ' << e.b << ' ' << v;
  }
}

TEST(RoadFunction, CenterLineHasItsEndsAndSlopes) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> slope(-2, 2), place(0, 1);
  for (int i = 0; i < 1000; ++i) {
    const double a = slope(random), b = slope(random), x = place(random);
    EXPECT_EQ(Lib::road_f(0, a, b), 0);
    EXPECT_EQ(Lib::road_f(1, a, b), 0);
    EXPECT_EQ(Lib::road_df(0, a, b), a);
    EXPECT_EQ(Lib::road_df(1, a, b), b);
    const Jet f = JetLib::road_f(Jet(x, 0), Jet(a), Jet(b)), df = JetLib::road_df(Jet(x, 0), Jet(a), Jet(b));
    EXPECT_NEAR(f.v[0], Lib::road_df(x, a, b), 1e-13);
    EXPECT_NEAR(df.v[0], Lib::road_ddf(x, a, b), 1e-13);
  }
}

// Worst errors of a mapping over the footprint: of v in units of the half width, and of u.
struct Errors {
  double v = 0, u = 0;
};

template <class Mapping>
Errors worst_errors(double a, double b, double width, Mapping mapping, int along = 400, int across = 40) {
  Segment s;
  s.slope_start = a;
  s.slope_end = b;
  Errors worst;
  for (int i = 0; i <= along; ++i) {
    const double u = static_cast<double>(i) / along, df = Lib::road_df(u, a, b), norm = std::sqrt(1 + df * df);
    for (int k = -across; k <= across; ++k) {
      const double v = width * k / across;
      const double x = u - v * df / norm, y = Lib::road_f(u, a, b) + v / norm;
      const Nearest exact = nearest(s, {x, y});
      const Lib::RoadCoord c = mapping(x, y);
      worst.v = std::max(worst.v, std::abs(std::abs(c.v) - exact.distance_m) / width);
      worst.u = std::max(worst.u, std::abs(c.u - exact.u));
    }
  }
  return worst;
}

// The table of the design: a, b, W/L; v by the paper and after one Newton step; u likewise. The first three are the
// paper's figures 7, 9 and 8. Two digits are given, and the worst point lies between samples: 8 %. The step is that of
// the table, without limits to u; road_project keeps u in [0, 1], which can only help.
TEST(RoadFunction, ErrorsAreThoseOfTheDesignTable) {
  constexpr std::array<std::array<double, 7>, 6> kTable = {{{0.7, -0.3, 0.2, 4.8e-3, 1.1e-5, 4.0e-2, 1.8e-3},
                                                            {1, -1, 0.2, 3.3e-2, 1.3e-3, 9.9e-2, 2.0e-2},
                                                            {1, 1, 0.2, 2.3e-2, 2.1e-2, 7.6e-2, 6.4e-2},
                                                            {0.5, -0.5, 0.3, 1.1e-3, 3.1e-7, 3.0e-2, 5.1e-4},
                                                            {0.5, 0.5, 0.2, 7.1e-4, 2.0e-7, 1.5e-2, 2.4e-4},
                                                            {0.25, -0.25, 0.2, 4.8e-5, 3.1e-11, 6.5e-3, 5.3e-6}}};
  for (const auto& [a, b, width, v_paper, v_step, u_paper, u_step] : kTable) {
    const double slope_a = a, slope_b = b;
    const Errors paper =
        worst_errors(a, b, width, [&](double x, double y) { return Lib::road_project_paper(x, y, slope_a, slope_b); });
    const Errors step = worst_errors(a, b, width, [&](double x, double y) {
      const double u1 = Lib::road_project_paper(x, y, slope_a, slope_b).u;
      const double u = Lib::road_newton(u1, x, y, slope_a, slope_b);
      return Lib::RoadCoord{u, Lib::road_v(u, x, y, slope_a, slope_b)};
    });
    const Errors limited =
        worst_errors(a, b, width, [&](double x, double y) { return Lib::road_project(x, y, slope_a, slope_b); });
    EXPECT_NEAR(paper.v / v_paper, 1, 0.08) << a << ' ' << b << ' ' << width;
    EXPECT_NEAR(step.v / v_step, 1, 0.08) << a << ' ' << b << ' ' << width;
    EXPECT_NEAR(paper.u / u_paper, 1, 0.08) << a << ' ' << b << ' ' << width;
    EXPECT_NEAR(step.u / u_step, 1, 0.08) << a << ' ' << b << ' ' << width;
    EXPECT_LE(limited.v, step.v * (1 + 1e-9));
    EXPECT_LE(limited.u, step.u * (1 + 1e-9));
  }
}

// Slopes of at least 0.5: sums of the worst errors of v of the two approximations. Where a = -b they are equal.
TEST(RoadFunction, SimplerApproximationIsWorseOnStrongBends) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> slope(0.5, 1);
  for (const double sign : {1.0, -1.0}) {
    double sum1 = 0, sum2 = 0;
    int better = 0;
    constexpr int kBends = 50;
    for (int i = 0; i < kBends; ++i) {
      const double a = slope(random), b = sign * slope(random), width = sign > 0 ? 0.2 : 0.3;
      const double first =
          worst_errors(
              a, b, width, [&](double x, double y) { return Lib::road_project_paper(x, y, a, b); }, 60, 8)
              .v;
      const double second = worst_errors(
                                a, b, width,
                                [&](double x, double y) {
                                  const double u = Lib::road_u2(x, y, a, b);
                                  return Lib::RoadCoord{u, Lib::road_v(u, x, y, a, b)};
                                },
                                60, 8)
                                .v;
      sum1 += first, sum2 += second;
      better += first < second;
    }
    EXPECT_GT(sum2, (sign > 0 ? 10 : 1.2) * sum1);
    EXPECT_GT(better, kBends / 2);
  }
}

// Quantities are of order 1, some twenty operations deep, and equation 3 and the Newton step divide by no less than 0.4
// in this range: 60 units of 2^-24.
TEST(RoadFunction, SinglePrecisionAgreesWithDouble) {
  Ends ends;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(0, 1);
  constexpr double kTolerance = 60 * 0x1p-24;
  for (int i = 0; i < 20000; ++i) {
    End e = ends.next();
    e.a *= 0.7, e.b *= 0.7;
    // Both sides get the same rounded numbers.
    const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    const double a = rounded(e.a), b = rounded(e.b), u = place(random), v = ends.offset(e.width);
    const double df = Lib::road_df(u, a, b), norm = std::sqrt(1 + df * df);
    const double x = rounded(u - v * df / norm), y = rounded(Lib::road_f(u, a, b) + v / norm);
    const Lib::RoadCoord exact = Lib::road_project(x, y, a, b);
    const FloatLib::RoadCoord single = FloatLib::road_project(x, y, a, b);
    ASSERT_NEAR(static_cast<double>(single.v), exact.v, kTolerance);
    ASSERT_NEAR(static_cast<double>(single.u), exact.u, kTolerance) << a << ' ' << b << ' ' << u << ' ' << v;
  }
}

// Central differences with step 1e-5: error of order 1e-10 times third derivatives (up to 1e3), rounding 1e-11.
TEST(RoadFunction, DerivativesAgreeWithFiniteDifferences) {
  Ends ends;
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> place(0.02, 0.98);
  for (int i = 0; i < 2000; ++i) {
    const End e = ends.next();
    const double u = place(random), v = ends.offset(e.width) * 0.9;
    const double df = Lib::road_df(u, e.a, e.b), norm = std::sqrt(1 + df * df);
    std::array<double, 4> p{u - v * df / norm, Lib::road_f(u, e.a, e.b) + v / norm, e.a, e.b};
    using Jet4 = ceres::Jet<double, 4>;
    const auto c = glsl::Library<Jet4>::road_project(Jet4(p[0], 0), Jet4(p[1], 1), Jet4(p[2], 2), Jet4(p[3], 3));
    if (c.u.a < 0.01 || c.u.a > 0.99) continue;
    for (std::size_t k = 0; k < p.size(); ++k) {
      constexpr double kStep = 1e-5;
      auto low = p, high = p;
      low[k] -= kStep, high[k] += kStep;
      const auto below = Lib::road_project(low[0], low[1], low[2], low[3]);
      const auto above = Lib::road_project(high[0], high[1], high[2], high[3]);
      ASSERT_NEAR(c.v.v[static_cast<int>(k)], (above.v - below.v) / (2 * kStep), 1e-6) << k;
      ASSERT_NEAR(c.u.v[static_cast<int>(k)], (above.u - below.u) / (2 * kStep), 1e-5) << k;
    }
  }
}

TEST(RoadFunction, StaysFiniteEverywhere) {
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> slope(-3, 3), place(-20, 20);
  for (int i = 0; i < 100000; ++i) {
    const double x = place(random), y = place(random), a = slope(random), b = slope(random);
    const Lib::RoadCoord c = Lib::road_project(x, y, a, b);
    ASSERT_TRUE(c.u >= 0 && c.u <= 1 && std::isfinite(c.v)) << x << ' ' << y << ' ' << a << ' ' << b;
  }
}

}  // namespace
}  // namespace roadgen
