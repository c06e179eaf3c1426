// The library beside the road function (surface, markings, noise, sky, ground, junctions) on the GPU against the same text in
// double.
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
SHADER_CASE(Height, 19, 5, RoadSurface r = RoadSurface(x[1], x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10],
                                                       x[11], x[12], x[13], x[14], x[15], x[16], x[17]);
                           y[0] = surface_arc(x[0], r); SurfaceSlope z = surface_at(y[0], x[18], r);
                           y[1] = z.height; y[2] = z.ahead; y[3] = z.aside; y[4] = z.cosine;)
SHADER_CASE(Intersect, 23, 3,
            RoadSurface r = RoadSurface(x[6], x[7], x[8], x[9], x[10], x[11], x[12], x[13], x[14], x[15], x[16], x[17],
                                        x[18], x[19], x[20], x[21], x[22]);
            RoadHit h = surface_search(x[0], x[1], x[2], x[3], x[4], x[5], float(-40.0), float(0.0), float(1e-4),
                                       float(0.05), float(1e3), 0, float(0.0), float(0.0), r).hit;
            y[0] = h.k; y[1] = h.u; y[2] = h.v * r.chord;)
SHADER_CASE(Step, 3, 1, y[0] = filter_step(x[0], x[1], x[2]);)
SHADER_CASE(Dash, 3, 1, y[0] = marking_dash(x[0], float(9.0), float(3.0), x[1], x[2]);)
SHADER_CASE(Border, 6, 6, for (int i = 1; i <= 6; ++i) {
              y[i - 1] = marking_border(i, x[0], x[1], float(0.12), float(0.12), float(3.0), float(6.0), x[2], x[3], x[4],
                                        x[5], float(0.01), float(-0.02)); })
SHADER_CASE(Arrow, 2, 3, y[0] = marking_arrow(x[0], x[1], float(4.0), float(1.2), float(0.0), false);
                         y[1] = marking_arrow(x[0], x[1], float(4.0), float(1.2), float(1.0), false);
                         y[2] = marking_arrow(x[0], x[1], float(4.0), float(1.2), float(-1.0), true);)
SHADER_CASE(Materials, 4, 6, for (int i = 0; i < 6; ++i) {
              vec3 c = material_albedo(i, x[0], x[1], float(0.5), float(3.0), x[2], x[3]); y[i] = c.y; })
SHADER_CASE(NoiseValue, 2, 1, y[0] = noise_value(x[0], x[1], float(2.0));)
SHADER_CASE(NoiseSlope, 2, 3, vec3 n = noise_value_slope(x[0], x[1], float(8.0)); y[0] = n.x; y[1] = n.y; y[2] = n.z;)
SHADER_CASE(NoiseFractal, 3, 2, y[0] = noise_fractal(x[0], x[1], float(64.0), 5, float(0.5), x[2]);
                                y[1] = noise_fractal_slope(x[0], x[1], float(64.0), 5, float(0.5), x[2]).y;)
SHADER_CASE(Sky, 2, 3, vec3 c = sky_gradient(x[0], x[1]); y[0] = c.x; y[1] = c.y; y[2] = c.z;)
SHADER_CASE(Light, 4, 5, vec3 c = sky_ambient(x[0]); y[0] = c.x; y[1] = c.z; y[2] = sky_tone(x[1]);
                         y[3] = sky_transmittance(x[2], float(9000.0)); y[4] = sky_sun_disc(x[3]);)
SHADER_CASE(Refracted, 4, 6, vec3 n = vec3(0.0, 0.0, 1.0); vec3 d = normalize(vec3(x[0], x[1], x[2]));
                             LightRefraction r = light_refracted(d, n, x[3]);
                             y[0] = r.direction.x; y[1] = r.direction.z; vec3 m = light_mirrored(d, n); y[2] = m.z;
                             y[3] = light_fresnel(-d.z, x[3]); y[4] = light_schlick(vec3(0.04, 0.5, 1.0), -d.z).y;
                             y[5] = r.total ? float(1.0) : float(0.0);)
SHADER_CASE(MetalRoughness, 9, 3,
            vec3 l = normalize(vec3(x[0], x[1], x[2])); vec3 v = normalize(vec3(x[3], x[4], x[5]));
            LightSurface s = light_metal_roughness(vec3(0.9, 0.5, 0.1), x[6], x[7], x[8]);
            vec3 f = light_brdf(s, vec3(0.0, 0.0, 1.0), l, v); y[0] = f.x; y[1] = f.y; y[2] = f.z;)
