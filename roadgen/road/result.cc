#include "roadgen/road/result.h"

namespace roadgen {
namespace {

std::string located(const std::string& file, int line, const std::string& element, const std::string& message) {
  std::string text;
  if (!file.empty()) text += file + (line > 0 ? ":" + std::to_string(line) : "") + ": ";
  if (!element.empty()) text += element + ": ";
  return text + message;
}

}  // namespace

std::string Error::text() const { return located(file, line, element, message); }

std::string Diagnostic::text() const {
  return std::string(severity_name(severity)) + ": " + located(file, line, element, message);
}

const char* severity_name(Severity severity) {
  switch (severity) {
    case Severity::kInfo: return "info";
    case Severity::kWarning: return "warning";
    case Severity::kError: return "error";
  }
  return "error";
}

}  // namespace roadgen
