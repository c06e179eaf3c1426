// The renderer against the double-precision truth: coverage, depth, (s, t) and ids of every pixel by casting the eye
// ray on the CPU; and the picture against itself when the whole world is moved.
#include "roadgen/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/query/road_index.h"
#include "roadgen/render/flight.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen {
namespace {

constexpr int kWidth = 320, kHeight = 200;

// A winding road, level or over hills, whose first anchor lies at `origin`.
Network winding_network(bool hilly, glm::dvec3 origin) {
  std::vector<Anchor> anchors;
  glm::dvec2 p(0, 0);
  for (int i = 0; i < 80; ++i) {
    const double s = i * 14.0, heading = 1.2 * std::sin(s / 60) + 0.5 * std::sin(s / 23);
    const double z = hilly ? 12 * std::sin(p.x / 90) + 2 * std::sin(p.x / 33) : 0;
    anchors.push_back({.position_m = p + glm::dvec2(origin), .elevation_m = origin.z + z});
    p += 14.0 * glm::dvec2(std::cos(heading), std::sin(heading));
  }
  auto road = road_from_anchors(anchors, {});
  EXPECT_TRUE(road.ok());
  Network network;
  network.roads.push_back(std::move(*road));
  network.roads[0].id = "1";
  return network;
}

struct Hit {
  double depth_m, s_m, t_m, edge_m;  // edge: |t| - W, negative inside
};

// The first place where the ray through a pixel meets a carriageway, in double.
std::optional<Hit> cast(const Network& network, const Camera& camera, double px, double py) {
  const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, px, py);
  std::optional<Hit> best;
  for (const Segment& segment : network.roads[0].segments) {
    const double length = segment.chord_length_m();
    const glm::dvec2 origin = to_chord(segment, glm::dvec2(camera.position_m));
    const glm::dvec2 along = to_chord(segment, glm::dvec2(camera.position_m) + glm::dvec2(ray)) - origin;
    const Cubic& z = segment.elevation_m;
    const auto above = [&](double k) {
      const auto c =
          Lib::road_project(origin.x + k * along.x, origin.y + k * along.y, segment.slope_start, segment.slope_end);
      return camera.position_m.z + k * ray.z - z.value(arc_at(segment, c.u));
    };
    // The part of the ray over the segment's own surroundings, sampled for a change of sign, then bisected: slow,
    // independent of the shader's Newton iteration.
    const Quad quad = fitted_quad(segment);
    const double reach = std::max({quad.y_high, -quad.y_low, 0.3});
    double k0 = camera.near_m, k1 = 3000;
    const auto clip = [&](double o, double d, double low, double high) {
      if (std::abs(d) < 1e-14) return o >= low && o <= high;
      const double a = (low - o) / d, b = (high - o) / d;
      k0 = std::max(k0, std::min(a, b));
      k1 = std::min(k1, std::max(a, b));
      return true;
    };
    if (!clip(origin.x, along.x, -reach, 1 + reach) || !clip(origin.y, along.y, quad.y_low, quad.y_high) || k0 >= k1)
      continue;
    constexpr int kSteps = 64;
    double before = above(k0);
    for (int i = 1; i <= kSteps; ++i) {
      const double ka = k0 + (k1 - k0) * (i - 1) / kSteps, kb = k0 + (k1 - k0) * i / kSteps;
      const double after = above(kb);
      if (before * after <= 0) {
        double low = ka, high = kb;
        for (int j = 0; j < 60; ++j) {
          const double middle = 0.5 * (low + high);
          (before * above(middle) <= 0 ? high : low) = middle;
        }
        const glm::dvec2 p = origin + low * along;
        const bool inside = p.x + segment.slope_start * p.y >= -1e-9 && 1 - p.x - segment.slope_end * p.y >= -1e-9;
        const auto c = Lib::road_project(p.x, p.y, segment.slope_start, segment.slope_end);
        const double s = arc_at(segment, c.u), edge = std::abs(c.v) * length - segment.left_m.value(s);
        if (inside && edge < 0.5) {
          if (!best || low < best->depth_m) best = Hit{low, segment.s_start_m + s, c.v * length, edge};
          break;
        }
      }
      before = after;
    }
  }
  return best;
}

