// Errors and diagnostics of roadgen: values, never exceptions.
//
// A function that can meet bad data returns Result<T>: the value or one Error. A function that reads a whole file also
// fills Diagnostics with every record that it repaired, dropped or could not honour. Programming errors assert.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace roadgen {

// What kind of fault; also the exit code of the command line: usage 2, everything else 1.
enum class ErrorCode { kUsage, kIo, kParse, kData, kGeometry, kContext, kShader };

// One line for the user: what, where, what to do.
struct Error {
  ErrorCode code = ErrorCode::kData;
  std::string message;       // what is wrong and what to do; no newline
  std::string file = {};     // the file it was found in, or empty
  int line = 0;              // 1-based, or 0 where there is none
  std::string element = {};  // id of the road, feature or record, or empty

  // "FILE:LINE: ELEMENT: MESSAGE", leaving out what is not known.
  std::string text() const;
};

enum class Severity { kInfo, kWarning, kError };

// A finding about the input that did not stop the work.
struct Diagnostic {
  Severity severity = Severity::kWarning;
  std::string message;
  std::string file = {};
  int line = 0;
  std::string element = {};

  std::string text() const;
};
using Diagnostics = std::vector<Diagnostic>;

// "info", "warning" or "error".
const char* severity_name(Severity severity);

// A value or an Error. Requires: value() only where ok(), error() only where not.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : held_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : held_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return held_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() & {
    assert(ok());
    return *std::get_if<0>(&held_);
  }
  const T& value() const& {
    assert(ok());
    return *std::get_if<0>(&held_);
  }
  T&& value() && {
    assert(ok());
    return std::move(*std::get_if<0>(&held_));
  }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  const Error& error() const {
    assert(!ok());
    return *std::get_if<1>(&held_);
  }

 private:
  std::variant<T, Error> held_;
};

// For functions that only succeed or fail: Status{Done{}} or an Error.
struct Done {};
using Status = Result<Done>;

}  // namespace roadgen
