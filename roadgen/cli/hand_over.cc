// The commands that draw and make meshes stand in a program of their own beside this one, `roadgen-draw`: the libraries
// for OpenGL, pictures and polygons take 150 MB and 0.2 s to load, more than the other commands need for a town. So does
// the import that reads an elevation file.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "roadgen/cli/import_command.h"

namespace roadgen::cli {
namespace {

// Returns only where it cannot be run.
int hand_over(const char* command, const Arguments& arguments) {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (own.parent_path() / "roadgen-draw").string();
  std::vector<std::string> words = {"roadgen", command};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  ::execv(program.c_str(), pointers.data());
  return fail(
      std::string("roadgen ") + command,
      {ErrorCode::kIo, "cannot be run: " + std::string(std::strerror(errno)) + "; it belongs beside roadgen", program});
}

}  // namespace

int run_import(const Arguments& arguments) {
  const auto is_heights = [](const std::string& word) { return word == "--heights" || word.starts_with("--heights="); };
  const bool needs_raster = std::any_of(arguments.begin(), arguments.end(), is_heights);
  return needs_raster ? hand_over("import", arguments) : import_command(arguments, nullptr);
}
int run_export(const Arguments& arguments) { return hand_over("export", arguments); }
int run_terrain(const Arguments& arguments) { return hand_over("terrain", arguments); }
int run_render(const Arguments& arguments) { return hand_over("render", arguments); }
int run_fly(const Arguments& arguments) { return hand_over("fly", arguments); }

}  // namespace roadgen::cli
