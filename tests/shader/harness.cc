#include "tests/shader/harness.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <memory>
#include <ostream>

#include "roadgen/render/gl.h"
#include "roadgen/render/program.h"

namespace roadgen::test {
namespace {

constexpr int kGroupSize = 64;

std::string compute_shader(const std::vector<std::string>& files, const std::string& body, int inputs, int outputs) {
  std::string text;
  for (const std::string& file : files) text += "#include \"" + file + "\"\n";
  const std::string in = std::to_string(inputs), out = std::to_string(outputs);
  text += "layout(local_size_x = " + std::to_string(kGroupSize) +
          ") in;\n"
          "layout(std430, binding = 0) readonly buffer Inputs { float inputs[]; };\n"
          "layout(std430, binding = 1) writeonly buffer Outputs { float outputs[]; };\n"
          "uniform uint rows;\n"
          "void evaluate_row(in float x[" +
          in + "], out float y[" + out + "]) {\n" + body +
          "\n}\n"
          "void main() {\n"
          "  uint row = gl_GlobalInvocationID.x;\n"
          "  if (row >= rows) return;\n"
          "  float x[" +
          in +
          "];\n"
          "  float y[" +
          out +
          "];\n"
          "  for (uint i = 0u; i < " +
          in + "u; ++i) x[i] = inputs[row * " + in +
          "u + i];\n"
          "  evaluate_row(x, y);\n"
          "  for (uint i = 0u; i < " +
          out + "u; ++i) outputs[row * " + out +
          "u + i] = y[i];\n"
          "}\n";
  return text;
}

// The greatest errors so far and the input of the worst.
struct Worst {
  double error = 0;
  double ulp = 0;
  std::string inputs;
};

void compare_row(const FunctionCase& function, const float* x, const float* y, Worst& worst) {
  const ShaderBody& body = function.body;
  std::vector<double> exact_x(x, x + body.inputs), exact_y(static_cast<size_t>(body.outputs));
  std::vector<Float32> single_x(x, x + body.inputs), single_y(static_cast<size_t>(body.outputs), Float32(0.0));
  body.exact(exact_x.data(), exact_y.data());
  body.single(single_x.data(), single_y.data());
  for (size_t i = 0; i < exact_y.size(); ++i) {
    ASSERT_TRUE(std::isfinite(y[i])) << function.name << ": output " << i << " is not finite";
    const double scale = std::max(1.0, std::abs(exact_y[i]));
    const double error = std::abs(y[i] - exact_y[i]) / scale;
    worst.ulp = std::max(worst.ulp, std::abs(y[i] - static_cast<double>(single_y[i])) / scale * 0x1p23);
    if (!(error > worst.error)) continue;
    worst.error = error;
    worst.inputs.clear();
    for (int k = 0; k < body.inputs; ++k) worst.inputs += (k ? ", " : "") + std::to_string(x[k]);
  }
}

}  // namespace

Result<std::vector<float>> evaluate(const std::vector<std::string>& files, const std::string& body,
                                    std::span<const float> x, int inputs, int outputs) {
  assert(!x.empty() && x.size() % static_cast<size_t>(inputs) == 0);
  Result<Program> program = Program::compute_from_text("harness.comp", compute_shader(files, body, inputs, outputs));
  if (!program) return program.error();
  const size_t rows = x.size() / static_cast<size_t>(inputs);
  std::vector<float> y(rows * static_cast<size_t>(outputs));
  const auto y_bytes = static_cast<GLsizeiptr>(y.size() * sizeof(float));
  const gl::Buffer input = gl::Buffer::with_data(static_cast<GLsizeiptr>(x.size_bytes()), x.data());
  const gl::Buffer output = gl::Buffer::with_data(y_bytes, nullptr);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, input.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, output.id());
  program->set("rows", static_cast<unsigned>(rows));
  program->use();
  glDispatchCompute(static_cast<GLuint>((rows + kGroupSize - 1) / kGroupSize), 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(output.id(), 0, y_bytes, y.data());
  glUseProgram(0);
  return y;
}

// splitmix64: short, and its numbers do not depend on the standard library.
double Random::uniform(double low, double high) {
  state_ += 0x9e3779b97f4a7c15u;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return low + (high - low) * (static_cast<double>(z >> 11) * 0x1p-53);
}

void PrintTo(const FunctionCase& function, std::ostream* out) { *out << function.name; }

std::function<void(Random&, double* x)> uniform_inputs(std::vector<InputRange> ranges) {
  return [ranges = std::move(ranges)](Random& random, double* x) {
    for (const InputRange& range : ranges) *x++ = random.uniform(range.low, range.high);
  };
}

void check_case(const std::vector<std::string>& files, const FunctionCase& function, int rows) {
  const auto inputs = static_cast<size_t>(function.body.inputs), outputs = static_cast<size_t>(function.body.outputs);
  Random random(1);
  std::vector<double> row(inputs);
  std::vector<float> x;
  for (int i = 0; i < rows; ++i) {
    function.sample(random, row.data());
    for (const double value : row) x.push_back(static_cast<float>(value));
  }
  const Result<std::vector<float>> y =
      evaluate(files, function.body.glsl, x, function.body.inputs, function.body.outputs);
  ASSERT_TRUE(y.ok()) << y.error().text();

  Worst worst;
  for (size_t i = 0; i < static_cast<size_t>(rows); ++i) {
    compare_row(function, &x[i * inputs], &(*y)[i * outputs], worst);
    if (::testing::Test::HasFatalFailure()) return;
  }
  std::printf("%-24s error %.2e (limit %.2e), against Float32 %.2f ulp (limit %.0f)\n", function.name, worst.error,
              function.limit, worst.ulp, function.limit_ulp);
  EXPECT_LE(worst.error, function.limit) << function.name << "(" << worst.inputs << ")";
  if (Context::current()->is_software()) {
    EXPECT_LE(worst.ulp, function.limit_ulp) << function.name;
  }
}

}  // namespace roadgen::test
