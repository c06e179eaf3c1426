// Structures along roads as drawn: depth, label and normal of every pixel against rays cast in double; thin cables
// fade with their width.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/render/flight.h"
#include "roadgen/render/renderer.h"
#include "roadgen/road/sweep_piece.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen {
namespace {

constexpr int kWidth = 320, kHeight = 200;

// A winding road over low hills, at 10,000 km from the origin.
Road winding_road() {
  std::vector<Anchor> anchors;
  glm::dvec2 p(1e7, -1e7);
  for (int i = 0; i < 40; ++i) {
    const double s = i * 14.0, heading = 0.9 * std::sin(s / 90) + 0.25 * std::sin(s / 31);
    anchors.push_back({.position_m = p, .elevation_m = 6 * std::sin(s / 110) + std::sin(s / 37)});
    p += 14.0 * glm::dvec2(std::cos(heading), std::sin(heading));
  }
  auto road = road_from_anchors(anchors, {});
  EXPECT_TRUE(road.ok());
  road->id = "1";
  return std::move(*road);
}

Network scene() {
  Network network;
  network.roads.push_back(winding_road());
  network.roads[0].sweeps = {{.s_start_m = 300, .s_end_m = 420, .shape = Tunnel{}},
                             {.s_start_m = 20, .s_end_m = 290, .t_m = -4.3, .shape = GuardRail{}},
                             {.s_start_m = 60, .s_end_m = 250, .t_m = 4.3, .shape = GuardRail{}},
                             {.s_start_m = 10, .s_end_m = 280, .t_m = 8, .shape = Cable{.radius_m = 0.05}},
                             {.s_start_m = 430, .s_end_m = 500, .t_m = -6, .t_slope = 0.02, .shape = Pipe{}}};
  return network;
}

struct Expected {
  double depth_m;
  glm::dvec3 normal;
};

class Tracer {
 public:
  explicit Tracer(const Network& network) : road_(network.roads[0]) {
    for (std::size_t i = 0; i < road_.sweeps.size(); ++i) {
      for (const SweepPart& part : sweep_parts(road_, i)) parts_.push_back(part);
    }
  }
  std::optional<Expected> cast(const Camera& camera, double x, double y) const {
    const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, x, y);
    const double length = glm::length(ray), pixel = 2 * std::tan(camera.fov_deg * M_PI / 360) / kHeight / length;
    std::optional<Expected> nearest;
    for (const SweepPart& part : parts_) {
      const auto hit = roadgen::cast(road_, part, camera.position_m, ray / length, pixel, camera.near_m * length);
      if (hit && (!nearest || hit->distance_m / length < nearest->depth_m)) {
        nearest = {hit->distance_m / length, hit->normal};
      }
    }
    return nearest;
  }

 private:
  const Road& road_;
  std::vector<SweepPart> parts_;
};

class SweepTest : public test::GlTest {
 protected:
  void SetUp() override {
    auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
    ASSERT_TRUE(renderer.ok()) << renderer.error().text();
    renderer_.emplace(std::move(*renderer));
  }
  void TearDown() override {
    renderer_.reset();
    GlTest::TearDown();
  }
  Frame draw(const Network& network, const Camera& camera, unsigned channels) {
    EXPECT_TRUE(renderer_->load_roads(network).ok());
    auto frame = renderer_->render(camera, {.width = kWidth, .height = kHeight, .channels = channels});
    EXPECT_TRUE(frame.ok());
    return std::move(*frame);
  }
  std::optional<Renderer> renderer_;
};

struct View {
  const char* name;
  double s_m, t_m, height_m, yaw_deg, pitch_deg, fov_deg;
};

