#include "roadgen/render/shader_source.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <regex>
#include <sstream>

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
    const size_t index = out_.files.size();
    out_.files.push_back(name);
    stack_.push_back(name);
    mark_line(1, index);
    int number = 0;
    while (!text.empty()) {
      const size_t end = std::min(text.find('\n'), text.size());
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      ++number;
      const std::optional<std::string> included = included_name(line);
      if (!included) {
        out_.text.append(line).push_back('\n');
        continue;
      }
      if (const Status status = include(*included, number); !status) return status;
      mark_line(number + 1, index);
    }
    stack_.pop_back();
    return Done{};
  }

 private:
  Status include(const std::string& name, int line) {
    const std::string from = kFolder + stack_.back();
    if (name.empty()) return Error{ErrorCode::kShader, "malformed #include; write #include \"lib/road.glsl\"", from, line};
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

  // The next line is line `number` of file `index`.
  void mark_line(int number, size_t index) {
    out_.text += "#line " + std::to_string(number) + " " + std::to_string(index) + "\n";
  }

  ShaderSource& out_;
  std::vector<std::string> stack_;  // the files being expanded, outermost first
};

struct LogEntry {
  size_t file;
  int line;
  std::string message;
};

// Mesa: "0:42(13): error: ..."; NVIDIA: "0(42) : error C1008: ...".
std::vector<LogEntry> log_errors(const std::string& log) {
  static const std::regex kMesa(R"(^(\d+):(\d+)\(\d+\): (?:preprocessor )?error: (.*)$)");
  static const std::regex kNvidia(R"(^(\d+)\((\d+)\) : (?:fatal )?error (.*)$)");
  std::vector<LogEntry> entries;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (line.size() > 2000) line.resize(2000);  // std::regex recurses per character
    if (std::regex_match(line, match, kMesa) || std::regex_match(line, match, kNvidia)) {
      entries.push_back({std::strtoul(match[1].str().c_str(), nullptr, 10), std::atoi(match[2].str().c_str()), match[3]});
    }
  }
  return entries;
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
    const LogEntry& entry = entries[i];
    const std::string file = entry.file < source.files.size() ? kFolder + source.files[entry.file] : std::string();
    if (i == 0) {
      error.file = file;
      error.line = entry.line;
      error.message = entry.message;
    } else {
      error.message += "; " + file + ":" + std::to_string(entry.line) + ": " + entry.message;
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
