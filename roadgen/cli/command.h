// What the subcommands of `roadgen` share: arguments, exit codes, messages and progress on stderr.
//
// Each subcommand is one function in one file; main.cc holds the table of them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roadgen/road/result.h"

namespace CLI {
class App;
}

namespace roadgen::cli {

using Arguments = std::vector<std::string>;  // without the program's and the subcommand's name

inline constexpr int kExitDone = 0, kExitData = 1, kExitUsage = 2;

// Parses the arguments. Returns the exit code where the command ends here: help was asked for (printed on
// stdout), or the arguments are wrong (one line on stderr); else nothing.
std::optional<int> parse(CLI::App& app, Arguments arguments);

// One line on stderr, "COMMAND: error: FILE:LINE: ELEMENT: MESSAGE"; returns the exit code for the error.
int fail(const std::string& command, const Error& error);

// Diagnostics on stderr: all of them where they are few, else the first ones and counts. more says where all
// stand.
void print_diagnostics(const Diagnostics& diagnostics, const std::string& more);

// JSON or other machine output: to stdout where path is empty or "-", else whole or not at all to the file.
Status put_out(const std::string& text, const std::string& path);

// A line on stderr that tells how far the work is; nothing where stderr is not a terminal. Clears itself.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void show(double part, const std::string& what);
  void clear();

 private:
  bool terminal_;
  bool shown_ = false;
};

// The subcommands. Each returns the exit code.
int run_import(const Arguments& arguments);
int run_info(const Arguments& arguments);
int run_check(const Arguments& arguments);
int run_query(const Arguments& arguments);
int run_render(const Arguments& arguments);
int run_fly(const Arguments& arguments);
int run_export(const Arguments& arguments);
int run_terrain(const Arguments& arguments);

}  // namespace roadgen::cli
