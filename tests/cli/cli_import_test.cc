// roadgen import, info and check on good input.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace {

using nlohmann::json;
using roadgen::test::Outcome;
using roadgen::test::TemporaryFolder;
using roadgen::test::text_of;

std::string number(double x) { return std::to_string(x); }

// A loop of about 1.9 km around 50 N 11 E, with dirt in it.
std::string loop_csv() {
  std::string text = "lat,lon,height,width\n";
  for (int i = 0; i < 120; ++i) {
    const double angle = 2 * 3.14159265358979 * i / 120;
    const double height = i == 40 ? 0 : i == 80 ? -32768 : 400 + 10 * std::sin(angle);
    text += number(50 + 0.0027 * std::sin(angle)) + "," + number(11 + 0.0042 * std::cos(angle)) + "," + number(height) +
            ",8\n";
  }
  return text;
}

TEST(Commands, HelpGoesToStandardOutput) {
  for (const std::vector<std::string>& line : std::vector<std::vector<std::string>>{
           {"--help"}, {"import", "--help"}, {"info", "--help"}, {"check", "--help"}, {"--version"}}) {
    const Outcome run = roadgen::test::roadgen(line);
    EXPECT_EQ(run.code, 0);
    EXPECT_EQ(run.err, "");
    EXPECT_GT(run.out.size(), 10u);
  }
}

TEST(Commands, ImportThenInfoThenCheck) {
  const TemporaryFolder folder;
  const std::string source = folder.put("loop.csv", loop_csv()), net = folder.path("net.xodr"),
                    report = folder.path("r.json");
  const Outcome run = roadgen::test::roadgen({"import", source, "-o", net, "--report", report});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.out, "");

  const json fit = json::parse(text_of(report));
  ASSERT_EQ(fit["roads"].size(), 1u);
  const json road = fit["roads"][0];
  for (const char* key : {"id", "closed", "length_m", "samples", "anchors", "segments", "max_error_m", "rms_error_m",
                          "bound_m", "max_heading_jump_rad", "max_curvature_jump_per_m"}) {
    EXPECT_TRUE(road.contains(key)) << key;
  }
  EXPECT_EQ(road["closed"], true);
  EXPECT_EQ(road["samples"], 120);
  EXPECT_LE(road["max_error_m"], 0.1);
  EXPECT_LE(road["max_error_m"], road["bound_m"]);
  ASSERT_EQ(fit["diagnostics"].size(), 2u);
  for (const json& diagnostic : fit["diagnostics"]) {
    for (const char* key : {"severity", "file", "line", "element", "message"})
      EXPECT_TRUE(diagnostic.contains(key)) << key;
  }
  EXPECT_EQ(fit["diagnostics"][0]["line"], 42);

  const Outcome info = roadgen::test::roadgen({"info", net});
  ASSERT_EQ(info.code, 0) << info.err;
  EXPECT_EQ(info.err, "");
  const json told = json::parse(info.out);
  EXPECT_EQ(told["roads"], 1);
  EXPECT_EQ(told["lanes"], 4);  // with the hard shoulders
  EXPECT_EQ(told["driving_lanes"], 2);
  EXPECT_EQ(told["junctions"], 0);
  EXPECT_EQ(told["segments"], road["segments"]);
  EXPECT_NEAR(told["length_m"], road["length_m"], 1e-6);
  EXPECT_NEAR(told["georeference"]["latitude_deg"], 50, 1e-5);

  const Outcome check = roadgen::test::roadgen({"check", net});
  ASSERT_EQ(check.code, 0) << check.err;
  const json checked = json::parse(check.out);
  for (const char* key :
       {"joints", "max_position_gap_m", "max_heading_gap_rad", "max_mapping_bound_m", "max_s_bound_m", "problems"}) {
    EXPECT_TRUE(checked.contains(key)) << key;
  }
  EXPECT_EQ(checked["ok"], true);
  EXPECT_EQ(checked["joints"], road["segments"]);
  EXPECT_EQ(folder.count(), 3u);
}

