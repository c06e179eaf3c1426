// Ditches beside roads: the stated section, where they end, and the terrain's claim with them.
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/fit/heights.h"
#include "roadgen/import/import.h"
#include "terrain/natural.h"
#include "terrain/terrain.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::hairpin_network;
using testing::road_along;
using testing::straight;

constexpr double kSingle_m = 4e-5;  // natural ground comes in single precision
constexpr double kHalfWidth_m = 3.5, kRoad_m = 500, kHeading = 0.3;
const glm::dvec2 kAhead(std::cos(kHeading), std::sin(kHeading)), kLeft(-kAhead.y, kAhead.x);

Network straight_road() {
  Network network;
  network.roads.push_back(road_along(
      "1", 200, 20, kHalfWidth_m,
      [](double s) {
        return straight({0, 0}, kHeading, s);
      },
      [](double) { return kRoad_m; }));
  return network;
}

LevellingOptions with_ditch() {
  LevellingOptions options;
  options.ditch_depth_m = 0.8;
  options.ditch_bottom_m = 0.6;
  options.ditch_inner_slope = 0.4;
  options.ditch_outer_slope = 0.8;
  return options;
}

// The stated section on level ground: how far below the edge at a distance from it.
double section_m(const LevellingOptions& o, double from_edge_m) {
  const double d = from_edge_m - o.shoulder_m, inner = o.ditch_depth_m / o.ditch_inner_slope;
  if (d <= 0 || d >= o.ditch_width_m()) return 0;
  if (d < inner) return o.ditch_inner_slope * d;
  return std::min(o.ditch_depth_m, o.ditch_outer_slope * (o.ditch_width_m() - d));
}

Grid level_ground(double height_m) {
  return {{-200, -200}, {20, 20}, 31, 26, std::vector<float>(31 * 26, static_cast<float>(height_m))};
}

TEST(Ditch, HasTheStatedSection) {
  const Network network = straight_road();
  const RoadIndex index(network);
  const LevellingOptions options = with_ditch();
  EXPECT_NEAR(options.ditch_width_m(), 2 + 0.6 + 1, 1e-12);
  const Grid natural = level_ground(kRoad_m - options.gap_m);
  const Levelling ground(index, natural, options);
  TerrainOptions mesh_options;
  mesh_options.levelling = options;
  mesh_options.margin_m = 100;
  const auto terrain = Terrain::build(network, nullptr, mesh_options);
  ASSERT_TRUE(terrain.ok());
  // On posts 2 m apart, divided down to legs of 0.5 m: the mesh deviates by a fifth of the depth where it is looked at when
  // it is made, and by what a leg more of the steeper slope's half does between these places.
  const double shoulder = std::max(options.shoulder_m, 1.5 * terrain->report().spacing_m);
  const double mesh_error = 0.2 * options.ditch_depth_m + 0.06;
  double worst = 0, deepest = 0;
  for (double s = 30; s < 170; s += 1.7) {
    for (const double side : {-1.0, 1.0}) {
      for (double e = 0; e < 12; e += 0.05) {
        const glm::dvec2 p = s * kAhead + side * (kHalfWidth_m + e) * kLeft;
        EXPECT_NEAR(ground.height_m(p), kRoad_m - options.gap_m - section_m(options, e), kSingle_m) << s << " " << e;
        LevellingOptions raised = options;
        raised.shoulder_m = shoulder;
        const double z = terrain->height_m(p);
        worst = std::max(worst, std::abs(z - (kRoad_m - options.gap_m - section_m(raised, e))));
        deepest = std::max(deepest, kRoad_m - z);
      }
    }
  }
  std::printf("the mesh is off the section by %.3f m at most, and %.3f m deep\n", worst, deepest);
  EXPECT_LT(worst, mesh_error);
  EXPECT_NEAR(deepest, options.ditch_depth_m + options.gap_m, 0.05);
}