SHADER_CASE(Phong, 7, 3,
            vec3 l = normalize(vec3(x[0], x[1], x[2])); vec3 v = normalize(vec3(x[3], x[4], x[5]));
            LightSurface s = light_phong(vec3(0.9, 0.5, 0.1), vec3(0.1, 0.2, 0.8), x[6]);
            vec3 f = light_brdf(s, vec3(0.0, 0.0, 1.0), l, v); y[0] = f.x; y[1] = f.y; y[2] = f.z;)
SHADER_CASE(Harmonics, 3, 9, vec3 d = normalize(vec3(x[0], x[1], x[2])); for (int i = 0; i < 9; ++i) {
              y[i] = light_harmonic_cosine(i) * light_harmonic(i, d); })
SHADER_CASE(HalfVector, 3, 3, vec3 h = light_half_vector(x[0], x[1], x[2]); y[0] = h.x; y[1] = h.y; y[2] = h.z;)
SHADER_CASE(Ground, 6, 3, float bare = ground_bareness(x[0], x[1], x[2], x[3], x[4]);
                          vec3 c = mix(mix(ground_grass(x[1], x[2], x[3], x[4]), ground_rock(x[3], x[4], x[5]), bare),
                                       ground_snow(), ground_snowiness(x[0], x[1], x[2], x[3], x[4]));
                          y[0] = c.x; y[1] = c.y; y[2] = c.z;)
SHADER_CASE(Verge, 4, 2, y[0] = ground_verge(x[0], x[1], x[2], x[3]); vec3 c = ground_gravel(x[2]); y[1] = c.x;)
SHADER_CASE(Asphalt, 3, 1, vec3 c = ground_asphalt(x[0], x[1], x[2]); y[0] = c.x;)
SHADER_CASE(JunctionCutHeight, 13, 6,
            JunctionCut c = JunctionCut(x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], x[12]);
            JunctionHeight h = junction_height_add_cut(junction_height_begin(), x[0], x[1], c);
            y[0] = h.z; y[1] = h.zx; y[2] = h.zy; y[3] = 1.0 / h.w; y[4] = h.wx / (h.w * h.w); y[5] = h.wy / (h.w * h.w);)
SHADER_CASE(JunctionCornerHeight, 23, 6,
            JunctionCorner c = JunctionCorner(x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], x[12],
                                              x[13], x[14], x[15], x[16], x[17], x[18], x[19], x[20], x[21], x[22]);
            JunctionHeight h = junction_height_add_corner(junction_height_begin(), x[0], x[1], c);
            y[0] = h.z; y[1] = h.zx; y[2] = h.zy; y[3] = 1.0 / h.w; y[4] = h.wx / (h.w * h.w); y[5] = h.wy / (h.w * h.w);)
SHADER_CASE(JunctionMean, 15, 3,
            JunctionHeight h = junction_height_add(junction_height_begin(), x[0], x[1], x[2], x[3], x[4], x[5], x[6]);
            h = junction_height_add(h, x[7], x[8], x[9], x[10], x[11], x[12], x[13]);
            y[0] = h.z; y[1] = h.zx; y[2] = h.zy;)
SHADER_CASE(JunctionCutSide, 13, 2,
            JunctionCut c = JunctionCut(x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], x[12]);
            JunctionSide r = junction_side_add_cut(junction_side_begin(), x[0], x[1], c);
            y[0] = r.cut; y[1] = junction_distance(r);)
SHADER_CASE(JunctionCornerSide, 23, 4,
            JunctionCorner c = JunctionCorner(x[2], x[3], x[4], x[5], x[6], x[7], x[8], x[9], x[10], x[11], x[12],
                                              x[13], x[14], x[15], x[16], x[17], x[18], x[19], x[20], x[21], x[22]);
            JunctionSide r = junction_side_add_corner(junction_side_begin(), x[0], x[1], c);
            y[0] = r.corner; y[1] = junction_distance(r); y[2] = r.nx; y[3] = r.ny;)
SHADER_CASE(JunctionOpen, 3, 2,
            JunctionSide r = JunctionSide(x[0], float(1.0), float(0.0), x[1], x[2] > 0.0);
            y[0] = junction_open_distance(r) < 0.0 ? float(0.0) : float(1.0);
            y[1] = junction_crosses(x[0], x[1], x[2], true) ? float(1.0) : float(0.0);)
