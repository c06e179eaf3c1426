// The terrain's claim: no ground shows through any carriageway. And the mesh that keeps it.
#include "terrain/terrain.h"

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <set>
#include <span>

#include <gtest/gtest.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/bisection.h"
#include "terrain/height_mesh.h"
#include "terrain/plates.h"
#include "tests/joined_ground.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::Clearance;
using testing::hairpin_network;
using testing::independent_clearance;
using testing::road_along;
using testing::scratch_folder;
using testing::straight;
using testing::write_ascii_grid;

constexpr double kPi = std::numbers::pi;
constexpr double kLeast_m = 0.02, kMost_m = 0.12;  // TerrainOptions' defaults

// Rough mountains: waves of 400 m down to 25 m, on a slope to the south.
double rough_ground_m(double x, double y) {
  return 505 + 0.43 * y + 25 * std::sin(x / 64) * std::cos(y / 71) + 6 * std::sin(x / 17 + 1) * std::sin(y / 13) +
         2 * std::sin(x / 4.1) * std::sin(y / 4.3 + 2);
}

Elevation rough_elevation(const std::string& folder) {
  auto e = Elevation::open(write_ascii_grid(folder + "/rough.asc", {-1200, -1200}, 10, 261, 261, rough_ground_m));
  EXPECT_TRUE(e);
  return std::move(*e);
}

TerrainOptions small() {
  TerrainOptions options;
  options.margin_m = 300;
  return options;
}

// Two straight roads side by side, the second above the first by rise_m, edge to edge gap_m.
Network stacked_legs(double rise_m, double apart_m) {
  Network network;
  network.roads.push_back(road_along(
      "low", 300, 20, 3.5,
      [](double s) {
        return straight({0, 0}, 0.1, s);
      },
      [](double s) { return 500 + 0.05 * s; }));
  const glm::dvec2 beside = (7 + apart_m) * glm::dvec2(-std::sin(0.1), std::cos(0.1));
  network.roads.push_back(road_along(
      "high", 300, 20, 3.5, [=](double s) { return straight(beside, 0.1, s); },
      [=](double s) { return 500 + rise_m + 0.05 * s; }));
  return network;
}

// Crests and dips of 400 m vertical radius with 15 % grades.
Network crest() {
  Network network;
  network.roads.push_back(road_along(
      "crest", 400, 10, 4,
      [](double s) {
        return straight({-200, 40}, 0.4, s);
      },
      [](double s) { return 500 + 0.15 * 60 * std::sin(s / 60); }));
  return network;
}

// Heights with the faults of a bad survey: 3 m up and down every 20 m.
Network faulty_heights() {
  Network network;
  network.roads.push_back(road_along(
      "faulty", 300, 10, 3.5,
      [](double s) {
        return straight({-150, 0}, -0.2, s);
      },
      [](double s) { return 500 + 3 * std::sin(s * kPi / 10 + 0.7); }));
  return network;
}

struct Scene {
  const char* name;
  Network network;
  double greatest_m;  // allowed clearance
};

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  all.push_back({"hairpins at 8 %", hairpin_network(0.08), kMost_m});
  all.push_back({"hairpins at 15 %", hairpin_network(0.15), kMost_m});
  all.push_back({"tight hairpins at 15 %", hairpin_network(0.15, 60, 9), kMost_m});
  all.push_back({"legs 5 m above each other, 8 m apart", stacked_legs(5, 8), kMost_m});
  all.push_back({"legs 3 m above each other, 1 m apart", stacked_legs(3, 1), kMost_m});
  all.push_back({"crest and dip", crest(), kMost_m});
  all.push_back({"faulty heights", faulty_heights(), kMost_m});
  return all;
}

