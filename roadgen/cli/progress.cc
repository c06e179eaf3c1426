#include "roadgen/cli/progress.h"

#include <unistd.h>

#include <cstdio>

namespace roadgen::cli {

void Progress::show(double fraction) {
  static const bool terminal = isatty(STDERR_FILENO) == 1;
  const auto now = std::chrono::steady_clock::now();
  if (!terminal || now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  shown_ = true;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  std::fprintf(stderr, "\r\033[K%s: %3.0f %%, %.0f s", what_.c_str(), 100 * fraction, seconds);
}

void Progress::done() {
  if (shown_) std::fputs("\r\033[K", stderr);
  shown_ = false;
}

}  // namespace roadgen::cli