// In a cutting the slope begins beyond the ditch; an embankment falls away through it.
TEST(Ditch, LiesInCuttingsAndNotOnEmbankments) {
  const Network network = straight_road();
  const RoadIndex index(network);
  const LevellingOptions options = with_ditch();
  LevellingOptions none = options;
  none.ditch_depth_m = 0;
  const Grid above = level_ground(kRoad_m + 10), below = level_ground(kRoad_m - 10);
  const Levelling cut(index, above, options), fill(index, below, options), fill_without(index, below, none);
  const auto at = [&](double e) { return 100.0 * kAhead + (kHalfWidth_m + e) * kLeft; };
  const double end = options.shoulder_m + options.ditch_width_m();
  for (double e = 0; e < end; e += 0.1) {
    EXPECT_NEAR(cut.height_m(at(e)), kRoad_m - options.gap_m - section_m(options, e), kSingle_m) << e;
  }
  for (double e = end; e < 30; e += 0.1) {
    const double z = cut.height_m(at(e));
    EXPECT_GE(z, kRoad_m - options.gap_m - 1e-6);
    EXPECT_LE(z, kRoad_m + options.cut_slope * (e - end) * 1.5 + 1e-6);
  }
  EXPECT_NEAR(cut.height_m(at(52)), kRoad_m + 10, 0.1);
  for (double e = 0; e < 60; e += 0.1) {
    const double z = fill.height_m(at(e)), without = fill_without.height_m(at(e));
    EXPECT_LE(z, without + 1e-9);
    // Deeper than the ditch the embankment is as it was.
    if (without < kRoad_m - options.ditch_depth_m - options.gap_m) {
      EXPECT_NEAR(z, without, 1e-9) << e;
    }
  }
}

TEST(Ditch, EndsBeforeOtherRoadsAndBridges) {
  Network network = straight_road();
  // A driveway from the left onto the road at s = 60; a bridge from s = 130 to 160.
  network.roads.push_back(road_along(
      "driveway", 60, 20, 2,
      [](double s) { return straight(60.0 * kAhead + kHalfWidth_m * kLeft, kHeading + std::numbers::pi / 2, s); },
      [](double) { return kRoad_m; }));
  network.roads[0].bridges = {{.s_start_m = 130, .s_end_m = 160}};
  const RoadIndex index(network);
  const LevellingOptions options = with_ditch();
  const double width = options.ditch_width_m();
  const Grid natural = level_ground(kRoad_m - options.gap_m);
  const Levelling ground(index, natural, options);
  // Along the middle of the ditch's bottom.
  const double e =
      options.shoulder_m + options.ditch_depth_m / options.ditch_inner_slope + 0.5 * options.ditch_bottom_m;
  const auto depth_m = [&](double s, double side) {
    return kRoad_m - options.gap_m - ground.height_m(s * kAhead + side * (kHalfWidth_m + e) * kLeft);
  };
  double before = 0;
  for (double s = 10; s < 125; s += 0.1) {
    const double left = depth_m(s, 1), beside = std::abs(s - 60) - 2 - options.shoulder_m;
    EXPECT_LE(left, options.ditch_depth_m + 1e-6);
    if (beside <= 0) {
      EXPECT_NEAR(left, 0, kSingle_m) << s;
    }
    if (beside >= width && s < 130 - width) {
      EXPECT_NEAR(left, options.ditch_depth_m, kSingle_m) << s;
    }
    // No step: at most the slope of a ditch, the driveway's own perhaps, and that of the fading.
    if (s > 10) {
      EXPECT_LE(std::abs(left - before), 0.1 * (options.ditch_outer_slope + 1.6 * options.ditch_depth_m / width)) << s;
    }
    before = left;
    if (s < 130 - width) {
      EXPECT_NEAR(depth_m(s, -1), options.ditch_depth_m, kSingle_m) << s;
    }
  }
  // Nothing is dug beside the bridge, and as the ground is level there nothing else is done.
  for (double s = 130; s < 160; s += 0.5) EXPECT_NEAR(depth_m(s, 1), 0, kSingle_m) << s;
  EXPECT_NEAR(depth_m(130.05, -1), 0, 0.01);
}

