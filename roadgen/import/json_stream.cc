#include "roadgen/import/json_stream.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

#include <nlohmann/json.hpp>

namespace roadgen {
namespace {

using Kind = JsonValue::Kind;

// Where the reading is: the parser copies its iterators, so they share this.
struct Place {
  int line = 1;
  bool newline = false;  // the last byte was one
};

class CountingIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  CountingIterator(const char* at, Place* place) : at_(at), place_(place) {}
  reference operator*() const { return *at_; }
  CountingIterator& operator++() {
    place_->newline = *at_ == '\n';
    place_->line += place_->newline ? 1 : 0;
    ++at_;
    return *this;
  }
  CountingIterator operator++(int) {
    const CountingIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const CountingIterator& other) const { return at_ == other.at_; }
  bool operator!=(const CountingIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  Place* place_;
};

class Handler {
 public:
  Handler(const std::string& file, const Place& place, std::string_view streamed,
          const std::function<Status(const std::string&, const JsonValue&, std::size_t)>& member)
      : file_(file), place_(place), streamed_(streamed), member_(member) {}

  std::optional<Error>& error() { return error_; }

  bool null() { return add(JsonValue{.kind = Kind::kNull, .line = place_.line}); }
  bool boolean(bool x) { return add(JsonValue{.kind = Kind::kBool, .line = place_.line, .truth = x}); }
  bool number_integer(std::int64_t x) { return number(static_cast<double>(x)); }
  bool number_unsigned(std::uint64_t x) { return number(static_cast<double>(x)); }
  bool number_float(double x, const std::string&) { return number(x); }
  bool string(std::string& x) {
    return add(JsonValue{.kind = Kind::kString, .line = place_.line, .text = std::move(x)});
  }
  bool binary(std::vector<std::uint8_t>&) { return false; }  // JSON text has none
  bool start_object(std::size_t) { return start(Kind::kObject); }
  bool start_array(std::size_t) { return start(Kind::kArray); }
  bool end_object() { return end(); }
  bool end_array() { return end(); }

  bool key(std::string& x) {
    if (open_.size() > 1) {
      const auto& members = open_.back().value.members;
      // Of many members the reader of the format finds doubles; here only what is cheap.
      if (members.size() < 64 && open_.back().value.find(x)) return fail("the key '" + x + "' stands here twice");
    } else if (std::find(seen_.begin(), seen_.end(), x) != seen_.end()) {
      return fail("the key '" + x + "' stands here twice");
    } else {
      seen_.push_back(x);
      if (seen_.size() > 64) return fail("more than 64 keys at the top");
    }
    open_.back().key = std::move(x);
    return true;
  }

  bool parse_error(std::size_t, const std::string&, const nlohmann::detail::exception& fault) {
    // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while parsing ...": from "syntax".
    std::string why = fault.what();
    if (const std::size_t at = why.find("column "); at != why.npos && why.find(": ", at) != why.npos) {
      why = why.substr(why.find(": ", at) + 2);
    } else if (const std::size_t bracket = why.find("] "); bracket != why.npos) {
      why = why.substr(bracket + 2);
    }
    std::replace_if(
        why.begin(), why.end(), [](unsigned char c) { return c < ' '; }, ' ');
    if (why.size() > 200) why = why.substr(0, 200) + "...";
    return fail("not JSON: " + why);
  }

 private:
  struct Open {
    JsonValue value;
    std::string key;  // of the member that comes next
  };

  int line() const { return place_.newline ? place_.line - 1 : place_.line; }

  bool fail(std::string why) { return fail(Error{ErrorCode::kParse, std::move(why), file_, line()}); }
  bool fail(Error error) {
    error_ = std::move(error);
    return false;
  }

  // The parser has read one byte beyond a number.
  bool number(double x) { return add(JsonValue{.kind = Kind::kNumber, .line = line(), .number = x}); }

  bool start(Kind kind) {
    if (open_.empty() && kind != Kind::kObject) return fail("expected an object: { ... }");
    if (open_.size() >= kMostDepth) return fail("values are nested too deep: more than 256");
    open_.push_back({JsonValue{.kind = kind, .line = place_.line}, {}});
    return true;
  }

  bool end() {
    Open done = std::move(open_.back());
    open_.pop_back();
    if (open_.empty()) return true;
    if (open_.size() == 1 && done.value.kind == Kind::kArray && open_.back().key == streamed_) {
      index_ = 0;
      return true;
    }
    return add(std::move(done.value));
  }