class RendererTest : public test::GlTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override { renderer_.emplace(make_renderer(ContextKind::kOsmesa)); }
  void TearDown() override {
    renderer_.reset();
    GlTest::TearDown();
  }
  Renderer make_renderer(ContextKind kind) {
    auto renderer = Renderer::create(*make_context(kind));
    EXPECT_TRUE(renderer.ok()) << renderer.error().text();
    return std::move(*renderer);
  }
  static Frame draw(Renderer& renderer, const Network& network, const Camera& camera,
                    unsigned channels = kAllChannels) {
    EXPECT_TRUE(renderer.load_roads(network).ok());
    auto frame = renderer.render(camera, {.width = kWidth, .height = kHeight, .channels = channels});
    EXPECT_TRUE(frame.ok());
    return std::move(*frame);
  }

  std::optional<Renderer> renderer_;
};

INSTANTIATE_TEST_SUITE_P(LevelAndHilly, RendererTest, testing::Bool(),
                         [](const auto& test) { return test.param ? "Hilly" : "Level"; });

TEST_P(RendererTest, EveryPixelAgreesWithTheRayCastInDouble) {
  const Network network = winding_network(GetParam(), {0, 0, 0});
  std::size_t compared = 0, wrong = 0, on_road = 0;
  double worst_depth = 0, worst_s = 0, worst_t = 0;
  for (const double s : {40.0, 233.0, 610.0}) {
    for (const double height : {1.2, 9.0, 60.0}) {
      Camera camera = drive_camera(network.roads[0], s, -1.6, height);
      camera.pitch_deg -= 4 + height / 3;
      const Frame frame = draw(*renderer_, network, camera);
      for (int y = 0; y < kHeight; y += 3) {
        for (int x = 0; x < kWidth; x += 3) {
          const auto hit = cast(network, camera, x, y);
          const double pixel = 2 * std::tan(camera.fov_deg * M_PI / 360) / kHeight;
          const bool drawn = frame.road.at(x, y, 0) >= 0;
          // A pixel whose centre lies within a hundredth of a pixel of an edge, as seen, may fall either way.
          const auto left = cast(network, camera, x - 0.02, y), right = cast(network, camera, x + 0.02, y);
          const auto up = cast(network, camera, x, y - 0.02), down = cast(network, camera, x, y + 0.02);
          const auto inside = [](const std::optional<Hit>& h) { return h && h->edge_m < 0; };
          if (inside(left) != inside(right) || inside(up) != inside(down)) continue;
          ++compared;
          if (drawn != inside(hit)) {
            ++wrong;
            continue;
          }
          if (!drawn) continue;
          ++on_road;
          worst_depth = std::max(worst_depth, std::abs(frame.depth_m.at(x, y, 0) - hit->depth_m) / hit->depth_m);
          worst_s = std::max(worst_s, std::abs(frame.road.at(x, y, 1) - hit->s_m) / (1 + hit->depth_m));
          worst_t =
              std::max(worst_t, std::abs(frame.road.at(x, y, 2) - hit->t_m) / std::max(hit->depth_m * pixel, 1e-3));
        }
      }
    }
  }
  std::printf("compared %zu pixels, %zu on the road, %zu wrong; depth %.2e relative, s %.2e m per m, t %.2e pixels\n",
              compared, on_road, wrong, worst_depth, worst_s, worst_t);
  EXPECT_GT(on_road, 4000u);
  // A ray that nearly touches a crest can miss by rounding: at most one pixel in 20,000.
  EXPECT_LE(static_cast<double>(wrong), 5e-5 * static_cast<double>(compared));
  // The intersection stops at a hundredth of a pixel of height, which a grazing ray stretches along itself.
  EXPECT_LT(worst_depth, 2e-3);
  EXPECT_LT(worst_s, 2e-3);
  EXPECT_LT(worst_t, 0.2);
}

TEST_P(RendererTest, DepthUnprojectedLiesOnTheRoadThatTheQueryNames) {
  const Network network = winding_network(GetParam(), {0, 0, 0});
  const RoadIndex index(network);
  Camera camera = drive_camera(network.roads[0], 120, -1.6, 1.3);
  camera.pitch_deg -= 6;
  const Frame frame = draw(*renderer_, network, camera);
  std::size_t compared = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (frame.road.at(x, y, 0) < 0 || frame.depth_m.at(x, y, 0) > 60) continue;
      const glm::dvec3 p =
          camera.position_m + static_cast<double>(frame.depth_m.at(x, y, 0)) * pixel_ray(camera, kWidth, kHeight, x, y);
      const auto found = index.to_road(p, 0.05);
      ASSERT_TRUE(found) << x << ", " << y;
      EXPECT_NEAR(found->s_m, frame.road.at(x, y, 1), 5e-3) << x << ", " << y;
      EXPECT_NEAR(found->t_m, frame.road.at(x, y, 2), 2e-3) << x << ", " << y;
      EXPECT_NEAR(found->height_m, 0, 2e-3) << x << ", " << y;
      ++compared;
    }
  }
  EXPECT_GT(compared, 5000u);
}

