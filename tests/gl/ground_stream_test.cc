// What memory there is, and how slowly the ground is read, may not change a picture that waits for it, nor tear one that
// does not.
#include <condition_variable>
#include <cstdio>
#include <mutex>

#include <gtest/gtest.h>

#include "roadgen/import/import.h"
#include "roadgen/render/flight.h"
#include "roadgen/render/ground_batch.h"
#include "roadgen/render/render_target.h"
#include "roadgen/render/renderer.h"
#include "terrain/ground_source.h"
#include "terrain/terrain.h"
#include "terrain/terrain_file.h"
#include "tests/gl/pass_fixture.h"
#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

constexpr int kWidth = 320, kHeight = 180;
constexpr std::uint64_t kKey = 7;

// Reads as many bands as it was allowed to, but the first of each tile at once.
class SlowSource : public GroundSource {
 public:
  explicit SlowSource(std::shared_ptr<const GroundSource> source) : source_(std::move(source)) {}
  std::span<const GroundTile> tiles() const override { return source_->tiles(); }
  bool is_in_memory() const override { return false; }
  Status load(std::size_t tile, std::uint32_t first, std::uint32_t last) const override {
    if (last > 1) {
      std::unique_lock<std::mutex> lock(mutex_);
      allowed_.wait(lock, [&] { return left_ > 0; });
      --left_;
    }
    return source_->load(tile, first, last);
  }
  void release(std::size_t tile) const override { source_->release(tile); }
  void allow(int bands) {
    const std::lock_guard<std::mutex> lock(mutex_);
    left_ += bands;
    allowed_.notify_all();
  }

 private:
  std::shared_ptr<const GroundSource> source_;
  mutable std::mutex mutex_;
  mutable std::condition_variable allowed_;
  mutable int left_ = 0;
};

class GroundStreamTest : public test::PassTest {
 protected:
  void SetUp() override {
    PassTest::SetUp();
    if (HasFatalFailure()) return;
    auto built = Terrain::build(network_, &*elevation_);
    ASSERT_TRUE(built.ok()) << built.error().text();
    built_.emplace(std::move(*built));
    path_ = folder_.path("pass.ground");
    ASSERT_TRUE(write_terrain_file(*built_, kKey, path_).ok());
    for (const GroundTile& tile : built_->ground()->tiles()) {
      // As GroundBatch has them.
      mesh_bytes_ += 28 * tile.positions_m.size() + 12 * tile.triangle_count();
    }
  }
  Renderer renderer(std::shared_ptr<const GroundSource> ground, std::size_t budget_bytes) {
    RendererOptions options;
    options.ground_budget_bytes = budget_bytes;
    auto made = Renderer::create(*make_context(ContextKind::kOsmesa), options);
    EXPECT_TRUE(made.ok() && made->load_roads(network_).ok() && made->load_ground(std::move(ground)).ok());
    return std::move(*made);
  }
  std::shared_ptr<const GroundSource> from_file() {
    const auto read = read_terrain_file(path_, kKey);
    EXPECT_TRUE(read.ok());
    return read->ground();
  }

  test::TemporaryFolder folder_;
  std::optional<Terrain> built_;
  std::string path_;
  std::size_t mesh_bytes_ = 0;
};

Camera camera(const Network& network, int i) {
  Camera c = i % 2 == 0 ? drive_camera(network.roads[0], 900.0 * i, -1.75, 1.5)
                        : flight_camera(network.roads[0], 900.0 * i, {.height_m = 150});
  c.yaw_deg += 77 * i;
  return c;
}

// Every channel and the picture, from memory and from a file, with a tenth of the memory that the mesh takes.
TEST_F(GroundStreamTest, PicturesAreTheSameWithinATenthOfTheMesh) {
  const std::size_t tenth = mesh_bytes_ / 10;
  Renderer whole = renderer(built_->ground(), std::size_t{1} << 30);
  Renderer small = renderer(built_->ground(), tenth), file = renderer(from_file(), tenth);
  std::size_t batches = 0, most_bytes = 0;
  for (int i = 0; i < 8; ++i) {
    const FrameOptions request{.width = kWidth, .height = kHeight, .channels = kAllChannels};
    const auto a = whole.render(camera(network_, i), request);
    ASSERT_TRUE(a.ok());
    EXPECT_EQ(whole.ground_statistics().batches, 1u);
    for (Renderer* other : {&small, &file}) {
      const auto b = other->render(camera(network_, i), request);
      ASSERT_TRUE(b.ok()) << b.error().text();
      EXPECT_TRUE(a->color.pixels == b->color.pixels);
      EXPECT_TRUE(a->depth_m.pixels == b->depth_m.pixels);
      EXPECT_TRUE(a->label.pixels == b->label.pixels);
      EXPECT_TRUE(a->normal.pixels == b->normal.pixels);
      EXPECT_TRUE(a->road.pixels == b->road.pixels);
      const GroundStatistics used = other->ground_statistics();
      EXPECT_EQ(used.drawn_triangles, whole.ground_statistics().drawn_triangles);
      EXPECT_LE(used.gpu_bytes, tenth);
      EXPECT_LE(used.loaded_bytes, tenth);
      EXPECT_EQ(used.waiting_tiles, 0u);
      batches = std::max(batches, used.batches);
      most_bytes = std::max(most_bytes, used.gpu_bytes);
    }
  }
  std::printf("mesh of %zu bytes; at most %zu on the GPU of %zu, a frame in up to %zu batches\n", mesh_bytes_,
              most_bytes, tenth, batches);
  EXPECT_GT(batches, 4u);
}