#undef float
// clang-format on

// A RoadSurface: an admissible segment with grades up to 12 %, superelevation up to 8 degrees and crossfall to 4 %.
void surface(Random& random, double* x) {
  const double length = random.uniform(4, 40);
  Segment s = make_segment({0, 0}, {length, 0}, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3), 3.5);
  const double grade0 = random.uniform(-0.12, 0.12), grade1 = random.uniform(-0.12, 0.12);
  const Cubic z = Cubic::hermite(0, grade0, s.arc_m * random.uniform(-0.12, 0.12), grade1, s.arc_m);
  const auto bank = [&] { return random.uniform(-0.14, 0.14); };
  const Cubic e = Cubic::hermite(bank(), 0, bank(), 0, s.arc_m);
  const auto fall = [&] { return random.uniform(0.02, 0.04); };
  const double values[] = {length,
                           s.slope_start,
                           s.slope_end,
                           s.arc_m,
                           s.arc_c0,
                           s.arc_c1,
                           z.c1,
                           z.c2,
                           z.c3,
                           e.c0,
                           e.c1,
                           e.c2,
                           e.c3,
                           fall(),
                           random.uniform(-1, 1) * 0.02 / s.arc_m,
                           fall(),
                           random.uniform(-1, 1) * 0.02 / s.arc_m};
  std::copy(std::begin(values), std::end(values), x);
}

void height_inputs(Random& random, double* x) {
  x[0] = random.uniform(0, 1);
  surface(random, x + 1);
  x[18] = random.uniform(-5, 5);
}

// A ray down to a point near the centre of the surface, at 25 degrees or steeper, that ends a little below it.
void ray_inputs(Random& random, double* x) {
  surface(random, x + 6);
  const double down = -random.uniform(0.42, 1), turn = random.uniform(0, 6.28), length = x[6];
  const double across = std::sqrt(1 - down * down);
  const double d[] = {across * std::cos(turn) / length, across * std::sin(turn) / length, down};
  x[0] = random.uniform(0.3, 0.7);
  x[1] = random.uniform(-1, 1) / length;
  x[2] = -0.2;
  std::copy(std::begin(d), std::end(d), x + 3);
}

// A point, and an arm's end of random place, direction and surface within some ten metres of it.
void cut_inputs(Random& random, double* x) {
  const double turn = random.uniform(0, 6.28), left = random.uniform(1, 6), right = -random.uniform(1, 6);
  x[2] = random.uniform(-10, 10), x[3] = random.uniform(-10, 10);
  x[4] = x[2] + (left - right) * std::cos(turn), x[5] = x[3] + (left - right) * std::sin(turn);
  x[6] = left, x[7] = right;
  x[8] = random.uniform(-1, 1);
  for (int i = 9; i < 13; ++i) x[i] = random.uniform(-0.08, 0.08);
  x[0] = 0.5 * (x[2] + x[4]) + random.uniform(-8, 8), x[1] = 0.5 * (x[3] + x[5]) + random.uniform(-8, 8);
}

// A point, and a corner's piece, of an admissible segment of 2 m to 20 m, whose middle lies within five metres of it.
void corner_inputs(Random& random, double* x) {
  const double length = random.uniform(2, 20), turn = random.uniform(0, 6.28);
  const glm::dvec2 axis(std::cos(turn), std::sin(turn)), start(random.uniform(-10, 10), random.uniform(-10, 10));
  const glm::dvec2 end = start + length * axis, middle = 0.5 * (start + end);
  const Segment s =
      make_segment(start, end, turn + random.uniform(-0.26, 0.26), turn + random.uniform(-0.26, 0.26), 0.4);
  const Cubic z = Cubic::hermite(random.uniform(-1, 1), random.uniform(-0.1, 0.1), random.uniform(-1, 1),
                                 random.uniform(-0.1, 0.1), s.arc_m);
  const double values[] = {middle.x + random.uniform(-4, 4),
                           middle.y + random.uniform(-4, 4),
                           start.x,
                           start.y,
                           end.y,
                           length,
                           axis.x,
                           axis.y,
                           s.slope_start,
                           s.slope_end,
                           s.arc_m,
                           s.arc_c0,
                           s.arc_c1,
                           z.c0,
                           z.c1,
                           z.c2,
                           z.c3};
  std::copy(std::begin(values), std::end(values), x);
  for (int i = 17; i < 23; ++i) x[i] = random.uniform(-0.08, 0.08);
}

