// The light on objects and their shadows, pixel by pixel, against a render in double: rays of roadgen/object/rays.h, the
// formulas of shaders/lib/light.glsl, an environment that is a formula itself, and a sun's disc of many rays.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/object/rays.h"
#include "roadgen/render/environment.h"
#include "roadgen/render/renderer.h"
#include "tests/gl/gl_fixture.h"
#include "tests/temporary_folder.h"

namespace roadgen::test {
namespace {

using Lib = ObjectLib;
using std::numbers::pi;

constexpr int kWidth = 240, kHeight = 180;

class ObjectLight : public GlTest {
 protected:
  // One sample a pixel and no haze, so that a pixel is its centre. Nothing where there is no context.
  std::optional<Frame> draw(const ObjectScene& scene, const Camera& camera, const ImageF* panorama) {
    if (!renderer_) {
      Context* context = make_context(ContextKind::kOsmesa);
      if (!context) return {};
      auto made = Renderer::create(*context);
      EXPECT_TRUE(made.ok()) << made.error().text();
      if (!made.ok()) return {};
      renderer_.emplace(std::move(*made));
      renderer_->set_lighting({.haze_range_m = 1e12});
      const Status lit = panorama ? renderer_->load_environment(*panorama) : Status(Done{});
      EXPECT_TRUE(lit.ok());
    }
    const Status loaded = renderer_->load_objects(scene);
    EXPECT_TRUE(loaded.ok()) << loaded.error().text();
    auto frame = renderer_->render(camera, {.width = kWidth, .height = kHeight, .samples = 1});
    EXPECT_TRUE(frame.ok()) << frame.error().text();
    if (!frame.ok()) return {};
    return std::move(*frame);
  }
  void TearDown() override {
    renderer_.reset();  // before its context
    GlTest::TearDown();
  }