TEST(Ditch, LeavesTheClaimAsItWas) {
  for (const Network& network : {hairpin_network(0.1), straight_road()}) {
    TerrainOptions options;
    options.levelling = with_ditch();
    options.margin_m = 200;
    const auto terrain = Terrain::build(network, nullptr, options);
    ASSERT_TRUE(terrain.ok());
    const TerrainReport& report = terrain->report();
    const testing::Clearance seen =
        testing::independent_clearance(network, 0.5, [&](glm::dvec2 p) { return terrain->height_m(p); });
    EXPECT_GE(report.clearance_min_m, options.least_clearance_m);
    EXPECT_LE(report.clearance_min_m, seen.min_m);
    EXPECT_LE(report.clearance_max_m, options.most_clearance_m);
    EXPECT_GE(report.clearance_max_m, seen.max_m);
  }
  TerrainOptions wrong;
  wrong.levelling.ditch_depth_m = -0.1;
  EXPECT_EQ(Terrain::build(straight_road(), nullptr, wrong).error().code, ErrorCode::kUsage);
  wrong.levelling.ditch_depth_m = 20;
  EXPECT_EQ(Terrain::build(straight_road(), nullptr, wrong).error().code, ErrorCode::kUsage);
}

// The project's pass, and Monaco with its heights fitted to the ground: roads at different heights side by side and, in the
// source, above one another. Public data: see data sources in README.
TEST(Ditch, LeavesTheClaimAsItWasOnRealRoads) {
  const std::filesystem::path data = std::filesystem::path(ROADGEN_SOURCE_DIR) / "data",
                              shared = std::filesystem::path(ROADGEN_SOURCE_DIR) / "../shared/data";
  const std::filesystem::path monaco = shared / "road-geo/osm-graphhopper/monaco.osm.gz",
                              srtm = shared / "terrain/srtm-hgt/N43E007.hgt.zip";
  for (const bool is_monaco : {false, true}) {
    if (is_monaco && (!std::filesystem::exists(monaco) || !std::filesystem::exists(srtm))) {
      GTEST_SKIP() << "no " << monaco << " or no " << srtm << ": the public data are not here";
    }
    auto imported = import_files({(is_monaco ? monaco : data / "pass.csv").string()}, {});
    ASSERT_TRUE(imported.ok());
    const auto elevation = Elevation::open((is_monaco ? srtm : data / "pass_dem.tif").string());
    ASSERT_TRUE(elevation.ok());
    if (is_monaco) {
      ASSERT_TRUE(fit_heights(imported->network, measured_ground(*elevation, imported->network)).ok());
    }
    TerrainOptions options;
    options.levelling.ditch_depth_m = 0.4;
    options.margin_m = 100;
    const auto terrain = Terrain::build(imported->network, &*elevation, options);
    ASSERT_TRUE(terrain.ok());
    const TerrainReport& r = terrain->report();
    std::printf(
        "%s with ditches: %zu triangles, clearance %.4f to %.3f m; too deep %.4f of the area, %.4f by roads above one "
        "another, at %zu places, %.0f m2 over others; %.1f s\n",
        is_monaco ? "Monaco" : "pass", r.triangles, r.clearance_min_m, r.clearance_max_m, r.too_deep,
        r.too_deep_by_overlap, r.overlap_places, r.over_others_m2, r.seconds);
    EXPECT_GE(r.clearance_min_m, options.least_clearance_m);
    // Where carriageways overlap at different heights no ground is just below both; elsewhere they are nearer to one
    // another than the finest posts, or steeper than these follow.
    EXPECT_LE(r.too_deep, is_monaco ? 0.02 : 0);
    EXPECT_LE(r.too_deep - r.too_deep_by_overlap, is_monaco ? 0.002 : 0);
  }
}

}  // namespace
}  // namespace roadgen