TEST(Terrain, LiesBelowEveryCarriagewayButNotDeep) {
  const Elevation elevation = rough_elevation(scratch_folder());
  for (const Scene& scene : scenes()) {
    for (const Elevation* e : {&elevation, static_cast<const Elevation*>(nullptr)}) {
      SCOPED_TRACE(std::string(scene.name) + (e ? " on rough ground" : " without elevation"));
      const auto terrain = Terrain::build(scene.network, e, small());
      ASSERT_TRUE(terrain) << terrain.error().text();
      const Clearance c =
          independent_clearance(scene.network, 0.25, [&](glm::dvec2 p) { return terrain->height_m(p); });
      EXPECT_GT(c.samples, 10000u);
      EXPECT_GE(c.min_m, kLeast_m);
      EXPECT_LE(c.max_m, scene.greatest_m);
      // Proven: no sample may be outside.
      const TerrainReport& report = terrain->report();
      EXPECT_GE(report.clearance_min_m, kLeast_m);
      EXPECT_LE(report.clearance_min_m, c.min_m);
      EXPECT_GE(report.clearance_max_m, c.max_m);
      std::printf(
          "%-40s %s: %.3f to %.3f m proven, %.3f to %.3f m seen, too deep %.4f, %zu of %zu lowered, by %.3f m\n",
          scene.name, e ? "rough" : "plain", report.clearance_min_m, report.clearance_max_m, c.min_m, c.max_m,
          report.too_deep, report.triangles_lowered, report.triangles_under_roads, report.lowered_max_m);
    }
  }
}

// What the claim is measured against: the same levelled ground on a plain grid of posts, as games and simulators do it.
TEST(Terrain, ANaiveGridOfTheSameGroundCutsThroughTheRoad) {
  const Elevation elevation = rough_elevation(scratch_folder());
  const Network network = hairpin_network(0.15);
  const Bounds b = bounds(network);
  const Grid natural =
      natural_from_elevation(elevation, network, {glm::dvec2(b.low_m) - 200.0, glm::dvec2(b.high_m) + 200.0}, 6);
  const RoadIndex index(network);
  const Levelling ground(index, natural, {});
  Grid naive = natural;
  naive.step_m *= 8.0 / naive.step_m.x;
  naive.columns = naive.columns * 3 / 4;
  naive.rows = naive.rows * 3 / 4;
  naive.values.clear();
  for (int row = 0; row < naive.rows; ++row) {
    for (int column = 0; column < naive.columns; ++column) {
      const glm::dvec2 post = naive.origin_m + naive.step_m * glm::dvec2(column, row);
      naive.values.push_back(static_cast<float>(ground.height_m(post)));
    }
  }
  const Clearance c = independent_clearance(network, 0.25, [&](glm::dvec2 p) { return sample_bilinear(naive, p); });
  EXPECT_LT(c.min_m, -0.1);
  // The proof sees it too.
  const Plates roads(network);
  double least = 1e300;
  for (int row = 0; row + 1 < naive.rows; ++row) {
    for (int column = 0; column + 1 < naive.columns; ++column) {
      const auto post = [&](int i, int j) {
        return glm::dvec3(naive.origin_m + naive.step_m * glm::dvec2(i, j), naive.at(i, j));
      };
      for (const glm::dvec3& third : {post(column + 1, row), post(column, row + 1)}) {
        least = std::min(least, roads.over({post(column, row), post(column + 1, row + 1), third}).least_m);
      }
    }
  }
  EXPECT_LT(least, -0.1);
  // And the natural ground, not levelled at all, buries it.
  const Clearance raw =
      independent_clearance(hairpin_network(0.08), 0.5, [&](glm::dvec2 p) { return sample_bilinear(natural, p); });
  EXPECT_LT(raw.min_m, -3);
}

