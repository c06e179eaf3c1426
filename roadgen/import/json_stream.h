// Internal: JSON read piece by piece, each value with its line, so that a fault in a file of a million objects is named
// with line and path, and memory holds one of them at a time.
#pragma once

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "roadgen/road/result.h"

namespace roadgen {

struct JsonValue {
  enum class Kind { kNull, kBool, kNumber, kString, kArray, kObject };
  Kind kind = Kind::kNull;
  int line = 0;
  bool truth = false;                                           // kBool
  double number = 0;                                            // kNumber
  std::string text = {};                                        // kString
  std::vector<JsonValue> items = {};                            // kArray
  std::vector<std::pair<std::string, JsonValue>> members = {};  // kObject, in the file's order

  const JsonValue* find(std::string_view key) const;
};
// "a number", "an array", ...
const char* json_kind_name(JsonValue::Kind kind);

// The keys that lead to a value: "objects[3].center".
class JsonPath {
 public:
  JsonPath() = default;
  explicit JsonPath(std::string text) : text_(std::move(text)) {}
  JsonPath at(std::string_view key) const;
  JsonPath at(std::size_t index) const { return JsonPath(text_ + "[" + std::to_string(index) + "]"); }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

// A value, where it stands, and the questions that a reader of a format asks of it. Errors are kData, or kParse for
// another kind of value, with file, line and path.
class JsonNode {
 public:
  JsonNode(const JsonValue& value, JsonPath path, const std::string& file)
      : value_(&value), path_(std::move(path)), file_(&file) {}

  const JsonValue& value() const { return *value_; }
  const JsonPath& path() const { return path_; }
  int line() const { return value_->line; }
  Error error(const std::string& why, ErrorCode code = ErrorCode::kData) const;

  Status expect(JsonValue::Kind kind) const;
  // That it is an object without other keys, and none of them twice.
  Status expect_keys(std::initializer_list<std::string_view> known) const;
  bool has(std::string_view key) const { return value_->find(key) != nullptr; }
  Result<JsonNode> at(std::string_view key) const;  // Errors: also where there is none
  JsonNode item(std::size_t i) const { return {value_->items[i], path_.at(i), *file_}; }

  Result<double> number() const;  // finite
  Result<std::string> text() const;
  Result<bool> truth() const;
  // An array of exactly so many finite numbers.
  Status numbers(double* found, std::size_t count) const;

 private:
  const JsonValue* value_;
  JsonPath path_;
  const std::string* file_;
};

// Reads a text whose outermost value is an object. member(key, value, index) gets each of its members in the file's
// order; of the one whose key is `streamed`, an array, each item by itself, with its index. The first Error that it returns ends the reading and is the answer.
// Errors: kParse with the line: not JSON, not an object, a key twice in it, values nested deeper than kMostDepth, one
// with more than kMostValues within; kData where a number is too large.
inline constexpr std::size_t kMostDepth = 256;
inline constexpr std::size_t kMostValues = 8'000'000;
Status read_json(
    std::string_view text, const std::string& file, std::string_view streamed,
    const std::function<Status(const std::string& key, const JsonValue& value, std::size_t index)>& member);

}  // namespace roadgen
