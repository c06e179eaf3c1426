// A line that shows how far long work has come, where a terminal is there to show it.
#pragma once

#include <chrono>
#include <string>

namespace roadgen::cli {

class Progress {
 public:
  explicit Progress(std::string what) : what_(std::move(what)) {}
  ~Progress() { done(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // fraction in [0, 1]. Writes to stderr at most ten times a second, and only to a terminal.
  void show(double fraction);
  // Removes the line.
  void done();

 private:
  std::string what_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_{};
  bool shown_ = false;
};

}  // namespace roadgen::cli
