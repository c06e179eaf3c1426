# cmake -DSOURCE_DIR=... -DNAMES=a.vert,lib/b.glsl -DOUTPUT=embedded.cc -P embed.cmake
# Writes a C++ file that defines embedded_shader() and embedded_shader_names() of shaders/embedded.h.
string(REPLACE "," ";" names "${NAMES}")
list(LENGTH names count)
set(text "#include \"shaders/embedded.h\"\n\n#include <array>\n#include <utility>\n\n")
string(APPEND text "namespace roadgen {\nnamespace {\n\n")
string(APPEND text "constexpr std::array<std::pair<std::string_view, std::string_view>, ${count}> kShaders = {{\n")
foreach(name IN LISTS names)
  file(READ ${SOURCE_DIR}/${name} body)
  string(APPEND text "{\"${name}\", R\"=glsl=(${body})=glsl=\"},\n")
endforeach()
string(APPEND text "}};

}  // namespace

std::optional<std::string_view> embedded_shader(std::string_view name) {
  for (const auto& [key, body] : kShaders) {
    if (key == name) return body;
  }
  return std::nullopt;
}

std::vector<std::string_view> embedded_shader_names() {
  std::vector<std::string_view> names;
  for (const auto& entry : kShaders) names.push_back(entry.first);
  return names;
}

}  // namespace roadgen
")
file(WRITE ${OUTPUT} "${text}")