 private:
  std::optional<Renderer> renderer_;
};

glm::dvec3 toward_sun() {
  const Lighting lighting;
  const double a = lighting.sun_azimuth_deg * pi / 180, e = lighting.sun_elevation_deg * pi / 180;
  return {std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e)};
}

// So smooth that a pixel's width and the cube's texels change nothing.
glm::dvec3 surroundings(glm::dvec3 d) {
  return {0.5 + 0.3 * d.x + 0.1 * d.y * d.z, 0.4 - 0.2 * d.y + 0.15 * d.z, 0.6 + 0.35 * d.z - 0.1 * d.x * d.y};
}

ImageF panorama_of_surroundings() {
  constexpr int kRows = 128;
  ImageF image(2 * kRows, kRows, 3);
  for (int y = 0; y < kRows; ++y) {
    for (int x = 0; x < 2 * kRows; ++x) {
      const double polar = (y + 0.5) / kRows * pi, turn = (0.5 - (x + 0.5) / (2 * kRows)) * 2 * pi;
      const glm::dvec3 c =
          surroundings({std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
      for (int i = 0; i < 3; ++i) image.at(x, y, i) = static_cast<float>(c[i]);
    }
  }
  return image;
}

glm::dvec3 reflected(glm::dvec3 d, glm::dvec3 n) { return Lib::light_mirrored(d, n); }

// What comes through a solid: the exits that the ray's hits tell, mirrored within up to four times.
glm::dvec3 through(const Primitive& primitive, glm::dvec3 position, glm::dvec3 d, glm::dvec3 n, double ior) {
  Lib::LightRefraction ray = Lib::light_refracted(d, n, ior);
  double kept = 0;
  for (int i = 0; i < 4; ++i) {
    const auto hits = all_hits(primitive, position, ray.direction);
    const auto exit = std::find_if(hits.begin(), hits.end(), [&](const ObjectHit& h) {
      return h.t > 1e-4 && glm::dot(h.normal, ray.direction) > 0;
    });
    if (exit == hits.end()) break;
    const double cosine = glm::dot(ray.direction, exit->normal);
    const auto leaving = Lib::light_refracted(ray.direction, -exit->normal, 1 / ior);
    if (!leaving.total) kept = Lib::light_fresnel(cosine, 1 / ior);
    ray = leaving;
    position = exit->position_m;
    if (!leaving.total) break;
  }
  return (1 - kept) * surroundings(ray.direction);
}

glm::dvec3 harmonic_light(const Harmonics& h, glm::dvec3 n) {
  glm::dvec3 sum(0);
  for (int i = 0; i < 9; ++i) sum += h[static_cast<std::size_t>(i)] * Lib::light_harmonic(i, n);
  return glm::max(sum, glm::dvec3(0));
}

// Radiance of smooth materials (roughness 0, or Phong) where nothing else hides the sun.
glm::dvec3 expected(const ObjectMaterial& m, const ObjectHit& hit, const Primitive& primitive, glm::dvec3 d,
                    const Harmonics& harmonics) {
  const glm::dvec3 n = hit.normal, base(m.base_color);
  const double cosine = -glm::dot(n, d);
  Lib::LightSurface s = m.model == ObjectMaterial::Model::kPhong
                            ? Lib::light_phong(base, glm::dvec3(m.specular), m.shininess)
                            : Lib::light_metal_roughness(base, m.metallic, m.roughness, m.ior);
  s.diffuse *= 1 - static_cast<double>(m.transmission);
  Lib::LightSurface sunlit = s;
  sunlit.alpha = std::max(s.alpha, LIGHT_SUN_ALPHA);
  const double facing = std::max(glm::dot(n, toward_sun()), 0.0);
  glm::dvec3 light = Lib::light_brdf(sunlit, n, toward_sun(), -d) * Lib::sky_sun_color() * (pi * facing);
  glm::dvec3 part(0);
  if (m.model != ObjectMaterial::Model::kPhong) {
    const glm::dvec2 split = split_sum(cosine, std::sqrt(s.alpha));
    part = s.f0 * split.x + split.y;
  }
  light += s.diffuse * harmonic_light(harmonics, n) * (1.0 - part);
  if (m.model != ObjectMaterial::Model::kPhong) {
    const double fresnel = Lib::light_fresnel(cosine, m.ior), t = m.transmission;
    light += (part * (1 - t) + glm::dvec3(fresnel) * t) * surroundings(reflected(d, n));
    if (t > 0) light += base * (t * (1 - fresnel)) * through(primitive, hit.position_m, d, n, m.ior);
  }
  return light;
}

ObjectScene scene_of(const Shape& shape, const ObjectMaterial& material) {
  ObjectScene scene;
  scene.objects.push_back({"it", shape, glm::dmat4(1.0), 0});
  scene.materials.push_back(material);
  return scene;
}

struct Compared {
  int pixels = 0, off = 0;
  int worst = 0;
};

Compared compare_light(const Frame& frame, const ObjectScene& scene, const Camera& camera, const Harmonics& harmonics) {
  const ObjectRays rays(scene);
  const Primitive of = primitive(scene.objects[0]);
  Compared result;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 d = glm::normalize(pixel_ray(camera, kWidth, kHeight, x, y));
      const auto hit = rays.nearest(camera.position_m, d, camera.near_m);
      // At the rim a step of a pixel is no step along the surface.
      if (!hit || glm::dot(hit->normal, d) > -0.15) continue;
      const glm::dvec3 light = expected(scene.materials[0], *hit, of, d, harmonics);
      ++result.pixels;
      int off = 0;
      for (int c = 0; c < 3; ++c) {
        const double tone = Lib::sky_tone(light[c]);
        const double code = 255 * (tone <= 0.0031308 ? 12.92 * tone : 1.055 * std::pow(tone, 1 / 2.4) - 0.055);
        off = std::max(off, static_cast<int>(std::lround(std::abs(code - frame.color.at(x, y, c)))));
      }
      result.worst = std::max(result.worst, off);
      if (off > 3) ++result.off;
    }
  }
  return result;
}

struct LightCase {
  const char* name;
  ObjectMaterial material;
};

TEST_F(ObjectLight, EverySmoothMaterialIsAsComputedInDouble) {
  const ImageF panorama = panorama_of_surroundings();
  const Harmonics harmonics = harmonics_of(panorama);
  const Camera camera = {.position_m = {-6, 0.5, 1.5}, .yaw_deg = -4, .pitch_deg = -12, .fov_deg = 40};
  const LightCase materials[] = {
      {"mirror", {.base_color = {0.9f, 0.7f, 0.4f}, .metallic = 1, .roughness = 0}},
      {"glass", {.base_color = {1, 0.95f, 0.9f}, .roughness = 0, .transmission = 1, .ior = 1.5f}},
      {"water", {.base_color = {0.8f, 0.9f, 1}, .roughness = 0, .transmission = 0.7f, .ior = 1.33f}},
      {"lacquer", {.base_color = {0.5f, 0.1f, 0.1f}, .roughness = 0}},
      {"phong", {.model = ObjectMaterial::Model::kPhong, .base_color = {0.2f, 0.4f, 0.6f}, .shininess = 20}},
  };
  const std::pair<const char*, Shape> shapes[] = {
      {"sphere", Sphere{{0, 0, 0}, 1}},
      {"ellipsoid", Ellipsoid{{0, 0, 0}, {1.5, 0, 0}, {0, 1, 0.3}, {0, 0, 0.8}}},
      {"cylinder", Cylinder{{0, -1, -0.5}, {0.3, 1, 0.4}, 0.8}},
      {"box", Parallelepiped{{-0.7, -0.8, -0.6}, {1.2, 0.5, 0}, {-0.5, 1.3, 0}, {0, 0.1, 1.1}}},
      {"hyperboloid", Quadric{{1, 1, -1, 0, 0, 0, 0, 0, 0, -0.3}, {-1.5, -1.5, -1}, {1.5, 1.5, 1}, true}},
  };
  for (const auto& [name, shape] : shapes) {
    for (const LightCase& material : materials) {
      const ObjectScene scene = scene_of(shape, material.material);
      const auto frame = draw(scene, camera, &panorama);
      if (!frame) return;
      const Compared c = compare_light(*frame, scene, camera, harmonics);
      EXPECT_GT(c.pixels, 1500) << name;
      // Edges of the far side seen through it, where neighbouring rays leave by different faces.
      EXPECT_LE(c.off, 0.001 * c.pixels) << name << " of " << material.name;
      std::printf("%-12s %-8s %5d pixels, %4d off by more than 3/255, greatest %d\n", name, material.name, c.pixels,
                  c.off, c.worst);
    }
  }
}

// Part of the sun's disc that is seen from a place, by rays in double.
double sun_seen(const ObjectRays& rays, glm::dvec3 place) {
  const glm::dvec3 sun = toward_sun();
  const glm::dvec3 across = glm::normalize(glm::cross(glm::dvec3(0, 0, 1), sun)), along = glm::cross(sun, across);
  constexpr int kRays = 48;
  int seen = 0;
  for (int i = 0; i < kRays; ++i) {
    const double r = 0.00465 * std::sqrt((i + 0.5) / kRays), turn = 2.39996323 * i;
    const glm::dvec3 d = sun + r * (across * std::cos(turn) + along * std::sin(turn));
    seen += rays.nearest(place, d, 1e-3) ? 0 : 1;
  }
  return static_cast<double>(seen) / kRays;
}

// A picture whose red grows with u and whose green grows with v, from a file.
TEST_F(ObjectLight, TexturesLieByUv) {
  TemporaryFolder folder;
  Image8 ramp(256, 128, 3);
  for (int y = 0; y < ramp.height; ++y) {
    for (int x = 0; x < ramp.width; ++x) {
      ramp.at(x, y, 0) = static_cast<std::uint8_t>(x);
      ramp.at(x, y, 1) = static_cast<std::uint8_t>(2 * (ramp.height - 1 - y));
      ramp.at(x, y, 2) = 128;
    }
  }
  ASSERT_TRUE(write_png(folder.path("ramp.png"), ramp).ok());
  const ObjectMaterial material = {.model = ObjectMaterial::Model::kPhong,
                                   .base_color = {0.6f, 0.6f, 0.6f},
                                   .specular = {0, 0, 0},
                                   .texture_file = folder.path("ramp.png")};
  const Camera camera = {.position_m = {-6, 0.5, 1.5}, .yaw_deg = -4, .pitch_deg = -12, .fov_deg = 40};
  const Shape shapes[] = {Sphere{{0, 0, 0}, 1}, Parallelogram{{0, 1, -1}, {0, -2, 0.2}, {-0.5, 0, 2}},
                          Cylinder{{0, 0, -1}, {0, 0, 1}, 0.8}, Torus{{0, 0, 0}, {0.5, 0, 1}, 0.9, 0.35}};
  for (const Shape& shape : shapes) {
    const ObjectScene scene = scene_of(shape, material);
    const auto frame = draw(scene, camera, nullptr);
    if (!frame) return;
    const ObjectRays rays(scene);
    const Harmonics harmonics = harmonics_of_sky();
    int pixels = 0, off = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const glm::dvec3 d = glm::normalize(pixel_ray(camera, kWidth, kHeight, x, y));
        const auto hit = rays.nearest(camera.position_m, d, camera.near_m);
        if (!hit || glm::dot(hit->normal, d) > -0.25) continue;
        // Not at the ramps' ends, where the other one begins, and where the sun is wholly seen or not at all.
        const glm::dvec2 uv = hit->uv;
        if (std::min(uv.x, uv.y) < 0.04 || std::max(uv.x, uv.y) > 0.96) continue;
        const double facing = glm::dot(hit->normal, toward_sun());
        const double seen = facing > 0 ? sun_seen(rays, hit->position_m + 1e-3 * hit->normal) : 0.0;
        if (std::abs(facing) < 0.1 || (seen > 0 && seen < 1)) continue;
        const auto linear = [](double c) { return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
        const glm::dvec3 base = 0.6 * glm::dvec3(linear(uv.x), linear(uv.y), linear(128 / 255.0));
        const glm::dvec3 light =
            base * (Lib::sky_sun_color() * (std::max(facing, 0.0) * seen) + harmonic_light(harmonics, hit->normal));
        ++pixels;
        int worst = 0;
        for (int c = 0; c < 3; ++c) {
          const double tone = Lib::sky_tone(light[c]);
          const double code = 255 * (tone <= 0.0031308 ? 12.92 * tone : 1.055 * std::pow(tone, 1 / 2.4) - 0.055);
          worst = std::max(worst, static_cast<int>(std::lround(std::abs(code - frame->color.at(x, y, c)))));
        }
        off += worst > 6 ? 1 : 0;  // a pixel and a texel wide, on ramps of 255 over some 60 pixels
      }
    }
    EXPECT_GT(pixels, 1000) << shape_name(shape);
    EXPECT_LE(off, 0.005 * pixels) << shape_name(shape);
    std::printf("%-14s %5d pixels, %d off\n", shape_name(shape), pixels, off);
  }
}

