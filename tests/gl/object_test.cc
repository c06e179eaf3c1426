// Objects in the picture against their rays in double: coverage, depth and normal of every pixel, over ten thousand
// placements of each shape, near and far, tiny and huge, with the eye inside.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "roadgen/object/rays.h"
#include "roadgen/render/renderer.h"
#include "tests/gl/gl_fixture.h"
#include "tests/gl/object_pixels.h"

namespace roadgen::test {
namespace {

// Depth is to agree within this part of the distance, the normal within this angle, each and what it changes over kPixel_px
// of the picture: where the surface is steep, or the object itself a pixel wide, that is more, and single precision cannot
// tell rays that are nearer to one another.
constexpr double kDepth = 1e-6, kNormal_rad = 1e-4, kPixel_px = 1e-4;
// Likewise what they change when the eye moves by this part of the object's size, to which single precision knows places
// in the object's frame: more than the above where an eye is a thousandth of its size above a surface.
constexpr double kPlace = 0x1p-22;

struct Tally {
  long placements = 0, pixels = 0, covered = 0, edge = 0;
  long steep = 0, bent = 0;      // pixels beyond kDepth and kNormal_rad themselves
  double depth = 0, normal = 0;  // greatest errors
  std::string first;             // what was wrong first

  void wrong(const std::string& what) {
    if (first.empty()) first = what;
  }
};

// One pixel of the frame against the rays.
void compare(const Frame& frame, std::uint32_t instance, const Primitive& p, const Camera& camera, int x, int y,
             Tally& tally) {
  const int width = frame.label.width, height = frame.label.height;
  const auto hit = cast(p, camera, width, height, x, y);
  const bool drawn = frame.instance.at(x, y, 0) == instance;
  ++tally.pixels;
  const auto at = [&] {
    return " at pixel " + std::to_string(x) + "," + std::to_string(y) + " of placement " +
           std::to_string(tally.placements);
  };
  if (drawn != hit.has_value()) {
    ++tally.edge;
    if (same_around(p, camera, width, height, x, y, hit)) {
      tally.wrong((drawn ? "drawn, no hit" : "not drawn, hit at " + std::to_string(hit->t)) + at());
    }
    return;
  }
  if (!hit) return;
  ++tally.covered;
  const float depth = frame.depth_m.at(x, y, 0);
  const glm::dvec3 normal(frame.normal.at(x, y, 0), frame.normal.at(x, y, 1), frame.normal.at(x, y, 2));
  const double depth_error = std::abs(depth - hit->t) / hit->t;
  const double angle = std::asin(std::min(1.0, 0.5 * glm::length(normal - hit->normal))) * 2;
  if (!std::isfinite(depth) || !std::isfinite(angle)) return tally.wrong("not a number" + at());
  if (depth_error > kDepth || angle > kNormal_rad) {
    if (!same_around(p, camera, width, height, x, y, hit)) {
      ++tally.edge;
      return;
    }
    double depth_change = 0, normal_change = 0;
    const auto changed = [&](const Camera& from, double px, double py) {
      const auto other = cast(p, from, width, height, px, py);
      if (!other) return;
      depth_change = std::max(depth_change, std::abs(other->t - hit->t) / hit->t);
      normal_change = std::max(normal_change, glm::length(other->normal - hit->normal));
    };
    const double size = std::max({glm::length(p.axes[0]), glm::length(p.axes[1]), glm::length(p.axes[2])});
    for (const double side : {-1.0, 1.0}) {
      changed(camera, x + side * kPixel_px, y);
      changed(camera, x, y + side * kPixel_px);
      for (int axis = 0; axis < 3; ++axis) {
        Camera moved = camera;
        moved.position_m[axis] += side * kPlace * size;
        changed(moved, x, y);
      }
    }
    tally.steep += depth_error > kDepth;
    tally.bent += angle > kNormal_rad;
    if (depth_error > kDepth + depth_change) {
      tally.wrong("depth off by " + std::to_string(depth_error * 1e6) + "e-6" + at());
    }
    if (angle > kNormal_rad + normal_change) tally.wrong("normal off by " + std::to_string(angle) + at());
  }
  tally.depth = std::max(tally.depth, depth_error);
  tally.normal = std::max(tally.normal, angle);
}

// A grid of objects, one a cell, seen so that each about fills its cell: at a field of view of 0.003 degrees they are
// 1e5 radii and more away.
class Grid {
 public:
  static constexpr int kCells = 16, kCell_px = 16, kSize = kCells * kCell_px;

