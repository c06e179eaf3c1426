// No ground shows through a road: pictures of the pass with its levelled terrain, looked at pixel by pixel.
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <stdlib.h>

#include "roadgen/import/import.h"
#include "roadgen/query/road_index.h"
#include "roadgen/render/flight.h"
#include "roadgen/render/renderer.h"
#include "roadgen/render/shader_source.h"
#include "terrain/natural.h"
#include "terrain/terrain.h"
#include "tests/gl/pass_fixture.h"
#include "tests/joined_ground.h"
#include "tests/temporary_folder.h"

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

class GroundTest : public test::PassTest {
 protected:
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

// Nor at any level of detail: the coarsest there is, and what is drawn within so many pixels from the road's middle.
TEST_F(GroundTest, NoGroundShowsThroughTheRoadAtAnyLevelOfDetail) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  const std::vector<TerrainMesh> least = test::coarsest(terrain->tiles());
  EXPECT_EQ(test::triangle_count(least), terrain->report().triangles_coarsest);
  EXPECT_LT(test::triangle_count(least), terrain->report().triangles / 2);
  std::vector<std::vector<TerrainMesh>> levels{least};
  const Road& road = network_.roads[0];
  for (const double part : {0.0003, 0.003, 0.03}) {
    const Camera middle = drive_camera(road, 0.5 * road.length_m(), 0, 1.5);
    levels.push_back(test::joined(terrain->tiles(), {.eye_m = middle.position_m, .room_m = 1, .part = part}));
  }
  for (const std::vector<TerrainMesh>& level : levels) {
    const Counts counts = look(level);
    std::printf("%zu of %zu triangles: %zu pixels of road, %zu of ground, %zu of ground through the road\n",
                test::triangle_count(level), terrain->report().triangles, counts.road, counts.ground, counts.through);
    EXPECT_GT(counts.road, 50000u);
    EXPECT_GT(counts.ground, 500000u);
    EXPECT_EQ(counts.through, 0u);
  }
}

// The picture is drawn from fewer triangles than the data channels; asked for no error, from the same.
TEST_F(GroundTest, ThePictureHasLevelsOfDetailAndTheDataChannelsHaveNone) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  const Camera camera = flight_camera(network_.roads[0], 1000, {});
  const auto drawn = [&](double error, unsigned channels) {
    RendererOptions options;
    options.ground_error_pixels = error;
    options.cull = false;  // what is hidden is another matter
    auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa), options);
    EXPECT_TRUE(renderer.ok() && renderer->load_ground(terrain->tiles()).ok());
    EXPECT_TRUE(renderer->render(camera, {.width = kWidth, .height = kHeight, .channels = channels}).ok());
    return renderer->ground_statistics().drawn_triangles;
  };
  EXPECT_EQ(drawn(0.5, kDepth), drawn(0, kDepth));
  EXPECT_EQ(drawn(0, kColor), drawn(0, kDepth));
  EXPECT_LT(drawn(0.5, kColor), drawn(0, kDepth) / 2);
  EXPECT_LT(drawn(4, kColor), drawn(0.5, kColor) / 2);
}

// The picture's samples lie off the pixel's centre, where the ground may be nearer than the road is at the centre.
// Nothing pops: along a flight, whose triangles are chosen again for every frame, a frame differs from the one of all
// triangles by little, and by as little from frame to frame.
TEST_F(GroundTest, LevelsOfDetailDoNotPop) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  RendererOptions all;
  all.ground_error_pixels = 0;
  auto picture = Renderer::create(*make_context(ContextKind::kOsmesa));
  auto whole = Renderer::create(*make_context(ContextKind::kOsmesa), all);
  ASSERT_TRUE(picture.ok() && whole.ok());
  ASSERT_TRUE(picture->load_ground(terrain->tiles()).ok() && whole->load_ground(terrain->tiles()).ok());
  std::vector<int> off(256, 0);  // pixels by how far their strongest channel is off
  double worst_mean = 0, worst_step = 0, before = 0;
  constexpr int kFrames = 30;
  for (int i = 0; i < kFrames; ++i) {
    const Camera camera = flight_camera(network_.roads[0], 1000 + 1.3 * i, {});
    const FrameOptions request{.width = kWidth, .height = kHeight, .channels = kColor};
    const auto a = picture->render(camera, request), b = whole->render(camera, request);
    ASSERT_TRUE(a.ok() && b.ok());
    double sum = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        int most = 0;
        for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a->color.at(x, y, c) - b->color.at(x, y, c)));
        ++off[static_cast<std::size_t>(most)];
        sum += most;
      }
    }
    const double mean = sum / (kWidth * kHeight);
    worst_mean = std::max(worst_mean, mean);
    if (i > 0) worst_step = std::max(worst_step, std::abs(mean - before));
    before = mean;
  }
  int many = 0;
  for (std::size_t i = 17; i < off.size(); ++i) many += off[i];
  const double part = many / static_cast<double>(kFrames * kWidth * kHeight);
  std::printf(
      "off by %.3f / 255 at most on the mean, from frame to frame by %.4f; %.5f of the pixels by more than 16\n",
      worst_mean, worst_step, part);
  EXPECT_LT(worst_mean, 0.5);
  EXPECT_LT(worst_step, 0.02);
  EXPECT_LT(part, 0.001);
}