// Its mean over the pixel's square.
double mean_over_pixel(const ObjectRays& rays, const Camera& camera, int x, int y) {
  constexpr int kPlaces = 6;
  double sum = 0;
  for (int i = 0; i < kPlaces * kPlaces; ++i) {
    const double u = (i % kPlaces + 0.5) / kPlaces - 0.5, v = (i / kPlaces + 0.5) / kPlaces - 0.5;
    const glm::dvec3 d = pixel_ray(camera, kWidth, kHeight, x + u, y + v);
    const auto hit = rays.nearest(camera.position_m, d, camera.near_m);
    if (hit && glm::dot(hit->normal, toward_sun()) > 0) sum += sun_seen(rays, hit->position_m + 1e-4 * hit->normal);
  }
  return sum / (kPlaces * kPlaces);
}

// A floor on which everything throws its shadow.
ObjectScene shadow_scene(glm::dvec3 origin) {
  ObjectScene scene;
  scene.materials.push_back(
      {.model = ObjectMaterial::Model::kPhong, .base_color = {0.5f, 0.5f, 0.5f}, .specular = {0, 0, 0}});
  const auto add = [&](const Shape& shape) {
    glm::dmat4 moved(1.0);
    moved[3] = glm::dvec4(origin, 1);
    scene.objects.push_back({"", shape, moved, 0});
  };
  add(Parallelogram{{-40, -40, 0}, {80, 0, 0}, {0, 80, 0}});
  add(Sphere{{0, 0, 1.2}, 1});
  add(Cylinder{{4, 1, 0}, {4, 1, 7}, 0.15});
  add(Cone{{2, -4, 0}, {2, -4, 2}, 0.7, 0});
  add(Torus{{-3, 3, 2}, {1, 0.2, 0.5}, 1.2, 0.3});
  add(Parallelepiped{{-4, -4, 0.5}, {1, 0.3, 0}, {-0.3, 1, 0}, {0, 0, 1.5}});
  add(Tetrahedron{{6, -3, 0.3}, {7.5, -3, 0.3}, {6.7, -1.7, 0.3}, {6.7, -2.5, 2}});
  add(Circle{{0, 5, 3}, {0.3, 0, 1}, 0.9});
  add(Conic{{4, 6, 2.5}, {1, 0, 0.2}, {0, 1, 0}, {1, 0, 0, 0, -1, 0}, {-1, 0}, {1, 1}});
  add(Triangle{{-6, 0, 2}, {-5, 0.5, 2.4}, {-5.6, 1.4, 1.8}});
  add(Quadric{{1, 1, -1, 0, 0, 0, 0, 0, 0, -0.2}, {-1, -1, -1}, {1, 1, 1}, false});
  scene.objects.back().transform[3] += glm::dvec4(8, 3, 1.5, 0);
  SphereSet set;
  set.origin_m = origin + glm::dvec3(-8, -2, 1);
  for (int i = 0; i < 60; ++i) {
    set.items.push_back(
        {{0.25f * static_cast<float>(i % 5), 0.25f * static_cast<float>(i / 5 % 4), 0.5f * static_cast<float>(i / 20)},
         0.16f});
  }
  scene.sphere_sets.push_back(set);
  return scene;
}