// A ray onto a surface, and an index not within 1 % of the one at which all begins to be mirrored.
void refraction_inputs(Random& random, double* x) {
  for (int i = 0; i < 2; ++i) x[i] = random.uniform(-1, 1);
  x[2] = random.uniform(-1, -0.1);
  const double sine = std::sqrt((x[0] * x[0] + x[1] * x[1]) / (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]));
  do {
    x[3] = random.uniform(0.5, 2.5);
  } while (std::abs(x[3] - sine) < 0.01 * sine);
}

// Limits: about twice what llvmpipe measures.
const FunctionCase kCases[] = {
    {"surface_height", Height, height_inputs, 1.7e-6},
    {"surface_search", Intersect, ray_inputs, 2.4e-6,
     9},  // rounding of metres of z, over the sine of what banks leave of 25 degrees
    {"filter_step", Step, uniform_inputs({{-2, 2}, {-1, 1}, {-1, 1}}), 1e-5, 64},       // divides by 0.02
    {"marking_dash", Dash, uniform_inputs({{0, 40}, {0.02, 20}, {0.02, 20}}), 3.1e-4},  // by 2 cm of 40 m
    {"marking_border", Border, uniform_inputs({{-1, 1}, {0, 40}, {-0.2, 0.2}, {-0.2, 0.2}, {-2, 2}, {-2, 2}}), 1e-3,
     64},
    {"marking_arrow", Arrow, uniform_inputs({{-3, 3}, {-1, 1}}), 1e-6},
    {"material_albedo", Materials, uniform_inputs({{0, 200}, {-9, 9}, {0.02, 1}, {0.02, 1}}), 1e-3, 64},
    {"noise_value", NoiseValue, uniform_inputs({{-200, 200}, {-200, 200}}), 2.7e-6},  // 200 m / 2 m in 24 bits
    {"noise_value_slope", NoiseSlope, uniform_inputs({{-200, 200}, {-200, 200}}), 3.6e-6},
    {"noise_fractal", NoiseFractal, uniform_inputs({{-200, 200}, {-200, 200}, {0, 4}}), 3.4e-6},
    {"sky_gradient", Sky, uniform_inputs({{-1, 1}, {-1, 1}}), 6e-7},  // pow of the driver
    {"sky_light", Light, uniform_inputs({{-1, 1}, {0, 20}, {0, 30000}, {0.9995, 1}}), 5.3e-4,
     5},                                                           // the sun's rim: / 1e-4
    {"light_refracted", Refracted, refraction_inputs, 1e-4, 170},  // a square root near the rim
    {"light_metal_roughness", MetalRoughness,
     uniform_inputs({{-1, 1}, {-1, 1}, {0.05, 1}, {-1, 1}, {-1, 1}, {0.05, 1}, {0, 1}, {0.2, 1}, {1, 2.5}}), 1e-5, 64},
    {"light_phong", Phong, uniform_inputs({{-1, 1}, {-1, 1}, {0, 1}, {-1, 1}, {-1, 1}, {0, 1}, {1, 60}}), 4e-5,
     400},  // the power of 60
    {"light_harmonic", Harmonics, uniform_inputs({{-1, 1}, {-1, 1}, {-1, 1}}), 1e-6},
    {"light_half_vector", HalfVector, uniform_inputs({{0, 0.999}, {0, 1}, {0.05, 1}}), 1e-5, 64},
    {"ground_materials", Ground, uniform_inputs({{0, 0.6}, {0, 1}, {-1, 1}, {-1, 1}, {-1, 1}, {-1, 1}}), 2.3e-6, 50},
    {"ground_verge", Verge, uniform_inputs({{0, 16}, {-1, 1}, {-1, 1}, {0, 4}}), 2e-6},
    {"ground_asphalt", Asphalt, uniform_inputs({{0, 1}, {-1, 1}, {-1, 1}}), 1e-7},
    {"junction_height_cut", JunctionCutHeight, cut_inputs, 9e-6, 16},
    {"junction_height_corner", JunctionCornerHeight, corner_inputs, 2.4e-6, 6},
    {"junction_height_mean", JunctionMean,
     uniform_inputs({{1, 20},
                     {0.01, 400},
                     {-20, 20},
                     {-20, 20},
                     {-2, 2},
                     {-1, 1},
                     {-1, 1},
                     {1, 20},
                     {0.01, 400},
                     {-20, 20},
                     {-20, 20},
                     {-2, 2},
                     {-1, 1},
                     {-1, 1},
                     {0, 1}}),
     9e-7},
    {"junction_side_cut", JunctionCutSide, cut_inputs, 3.9e-6},
    {"junction_side_corner", JunctionCornerSide, corner_inputs, 3.4e-6},
    {"junction_open", JunctionOpen, uniform_inputs({{0, 1}, {0, 1}, {-1, 1}}), 1e-7},
};