TEST_F(SweepTest, EveryPixelAgreesWithTheRayCastInDouble) {
  const Network network = scene();
  const Tracer tracer(network);
  const View views[] = {
      {"inside the tunnel", 340, -1.75, 1.5, 0, 0, 60},    {"backward in it", 330, 1, 2.5, 180, 5, 90},
      {"into the portal", 270, -1.75, 1.6, 0, 2, 40},      {"tunnel from above", 280, 30, 25, -30, -20, 60},
      {"along the rail", 100, -4.2, 0.9, 0, 0, 40},        {"behind the rail", 100, -6, 0.6, 20, 2, 60},
      {"rail on the bend, far", 60, -1.75, 1.2, 0, -1, 8}, {"cable, far", 20, -40, 3, 20, 3, 20},
      {"under the cable", 113, 8, 1.5, 5, 20, 70},         {"pipe", 440, -7, 1.2, 0, -10, 70}};
  for (const View& view : views) {
    SCOPED_TRACE(view.name);
    Camera camera = drive_camera(network.roads[0], view.s_m, view.t_m, view.height_m);
    camera.yaw_deg += view.yaw_deg, camera.pitch_deg += view.pitch_deg, camera.fov_deg = view.fov_deg;
    const Frame frame = draw(network, camera, kLabel | kDepth | kNormal | kInstance);
    std::size_t compared = 0, structure = 0, wrong = 0, turned = 0, coarse = 0;
    double worst = 0, across = 0;
    for (int y = 0; y < kHeight; y += 2) {
      for (int x = 0; x < kWidth; x += 2) {
        const auto hit = tracer.cast(camera, x, y);
        const double depth = frame.depth_m.at(x, y, 0);
        const bool drawn = frame.label.at(x, y, 0) == static_cast<std::uint32_t>(Label::kStructure);
        // Structures behind a crest of the road are rightly hidden; where a fiftieth of a pixel aside shows something
        // else, rounding may decide.
        bool edge = false;
        for (const auto& [dx, dy] : {std::pair{-0.02, 0.0}, {0.02, 0.0}, {0.0, -0.02}, {0.0, 0.02}}) {
          const auto aside = tracer.cast(camera, x + dx, y + dy);
          edge = edge || aside.has_value() != hit.has_value() ||
                 (hit && std::abs(aside->depth_m - hit->depth_m) > 0.01 * hit->depth_m);
        }
        // Where a structure stands on the road both are equally near.
        edge = edge || (!drawn && hit && std::abs(hit->depth_m - depth) < 2e-3 * (1 + depth));
        if (edge) continue;
        ++compared;
        const bool expected = hit && hit->depth_m < depth + 2e-3 * (1 + depth);
        if (drawn != expected) {
          ++wrong;
          continue;
        }
        if (!drawn) continue;
        ++structure;
        EXPECT_EQ(frame.instance.at(x, y, 0), 1u);
        // Across the surface, not along the ray: what a grazing ray stretches along itself counts once.
        const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, x, y);
        const double off = std::abs(depth - hit->depth_m) * std::abs(glm::dot(ray, hit->normal));
        const double pixel = 2 * std::tan(camera.fov_deg * M_PI / 360) / kHeight;
        worst = std::max(worst, std::abs(depth - hit->depth_m) / hit->depth_m);
        across = std::max(across, off / std::max(pixel * hit->depth_m, 0.05));
        coarse += off > 0.05 * std::max(pixel * hit->depth_m, 0.05);
        const glm::dvec3 n(frame.normal.at(x, y, 0), frame.normal.at(x, y, 1), frame.normal.at(x, y, 2));
        turned += glm::dot(n, hit->normal) < 0.99;
      }
    }
    std::printf("%s: %zu pixels compared, %zu of structures, %zu wrong, %zu turned, depth %.1e, across %.3f\n",
                view.name, compared, structure, wrong, turned, worst, across);
    EXPECT_GT(compared, 10000u);
    EXPECT_GT(structure, 20u);
    EXPECT_LE(wrong, compared / 5000);
    // At the kinks of a profile the normal may be either side's.
    EXPECT_LE(turned, structure / 100 + 3);
    // The march ends within a hundredth of a pixel or half a millimetre, in float and in double, and along the way
    // between the two the surface may turn; most where a ray grazes a thin pole.
    EXPECT_LE(coarse, structure / 500 + 1);
    EXPECT_LT(across, 0.1);
    EXPECT_LT(worst, 0.02);
  }
}

// What a cable far thinner than a pixel takes of the sky, summed over each column of the picture, is the same in all of
// them and grows with its width.
TEST_F(SweepTest, AThinCableFadesWithItsWidth) {
  Network network;
  Road road;
  road.id = "1";
  road.segments.push_back(make_segment({0, 0}, {100, 0}, 0, 0, 3.5));
  chain_arc_lengths(road);
  two_lane_sections(road);
  network.roads.push_back(road);
  Camera camera;
  camera.position_m = {50, -130, 2};
  camera.yaw_deg = 90, camera.pitch_deg = 6, camera.fov_deg = 25;
  const auto linear = [](const Frame& f, int x, int y) {
    const double c = f.color.at(x, y, 2) / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  const Frame sky = draw(network, camera, kColor);
  double means[2] = {0, 0};
  for (const int twice : {0, 1}) {
    network.roads[0].sweeps = {
        {.s_start_m = 0,
         .s_end_m = 100,
         .shape =
             Cable{.radius_m = twice ? 0.06 : 0.03, .height_m = 16, .span_m = 200, .sag_m = 8, .pole_radius_m = 0}}};
    ASSERT_TRUE(problems(network.roads[0], network.roads[0].sweeps[0]).empty());
    const Frame frame = draw(network, camera, kColor);
    double sum = 0, squares = 0;
    constexpr int kFrom = 60, kTo = 260;
    for (int x = kFrom; x < kTo; ++x) {
      double column = 0;
      for (int y = 0; y < kHeight; ++y) column += linear(sky, x, y) - linear(frame, x, y);
      sum += column, squares += column * column;
    }
    const double count = kTo - kFrom, mean = sum / count, spread = std::sqrt(squares / count - mean * mean);
    std::printf("radius %d cm: mean %.4f, spread %.4f\n", twice ? 6 : 3, mean, spread);
    means[twice] = mean;
    EXPECT_GT(mean, 0.02);
    EXPECT_LT(spread, 0.12 * mean);
  }
  EXPECT_NEAR(means[1] / means[0], 2, 0.1);
}

TEST_F(SweepTest, BadSweepsDrawNothingAndHarmNothing) {
  Network network = scene();
  const Camera camera = drive_camera(network.roads[0], 60, -1.75, 1.3);
  network.roads[0].sweeps.clear();
  const Frame without = draw(network, camera, kAllChannels);
  network.roads[0].sweeps = {{.s_start_m = 20, .s_end_m = 290, .t_m = -4.3, .shape = GuardRail{.sheet_m = -1}},
                             {.s_start_m = 290, .s_end_m = 20, .shape = Tunnel{}},
                             {.s_start_m = 20, .s_end_m = 290, .t_m = std::nan(""), .shape = Pipe{}}};
  const Frame with = draw(network, camera, kAllChannels);
  EXPECT_EQ(without.color.pixels, with.color.pixels);
  EXPECT_EQ(without.label.pixels, with.label.pixels);
}

}  // namespace
}  // namespace roadgen
