// Terrain kept in files: read back to the bit, and refused where it is another's or damaged.
#include <filesystem>
#include <random>

#include <gtest/gtest.h>

#include "terrain/terrain_file.h"
#include "tests/temporary_folder.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

namespace fs = std::filesystem;

Network tunnel_network() {
  Network network;
  network.roads.push_back(testing::road_along(
      "1", 400, 20, 3.5,
      [](double s) {
        return testing::straight({0, 0}, 0.3, s);
      },
      [](double) { return 100; }));
  network.roads[0].sweeps = {{.s_start_m = 150, .s_end_m = 250, .shape = Tunnel{.half_width_m = 5}}};
  return network;
}

class TerrainFile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto hill = [](double x, double y) {
      return 101 + 30 * std::exp(-std::pow((x * 0.955 + y * 0.296 - 200) / 45, 6));
    };
    auto elevation =
        Elevation::open(testing::write_ascii_grid(folder_.path("hill.asc"), {-200, -200}, 5, 141, 121, hill));
    ASSERT_TRUE(elevation.ok());
    elevation_.emplace(std::move(*elevation));
    options_.margin_m = 100;
    auto built = Terrain::build(tunnel_network(), &*elevation_, options_);
    ASSERT_TRUE(built.ok()) << built.error().text();
    built_.emplace(std::move(*built));
    ASSERT_GT(built_->report().triangles_cut, 0u);
    path_ = folder_.path("net.ground");
    key_ = terrain_key("the network", &*elevation_, options_);
  }
  test::TemporaryFolder folder_;
  TerrainOptions options_;
  std::optional<Elevation> elevation_;
  std::optional<Terrain> built_;
  std::string path_;
  std::uint64_t key_ = 0;
};

TEST_F(TerrainFile, IsReadBackToTheBit) {
  ASSERT_TRUE(write_terrain_file(*built_, key_, path_).ok());
  EXPECT_FALSE(fs::exists(path_ + ".part"));
  const auto read = read_terrain_file(path_, key_);
  ASSERT_TRUE(read.ok()) << read.error().text();
  ASSERT_EQ(read->tiles().size(), built_->tiles().size());
  for (std::size_t i = 0; i < read->tiles().size(); ++i) {
    const TerrainMesh &a = built_->tiles()[i], &b = read->tiles()[i];
    EXPECT_EQ(a.origin_m, b.origin_m);
    EXPECT_EQ(a.positions_m, b.positions_m);
    EXPECT_EQ(a.normals, b.normals);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.error_m, b.error_m);
    EXPECT_EQ(a.nodes.size(), b.nodes.size());
    EXPECT_EQ(a.cuts.size(), b.cuts.size());
    EXPECT_EQ(a.hollows.size(), b.hollows.size());
  }
  EXPECT_EQ(read->report().clearance_min_m, built_->report().clearance_min_m);
  EXPECT_EQ(read->report().triangles, built_->report().triangles);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(-100, 500), y(-100, 250), z(95, 120);
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec3 p(x(random), y(random), z(random));
    EXPECT_EQ(read->height_m(p), built_->height_m(p));
    EXPECT_EQ(read->normal(glm::dvec2(p)), built_->normal(glm::dvec2(p)));
  }
}

TEST_F(TerrainFile, RefusesWhatIsNotItsOwn) {
  EXPECT_EQ(read_terrain_file(path_, key_).error().code, ErrorCode::kIo);
  ASSERT_TRUE(write_terrain_file(*built_, key_, path_).ok());
  EXPECT_EQ(read_terrain_file(path_, key_ + 1).error().code, ErrorCode::kData);
  EXPECT_FALSE(write_terrain_file(*built_, key_, folder_.path("none/net.ground")).ok());
  const std::string whole = test::text_of(path_);
  for (const std::size_t size : {std::size_t{0}, std::size_t{7}, std::size_t{24}, whole.size() / 2, whole.size() - 1}) {
    folder_.put("net.ground", whole.substr(0, size));
    EXPECT_EQ(read_terrain_file(path_, key_).error().code, ErrorCode::kData) << size;
  }
  // Any one bit.
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    std::string damaged = whole;
    damaged[random() % damaged.size()] ^= static_cast<char>(1 << random() % 8);
    folder_.put("net.ground", damaged);
    EXPECT_EQ(read_terrain_file(path_, key_).error().code, ErrorCode::kData);
  }
}

TEST_F(TerrainFile, KeysTellWhatTheGroundDependsOn) {
  EXPECT_EQ(terrain_key("the network", &*elevation_, options_), key_);
  EXPECT_NE(terrain_key("the Network", &*elevation_, options_), key_);
  EXPECT_NE(terrain_key("the network", nullptr, options_), key_);
  TerrainOptions other = options_;
  other.levelling.cover_m += 1e-9;
  EXPECT_NE(terrain_key("the network", &*elevation_, other), key_);
  const auto taller = [](double x, double) { return x > 0 ? 100.25 : 100; };
  const auto elsewhere =
      Elevation::open(testing::write_ascii_grid(folder_.path("b.asc"), {-200, -200}, 5, 141, 121, taller));
  ASSERT_TRUE(elsewhere.ok());
  EXPECT_NE(terrain_key("the network", &*elsewhere, options_), key_);
}

}  // namespace
}  // namespace roadgen