  // A value that is whole.
  bool add(JsonValue value) {
    if (open_.empty()) return fail("expected an object: { ... }");
    Open& parent = open_.back();
    if (open_.size() == 1) {
      if (parent.key == streamed_) {
        return fail(JsonNode(value, JsonPath(streamed_), file_).expect(Kind::kArray).error());
      }
      values_ = 0;
      if (Status s = member_(parent.key, value, 0); !s) return fail(s.error());
      return true;
    }
    if (open_.size() == 2 && parent.value.kind == Kind::kArray && open_.front().key == streamed_) {
      values_ = 0;
      if (Status s = member_(streamed_, value, index_++); !s) return fail(s.error());
      return true;
    }
    if (++values_ > kMostValues) return fail("more than 8 million values in one");
    if (parent.value.kind == Kind::kArray) {
      parent.value.items.push_back(std::move(value));
    } else {
      parent.value.members.emplace_back(std::move(parent.key), std::move(value));
    }
    return true;
  }

  const std::string& file_;
  const Place& place_;
  std::string streamed_;
  const std::function<Status(const std::string&, const JsonValue&, std::size_t)>& member_;
  std::vector<Open> open_;
  std::vector<std::string> seen_;
  std::size_t index_ = 0, values_ = 0;
  std::optional<Error> error_;
};

}  // namespace

const char* json_kind_name(Kind kind) {
  constexpr const char* kNames[] = {"null", "true or false", "a number", "a string", "an array", "an object"};
  return kNames[static_cast<std::size_t>(kind)];
}

const JsonValue* JsonValue::find(std::string_view key) const {
  const auto found = std::find_if(members.begin(), members.end(), [&](const auto& m) { return m.first == key; });
  return found == members.end() ? nullptr : &found->second;
}

JsonPath JsonPath::at(std::string_view key) const {
  return JsonPath(text_.empty() ? std::string(key) : text_ + "." + std::string(key));
}

Error JsonNode::error(const std::string& why, ErrorCode code) const {
  return {code, why, *file_, value_->line, path_.text()};
}

Status JsonNode::expect(Kind kind) const {
  if (value_->kind == kind) return Done{};
  return error(std::string("expected ") + json_kind_name(kind) + ", found " + json_kind_name(value_->kind),
               ErrorCode::kParse);
}

Status JsonNode::expect_keys(std::initializer_list<std::string_view> known) const {
  if (Status s = expect(Kind::kObject); !s) return s;
  for (std::size_t i = 0; i < value_->members.size(); ++i) {
    const std::string& key = value_->members[i].first;
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    std::string names;
    for (const std::string_view name : known) names += (names.empty() ? "" : ", ") + std::string(name);
    return JsonNode(value_->members[i].second, path_, *file_)
        .error("unknown key '" + key.substr(0, 60) + "'; known here: " + names);
  }
  return Done{};
}

Result<JsonNode> JsonNode::at(std::string_view key) const {
  if (const JsonValue* found = value_->find(key)) return JsonNode(*found, path_.at(key), *file_);
  return error("the key '" + std::string(key) + "' is missing");
}

Result<double> JsonNode::number() const {
  if (Status s = expect(Kind::kNumber); !s) return s.error();
  if (!std::isfinite(value_->number)) return error("the number is not finite");
  return value_->number;
}

Result<std::string> JsonNode::text() const {
  if (Status s = expect(Kind::kString); !s) return s.error();
  return value_->text;
}

Result<bool> JsonNode::truth() const {
  if (Status s = expect(Kind::kBool); !s) return s.error();
  return value_->truth;
}

Status JsonNode::numbers(double* found, std::size_t count) const {
  if (Status s = expect(Kind::kArray); !s) return s;
  if (value_->items.size() != count) {
    return error("expected " + std::to_string(count) + " numbers, found " + std::to_string(value_->items.size()));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto x = item(i).number();
    if (!x) return x.error();
    found[i] = *x;
  }
  return Done{};
}

Status read_json(std::string_view text, const std::string& file, std::string_view streamed,
                 const std::function<Status(const std::string&, const JsonValue&, std::size_t)>& member) {
  Place place;
  Handler handler(file, place, streamed, member);
  const bool done = nlohmann::json::sax_parse(CountingIterator(text.data(), &place),
                                              CountingIterator(text.data() + text.size(), &place), &handler);
  if (handler.error()) return *handler.error();
  if (!done) return Error{ErrorCode::kParse, "not JSON", file, place.line};
  return Done{};
}

}  // namespace roadgen
