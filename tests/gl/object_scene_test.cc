// Scenes of objects: sets of spheres against rays in double, options that change nothing, antialiasing, roads and ground
// in front and behind, far from the origin, and what is refused.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/object/rays.h"
#include "roadgen/render/renderer.h"
#include "terrain/terrain.h"
#include "tests/gl/gl_fixture.h"
#include "tests/object_shapes.h"

namespace roadgen::test {
namespace {

constexpr int kSize = 192;
constexpr FrameOptions kData{.width = kSize, .height = kSize, .channels = kAllChannels & ~kColor};

// A dense cloud, many of whose spheres are hidden.
ObjectScene cloud(glm::dvec3 origin, int count) {
  ShapeRandom random(9);
  ObjectScene scene;
  scene.objects.push_back({.name = "ball", .shape = Sphere{{0, 0, 0}, 0.7}});
  scene.objects[0].transform[3] = glm::dvec4(origin + glm::dvec3(-4, 2, 1), 1);
  SphereSet& set = scene.sphere_sets.emplace_back();
  set.origin_m = origin;
  for (int i = 0; i < count; ++i) {
    set.items.push_back({glm::vec3(random.direction() * std::cbrt(random.uniform(0, 1)) * 4.0),
                         static_cast<float>(random.scale(0.05, 0.5)),
                         {200, 120, static_cast<std::uint8_t>(i), 255}});
  }
  return scene;
}

Camera camera_at(glm::dvec3 position) {
  Camera camera;
  camera.position_m = position;
  camera.near_m = 0.05;
  return camera;
}

class ObjectScenes : public GlTest {
 protected:
  void SetUp() override {
    Context* context = make_context(ContextKind::kOsmesa);
    ASSERT_NE(context, nullptr);
    auto made = Renderer::create(*context);
    ASSERT_TRUE(made.ok()) << made.error().text();
    renderer_ = std::make_unique<Renderer>(std::move(*made));
  }
  void TearDown() override {
    renderer_.reset();
    GlTest::TearDown();
  }
  Frame frame(const Camera& camera, const FrameOptions& options = kData) {
    auto made = renderer_->render(camera, options);
    EXPECT_TRUE(made.ok()) << made.error().text();
    return made.ok() ? std::move(*made) : Frame{};
  }
  void load(const ObjectScene& scene, const ObjectOptions& options = {}) {
    const Status status = renderer_->load_objects(scene, options);
    ASSERT_TRUE(status.ok()) << status.error().text();
  }

