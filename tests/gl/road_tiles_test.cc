// What culling, streaming and the limits of memory may not change: the picture.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "roadgen/render/renderer.h"
#include "roadgen/render/road_tiles.h"
#include "tests/common/city.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen {
namespace {

constexpr int kWidth = 160, kHeight = 100;

// A level city, and one on hills that crosses above it: both kinds of segments in most tiles.
Network two_cities() {
  Network network = test::city({.blocks = 14, .jitter_m = 20});
  Network upper = test::city({.blocks = 10, .center_m = {130, -470, 9}, .hill_m = 6, .jitter_m = 15, .seed = 5});
  for (Road& road : upper.roads) {
    road.id += "u";
    network.roads.push_back(std::move(road));
  }
  return network;
}

// Among the roads, above them looking straight down, or far away.
Camera random_camera(std::mt19937& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Camera c;
  c.yaw_deg = uniform(-180, 180);
  c.fov_deg = uniform(20, 100);
  const double kind = uniform(0, 1);
  if (kind < 0.5) {
    c.position_m = {uniform(-800, 800), uniform(-800, 800), uniform(0.5, 30)};
    c.pitch_deg = uniform(-30, 10);
    c.roll_deg = uniform(-20, 20);
  } else if (kind < 0.75) {
    c.position_m = {uniform(-800, 800), uniform(-800, 800), 20 * std::pow(100, uniform(0, 1))};
    c.pitch_deg = -90;
  } else {
    const double away = 800 * std::pow(20, uniform(0, 1));
    c.position_m = {away * std::cos(c.yaw_deg * M_PI / 180), away * std::sin(c.yaw_deg * M_PI / 180),
                    away * uniform(0, 0.5)};
    c.yaw_deg += uniform(0, 1) < 0.5 ? 180 : uniform(90, 270);
    c.pitch_deg = uniform(-30, 5);
  }
  return c;
}

class RoadTilesTest : public test::GlTest {
 protected:
  void SetUp() override { context_ = make_context(ContextKind::kOsmesa); }
  Renderer renderer(const Network& network, const RendererOptions& options) {
    auto made = Renderer::create(*context_, options);
    EXPECT_TRUE(made.ok()) << made.error().text();
    EXPECT_TRUE(made->load_roads(network).ok());
    return std::move(*made);
  }
  static Frame draw(Renderer& renderer, const Camera& camera, unsigned channels = kAllChannels, int width = kWidth,
                    int height = kHeight) {
    auto frame = renderer.render(camera, {.width = width, .height = height, .channels = channels});
    EXPECT_TRUE(frame.ok());
    return std::move(*frame);
  }
  static void expect_equal(const Frame& a, const Frame& b) {
    EXPECT_TRUE(a.color.pixels == b.color.pixels);
    EXPECT_TRUE(a.depth_m.pixels == b.depth_m.pixels);
    EXPECT_TRUE(a.label.pixels == b.label.pixels);
    EXPECT_TRUE(a.road.pixels == b.road.pixels);
  }

  Context* context_ = nullptr;
};

TEST_F(RoadTilesTest, CulledAndUnculledPicturesAreEqual) {
  const Network network = two_cities();
  Renderer culled = renderer(network, {.least_contribution = 0});
  Renderer whole = renderer(network, {.least_contribution = 0, .cull = false});
  std::mt19937 random(3);
  std::size_t drawn = 0, of = 0, frames_with_roads = 0;
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    const Camera camera = random_camera(random);
    const unsigned channels = i % 4 ? kColor : kAllChannels;
    const Frame a = draw(culled, camera, channels), b = draw(whole, camera, channels);
    expect_equal(a, b);
    drawn += culled.road_statistics().drawn_tiles;
    of += whole.road_statistics().drawn_tiles;
    ASSERT_EQ(whole.road_statistics().drawn_segments, network.segment_count());
    frames_with_roads += culled.road_statistics().drawn_tiles > 0;
  }
  std::printf("%zu of %zu tiles drawn, roads in %zu of 200 pictures\n", drawn, of, frames_with_roads);
  EXPECT_LT(static_cast<double>(drawn), 0.5 * static_cast<double>(of));
  EXPECT_GT(frames_with_roads, 100u);
}

TEST_F(RoadTilesTest, TheFarPlaneLeavesNothingOutThatIsNearer) {
  const Network network = two_cities();
  Renderer roads = renderer(network, {});
  std::mt19937 random(4);
  std::size_t kept = 0, left_out = 0;
  for (int i = 0; i < 80; ++i) {
    Camera camera = random_camera(random);
    camera.position_m.z = 40;
    const Frame whole = draw(roads, camera, kDepth | kRoad);
    camera.far_m = 500;
    const Frame cut = draw(roads, camera, kDepth | kRoad);
    for (std::size_t p = 0; p < whole.depth_m.pixels.size(); ++p) {
      if (whole.depth_m.pixels[p] < 500) {
        ASSERT_EQ(whole.depth_m.pixels[p], cut.depth_m.pixels[p]);
        ++kept;
      } else {
        left_out += cut.depth_m.pixels[p] != whole.depth_m.pixels[p];
      }
    }
  }
  EXPECT_GT(kept, 10000u);
  EXPECT_GT(left_out, 1000u);
}

