// Elevation and roads that do not suit one another: an honest ground, or one error that names the place.
#include <cmath>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/natural.h"
#include "terrain/terrain.h"
#include "tests/temporary_folder.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::road_along;
using testing::straight;
using testing::write_ascii_grid;

Network level_road(double length_m = 200) {
  Network network;
  network.roads.push_back(road_along(
      "1", length_m, 20, 3.5,
      [](double s) {
        return straight({0, 0}, 0.2, s);
      },
      [](double) { return 50; }));
  return network;
}

void expect_sound(const Terrain& terrain) {
  EXPECT_GE(terrain.report().clearance_min_m, 0.02);
  for (const TerrainMesh& tile : terrain.tiles()) {
    for (std::size_t i = 0; i < tile.positions_m.size(); ++i) {
      EXPECT_TRUE(std::isfinite(tile.positions_m[i].z));
      EXPECT_NEAR(glm::length(tile.normals[i]), 1, 1e-5);
    }
  }
}

TEST(BadElevation, OverflownNumbersAreVoidsAndTold) {
  const test::TemporaryFolder folder;
  // -11 m as SRTM has it on some shores, read as if it had no sign; and one that wrapped around.
  const auto post = [](double x, double y) -> std::string {
    if (x == 10 && y == 20) return "65525";
    if (x == 30 && y == 20) return "-25536";
    return "50";
  };
  const std::string path = write_ascii_grid(folder.path("o.asc"), {-100, -100}, 10, 41, 31, post);
  Diagnostics told;
  const auto elevation = Elevation::open(path, &told);
  ASSERT_TRUE(elevation.ok()) << elevation.error().text();
  EXPECT_EQ(elevation->voids_filled(), 2u);
  EXPECT_NEAR(elevation->height_m({10, 20}), 50, 1e-4);
  EXPECT_FALSE(elevation->is_measured({12, 22}));
  EXPECT_TRUE(elevation->is_measured({-50, -50}));
  ASSERT_FALSE(told.empty());
  EXPECT_NE(told[0].message.find("2 posts"), std::string::npos) << told[0].message;
  EXPECT_NE(told[0].message.find("65525 m at x 10"), std::string::npos) << told[0].message;
  const auto all = Elevation::open(
      write_ascii_grid(folder.path("a.asc"), {0, 0}, 10, 4, 4, [](double, double) { return 40000.0; }), nullptr);
  ASSERT_FALSE(all.ok());
  EXPECT_NE(all.error().message.find("16 posts"), std::string::npos);
}

TEST(BadElevation, WrongCoordinateSystemsAreErrors) {
  const test::TemporaryFolder folder;
  // Metres of some map, without saying which, for roads on the Earth; and degrees for roads that are not.
  const auto flat = [](double, double) { return 50.0; };
  const auto metres = Elevation::open(write_ascii_grid(folder.path("m.asc"), {370000, 4840000}, 30, 20, 20, flat));
  const auto degrees = Elevation::open(write_ascii_grid(folder.path("d.asc"), {7, 43}, 0.001, 20, 20, flat));
  ASSERT_TRUE(metres.ok() && degrees.ok());
  Network on_earth = level_road();
  on_earth.georeference = Georeference{43.01, 7.01, 0};
  const auto a = Terrain::build(on_earth, &*metres);
  ASSERT_FALSE(a.ok());
  EXPECT_NE(a.error().message.find("no coordinate system"), std::string::npos) << a.error().message;
  const auto b = Terrain::build(level_road(), &*degrees);
  ASSERT_FALSE(b.ok());
  EXPECT_NE(b.error().message.find("no georeference"), std::string::npos) << b.error().message;
}

TEST(BadElevation, PartialCoverIsAnErrorWithBothExtents) {
  const test::TemporaryFolder folder;
  const auto half = Elevation::open(
      write_ascii_grid(folder.path("h.asc"), {-100, -100}, 10, 21, 31, [](double, double) { return 50.0; }));
  ASSERT_TRUE(half.ok());
  const auto built = Terrain::build(level_road(), &*half);
  ASSERT_FALSE(built.ok());
  EXPECT_EQ(built.error().code, ErrorCode::kData);
  EXPECT_NE(built.error().message.find("x -100.00 to 100.00 m"), std::string::npos) << built.error().message;
  EXPECT_NE(built.error().message.find("but the roads need"), std::string::npos);
}

// The ground falls by 120 m from one post to the next across the road: cut on the one side, filled on the other.
TEST(BadElevation, ARoadThroughACliffIsCutAndFilled) {
  const test::TemporaryFolder folder;
  const auto cliff = Elevation::open(write_ascii_grid(folder.path("c.asc"), {-200, -200}, 10, 61, 51,
                                                      [](double x, double) { return x < 95 ? 110.0 : -10.0; }));
  ASSERT_TRUE(cliff.ok());
  TerrainOptions options;
  options.margin_m = 120;
  const auto built = Terrain::build(level_road(), &*cliff, options);
  ASSERT_TRUE(built.ok()) << built.error().text();
  expect_sound(*built);
  EXPECT_GT(built->report().deepest_cut_m, 55);
  EXPECT_GT(built->report().highest_fill_m, 55);
  EXPECT_LE(built->report().clearance_max_m, options.most_clearance_m);
}

// Two roads that cross at one height, without a junction: the ground lies below both.
TEST(BadElevation, TwoRoadsThatCrossAtOneHeightAreBothClear) {
  Network network = level_road();
  network.roads.push_back(road_along(
      "2", 200, 20, 3.5,
      [](double s) {
        return straight({100, -80}, 1.4, s);
      },
      [](double s) { return 50 + 0.02 * (s - 100); }));
  TerrainOptions options;
  options.margin_m = 80;
  const auto built = Terrain::build(network, nullptr, options);
  ASSERT_TRUE(built.ok()) << built.error().text();
  expect_sound(*built);
  const testing::Clearance seen =
      testing::independent_clearance(network, 0.7, [&](glm::dvec2 p) { return built->height_m(p); });
  EXPECT_GE(seen.min_m, 0.02);
}

}  // namespace
}  // namespace roadgen