TEST_P(RendererTest, AWorldMovedByTenThousandKilometresLooksTheSame) {
  // A multiple of the noise's and of no other period, so that only precision may differ.
  const glm::dvec3 far(4096.0 * 2441, -4096.0 * 2441, 0);
  const Network here = winding_network(GetParam(), {0, 0, 0}), there = winding_network(GetParam(), far);
  Camera camera = drive_camera(here.roads[0], 120, -1.6, 1.3);
  const Frame a = draw(*renderer_, here, camera, kColor);
  camera.position_m += far;
  const Frame b = draw(*renderer_, there, camera, kColor);
  int worst = 0;
  std::size_t different = 0;
  for (std::size_t i = 0; i < a.color.pixels.size(); ++i) {
    const int difference = std::abs(a.color.pixels[i] - b.color.pixels[i]);
    worst = std::max(worst, difference);
    different += difference > 1;
  }
  std::printf("largest difference %d/255, above 1/255: %zu of %zu values\n", worst, different, a.color.pixels.size());
  EXPECT_LE(worst, 1);
}

TEST_F(RendererTest, BadRequestsAreUsageErrors) {
  Camera camera;
  EXPECT_EQ(renderer_->render(camera, {.width = 0, .height = 10}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(renderer_->render(camera, {.width = 10, .height = 10, .samples = 3}).error().code, ErrorCode::kUsage);
  camera.fov_deg = 180;
  EXPECT_EQ(renderer_->render(camera, {.width = 10, .height = 10}).error().code, ErrorCode::kUsage);
  camera = {};
  camera.position_m.x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(renderer_->render(camera, {.width = 10, .height = 10}).error().code, ErrorCode::kUsage);
}

TEST_F(RendererTest, AnEmptySceneIsSkyAndInfiniteDepth) {
  Camera camera;
  camera.pitch_deg = 20;
  const Frame frame = draw(*renderer_, Network{}, camera);
  EXPECT_TRUE(
      std::all_of(frame.depth_m.pixels.begin(), frame.depth_m.pixels.end(), [](float d) { return std::isinf(d); }));
  EXPECT_TRUE(
      std::all_of(frame.label.pixels.begin(), frame.label.pixels.end(), [](std::uint32_t l) { return l == 0; }));
  EXPECT_GT(frame.color.pixels[2], frame.color.pixels[0]);  // blue
}

TEST_F(RendererTest, EveryContextDrawsTheSameScene) {
  const Network network = winding_network(true, {0, 0, 0});
  Camera camera = drive_camera(network.roads[0], 120, -1.6, 1.3);
  camera.pitch_deg -= 5;
  const Frame reference = draw(*renderer_, network, camera);
  for (const ContextKind kind : {ContextKind::kEgl, ContextKind::kWindow}) {
    SCOPED_TRACE(context_kind_name(kind));
    if (kind == ContextKind::kWindow && !test::ensure_display()) GTEST_SKIP() << "no display and no Xvfb";
    Context* context = make_context(kind);
    if (!context) return;
    auto renderer = Renderer::create(*context);
    ASSERT_TRUE(renderer.ok()) << renderer.error().text();
    const Frame frame = draw(*renderer, network, camera);
    const auto color = compare(reference.color, frame.color);
    const auto depth = compare(reference.depth_m, frame.depth_m);
    ASSERT_TRUE(color.ok() && depth.ok());
    std::printf("%s, %s: color max %.0f/255, mean %.4f/255; depth max %.2e m\n", context_kind_name(kind),
                context->renderer().c_str(), color->max, color->mean, depth->max);
    if (context->is_software()) {
      // One rasterizer behind three windows: the same arithmetic, but for the compiler's freedom.
      EXPECT_LE(color->max, 2);
      EXPECT_LE(depth->max, 1e-3);
    } else {
      // Another rasterizer may round a sample of an edge the other way.
      EXPECT_LE(color->mean, 0.5);
    }
  }
}

}  // namespace
}  // namespace roadgen
