// The environment on the GPU against integrals in double over a panorama of a known formula.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/environment.h"
#include "roadgen/render/panorama.h"
#include "roadgen/render/renderer.h"
#include "shaders/lib/glsl.h"
#include "tests/gl/gl_fixture.h"
#include "tests/temporary_folder.h"

namespace roadgen::test {
namespace {

using Lib = glsl::Library<double>;
using std::numbers::pi;

class EnvironmentGl : public GlTest {};

ImageF panorama_of(const std::function<glm::dvec3(glm::dvec3)>& light, int height) {
  ImageF image(2 * height, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < 2 * height; ++x) {
      const double polar = (y + 0.5) / height * pi, turn = (0.5 - (x + 0.5) / (2 * height)) * 2 * pi;
      const glm::dvec3 c = light({std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
      for (int i = 0; i < 3; ++i) image.at(x, y, i) = static_cast<float>(c[i]);
    }
  }
  return image;
}

// Smooth, not even, brightest behind the seam and near a pole.
glm::dvec3 hills(glm::dvec3 d) {
  const auto lobe = [&](glm::dvec3 toward, double sharp) {
    return std::exp(sharp * (glm::dot(d, glm::normalize(toward)) - 1));
  };
  return glm::dvec3(0.2, 0.3, 0.1) + glm::dvec3(2, 1, 0.5) * lobe({-1, 0.02, 0.1}, 40) +
         glm::dvec3(0.5, 2, 3) * lobe({0.1, 0.1, 1}, 60) + glm::dvec3(1, 1, 1) * lobe({0.3, -1, -0.4}, 10);
}

glm::dvec3 direction(int face, int x, int y, int size) {
  const double u = (x + 0.5) * 2 / size - 1, v = (y + 0.5) * 2 / size - 1;
  const glm::dvec3 d[] = {{1, -v, -u}, {-1, -v, u}, {u, 1, v}, {u, -1, -v}, {u, -v, 1}, {-u, -v, -1}};
  return glm::normalize(d[face]);
}

std::vector<glm::vec4> texels(const Environment& environment, int level) {
  const int size = environment.size() >> level;
  std::vector<glm::vec4> found(static_cast<std::size_t>(6 * size * size));
  glGetTextureSubImage(environment.cube(), level, 0, 0, 0, size, size, 6, GL_RGBA, GL_FLOAT,
                       static_cast<GLsizei>(found.size() * sizeof found[0]), found.data());
  return found;
}

// Visits every texel: face, its direction, its value.
template <class Visit>
void visit(const Environment& environment, int level, Visit&& visit_texel) {
  const int size = environment.size() >> level;
  const std::vector<glm::vec4> all = texels(environment, level);
  for (int face = 0; face < 6; ++face) {
    for (int y = 0; y < size; ++y) {
      for (int x = 0; x < size; ++x) {
        visit_texel(direction(face, x, y, size),
                    glm::dvec3(all[static_cast<std::size_t>((face * size + y) * size + x)]));
      }
    }
  }
}

double worst(glm::dvec3 a) { return std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)}); }

TEST_F(EnvironmentGl, EvenLightStaysEvenAtEveryRoughness) {
  if (!make_context(ContextKind::kOsmesa)) return;
  const ImageF image = panorama_of([](glm::dvec3) { return glm::dvec3(0.25, 0.5, 1); }, 64);
  const auto environment = Environment::of_panorama(image);
  ASSERT_TRUE(environment.ok()) << environment.error().text();
  for (int level = 0; level < environment->levels(); ++level) {
    visit(*environment, level, [&](glm::dvec3, glm::dvec3 c) {
      ASSERT_LT(worst(c - glm::dvec3(0.25, 0.5, 1)), 1e-3) << level;  // half floats
    });
  }
  const Harmonics h = harmonics_of(image);
  EXPECT_NEAR(h[0].y * Lib::light_harmonic(0, glm::dvec3(0, 0, 1)), 0.5, 1e-3);
  for (std::size_t i = 1; i < 9; ++i) EXPECT_LT(worst(h[i]), 1e-3) << i;
}