  std::unique_ptr<Renderer> renderer_;
};

TEST_F(ObjectScenes, SetsOfSpheresAreTheRaysOwnFromOutsideAndWithin) {
  const ObjectScene scene = cloud({30, -20, 5}, 4000);
  load(scene);
  const ObjectRays rays(scene);
  for (const glm::dvec3 from : {glm::dvec3(-12, 0, 0), glm::dvec3(-5, 1, 0.3), glm::dvec3(-0.4, 0.2, 0)}) {
    const Camera camera = camera_at(glm::dvec3(30, -20, 5) + from);
    const Frame f = frame(camera);
    long covered = 0, edge = 0;
    for (int y = 0; y < kSize; ++y) {
      for (int x = 0; x < kSize; ++x) {
        const auto cast = [&](double dx, double dy) {
          const auto hit =
              rays.nearest(camera.position_m, pixel_ray(camera, kSize, kSize, x + dx, y + dy), camera.near_m);
          return std::pair(hit ? hit->instance + 1 : 0, hit ? hit->t : 0);
        };
        const auto [instance, t] = cast(0, 0);
        covered += instance != 0;
        if (f.instance.at(x, y, 0) == instance) {
          EXPECT_EQ(f.label.at(x, y, 0), static_cast<std::uint32_t>(instance ? Label::kObject : Label::kNone));
          // At outlines by their slope.
          if (instance) {
            EXPECT_NEAR(f.depth_m.at(x, y, 0) / t, 1, 5e-5);
          }
          continue;
        }
        // Within 0.01 pixels of an outline, where two spheres meet too.
        bool other = false;
        for (int i = 0; i < 8; ++i) {
          const double turn = i * std::numbers::pi / 4;
          other |= cast(0.01 * std::cos(turn), 0.01 * std::sin(turn)).first == f.instance.at(x, y, 0);
        }
        EXPECT_TRUE(other) << x << "," << y << ": " << f.instance.at(x, y, 0) << ", not " << instance;
        ++edge;
      }
    }
    EXPECT_GT(covered, kSize * kSize / 5);
    EXPECT_LT(edge, 40);
  }
}

TEST_F(ObjectScenes, HiddenSpheresMakeNoDifference) {
  const ObjectScene scene = cloud({0, 0, 0}, 20000);
  for (const glm::dvec3 from : {glm::dvec3(-12, 0, 0), glm::dvec3(-60, 3, 2), glm::dvec3(0.2, 0.1, 0)}) {
    load(scene, {.occlusion = false});
    const Frame all = frame(camera_at(from), {.width = kSize, .height = kSize, .channels = kAllChannels});
    const std::size_t drawn = renderer_->object_statistics().drawn_spheres;
    load(scene);
    const Frame some = frame(camera_at(from), {.width = kSize, .height = kSize, .channels = kAllChannels});
    EXPECT_EQ(all.instance.pixels, some.instance.pixels);
    EXPECT_EQ(all.color.pixels, some.color.pixels);
    EXPECT_LT(renderer_->object_statistics().drawn_spheres, drawn);
  }
}

// Any polygon, the rectangle, and the paper's texture space: the same surface.
TEST_F(ObjectScenes, ProxiesAndAcceptanceMakeNoDifference) {
  ShapeRandom random(4);
  ObjectScene scene = cloud({0, 0, 0}, 500);
  for (int i = 0; i < 130; ++i) {
    Object& object = scene.objects.emplace_back();
    object.shape = random_shape(i % kShapeKinds, random);
    object.transform = glm::dmat4(random.rotation() * random.scale(0.2, 1));
    object.transform[3] = glm::dvec4(random.direction() * random.uniform(4, 7), 1);
  }
  for (const glm::dvec3 from : {glm::dvec3(-14, 0, 0), glm::dvec3(0, 0, 0)}) {
    load(scene, {.polygon = 12});
    const Frame expected = frame(camera_at(from));
    const ObjectOptions options[] = {{.polygon = 3},         {.polygon = 4}, {.polygon = 32}, {.rectangle = true}, {},
                                     {.texture_space = true}};
    for (const ObjectOptions& option : options) {
      load(scene, option);
      const Frame f = frame(camera_at(from));
      long other = 0, seen = 0;
      for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
          seen += expected.instance.at(x, y, 0) != 0;
          if (f.instance.at(x, y, 0) != expected.instance.at(x, y, 0)) {
            ++other;
          } else if (expected.instance.at(x, y, 0) != 0) {
            // The rasterizer's own depth of flat shapes is coarser.
            const double tolerance = option.texture_space ? 2e-3 : 1e-6;
            EXPECT_NEAR(f.depth_m.at(x, y, 0) / expected.depth_m.at(x, y, 0), 1, tolerance);
          }
        }
      }
      EXPECT_GT(seen, 5000);
      EXPECT_LE(other, option.texture_space ? seen / 500 : 2) << option.polygon;
    }
  }
}

// Four samples a pixel against 8 x 8 rays: outlines are as smooth as the samples allow, no more is changed.
TEST_F(ObjectScenes, OutlinesAreAntialiased) {
  ShapeRandom random(6);
  ObjectScene scene = cloud({9, 0, 0}, 60);
  for (int i = 0; i < 26; ++i) {
    Object& object = scene.objects.emplace_back();
    object.shape = random_shape(i % kShapeKinds, random);
    object.transform[3] = glm::dvec4(9, (i % 5 - 2) * 1.8, (i / 5 - 2) * 1.8, 1);
  }
  load(scene);
  const Camera camera = camera_at({-3, 0, 0});
  constexpr int kSide = 96;
  const Frame fine = frame(camera, {.width = 8 * kSide, .height = 8 * kSide, .samples = 1});
  const auto error = [&](int samples) {
    const Frame f = frame(camera, {.width = kSide, .height = kSide, .samples = samples});
    double sum = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        // In linear light, where samples are averaged.
        const auto linear = [](std::uint8_t v) { return std::pow(v / 255.0, 2.2); };
        double mean = 0;
        for (int i = 0; i < 64; ++i) mean += linear(fine.color.at(8 * x + i % 8, 8 * y + i / 8, 1)) / 64;
        const double d = linear(f.color.at(x, y, 1)) - mean;
        sum += d * d;
      }
    }
    return std::sqrt(sum / (kSide * kSide));
  };
  const double one = error(1), four = error(4);
  std::printf("root mean square error of the picture: %.4f with 1 sample, %.4f with 4\n", one, four);
  EXPECT_LT(four, 0.55 * one);
}

