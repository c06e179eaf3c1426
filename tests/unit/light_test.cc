// The light library in double: closed forms, limits, reciprocity and what a white furnace gets back.
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "shaders/lib/glsl.h"

namespace roadgen {
namespace {

using Lib = glsl::Library<double>;
using std::numbers::pi;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }

 private:
  std::mt19937_64 engine_;
};

constexpr glm::dvec3 kUp(0, 0, 1);
constexpr glm::dvec3 kWhite(1, 1, 1);

glm::dvec3 at(double cosine, double turn) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(turn), sine * std::sin(turn), cosine};
}

// Even in the hemisphere about +z.
glm::dvec3 random_up(Random& random) { return at(random.uniform(0, 1), random.uniform(0, 2 * pi)); }

// Integral of f over the hemisphere about +z, as a function of directions.
template <class F>
double hemisphere(F&& f, int rings) {
  double sum = 0;
  for (int i = 0; i < rings; ++i) {
    // Even in sine^2 near the top, where narrow lobes are, would miss the rim: even in the angle serves both.
    const double angle = (i + 0.5) / rings * pi / 2;
    for (int k = 0; k < 2 * rings; ++k) {
      sum += f(at(std::cos(angle), (k + 0.5) * pi / rings)) * std::sin(angle);
    }
  }
  return sum * (pi / 2 / rings) * (pi / rings);
}

// Part of the light from v that a surface sends out again.
double albedo(const Lib::LightSurface& s, glm::dvec3 v, int rings = 400) {
  return hemisphere([&](glm::dvec3 l) { return Lib::light_brdf(s, kUp, l, v).x * l.z; }, rings);
}

TEST(Light, MirroredTwiceIsTheSameAndTheNormalHalvesTheAngle) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const glm::dvec3 n = random_up(random), d = -random_up(random), r = Lib::light_mirrored(d, n);
    EXPECT_NEAR(glm::length(r), 1, 1e-14);
    EXPECT_NEAR(glm::dot(r, n), -glm::dot(d, n), 1e-14);
    EXPECT_NEAR(glm::length(Lib::light_mirrored(r, n) - d), 0, 1e-14);
    EXPECT_NEAR(glm::length(Lib::light_mirrored(d, -n) - r), 0, 1e-14);
  }
}

TEST(Light, RefractionObeysSnellAndRunsBackward) {
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const double ior = random.uniform(0.4, 2.5);
    const glm::dvec3 d = -random_up(random);
    const auto r = Lib::light_refracted(d, kUp, ior);
    const double sine = std::hypot(d.x, d.y);
    EXPECT_EQ(r.total, sine > ior) << sine << " " << ior;
    EXPECT_NEAR(glm::length(r.direction), 1, 1e-14);
    if (r.total) {
      EXPECT_NEAR(glm::length(r.direction - Lib::light_mirrored(d, kUp)), 0, 1e-14);
      continue;
    }
    EXPECT_NEAR(std::hypot(r.direction.x, r.direction.y) * ior, sine, 1e-13);
    EXPECT_LT(r.direction.z, 0);
    EXPECT_NEAR(d.x * r.direction.y - d.y * r.direction.x, 0, 1e-14);  // in the plane of incidence
    const auto back = Lib::light_refracted(-r.direction, -kUp, 1 / ior);
    EXPECT_NEAR(glm::length(back.direction + d), 0, 1e-7);  // the square root, near the rim
  }
  const auto straight = Lib::light_refracted(at(-0.3, 1), kUp, 1.0);
  EXPECT_NEAR(glm::length(straight.direction - at(-0.3, 1)), 0, 1e-14);
}

TEST(Light, FresnelHasItsClosedFormsAndIsTheSameFromBothSides) {
  for (const double ior : {1.0, 1.33, 1.5, 2.4, 4.0}) {
    const double r = (ior - 1) / (ior + 1);
    EXPECT_NEAR(Lib::light_fresnel(1.0, ior), r * r, 1e-15);
    EXPECT_NEAR(Lib::light_fresnel(1.0, 1 / ior), r * r, 1e-15);
    EXPECT_EQ(Lib::light_fresnel(0.0, ior), ior == 1 ? 0 : 1);
    // Brewster's angle: of the light that swings in the plane nothing returns.
    const double brewster = std::atan(ior), across = std::cos(2 * brewster);
    EXPECT_NEAR(Lib::light_fresnel(std::cos(brewster), ior), 0.5 * across * across, 1e-14);
    double last = 1;
    for (double cosine = 0; cosine <= 1; cosine += 1.0 / 64) {
      const double f = Lib::light_fresnel(cosine, ior);
      EXPECT_GE(f, 0);
      EXPECT_LE(f, 1);
      if (ior < 2.5) {
        EXPECT_LE(f, last + 1e-3) << ior << " " << cosine;  // falls, but for a dip near Brewster's angle
      }
      last = f;
      // The same ray from the other side.
      const double inside = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
      EXPECT_NEAR(Lib::light_fresnel(inside, 1 / ior), f, 1e-6);  // the square root, near the rim
    }
  }
  // Beyond the critical angle all is reflected.
  EXPECT_EQ(Lib::light_fresnel(0.5, 1 / 1.5), 1);
  EXPECT_EQ(Lib::light_fresnel(std::sqrt(1 - 1 / 2.25) - 1e-9, 1 / 1.5), 1);
}

