// A linked OpenGL program with its uniforms.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/shader_source.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Files of shaders/; an empty name is no such stage. Either compute alone, or vertex with any of the others.
struct ProgramFiles {
  std::string vertex = {};
  std::string geometry = {};
  std::string fragment = {};
  std::string compute = {};
};

// Owns a program object; movable. Made, used and destroyed with its context current.
class Program {
 public:
  // Compiles and links. Every stage gets the same defines. The program's debug label is the names of its files.
  // Errors: kShader with file and line: "shaders/lib/road.glsl:42: ...".
  static Result<Program> create(const ProgramFiles& files, const ShaderDefines& defines = {});
  static Result<Program> graphics(const std::string& vertex_file, const std::string& fragment_file,
                                  const ShaderDefines& defines = {});
  static Result<Program> compute(const std::string& compute_file, const ShaderDefines& defines = {});
  // A compute program from a text at hand; errors call it by name.
  static Result<Program> compute_from_text(const std::string& name, std::string_view text,
                                           const ShaderDefines& defines = {});

  // Owns nothing.
  Program();
  ~Program();
  Program(Program&& other) noexcept;
  Program& operator=(Program&& other) noexcept;

  // The name of the program object, 0 where this owns nothing.
  unsigned id() const { return id_; }
  // glUseProgram. Requires: id() != 0.
  void use() const;

  // Whether the driver kept such a uniform; "lights" and "lights[0]" name the same one.
  bool has_uniform(std::string_view name) const;

  // Sets a uniform; the program need not be in use. A uniform that the linker removed is skipped silently. One of
  // another type is an OpenGL error. Cost: a hash of the name, and the call.
  void set(std::string_view name, float x);
  void set(std::string_view name, int x);  // also samplers and images (their unit) and bool
  void set(std::string_view name, unsigned x);
  void set(std::string_view name, const glm::vec2& x);
  void set(std::string_view name, const glm::vec3& x);
  void set(std::string_view name, const glm::vec4& x);
  void set(std::string_view name, const glm::ivec2& x);
  void set(std::string_view name, const glm::ivec3& x);
  void set(std::string_view name, const glm::uvec2& x);
  void set(std::string_view name, const glm::mat3& x);
  void set(std::string_view name, const glm::mat4& x);
  // Arrays, from their first element on.
  void set(std::string_view name, std::span<const float> x);
  void set(std::string_view name, std::span<const int> x);
  void set(std::string_view name, std::span<const glm::vec3> x);
  void set(std::string_view name, std::span<const glm::vec4> x);
  void set(std::string_view name, std::span<const glm::mat4> x);

 private:
  friend class LazyProgram;
  struct Uniforms;
  static Result<Program> link(std::span<const unsigned> shaders, const ShaderSource& first, const std::string& label);
  int location(std::string_view name) const;

  unsigned id_ = 0;
  std::unique_ptr<Uniforms> uniforms_;
};

// A graphics program whose files are read when it is made and which is compiled when it is first needed: of the many kinds
// of programs that a renderer has, most pictures need few.
class LazyProgram {
 public:
  LazyProgram() = default;
  // Errors: kIo, kShader: a file is missing or its includes are malformed.
  static Result<LazyProgram> graphics(const std::string& vertex_file, const std::string& fragment_file,
                                      const ShaderDefines& defines = {});
  // Compiles where that is not done yet. Errors: kShader, as Program::create.
  Status need();
  // Requires: need() succeeded.
  const Program& operator*() const { return program_; }
  const Program* operator->() const { return &program_; }

 private:
  std::string label_;
  ShaderSource vertex_, fragment_;
  Program program_;
};

}  // namespace roadgen
