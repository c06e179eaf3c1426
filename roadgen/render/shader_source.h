// The text that the OpenGL driver compiles, put together from the files of shaders/.
//
// A line `#include "lib/road.glsl"` is replaced by that file, its name relative to shaders/; each file comes in at most
// once. So an #include must not stand between #if and #endif. Files carry no #version: the text begins with
//
//   #version 450 core
//   #define FN / IN(T) in T / OUT(T) out T     the GLSL side of shaders/lib/glsl.h
//   #define ...                                 the caller's
//
// The driver sees one numbered text, and ShaderSource::lines maps its complaints back to files and lines. #line
// directives would not do: Mesa's compiler forgets the file number of most expressions and calls every file 0.
//
// Files come from the directory that the environment variable ROADGEN_SHADER_DIR names, if it has them; otherwise they
// are those that were embedded when the library was built.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roadgen/road/result.h"

namespace roadgen {

// Preprocessor macros: name and value, the value possibly empty.
using ShaderDefines = std::vector<std::pair<std::string, std::string>>;

struct ShaderSource {
  struct Origin {
    int file;  // index into files, or -1 for the lines put before them
    int line;  // 1-based
  };
  std::string text;                // ready for glShaderSource
  std::vector<std::string> files;  // the file names, relative to shaders/, in order of appearance
  std::vector<Origin> lines;       // where each line of text comes from
};

// One file of shaders/ by its name, such as "lib/road.glsl". Errors: kIo: no such file.
Result<std::string> read_shader_file(const std::string& name);

// The text for a shader file, such as "road.frag". Errors: kIo: no such file; kShader, with file and line: a missing
// include, an include cycle, a malformed #include.
Result<ShaderSource> shader_source(const std::string& name, const ShaderDefines& defines = {});

// The same for a text at hand, which may include files; name is what errors call it.
Result<ShaderSource> shader_source_from_text(const std::string& name, std::string_view text,
                                             const ShaderDefines& defines = {});

// The first error of a driver's log, with its file ("shaders/lib/road.glsl") and line if the log tells them; the
// message is the driver's, and holds up to two more errors after "; ". Understands the formats of Mesa and NVIDIA.
Error shader_error(const std::string& log, const ShaderSource& source);

}  // namespace roadgen