TEST(Light, SchlickIsNearFresnel) {
  double worst = 0;
  for (double cosine = 0; cosine <= 1; cosine += 1.0 / 256) {
    worst = std::max(worst, std::abs(Lib::light_schlick(0.04 * kWhite, cosine).x - Lib::light_fresnel(cosine, 1.5)));
  }
  EXPECT_LT(worst, 0.04);
  EXPECT_GT(worst, 0.01);
}

TEST(Light, ProjectedAreaOfAllMicrofacetsIsOne) {
  for (const double alpha : {0.05, 0.2, 0.5, 1.0}) {
    const double sum = hemisphere([&](glm::dvec3 h) { return Lib::light_distribution(kUp, h, alpha) * h.z; },
                                  alpha < 0.1 ? 2000 : 400);
    EXPECT_NEAR(sum, 1, 1e-3) << alpha;
  }
}

TEST(Light, HalfVectorsFallByTheDistribution) {
  // The part of samples within a cone against the integral of the distribution over it, which is cosine-weighted
  // a closed form: sin^2 / (sin^2 + alpha^2 cos^2).
  for (const double alpha : {0.1, 0.4, 1.0}) {
    for (const double cosine : {0.3, 0.8, 0.99}) {
      const double sine2 = 1 - cosine * cosine;
      const double expected = sine2 / (sine2 + alpha * alpha * cosine * cosine);
      EXPECT_NEAR(Lib::light_half_vector(expected, 0.3, alpha).z, cosine, 1e-12);
    }
  }
}

TEST(Light, BrdfsAreReciprocal) {
  Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 l = random_up(random), v = random_up(random);
    const glm::dvec3 base(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    const auto metal = Lib::light_metal_roughness(base, random.uniform(0, 1), random.uniform(0.05, 1), 1.5);
    const auto phong = Lib::light_phong(base, kWhite * random.uniform(0, 1), random.uniform(1, 200));
    for (const auto& s : {metal, phong}) {
      const glm::dvec3 a = Lib::light_brdf(s, kUp, l, v), b = Lib::light_brdf(s, kUp, v, l);
      EXPECT_NEAR(glm::length(a - b), 0, 1e-9 * (1 + glm::length(a)));
      EXPECT_GE(std::min({a.x, a.y, a.z}), 0);
      EXPECT_EQ(Lib::light_brdf(s, kUp, -l, v), glm::dvec3(0));
      EXPECT_EQ(Lib::light_brdf(s, kUp, l, -v), glm::dvec3(0));
    }
  }
}

// White surfaces under even light return no more than they get, and metal of small roughness nearly all.
TEST(Light, WhiteFurnaceGetsBackAtMostOne) {
  for (const double cosine : {0.1, 0.3, 0.6, 0.9, 1.0}) {
    const glm::dvec3 v = at(cosine, 0.4);
    for (const double roughness : {0.3, 0.5, 0.8, 1.0}) {
      for (const double metallic : {0.0, 0.5, 1.0}) {
        const double a = albedo(Lib::light_metal_roughness(kWhite, metallic, roughness, 1.5), v, 600);
        EXPECT_LE(a, 1.002) << roughness << " " << metallic << " " << cosine;  // the quadrature's own error
        EXPECT_GT(a, 0.25);
        if (metallic == 1.0 && roughness == 0.3 && cosine >= 0.6) {
          EXPECT_GT(a, 0.96) << metallic << " " << cosine;
        }
      }
    }
    for (const double exponent : {1.0, 10.0, 200.0}) {
      for (const double specular : {0.0, 0.5, 1.0}) {
        const double a = albedo(Lib::light_phong(kWhite, specular * kWhite, exponent), v);
        EXPECT_LE(a, 1 + 1e-3);
        if (cosine == 1.0 || specular == 0) {
          EXPECT_NEAR(a, 1, 2e-3) << exponent << " " << specular;
        }
      }
    }
  }
}

TEST(Light, HarmonicsAreOrthonormalAndCosinesKeepEvenLight) {
  for (int i = 0; i < 9; ++i) {
    for (int k = 0; k <= i; ++k) {
      const double sum = hemisphere(
          [&](glm::dvec3 d) {
            return Lib::light_harmonic(i, d) * Lib::light_harmonic(k, d) +
                   Lib::light_harmonic(i, -d) * Lib::light_harmonic(k, -d);
          },
          200);
      EXPECT_NEAR(sum, i == k ? 1 : 0, 1e-4) << i << " " << k;
    }
  }
  // The clamped cosine's own coefficients, over pi: integral of max(cos, 0) Y(d) = pi * factor * Y(axis).
  for (int i = 0; i < 9; ++i) {
    const double sum = hemisphere([&](glm::dvec3 d) { return d.z * Lib::light_harmonic(i, d); }, 200);
    EXPECT_NEAR(sum / pi, Lib::light_harmonic_cosine(i) * Lib::light_harmonic(i, kUp), 1e-4) << i;
  }
}

TEST(Light, TheSunsLobeIsAsBrightAsItsDisc) {
  // Mirrored straight: distribution * visibility = 1 / (pi alpha^2) / 4, and the disc's radiance under irradiance 1.
  const double lobe =
      Lib::light_distribution(kUp, kUp, LIGHT_SUN_ALPHA) * Lib::light_visibility(1.0, 1.0, LIGHT_SUN_ALPHA);
  const double radius = std::acos(0.9999);  // the middle of the rim of sky_sun_disc
  EXPECT_NEAR(lobe * pi * radius * radius, 1, 0.03);
}

}  // namespace
}  // namespace roadgen