// A picture in place of the grass; what is no picture is refused.
TEST_F(GroundTest, TexturesShowTheGround) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
  ASSERT_TRUE(renderer.ok() && renderer->load_ground(terrain->tiles()).ok());
  EXPECT_EQ(renderer->set_ground_texture(GroundMaterial::kGrass, Image8()).error().code, ErrorCode::kData);
  const auto red_part = [&] {
    const auto frame = renderer->render(drive_camera(network_.roads[0], 300, 6, 2),
                                        {.width = kWidth, .height = kHeight, .channels = kColor | kLabel});
    EXPECT_TRUE(frame.ok());
    int red = 0, ground = 0;
    for (int y = kHeight / 2; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (static_cast<Label>(frame->label.at(x, y, 0)) != Label::kGround) continue;
        ++ground;
        red += frame->color.at(x, y, 0) > 2 * frame->color.at(x, y, 1);
      }
    }
    EXPECT_GT(ground, 5000);
    return red / static_cast<double>(ground);
  };
  EXPECT_LT(red_part(), 0.001);
  for (const auto& [width, height] : {std::pair(2, 2), {5, 3}}) {  // any size
    Image8 red(width, height, 3);
    for (std::size_t i = 0; i < red.pixels.size(); i += 3) red.pixels[i] = 200;
    for (const GroundMaterial m : {GroundMaterial::kGrass, GroundMaterial::kRock, GroundMaterial::kGravel}) {
      ASSERT_TRUE(renderer->set_ground_texture(m, red).ok());
    }
    EXPECT_GT(red_part(), 0.98);
  }
}

TEST_F(GroundTest, NoGroundIsMixedIntoTheRoadsPicture) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  std::vector<TerrainMesh> deep = terrain->tiles();
  for (TerrainMesh& tile : deep) tile.origin_m.z -= 2;
  auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
  ASSERT_TRUE(renderer.ok());
  ASSERT_TRUE(renderer->load_roads(network_).ok());
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::size_t compared = 0, mixed = 0;
  for (int i = 0; i < 30; ++i) {
    const Road& road = network_.roads[0];
    const Camera camera = i % 2 == 0 ? flight_camera(road, uniform(random) * road.length_m(), {})
                                     : drive_camera(road, uniform(random) * road.length_m(), -1.75, 1.3);
    ASSERT_TRUE(renderer->load_ground(terrain->tiles()).ok());
    const auto real = renderer->render(camera, {.width = kWidth, .height = kHeight, .channels = kColor | kLabel});
    ASSERT_TRUE(renderer->load_ground(deep).ok());
    const auto away = renderer->render(camera, {.width = kWidth, .height = kHeight, .channels = kColor | kLabel});
    ASSERT_TRUE(real.ok() && away.ok());
    const auto is_road = [](const Frame& frame, int x, int y) {
      return frame.label.at(x, y, 0) >= static_cast<std::uint32_t>(Label::kCarriageway);
    };
    for (int y = 2; y + 2 < kHeight; ++y) {
      for (int x = 2; x + 2 < kWidth; ++x) {
        bool inside = true;  // with all its neighbours, and theirs
        for (int k = 0; k < 25 && inside; ++k) {
          const int nx = x + k % 5 - 2, ny = y + k / 5 - 2;
          inside = is_road(*real, nx, ny) && is_road(*away, nx, ny);
        }
        if (!inside) continue;
        ++compared;
        int difference = 0;
        for (int c = 0; c < 3; ++c)
          difference = std::max(difference, std::abs(real->color.at(x, y, c) - away->color.at(x, y, c)));
        mixed += difference > 2;
      }
    }
  }
  std::printf("pixels inside the road: %zu, with ground mixed in: %zu\n", compared, mixed);
  EXPECT_GT(compared, 100000u);
  // Of a joint, rounding may leave single samples to the ground: one pixel in 100,000, by a few levels.
  EXPECT_LE(static_cast<double>(mixed), 1e-5 * static_cast<double>(compared));
}

