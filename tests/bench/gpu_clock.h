// How long it takes to draw: on a GPU by timer query; where the CPU computes the pixels by wall clock up to glFinish, or
// by the time that all threads of the process spend, which other work on the machine does not lengthen.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <vector>

#include "roadgen/render/context.h"
#include "roadgen/render/gl.h"

namespace roadgen::bench {

enum class Clock { kWall, kProcess };

template <class Draw>
double milliseconds(const Context& context, Clock clock, const Draw& draw) {
  glFinish();
  if (context.is_software()) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t spent = std::clock();
    draw();
    glFinish();
    if (clock == Clock::kProcess) return 1e3 * static_cast<double>(std::clock() - spent) / CLOCKS_PER_SEC;
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  }
  const gl::Query query = gl::Query::create(GL_TIME_ELAPSED);
  glBeginQuery(GL_TIME_ELAPSED, query.id());
  draw();
  glEndQuery(GL_TIME_ELAPSED);
  GLuint64 nanoseconds = 0;
  glGetQueryObjectui64v(query.id(), GL_QUERY_RESULT, &nanoseconds);
  return static_cast<double>(nanoseconds) * 1e-6;
}

// Requires: a value at least.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace roadgen::bench
