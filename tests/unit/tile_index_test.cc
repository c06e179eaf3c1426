// Culling without OpenGL: what is left out of a frame against the plain geometry of the camera.
#include "roadgen/render/tile_index.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/road/segment.h"

namespace roadgen {
namespace {

class Random {
 public:
  double operator()(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  glm::dvec3 point(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
  // Any direction, now and then one along an axis.
  Camera camera(double size) {
    Camera c;
    c.position_m = point(size);
    c.yaw_deg = (*this)(-180, 180);
    c.pitch_deg = (*this)(-90, 90);
    c.roll_deg = (*this)(-180, 180);
    c.fov_deg = (*this)(10, 120);
    if ((*this)(0, 1) < 0.2) c.yaw_deg = c.roll_deg = 0, c.pitch_deg = -90;
    if ((*this)(0, 1) < 0.5) c.far_m = (*this)(1, 3) * size;
    return c;
  }

 private:
  std::mt19937 engine_{11};
};

TEST(Frustum, SeesEveryBoxWithAPointThatProjectsIntoThePicture) {
  Random random;
  int inside = 0;
  for (int i = 0; i < 200000; ++i) {
    const Camera camera = random.camera(100);
    const double aspect = random(0.5, 2);
    // Half of the boxes are but the point.
    const double size = i % 2 ? 20 : 1e-9;
    const glm::dvec3 p = random.point(200), low = p - glm::abs(random.point(size)),
                     high = p + glm::abs(random.point(size));
    const glm::dvec4 clip = clip_from_relative(camera, aspect) * glm::dvec4(p, 1);
    if (std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w || clip.z > clip.w || clip.w > camera.far_m) continue;
    ++inside;
    const Frustum frustum(camera, aspect);
    EXPECT_TRUE(frustum.may_see(low, high));
    EXPECT_TRUE(frustum.may_see(0.5 * (low + high), 0.5 * glm::length(high - low)));
  }
  EXPECT_GT(inside, 10000);
}

TEST(Frustum, RefusesWhatLiesBeyondAnyOneOfItsSixPlanes) {
  Camera camera;  // east, at the origin
  camera.fov_deg = 90;
  camera.far_m = 100;
  const Frustum frustum(camera, 1);
  const glm::dvec3 half(1);
  EXPECT_TRUE(frustum.may_see(glm::dvec3(50, 0, 0) - half, glm::dvec3(50, 0, 0) + half));
  for (const glm::dvec3 p : {glm::dvec3(50, 53, 0), glm::dvec3(50, -53, 0), glm::dvec3(50, 0, 53),
                             glm::dvec3(50, 0, -53), glm::dvec3(-2, 0, 0), glm::dvec3(102, 0, 0)}) {
    EXPECT_FALSE(frustum.may_see(p - half, p + half)) << p.x << ", " << p.y << ", " << p.z;
    EXPECT_FALSE(frustum.may_see(p, 1.0));
  }
}

TEST(TileIndex, ContributionBoundsHowFarFromTheHorizonABoxIsSeen) {
  Random random;
  double tightest = 1e300;
  int bounded = 0;
  for (int i = 0; i < 100000; ++i) {
    Camera camera = random.camera(1);
    camera.position_m = {};
    const TileView view{.camera = camera,
                        .width = 1280,
                        .height = 720,
                        .haze_range_m = std::numeric_limits<double>::infinity(),
                        .least_contribution = 0};
    glm::dvec3 low = random.point(20000), high = low + glm::abs(random.point(300));
    low.z = random(-3, 3), high.z = low.z + random(0, 3);
    const double bound = TileIndex::contribution(view, low, high);
    if (bound >= 1) continue;
    ++bounded;
    const ViewAxes axes = view_axes(camera);
    const double pixel = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / view.height;
    const auto seen = [&](glm::dvec3 p) {
      return glm::dvec2(glm::dot(p, axes.right), glm::dot(p, axes.up)) / (glm::dot(p, axes.forward) * pixel);
    };
    for (int j = 0; j < 20; ++j) {
      const glm::dvec3 p = glm::mix(low, high, glm::abs(random.point(1)));
      const double off = glm::length(seen(p) - seen({p.x, p.y, 0}));
      ASSERT_LE(off, bound * (1 + 1e-9));
      if (off > 0) tightest = std::min(tightest, bound / off);
    }
  }
  std::printf("%d boxes; the bound is at best %.4f times what is seen\n", bounded, tightest);
  EXPECT_GT(bounded, 1000);
  EXPECT_LT(tightest, 1.1);
}

// What is behind a road pixel, and the road, are any albedo within [0, 0.9] (fresh snow) in any light that the sky has
// to give, behind the same air.
TEST(TileIndex, HazeContrastBoundsWhatTheAirLeavesOfAnyDifference) {
  const auto encoded = [](double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; };
  const auto shown = [&](double light) { return encoded(Lib::sky_tone(light)); };
  double worst = 0;
  for (int turn = 0; turn <= 100; ++turn) {
    // Roads near the horizon lie in horizontal directions.
    const glm::dvec3 air = Lib::sky_gradient(0.0, turn / 50.0 - 1);
    const glm::dvec3 brightest = 0.9 * (Lib::sky_sun_color() + Lib::sky_ambient(1.0));
    for (int i = 1; i <= 1000; ++i) {
      const double clear = i / 1000.0;
      for (int c = 0; c < 3; ++c) {
        const double difference = shown(glm::mix(air[c], brightest[c], clear)) - shown(glm::mix(air[c], 0.0, clear));
        worst = std::max(worst, difference / haze_contrast(clear));
      }
    }
  }
  std::printf("largest difference: %.3f of the bound\n", worst);
  EXPECT_LE(worst, 1);
  EXPECT_GT(worst, 0.8);
}

// Tiles of a plane with hills and of bridges over it.
std::vector<RoadTile> random_tiles(Random& random, int count) {
  std::vector<RoadTile> tiles;
  for (int i = 0; i < count; ++i) {
    RoadTile tile;
    const glm::dvec3 p(random(-20000, 20000), random(-20000, 20000), random(0, 1) < 0.9 ? 1 : 400);
    tile.origin_m = glm::floor(p / kTileSize_m) * kTileSize_m;
    tile.bounds.add(glm::dvec3(tile.origin_m.x, tile.origin_m.y, p.z));
    tile.bounds.add(glm::dvec3(tile.origin_m.x, tile.origin_m.y, p.z) +
                    glm::abs(random.point(1)) * glm::dvec3(300, 300, 4));
    tiles.push_back(tile);
  }
  return tiles;
}

TEST(TileIndex, SelectsWhatAPlainLoopSelects) {
  Random random;
  const std::vector<RoadTile> tiles = random_tiles(random, 3000);
  const TileIndex index(tiles);
  std::size_t total = 0, dropped = 0;
  for (int i = 0; i < 300; ++i) {
    TileView view{.camera = random.camera(15000), .width = 640, .height = 360};
    if (i % 2) view.camera.position_m.z = random(1, 20), view.camera.pitch_deg = random(-5, 5);
    view.least_contribution = i % 3 ? 1.0 / 255 : 0;
    // Sides with room for edges; the far plane without.
    Camera endless = view.camera;
    endless.far_m = std::numeric_limits<double>::infinity();
    const Frustum sides(endless, 640.0 / 360);
    const glm::dvec3 forward = view_axes(view.camera).forward;
    std::vector<std::uint32_t> plain, visible;
    for (std::uint32_t t = 0; t < tiles.size(); ++t) {
      const glm::dvec3 low = tiles[t].bounds.low_m - view.camera.position_m;
      const glm::dvec3 high = tiles[t].bounds.high_m - view.camera.position_m;
      const glm::dvec3 room = TileIndex::room_m(view, low, high);
      if (!sides.may_see(low - room, high + room)) continue;
      double nearest = 0;
      for (int axis = 0; axis < 3; ++axis) nearest += std::min(forward[axis] * low[axis], forward[axis] * high[axis]);
      if (nearest > view.camera.far_m) continue;
      if (TileIndex::contribution(view, low, high) < view.least_contribution) {
        ++dropped;
        continue;
      }
      plain.push_back(t);
    }
    index.select(view, visible);
    total += visible.size();
    std::sort(visible.begin(), visible.end());
    EXPECT_EQ(visible, plain);
  }
  EXPECT_GT(total, 10000u);
  EXPECT_GT(dropped, 1000u);
}

TEST(TileIndex, OrdersFarToNearAlongEveryRay) {
  Random random;
  std::vector<RoadTile> tiles;
  for (int x = -8; x < 8; ++x) {
    for (int y = -8; y < 8; ++y) {
      for (int z = -1; z < 2; ++z) {
        RoadTile tile;
        tile.origin_m = kTileSize_m * glm::dvec3(x, y, z);
        tile.bounds.add(tile.origin_m);
        tile.bounds.add(tile.origin_m + kTileSize_m);
        tiles.push_back(tile);
      }
    }
  }
  const TileIndex index(tiles);
  std::vector<std::uint32_t> visible;
  for (int i = 0; i < 200; ++i) {
    const TileView view{.camera = random.camera(2000)};
    index.select_all(view, visible);
    ASSERT_EQ(visible.size(), tiles.size());
    std::vector<std::size_t> rank(tiles.size());
    for (std::size_t r = 0; r < visible.size(); ++r) rank[visible[r]] = r;
    for (int j = 0; j < 20; ++j) {
      const glm::dvec3 along = glm::normalize(random.point(1));
      std::size_t before = tiles.size();
      for (double k = 0; k < 6000; k += 3) {
        const glm::dvec3 cell = glm::floor((view.camera.position_m + k * along) / kTileSize_m);
        if (cell.x < -8 || cell.x >= 8 || cell.y < -8 || cell.y >= 8 || cell.z < -1 || cell.z >= 2) continue;
        const std::size_t at = static_cast<std::size_t>(((cell.x + 8) * 16 + cell.y + 8) * 3 + cell.z + 1);
        ASSERT_LE(rank[at], before);
        before = rank[at];
      }
    }
  }
}

TEST(Camera, FarPlaneMustLieBeyondTheNearOne) {
  Camera camera;
  EXPECT_TRUE(check_camera(camera).ok());
  for (const double far : {0.0, -5.0, camera.near_m, std::numeric_limits<double>::quiet_NaN()}) {
    camera.far_m = far;
    EXPECT_EQ(check_camera(camera).error().code, ErrorCode::kUsage) << far;
  }
}

}  // namespace
}  // namespace roadgen
