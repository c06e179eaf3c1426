// Junctions as drawn against a ray cast in double, against their supersampled picture, and against the roads they join.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/render/renderer.h"
#include "roadgen/road/crossing.h"
#include "roadgen/road/junction.h"
#include "terrain/terrain.h"
#include "tests/gl/gl_fixture.h"
#include "tests/junction_scenes.h"

namespace roadgen {
namespace {

constexpr int kWidth = 320, kHeight = 200;

Junction made(std::vector<JunctionArm> arms) {
  auto junction = make_junction("J", std::move(arms));
  EXPECT_TRUE(junction.ok()) << junction.error().text();
  return std::move(*junction);
}

// Straight level-across roads up each arm, which end where the junction begins.
Network with_roads(const std::vector<JunctionArm>& arms) {
  Network network;
  network.junctions.push_back(made(arms));
  for (const JunctionArm& arm : arms) {
    const glm::dvec2 into(std::cos(arm.heading_rad), std::sin(arm.heading_rad));
    Road road;
    road.id = arm.road;
    constexpr double kLength_m = 60;
    const glm::dvec2 from = arm.position_m - kLength_m * into;
    if (arm.at_end) {
      road.segments.push_back(make_segment(from, arm.position_m, arm.heading_rad, arm.heading_rad, arm.left_m));
      road.segments[0].elevation_m = {arm.elevation_m - kLength_m * arm.grade, arm.grade, 0, 0};
    } else {
      const double out = arm.heading_rad + M_PI;
      road.segments.push_back(make_segment(arm.position_m, from, out, out, arm.left_m));
      road.segments[0].elevation_m = {arm.elevation_m, -arm.grade, 0, 0};
    }
    two_lane_sections(road);
    network.roads.push_back(std::move(road));
  }
  return network;
}

// Arms like those of roads without crossfall or superelevation, which are as wide on either side.
std::vector<JunctionArm> plain(std::vector<JunctionArm> arms) {
  for (JunctionArm& a : arms) {
    a.tilt = a.crossfall_left = a.crossfall_right = 0;
    a.right_m = -a.left_m;
  }
  return arms;
}

Camera look_at(glm::dvec3 target, double distance_m, double yaw_deg, double pitch_deg) {
  Camera camera;
  camera.yaw_deg = yaw_deg;
  camera.pitch_deg = pitch_deg;
  camera.position_m = target - distance_m * view_axes(camera).forward;
  return camera;
}

struct Hit {
  double depth_m;
  glm::dvec2 place;
};

// Where the ray through a pixel first meets the area, in double: by small steps and bisection.
std::optional<Hit> cast(const JunctionSurface& surface, const Camera& camera, double px, double py) {
  const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, px, py);
  double k0 = camera.near_m, k1 = 1e5;
  for (int axis = 0; axis < 3; ++axis) {
    const double o = camera.position_m[axis] - surface.center_m[axis], d = ray[axis];
    const double a = (surface.low_m[axis] - 0.5 - o) / d, b = (surface.high_m[axis] + 0.5 - o) / d;
    k0 = std::max(k0, std::min(a, b));
    k1 = std::min(k1, std::max(a, b));
  }
  if (!(k0 < k1)) return std::nullopt;
  const auto above = [&](double k) {
    const glm::dvec3 p = camera.position_m + k * ray;
    return p.z - height_at(surface, glm::dvec2(p)).height_m;
  };
  const int steps = std::clamp(static_cast<int>((k1 - k0) * glm::length(ray) / 0.15), 4, 4000);
  double before = above(k0);
  for (int i = 1; i <= steps; ++i) {
    double low = k0 + (k1 - k0) * (i - 1) / steps, high = k0 + (k1 - k0) * i / steps;
    const double after = above(high);
    if (before * after <= 0) {
      for (int j = 0; j < 50; ++j) {
        const double middle = 0.5 * (low + high);
        (before * above(middle) <= 0 ? high : low) = middle;
      }
      const glm::dvec2 p = glm::dvec2(camera.position_m + low * ray);
      if (signed_distance_m(surface, p) >= 0) return Hit{low, p};
    }
    before = after;
  }
  return std::nullopt;
}

class JunctionRender : public test::GlTest {
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
  Frame draw(const Camera& camera, unsigned channels, int width = kWidth, int height = kHeight) {
    auto frame = renderer_->render(camera, {.width = width, .height = height, .channels = channels});
    EXPECT_TRUE(frame.ok());
    return std::move(*frame);
  }
  std::optional<Renderer> renderer_;
};

struct View {
  const char* name;
  double distance_m, pitch_deg;
};
// From above, at an angle, from a driver's eye, along the surface, from below.
constexpr View kViews[] = {
    {"above", 60, -89}, {"oblique", 45, -25}, {"driver", 26, -4}, {"grazing", 40, -1.2}, {"below", 30, 20}};

TEST_F(JunctionRender, EveryPixelAgreesWithTheRayCastInDouble) {
  std::vector<Junction> junctions = {made(test::crossing_arms()), made(test::skewed_arms())};
  std::mt19937 random(21);
  for (int i = 0; i < 4; ++i) junctions.push_back(made(test::random_arms(random, {5e6, -3e6, 700})));
  std::size_t all = 0, all_wrong = 0;
  for (const View& view : kViews) {
    std::size_t compared = 0, inside = 0, wrong = 0;
    double worst_depth = 0, worst_place = 0;
    for (std::size_t j = 0; j < junctions.size(); ++j) {
      Network network;
      network.junctions = {junctions[j]};
      ASSERT_TRUE(renderer_->load_roads(network).ok());
      const JunctionSurface surface = junction_surface(junctions[j]);
      const glm::dvec3 middle(glm::dvec2(surface.center_m), height_at(surface, glm::dvec2(surface.center_m)).height_m);
      const Camera camera = look_at(middle, view.distance_m, 37.0 + 71.0 * static_cast<double>(j), view.pitch_deg);
      const Frame frame = draw(camera, kAllChannels & ~kColor);
      const double pixel = 2 * std::tan(camera.fov_deg * M_PI / 360) / kHeight;
      for (int y = 0; y < kHeight; y += 3) {
        for (int x = 0; x < kWidth; x += 3) {
          const auto hit = cast(surface, camera, x, y);
          const bool drawn = frame.road.at(x, y, 0) == -2;
          ++compared;
          if (drawn != hit.has_value()) {
            // A pixel whose centre lies within a fiftieth of a pixel of an edge may fall either way.
            bool edge = false;
            for (const glm::dvec2 d : {glm::dvec2(0.02, 0), {-0.02, 0}, {0, 0.02}, {0, -0.02}}) {
              edge = edge || cast(surface, camera, x + d.x, y + d.y).has_value() == drawn;
            }
            wrong += !edge;
            continue;
          }
          EXPECT_EQ(frame.label.at(x, y, 0), drawn ? static_cast<unsigned>(Label::kCarriageway) : 0u);
          EXPECT_EQ(frame.instance.at(x, y, 0), drawn ? 1u : 0u);
          if (!drawn) continue;
          ++inside;
          const glm::dvec2 local = hit->place - glm::dvec2(surface.center_m);
          const glm::dvec2 found(frame.road.at(x, y, 1), frame.road.at(x, y, 2));
          // Along a grazing ray a place is as uncertain as its height times the ray's slope.
          const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, x, y);
          const glm::dvec2 slope = height_at(surface, hit->place).gradient;
          const double closing = std::abs(ray.z - glm::dot(slope, glm::dvec2(ray))) / glm::length(ray);
          const double allowed = std::max(1e-3, 0.01 * pixel * hit->depth_m) / closing + 1e-3;
          worst_place = std::max(worst_place, glm::length(found - local) / allowed);
          worst_depth = std::max(worst_depth, std::abs(frame.depth_m.at(x, y, 0) - hit->depth_m) / allowed);
        }
      }
    }
    std::printf(
        "%-8s %6zu pixels, %6zu inside, %zu wrong; of what a millimetre of height allows: depth %.3f, place %.3f\n",
        view.name, compared, inside, wrong, worst_depth, worst_place);
    EXPECT_GT(inside, 500u) << view.name;
    EXPECT_LE(worst_depth, 1) << view.name;
    EXPECT_LE(worst_place, 1) << view.name;
    all += compared;
    all_wrong += wrong;
  }
  // A ray that nearly touches a crest can miss by rounding.
  EXPECT_LE(static_cast<double>(all_wrong), 1e-4 * static_cast<double>(all));
}