TEST(Terrain, UnderABridgeTheLowerRoadWins) {
  Network network;
  const auto level = [](double z) { return [z](double) { return z; }; };
  network.roads.push_back(road_along(
      "low", 200, 20, 4,
      [](double s) {
        return straight({-100, 0}, 0, s);
      },
      level(500)));
  network.roads.push_back(road_along(
      "bridge", 200, 20, 4,
      [](double s) {
        return straight({0, -100}, kPi / 2, s);
      },
      level(507)));
  const auto terrain = Terrain::build(network, nullptr, small());
  ASSERT_TRUE(terrain);
  const Clearance c = independent_clearance(network, 0.25, [&](glm::dvec2 p) { return terrain->height_m(p); });
  EXPECT_GE(c.min_m, kLeast_m);
  // The triangles of the wall at the lower road's edges are lowered, since they are steep: by at most what one falls within
  // half a metre, the finest posts of a wall under a carriageway.
  EXPECT_GE(c.max_m, 7.02);
  EXPECT_LE(c.max_m, 8.25);
  EXPECT_LT(terrain->height_m({0, 0}), 500);
  // It is the only place, and told; the upper road is taken for a bridge there, so that nothing else lies deep.
  const TerrainReport& report = terrain->report();
  EXPECT_EQ(report.triangles_too_deep, 0u);
  EXPECT_LE(report.clearance_max_m, kMost_m);
  EXPECT_EQ(report.bridge_parts, 0u);
  EXPECT_EQ(report.assumed_bridge_parts, 1u);
  // The lower road, a shoulder and a slope of 1:1 that rises by 7 m to either side.
  EXPECT_NEAR(report.assumed_bridge_m, 8 + 2 * (3 + 7), 3);
  ASSERT_EQ(report.overlap_places, 1u);
  EXPECT_LT(glm::length(report.overlaps[0].at_m), 12);
  EXPECT_NEAR(report.overlaps[0].apart_m, 7, 1.1);
  EXPECT_GT(report.over_others_m2, 8 * 8);
  EXPECT_LT(report.over_others_m2, 8 * report.assumed_bridge_m + 64);
}

// Two carriageways that do not overlap, however near: a wall stands between them, and neither lies deep.
TEST(Terrain, BetweenRoadsSideBySideStandsAWall) {
  for (const auto& [rise, apart] : {std::pair(3.0, 1.0), {0.5, 0.8}, {6.0, 2.0}}) {
    const Network network = stacked_legs(rise, apart);
    const auto terrain = Terrain::build(network, nullptr, small());
    ASSERT_TRUE(terrain);
    const TerrainReport& report = terrain->report();
    std::printf("%.1f m above each other, %.1f m apart: %.3f to %.3f m, %zu of %zu too deep\n", rise, apart,
                report.clearance_min_m, report.clearance_max_m, report.triangles_too_deep,
                report.triangles_under_roads);
    EXPECT_GE(report.clearance_min_m, kLeast_m);
    EXPECT_LE(report.clearance_max_m, kMost_m);
    EXPECT_EQ(report.triangles_too_deep, 0u);
    EXPECT_EQ(report.overlap_places, 0u);
    EXPECT_EQ(report.over_others_m2, 0);
  }
}

// Nor does a bridge that stands lower take the ground from under a road beside it.
TEST(Terrain, BetweenARoadAndALowerBridgeStandsAWall) {
  Network network = stacked_legs(3, 1);
  network.roads[0].bridges = {{.s_start_m = 0, .s_end_m = network.roads[0].length_m()}};
  const auto terrain = Terrain::build(network, nullptr, small());
  ASSERT_TRUE(terrain);
  const TerrainReport& report = terrain->report();
  EXPECT_EQ(report.bridge_parts, 1u);
  EXPECT_GE(report.clearance_min_m, kLeast_m);
  EXPECT_LE(report.clearance_max_m, kMost_m);
  EXPECT_EQ(report.triangles_too_deep, 0u);
  const glm::dvec3 deck = pose_at(network.roads[0], 150, 0).position_m;
  EXPECT_LE(terrain->height_m(glm::dvec2(deck)), deck.z - kLeast_m);
}

TEST(Terrain, BetweenLegsThereAreRampsNotCliffs) {
  const Elevation elevation = rough_elevation(scratch_folder());
  const Network network = hairpin_network(0.08);
  const auto terrain = Terrain::build(network, &elevation, small());
  ASSERT_TRUE(terrain);
  // Up to 17 m of height over the 10.5 m between two shoulders: 1.6 on the mean, and at most twice that.
  double steepest = 0;
  for (double x = 5; x < 85; x += 0.5) {
    for (double y = 0; y < 140; y += 0.5) {
      const glm::dvec3 n = terrain->normal({x, y});
      steepest = std::max(steepest, std::hypot(n.x, n.y) / n.z);
    }
  }
  EXPECT_LT(steepest, 3.2);
}

