// roadgen render and fly: files and JSON of a good run; bad input is one line, the right exit code, and no output.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <nlohmann/json.hpp>

#include "tests/cli/run_program.h"

namespace {

using nlohmann::json;
using roadgen::test::Outcome;
using roadgen::test::TemporaryFolder;

const std::string kData = std::string(ROADGEN_SOURCE_DIR) + "/data/";

class Render : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const Outcome run = roadgen::test::roadgen({"import", kData + "pass.csv", "-o", folder_->path("net.xodr")});
    ASSERT_EQ(run.code, 0) << run.err;
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string net() { return folder_->path("net.xodr"); }

  // Runs the command, which must fail with `code`, say one line that holds `says`, and leave no file behind.
  static void expect_refused(std::vector<std::string> arguments, int code, const std::string& says) {
    const std::size_t before = folder_->count();
    const Outcome run = roadgen::test::roadgen(std::move(arguments));
    SCOPED_TRACE(run.err);
    EXPECT_EQ(run.code, code);
    EXPECT_EQ(run.out, "");
    // One line, but for warnings about what the input leaves open.
    const auto lines = run.error_lines();
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(), [](const std::string& l) { return l.find("warning: ") != 0; }),
              1);
    EXPECT_NE(run.err.find("error: "), std::string::npos);
    EXPECT_NE(run.err.find(says), std::string::npos);
    EXPECT_EQ(folder_->count(), before);
  }
  static std::vector<std::string> render(std::vector<std::string> more) {
    std::vector<std::string> all = {"render", net(), "--size", "64x48", "-o", folder_->path("p")};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  static TemporaryFolder* folder_;
};
TemporaryFolder* Render::folder_ = nullptr;

TEST_F(Render, WritesEveryChannelAndNamesThemInJson) {
  const TemporaryFolder out;
  const Outcome run =
      roadgen::test::roadgen({"render", net(), "--dem", kData + "pass_dem.tif", "--follow", "1,300,-1.75,1.3", "--size",
                              "160x90", "--channels", "color,depth,label,instance,normal,road", "-o", out.path("p")});
  ASSERT_EQ(run.code, 0) << run.err;
  const json report = json::parse(run.out);
  for (const char* channel : {"color", "depth", "label", "instance", "normal", "road"}) {
    ASSERT_TRUE(report["files"].contains(channel)) << channel;
    EXPECT_GT(std::filesystem::file_size(report["files"][channel].get<std::string>()), 100u) << channel;
  }
  EXPECT_EQ(out.count(), 6u);
}

TEST_F(Render, FliesIntoAFolderAndAVideo) {
  const TemporaryFolder out;
  const Outcome pictures = roadgen::test::roadgen({"fly", net(), "--frames", "12", "--size", "96x54", "-o",
                                                   out.path("frames"), "--contact-sheet", out.path("sheet.png")});
  ASSERT_EQ(pictures.code, 0) << pictures.err;
  EXPECT_TRUE(std::filesystem::exists(out.path("frames/00011.png")));
  EXPECT_TRUE(std::filesystem::exists(out.path("sheet.png")));
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg: the video was not tested";
  const Outcome video =
      roadgen::test::roadgen({"fly", net(), "--frames", "5", "--size", "97x53", "-o", out.path("f.mp4")});
  ASSERT_EQ(video.code, 0) << video.err;
  EXPECT_GT(std::filesystem::file_size(out.path("f.mp4")), 500u);
  EXPECT_EQ(out.count(), 3u);  // no temporary is left
}

TEST_F(Render, RefusesWrongUsage) {
  expect_refused(render({}), 2, "--camera");
  expect_refused(render({"--camera", "1,2,3"}), 2, "6 numbers");
  expect_refused(render({"--camera", "1,2,3,nan,0,0"}), 2, "6 numbers");
  expect_refused(render({"--follow", "9,0,0,1"}), 2, "no road '9'");
  expect_refused(render({"--follow", "1,x,0,1"}), 2, "3 numbers");
  expect_refused(render({"--follow", "1,0,0,1", "--channels", "colour"}), 2, "'colour'");
  expect_refused(render({"--follow", "1,0,0,1", "--fov", "190"}), 2, "field of view");
  expect_refused(render({"--follow", "1,0,0,1", "--context", "glx"}), 2, "glx");
  expect_refused({"render", net(), "--size", "0x5", "--follow", "1,0,0,1", "-o", folder_->path("p")}, 2, "--size");
  expect_refused({"fly", net(), "--frames", "0", "-o", folder_->path("v.mp4")}, 2, "--frames");
  expect_refused({"fly", net()}, 2, "-o");
}

TEST_F(Render, RefusesBadFiles) {
  expect_refused({"render", folder_->path("none.xodr"), "--follow", "1,0,0,1", "-o", folder_->path("p")}, 1,
                 "none.xodr");
  expect_refused(render({"--follow", "1,0,0,1", "--dem", folder_->path("none.tif")}), 1, "none.tif");
  expect_refused(render({"--follow", "1,0,0,1", "--dem", net()}), 1, "net.xodr");
  expect_refused({"render", net(), "--follow", "1,0,0,1", "-o", "/no/such/folder/p"}, 1, "/no/such/folder");
  expect_refused({"fly", net(), "--frames", "2", "-o", "/no/such/folder/v.mp4"}, 1, "/no/such/folder");
}

TEST_F(Render, ADemElsewhereIsRefusedWithBothExtents) {
  const TemporaryFolder other;
  std::string grid = "ncols 4\nnrows 4\nxllcorner 10\nyllcorner 50\ncellsize 0.01\nNODATA_value -9999\n";
  for (int row = 0; row < 4; ++row) grid += "100 100 100 100\n";
  expect_refused(render({"--follow", "1,0,0,1", "--dem", other.put("elsewhere.asc", grid)}), 1, "elsewhere.asc");
}

TEST_F(Render, NoContextIsOneLineThatSaysWhatToDo) {
  ASSERT_EQ(::unsetenv("DISPLAY"), 0);
  ::unsetenv("WAYLAND_DISPLAY");
  expect_refused(render({"--follow", "1,0,0,1", "--context", "window"}), 1, "osmesa");
}

}  // namespace