class ShadowFrom : public ObjectLight, public ::testing::WithParamInterface<double> {};

// Where the disc and the pixel are wholly lit or wholly hidden the picture is; in between it is near the part.
TEST_P(ShadowFrom, ShadowsAreThoseOfRaysInDouble) {
  const double far = GetParam();
  const glm::dvec3 origin(far, -0.5 * far, 0.01 * far);
  const ObjectScene scene = shadow_scene(origin);
  const Camera camera = {.position_m = origin + glm::dvec3(11, 9, 9), .yaw_deg = 218, .pitch_deg = -33, .fov_deg = 52};
  const auto frame = draw(scene, camera, nullptr);
  if (!frame) return;
  const ObjectRays rays(scene);
  const Harmonics harmonics = harmonics_of_sky();
  int sure = 0, wrong = 0, shaded = 0, between = 0;
  double sum = 0;
  for (int y = 1; y + 1 < kHeight; ++y) {
    for (int x = 1; x + 1 < kWidth; ++x) {
      // The parts at the pixel's corners and its centre, all on one surface.
      double least = 1, most = 0;
      bool same = true;
      std::optional<ObjectHit> middle;
      glm::dvec3 direction;
      for (const glm::dvec2 at : {glm::dvec2(0, 0), {-0.7, -0.7}, {0.7, -0.7}, {-0.7, 0.7}, {0.7, 0.7}}) {
        const glm::dvec3 d = glm::normalize(pixel_ray(camera, kWidth, kHeight, x + at.x, y + at.y));
        const auto hit = rays.nearest(camera.position_m, d, camera.near_m);
        if (!hit) {
          same = false;
          break;
        }
        if (!middle) middle = hit, direction = d;
        same =
            same && hit->instance == middle->instance && hit->face == middle->face && glm::dot(hit->normal, d) < -0.1;
        const double facing = glm::dot(hit->normal, toward_sun());
        // Where the sun grazes the surface its own roughness in floats decides.
        same = same && std::abs(facing) > 0.08;
        const double seen = facing > 0 ? sun_seen(rays, hit->position_m + 1e-4 * hit->normal) : 0.0;
        least = std::min(least, seen), most = std::max(most, seen);
      }
      if (!same) continue;
      const double facing = std::max(glm::dot(middle->normal, toward_sun()), 0.0);
      const auto code = [&](double seen) {
        const glm::dvec3 light =
            0.5 * (Lib::sky_sun_color() * facing * seen + harmonic_light(harmonics, middle->normal));
        const double tone = Lib::sky_tone(light.y);
        return 255 * (1.055 * std::pow(tone, 1 / 2.4) - 0.055);
      };
      const double drawn = frame->color.at(x, y, 1);
      if (least == most) {
        ++sure;
        shaded += most == 0 && facing > 0 ? 1 : 0;
        // Everything but the sun is the same: what is off is the part of the sun.
        wrong += std::abs(drawn - code(most)) > 4 ? 1 : 0;
      } else {
        ++between;
        const double mean = mean_over_pixel(rays, camera, x, y);
        sum += std::abs(drawn - code(mean)) / std::max(code(1) - code(0), 1.0);
      }
    }
  }
  std::printf("%g m: %d sure pixels, %d in shadow, %d wrong; %d at edges, mean error of the part %.3f\n", far, sure,
              shaded, wrong, between, sum / std::max(between, 1));
  EXPECT_GT(sure, 10000);
  EXPECT_GT(shaded, 1000);
  EXPECT_GT(between, 300);
  // Edges that five places of a pixel do not tell: tips, and spheres that nearly touch.
  EXPECT_LE(wrong, 0.002 * sure);
  EXPECT_LT(sum / between, 0.05);
}
INSTANTIATE_TEST_SUITE_P(, ShadowFrom, ::testing::Values(0.0, 1e5, 1e7));

}  // namespace
}  // namespace roadgen::test