// A vertex's place in units of 1/1024 m: exact as integers.
constexpr double kQuanta = 1024;  // per metre
using Corner = std::pair<long long, long long>;
Corner corner(const TerrainMesh& tile, std::uint32_t v) {
  const glm::dvec2 p = glm::dvec2(tile.origin_m) + glm::dvec2(glm::vec2(tile.positions_m[v]));
  const glm::dvec2 scaled = p * kQuanta;
  EXPECT_EQ(scaled.x, std::floor(scaled.x));
  return {static_cast<long long>(scaled.x), static_cast<long long>(scaled.y)};
}

// Every triangle is a real one, every edge is one of two triangles, or lies on the border of the area, and tiles agree.
void expect_no_cracks(std::span<const TerrainMesh> tiles, const Rectangle& area) {
  std::map<std::pair<Corner, Corner>, int> edges;
  std::map<Corner, double> heights;
  double total = 0;
  for (const TerrainMesh& tile : tiles) {
    ASSERT_EQ(tile.positions_m.size(), tile.normals.size());
    for (std::size_t i = 0; i + 2 < tile.triangles.size(); i += 3) {
      Corner c[3];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t v = tile.triangles[i + k];
        c[k] = corner(tile, v);
        // Tiles agree in height where they meet, to the last bit.
        const double z = tile.origin_m.z + tile.positions_m[v].z;
        EXPECT_EQ(heights.emplace(c[k], z).first->second, z);
      }
      const double area2 = static_cast<double>((c[1].first - c[0].first) * (c[2].second - c[0].second) -
                                               (c[2].first - c[0].first) * (c[1].second - c[0].second));
      ASSERT_GT(area2, 0);
      total += 0.5 * area2 / (kQuanta * kQuanta);
      for (int k = 0; k < 3; ++k) ++edges[{c[k], c[(k + 1) % 3]}];
    }
  }
  EXPECT_NEAR(total, (area.high_m.x - area.low_m.x) * (area.high_m.y - area.low_m.y), 1e-3);
  double border = 0;
  for (const auto& [edge, count] : edges) {
    ASSERT_EQ(count, 1);
    if (edges.count({edge.second, edge.first})) continue;
    const double dx = static_cast<double>(edge.second.first - edge.first.first) / kQuanta;
    const double dy = static_cast<double>(edge.second.second - edge.first.second) / kQuanta;
    border += std::hypot(dx, dy);
    // An edge with one triangle only lies on the border of the area.
    const double x = static_cast<double>(edge.first.first) / kQuanta,
                 y = static_cast<double>(edge.first.second) / kQuanta;
    EXPECT_TRUE((dx == 0 && (x == area.low_m.x || x == area.high_m.x)) ||
                (dy == 0 && (y == area.low_m.y || y == area.high_m.y)));
  }
  EXPECT_NEAR(border, 2 * (area.high_m.x - area.low_m.x + area.high_m.y - area.low_m.y), 1e-6);
}

TEST(Terrain, TheMeshHasNoCracksAndNoSlivers) {
  const Elevation elevation = rough_elevation(scratch_folder());
  TerrainOptions options = small();
  options.margin_m = 900;
  const auto terrain = Terrain::build(hairpin_network(0.08), &elevation, options);
  ASSERT_TRUE(terrain);
  EXPECT_GT(terrain->tiles().size(), 1u);
  EXPECT_EQ(test::triangle_count(terrain->tiles()), terrain->report().triangles);
  expect_no_cracks(terrain->tiles(), terrain->report().area);
}

