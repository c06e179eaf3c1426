// No ground shows through a road: pictures of the pass with its levelled terrain, looked at pixel by pixel.
#include <cmath>
#include <cstdio>
#include <random>

#include <gtest/gtest.h>

#include "roadgen/import/import.h"
#include "roadgen/query/road_index.h"
#include "roadgen/render/flight.h"
#include "roadgen/render/renderer.h"
#include "terrain/terrain.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen {
namespace {

constexpr int kWidth = 480, kHeight = 270;

struct Counts {
  std::size_t road = 0, ground = 0, through = 0;
};

// Counts the ground pixels that a road should have covered: where the eye ray, coming from above, crosses the height of
// the road's surface inside a carriageway and yet arrives at the ground below it.
void count(const Frame& frame, const Camera& camera, const RoadIndex& index, Counts& counts) {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto label = static_cast<Label>(frame.label.at(x, y, 0));
      counts.road += label == Label::kCarriageway || label == Label::kMarking;
      if (label != Label::kGround) continue;
      ++counts.ground;
      const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, x, y);
      if (ray.z >= 0) continue;
      const glm::dvec3 seen = camera.position_m + static_cast<double>(frame.depth_m.at(x, y, 0)) * ray;
      const auto below = index.to_road(glm::dvec2(seen), 0);
      if (!below) continue;
      const auto surface_m = [&](const RoadPoint& at) {
        const Segment& segment = index.segment(at.at);
        return segment.elevation_m.value(at.s_m - segment.s_start_m);
      };
      // Where the ray is at the road's height; ground above the road is taken as it is, since no tunnel is about.
      glm::dvec3 crossing = seen;
      std::optional<RoadPoint> at = below;
      for (int i = 0; i < 300 && at && seen.z < surface_m(*below); ++i) {
        crossing += ray * ((surface_m(*at) - crossing.z) / ray.z);
        at = index.to_road(glm::dvec2(crossing), 0);
      }
      // 5 mm inside the edge: an edge itself may round either way.
      if (at && at->at.road == below->at.road && std::abs(at->t_m) < index.segment(at->at).max_half_width_m() - 0.005)
        ++counts.through;
    }
  }
}

class GroundTest : public test::GlTest {
 protected:
  void SetUp() override {
    const std::string data = std::string(ROADGEN_SOURCE_DIR) + "/data/";
    auto imported = import_files({data + "pass.csv"}, {});
    ASSERT_TRUE(imported.ok()) << imported.error().text();
    network_ = std::move(imported->network);
    auto elevation = Elevation::open(data + "pass_dem.tif");
    ASSERT_TRUE(elevation.ok()) << elevation.error().text();
    elevation_.emplace(std::move(*elevation));
  }
  // From 60 random places on and above the road, along it and down the slopes.
  Counts look(std::span<const TerrainMesh> tiles) {
    Counts counts;
    auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
    EXPECT_TRUE(renderer.ok());
    EXPECT_TRUE(renderer->load_roads(network_).ok());
    EXPECT_TRUE(renderer->load_ground(tiles).ok());
    const RoadIndex index(network_);
    const Road& road = network_.roads[0];
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int i = 0; i < 60; ++i) {
      const double s = uniform(random) * road.length_m(), height = 0.6 * std::pow(200, uniform(random));
      Camera camera = drive_camera(road, s, 3 * (uniform(random) - 0.5), height);
      camera.yaw_deg += 360 * uniform(random);
      camera.pitch_deg -= 3 + 30 * uniform(random);
      const auto frame = renderer->render(camera, {.width = kWidth, .height = kHeight, .channels = kLabel | kDepth});
      EXPECT_TRUE(frame.ok());
      count(*frame, camera, index, counts);
    }
    return counts;
  }

  Network network_;
  std::optional<Elevation> elevation_;
};

TEST_F(GroundTest, NoGroundShowsThroughTheRoad) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  const Counts counts = look(terrain->tiles());
  std::printf("pixels: %zu of road, %zu of ground, %zu of ground through the road\n", counts.road, counts.ground,
              counts.through);
  EXPECT_GT(counts.road, 50000u);
  EXPECT_GT(counts.ground, 500000u);
  EXPECT_EQ(counts.through, 0u);
}

TEST_F(GroundTest, GroundThatIsNotLevelledIsFound) {
  // The same road in a terrain that was levelled for a road 0.4 m higher: the test above can fail.
  Network higher = network_;
  for (Segment& segment : higher.roads[0].segments) segment.elevation_m.c0 += 0.4;
  auto terrain = Terrain::build(higher, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  const Counts counts = look(terrain->tiles());
  EXPECT_GT(counts.through, 50000u);
}

}  // namespace
}  // namespace roadgen
