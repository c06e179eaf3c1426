// The commands that draw and make meshes stand in a program of their own beside this one, `roadgen-draw`: the libraries
// for OpenGL, pictures and polygons take 150 MB and 0.2 s to load, more than the other commands need for a town.
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "roadgen/cli/command.h"

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

int run_export(const Arguments& arguments) { return hand_over("export", arguments); }
int run_terrain(const Arguments& arguments) { return hand_over("terrain", arguments); }
int run_render(const Arguments& arguments) { return hand_over("render", arguments); }
int run_fly(const Arguments& arguments) { return hand_over("fly", arguments); }

}  // namespace roadgen::cli