// Seen from any place, within any part of its distance: without cracks, also between tiles, and no further from the mesh.
TEST(Terrain, LevelsOfDetailHaveNoCracksAndStayWithinTheirError) {
  const Elevation elevation = rough_elevation(scratch_folder());
  TerrainOptions options = small();
  options.margin_m = 900;
  const auto terrain = Terrain::build(hairpin_network(0.08), &elevation, options);
  ASSERT_TRUE(terrain);
  const TerrainReport& report = terrain->report();
  std::mt19937 random(14);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t last = report.triangles;
  for (const double part : {0.0, 0.0005, 0.002, 0.01, 0.05}) {
    const glm::dvec2 flat = glm::mix(report.area.low_m, report.area.high_m, glm::dvec2(unit(random), unit(random)));
    const glm::dvec3 eye(flat, terrain->height_m(flat) + 2 + 50 * unit(random));
    const std::vector<TerrainMesh> tiles = test::joined(terrain->tiles(), {.eye_m = eye, .part = part});
    expect_no_cracks(tiles, report.area);
    double worst = 0;
    for (const TerrainMesh& tile : tiles) {
      for (std::size_t i = 0; i + 2 < tile.triangles.size(); i += 3) {
        const auto at = [&](std::size_t k) { return glm::dvec3(tile.positions_m[tile.triangles[i + k]]); };
        for (int sample = 0; sample < 20; ++sample) {
          double a = unit(random), b = unit(random);
          if (a + b > 1) a = 1 - a, b = 1 - b;
          const glm::dvec3 p = tile.origin_m + at(0) + a * (at(1) - at(0)) + b * (at(2) - at(0));
          const double off = std::abs(terrain->height_m(glm::dvec2(p)) - p.z);
          worst = std::max(worst, (off - 1e-9) / std::max(part * glm::length(p - eye), 1e-9));
        }
      }
    }
    std::printf("%.4f of the distance: %zu of %zu triangles, at most %.3f of the error\n", part,
                test::triangle_count(tiles), report.triangles, worst);
    EXPECT_LE(worst, 1);
    EXPECT_LE(test::triangle_count(tiles), last);
    last = test::triangle_count(tiles);
  }
  EXPECT_LT(last, report.triangles / 5);
  const std::vector<TerrainMesh> coarsest = test::coarsest(terrain->tiles());
  EXPECT_EQ(test::triangle_count(coarsest), report.triangles_coarsest);
  expect_no_cracks(coarsest, report.area);
}

// Whatever part of whichever tiles has been read, the rest is drawn coarser without cracks, and from no more than is there.
TEST(Terrain, TilesThatAreNotAllThereFitTogether) {
  const Elevation elevation = rough_elevation(scratch_folder());
  TerrainOptions options = small();
  options.margin_m = 900;
  const auto terrain = Terrain::build(hairpin_network(0.08), &elevation, options);
  ASSERT_TRUE(terrain);
  const std::span<const GroundTile> tiles = terrain->ground()->tiles();
  ASSERT_GT(tiles.size(), 3u);
  std::mt19937 random(15);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t lacking = 0;
  for (int trial = 0; trial < 24; ++trial) {
    const Rectangle& area = terrain->report().area;
    const glm::dvec2 flat = glm::mix(area.low_m, area.high_m, glm::dvec2(unit(random), unit(random)));
    Detail detail{{flat, terrain->height_m(flat) + 2}, 1, 1e-5 * std::pow(1000, unit(random))};
    std::vector<std::uint32_t> bands;
    for (const GroundTile& tile : tiles) {
      const std::uint32_t needed = bands_needed(tile, detail);
      bands.push_back(unit(random) < 0.5 ? needed : 1 + static_cast<std::uint32_t>(unit(random) * needed));
      if (bands.back() >= needed) continue;
      detail.gaps.push_back(gap_of(tile, bands.back()));
      ++lacking;
    }
    std::vector<TerrainMesh> drawn = terrain->tiles();
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      // What is not there is no number, so that whatever reads it is found.
      const std::uint32_t known = tiles[i].bands[bands[i] - 1].vertices;
      const auto lose = [&](std::vector<float>& of) { std::fill(of.begin() + known, of.end(), NAN); };
      lose(drawn[i].error_m);
      lose(drawn[i].radius_m);
      std::vector<std::uint32_t> chosen;
      select_triangles(view_of(drawn[i]), bands[i], detail, chosen);
      for (const std::uint32_t v : chosen) ASSERT_LT(v, known);
      drawn[i].triangles = chosen;
    }
    expect_no_cracks(drawn, area);
  }
  EXPECT_GT(lacking, 20u);
}

