// Junctions and structures through the file: the town of the demo, drawn from its OpenDRIVE file, is the same picture
// as the town in memory; info counts them, check finds nothing wrong. And other programs' maps, where they are at hand.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace {

using nlohmann::json;
using roadgen::test::Outcome;
using roadgen::test::roadgen;
using roadgen::test::TemporaryFolder;
namespace fs = std::filesystem;

TEST(Town, ThroughTheFileIsTheSamePictureBitForBit) {
  const TemporaryFolder folder;
  const std::string prefix = folder.path("town"), net = prefix + ".xodr";
  const Outcome town = ::roadgen::test::run(TOWN_PROGRAM, {prefix});
  ASSERT_EQ(town.code, 0) << town.err;

  const json info = json::parse(roadgen({"info", net}).out);
  EXPECT_EQ(info["junctions"], 1);
  EXPECT_EQ(info["junction_areas"], 1);
  EXPECT_EQ(info["structures"]["tunnels"], 1);
  EXPECT_EQ(info["structures"]["guard_rails"], 1);
  EXPECT_EQ(info["structures"]["cables"], 1);
  EXPECT_EQ(info["structures"]["pipes"], 0);
  // The cable's poles stand 7.3 m above a road that climbs to 6.4 m.
  EXPECT_GT(info["bounds"]["high_m"][2], 10);
  const Outcome check = roadgen({"check", net});
  EXPECT_EQ(check.code, 0) << check.err;

  // The cameras of demo/town/main.cc.
  const char* views[][2] = {{"crossing", "-45,-40,22,45,-25,0"}, {"tunnel", "21,-110,0,100,2,0"}};
  for (const auto& [name, camera] : views) {
    const Outcome drawn =
        roadgen({"render", net, "--camera", camera, "--fov", "60", "--size", "960x600", "-o", folder.path(name)});
    ASSERT_EQ(drawn.code, 0) << drawn.err;
    const std::string in_memory = ::roadgen::test::text_of(prefix + "." + name + ".png");
    EXPECT_GT(in_memory.size(), 10000u);
    EXPECT_TRUE(::roadgen::test::text_of(folder.path(std::string(name) + ".color.png")) == in_memory) << name;
  }
}

struct Map {
  const char* file;
  int junctions, areas;
};
void PrintTo(const Map& map, std::ostream* stream) { *stream << map.file; }

class SharedMap : public testing::TestWithParam<Map> {};

TEST_P(SharedMap, CrossingsBecomeAreas) {
  const fs::path file = fs::path(ROADGEN_SOURCE_DIR) / "../shared/data/opendrive" / GetParam().file;
  if (!fs::exists(file)) GTEST_SKIP() << "no " << file << ": the public maps are not here";
  const Outcome run = roadgen({"info", file});
  ASSERT_EQ(run.code, 0) << run.err;
  const json info = json::parse(run.out);
  EXPECT_EQ(info["junctions"], GetParam().junctions);
  EXPECT_EQ(info["junction_areas"], GetParam().areas);
}

INSTANTIATE_TEST_SUITE_P(Maps, SharedMap,
                         testing::Values(Map{"carla/Town01.xodr", 12, 12}, Map{"carla/Town03.xodr", 34, 14},
                                         Map{"maliput/Crossing8Course.xodr", 1, 0}));

}  // namespace