// What wheels off the road stand on is what the picture shows: the height of every pixel of ground, within 1 cm or, where
// a pixel is larger than a metre, a hundredth of it: the rasterizer snaps vertices to 1/256 of a pixel.
TEST_F(GroundTest, ContactAgreesWithThePicture) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
  ASSERT_TRUE(renderer.ok());
  ASSERT_TRUE(renderer->load_ground(terrain->tiles()).ok());
  const Road& road = network_.roads[0];
  double worst_m = 0, worst_near_m = 0, worst_part = 0;
  std::size_t compared = 0, beyond = 0;
  for (int i = 0; i < 12; ++i) {
    Camera camera = drive_camera(road, road.length_m() * i / 12, 0, i % 2 == 0 ? 1.5 : 60);
    camera.yaw_deg += 30 * i;
    camera.pitch_deg -= 8;
    const double pixel = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / kHeight;
    const auto frame = renderer->render(camera, {.width = kWidth, .height = kHeight, .channels = kLabel | kDepth});
    ASSERT_TRUE(frame.ok());
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        if (static_cast<Label>(frame->label.at(x, y, 0)) != Label::kGround) continue;
        const double depth = frame->depth_m.at(x, y, 0);
        const glm::dvec3 seen = camera.position_m + depth * pixel_ray(camera, kWidth, kHeight, x, y);
        const double off = std::abs(seen.z - terrain->height_m(glm::dvec2(seen)));
        worst_m = std::max(worst_m, off);
        if (depth < 300) worst_near_m = std::max(worst_near_m, off);
        const double part = off / std::max(0.01, 0.01 * pixel * depth);
        worst_part = std::max(worst_part, part);
        beyond += part > 1;
        ++compared;
      }
    }
  }
  std::printf(
      "%zu pixels of ground, at most %.2e m from its height, %.2e m within 300 m, %.2f of the limit; %zu beyond\n",
      compared, worst_m, worst_near_m, worst_part, beyond);
  EXPECT_GT(compared, 500000u);
  // Of triangles that are thinner in the picture than a fiftieth of a pixel the rasterizer, which puts corners on 1/256
  // pixel, does not know the plane: a pixel of them now and then is off by more, but not by a tenth of a pixel.
  EXPECT_LE(500000 * beyond, compared);
  EXPECT_LE(worst_part, 10);
}

// Ground behind nearer ground is left out: the same picture and channels, bit for bit, from the road, the air and beside.
TEST_F(GroundTest, GroundBehindGroundMayBeLeftOut) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  RendererOptions all;
  all.cull = false;
  auto drawn = Renderer::create(*make_context(ContextKind::kOsmesa));
  auto whole = Renderer::create(*make_context(ContextKind::kOsmesa), all);
  ASSERT_TRUE(drawn.ok() && whole.ok());
  ASSERT_TRUE(drawn->load_ground(terrain->ground()).ok() && whole->load_ground(terrain->ground()).ok());
  std::mt19937 random(21);
  std::uniform_real_distribution<double> uniform(0, 1);
  const Rectangle& area = terrain->report().area;
  std::size_t of_drawn = 0, of_all = 0;
  for (int i = 0; i < 150; ++i) {
    Camera camera = drive_camera(network_.roads[0], network_.roads[0].length_m() * uniform(random), -1.75, 1.5);
    camera.yaw_deg += 360 * uniform(random);
    camera.pitch_deg += 40 * (uniform(random) - 0.5);
    camera.fov_deg = 10 + 100 * uniform(random);
    // Anywhere, from 10 cm above the ground to 300 m; now and then below it, or outside of the area.
    if (i % 2 == 0) {
      const glm::dvec2 at =
          area.low_m + (area.high_m - area.low_m) * (1.1 * glm::dvec2(uniform(random), uniform(random)));
      camera.position_m = {at, terrain->height_m(at) + (i % 10 == 0 ? -20 : 0.1 * std::pow(3000, uniform(random)))};
    }
    const FrameOptions request{.width = 160, .height = 90, .channels = kColor | kDepth};
    const auto a = drawn->render(camera, request), b = whole->render(camera, request);
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_TRUE(a->color.pixels == b->color.pixels) << i;
    EXPECT_TRUE(a->depth_m.pixels == b->depth_m.pixels) << i;
    of_drawn += drawn->ground_statistics().drawn_triangles;
    of_all += whole->ground_statistics().drawn_triangles;
  }
  std::printf("%zu of %zu triangles drawn\n", of_drawn, of_all);
  EXPECT_LT(of_drawn, of_all / 2);
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