// The bands are meshes of their own, of falling error, and the first holds what is always drawn.
TEST(Terrain, BandsGoFromCoarseToFine) {
  const Elevation elevation = rough_elevation(scratch_folder());
  const auto terrain = Terrain::build(hairpin_network(0.1), &elevation, small());
  ASSERT_TRUE(terrain);
  for (const TerrainMesh& tile : terrain->tiles()) {
    ASSERT_FALSE(tile.bands.empty());
    EXPECT_EQ(tile.bands.back().vertices, tile.positions_m.size());
    EXPECT_EQ(tile.bands.back().nodes, tile.nodes.size());
    std::size_t band = 0;
    float error = std::numeric_limits<float>::infinity();
    for (std::size_t i = 0; i < tile.nodes.size(); ++i) {
      if (i == tile.bands[band].nodes) ++band;
      const TerrainMesh::Node& node = tile.nodes[i];
      EXPECT_TRUE(node.child < 0 || node.child > static_cast<std::int32_t>(i));
    }
    for (std::size_t i = tile.bands[0].vertices; i < tile.error_m.size(); ++i) {
      EXPECT_LE(tile.error_m[i], error);
      error = tile.error_m[i];
      EXPECT_FALSE(std::isinf(error));
    }
    for (const std::uint32_t v : std::span(tile.triangles).subspan(tile.whole())) {
      EXPECT_LT(v, tile.bands[0].vertices);
    }
  }
}

TEST(Terrain, HeightIsThatOfTheDrawnTriangles) {
  const Elevation elevation = rough_elevation(scratch_folder());
  const auto terrain = Terrain::build(hairpin_network(0.1), &elevation, small());
  ASSERT_TRUE(terrain);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  for (const TerrainMesh& tile : terrain->tiles()) {
    for (std::size_t i = 0; i + 2 < tile.triangles.size(); i += 3) {
      double a = unit(random), b = unit(random);
      if (a + b > 1) a = 1 - a, b = 1 - b;
      const glm::dvec3 p0(tile.positions_m[tile.triangles[i]]), p1(tile.positions_m[tile.triangles[i + 1]]),
          p2(tile.positions_m[tile.triangles[i + 2]]);
      const glm::dvec3 p = tile.origin_m + p0 + a * (p1 - p0) + b * (p2 - p0);
      ASSERT_NEAR(terrain->height_m(glm::dvec2(p)), p.z, 1e-9);
      const glm::dvec3 flat = glm::normalize(glm::cross(p1 - p0, p2 - p0));
      if (a > 0.01 && b > 0.01 && a + b < 0.99) {
        ASSERT_NEAR(glm::length(terrain->normal(glm::dvec2(p)) - flat), 0, 1e-9);
      }
    }
  }
  // Outside, the border goes on.
  const Rectangle area = terrain->report().area;
  EXPECT_EQ(terrain->height_m({area.low_m.x - 100, 0}), terrain->height_m({area.low_m.x, 0}));
}

TEST(Terrain, FarFromRoadsTheGroundIsNatural) {
  const Elevation elevation = rough_elevation(scratch_folder());
  const Network network = hairpin_network(0.08);
  const auto terrain = Terrain::build(network, &elevation, small());
  ASSERT_TRUE(terrain);
  const RoadIndex index(network);
  std::size_t checked = 0;
  for (double x = -250; x < 350; x += 7.3) {
    for (double y = -250; y < 350; y += 9.1) {
      const auto near = index.to_road(glm::dvec2(x, y), 1000);
      if (near->outside_m < 70) continue;
      ++checked;
      // The mesh's tolerance, doubled since errors are sampled.
      EXPECT_NEAR(terrain->height_m({x, y}), elevation.height_m({x, y}), 2 * (0.12 + 0.003 * near->outside_m) + 0.5);
    }
  }
  EXPECT_GT(checked, 1000u);
}

