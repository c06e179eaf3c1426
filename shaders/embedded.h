// The GLSL files of this folder as they were when the library was built.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace roadgen {

// The text of a shader file by its name relative to shaders/, such as "lib/road.glsl"; nothing if there is none.
// Cost: linear in the number of files.
std::optional<std::string_view> embedded_shader(std::string_view name);

// All names, sorted.
std::vector<std::string_view> embedded_shader_names();

}  // namespace roadgen
