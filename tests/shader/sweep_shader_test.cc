// Sweeps (shaders/lib/sweep.glsl) on the GPU against the same text in double.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "roadgen/road/segment.h"
#include "tests/shader/harness.h"

namespace roadgen::test {
namespace {

// clang-format off
#define float Real
SHADER_CASE(Tube, 3, 1, SweepProfile p = SweepProfile(SWEEP_TUBE, x[2], x[2], x[2], x[2], x[2], x[2]);
                        y[0] = sweep_distance(x[0], x[1], p);)
SHADER_CASE(Beam, 2, 2, y[0] = sweep_beam(x[0], x[1], float(0.155), float(0.081), float(0.0015), float(1.0));
                        y[1] = sweep_beam(x[0], x[1], float(0.155), float(0.081), float(0.0015), float(-1.0));)
SHADER_CASE(Vault, 5, 1, y[0] = sweep_vault(x[0], x[1], x[2], x[3], x[4]);)
SHADER_CASE(Lining, 3, 2, SweepProfile p = SweepProfile(int(x[2]), float(5.0), float(2.6), float(5.0), float(6.5), float(0.6), float(8.0));
                          p.p3 = p.kind == SWEEP_LINING ? float(0.5) : float(6.5);
                          p.p5 = p.kind == SWEEP_LINING ? float(3.7) : float(8.0);
                          y[0] = sweep_distance(x[0], x[1], p); y[1] = sweep_support(x[0] / 10.0, x[1] / 10.0, p);)
SHADER_CASE(Support, 1, 2, float c = cos(x[0]); float s = sin(x[0]);
                           SweepProfile p = SweepProfile(SWEEP_BEAM, float(0.155), float(0.081), float(0.0015), float(1.0), float(0.0), float(0.0));
                           y[0] = sweep_support(c, s, p); p.kind = SWEEP_TUBE; y[1] = sweep_support(c, s, p);)
SHADER_CASE(Locate, 18, 7,
            SweepPath r = SweepPath(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], float(0.0), float(0.0), float(0.0));
            SweepPoint p = sweep_locate(x[12], x[13], x[14], x[15], x[16], x[17], r);
            y[0] = p.s; y[1] = p.n; y[2] = p.h; y[3] = p.ds; y[4] = p.dn; y[5] = p.dh; y[6] = p.stretch;)
SHADER_CASE(Hollow, 18, 1,
            SweepPath r = SweepPath(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], float(0.0), float(0.0), float(0.0));
            SweepProfile p = SweepProfile(SWEEP_LINING, float(5.0), float(2.0), float(5.2), float(0.0), float(0.5), float(0.0));
            SweepPosts posts = SweepPosts(float(0.0), float(1.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0));
            SweepPiece piece = SweepPiece(r, p, posts, float(0.2), float(0.8), float(0.0), float(0.0), float(-9.0), float(9.0), float(-2.0), float(8.0));
            y[0] = sweep_hollow(x[12], x[13], x[14], piece);)
SHADER_CASE(Time, 3, 1, y[0] = 1.0 / (0.1 + sweep_time(x[0], x[1], x[2]));)
SHADER_CASE(Keep, 2, 2, vec2 k = sweep_keep(vec2(-3.0, 4.0), x[0], x[1]); y[0] = k.x; y[1] = k.y;)
SHADER_CASE(March, 18, 3,
            SweepPath r = SweepPath(x[0], x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], float(0.05), float(0.05), float(0.05));
            SweepProfile p = SweepProfile(SWEEP_TUBE, float(0.5), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0));
            SweepPosts posts = SweepPosts(float(0.0), float(1.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0));
            SweepPiece piece = SweepPiece(r, p, posts, float(0.0), float(1.0), float(0.0), float(0.0), float(-50.0), float(50.0), float(-50.0), float(50.0));
            SweepCast c = sweep_cast(x[12], x[13], x[14], x[15], x[16], x[17], float(0.0), float(0.0), float(0.001), piece);
            y[0] = c.body.k; y[1] = c.body.met; y[2] = c.body.coverage;)
SHADER_CASE(Post, 6, 3,
            SweepPoint c; c.s = x[0]; c.n = x[1]; c.h = x[2]; c.ds = x[3]; c.dn = x[4]; c.dh = x[5];
            c.tx = float(1.0); c.ty = float(0.0); c.stretch = float(1.0); c.grade = float(0.0);
            SweepPath r = SweepPath(float(10.0), float(0.0), float(0.0), float(10.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0), float(0.0));
            SweepPosts posts = SweepPosts(float(0.0), float(1.0), float(1.0), float(0.06), float(0.1), float(0.0), float(-1.0), float(1.0));
            SweepHit hit = sweep_post(c, float(1.0), float(0.0), x[0], float(0.2), r, posts); y[0] = hit.coverage;
            posts.half_s = float(-0.1); hit = sweep_post(c, float(1.0), float(0.0), x[0], float(0.2), r, posts); y[1] = hit.coverage;
            y[2] = hit.met > 0.5 ? hit.k : float(0.0);)
