// Whole input files as text, with the checks that every text format wants.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/road/result.h"

namespace roadgen {

// Larger files are refused, so that memory stays bounded however often a file repeats its elements: what a reader makes
// of one is some twenty times as large at worst.
inline constexpr std::uintmax_t kMostText_bytes = std::uintmax_t{1} << 29;

// Errors: kIo where there is no file or it is a folder; kParse where it is empty.
Status check_is_file(const std::string& path);

// The bytes of a regular file. Errors: kIo where it is missing, a folder or unreadable; kParse where it is empty; kData
// where it is larger than most_bytes.
Result<std::string> read_file(const std::string& path, std::uintmax_t most_bytes = kMostText_bytes);

// Gives the memory of bytes begin to end, which are no longer read, back to the system but for broken pages; they are
// then 0.
void forget(std::string& text, std::size_t begin, std::size_t end);

// Error kParse with the line of the first byte that is not UTF-8, or of the first NUL.
Status check_utf8(std::string_view text, const std::string& file);

// Lines of a text by byte offset. Cost: O(size) to make, O(log lines) to ask.
class LineIndex {
 public:
  explicit LineIndex(std::string_view text);
  int line(std::ptrdiff_t offset) const;  // 1-based; negative offsets count as 0

 private:
  std::vector<std::ptrdiff_t> newlines_;
};

// A number in C notation with nothing else but blanks around it, whatever the locale; nan and inf are numbers.
std::optional<double> parse_number(std::string_view text);

// The text without blanks, tabs and carriage returns at both ends.
std::string_view trimmed(std::string_view text);

}  // namespace roadgen
