// Shader sources and programs: includes, errors that name file and line, overrides, uniforms.
#include "roadgen/render/program.h"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "roadgen/render/gl.h"
#include "shaders/embedded.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen::test {
namespace {

// A folder for shader files, named by ROADGEN_SHADER_DIR.
class ShaderTest : public GlTest {
 protected:
  ShaderTest() {
    folder_ = std::filesystem::temp_directory_path() / ("roadgen-shaders-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_ / "lib");
    setenv("ROADGEN_SHADER_DIR", folder_.c_str(), 1);
  }
  ~ShaderTest() override {
    unsetenv("ROADGEN_SHADER_DIR");
    std::filesystem::remove_all(folder_);
  }
  void put(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

  std::filesystem::path folder_;
};

// What a compute program writes to `float y[count]`.
std::vector<float> run(Program& program, size_t count) {
  std::vector<float> y(count, -1);
  const gl::Buffer buffer = gl::Buffer::with_data(static_cast<GLsizeiptr>(count * sizeof(float)), y.data());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer.id());
  program.use();
  glDispatchCompute(1, 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(count * sizeof(float)), y.data());
  glUseProgram(0);
  return y;
}

const std::string kComputeHead =
    "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer Out { float y[]; };\n";

TEST(EmbeddedShaders, AreTheFilesOfTheSourceTree) {
  const auto names = embedded_shader_names();
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  EXPECT_NE(std::find(names.begin(), names.end(), "lib/road.glsl"), names.end());
  for (const std::string_view name : names) {
    std::ifstream file(std::filesystem::path(ROADGEN_SOURCE_DIR) / "shaders" / name, std::ios::binary);
    EXPECT_EQ(embedded_shader(name).value(), std::string(std::istreambuf_iterator<char>(file), {})) << name;
  }
  EXPECT_FALSE(embedded_shader("lib/none.glsl"));
}

TEST_F(ShaderTest, SourceIncludesEachFileOnceAndKeepsLineNumbers) {
  put("a.comp", "#include \"lib/b.glsl\"\n  #  include \"lib/c.glsl\"\nvoid main() {}\n");
  put("lib/b.glsl", "#include \"lib/c.glsl\"\nint b;");
  put("lib/c.glsl", "int c;\n");
  const auto source = shader_source("a.comp", {{"SAMPLES", "4"}, {"FOG", ""}});
  ASSERT_TRUE(source.ok()) << source.error().text();
  EXPECT_EQ(source->files, (std::vector<std::string>{"a.comp", "lib/b.glsl", "lib/c.glsl"}));
  EXPECT_EQ(source->text,
            "#version 450 core\n#define FN\n#define IN(T) in T\n#define OUT(T) out T\n#define SAMPLES 4\n"
            "#define FOG \nint c;\nint b;\nvoid main() {}\n");
  ASSERT_EQ(source->lines.size(), 9u);
  const auto [c_file, c_line] = source->lines[6];
  const auto [b_file, b_line] = source->lines[7];
  const auto [a_file, a_line] = source->lines[8];
  EXPECT_EQ(source->lines[5].file, -1);
  EXPECT_EQ((std::vector<int>{c_file, c_line, b_file, b_line, a_file, a_line}), (std::vector<int>{2, 1, 1, 2, 0, 3}));
}

TEST_F(ShaderTest, MissingCyclicAndMalformedIncludesNameFileAndLine) {
  put("missing.frag", "\n#include \"lib/none.glsl\"\n");
  put("cycle.frag", "#include \"lib/x.glsl\"\n");
  put("lib/x.glsl", "\n\n#include \"lib/y.glsl\"\n");
  put("lib/y.glsl", "#include \"lib/x.glsl\"\n");
  put("malformed.frag", "#include <lib/x.glsl>\n");
  EXPECT_EQ(shader_source("missing.frag").error().text(),
            "shaders/missing.frag:2: cannot include 'lib/none.glsl': no such shader file");
  EXPECT_EQ(shader_source("cycle.frag").error().text(),
            "shaders/lib/y.glsl:1: include cycle: lib/x.glsl -> lib/y.glsl -> lib/x.glsl");
  EXPECT_EQ(shader_source("malformed.frag").error().text(),
            "shaders/malformed.frag:1: malformed #include; write #include \"lib/road.glsl\"");
  EXPECT_EQ(shader_source("none.frag").error().text(), "shaders/none.frag: no such shader file");
}

TEST_F(ShaderTest, CompileErrorNamesFileAndLine) {
  make_context(ContextKind::kOsmesa);
  put("bad.comp", kComputeHead + "#include \"lib/bad.glsl\"\nvoid main() { y[0] = bad(); }\n");
  put("lib/bad.glsl", "// one\n// two\nFN float bad() { return undeclared; }\n");
  auto program = Program::compute("bad.comp");
  ASSERT_FALSE(program.ok());
  EXPECT_EQ(program.error().code, ErrorCode::kShader);
  EXPECT_EQ(program.error().file, "shaders/lib/bad.glsl");
  EXPECT_EQ(program.error().line, 3);
  EXPECT_NE(program.error().message.find("undeclared"), std::string::npos) << program.error().text();

  put("lib/bad.glsl", "FN float bad() { return float(1.0); }\n");
  put("bad.comp", kComputeHead + "#include \"lib/bad.glsl\"\n\nvoid main() { y[0] = bad(; }\n");
  program = Program::compute("bad.comp");
  ASSERT_FALSE(program.ok());
  EXPECT_EQ(program.error().file, "shaders/bad.comp");
  EXPECT_EQ(program.error().line, 5);
}

TEST_F(ShaderTest, LinkErrorSaysWhat) {
  make_context(ContextKind::kOsmesa);
  put("a.vert", "out vec3 color;\nvoid main() { color = vec3(1); gl_Position = vec4(0); }\n");
  put("a.frag", "in vec2 color;\nout vec4 picture;\nvoid main() { picture = vec4(color, 0, 1); }\n");
  const auto program = Program::graphics("a.vert", "a.frag");
  ASSERT_FALSE(program.ok());
  EXPECT_NE(program.error().message.find("cannot link a.vert+a.frag"), std::string::npos) << program.error().text();
}

TEST_F(ShaderTest, LogsOfOtherDriversAreUnderstood) {
  const ShaderSource source{"", {"road.frag", "lib/road.glsl"}, {{-1, 1}, {1, 42}, {0, 7}}};
  EXPECT_EQ(
      shader_error("0(2) : error C1503: undefined variable \"q\"\n0(3) : error C0000: syntax error\n", source).text(),
      "shaders/lib/road.glsl:42: C1503: undefined variable \"q\"; shaders/road.frag:7: C0000: syntax error");
  EXPECT_EQ(shader_error("0:1(1): error: bad define\n0:99(1): error: where?", source).text(),
            "macros before shaders:1: bad define; macros before shaders:0: where?");
  EXPECT_EQ(shader_error("something\nelse", source).text(), "shaders/road.frag: something else");
}

TEST_F(ShaderTest, OverrideFolderWinsAndFallsBackToTheEmbeddedFile) {
  make_context(ContextKind::kOsmesa);
  const std::string text =
      kComputeHead + "#include \"lib/road.glsl\"\nvoid main() { y[0] = road_f(0.5, 1.0, -1.0); }\n";
  auto embedded = Program::compute_from_text("override.comp", text);
  ASSERT_TRUE(embedded.ok()) << embedded.error().text();
  EXPECT_EQ(run(*embedded, 1)[0], 0.25f);
  put("lib/road.glsl", "FN float road_f(IN(float) x, IN(float) a, IN(float) b) { return float(42.0); }\n");
  auto overridden = Program::compute_from_text("override.comp", text);
  ASSERT_TRUE(overridden.ok()) << overridden.error().text();
  EXPECT_EQ(run(*overridden, 1)[0], 42.0f);
}

TEST_F(ShaderTest, ParameterMacrosAndDefinesWork) {
  make_context(ContextKind::kOsmesa);
  auto program = Program::compute_from_text("macros.comp",
                                            kComputeHead +
                                                "FN void twice(IN(float) x, OUT(float) result) { result = 2.0 * x; }\n"
                                                "void main() { twice(VALUE, y[0]); }\n",
                                            {{"VALUE", "21.0"}});
  ASSERT_TRUE(program.ok()) << program.error().text();
  EXPECT_EQ(run(*program, 1)[0], 42.0f);
}

TEST_F(ShaderTest, UniformsOfEveryTypeArrive) {
  make_context(ContextKind::kOsmesa);
  auto program = Program::compute_from_text("uniforms.comp", kComputeHead + R"(
uniform float f; uniform int i; uniform uint u; uniform bool flag;
uniform vec2 v2; uniform vec3 v3; uniform vec4 v4; uniform ivec2 i2; uniform ivec3 i3; uniform uvec2 u2;
uniform mat3 m3; uniform mat4 m4;
uniform float fs[3]; uniform int is[2]; uniform vec3 v3s[2]; uniform vec4 v4s[2]; uniform mat4 m4s[2];
void main() {
  y[0] = f; y[1] = float(i); y[2] = float(u); y[3] = flag ? 1.0 : 0.0;
  y[4] = v2.y; y[5] = v3.z; y[6] = v4.w; y[7] = float(i2.y); y[8] = float(i3.z); y[9] = float(u2.y);
  y[10] = m3[1][2]; y[11] = m4[3][1];
  y[12] = fs[2]; y[13] = float(is[1]); y[14] = v3s[1].z; y[15] = v4s[1].w; y[16] = m4s[1][3][3];
})");
  ASSERT_TRUE(program.ok()) << program.error().text();
  glm::mat3 m3(0);
  m3[1][2] = 10;
  glm::mat4 m4(0);
  m4[3][1] = 11;
  const float floats[] = {0, 0, 12};
  const int ints[] = {0, 13};
  const glm::vec3 v3s[] = {glm::vec3(0), glm::vec3(14)};
  const glm::vec4 v4s[] = {glm::vec4(0), glm::vec4(15)};
  const glm::mat4 m4s[] = {glm::mat4(0), glm::mat4(16)};
  program->set("f", 0.5f);
  program->set("i", -1);
  program->set("u", 2u);
  program->set("flag", 1);
  program->set("v2", glm::vec2(0, 4));
  program->set("v3", glm::vec3(0, 0, 5));
  program->set("v4", glm::vec4(0, 0, 0, 6));
  program->set("i2", glm::ivec2(0, 7));
  program->set("i3", glm::ivec3(0, 0, 8));
  program->set("u2", glm::uvec2(0, 9));
  program->set("m3", m3);
  program->set("m4", m4);
  program->set("fs", std::span(floats));
  program->set("is", std::span(ints));
  program->set("v3s", std::span(v3s));
  program->set("v4s", std::span(v4s));
  program->set("m4s", std::span(m4s));
  program->set("removed", 1.0f);
  EXPECT_TRUE(program->has_uniform("fs"));
  EXPECT_FALSE(program->has_uniform("removed"));
  EXPECT_EQ(run(*program, 17), (std::vector<float>{0.5f, -1, 2, 1, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}));
}

TEST_F(ShaderTest, ProgramsMove) {
  make_context(ContextKind::kOsmesa);
  Program empty;
  EXPECT_EQ(empty.id(), 0u);
  auto made = Program::compute_from_text("move.comp", kComputeHead + "uniform float f;\nvoid main() { y[0] = f; }\n");
  ASSERT_TRUE(made.ok()) << made.error().text();
  Program program = std::move(*made);
  EXPECT_EQ(made->id(), 0u);
  program.set("f", 3.0f);
  EXPECT_EQ(run(program, 1)[0], 3.0f);
}

}  // namespace
}  // namespace roadgen::test
