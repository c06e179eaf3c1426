#include "roadgen/render/program.h"

#include <glad/gl.h>

#include <algorithm>
#include <cassert>
#include <unordered_map>
#include <utility>
#include <vector>

#include <glm/gtc/type_ptr.hpp>

namespace roadgen {
namespace {

struct StringHash {
  using is_transparent = void;
  size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
};

// Shader objects, deleted at the end of linking.
struct Shaders {
  std::vector<GLuint> ids;
  Shaders() = default;
  Shaders(const Shaders&) = delete;
  Shaders& operator=(const Shaders&) = delete;
  ~Shaders() {
    for (const GLuint id : ids) glDeleteShader(id);
  }
};

std::string shader_log(GLuint shader) {
  GLint length = 0;
  glGetShaderiv(shader, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(length), '\0');
  glGetShaderInfoLog(shader, length, &length, log.data());
  log.resize(static_cast<size_t>(length));
  return log;
}

std::string program_log(GLuint program) {
  GLint length = 0;
  glGetProgramiv(program, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<size_t>(length), '\0');
  glGetProgramInfoLog(program, length, &length, log.data());
  log.resize(static_cast<size_t>(length));
  return log;
}

Status compile(GLenum stage, const ShaderSource& source, Shaders& shaders) {
  const GLuint shader = glCreateShader(stage);
  shaders.ids.push_back(shader);
  const char* text = source.text.data();
  const GLint length = static_cast<GLint>(source.text.size());
  glShaderSource(shader, 1, &text, &length);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (!compiled) return shader_error(shader_log(shader), source);
  return Done{};
}

}  // namespace

struct Program::Uniforms {
  std::unordered_map<std::string, GLint, StringHash, std::equal_to<>> locations;
};

Program::Program() = default;
Program::~Program() {
  if (id_) glDeleteProgram(id_);
}
Program::Program(Program&& other) noexcept : id_(std::exchange(other.id_, 0)), uniforms_(std::move(other.uniforms_)) {}
Program& Program::operator=(Program&& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(uniforms_, other.uniforms_);
  return *this;
}

Result<Program> Program::link(std::span<const unsigned> shaders, const ShaderSource& first, const std::string& label) {
  Program program;
  program.uniforms_ = std::make_unique<Uniforms>();
  program.id_ = glCreateProgram();
  for (const GLuint shader : shaders) glAttachShader(program.id_, shader);
  glLinkProgram(program.id_);
  GLint linked = GL_FALSE;
  glGetProgramiv(program.id_, GL_LINK_STATUS, &linked);
  if (!linked) {
    Error error = shader_error(program_log(program.id_), first);
    error.message = "cannot link " + label + ": " + error.message;
    return error;
  }
  for (const GLuint shader : shaders) glDetachShader(program.id_, shader);
  glObjectLabel(GL_PROGRAM, program.id_, static_cast<GLsizei>(std::min<size_t>(label.size(), 255)), label.data());
  return program;
}

Result<Program> Program::create(const ProgramFiles& files, const ShaderDefines& defines) {
  assert(files.compute.empty() != files.vertex.empty());
  const std::pair<GLenum, const std::string&> stages[] = {{GL_VERTEX_SHADER, files.vertex},
                                                          {GL_GEOMETRY_SHADER, files.geometry},
                                                          {GL_FRAGMENT_SHADER, files.fragment},
                                                          {GL_COMPUTE_SHADER, files.compute}};
  Shaders shaders;
  ShaderSource first;
  std::string label;
  for (const auto& [stage, file] : stages) {
    if (file.empty()) continue;
    Result<ShaderSource> source = shader_source(file, defines);
    if (!source) return source.error();
    if (const Status status = compile(stage, *source, shaders); !status) return status.error();
    if (label.empty()) first = std::move(*source);
    label += (label.empty() ? "" : "+") + file;
  }
  return link(shaders.ids, first, label);
}

Result<Program> Program::graphics(const std::string& vertex_file, const std::string& fragment_file,
                                  const ShaderDefines& defines) {
  return create({.vertex = vertex_file, .fragment = fragment_file}, defines);
}

Result<LazyProgram> LazyProgram::graphics(const std::string& vertex_file, const std::string& fragment_file,
                                          const ShaderDefines& defines) {
  auto vertex = shader_source(vertex_file, defines);
  if (!vertex) return vertex.error();
  auto fragment = shader_source(fragment_file, defines);
  if (!fragment) return fragment.error();
  LazyProgram program;
  program.label_ = vertex_file + "+" + fragment_file;
  program.vertex_ = std::move(*vertex);
  program.fragment_ = std::move(*fragment);
  return program;
}

Status LazyProgram::need() {
  if (program_.id() != 0) return Done{};
  Shaders shaders;
  if (Status s = compile(GL_VERTEX_SHADER, vertex_, shaders); !s) return s;
  if (Status s = compile(GL_FRAGMENT_SHADER, fragment_, shaders); !s) return s;
  auto linked = Program::link(shaders.ids, vertex_, label_);
  if (!linked) return linked.error();
  program_ = std::move(*linked);
  vertex_ = fragment_ = {};
  return Done{};
}

Result<Program> Program::compute(const std::string& compute_file, const ShaderDefines& defines) {
  return create({.compute = compute_file}, defines);
}

Result<Program> Program::compute_from_text(const std::string& name, std::string_view text,
                                           const ShaderDefines& defines) {
  const Result<ShaderSource> source = shader_source_from_text(name, text, defines);
  if (!source) return source.error();
  Shaders shaders;
  if (const Status status = compile(GL_COMPUTE_SHADER, *source, shaders); !status) return status.error();
  return link(shaders.ids, *source, name);
}

void Program::use() const {
  assert(id_);
  glUseProgram(id_);
}

int Program::location(std::string_view name) const {
  assert(id_);
  auto& locations = uniforms_->locations;
  if (const auto it = locations.find(name); it != locations.end()) return it->second;
  std::string key(name);
  const GLint found = glGetUniformLocation(id_, key.c_str());
  locations.emplace(std::move(key), found);
  return found;
}

bool Program::has_uniform(std::string_view name) const { return location(name) >= 0; }

// OpenGL ignores location -1.
void Program::set(std::string_view name, float x) { glProgramUniform1f(id_, location(name), x); }
void Program::set(std::string_view name, int x) { glProgramUniform1i(id_, location(name), x); }
void Program::set(std::string_view name, unsigned x) { glProgramUniform1ui(id_, location(name), x); }
void Program::set(std::string_view name, const glm::vec2& x) { glProgramUniform2f(id_, location(name), x.x, x.y); }
void Program::set(std::string_view name, const glm::vec3& x) { glProgramUniform3fv(id_, location(name), 1, &x[0]); }
void Program::set(std::string_view name, const glm::vec4& x) { glProgramUniform4fv(id_, location(name), 1, &x[0]); }
void Program::set(std::string_view name, const glm::ivec2& x) { glProgramUniform2i(id_, location(name), x.x, x.y); }
void Program::set(std::string_view name, const glm::ivec3& x) { glProgramUniform3iv(id_, location(name), 1, &x[0]); }
void Program::set(std::string_view name, const glm::uvec2& x) { glProgramUniform2ui(id_, location(name), x.x, x.y); }
void Program::set(std::string_view name, const glm::mat3& x) {
  glProgramUniformMatrix3fv(id_, location(name), 1, GL_FALSE, glm::value_ptr(x));
}
void Program::set(std::string_view name, const glm::mat4& x) {
  glProgramUniformMatrix4fv(id_, location(name), 1, GL_FALSE, glm::value_ptr(x));
}
void Program::set(std::string_view name, std::span<const float> x) {
  glProgramUniform1fv(id_, location(name), static_cast<GLsizei>(x.size()), x.data());
}
void Program::set(std::string_view name, std::span<const int> x) {
  glProgramUniform1iv(id_, location(name), static_cast<GLsizei>(x.size()), x.data());
}
void Program::set(std::string_view name, std::span<const glm::vec3> x) {
  if (!x.empty()) glProgramUniform3fv(id_, location(name), static_cast<GLsizei>(x.size()), &x[0][0]);
}
void Program::set(std::string_view name, std::span<const glm::vec4> x) {
  if (!x.empty()) glProgramUniform4fv(id_, location(name), static_cast<GLsizei>(x.size()), &x[0][0]);
}
void Program::set(std::string_view name, std::span<const glm::mat4> x) {
  if (!x.empty()) {
    glProgramUniformMatrix4fv(id_, location(name), static_cast<GLsizei>(x.size()), GL_FALSE, &x[0][0][0]);
  }
}

}  // namespace roadgen
