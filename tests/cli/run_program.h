// Runs a program and keeps what it says.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "tests/temporary_folder.h"

namespace roadgen::test {

struct Outcome {
  int code = -1;  // exit code, or -1 where it did not end by itself
  std::string out, err;

  std::vector<std::string> error_lines() const {
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < err.size();) {
      const std::size_t end = std::min(err.find('\n', at), err.size());
      lines.push_back(err.substr(at, end - at));
      at = end + 1;
    }
    return lines;
  }
};

// input: what the program reads from standard input.
inline Outcome run(const std::string& program, std::vector<std::string> arguments, std::string_view input = {}) {
  const TemporaryFolder folder;
  const std::string in = folder.put("in", input), out = folder.path("out"), err = folder.path("err");
  arguments.insert(arguments.begin(), program);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);

  const pid_t child = ::fork();
  if (child == 0) {
    const bool redirected =
        ::freopen(in.c_str(), "r", stdin) && ::freopen(out.c_str(), "w", stdout) && ::freopen(err.c_str(), "w", stderr);
    if (redirected) ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(out), text_of(err)};
}

// The program roadgen that was just built.
inline Outcome roadgen(std::vector<std::string> arguments, std::string_view input = {}) {
  return run(ROADGEN_PROGRAM, std::move(arguments), input);
}

}  // namespace roadgen::test
