#include "roadgen/render/shader_source.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <system_error>

#include "shaders/embedded.h"

namespace roadgen {
namespace {

const char* const kFolder = "shaders/";  // what errors put before a name

std::optional<std::string> overriding_file(const std::string& name) {
  const char* folder = std::getenv("ROADGEN_SHADER_DIR");
  if (!folder || !*folder) return std::nullopt;
  std::ifstream file(std::filesystem::path(folder) / name, std::ios::binary);
  if (!file) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(file), {});
}

// The name of an #include line; nothing for other lines, an empty string where it is malformed.
std::optional<std::string> included_name(std::string_view line) {
  const auto skip = [&line](std::string_view blanks) {
    line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
  };
  skip(" \t");
  if (!line.starts_with('#')) return std::nullopt;
  line.remove_prefix(1);
  skip(" \t");
  if (!line.starts_with("include")) return std::nullopt;
  line.remove_prefix(7);
  skip(" \t");
  const size_t end = line.find('"', 1);
  if (!line.starts_with('"') || end == std::string_view::npos) return std::string();
  return std::string(line.substr(1, end - 1));
}

// Depth-first expansion of includes.
class Expander {
 public:
  explicit Expander(ShaderSource& out) : out_(out) {}

  Status add(const std::string& name, std::string_view text) {
    const int index = static_cast<int>(out_.files.size());
    out_.files.push_back(name);
    stack_.push_back(name);
    int number = 0;
    while (!text.empty()) {
      const size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      ++number;
      const std::optional<std::string> included = included_name(line);
      if (!included) {
        out_.text.append(line).push_back('\n');
        out_.lines.push_back({index, number});
        continue;
      }
      if (const Status status = include(*included, number); !status) return status;
    }
    stack_.pop_back();
    return Done{};
  }

 private:
  Status include(const std::string& name, int line) {
    const std::string from = kFolder + stack_.back();
    if (name.empty()) {
      return Error{ErrorCode::kShader, "malformed #include; write #include \"lib/road.glsl\"", from, line};
    }
    if (const auto seen = std::find(stack_.begin(), stack_.end(), name); seen != stack_.end()) {
      std::string cycle;
      for (auto it = seen; it != stack_.end(); ++it) cycle += *it + " -> ";
      return Error{ErrorCode::kShader, "include cycle: " + cycle + name, from, line};
    }
    if (std::find(out_.files.begin(), out_.files.end(), name) != out_.files.end()) return Done{};
    const Result<std::string> text = read_shader_file(name);
    if (!text) return Error{ErrorCode::kShader, "cannot include '" + name + "': " + text.error().message, from, line};
    return add(name, *text);
  }

  ShaderSource& out_;
  std::vector<std::string> stack_;  // the files being expanded, outermost first
};

struct LogEntry {
  int line;
  std::string message;
};

// The number that the digits at the start of the text make, which are removed; nothing if there are none.
std::optional<int> leading_number(std::string_view& text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  text.remove_prefix(static_cast<size_t>(end - text.data()));
  return number;
}

// Mesa: "0:42(13): error: ..."; NVIDIA: "0(42) : error C1008: ...". The first number is that of the source string.
std::optional<LogEntry> log_error(std::string_view text) {
  if (!leading_number(text) || !(text.starts_with(':') || text.starts_with('('))) return std::nullopt;
  text.remove_prefix(1);
  const std::optional<int> line = leading_number(text);
  if (!line) return std::nullopt;
  for (const std::string_view marker : {": error: ", ": preprocessor error: ", ": error ", ": fatal error "}) {
    const size_t at = text.find(marker);
    if (at != std::string_view::npos) return LogEntry{*line, std::string(text.substr(at + marker.size()))};
  }
  return std::nullopt;
}

std::vector<LogEntry> log_errors(const std::string& log) {
  std::vector<LogEntry> entries;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    if (auto entry = log_error(line)) entries.push_back(std::move(*entry));
  }
  return entries;
}

// The origin of a line of the text; file -1 where there is none.
ShaderSource::Origin origin_of(int line, const ShaderSource& source) {
  if (line < 1 || line > static_cast<int>(source.lines.size())) return {-1, 0};
  return source.lines[static_cast<size_t>(line - 1)];
}

}  // namespace

Result<std::string> read_shader_file(const std::string& name) {
  if (auto text = overriding_file(name)) return std::move(*text);
  if (const auto text = embedded_shader(name)) return std::string(*text);
  return Error{ErrorCode::kIo, "no such shader file", kFolder + name};
}

Result<ShaderSource> shader_source_from_text(const std::string& name, std::string_view text,
                                             const ShaderDefines& defines) {
  ShaderSource source;
  source.text = "#version 450 core\n#define FN\n#define IN(T) in T\n#define OUT(T) out T\n";
  for (const auto& [macro, value] : defines) source.text += "#define " + macro + " " + value + "\n";
  const auto preamble = static_cast<int>(std::count(source.text.begin(), source.text.end(), '\n'));
  for (int line = 1; line <= preamble; ++line) source.lines.push_back({-1, line});
  if (const Status status = Expander(source).add(name, text); !status) return status.error();
  return source;
}

Result<ShaderSource> shader_source(const std::string& name, const ShaderDefines& defines) {
  const Result<std::string> text = read_shader_file(name);
  if (!text) return text.error();
  return shader_source_from_text(name, *text, defines);
}

Error shader_error(const std::string& log, const ShaderSource& source) {
  Error error{ErrorCode::kShader, ""};
  const std::vector<LogEntry> entries = log_errors(log);
  for (size_t i = 0; i < entries.size() && i < 3; ++i) {
    const auto [index, line] = origin_of(entries[i].line, source);
    const std::string file = index >= 0 ? kFolder + source.files[static_cast<size_t>(index)] : "macros before shaders";
    if (i == 0) {
      error.file = file;
      error.line = line;
      error.message = entries[i].message;
    } else {
      error.message += "; " + file + ":" + std::to_string(line) + ": " + entries[i].message;
    }
  }
  if (entries.empty()) {
    error.file = source.files.empty() ? std::string() : kFolder + source.files.front();
    error.message = log.empty() ? "the driver gives no reason" : log;
    std::replace(error.message.begin(), error.message.end(), '\n', ' ');
  }
  return error;
}

}  // namespace roadgen
