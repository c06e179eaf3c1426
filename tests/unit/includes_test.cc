// The order of the modules, read off the #include lines: arrows run downward only; OpenGL and other
// third-party headers stay where DESIGN puts them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Names = std::set<std::string>;

// Folder -> folders whose headers it may use, itself aside.
const std::map<std::string, Names>& allowed() {
  static const Names network = {"shaders", "roadgen/road"};
  static const auto with = [](Names names, std::initializer_list<const char*> more) {
    names.insert(more.begin(), more.end());
    return names;
  };
  static const Names files = with(network, {"roadgen/fit", "roadgen/geodesy"});
  static const Names scene = with(network, {"roadgen/query", "roadgen/object", "terrain"});
  static const Names all = with(
      scene, {"roadgen/fit", "roadgen/geodesy", "roadgen/import", "roadgen/export", "roadgen/render", "roadgen/pick"});
  static const std::map<std::string, Names> table = {
      {"shaders", {}},
      {"roadgen/road", {"shaders"}},
      {"roadgen/geodesy", network},
      {"roadgen/fit", network},
      {"roadgen/import", with(files, {"roadgen/export", "roadgen/object"})},
      {"roadgen/export", files},
      {"roadgen/query", network},
      {"roadgen/object", network},
      {"terrain", with(network, {"roadgen/query", "roadgen/geodesy"})},
      {"roadgen/render", with(network, {"roadgen/query", "roadgen/object", "terrain"})},
      {"roadgen/pick", with(scene, {"roadgen/render"})},
      {"roadgen/capi", all},
      {"roadgen/cli", with(all, {"roadgen/capi"})},
      {"roadgen/python", with(all, {"roadgen/capi"})},
  };
  return table;
}

struct Include {
  std::string file, folder, header;
  bool quoted = false, in_header = false;
};

std::string folder_of(const std::string& path) {
  std::string longest;
  for (const auto& [folder, uses] : allowed()) {
    if (path.starts_with(folder + "/") && folder.size() > longest.size()) longest = folder;
  }
  return longest;
}

std::vector<Include> includes() {
  static const std::regex pattern(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  const fs::path root = ROADGEN_SOURCE_DIR;
  std::vector<Include> found;
  for (const char* top : {"shaders", "roadgen", "terrain", "demo"}) {
    if (!fs::exists(root / top)) continue;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string ending = entry.path().extension().string();
      if (ending != ".h" && ending != ".cc" && ending != ".c") continue;
      const std::string file = fs::relative(entry.path(), root).generic_string();
      std::ifstream stream(entry.path());
      std::smatch match;
      for (std::string line; std::getline(stream, line);) {
        if (!std::regex_search(line, match, pattern)) continue;
        found.push_back({file, folder_of(file), match[2], match[1] == "\"", ending == ".h"});
      }
    }
  }
  return found;
}

bool is_of(const std::string& header, std::initializer_list<const char*> prefixes) {
  return std::any_of(prefixes.begin(), prefixes.end(), [&](const char* p) { return header.starts_with(p); });
}

TEST(Includes, ArrowsRunDownwardOnly) {
  const std::vector<Include> all = includes();
  ASSERT_GT(all.size(), 20u);
  for (const Include& include : all) {
    const std::string to = folder_of(include.header);
    if (to.empty() || include.folder.empty() || to == include.folder) continue;
    EXPECT_TRUE(allowed().at(include.folder).contains(to)) << include.file << " includes " << include.header;
  }
}

TEST(Includes, OurOwnHeadersAreQuotedFromTheRoot) {
  for (const Include& include : includes()) {
    if (include.folder.empty()) continue;  // the demo uses the installed tree
    const bool is_ours = fs::exists(fs::path(ROADGEN_SOURCE_DIR) / include.header);
    EXPECT_EQ(include.quoted, is_ours) << include.file << ": " << include.header;
  }
}

TEST(Includes, OpenGlStaysInRenderPickAndDemo) {
  for (const Include& include : includes()) {
    if (!is_of(include.header, {"GL/", "GLES", "glad/", "EGL/", "GLFW/", "KHR/", "epoxy/"})) continue;
    EXPECT_TRUE(is_of(include.file, {"roadgen/render/", "roadgen/pick/", "demo/"}))
        << include.file << ": " << include.header;
  }
}

TEST(Includes, NoHeaderShowsThirdPartyTypes) {
  for (const Include& include : includes()) {
    if (!include.in_header || include.folder.empty()) continue;
    EXPECT_FALSE(is_of(include.header,
                       {"ceres/", "Eigen/", "gdal", "ogr", "cpl_", "OpenImageIO/", "GeographicLib/", "proj.h",
                        "embree3/", "pugixml", "osmium/", "nlohmann/", "CLI/", "geos", "tbb/", "spdlog/", "fmt/"}))
        << include.file << ": " << include.header;
  }
}

TEST(Includes, FileReadersStayInTheirModules) {
  for (const Include& include : includes()) {
    const auto only_in = [&](std::initializer_list<const char*> prefixes, std::initializer_list<const char*> folders) {
      EXPECT_TRUE(!is_of(include.header, prefixes) || is_of(include.file, folders))
          << include.file << ": " << include.header;
    };
    only_in({"ceres/"}, {"roadgen/fit/"});
    only_in({"gdal", "ogr", "cpl_"}, {"roadgen/import/", "roadgen/export/", "terrain/"});
    only_in({"GeographicLib/", "proj.h"}, {"roadgen/geodesy/"});
    only_in({"pugixml", "osmium/"}, {"roadgen/import/"});
    only_in({"geos_c.h"}, {"roadgen/export/"});
    only_in({"OpenImageIO/"}, {"roadgen/render/", "demo/"});
    only_in({"embree3/"}, {"roadgen/object/"});
    only_in({"CLI/"}, {"roadgen/cli/", "demo/"});
  }
}

}  // namespace