// Frames that do not wait, while little by little is read: the sky, which is of a colour that no ground has, is never seen
// through the ground.
TEST_F(GroundStreamTest, FlightsThatDoNotWaitHaveNoHolesAndKeepTheirBudget) {
  const std::size_t budget = mesh_bytes_ / 4;
  const auto slow = std::make_shared<SlowSource>(from_file());
  Renderer flying = renderer(slow, budget);
  ImageF magenta(4, 2, 3);
  for (std::size_t i = 0; i < magenta.pixels.size(); ++i) magenta.pixels[i] = i % 3 == 1 ? 0.0f : 50.0f;
  ASSERT_TRUE(flying.load_environment(magenta).ok());
  ASSERT_TRUE(contexts_[0]->make_current().ok());
  auto target = RenderTarget::create({.width = kWidth, .height = kHeight});
  ASSERT_TRUE(target.ok());
  const auto is_sky = [](const Image8& p, int x, int y) {
    return p.at(x, y, 0) > 150 && p.at(x, y, 2) > 150 && p.at(x, y, 1) < 60;
  };
  const auto fly = [&](const Camera& from) {
    EXPECT_TRUE(flying.draw(from, kWidth, kHeight, 1, target->framebuffer()).ok());
    return target->read_rgba8();
  };
  std::size_t holes = 0, coarser = 0, skies = 0;
  Camera last;
  for (int i = 0; i < 60; ++i) {
    last = flight_camera(network_.roads[0], 2000 + 8.0 * i, {.height_m = 120});
    last.yaw_deg += 10 * i;
    last.pitch_deg = -50;
    const Image8 picture = fly(last);
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) holes += is_sky(picture, x, y);
    }
    const GroundStatistics used = flying.ground_statistics();
    EXPECT_LE(used.gpu_bytes, budget);
    EXPECT_LE(used.loaded_bytes, budget);
    coarser += used.waiting_tiles;
    slow->allow(1);
  }
  // Looking up, there is such a sky.
  Camera up = last;
  up.pitch_deg = 60;
  const Image8 above = fly(up);
  for (int x = 0; x < kWidth; ++x) skies += is_sky(above, x, 0);
  slow->allow(1000000);
  std::printf("%zu holes; %zu tiles drawn coarser than asked for\n", holes, coarser);
  EXPECT_EQ(holes, 0u);
  EXPECT_GT(coarser, 30u);
  EXPECT_EQ(skies, static_cast<std::size_t>(kWidth));
}

// Where all that the view asks for goes into the budget, frames that do not wait come to be the one that does.
TEST_F(GroundStreamTest, WhatWasCoarserBecomesAsFineAsAskedFor) {
  Renderer flying = renderer(from_file(), std::size_t{1} << 30), waiting = renderer(built_->ground(), 1 << 30);
  ASSERT_TRUE(contexts_[0]->make_current().ok());
  auto target = RenderTarget::create({.width = kWidth, .height = kHeight});
  ASSERT_TRUE(target.ok());
  std::size_t coarser = 0;
  for (int i = 0; i < 500; ++i) {
    EXPECT_TRUE(flying.draw(camera(network_, 3), kWidth, kHeight, 1, target->framebuffer()).ok());
    if (flying.ground_statistics().waiting_tiles == 0) break;
    ++coarser;
  }
  EXPECT_GT(coarser, 0u);
  EXPECT_EQ(flying.ground_statistics().waiting_tiles, 0u);
  const Image8 end = target->read_rgba8();
  const auto whole = waiting.render(camera(network_, 3), {.width = kWidth, .height = kHeight, .samples = 1});
  ASSERT_TRUE(whole.ok());
  EXPECT_TRUE(end.pixels == whole->color.pixels);
}

// A file that is damaged while it is read is an error of the frame that needs it.
TEST_F(GroundStreamTest, DamageInUseIsToldAndNotDrawn) {
  const auto ground = from_file();
  const std::string whole = test::text_of(path_);
  {
    std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
    for (std::size_t at = whole.size() / 3; at < whole.size(); at += 1000) {
      file.seekp(static_cast<std::streamoff>(at));
      file.put(static_cast<char>(whole[at] ^ 16));
    }
  }
  Renderer renderer_of_it = renderer(ground, std::size_t{1} << 30);
  const auto frame = renderer_of_it.render(camera(network_, 1), {.width = kWidth, .height = kHeight});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kData);
}

TEST_F(GroundStreamTest, TooSmallABudgetIsRefused) {
  RendererOptions options;
  options.ground_budget_bytes = kLeastGroundBytes - 1;
  EXPECT_EQ(Renderer::create(*make_context(ContextKind::kOsmesa), options).error().code, ErrorCode::kUsage);
  // The least there is: it takes batches of a few pages each.
  Renderer least = renderer(built_->ground(), kLeastGroundBytes), whole = renderer(built_->ground(), 1 << 30);
  const FrameOptions request{.width = 160, .height = 90};
  const auto a = least.render(camera(network_, 2), request), b = whole.render(camera(network_, 2), request);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE(a->color.pixels == b->color.pixels);
  EXPECT_LE(least.ground_statistics().gpu_bytes, kLeastGroundBytes);
}

}  // namespace
}  // namespace roadgen
