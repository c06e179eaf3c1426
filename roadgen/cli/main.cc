// The program `roadgen`: picks the subcommand.
#include <cstdio>
#include <exception>
#include <string_view>

#include "roadgen/cli/command.h"

namespace {

using roadgen::cli::Arguments;

struct Command {
  const char* name;
  const char* summary;
  int (*run)(const Arguments&);
};

constexpr Command kCommands[] = {
    {"import", "measured centre lines to an OpenDRIVE network", roadgen::cli::run_import},
    {"info", "what a network holds, as JSON", roadgen::cli::run_info},
    {"check", "whether a network is sound, as JSON", roadgen::cli::run_check},
    {"query", "world to road and road to world, as CSV", roadgen::cli::run_query},
    {"terrain", "the ground levelled along the roads, as GeoTIFF", roadgen::cli::run_terrain},
    {"export", "a network as mesh (glTF) or lines (GeoJSON)", roadgen::cli::run_export},
    {"render", "one camera's picture and data channels", roadgen::cli::run_render},
    {"fly", "a video along a road", roadgen::cli::run_fly},
};

void print_help(std::FILE* to) {
  std::fputs("Usage: roadgen COMMAND ...\n\nCommands:\n", to);
  for (const Command& command : kCommands) std::fprintf(to, "  %-10s %s\n", command.name, command.summary);
  std::fputs("\nroadgen COMMAND --help tells more. Exit code: 0 done, 1 error in the data, 2 wrong usage.\n", to);
}

int usage_error(const char* what, const char* name) {
  std::fprintf(stderr, "roadgen: error: %s%s; see roadgen --help\n", what, name);
  return roadgen::cli::kExitUsage;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return usage_error("no command given", "");
  const std::string_view name = argv[1];
  if (name == "--help" || name == "-h") {
    print_help(stdout);
    return roadgen::cli::kExitDone;
  }
  if (name == "--version") {
    std::puts("roadgen " ROADGEN_VERSION);
    return roadgen::cli::kExitDone;
  }
  for (const Command& command : kCommands) {
    if (name != command.name) continue;
    try {
      return command.run(Arguments(argv + 2, argv + argc));
    } catch (const std::exception& e) {  // out of memory, mostly
      std::fprintf(stderr, "roadgen %s: error: %s\n", command.name, e.what());
      return roadgen::cli::kExitData;
    }
  }
  return usage_error("no command ", argv[1]);
}
