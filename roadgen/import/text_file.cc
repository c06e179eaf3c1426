#include "roadgen/import/text_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace roadgen {
namespace {

namespace fs = std::filesystem;

// Length of the UTF-8 sequence at the start of text, or 0. Source: Unicode 15, table 3-7 (well-formed
// sequences).
std::size_t sequence_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto is_tail = [&](std::size_t i) { return byte(i) >= 0x80 && byte(i) <= 0xBF; };
  const unsigned lead = byte(0), second = byte(1);
  if (lead != 0 && lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return is_tail(1) ? 2 : 0;
  if (lead >= 0xE0 && lead <= 0xEF) {
    const bool overlong = lead == 0xE0 && second < 0xA0, surrogate = lead == 0xED && second > 0x9F;
    return is_tail(1) && is_tail(2) && !overlong && !surrogate ? 3 : 0;
  }
  if (lead >= 0xF0 && lead <= 0xF4) {
    const bool overlong = lead == 0xF0 && second < 0x90, beyond = lead == 0xF4 && second > 0x8F;
    return is_tail(1) && is_tail(2) && is_tail(3) && !overlong && !beyond ? 4 : 0;
  }
  return 0;
}

}  // namespace

Status check_is_file(const std::string& path) {
  std::error_code failed;
  const fs::file_status status = fs::status(path, failed);
  if (status.type() == fs::file_type::not_found) return Error{ErrorCode::kIo, "no such file; check the path", path};
  if (fs::is_directory(status)) return Error{ErrorCode::kIo, "is a folder; name a file in it", path};
  if (failed) return Error{ErrorCode::kIo, "cannot be read: " + failed.message(), path};
  if (fs::is_regular_file(status) && fs::file_size(path, failed) == 0 && !failed) {
    return Error{ErrorCode::kParse, "is empty", path};
  }
  return Done{};
}

Result<std::string> read_file(const std::string& path, std::uintmax_t most_bytes) {
  if (Status status = check_is_file(path); !status) return status.error();
  std::ifstream stream(path, std::ios::binary);
  if (!stream) return Error{ErrorCode::kIo, std::string("cannot be read: ") + std::strerror(errno), path};
  // At once where the size is known, and what there is beyond it.
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(path, unknown);
  const auto too_large = [&] {
    return Error{ErrorCode::kData, "is larger than " + std::to_string(most_bytes >> 20) + " MiB; divide it", path};
  };
  if (!unknown && size > most_bytes) return too_large();
  std::string text(unknown ? 0 : size, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  for (char block[4096]; stream.read(block, sizeof block) || stream.gcount() > 0;) {
    text.append(block, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > most_bytes) return too_large();
  }
  if (stream.bad()) return Error{ErrorCode::kIo, "cannot be read to its end", path};
  if (text.empty()) return Error{ErrorCode::kParse, "is empty", path};
  return text;
}

void forget(std::string& text, std::size_t begin, std::size_t end) {
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto start = reinterpret_cast<std::uintptr_t>(text.data());
  const std::uintptr_t from = (start + begin + page - 1) / page * page, to = (start + end) / page * page;
  if (from < to) ::madvise(reinterpret_cast<void*>(from), to - from, MADV_DONTNEED);
}

Status check_utf8(std::string_view text, const std::string& file) {
  for (std::size_t at = 0; at < text.size();) {
    // Eight bytes of ASCII at a time: none has its highest bit, or is 0, where a 1 would be borrowed into that bit.
    std::uint64_t eight = 0;
    if (text.size() - at >= sizeof eight) {
      std::memcpy(&eight, text.data() + at, sizeof eight);
      if (((eight | (eight - 0x0101010101010101u)) & 0x8080808080808080u) == 0) {
        at += sizeof eight;
        continue;
      }
    }
    const std::size_t length = sequence_length(text.substr(at));
    if (length == 0) {
      return Error{ErrorCode::kParse, "is not UTF-8 text: save it as UTF-8, or check that it is the right file", file,
                   LineIndex(text).line(static_cast<std::ptrdiff_t>(at))};
    }
    at += length;
  }
  return Done{};
}

LineIndex::LineIndex(std::string_view text) {
  for (std::size_t at = text.find('\n'); at != text.npos; at = text.find('\n', at + 1)) {
    newlines_.push_back(static_cast<std::ptrdiff_t>(at));
  }
}

int LineIndex::line(std::ptrdiff_t offset) const {
  return 1 + static_cast<int>(std::lower_bound(newlines_.begin(), newlines_.end(), offset) - newlines_.begin());
}

std::optional<double> parse_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+')) {
    text.remove_prefix(1);
    if (text.starts_with('-')) return {};
  }
  if (text.empty()) return {};
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

}  // namespace roadgen