TEST_F(EnvironmentGl, LevelZeroIsThePanoramaAtTheSeamAndThePolesToo) {
  if (!make_context(ContextKind::kOsmesa)) return;
  const auto environment = Environment::of_panorama(panorama_of(hills, 256));
  ASSERT_TRUE(environment.ok()) << environment.error().text();
  double greatest = 0;
  visit(*environment, 0, [&](glm::dvec3 d, glm::dvec3 c) { greatest = std::max(greatest, worst(c - hills(d))); });
  // The formula bends by up to 180 per rad^2, over texels of the panorama and of the cube of 0.012 rad.
  EXPECT_LT(greatest, 0.02);
}

TEST_F(EnvironmentGl, LevelsAreMeansOverTheLobe) {
  if (!make_context(ContextKind::kOsmesa)) return;
  const auto environment = Environment::of_panorama(panorama_of(hills, 256));
  ASSERT_TRUE(environment.ok()) << environment.error().text();
  std::mt19937 random(5);
  for (int level = 1; level < environment->levels(); ++level) {
    const double roughness = static_cast<double>(level) / (environment->levels() - 1);
    double greatest = 0;
    visit(*environment, level, [&](glm::dvec3 n, glm::dvec3 c) {
      const std::size_t all =
          6u * static_cast<std::size_t>((environment->size() >> level) * (environment->size() >> level));
      if (random() % all > 150) return;
      // The same mean by an even grid over the half vectors.
      const glm::dvec3 aside =
          glm::normalize(glm::cross(std::abs(n.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0), n));
      const glm::dvec3 ahead = glm::cross(n, aside);
      glm::dvec3 sum(0);
      double weight = 0;
      constexpr int kSteps = 96;
      for (int i = 0; i < kSteps; ++i) {
        for (int k = 0; k < kSteps; ++k) {
          const glm::dvec3 h = Lib::light_half_vector((i + 0.5) / kSteps, (k + 0.5) / kSteps, roughness * roughness);
          const glm::dvec3 l = 2 * h.z * h - glm::dvec3(0, 0, 1);
          if (l.z <= 0) continue;
          sum += l.z * hills(aside * l.x + ahead * l.y + n * l.z);
          weight += l.z;
        }
      }
      greatest = std::max(greatest, worst(c - sum / weight));
    });
    EXPECT_LT(greatest, 0.06) << level;  // of up to 3.3
    EXPECT_GT(greatest, 0) << level;
  }
}

// The picture's sky is the panorama, tone-mapped, in every direction.
TEST_F(EnvironmentGl, APanoramaIsTheSky) {
  auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
  ASSERT_TRUE(renderer.ok());
  ASSERT_TRUE(renderer->load_environment(panorama_of(hills, 256)).ok());
  constexpr int kSide = 48;
  double most = 0, brightest = 0;
  for (const double yaw : {0.0, 100.0, 180.0, 300.0}) {
    Camera camera;
    camera.yaw_deg = yaw;
    camera.pitch_deg = yaw / 10 - 10;
    camera.fov_deg = 25;
    const auto frame = renderer->render(camera, {.width = kSide, .height = kSide, .samples = 1});
    ASSERT_TRUE(frame.ok());
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const glm::dvec3 light = hills(glm::normalize(pixel_ray(camera, kSide, kSide, x, y)));
        for (int i = 0; i < 3; ++i) {
          const double linear = Lib::sky_tone(light[i]);
          const double shown = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
          most = std::max(most, std::abs(frame->color.at(x, y, i) - 255 * shown));
          brightest = std::max(brightest, shown);
        }
      }
    }
  }
  std::printf("a panorama as the sky: off by at most %.1f / 255\n", most);
  EXPECT_GT(brightest, 0.9);
  // Texels of the cube are 0.012 rad wide, over which the lobes bend.
  EXPECT_LT(most, 4);
}

TEST(Environment, SplitSumIsTheIntegralOfTheBrdf) {
  for (const double roughness : {0.3, 0.5, 1.0}) {
    for (const double cosine : {0.1, 0.4, 0.8, 1.0}) {
      const glm::dvec3 v(std::sqrt(1 - cosine * cosine), 0, cosine), n(0, 0, 1);
      const auto albedo = [&](double f0) {
        Lib::LightSurface s = Lib::light_metal_roughness(glm::dvec3(f0), 1.0, roughness, 1.5);
        double sum = 0;
        constexpr int kRings = 400, kTurns = 2000;  // of half a circle: lobes seen at a slant are narrow
        for (int i = 0; i < kRings; ++i) {
          const double polar = (i + 0.5) / kRings * pi / 2;
          for (int k = 0; k < kTurns; ++k) {
            const double turn = (k + 0.5) / kTurns * pi;
            const glm::dvec3 l(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar));
            sum += Lib::light_brdf(s, n, l, v).x * l.z * std::sin(polar);
          }
        }
        return sum * (pi / 2 / kRings) * (2 * pi / kTurns);
      };
      const glm::dvec2 part = split_sum(cosine, roughness);
      EXPECT_NEAR(part.x + part.y, albedo(1), 3e-3) << roughness << " " << cosine;
      EXPECT_NEAR(part.x * 0.04 + part.y, albedo(0.04), 3e-3) << roughness << " " << cosine;
      EXPECT_LE(part.x + part.y, 1.001);
    }
  }
}