SHADER_CASE(TunnelLight, 2, 2, y[0] = sweep_daylight(x[0]); y[1] = sweep_lamplight(x[1], float(12.0));)
#undef float
// clang-format on

// chord, a, b, arc, c0, c1, z0 to z3, n0, n1 of a piece beside a bent, climbing segment.
void path(Random& random, double* x) {
  const double length = random.uniform(6, 40);
  const Segment s = make_segment({0, 0}, {length, 0}, random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), 3.5);
  const Cubic z = Cubic::hermite(0.6, random.uniform(-0.1, 0.1), 0.6 + s.arc_m * random.uniform(-0.1, 0.1),
                                 random.uniform(-0.1, 0.1), s.arc_m);
  const double values[] = {length,
                           s.slope_start,
                           s.slope_end,
                           s.arc_m,
                           s.arc_c0,
                           s.arc_c1,
                           z.c0,
                           z.c1,
                           z.c2,
                           z.c3,
                           random.uniform(-5, 5),
                           random.uniform(-0.02, 0.02)};
  std::copy(std::begin(values), std::end(values), x);
}

void place_inputs(Random& random, double* x) {
  path(random, x);
  const double turn = random.uniform(0, 6.28), up = random.uniform(-1, 1), level = std::sqrt(1 - up * up);
  const double values[] = {random.uniform(0.1, 0.9) * x[0], random.uniform(-6, 6),  random.uniform(-3, 3),
                           level * std::cos(turn),          level * std::sin(turn), up};
  std::copy(std::begin(values), std::end(values), x + 12);
}

// Across the road at the middle of the tube, steeply enough to be far from its silhouette.
void ray_inputs(Random& random, double* x) {
  path(random, x);
  const double turn = random.uniform(1.2, 1.9), up = random.uniform(-0.4, 0.4), level = std::sqrt(1 - up * up);
  const double d[] = {level * std::cos(turn), level * std::sin(turn), up}, k = random.uniform(4, 20);
  const double u = 0.5, s = x[0] * Lib::road_arc(u, x[1], x[2], x[3] / x[0], x[4], x[5]);
  const double y = x[0] * Lib::road_f(u, x[1], x[2]) + x[10] + x[11] * s;
  const double z = Lib::road_cubic(s, x[6], x[7], x[8], x[9]) + random.uniform(-0.2, 0.2);
  const double values[] = {0.5 * x[0] - k * d[0], y - k * d[1], z - k * d[2], d[0], d[1], d[2]};
  std::copy(std::begin(values), std::end(values), x + 12);
}

// Limits: about twice what llvmpipe measures.
const FunctionCase kCases[] = {
    {"sweep_tube", Tube, uniform_inputs({{-5, 5}, {-5, 5}, {0.01, 2}}), 5e-7},
    {"sweep_beam", Beam, uniform_inputs({{-0.3, 0.3}, {-0.4, 0.4}}), 1e-7},
    {"sweep_vault", Vault, uniform_inputs({{-9, 9}, {-2, 9}, {3, 6}, {0, 3}, {4, 9}}), 2e-6},
    {"sweep_lining", Lining, uniform_inputs({{-9, 9}, {-2, 9}, {2, 3.99}}), 1.2e-6},
    {"sweep_support", Support, uniform_inputs({{-3.1, 3.1}}), 5e-8},
    {"sweep_locate", Locate, place_inputs, 2.5e-6, 10},
    {"sweep_hollow", Hollow, place_inputs, 2.5e-6, 10},
    {"sweep_time", Time, uniform_inputs({{-1, 9}, {-1, 1}, {0.001, 0.2}}), 4e-7},
    {"sweep_keep", Keep, uniform_inputs({{-9, 9}, {0.1, 1}}), 1.2e-7},
    {"sweep_cast", March, ray_inputs, 6e-4, 20},  // both end within half a millimetre
    {"sweep_post", Post, uniform_inputs({{-0.3, 0.3}, {-0.3, 0.3}, {-0.5, 0.5}, {0.4, 0.9}, {-0.9, -0.4}, {-0.1, 0.1}}),
     3.5e-6},
    {"sweep_light", TunnelLight, uniform_inputs({{-5, 200}, {-50, 500}}), 4e-6, 8},
};

class SweepShader : public GlTest, public ::testing::WithParamInterface<FunctionCase> {};

TEST_P(SweepShader, MatchesDoublePrecision) {
  if (!make_context(ContextKind::kOsmesa)) return;
  check_case({"lib/road.glsl", "lib/marking.glsl", "lib/sweep.glsl"}, GetParam(), 100000);
}

INSTANTIATE_TEST_SUITE_P(, SweepShader, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace roadgen::test
