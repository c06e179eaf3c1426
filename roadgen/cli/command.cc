#include "roadgen/cli/command.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>

#include "roadgen/export/atomic_file.h"

namespace roadgen::cli {
namespace {

constexpr std::size_t kMostDiagnostics = 12;

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

std::optional<int> parse(CLI::App& app, Arguments arguments) {
  try {
    std::reverse(arguments.begin(), arguments.end());  // CLI11 takes them from the back
    app.parse(arguments);
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return kExitDone;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "{}: error: {}; see {} --help\n", app.get_name(), one_line(error.what()), app.get_name());
    return kExitUsage;
  }
  return {};
}

int fail(const std::string& command, const Error& error) {
  fmt::print(stderr, "{}: error: {}\n", command, one_line(error.text()));
  return error.code == ErrorCode::kUsage ? kExitUsage : kExitData;
}

void print_diagnostics(const Diagnostics& diagnostics, const std::string& more) {
  const std::size_t shown = diagnostics.size() <= kMostDiagnostics ? diagnostics.size() : kMostDiagnostics - 2;
  for (std::size_t i = 0; i < shown; ++i) fmt::print(stderr, "{}\n", one_line(diagnostics[i].text()));
  if (shown == diagnostics.size()) return;
  const auto warnings = std::count_if(diagnostics.begin(), diagnostics.end(),
                                      [](const Diagnostic& d) { return d.severity != Severity::kInfo; });
  fmt::print(stderr, "... and {} more; {} findings in all, {} of them warnings{}\n", diagnostics.size() - shown,
             diagnostics.size(), warnings, more);
}

Status put_out(const std::string& text, const std::string& path) {
  if (!path.empty() && path != "-") return write_file(path, text);
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0) {
    return Error{ErrorCode::kIo, "standard output cannot be written"};
  }
  return Done{};
}

ProgressLine::ProgressLine() : terminal_(::isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::show(double part, const std::string& what) {
  if (!terminal_) return;
  fmt::print(stderr, "\r{:3.0f} % {}\033[K", 100 * part, one_line(what));
  std::fflush(stderr);
  shown_ = true;
}

void ProgressLine::clear() {
  if (shown_) fmt::print(stderr, "\r\033[K");
  shown_ = false;
}

}  // namespace roadgen::cli