// Nothing shows between a road and its junction, and their surfaces and pictures go on across the cut.
TEST_F(JunctionRender, RoadsAndJunctionJoinWithoutACrack) {
  for (const bool is_skewed : {false, true}) {
    const Network network = with_roads(plain(is_skewed ? test::skewed_arms() : test::crossing_arms()));
    ASSERT_TRUE(renderer_->load_roads(network).ok());
    const JunctionSurface surface = junction_surface(network.junctions[0]);
    for (const JunctionArm& arm : network.junctions[0].arms) {
      for (const double pitch : {-89.0, -20.0, -5.0}) {
        const Camera camera =
            look_at(glm::dvec3(arm.position_m, arm.elevation_m), 9, arm.heading_rad * 180 / M_PI + 33, pitch);
        const Frame frame = draw(camera, kDepth | kRoad | kNormal);
        std::size_t beside = 0;
        for (int y = 0; y < kHeight; ++y) {
          for (int x = 0; x < kWidth; ++x) {
            const glm::dvec3 ray = pixel_ray(camera, kWidth, kHeight, x, y);
            // Where the ray meets the arm's plane, which is that of the road and near the cut that of the junction.
            const glm::dvec2 into(std::cos(arm.heading_rad), std::sin(arm.heading_rad));
            const double closing = ray.z - arm.grade * glm::dot(into, glm::dvec2(ray));
            const glm::dvec3 from = camera.position_m - glm::dvec3(arm.position_m, arm.elevation_m);
            const double k = -(from.z - arm.grade * glm::dot(into, glm::dvec2(from))) / closing;
            const glm::dvec2 p = glm::dvec2(from) + k * glm::dvec2(ray);
            const double ahead = glm::dot(p, into), n = into.x * p.y - into.y * p.x;
            if (!(k > 0) || std::abs(ahead) > 0.04 || std::abs(n) > arm.left_m - 0.2) continue;
            ++beside;
            ASSERT_NE(frame.road.at(x, y, 0), -1) << arm.road << ": " << x << ", " << y;
            EXPECT_NEAR(frame.depth_m.at(x, y, 0), k, 3e-3 / std::abs(closing) + 1e-3);
            const glm::dvec3 normal = glm::normalize(glm::dvec3(-arm.grade * into, 1));
            EXPECT_NEAR(frame.normal.at(x, y, 0), normal.x, 5e-3);
            EXPECT_NEAR(frame.normal.at(x, y, 1), normal.y, 5e-3);
          }
        }
        EXPECT_GT(beside, 10u);
      }
    }
  }
}