TEST(Terrain, TriangleLimitCoarsensTheCountryNotTheRoad) {
  const Elevation elevation = rough_elevation(scratch_folder());
  const Network network = hairpin_network(0.08);
  const auto fine = Terrain::build(network, &elevation, small());
  TerrainOptions options = small();
  options.max_triangles = fine->report().triangles * 2 / 3;
  const auto coarse = Terrain::build(network, &elevation, options);
  ASSERT_TRUE(coarse);
  EXPECT_LE(coarse->report().triangles, options.max_triangles);
  EXPECT_GT(coarse->report().tolerance_factor, 1);
  const Clearance c = independent_clearance(network, 0.25, [&](glm::dvec2 p) { return coarse->height_m(p); });
  EXPECT_GE(c.min_m, kLeast_m);
}

TEST(Terrain, AWorldFarFromTheOriginKeepsTheClaim) {
  Network network = hairpin_network(0.15);
  for (Segment& s : network.roads[0].segments) {
    s.start_m += glm::dvec2(1e7, -1e7);
    s.end_m += glm::dvec2(1e7, -1e7);
  }
  const auto terrain = Terrain::build(network, nullptr, small());
  ASSERT_TRUE(terrain);
  const Clearance c = independent_clearance(network, 0.25, [&](glm::dvec2 p) { return terrain->height_m(p); });
  EXPECT_GE(c.min_m, kLeast_m);
  EXPECT_LE(c.max_m, 0.16);
  for (const TerrainMesh& tile : terrain->tiles()) {
    for (const glm::vec3& p : tile.positions_m) ASSERT_LE(std::max(std::abs(p.x), std::abs(p.y)), 1025);
  }
}

TEST(Terrain, TellsItsProgressAndRefusesNonsense) {
  const Network network = hairpin_network(0.05);
  double last = -1;
  TerrainOptions options = small();
  options.progress = [&](double fraction) {
    EXPECT_GE(fraction, last);
    last = fraction;
  };
  ASSERT_TRUE(Terrain::build(network, nullptr, options));
  EXPECT_EQ(last, 1);
  EXPECT_FALSE(Terrain::build(Network{}, nullptr, small()));
  options = small();
  options.levelling.gap_m = 0;
  const auto bad = Terrain::build(network, nullptr, options);
  ASSERT_FALSE(bad);
  EXPECT_EQ(bad.error().code, ErrorCode::kUsage);
}

TEST(Terrain, IsWrittenAsElevationThatReadsBackTheSame) {
  Network network = hairpin_network(0.08);
  network.georeference = Georeference{46.5, 8.5, 0};
  const auto terrain = Terrain::build(network, nullptr, small());
  ASSERT_TRUE(terrain);
  const std::string path = scratch_folder() + "/levelled.tif";
  const Status written = write_terrain(*terrain, network, 2, path);
  ASSERT_TRUE(written) << written.error().text();
  const auto back = Elevation::open(path);
  ASSERT_TRUE(back);
  for (double s = 5; s < 800; s += 31) {
    const glm::dvec2 p(pose_at(network.roads[0], s, 0).position_m);
    EXPECT_NEAR(elevation_enu_m(*back, network, p), terrain->height_m(p), 0.05);
  }
}

// An uneven mesh. Asked from several threads, so a function of the triangle alone.
bool deep_or_one_of_three(const Bisection::Triangle& t) {
  return t.level < 3 || (t.apex * 2654435761u ^ t.left * 2246822519u ^ t.right * 3266489917u) % 3 == 0;
}

// The height of a place on a mesh, by looking at every leaf.
double height_of(const Bisection& mesh, const std::vector<std::int32_t>& leaves, glm::dvec2 p, glm::dvec2& slope) {
  for (const std::int32_t leaf : leaves) {
    const Bisection::Triangle& t = mesh.triangle(leaf);
    const glm::dvec2 apex(mesh.lattice(t.apex)), l = glm::dvec2(mesh.lattice(t.left)) - apex,
                                                 r = glm::dvec2(mesh.lattice(t.right)) - apex, q = p - apex;
    const double area = l.x * r.y - l.y * r.x;
    const double a = (q.x * r.y - q.y * r.x) / area, b = (l.x * q.y - l.y * q.x) / area;
    if (a < 0 || b < 0 || a + b > 1) continue;
    const double to_l = mesh.height(t.left) - mesh.height(t.apex), to_r = mesh.height(t.right) - mesh.height(t.apex);
    slope = glm::dvec2(to_l * r.y - to_r * l.y, to_r * l.x - to_l * r.x) / area;
    return mesh.height(t.apex) + a * to_l + b * to_r;
  }
  ADD_FAILURE() << "no leaf holds " << p.x << ", " << p.y;
  return 0;
}

