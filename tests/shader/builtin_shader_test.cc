// GLSL's own functions against those that shaders/lib/glsl.h provides under the same names, and the harness itself.
#include <gtest/gtest.h>

#include <string>
#include <tuple>
#include <vector>

#include "tests/shader/harness.h"

namespace roadgen::test {
namespace {

// clang-format off
#define float Real
SHADER_CASE(Sqrt, 1, 1, y[0] = sqrt(x[0]);)
SHADER_CASE(SinCos, 1, 2, y[0] = sin(x[0]); y[1] = cos(x[0]);)
SHADER_CASE(Exp, 1, 1, y[0] = exp(x[0]);)
SHADER_CASE(Pow, 2, 1, y[0] = pow(x[0], x[1]);)
SHADER_CASE(Steps, 1, 5, y[0] = abs(x[0]); y[1] = floor(x[0]); y[2] = fract(x[0]); y[3] = sign(x[0]);
                         y[4] = smoothstep(float(-1.0), float(2.0), x[0]);)
SHADER_CASE(Select, 3, 4, y[0] = min(x[0], x[1]); y[1] = max(x[0], x[1]); y[2] = clamp(x[0], float(-0.5), float(0.5));
                          y[3] = mix(x[0], x[1], x[2]);)
SHADER_CASE(Vectors, 6, 8, vec3 p = vec3(x[0], x[1], x[2]); vec3 q = vec3(x[3], x[4], x[5]); vec3 n = normalize(p);
                           vec3 m = mix(p, q, float(0.25)); y[0] = n.x; y[1] = n.y; y[2] = n.z; y[3] = m.x;
                           y[4] = m.y; y[5] = m.z; y[6] = dot(p, q); y[7] = length(vec2(p.x, q.y));)
#undef float
// clang-format on

// About twice what llvmpipe measures. Its exp and pow are polynomials, good to some 8 ulp; GLSL grants even
// 3 + 2 |x| ulp for exp, and more for pow.
const std::vector<InputRange> kUnit3 = {{-1, 1}, {-1, 1}, {-1, 1}};
const FunctionCase kCases[] = {
    {"sqrt", Sqrt, uniform_inputs({{0, 100}}), 1.2e-7},
    {"sin_cos", SinCos, uniform_inputs({{-10, 10}}), 1.5e-7},
    {"exp", Exp, uniform_inputs({{-20, 20}}), 2.1e-6, 18},
    {"pow", Pow, uniform_inputs({{0, 10}, {0, 4}}), 2.0e-6, 18},
    {"steps", Steps, uniform_inputs({{-10, 10}}), 2.9e-7},
    {"select", Select, uniform_inputs(kUnit3), 2.6e-7},
    {"vectors", Vectors, uniform_inputs({{0.1, 1}, {-1, 1}, {-1, 1}, {-1, 1}, {0.1, 1}, {-1, 1}}), 3.1e-7},
};

using CaseAndKind = std::tuple<FunctionCase, ContextKind>;
class BuiltinShader : public GlTest, public ::testing::WithParamInterface<CaseAndKind> {};

TEST_P(BuiltinShader, MatchesDoublePrecision) {
  const auto& [function, kind] = GetParam();
  if (!make_context(kind)) return;
  check_case({}, function, 200000);
}

INSTANTIATE_TEST_SUITE_P(, BuiltinShader,
                         ::testing::Combine(::testing::ValuesIn(kCases),
                                            ::testing::Values(ContextKind::kOsmesa, ContextKind::kEgl)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param).name) + "_" +
                                  context_kind_name(std::get<1>(test.param));
                         });

TEST_F(GlTest, EvaluateKeepsEveryRowOfAMillionInPlace) {
  if (!make_context(ContextKind::kOsmesa)) return;
  std::vector<float> x(1000003);
  for (size_t i = 0; i < x.size(); ++i) x[i] = static_cast<float>(i);
  const auto y = evaluate({}, "y[0] = x[0]; y[1] = 2.0 * x[0];", x, 1, 2);
  ASSERT_TRUE(y.ok()) << y.error().text();
  ASSERT_EQ(y->size(), 2 * x.size());
  for (size_t i = 0; i < x.size(); ++i) ASSERT_TRUE((*y)[2 * i] == x[i] && (*y)[2 * i + 1] == 2 * x[i]) << i;
}

TEST_F(GlTest, EvaluateReportsErrorsOfTheBody) {
  if (!make_context(ContextKind::kOsmesa)) return;
  const std::vector<float> x = {1};
  const auto y = evaluate({"lib/road.glsl"}, "y[0] = road_none(x[0]);", x, 1, 1);
  ASSERT_FALSE(y.ok());
  EXPECT_NE(y.error().message.find("road_none"), std::string::npos) << y.error().text();
}

}  // namespace
}  // namespace roadgen::test