TEST(Environment, HarmonicsOfAGradientAreItsDiffuseLight) {
  const glm::dvec3 slope = glm::normalize(glm::dvec3(1, -2, 0.5));
  const Harmonics h =
      harmonics_of(panorama_of([&](glm::dvec3 d) { return glm::dvec3(1 + 0.9 * glm::dot(d, slope)); }, 128));
  for (const glm::dvec3 n : {slope, -slope, glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0)}) {
    double sum = 0;
    for (int i = 0; i < 9; ++i) sum += h[static_cast<std::size_t>(i)].x * Lib::light_harmonic(i, n);
    EXPECT_NEAR(sum, 1 + 0.6 * glm::dot(n, slope), 1e-3);  // a clamped cosine keeps two thirds of a gradient
  }
}

TEST(Environment, TheSkysHarmonicsAreTheLightOnRoads) {
  const Harmonics h = harmonics_of_sky();
  for (double z = -1; z <= 1; z += 0.25) {
    const glm::dvec3 n(std::sqrt(1 - z * z), 0, z);
    glm::dvec3 sum(0);
    for (int i = 0; i < 9; ++i) sum += h[static_cast<std::size_t>(i)] * Lib::light_harmonic(i, n);
    EXPECT_LT(worst(sum - glm::dvec3(Lib::sky_ambient(z))), 1e-8);
  }
}

TEST(Environment, BadFilesAreToldInOneLine) {
  TemporaryFolder folder;
  const auto told = [](const std::string& path) {
    const auto image = read_panorama(path);
    return image.ok() ? std::string("none") : image.error().text();
  };
  EXPECT_NE(told(folder.put("a.png", "x")).find("an environment is a panorama in an .exr or .hdr file"),
            std::string::npos);
  for (const std::string& path :
       {folder.put("a.exr", "not an image"), folder.path("none.hdr"), folder.put("b.hdr", "")}) {
    EXPECT_NE(told(path), "none");
    EXPECT_NE(told(path).find(path), std::string::npos) << told(path);
    EXPECT_EQ(told(path).find('\n'), std::string::npos) << told(path);
  }
  ASSERT_TRUE(write_exr(folder.path("square.exr"), ImageF(64, 64, 3)).ok());
  EXPECT_NE(told(folder.path("square.exr")).find("twice as wide as high"), std::string::npos);
  ImageF odd(16, 8, 3);
  odd.at(3, 3, 0) = std::numeric_limits<float>::quiet_NaN();
  odd.at(4, 3, 0) = std::numeric_limits<float>::infinity();
  odd.at(5, 3, 0) = -1;
  odd.at(6, 3, 0) = 1e30f;
  ASSERT_TRUE(write_exr(folder.path("odd.exr"), odd).ok());
  const auto read = read_panorama(folder.path("odd.exr"));
  ASSERT_TRUE(read.ok()) << read.error().text();
  for (const float x : read->pixels) ASSERT_TRUE(x >= 0 && x <= 60000);
}

TEST(Environment, TheSharedPanoramasAreRead) {
  const std::filesystem::path folder = std::filesystem::path(ROADGEN_SOURCE_DIR) / "../shared/data/textures";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no ../shared/data";
  for (const char* file : {"hdr-blender-cc0/city.exr", "hdr-blender-cc0/sunset.exr", "hdr-pmndrs-cc0/park.exr"}) {
    const auto image = read_panorama(folder / file);
    ASSERT_TRUE(image.ok()) << image.error().text();
    EXPECT_EQ(image->width, 2 * image->height);
    EXPECT_GT(*std::max_element(image->pixels.begin(), image->pixels.end()), 0.5f);
  }
}

}  // namespace
}  // namespace roadgen::test