// Edges of an object before itself: rims, and where the box cuts an open quadric off before its back.
TEST_F(ObjectScenes, EdgesWithinObjectsAreAntialiased) {
  ShapeRandom random(7);
  ObjectScene scene;
  for (int i = 0; i < 28; ++i) {
    Object& object = scene.objects.emplace_back();
    if (i < 14) {
      object.shape = Quadric{.coefficients = kQuadricFamily[static_cast<std::size_t>(i)]};
    } else {
      object.shape = random_shape(8 + i % 4, random);
    }
    object.transform = glm::dmat4(random.rotation() * 0.9);
    object.transform[3] = glm::dvec4(9, (i % 6 - 2.5) * 1.7, (i / 6 - 2) * 1.7, 1);
  }
  // Shadows have edges of their own.
  load(scene, {.shadows = false});
  const Camera camera = camera_at({-3, 0, 0});
  constexpr int kSide = 128, kRays = 8;
  const Frame fine = frame(camera, {.width = kRays * kSide, .height = kRays * kSide, .samples = 1});
  const Frame who = frame(camera, {.width = kRays * kSide, .height = kRays * kSide, .channels = kInstance});
  const auto linear = [](std::uint8_t v) { return std::pow(v / 255.0, 2.2); };
  // Of a pixel that is all one object's, its mean and how far its rays are apart.
  const auto part_off = [&](int samples) {
    const Frame f = frame(camera, {.width = kSide, .height = kSide, .samples = samples});
    double sum = 0;
    int edges = 0;
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        double mean = 0, least = 1, most = 0;
        bool one = true;
        for (int i = 0; i < kRays * kRays; ++i) {
          const int rx = kRays * x + i % kRays, ry = kRays * y + i / kRays;
          const std::uint32_t seen = who.instance.at(rx, ry, 0);
          one = one && seen != 0 && seen == who.instance.at(kRays * x, kRays * y, 0);
          const double value = linear(fine.color.at(rx, ry, 1));
          mean += value / (kRays * kRays);
          least = std::min(least, value), most = std::max(most, value);
        }
        if (!one || most - least < 0.15) continue;
        ++edges;
        sum += std::abs(linear(f.color.at(x, y, 1)) - mean) / (most - least);
      }
    }
    EXPECT_GT(edges, 200);
    return sum / edges;
  };
  const double one = part_off(1), four = part_off(4);
  std::printf("parts of edge pixels off by %.3f with 1 sample, %.3f with 4\n", one, four);
  // A sample of four is a quarter of the pixel: even over that, an eighth at most and half of it on the mean; edges that bend
  // or cross within a pixel, and rims of three surfaces, are more.
  EXPECT_LT(four, 0.08);
}

TEST_F(ObjectScenes, TenThousandKilometresAwayTheyLookTheSame) {
  const auto render = [&](glm::dvec3 origin) {
    ObjectScene scene = cloud(origin, 2000);
    ShapeRandom random(8);
    for (int i = 0; i < 26; ++i) {
      Object& object = scene.objects.emplace_back();
      object.shape = random_shape(i % kShapeKinds, random);
      object.transform[3] = glm::dvec4(origin + glm::dvec3(0, (i % 6 - 2.5) * 1.8, (i / 6 - 2.5) * 1.8), 1);
    }
    load(scene);
    return frame(camera_at(origin + glm::dvec3(-12, 0, 0)));
  };
  const Frame here = render({0, 0, 0}), there = render({1e7, -7e6, 1e4});
  long other = 0;
  for (std::size_t i = 0; i < here.instance.pixels.size(); ++i) {
    other += here.instance.pixels[i] != there.instance.pixels[i];
    if (here.instance.pixels[i] == there.instance.pixels[i] && here.instance.pixels[i] != 0) {
      EXPECT_NEAR(there.depth_m.pixels[i] / here.depth_m.pixels[i], 1, 1e-5);
    }
  }
  EXPECT_LE(other, 4);
}

// A road on level ground, a tank half in the ground on it, a pole before it and one below the ground.
TEST_F(ObjectScenes, RoadsAndGroundHideAndAreHidden) {
  std::vector<Anchor> anchors;
  for (int i = 0; i < 10; ++i) anchors.push_back({.position_m = {i * 20.0, 0.0}});
  auto road = road_from_anchors(anchors, {});
  ASSERT_TRUE(road.ok());
  Network network;
  network.roads.push_back(std::move(*road));
  network.roads[0].id = "1";
  ASSERT_TRUE(renderer_->load_roads(network).ok());
  TerrainMesh ground;
  ground.positions_m = {{-50, -200, -0.1f}, {300, -200, -0.1f}, {300, 200, -0.1f}, {-50, 200, -0.1f}};
  ground.normals = std::vector<glm::vec3>(4, {0, 0, 1});
  ground.triangles = {0, 1, 2, 0, 2, 3};
  ASSERT_TRUE(renderer_->load_ground(std::vector<TerrainMesh>{ground}).ok());
  ObjectScene scene;
  scene.objects.push_back({.name = "tank", .shape = Cylinder{{60, 0, -2}, {60, 0, 2}, 3}});
  scene.objects.push_back({.name = "pole", .shape = Cylinder{{30, 1, 0}, {30, 1, 6}, 0.1}});
  scene.objects.push_back({.name = "buried", .shape = Sphere{{40, 5, -2}, 1.5}});
  load(scene);
  Camera camera = camera_at({10, 0, 2.5});
  camera.pitch_deg = -3;
  const Frame f = frame(camera);
  const ObjectRays rays(scene);
  long tank = 0, pole = 0, road_px = 0;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const glm::dvec3 ray = pixel_ray(camera, kSize, kSize, x, y);
      const auto hit = rays.nearest(camera.position_m, ray, camera.near_m);
      const double ground_t = ray.z < 0 ? -camera.position_m.z / ray.z : 1e9;
      const std::uint32_t seen = f.instance.at(x, y, 0);
      // Objects follow the one road in the channel. The road is 0 high, the ground 0.1 below.
      EXPECT_NE(seen, 4u);
      if (hit && hit->t < ground_t * 0.99) {
        EXPECT_EQ(seen, hit->instance + 2) << x << "," << y;
      }
      if (hit && hit->t > ground_t * 1.3) {
        EXPECT_LT(seen, 2u) << x << "," << y;
      }
      tank += seen == 2;
      pole += seen == 3;
      road_px += seen == 1;
    }
  }
  EXPECT_GT(tank, 150);
  EXPECT_GT(pole, 50);
  EXPECT_GT(road_px, 2000);
}