// One by one and in batches of any size, everywhere, and beyond the border as at it.
TEST(HeightMesh, TellsThePlaneOfTheLeafThatHoldsAPlace) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> quanta(-2000000, 9000000);
  Bisection mesh({3, 2}, 6, [&](glm::ivec2 p) { return ((p.x * 7919 + p.y * 104729) % 100000) / 1024.0; });
  ASSERT_TRUE(mesh.refine(deep_or_one_of_three, 100000));
  for (std::uint32_t v = 0; v < mesh.vertices(); ++v) mesh.set_height(v, quanta(random) / 1024.0);
  const std::vector<std::int32_t> leaves = mesh.all_leaves();
  const HeightMesh heights(mesh, 1.0 / 1024);
  EXPECT_TRUE(heights.is_sound());
  std::uniform_real_distribution<double> px(-10, 202), py(-10, 138);
  std::vector<glm::dvec2> places;
  for (int i = 0; i < 2000; ++i) places.emplace_back(px(random), py(random));
  for (const double x : {0.0, 64.0, 100.0, 192.0}) {
    for (const double y : {0.0, 32.0, 64.0, 128.0}) places.emplace_back(x, y);
  }
  std::vector<double> told(places.size());
  heights.heights_m(places, told);
  for (std::size_t i = 0; i < places.size(); ++i) {
    const glm::dvec2 p = places[i], inside = glm::clamp(p, glm::dvec2(0), glm::dvec2(192, 128));
    glm::dvec2 slope(0, 0);
    EXPECT_NEAR(heights.height_m(p), height_of(mesh, leaves, inside, slope), 1e-6);
    EXPECT_EQ(told[i], heights.height_m(p));
    // At vertices there are several.
    if (i < 2000 && p == inside) {
      EXPECT_LT(glm::length(heights.gradient(p) - slope), 1e-9);
    }
  }
  std::vector<double> few(5);
  heights.heights_m(std::span(places).first(5), few);
  EXPECT_TRUE(std::equal(few.begin(), few.end(), told.begin()));
  for (const glm::dvec2 p : {glm::dvec2(NAN, 3), glm::dvec2(INFINITY, -INFINITY), glm::dvec2(1e300, NAN)}) {
    EXPECT_TRUE(std::isfinite(heights.height_m(p)));
  }
}

TEST(Bisection, StaysConforming) {
  Bisection mesh({3, 2}, 6, [](glm::ivec2 p) { return 0.5 * p.x - 0.25 * p.y; });
  ASSERT_TRUE(mesh.refine(deep_or_one_of_three, 100000));
  ASSERT_GT(mesh.leaves(), 200u);
  std::set<std::int32_t> all;
  const auto add = [&](const auto& self, std::int32_t i) -> void {
    if (mesh.child(i) < 0) {
      all.insert(i);
    } else {
      self(self, mesh.child(i)), self(self, mesh.child(i) + 1);
    }
  };
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) add(add, mesh.root({x, y})), add(add, mesh.root({x, y}) + 1);
  }
  EXPECT_EQ(all.size(), mesh.leaves());
  // Neighbours know each other.
  for (const std::int32_t leaf : all) {
    const Bisection::Triangle& t = mesh.triangle(leaf);
    for (const std::int32_t other : {t.across_base, t.across_left, t.across_right}) {
      if (other < 0) continue;
      const Bisection::Triangle& o = mesh.triangle(other);
      EXPECT_TRUE(o.across_base == leaf || o.across_left == leaf || o.across_right == leaf);
    }
  }
}

}  // namespace
}  // namespace roadgen