// A level square of ground, 10 m below the middle of a junction.
TerrainMesh meadow(const JunctionSurface& surface) {
  constexpr float kSide_m = 300;
  TerrainMesh mesh;
  mesh.origin_m = surface.center_m - glm::dvec3(0, 0, 10);
  for (const float x : {-kSide_m, kSide_m}) {
    for (const float y : {-kSide_m, kSide_m}) mesh.positions_m.emplace_back(x, y, 0);
  }
  mesh.normals.assign(4, glm::vec3(0, 0, 1));
  mesh.triangles = {0, 2, 1, 1, 2, 3};
  return mesh;
}

// The part of an edge pixel that the junction covers, read off the picture: between the ground behind it, drawn alone,
// and the asphalt beside it; against the same part of a picture at four times the size.
TEST_F(JunctionRender, CornersCoverTheirPartOfEveryPixel) {
  Network network;
  network.junctions = {made(test::crossing_arms())};
  const JunctionSurface surface = junction_surface(network.junctions[0]);
  const TerrainMesh ground = meadow(surface);
  ASSERT_TRUE(renderer_->load_ground({&ground, 1}).ok());
  const auto linear = [](double v) {
    return v <= 0.04045 * 255 ? v / 255 / 12.92 : std::pow((v / 255 + 0.055) / 1.055, 2.4);
  };
  // The cuts are hard: roads are meant to go on there.
  const auto is_at_cut = [&](glm::dvec2 p) {
    return std::any_of(network.junctions[0].arms.begin(), network.junctions[0].arms.end(), [&](const JunctionArm& arm) {
      return glm::dot(p - arm.position_m, glm::dvec2(std::cos(arm.heading_rad), std::sin(arm.heading_rad))) < 0.7;
    });
  };
  const auto is_drawn = [](const Frame& frame, int x, int y) {
    return x >= 0 && y >= 0 && x < frame.road.width && y < frame.road.height && frame.road.at(x, y, 0) == -2;
  };
  constexpr int kFine = 4;
  for (const double pitch : {-89.0, -30.0, -8.0}) {
    const Camera camera = look_at(surface.center_m, 45, 20, pitch);
    ASSERT_TRUE(renderer_->load_roads({}).ok());
    const Frame bare = draw(camera, kColor);
    ASSERT_TRUE(renderer_->load_roads(network).ok());
    const Frame coarse = draw(camera, kColor);
    const Frame fine = draw(camera, kColor | kRoad, kFine * kWidth, kFine * kHeight);
    double sum = 0, bias = 0;
    std::size_t edges = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        int covered = 0;
        bool at_cut = false;
        for (int i = 0; i < kFine * kFine; ++i) {
          const int fx = kFine * x + i % kFine, fy = kFine * y + i / kFine;
          if (!is_drawn(fine, fx, fy)) continue;
          ++covered;
          at_cut = at_cut || is_at_cut(glm::dvec2(surface.center_m) +
                                       glm::dvec2(fine.road.at(fx, fy, 1), fine.road.at(fx, fy, 2)));
        }
        if (covered == 0 || covered == kFine * kFine || at_cut) continue;
        // The asphalt beside the edge: the mean about this pixel of those whose neighbours are asphalt too.
        double asphalt = 0;
        int whole = 0;
        for (int fy = kFine * (y - 1); fy < kFine * (y + 2); ++fy) {
          for (int fx = kFine * (x - 1); fx < kFine * (x + 2); ++fx) {
            if (!is_drawn(fine, fx, fy) || !is_drawn(fine, fx - 1, fy) || !is_drawn(fine, fx + 1, fy) ||
                !is_drawn(fine, fx, fy - 1) || !is_drawn(fine, fx, fy + 1)) {
              continue;
            }
            asphalt += linear(fine.color.at(fx, fy, 2));
            ++whole;
          }
        }
        if (whole == 0) continue;
        asphalt /= whole;
        const double behind = linear(bare.color.at(x, y, 2));
        if (std::abs(asphalt - behind) < 0.04) continue;
        const double part = (linear(coarse.color.at(x, y, 2)) - behind) / (asphalt - behind);
        const double off = part - static_cast<double>(covered) / (kFine * kFine);
        ++edges;
        sum += std::abs(off);
        bias += off;
      }
    }
    std::printf("pitch %.0f: %zu edge pixels, coverage off by %.3f on average, biased by %+.3f\n", pitch, edges,
                sum / static_cast<double>(edges), bias / static_cast<double>(edges));
    EXPECT_GT(edges, 150u);
    // Sixteen samples tell coverage to 0.03 on average, and the grain of the asphalt adds to it; at 8 degrees a pixel is
    // 1.5 m deep on the ground, over which the curves bend. A hard edge is off by 0.25.
    EXPECT_LE(sum / static_cast<double>(edges), 0.12);
    EXPECT_LE(std::abs(bias) / static_cast<double>(edges), 0.08);
  }
}