TEST_F(ObjectScenes, BadOnesAreRefusedByNameAndTheRestStaysDrawn) {
  ObjectScene scene = cloud({0, 0, 0}, 10);
  load(scene);
  ObjectScene bad;
  bad.objects.push_back({.name = "dome", .shape = Sphere{{0, 0, 0}, 0}});
  const Status refused = renderer_->load_objects(bad);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kData);
  EXPECT_NE(refused.error().text().find("object 0 (dome)"), std::string::npos) << refused.error().text();
  EXPECT_EQ(renderer_->object_statistics().spheres, 10u);
  EXPECT_EQ(renderer_->load_objects(scene, {.polygon = 2}).error().code, ErrorCode::kUsage);
  load(ObjectScene{});
  EXPECT_EQ(frame(camera_at({0, 0, 0})).instance.pixels, std::vector<std::uint32_t>(kSize * kSize, 0));
}

// Before anything is made of them.
TEST_F(ObjectScenes, MoreThanTheDriverHoldsAreRefusedByName) {
  ObjectScene scene = cloud({0, 0, 0}, 10);
  load(scene);
  ObjectScene many;
  many.sphere_sets.resize(2);
  many.sphere_sets[0].items.push_back({{0, 0, 0}, 1});
  many.sphere_sets[1].name = "dust";
  many.sphere_sets[1].items.resize(10'000'000, {{0, 0, 0}, 1});
  Status refused = renderer_->load_objects(many);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().text().find("sphere set 1 (dust): its 10000000 spheres are more than"), std::string::npos)
      << refused.error().text();
  many.sphere_sets.clear();
  many.objects.resize(700'000, {.name = "crate", .shape = Parallelepiped{}});
  refused = renderer_->load_objects(many);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().text().find("(crate): from here on the objects that are drawn as 'box' are more than"),
            std::string::npos)
      << refused.error().text();
  EXPECT_EQ(renderer_->object_statistics().spheres, 10u);
}

// What is at the limits of the numbers leaves no pixel that is none.
TEST_F(ObjectScenes, ExtremesMakeFinitePixels) {
  ShapeRandom random(13);
  ObjectScene scene;
  for (int i = 0; i < 20 * kShapeKinds; ++i) {
    Object& object = scene.objects.emplace_back();
    object.shape = random_shape(i % kShapeKinds, random);
    // Squeezed up to 1e5-fold, tiny or huge; some with their middle at the eye.
    const double size = random.scale(1e-2, 1e6);
    const glm::dmat3 turn = random.rotation();
    object.transform = glm::dmat4(glm::dmat3(turn[0] * size, turn[1] * size, turn[2] * size * random.scale(1e-5, 1)));
    object.transform[3] = glm::dvec4(random.direction() * (i % 3 == 0 ? 0 : size * random.uniform(0, 3)), 1);
  }
  load(scene);
  for (int i = 0; i < 10; ++i) {
    Camera camera = camera_at({0, 0, 0});
    camera.yaw_deg = i * 36;
    camera.near_m = random.scale(1e-5, 1);
    const Frame f = frame(camera, {.width = 64, .height = 64, .channels = kAllChannels});
    for (int k = 0; k < 64 * 64; ++k) {
      EXPECT_FALSE(std::isnan(f.depth_m.pixels[static_cast<std::size_t>(k)]));
      const float* n = &f.normal.pixels[static_cast<std::size_t>(3 * k)];
      const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      EXPECT_TRUE(length == 0 || std::abs(length - 1) < 1e-5) << length;
    }
  }
}

}  // namespace
}  // namespace roadgen::test
