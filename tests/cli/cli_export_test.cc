// roadgen export: a mesh and lines, and what it refuses.
#include <gtest/gtest.h>

#include <fstream>

#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace {

using nlohmann::json;
using roadgen::test::Outcome;
using roadgen::test::TemporaryFolder;

const std::string kData = std::string(ROADGEN_SOURCE_DIR) + "/data/";

TEST(Export, WritesMeshAndLines) {
  const TemporaryFolder folder;
  const std::string net = folder.path("net.xodr");
  ASSERT_EQ(roadgen::test::roadgen({"import", kData + "pass.csv", "-o", net}).code, 0);

  const Outcome mesh = roadgen::test::roadgen({"export", net, "-o", folder.path("net.glb"), "--max-error", "0.05"});
  ASSERT_EQ(mesh.code, 0) << mesh.err;
  EXPECT_GT(json::parse(mesh.out)["triangles"], 1000);
  EXPECT_LE(json::parse(mesh.out)["error_m"], 0.05);
  EXPECT_EQ(roadgen::test::text_of(folder.path("net.glb")).substr(0, 4), "glTF");

  const Outcome lines = roadgen::test::roadgen({"export", net, "-o", folder.path("net.geojson")});
  ASSERT_EQ(lines.code, 0) << lines.err;
  EXPECT_EQ(json::parse(roadgen::test::text_of(folder.path("net.geojson")))["type"], "FeatureCollection");
}

TEST(Export, RefusesInOneLineAndLeavesNothing) {
  const TemporaryFolder folder;
  const std::string net = folder.path("net.xodr"), plain = folder.path("plain.xodr"), csv = folder.path("plain.csv");
  ASSERT_EQ(roadgen::test::roadgen({"import", kData + "pass.csv", "-o", net}).code, 0);
  std::ofstream(csv) << "x,y\n0,0\n50,0\n100,10\n";
  ASSERT_EQ(roadgen::test::roadgen({"import", csv, "-o", plain}).code, 0);
  const std::size_t before = folder.count();
  struct Row {
    std::vector<std::string> arguments;
    int code;
    const char* says;
  };
  const Row rows[] = {{{net, "-o", folder.path("net.obj")}, 2, "must end in .glb or .geojson"},
                      {{net, "-o", folder.path("net.glb"), "--max-error", "0"}, 2, "from 0.0001 to 1 m"},
                      {{net, "-o", folder.path("net.geojson"), "--max-error", "nan"}, 2, "from 0.0001 to 1000 m"},
                      {{plain, "-o", folder.path("net.geojson")}, 1, "no georeference"},
                      {{folder.path("none.xodr"), "-o", folder.path("net.glb")}, 1, "none.xodr"},
                      {{net, "-o", folder.path("no/net.glb")}, 1, "no/net.glb"},
                      {{net}, 2, "--output is required"}};
  for (const Row& row : rows) {
    std::vector<std::string> arguments = {"export"};
    arguments.insert(arguments.end(), row.arguments.begin(), row.arguments.end());
    const Outcome run = roadgen::test::roadgen(arguments);
    EXPECT_EQ(run.code, row.code) << run.err;
    EXPECT_NE(run.err.find(row.says), std::string::npos) << run.err;
    EXPECT_EQ(run.error_lines().size(), 1u) << run.err;
    EXPECT_EQ(folder.count(), before);
  }
}

}  // namespace
