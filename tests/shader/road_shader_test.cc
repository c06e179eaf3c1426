// shaders/lib/road.glsl on the GPU against the same text in double, over the admissible domain.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <tuple>
#include <vector>

#include "roadgen/road/segment.h"
#include "tests/shader/harness.h"

namespace roadgen::test {
namespace {

// clang-format off
#define float Real
SHADER_CASE(F, 3, 1, y[0] = road_f(x[0], x[1], x[2]);)
SHADER_CASE(Df, 3, 1, y[0] = road_df(x[0], x[1], x[2]);)
SHADER_CASE(Ddf, 3, 1, y[0] = road_ddf(x[0], x[1], x[2]);)
SHADER_CASE(Linear, 4, 3, y[0] = road_alpha(x[1], x[2], x[3]); y[1] = road_beta(x[1], x[2], x[3]);
                          y[2] = road_gamma(x[0], x[1], x[2]);)
SHADER_CASE(U1, 4, 1, y[0] = road_u1(road_alpha(x[1], x[2], x[3]), road_beta(x[1], x[2], x[3]),
                                     road_gamma(x[0], x[1], x[2]));)
SHADER_CASE(U2, 4, 1, y[0] = road_u2(x[0], x[1], x[2], x[3]);)
SHADER_CASE(Newton, 4, 1, y[0] = road_newton(x[0], x[0], x[1], x[2], x[3]);)
SHADER_CASE(V, 4, 1, y[0] = road_v(x[0], x[0], x[1], x[2], x[3]);)
SHADER_CASE(ProjectPaper, 4, 2, RoadCoord c = road_project_paper(x[0], x[1], x[2], x[3]); y[0] = c.u; y[1] = c.v;)
SHADER_CASE(Project, 4, 2, RoadCoord c = road_project(x[0], x[1], x[2], x[3]); y[0] = c.u; y[1] = c.v;)
SHADER_CASE(Arc, 6, 1, y[0] = road_arc(x[0], x[1], x[2], x[3], x[4], x[5]);)
SHADER_CASE(Darc, 6, 1, y[0] = road_darc(x[0], x[1], x[2], x[3], x[4], x[5]);)
SHADER_CASE(CubicProfile, 5, 1, y[0] = road_cubic(x[0], x[1], x[2], x[3], x[4]);)
SHADER_CASE(CubicSlope, 5, 1, y[0] = road_dcubic(x[0], x[2], x[3], x[4]);)
#undef float
// clang-format on

// A point of the footprint of an admissible segment, and the segment's slopes: x, y, a, b.
void footprint_point(Random& random, double* x) {
  double a = 0, b = 0, w = 0;
  do {
    a = random.uniform(-0.7, 0.7);
    b = random.uniform(-0.7, 0.7);
    w = random.uniform(0.01, 0.3);
  } while (!(mapping_bound(a, b, w).v <= kMappingTolerance * w));
  const double u = random.uniform(0, 1), v = random.uniform(-w, w);
  const double df = Lib::road_df(u, a, b), norm = std::sqrt(1 + df * df);
  x[0] = u - v * df / norm;
  x[1] = Lib::road_f(u, a, b) + v / norm;
  x[2] = a;
  x[3] = b;
}

// An admissible segment's arc polynomial at a u: u, a, b, arc, c0, c1.
void arc_point(Random& random, double* x) {
  const double heading0 = random.uniform(-0.5, 0.5), heading1 = random.uniform(-0.5, 0.5);
  const Segment segment = make_segment({0, 0}, {1, 0}, heading0, heading1, 0.01);
  const double values[] = {random.uniform(0, 1), segment.slope_start, segment.slope_end,
                           segment.arc_m,        segment.arc_c0,      segment.arc_c1};
  std::copy(std::begin(values), std::end(values), x);
}

// Limits are about twice what llvmpipe measures, a handful of roundings of 2^-24 = 6e-8 each, which leaves room for
// GPUs that fuse multiplications and additions, and divide to 2.5 ulp. Where the limit is larger, the terms are.
const std::vector<InputRange> kCurve = {{0, 1}, {-0.7, 0.7}, {-0.7, 0.7}};
const std::vector<InputRange> kProfile = {{0, 100}, {-50, 50}, {-0.1, 0.1}, {-1e-3, 1e-3}, {-1e-5, 1e-5}};
const FunctionCase kCases[] = {
    {"road_f", F, uniform_inputs(kCurve), 6.4e-8},
    {"road_df", Df, uniform_inputs(kCurve), 2.1e-7},
    {"road_ddf", Ddf, uniform_inputs(kCurve), 6.8e-7},  // terms up to 4 |a + b|
    {"road_alpha_beta_gamma", Linear, footprint_point, 1.5e-7},
    {"road_u1", U1, footprint_point, 4.1e-7},  // x is rounded, then divided by nearly 2
    {"road_u2", U2, footprint_point, 2.7e-7},
    {"road_newton", Newton, footprint_point, 1.4e-7},
    {"road_v", V, footprint_point, 1.2e-7},
    {"road_project_paper", ProjectPaper, footprint_point, 4.1e-7},  // u as road_u1; v is better
    {"road_project", Project, footprint_point, 1.2e-7},             // the step also removes road_u1's rounding
    {"road_arc", Arc, arc_point, 4.0e-7},
    {"road_darc", Darc, arc_point, 7.4e-7},
    {"road_cubic", CubicProfile, uniform_inputs(kProfile), 4.4e-6},  // four terms of 10 to 50 m that may cancel
    {"road_dcubic", CubicSlope, uniform_inputs(kProfile), 1.3e-7},
};

using CaseAndKind = std::tuple<FunctionCase, ContextKind>;
class RoadShader : public GlTest, public ::testing::WithParamInterface<CaseAndKind> {};

TEST_P(RoadShader, MatchesDoublePrecision) {
  const auto& [function, kind] = GetParam();
  if (!make_context(kind)) return;
  check_case({"lib/road.glsl"}, function, 200000);
}

INSTANTIATE_TEST_SUITE_P(, RoadShader,
                         ::testing::Combine(::testing::ValuesIn(kCases),
                                            ::testing::Values(ContextKind::kOsmesa, ContextKind::kEgl)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param).name) + "_" +
                                  context_kind_name(std::get<1>(test.param));
                         });

// Points that are no part of the road still run through the shader, at the corners of quads and beyond.
TEST_F(GlTest, RoadProjectIsFiniteAndClampedFarOutsideTheFootprint) {
  if (!make_context(ContextKind::kOsmesa)) return;
  Random random(2);
  std::vector<float> x;
  for (int i = 0; i < 200000; ++i) {
    for (const double range : {3.0, 3.0, 1.0, 1.0}) x.push_back(static_cast<float>(random.uniform(-range, range)));
  }
  const auto y = evaluate({"lib/road.glsl"}, Project.glsl, x, Project.inputs, Project.outputs);
  ASSERT_TRUE(y.ok()) << y.error().text();
  for (size_t i = 0; i < y->size(); i += 2) {
    ASSERT_TRUE((*y)[i] >= 0 && (*y)[i] <= 1 && std::isfinite((*y)[i + 1]))
        << "x, y, a, b = " << x[2 * i] << ", " << x[2 * i + 1] << ", " << x[2 * i + 2] << ", " << x[2 * i + 3]
        << " gives u, v = " << (*y)[i] << ", " << (*y)[i + 1];
  }
}

}  // namespace
}  // namespace roadgen::test
