// The bytes of a fuzz target as a file, for readers that take a path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "tests/temporary_folder.h"

namespace roadgen::test {

class InputFile {
 public:
  // name: of the file, with the ending that the reader looks for.
  explicit InputFile(std::string name) : name_(std::move(name)) {}

  std::string path() const { return folder_.path(name_); }

  // Replaces the content and returns the path.
  std::string put(const std::uint8_t* data, std::size_t size) const {
    return folder_.put(name_, std::string_view(reinterpret_cast<const char*>(data), size));
  }

 private:
  TemporaryFolder folder_;
  std::string name_;
};

}  // namespace roadgen::test
