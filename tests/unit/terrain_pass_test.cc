// The project's own pass road: that it is what data/README.md says, and that the terrain's claim holds on it.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/geodesy/local_frame.h"
#include "terrain/terrain.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

const std::string kData = std::string(ROADGEN_SOURCE_DIR) + "/data/";

Network pass_network() {
  Network network;
  std::ifstream in(kData + "pass.csv");
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line, "lat,lon,height");
  std::optional<LocalFrame> frame;
  std::vector<Anchor> anchors;
  while (std::getline(in, line)) {
    Geodetic g;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf", &g.latitude_deg, &g.longitude_deg, &g.height_m) != 3) continue;
    if (!frame) {
      network.georeference = Georeference{g.latitude_deg, g.longitude_deg, 0};
      frame.emplace(*network.georeference);
    }
    const glm::dvec3 p = frame->to_local_m(g);
    anchors.push_back({glm::dvec2(p), p.z, 3.5});
  }
  AlignmentOptions options;
  options.tangents = Tangents::kCentripetal;
  auto road = road_from_anchors(anchors, options);
  EXPECT_TRUE(road) << road.error().text();
  if (road) network.roads.push_back(std::move(*road));
  return network;
}

TEST(PassData, IsAnAlpinePassRoad) {
  const Network network = pass_network();
  ASSERT_EQ(network.roads.size(), 1u);
  const Road& road = network.roads[0];
  EXPECT_GT(road.length_m(), 8000);
  EXPECT_LT(road.length_m(), 15000);
  // A hairpin turns by more than 130 degrees within 90 m.
  int hairpins = 0;
  double turned = 0, steepest = 0, high = -1e9;
  std::vector<double> turns;
  for (double s = 0; s < road.length_m(); s += 1) {
    turns.push_back(pose_at(road, s, 0).curvature_per_m);
    turned += turns.back();
    if (turns.size() > 90) turned -= turns[turns.size() - 91];
    if (std::abs(turned) > 130 * 3.14159 / 180) {
      ++hairpins;
      turned = 0;
      turns.clear();
    }
    high = std::max(high, pose_at(road, s, 0).position_m.z);
    if (s > 60) {
      const double rise = pose_at(road, s, 0).position_m.z - pose_at(road, s - 50, 0).position_m.z;
      steepest = std::max(steepest, std::abs(rise) / 50);
    }
  }
  EXPECT_GE(hairpins, 8);
  EXPECT_LT(steepest, 0.115);
  const double start = pose_at(road, 0, 0).position_m.z, end = pose_at(road, road.length_m(), 0).position_m.z;
  EXPECT_GT(high - start, 300);
  EXPECT_GT(high - end, 100);
}

TEST(PassData, MountainsCoverTheRoadWithMargin) {
  EXPECT_LT(std::filesystem::file_size(kData + "pass_dem.tif"), 400u * 1024);
  const auto elevation = Elevation::open(kData + "pass_dem.tif");
  ASSERT_TRUE(elevation) << elevation.error().text();
  EXPECT_TRUE(elevation->is_geographic());
  EXPECT_EQ(elevation->voids_filled(), 0u);
  EXPECT_NEAR(elevation->post_spacing_m(), 26.9, 0.5);
  const Network network = pass_network();
  ASSERT_TRUE(check_coverage(*elevation, network));
  const Rectangle covered = covered_rectangle(*elevation, network);
  const Bounds roads = bounds(network);
  EXPECT_GT(roads.low_m.x - covered.low_m.x, 1500);
  EXPECT_GT(covered.high_m.y - roads.high_m.y, 1500);
  const auto range = std::minmax_element(elevation->posts().values.begin(), elevation->posts().values.end());
  EXPECT_GT(*range.second - *range.first, 800);
}

TEST(PassData, NoTerrainShowsThroughThePassRoad) {
  const auto elevation = Elevation::open(kData + "pass_dem.tif");
  ASSERT_TRUE(elevation);
  const Network network = pass_network();
  const auto terrain = Terrain::build(network, &*elevation);
  ASSERT_TRUE(terrain) << terrain.error().text();
  const TerrainReport& report = terrain->report();
  const testing::Clearance c =
      testing::independent_clearance(network, 0.23, [&](glm::dvec2 p) { return terrain->height_m(p); });
  EXPECT_GE(report.clearance_min_m, 0.02);
  EXPECT_LE(report.clearance_min_m, c.min_m);
  EXPECT_GE(report.clearance_max_m, c.max_m);
  EXPECT_LE(report.clearance_max_m, 0.12);
  EXPECT_GT(report.triangles, 100000u);
  EXPECT_LT(report.triangles, 400000u);
  EXPECT_EQ(report.tolerance_factor, 1);
  EXPECT_LT(report.deepest_cut_m, 7);
  EXPECT_LT(report.highest_fill_m, 7);
  std::printf(
      "pass: clearance %.4f to %.4f m proven, %.4f to %.4f seen, %zu triangles, cut %.1f m, fill %.1f m, %.2f s\n",
      report.clearance_min_m, report.clearance_max_m, c.min_m, c.max_m, report.triangles, report.deepest_cut_m,
      report.highest_fill_m, report.seconds);
}

}  // namespace
}  // namespace roadgen