// Sidewalks without kerbs lie in one plane with the area that they run along: the seam lets no ground through, whether
// the pixels there are small or long.
TEST_F(JunctionRender, NoGroundIsMixedIntoTheSeamOfFlatSidewalks) {
  Network network;
  std::vector<RoadEnd> ends;
  for (int i = 0; i < 4; ++i) {
    const double angle = i * M_PI / 2;
    const glm::dvec2 out(std::cos(angle), std::sin(angle));
    Road road;
    road.id = std::to_string(i);
    road.segments = {make_segment(14.0 * out, 60.0 * out, angle, angle, 7)};
    chain_arc_lengths(road);
    LaneSection section;
    section.left = {{.width_m = {3.5}, .mark = {}}, {.type = LaneType::kSidewalk, .width_m = {3.5}, .mark = {}}};
    section.right = section.left;
    ASSERT_TRUE(set_sections(road, {section}).ok());
    network.roads.push_back(road);
    ends.push_back({road.id, false});
  }
  ASSERT_TRUE(add_crossing(network, "J", ends).ok());
  const auto terrain = Terrain::build(network, nullptr);
  ASSERT_TRUE(terrain.ok());
  std::vector<TerrainMesh> deep = terrain->tiles();
  for (TerrainMesh& tile : deep) tile.origin_m.z -= 2;
  ASSERT_TRUE(renderer_->load_roads(network).ok());
  std::size_t compared = 0, mixed = 0;
  int worst = 0;
  for (const double height : {1.4, 5.0, 20.0}) {
    for (const double yaw : {10.0, 45.0, 95.0, 170.0}) {
      const glm::dvec2 ahead(std::cos(yaw * M_PI / 180), std::sin(yaw * M_PI / 180));
      const Camera camera = {.position_m = glm::dvec3(-(6 + 2 * height) * ahead, height),
                             .yaw_deg = yaw,
                             .pitch_deg = -std::atan2(height, 6 + 2 * height) * 180 / M_PI};
      ASSERT_TRUE(renderer_->load_ground(terrain->tiles()).ok());
      const Frame real = draw(camera, kColor | kLabel);
      ASSERT_TRUE(renderer_->load_ground(deep).ok());
      const Frame away = draw(camera, kColor | kLabel);
      for (int y = 2; y + 2 < kHeight; ++y) {
        for (int x = 2; x + 2 < kWidth; ++x) {
          bool inside = true;  // with all its neighbours, and theirs
          for (int k = 0; k < 25 && inside; ++k) {
            const int nx = x + k % 5 - 2, ny = y + k / 5 - 2;
            inside = real.label.at(nx, ny, 0) >= static_cast<std::uint32_t>(Label::kCarriageway) &&
                     away.label.at(nx, ny, 0) >= static_cast<std::uint32_t>(Label::kCarriageway);
          }
          if (!inside) continue;
          ++compared;
          int difference = 0;
          for (int c = 0; c < 3; ++c) {
            difference = std::max(difference, std::abs(real.color.at(x, y, c) - away.color.at(x, y, c)));
          }
          mixed += difference > 2;
          worst = std::max(worst, difference);
        }
      }
    }
  }
  std::printf("pixels inside road and area: %zu, with ground mixed in: %zu, by at most %d/255\n", compared, mixed,
              worst);
  EXPECT_GT(compared, 100000u);
  // A pixel longer than the underlap holds the area's edge too, whose part it shares with the strip's: a little ground.
  // How much that shows is up to the ground's colours: with the gravel at roads, 14 levels and 3.6 in 1,000; on grass
  // alone, 8 and 1.0.
  EXPECT_LE(worst, 20);
  EXPECT_LE(static_cast<double>(mixed), 4.5e-3 * static_cast<double>(compared));
}

TEST_F(JunctionRender, AWorldMovedByTenThousandKilometresLooksTheSame) {
  const glm::dvec3 far(4096.0 * 2441, -4096.0 * 2441, 0);
  std::vector<JunctionArm> arms = test::crossing_arms();
  Network network;
  network.junctions = {made(arms)};
  for (JunctionArm& a : arms) a.position_m += glm::dvec2(far);
  Network moved;
  moved.junctions = {made(arms)};
  Camera camera = look_at({0, 0, 100}, 25, 30, -9);
  ASSERT_TRUE(renderer_->load_roads(network).ok());
  const Frame a = draw(camera, kColor);
  camera.position_m += far;
  ASSERT_TRUE(renderer_->load_roads(moved).ok());
  const Frame b = draw(camera, kColor);
  int worst = 0;
  for (std::size_t i = 0; i < a.color.pixels.size(); ++i) {
    worst = std::max(worst, std::abs(a.color.pixels[i] - b.color.pixels[i]));
  }
  EXPECT_LE(worst, 2);
}

}  // namespace
}  // namespace roadgen
