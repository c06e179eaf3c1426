// Where what covers objects on the screen is easily wrong: the eye within them, the near plane through them, parts of them or
// all behind the eye, edge-on and along their axes, far away and smaller than a pixel. No pixel that a ray in double hits is
// lost, none is drawn that no ray hits, none is not a number; for every kind, with few and with many corners.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "tests/gl/gl_fixture.h"
#include "tests/gl/object_pixels.h"

namespace roadgen::test {
namespace {

enum Case { kWithin, kCut, kAside, kBehind, kEdgeOn, kFarAway, kTiny, kCases };
constexpr const char* kCaseNames[] = {"eye within", "near plane through", "partly behind the eye", "behind the eye",
                                      "edge-on",    "1e5 radii away",     "less than a pixel"};

// Yaw and pitch of a direction.
void look_along(Camera& camera, glm::dvec3 d) {
  camera.yaw_deg = std::atan2(d.y, d.x) * 180 / std::numbers::pi;
  camera.pitch_deg = std::asin(std::clamp(d.z / glm::length(d), -1.0, 1.0)) * 180 / std::numbers::pi;
}

// In radii of a ball around the object.
double radius_of(const Primitive& p) {
  const ObjectBounds b = bounds(p);
  return 0.5 * glm::length(b.high_m - b.low_m);
}

// From where an object is seen edge-on or along an axis of its, within 1e-6 rad: of a flat shape in its plane.
glm::dvec3 edge_on(const Primitive& p, ShapeRandom& random) {
  const glm::dvec3 axis = glm::normalize(p.axes[2]), across = glm::normalize(glm::cross(axis, random.direction()));
  const bool along = !primitive_row(p.kind).flat && random.index(2) == 0;
  return glm::normalize((along ? axis : across) + random.direction() * random.uniform(0, 1e-6));
}

Camera camera_of(Case which, const Primitive& p, int size_px, ShapeRandom& random) {
  const double r = radius_of(p);
  const glm::dvec3 middle = 0.5 * (bounds(p).low_m + bounds(p).high_m), from = random.direction();
  Camera camera;
  camera.roll_deg = random.uniform(-180, 180);
  camera.near_m = 1e-3 * r;
  camera.fov_deg = random.uniform(40, 120);
  const auto at = [&](glm::dvec3 direction, double distance) {
    camera.position_m = middle + direction * distance;
    look_along(camera, -direction);
  };
  switch (which) {
    case kWithin:
      at(from, r * random.uniform(0, 0.5));
      look_along(camera, random.direction());
      break;
    case kCut: {
      const double distance = r * random.uniform(1, 3);
      at(from, distance);
      camera.near_m = distance + r * random.uniform(-0.7, 0.7);
      camera.near_m = std::max(camera.near_m, 0.05 * r);
      break;
    }
    case kAside:
      // The plane of the eye goes through it.
      at(from, r * random.uniform(1.02, 2));
      look_along(camera, glm::normalize(glm::cross(from, random.direction())) - from * random.uniform(-0.4, 0.4));
      camera.fov_deg = random.uniform(90, 150);
      break;
    case kBehind:
      at(from, r * random.uniform(1.02, 3));
      look_along(camera, from);
      break;
    case kEdgeOn: {
      const double distance = r * random.uniform(2, 6);
      at(edge_on(p, random), distance);
      camera.fov_deg = 2 * std::atan(1.3 * r / distance) * 180 / std::numbers::pi;
      break;
    }
    default: {
      const double distance = which == kTiny ? r * random.scale(10, 1e5) : 1e5 * r;
      at(from, distance);
      // The ball's radius in pixels.
      const double wide = which == kTiny ? random.uniform(0.2, 0.7) : random.uniform(6, 18);
      camera.fov_deg = 2 * std::atan(0.5 * size_px / wide * r / distance) * 180 / std::numbers::pi;
      // Off the middle of the picture by up to two pixels each way.
      const double part = 2 * std::numbers::pi / 180 * camera.fov_deg / size_px;
      camera.yaw_deg += random.uniform(-part, part) * 180 / std::numbers::pi;
      camera.pitch_deg += random.uniform(-part, part) * 180 / std::numbers::pi;
      break;
    }
  }
  return camera;
}

class ObjectProxies : public GlTest, public ::testing::WithParamInterface<int> {};

TEST_P(ObjectProxies, LoseNoPixelWhereverTheEyeIs) {
  constexpr int kPlacements = 40, kSize = 40;
  Context* context = make_context(ContextKind::kOsmesa);
  ASSERT_NE(context, nullptr);
  auto renderer = Renderer::create(*context);
  ASSERT_TRUE(renderer.ok());
  const int kind = GetParam();
  std::vector<ObjectOptions> options = {{}, {.polygon = 3}, {.polygon = 32}};
  if (kind == 5 || kind == 6 || kind == kOfSet) options.push_back({.rectangle = true});
  ShapeRandom random(static_cast<std::uint64_t>(kind) + 40);
  std::string row;
  for (int which = 0; which < kCases; ++which) {
    long covered = 0, edge = 0;
    for (int i = 0; i < kPlacements * (which == kTiny ? 4 : 1); ++i) {
      ObjectScene scene;
      glm::dmat4 transform(random.rotation() * random.scale(1e-2, 1e4));
      transform[3] = glm::dvec4(random.direction() * 100.0, 1);
      const Primitive p = add_shape(scene, kind, transform, random);
      const int size = which == kTiny ? 8 : kSize;
      const Camera camera = camera_of(static_cast<Case>(which), p, size, random);
      for (const ObjectOptions& option : options) {
        ASSERT_TRUE(renderer->load_objects(scene, option).ok());
        const auto frame = renderer->render(
            camera, {.width = size, .height = size, .channels = roadgen::kDepth | kInstance | kNormal});
        ASSERT_TRUE(frame.ok());
        for (int y = 0; y < size; ++y) {
          for (int x = 0; x < size; ++x) {
            const auto hit = cast(p, camera, size, size, x, y);
            const bool drawn = frame->instance.at(x, y, 0) == 1;
            covered += drawn;
            const float depth = frame->depth_m.at(x, y, 0);
            const float normal = frame->normal.at(x, y, 0) + frame->normal.at(x, y, 1) + frame->normal.at(x, y, 2);
            EXPECT_TRUE(!std::isnan(depth) && std::isfinite(normal)) << kCaseNames[which] << " " << x << "," << y;
            if (drawn == hit.has_value()) continue;
            ++edge;
            EXPECT_FALSE(same_around(p, camera, size, size, x, y, hit))
                << kCaseNames[which] << ", placement " << i << ", polygon of " << option.polygon << ", pixel " << x
                << "," << y << (drawn ? ": drawn, no hit" : ": lost");
          }
        }
      }
    }
    row += std::string(which ? "; " : "") + kCaseNames[which] + " " + std::to_string(covered) + " (" +
           std::to_string(edge) + ")";
    if (which == kBehind) {
      EXPECT_EQ(covered, 0);
    } else if (which != kEdgeOn) {
      EXPECT_GT(covered, which == kTiny ? 10 : 200) << kCaseNames[which];
    }
  }
  std::printf("%s: pixels covered (within 0.01 of edges and unlike): %s\n", kind_name(kind, random), row.c_str());
}

INSTANTIATE_TEST_SUITE_P(Kinds, ObjectProxies, ::testing::Range(0, kAllKinds));

}  // namespace
}  // namespace roadgen::test
