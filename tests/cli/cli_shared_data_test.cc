// Public centre lines of real circuits and roads: each is imported to its stated error and passes the check.
// The files stand beside the project, not in it; see data sources in README.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace {

using nlohmann::json;
using roadgen::test::Outcome;
namespace fs = std::filesystem;

const fs::path kData = fs::path(ROADGEN_SOURCE_DIR) / "../shared/data/road-geo";

struct Case {
  const char* file;
  bool closed;
  double allowed_error_m;
  std::size_t repairs;  // diagnostics of cleaning, at least
};

void PrintTo(const Case& c, std::ostream* stream) { *stream << c.file; }

class SharedData : public testing::TestWithParam<Case> {};

TEST_P(SharedData, IsImportedToItsErrorAndPassesTheCheck) {
  const Case& c = GetParam();
  const fs::path source = kData / c.file;
  if (!fs::exists(source)) GTEST_SKIP() << "no " << source << ": the public road data is not here";
  const roadgen::test::TemporaryFolder folder;
  const std::string net = folder.path("net.xodr");
  const Outcome run = roadgen::test::roadgen({"import", source, "-o", net, "--report", "-"});
  ASSERT_EQ(run.code, 0) << run.err;

  const json report = json::parse(run.out);
  ASSERT_EQ(report["roads"].size(), 1u);
  const json road = report["roads"][0];
  EXPECT_EQ(road["closed"], c.closed);
  EXPECT_EQ(road["allowed_error_m"], c.allowed_error_m);
  EXPECT_LE(road["max_error_m"], c.allowed_error_m);
  EXPECT_LE(road["rms_error_m"], road["max_error_m"]);
  EXPECT_LT(road["bound_m"], 1.01 * c.allowed_error_m);
  EXPECT_LT(road["max_heading_jump_rad"], 1e-9);
  EXPECT_GE(report["diagnostics"].size(), c.repairs);

  // The centre line misses little of the officially measured length, where the file states it.
  if (source.extension() == ".geojson") {
    std::ifstream stream(source);
    const double published_m = json::parse(stream)["features"][0]["properties"]["length"];
    EXPECT_NEAR(road["length_m"], published_m, 0.01 * published_m);
  }

  const Outcome check = roadgen::test::roadgen({"check", net});
  EXPECT_EQ(check.code, 0) << check.err;
  EXPECT_EQ(json::parse(check.out)["ok"], true);
}

INSTANTIATE_TEST_SUITE_P(
    Roads, SharedData,
    testing::Values(
        Case{"f1-circuits/be-1925.geojson", true, 0.1, 1}, Case{"f1-circuits/br-1940.geojson", true, 0.1, 1},
        Case{"f1-circuits/de-1927.geojson", true, 0.1, 2}, Case{"f1-circuits/it-1922.geojson", true, 0.1, 1},
        Case{"f1-circuits/mc-1929.geojson", true, 0.1, 1}, Case{"f1-circuits/us-2012.geojson", true, 0.1, 1},
        Case{"track_data/circuit-de-monaco-3f4a6324.csv", true, 0.1, 2},
        Case{"track_data/kimicircuit-4c9f0cef.csv", true, 0.1, 1},
        Case{"track_data/kimicircuit-99c46a6f.csv", true, 0.1, 1},
        Case{"track_data/pikes-peak-international-hill-climb-3222aa41.csv", false, 0.1, 1},
        Case{"track_data/schleizer-dreieck-23cd2402.csv", true, 0.1, 0}, Case{"gpx/gpxpy_Mojstrovka.gpx", false, 3, 2},
        Case{"gpx/gpxpy_around-visnjan-with-car.gpx", false, 3, 0}));

}  // namespace