  Grid(int kind, ShapeRandom& random) {
    const double unit = random.scale(1e-3, 1e5);
    camera_.fov_deg = random.uniform(0, 1) < 0.3 ? random.scale(0.002, 0.01) : random.scale(0.01, 100);
    camera_.yaw_deg = random.uniform(0, 360);
    camera_.pitch_deg = random.uniform(-90, 90);
    camera_.roll_deg = random.uniform(-180, 180);
    camera_.position_m = random.direction() * unit * random.scale(1, 1e4);
    camera_.near_m = 1e-3 * unit;
    const double pixel = 2 * std::tan(camera_.fov_deg * std::numbers::pi / 360) / kSize;
    for (int i = 0; i < kCells * kCells; ++i) {
      const double x = (i % kCells + random.uniform(0.3, 0.7)) * kCell_px;
      const double y = (i / kCells + random.uniform(0.3, 0.7)) * kCell_px;
      const glm::dvec3 ray = pixel_ray(camera_, kSize, kSize, x - 0.5, y - 0.5);
      const double size = unit * random.scale(0.1, 10);
      // Its ball is 0.2 to 1.2 cells wide; where that is nearer than the ball allows, as near as that.
      const double angle = random.scale(0.1, 0.6) * kCell_px * pixel / glm::dot(ray, ray);
      const glm::dvec3 center = camera_.position_m + glm::normalize(ray) * (size * std::max(2.0, 1 / angle));
      glm::dmat4 transform(random.rotation() * size);
      transform[3] = glm::dvec4(center, 1);
      primitives_.push_back(add_shape(scene_, kind, transform, random));
    }
  }

  void check_frame(Renderer& renderer, Tally& tally) const {
    ASSERT_TRUE(renderer.load_objects(scene_).ok());
    const auto frame =
        renderer.render(camera_, {.width = kSize, .height = kSize, .channels = kDepth_ | kInstance | kNormal | kLabel});
    ASSERT_TRUE(frame.ok());
    for (int i = 0; i < kCells * kCells; ++i, ++tally.placements) {
      const Primitive& p = primitives_[static_cast<std::size_t>(i)];
      for (int y = 0; y < kCell_px; ++y) {
        for (int x = 0; x < kCell_px; ++x) {
          const int px = i % kCells * kCell_px + x, py = i / kCells * kCell_px + y;
          const std::uint32_t seen = frame->instance.at(px, py, 0);
          // A neighbour reaches into the cell and hides it.
          if (seen != 0 && seen != static_cast<std::uint32_t>(i + 1)) continue;
          compare(*frame, static_cast<std::uint32_t>(i + 1), p, camera_, px, py, tally);
        }
      }
    }
  }

 private:
  static constexpr unsigned kDepth_ = roadgen::kDepth;
  Camera camera_;
  ObjectScene scene_;
  std::vector<Primitive> primitives_;
};

// One object around the eye, near it or far behind.
void check_near(Renderer& renderer, int kind, ShapeRandom& random, Tally& tally) {
  constexpr int kSize = 24;
  const double size = random.scale(1e-2, 1e6);
  ObjectScene scene;
  const Primitive p = add_shape(scene, kind, glm::dmat4(random.rotation() * size), random);
  Camera camera;
  camera.position_m = random.direction() * size * random.uniform(0, 2.5);
  camera.yaw_deg = random.uniform(0, 360);
  camera.pitch_deg = random.uniform(-90, 90);
  camera.fov_deg = random.uniform(20, 140);
  camera.near_m = size * random.scale(1e-4, 0.3);
  ASSERT_TRUE(renderer.load_objects(scene).ok());
  const auto frame = renderer.render(
      camera, {.width = kSize, .height = kSize, .channels = roadgen::kDepth | kInstance | kNormal | kLabel});
  ASSERT_TRUE(frame.ok());
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) compare(*frame, 1, p, camera, x, y, tally);
  }
  ++tally.placements;
}

class ObjectShapes : public GlTest, public ::testing::WithParamInterface<int> {};

TEST_P(ObjectShapes, EveryPixelIsTheRaysOwn) {
  Context* context = make_context(ContextKind::kOsmesa);
  ASSERT_NE(context, nullptr);
  auto renderer = Renderer::create(*context);
  ASSERT_TRUE(renderer.ok());
  ShapeRandom random(static_cast<std::uint64_t>(GetParam()) + 7);
  Tally tally;
  for (int i = 0; i < 36; ++i) Grid(GetParam(), random).check_frame(*renderer, tally);
  const long far_pixels = tally.covered;
  for (int i = 0; i < 784; ++i) check_near(*renderer, GetParam(), random, tally);
  std::printf(
      "%-15s %ld placements, %ld pixels, %ld covered far and %ld near, %ld at edges; depth within 1e-6 but for %ld, at "
      "most "
      "%.1e; normal within 1e-4 rad but for %ld, at most %.1e\n",
      kind_name(GetParam(), random), tally.placements, tally.pixels, far_pixels, tally.covered - far_pixels, tally.edge,
      tally.steep, tally.depth, tally.bent, tally.normal);
  EXPECT_EQ(tally.first, "");
  EXPECT_EQ(tally.placements, 10000);
  // Enough was seen for this to mean anything.
  EXPECT_GT(tally.covered, 50000);
  EXPECT_LT(tally.edge, tally.covered / 100);
  EXPECT_LT(tally.steep + tally.bent, tally.covered / 50);
}

INSTANTIATE_TEST_SUITE_P(Kinds, ObjectShapes, ::testing::Range(0, kAllKinds));

}  // namespace
}  // namespace roadgen::test