class LibraryShader : public GlTest, public ::testing::WithParamInterface<FunctionCase> {};

TEST_P(LibraryShader, MatchesDoublePrecision) {
  if (!make_context(ContextKind::kOsmesa)) return;
  check_case({"lib/road.glsl", "lib/surface.glsl", "lib/marking.glsl", "lib/noise.glsl", "lib/sky.glsl",
              "lib/light.glsl", "lib/ground.glsl", "lib/material.glsl", "lib/junction.glsl"},
             GetParam(), 100000);
}

INSTANTIATE_TEST_SUITE_P(, LibraryShader, ::testing::ValuesIn(kCases),
                         [](const auto& test) { return std::string(test.param.name); });

using Twin = glsl::Library<double>;

// Mean of a function over the square pixel, from a fine grid.
template <class F>
double pixel_mean(F&& f, int samples) {
  double sum = 0;
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) sum += f((i + 0.5) / samples - 0.5, (j + 0.5) / samples - 0.5);
  }
  return sum / (samples * samples);
}

TEST(Marking, TheStepIsThePartOfThePixelBeyondTheLine) {
  Random random(3);
  for (int i = 0; i < 400; ++i) {
    const double d = random.uniform(-1, 1), a = random.uniform(-1, 1), b = random.uniform(-1, 1);
    const double exact = pixel_mean([&](double x, double y) { return d + a * x + b * y >= 0; }, 200);
    EXPECT_NEAR(Twin::filter_step(d, a, b), exact, 0.01);  // the grid's own error, and the step's 0.005
    EXPECT_EQ(Twin::filter_step(d, 0.0, 0.0), d >= 0 ? 1 : 0);
    EXPECT_NEAR(Twin::filter_step(d, a, b) + Twin::filter_step(-d, a, b), 1, 1e-12);
  }
}

TEST(Marking, DashesAreTheirMeanOverThePixel) {
  Random random(4);
  double sum = 0;
  for (int i = 0; i < 400; ++i) {
    const double s = random.uniform(-30, 30), a = random.uniform(-15, 15), b = random.uniform(-15, 15);
    const auto lit = [&](double x, double y) {
      const double p = s + a * x + b * y;
      return p - 9 * std::floor(p / 9) < 3;
    };
    const double error = std::abs(Twin::marking_dash(s, 9.0, 3.0, a, b) - pixel_mean(lit, 200));
    EXPECT_LT(error, 0.12);  // the corner of a dash, where two points stand for the narrower spread
    sum += error;
  }
  EXPECT_LT(sum / 400, 0.02);
}

TEST(Noise, RepeatsAfterItsPeriodAndItsSlopesAreItsDerivatives) {
  Random random(5);
  for (int i = 0; i < 2000; ++i) {
    const double x = random.uniform(-4096, 4096), y = random.uniform(-4096, 4096);
    EXPECT_NEAR(Twin::noise_value(x, y, 8.0), Twin::noise_value(x + 4096, y - 4096, 8.0), 1e-9);
    const auto n = Twin::noise_value_slope(x, y, 8.0);
    constexpr double kStep = 1e-4;
    EXPECT_NEAR(n.y, (Twin::noise_value(x + kStep, y, 8.0) - Twin::noise_value(x - kStep, y, 8.0)) / (2 * kStep), 1e-6);
    EXPECT_NEAR(n.z, (Twin::noise_value(x, y + kStep, 8.0) - Twin::noise_value(x, y - kStep, 8.0)) / (2 * kStep), 1e-6);
    EXPECT_LE(std::abs(n.x), 1);
  }
}

}  // namespace
}  // namespace roadgen::test