TEST(Commands, TheSameImportGivesTheSameFile) {
  const TemporaryFolder folder;
  const std::string source = folder.put("loop.csv", loop_csv());
  for (const char* name : {"a.xodr", "b.xodr"})
    ASSERT_EQ(roadgen::test::roadgen({"import", source, "-o", folder.path(name)}).code, 0);
  EXPECT_EQ(text_of(folder.path("a.xodr")), text_of(folder.path("b.xodr")));
}

TEST(Commands, ReportGoesToStandardOutputWhereAsked) {
  const TemporaryFolder folder;
  const std::string source = folder.put("loop.csv", loop_csv());
  const Outcome run = roadgen::test::roadgen({"import", source, "-o", folder.path("n.xodr"), "--report", "-"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(json::parse(run.out)["roads"].size(), 1u);
}

TEST(Commands, OptionsAreHonoured) {
  const TemporaryFolder folder;
  const std::string source = folder.put("loop.csv", loop_csv()), net = folder.path("n.xodr");
  const auto report = [&](std::vector<std::string> more) {
    std::vector<std::string> line = {"import", source, "-o", net, "--report", "-"};
    line.insert(line.end(), more.begin(), more.end());
    const Outcome run = roadgen::test::roadgen(line);
    EXPECT_EQ(run.code, 0) << run.err;
    return json::parse(run.out);
  };
  EXPECT_EQ(report({"--closed", "no"})["roads"][0]["closed"], false);
  EXPECT_EQ(report({"--origin", "-33.5,151.25,12"})["origin"]["latitude_deg"], -33.5);
  EXPECT_EQ(report({"--origin=49,10"})["origin"]["height_m"], 0);
  const json coarse = report({"--max-error", "2"})["roads"][0], fine = report({"--max-error", "0.02"})["roads"][0];
  EXPECT_LT(coarse["segments"], fine["segments"]);
  EXPECT_LE(fine["max_error_m"], 0.02);
  EXPECT_LE(report({"--tangents", "catmull-rom"})["roads"][0]["max_error_m"], 0.1);
  const json smooth = report({"--tangents", "curvature"})["roads"][0];
  EXPECT_LE(smooth["max_error_m"], 0.1);
  EXPECT_LT(smooth["max_curvature_jump_per_m"], 1e-9);
}

TEST(Commands, MetresHaveNoGeoreference) {
  const TemporaryFolder folder;
  const std::string a = folder.put("a.csv", "x,y\n0,0\n100,0\n200,10\n"),
                    b = folder.put("b.csv", "x,y,z\n0,50,1\n100,50,2\n200,60,3\n");
  ASSERT_EQ(roadgen::test::roadgen({"import", a, b, "-o", folder.path("n.xodr")}).code, 0);
  const json told = json::parse(roadgen::test::roadgen({"info", folder.path("n.xodr")}).out);
  EXPECT_TRUE(told["georeference"].is_null());
  EXPECT_EQ(told["roads"], 2);
  EXPECT_EQ(told["road_list"][1]["name"], "b");
}

TEST(Commands, CheckFindsAKinkAndSaysWhere) {
  const TemporaryFolder folder;
  const std::string net = folder.path("n.xodr");
  ASSERT_EQ(roadgen::test::roadgen({"import", folder.put("l.csv", loop_csv()), "-o", net}).code, 0);
  // The start of one geometry, moved.
  std::string text = text_of(net);
  const std::size_t at = text.find(" x=\"", text.find("<geometry", text.find("<geometry") + 1)) + 4;
  text.replace(at, text.find('"', at) - at, number(std::stod(text.substr(at)) + 0.5));
  const Outcome run = roadgen::test::roadgen({"check", folder.put("moved.xodr", text)});
  EXPECT_EQ(run.code, 1);
  EXPECT_EQ(json::parse(run.out)["ok"], false);
  EXPECT_FALSE(json::parse(run.out)["problems"].empty());
  EXPECT_NE(run.err.find("gap"), std::string::npos) << run.err;
}

}  // namespace