TEST_F(RoadTilesTest, AFrameThatDoesNotFitIntoMemoryIsTheSame) {
  const Network network = two_cities();
  Renderer roomy = renderer(network, {}), tight = renderer(network, {.gpu_budget_bytes = 2 * kPageBytes}),
           tightest = renderer(network, {.gpu_budget_bytes = kPageBytes});
  std::mt19937 random(5);
  std::size_t batches = 0;
  for (int i = 0; i < 30; ++i) {
    SCOPED_TRACE(i);
    const Camera camera = random_camera(random);
    const Frame reference = draw(roomy, camera);
    expect_equal(reference, draw(tight, camera));
    expect_equal(reference, draw(tightest, camera));
    EXPECT_LE(roomy.road_statistics().batches, 2u);
    batches = std::max(batches, tight.road_statistics().batches);
  }
  EXPECT_EQ(tight.road_statistics().pool_bytes, 2 * kPageBytes);
  EXPECT_EQ(tightest.road_statistics().pool_bytes, kPageBytes);
  std::printf("up to %zu batches\n", batches);
  EXPECT_GT(batches, 10u);
}

TEST_F(RoadTilesTest, PagesAreUploadedWhenFirstSeenAndTheOldestMakesRoom) {
  const Network network = two_cities();
  const std::size_t pages = 6;
  Renderer roomy = renderer(network, {}), tight = renderer(network, {.gpu_budget_bytes = pages * kPageBytes});
  EXPECT_LT(roomy.road_statistics().pool_bytes, network.segment_count() * sizeof(RoadInstance) + 2 * kPageBytes);
  Camera above, aside;
  above.position_m = {-550, 0, 30};
  above.pitch_deg = aside.pitch_deg = -90;
  aside.position_m = {550, 0, 30};
  const auto uploaded = [](Renderer& r, const Camera& camera) {
    draw(r, camera, kColor);
    return r.road_statistics().uploaded_bytes;
  };
  EXPECT_GT(uploaded(roomy, above), 0u);
  EXPECT_EQ(uploaded(roomy, above), 0u);
  EXPECT_GT(uploaded(roomy, aside), 0u);
  EXPECT_EQ(uploaded(roomy, above), 0u);  // still there
  // The whole city passes through the small pool and pushes the first page out.
  EXPECT_GT(uploaded(tight, above), 0u);
  EXPECT_EQ(uploaded(tight, above), 0u);
  Camera high = above;
  high.position_m = {0, 0, 2000};
  EXPECT_GT(uploaded(tight, high), pages * kPageBytes);
  EXPECT_GT(uploaded(tight, above), 0u);
}

// The default's bound is for ground that roads cover entirely, in a picture of exact coverage. Of real streets, whose
// far parts the antialiasing shows by what they cover of a pixel, at most one step of 8 bits may be missed.
TEST_F(RoadTilesTest, WhatContributesLittleIsNotMissed) {
  std::mt19937 random(6);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (const double jitter : {0.0, 8.0}) {
    const Network network = test::city({.blocks = 250, .jitter_m = jitter});
    Renderer exact = renderer(network, {.least_contribution = 0}), fast = renderer(network, {});
    std::size_t counts[256] = {}, dropped = 0, of = 0;
    for (int i = 0; i < 24; ++i) {
      Camera camera;
      camera.fov_deg = 60;
      camera.position_m = {uniform(-300, 300), uniform(-300, 300), uniform(1.2, 2.5)};
      camera.yaw_deg = i % 3 == 0 ? 90.0 * (i / 3) + uniform(-2, 2) : uniform(-180, 180);  // a third along the streets
      camera.pitch_deg = uniform(-5, 5);
      camera.roll_deg = i % 2 ? uniform(-3, 3) : 0;
      const int samples = i % 4 < 2 ? 4 : 1;
      const FrameOptions options{.width = 640, .height = 360, .samples = samples};
      const auto a = exact.render(camera, options), b = fast.render(camera, options);
      ASSERT_TRUE(a.ok() && b.ok());
      of += exact.road_statistics().drawn_tiles;
      dropped += exact.road_statistics().drawn_tiles - fast.road_statistics().drawn_tiles;
      for (std::size_t p = 0; p < a->color.pixels.size(); ++p) {
        ++counts[std::abs(a->color.pixels[p] - b->color.pixels[p])];
      }
    }
    std::printf("jitter %.0f m: %zu of %zu tiles left out; values changed:", jitter, dropped, of);
    for (int i = 1; i < 256; ++i) {
      if (counts[i]) std::printf(" %zu by %d/255", counts[i], i);
    }
    std::printf(" of %zu\n", std::accumulate(counts, counts + 256, std::size_t{0}));
    EXPECT_GT(dropped, of * 2 / 5);
    EXPECT_EQ(std::accumulate(counts + 2, counts + 256, std::size_t{0}), 0u);
  }
}

TEST_F(RoadTilesTest, OptionsOutOfTheirRangeAreUsageErrors) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(Renderer::create(*context_, {.gpu_budget_bytes = 0}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(Renderer::create(*context_, {.gpu_budget_bytes = kPageBytes - 1}).error().code, ErrorCode::kUsage);
  for (const double x : {-0.1, 1.1, nan}) {
    EXPECT_EQ(Renderer::create(*context_, {.least_contribution = x}).error().code, ErrorCode::kUsage);
  }
}

}  // namespace
}  // namespace roadgen