// Pixels of roads that lie behind the ground are not evaluated: the picture is the same, bit for bit, where they are. Where
// they are painted instead, before everything, they are there to be seen.
// The contrast: the very same levelled ground, sampled at the posts of a grid, as games and simulators do it.
TEST_F(GroundTest, GroundThatIsSampledAtPostsShowsThroughTheRoad) {
  const Bounds b = bounds(network_);
  const Rectangle area{glm::dvec2(b.low_m) - 60.0, glm::dvec2(b.high_m) + 60.0};
  const Grid natural = natural_from_elevation(*elevation_, network_, area, 10);
  const RoadIndex index(network_);
  const Levelling ground(index, natural, {});
  for (const auto& [post_m, least] : {std::pair(8.0, 50000u), {4.0, 10u}}) {
    // The cells about the road.
    const glm::ivec2 posts(glm::ceil((area.high_m - area.low_m) / post_m));
    TerrainMesh tile;
    tile.origin_m = {area.low_m, 0};
    std::map<std::pair<int, int>, std::uint32_t> known;
    const auto vertex = [&](int x, int y) {
      const auto [at, is_new] = known.emplace(std::pair(x, y), static_cast<std::uint32_t>(known.size()));
      if (is_new) {
        const glm::dvec2 place = post_m * glm::dvec2(x, y);
        tile.positions_m.emplace_back(place, ground.height_m(area.low_m + place));
        tile.normals.emplace_back(0, 0, 1);
      }
      return at->second;
    };
    for (int y = 0; y + 1 < posts.y; ++y) {
      for (int x = 0; x + 1 < posts.x; ++x) {
        if (ground.edge_distance_m(area.low_m + post_m * (glm::dvec2(x, y) + 0.5), 40) >= 40) continue;
        const std::uint32_t a = vertex(x, y), b2 = vertex(x + 1, y), c = vertex(x + 1, y + 1), d = vertex(x, y + 1);
        tile.triangles.insert(tile.triangles.end(), {a, b2, c, a, c, d});
      }
    }
    const Counts counts = look({&tile, 1});
    std::printf("posts of %.0f m: %zu of road, %zu of ground, %zu of ground through the road\n", post_m, counts.road,
                counts.ground, counts.through);
    EXPECT_GT(counts.through, least);
  }
}

TEST_F(GroundTest, RoadsBehindTheGroundMayBeLeftOut) {
  auto terrain = Terrain::build(network_, &*elevation_);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  const auto shader = read_shader_file("road.frag");
  ASSERT_TRUE(shader.ok());
  const std::string left_out = "if (!part.beyond && behind_ground(ray)) return sight;";
  const std::size_t at = shader->find(left_out);
  ASSERT_NE(at, std::string::npos);
  const test::TemporaryFolder folder;
  const auto renderer_with = [&](const std::string& instead) {
    std::string text = *shader;
    folder.put("road.frag", text.replace(at, left_out.size(), instead));
    setenv("ROADGEN_SHADER_DIR", folder.path("").c_str(), 1);
    auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
    unsetenv("ROADGEN_SHADER_DIR");
    EXPECT_TRUE(renderer.ok());
    EXPECT_TRUE(renderer->load_roads(network_).ok());
    EXPECT_TRUE(renderer->load_ground(terrain->tiles()).ok());
    return renderer;
  };
  auto as_is = renderer_with(left_out), followed = renderer_with(""),
       painted = renderer_with(
           "if (!part.beyond && behind_ground(ray)) { sight.pixel = Pixel(vec3(1.0, 0.0, 0.0), 1.0, forward.w, "
           "vec4(0.0), "
           "vec3(0.0, 0.0, 1.0), 2.0, 1.0, true, false); sight.seen = 1.0; return sight; }");
  ASSERT_TRUE(as_is.ok() && followed.ok() && painted.ok());
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::size_t behind = 0;
  for (int i = 0; i < 12; ++i) {
    const double s = uniform(random) * network_.roads[0].length_m();
    Camera camera = drive_camera(network_.roads[0], s, 0, 0.8 * std::pow(100, uniform(random)));
    camera.yaw_deg += 360 * uniform(random);
    for (const int samples : {1, 4}) {
      const FrameOptions request{.width = kWidth, .height = kHeight, .channels = kColor, .samples = samples};
      const auto a = as_is->render(camera, request), b = followed->render(camera, request),
                 red = painted->render(camera, request);
      ASSERT_TRUE(a.ok() && b.ok() && red.ok());
      const auto difference = compare(a->color, b->color);
      ASSERT_TRUE(difference.ok());
      EXPECT_EQ(difference->max, 0) << i << ", " << samples << " samples";
      for (int y = 0; y < kHeight; ++y) {
        for (int x = 0; x < kWidth; ++x) behind += red->color.at(x, y, 0) > 250 && red->color.at(x, y, 1) < 10;
      }
    }
  }
  EXPECT_GT(behind, 2000u);
}

}  // namespace
}  // namespace roadgen
