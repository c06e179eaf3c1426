// XML by hand, since the form of our files is fixed and the order of attributes is part of being identical. Internal to
// roadgen/export.
#pragma once

#include <charconv>
#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace roadgen {

// Appends to a text, which goes to the sink whenever it has grown to kPiece bytes, if there is a sink.
class XmlWriter {
 public:
  static constexpr std::size_t kPiece = 1 << 16;
  using Sink = std::function<void(std::string_view)>;
  XmlWriter() = default;
  explicit XmlWriter(Sink sink) : sink_(std::move(sink)) {}

  XmlWriter& raw(std::string_view text) {
    text_ += text;
    if (text_.size() >= kPiece && sink_) flush();
    return *this;
  }
  // name="x", shortest digits that bring the same double back, whatever the locale.
  XmlWriter& number(const char* name, double x) {
    text_ += ' ';
    text_ += name;
    text_ += "=\"";
    digits(x);
    text_ += '"';
    return *this;
  }
  XmlWriter& text(const char* name, std::string_view value) {
    text_ += ' ';
    text_ += name;
    text_ += "=\"";
    for (const char c : value) escape(c);
    text_ += '"';
    return *this;
  }
  // Between tags.
  XmlWriter& content(std::string_view value) {
    for (const char c : value) c == '\n' ? raw("\n") : escape(c);
    return *this;
  }
  void digits(double x) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, x == 0 ? 0.0 : x).ptr;  // no "-0"
    text_.append(buffer, end);
  }
  // <userData code="roadgen:CODE" value="x y ..."/> and a newline; a text after the numbers where there is one.
  void user_data(const char* indent, const char* code, std::initializer_list<double> numbers) {
    user_data(indent, code, std::span(numbers.begin(), numbers.size()));
  }
  void user_data(const char* indent, const char* code, std::span<const double> numbers, std::string_view words = {}) {
    raw(indent).raw("<userData code=\"roadgen:").raw(code).raw("\" value=\"");
    const char* blank = "";
    for (const double x : numbers) raw(std::exchange(blank, " ")).digits(x);
    if (!words.empty()) raw(std::exchange(blank, " "));
    for (const char c : words) escape(c);
    raw("\"/>\n");
  }
  // What has not gone to the sink.
  std::string take() { return std::move(text_); }
  void flush() {
    sink_(text_);
    text_.clear();
  }

 private:
  XmlWriter& escape(char c) {
    switch (c) {
      case '&': text_ += "&amp;"; break;
      case '<': text_ += "&lt;"; break;
      case '>': text_ += "&gt;"; break;
      case '"': text_ += "&quot;"; break;
      case '\n':
      case '\r':
      case '\t': text_ += ' '; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) text_ += c;  // XML 1.0 has no other control characters
    }
    return *this;
  }

  std::string text_;
  Sink sink_;
};

}  // namespace roadgen
