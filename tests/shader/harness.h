// Runs functions of shaders/lib on the GPU, over many inputs at once, and compares them with their C++ twins.
//
// A case states the same few lines once, and they are compiled three times: as GLSL, over Library<double> (the truth)
// and over Library<Float32> (what single precision should give):
//
//   #define float Real
//   SHADER_CASE(RoadV, 5, 1, y[0] = road_v(x[0], x[1], x[2], x[3], x[4]);)
//   #undef float
//
// x holds the inputs, y the outputs; the rules of shaders/lib/glsl.h hold (float(0.5), no swizzles), so vec2 and vec3,
// GLSL's own functions and local variables may be used.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "roadgen/road/result.h"
#include "shaders/lib/glsl.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen::test {

using glsl::Float32;

// Runs `body`, GLSL statements over `float x[inputs]` and `float y[outputs]`, once per input row, by a compute shader
// that includes the named files of shaders/. Returns the rows of outputs. Requires: a current context; up to 4e6 rows.
// Errors: kShader.
Result<std::vector<float>> evaluate(const std::vector<std::string>& files, const std::string& body,
                                    std::span<const float> x, int inputs, int outputs);

// Uniform random numbers, the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);

 private:
  std::uint64_t state_;
};

// The three versions of a case's statements.
struct ShaderBody {
  int inputs;
  int outputs;
  const char* glsl;
  void (*exact)(const double* x, double* y);
  void (*single)(const Float32* x, Float32* y);
};

struct FunctionCase {
  const char* name;
  ShaderBody body;
  // Fills one row of inputs; they are rounded to float before anything is evaluated.
  std::function<void(Random&, double* x)> sample;
  // Greatest allowed |GPU - exact| / max(1, |exact|) of any output.
  double limit;
  // Greatest allowed |GPU - Library<Float32>|, in units of 2^-23 max(1, |exact|); asserted of software renderers, which
  // round every operation as Float32 does, though not in their order of equal terms. GPUs fuse operations.
  double limit_ulp = 4;
};
// For gtest's lists of tests.
void PrintTo(const FunctionCase& function, std::ostream* out);

// Sampler of independent inputs, each uniform in its range.
struct InputRange {
  double low, high;
};
std::function<void(Random&, double* x)> uniform_inputs(std::vector<InputRange> ranges);

// Evaluates the case over `rows` random rows in the current context, asserts its limits and prints what was measured.
void check_case(const std::vector<std::string>& files, const FunctionCase& function, int rows);

}  // namespace roadgen::test

#define SHADER_CASE(name, input_count, output_count, ...)                                               \
  struct name##Exact : ::roadgen::glsl::Library<double> {                                               \
    using Real = double;                                                                                \
    static void run(const Real* x, Real* y) {                                                           \
      using namespace ::roadgen::glsl;                                                                  \
      __VA_ARGS__                                                                                       \
    }                                                                                                   \
  };                                                                                                    \
  struct name##Single : ::roadgen::glsl::Library<::roadgen::glsl::Float32> {                            \
    using Real = ::roadgen::glsl::Float32;                                                              \
    static void run(const Real* x, Real* y) {                                                           \
      using namespace ::roadgen::glsl;                                                                  \
      __VA_ARGS__                                                                                       \
    }                                                                                                   \
  };                                                                                                    \
  constexpr ::roadgen::test::ShaderBody name{input_count, output_count, #__VA_ARGS__, name##Exact::run, \
                                             name##Single::run};
