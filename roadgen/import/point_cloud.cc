#include "roadgen/import/point_cloud.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include <glm/common.hpp>

#include "roadgen/import/point_cloud_sink.h"
#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

struct KnownElement {
  std::string_view symbol;
  float radius;
  std::uint32_t color;
};
constexpr KnownElement kElements[] = {
    {"H", 1.20f, 0xFFFFFF},  {"HE", 1.40f, 0xD9FFFF}, {"LI", 1.82f, 0xCC80FF}, {"C", 1.70f, 0x909090},
    {"N", 1.55f, 0x3050F8},  {"O", 1.52f, 0xFF0D0D},  {"F", 1.47f, 0x90E050},  {"NE", 1.54f, 0xB3E3F5},
    {"NA", 2.27f, 0xAB5CF2}, {"MG", 1.73f, 0x8AFF00}, {"AL", 1.84f, 0xBFA6A6}, {"SI", 2.10f, 0xF0C8A0},
    {"P", 1.80f, 0xFF8000},  {"S", 1.80f, 0xFFFF30},  {"CL", 1.75f, 0x1FF01F}, {"AR", 1.88f, 0x80D1E3},
    {"K", 2.75f, 0x8F40D4},  {"CA", 2.31f, 0x3DFF00}, {"NI", 1.63f, 0x50D050}, {"CU", 1.40f, 0xC88033},
    {"ZN", 1.39f, 0x7D80B0}, {"SE", 1.90f, 0xFFA100}, {"BR", 1.85f, 0xA62929}, {"KR", 2.02f, 0x5CB8D1},
    {"AG", 1.72f, 0xC0C0C0}, {"CD", 1.58f, 0xFFD98F}, {"I", 1.98f, 0x940094},  {"XE", 2.16f, 0x429EB0},
    {"PT", 1.75f, 0xD0D0E0}, {"AU", 1.66f, 0xFFD123}, {"HG", 1.55f, 0xB8B8D0}, {"PB", 2.02f, 0x575961},
};

// The lines of a text, without their ends.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool next(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = rest_.find('\n');
    line = rest_.substr(0, end);
    rest_ = end == rest_.npos ? std::string_view() : rest_.substr(end + 1);
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++number_;
    return true;
  }
  int number() const { return number_; }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  int number_ = 0;
};

// The next word of a line, which it is taken from; empty at its end.
std::string_view word(std::string_view& line) {
  constexpr std::string_view kBlank = " \t";
  const std::size_t first = line.find_first_not_of(kBlank);
  if (first == line.npos) return line = {};
  const std::size_t end = std::min(line.find_first_of(kBlank, first), line.size());
  const std::string_view found = line.substr(first, end - first);
  line = line.substr(end);
  return found;
}

Result<SphereSet> parse_xyzr(std::string_view text, const std::string& file) {
  PointCloudSink sink(file);
  Lines lines(text);
  for (std::string_view line; lines.next(line);) {
    line = trimmed(line);
    if (line.empty() || line.front() == '#') continue;
    double number[4];
    for (double& x : number) {
      const std::string_view cell = word(line);
      const auto value = parse_number(cell);
      if (!value) {
        return Error{ErrorCode::kParse,
                     cell.empty() ? "expected x y z radius [element], the line ends before"
                                  : "'" + std::string(cell.substr(0, 40)) + "' is not a number",
                     file, lines.number()};
      }
      x = *value;
    }
    const std::string_view symbol = word(line);
    const Element of = symbol.empty() ? Element{0, {255, 255, 255, 255}} : element(symbol);
    if (Status s = sink.add({number[0], number[1], number[2]}, number[3], of.color, lines.number()); !s) {
      return s.error();
    }
  }
  return sink.finish();
}

// The element of an atom's record: columns 77 and 78, or in older files the letters of the atom's name, which begin in
// column 13 only where the symbol has two.
std::string_view element_of(std::string_view line) {
  const std::string_view symbol = line.size() >= 78 ? trimmed(line.substr(76, 2)) : std::string_view();
  if (!symbol.empty()) return symbol;
  const std::string_view two = line.size() >= 14 ? line.substr(12, 2) : std::string_view();
  if (two.size() == 2 && std::isalpha(static_cast<unsigned char>(two[0]))) return two;
  return two.size() == 2 ? two.substr(1) : two;
}

Result<SphereSet> parse_pdb(std::string_view text, const std::string& file) {
  PointCloudSink sink(file);
  Lines lines(text);
  char location = ' ';
  for (std::string_view line; lines.next(line);) {
    if (line.starts_with("ENDMDL")) break;
    if (!line.starts_with("ATOM  ") && !line.starts_with("HETATM")) continue;
    double number[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string_view cell = line.size() > 30 + 8 * i ? line.substr(30 + 8 * i, 8) : std::string_view();
      const auto value = parse_number(cell);
      if (!value) {
        return Error{ErrorCode::kParse, "columns 31 to 54 must have three coordinates of 8 columns each", file,
                     lines.number()};
      }
      number[i] = *value;
    }
    const char alternate = line.size() > 16 ? line[16] : ' ';
    if (alternate != ' ') {
      if (location == ' ') location = alternate;
      if (alternate != location) continue;
    }
    const Element of = element(element_of(line));
    if (Status s =
            sink.add({number[0], number[1], number[2]}, static_cast<double>(of.radius), of.color, lines.number());
        !s) {
      return s.error();
    }
  }
  return sink.finish();
}

}  // namespace

Element element(std::string_view symbol) {
  const auto same = [&](const KnownElement& known) {
    return known.symbol.size() == symbol.size() &&
           std::equal(symbol.begin(), symbol.end(), known.symbol.begin(),
                      [](unsigned char a, unsigned char b) { return std::toupper(a) == b; });
  };
  const auto* const found = std::find_if(std::begin(kElements), std::end(kElements), same);
  if (found == std::end(kElements)) return {};
  const auto byte = [&](int shift) { return static_cast<std::uint8_t>(found->color >> shift & 0xFF); };
  return {found->radius, {byte(16), byte(8), byte(0), 255}};
}

Status PointCloudSink::add(glm::dvec3 center, double radius, std::array<std::uint8_t, 4> color, int line) {
  const auto refuse = [&](const char* why) { return Error{ErrorCode::kData, why, file_, line}; };
  if (!(std::abs(center.x) <= kFarthest && std::abs(center.y) <= kFarthest && std::abs(center.z) <= kFarthest)) {
    return refuse("a coordinate is not finite, or beyond 1e9");
  }
  if (!(radius > 0 && radius <= kFarthest)) return refuse("the radius must be greater than 0");
  if (set_.items.size() == kMostPoints) return refuse("more than 50 million points; divide the file");
  if (set_.items.empty()) origin_ = center;  // so that the floats are small
  low_ = set_.items.empty() ? center : glm::min(low_, center);
  high_ = set_.items.empty() ? center : glm::max(high_, center);
  set_.items.push_back({glm::vec3(center - origin_), static_cast<float>(radius), color});
  return Done{};
}

Result<SphereSet> PointCloudSink::finish() {
  if (set_.items.empty()) return Error{ErrorCode::kData, "has no points", file_};
  const glm::dvec3 middle = 0.5 * (low_ + high_);
  for (SphereSet::Item& item : set_.items) {
    item.center = glm::vec3(glm::dvec3(item.center) + (origin_ - middle));
  }
  set_.origin_m = middle;
  set_.name = std::filesystem::path(file_).filename().string();
  return std::move(set_);
}

Result<SphereSet> parse_point_cloud(std::string_view bytes, const std::string& file, const PointCloudOptions& options) {
  std::string ending = std::filesystem::path(file).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".xyzr") return parse_xyzr(bytes, file);
  if (ending == ".pdb") return parse_pdb(bytes, file);
  if (ending == ".ply") return parse_ply(bytes, file, options);
  return Error{ErrorCode::kUsage, "point clouds are .pdb, .xyzr or .ply files", file};
}

Result<SphereSet> read_point_cloud(const std::string& path, const PointCloudOptions& options) {
  const auto bytes = read_file(path, std::uintmax_t{1} << 31);
  if (!bytes) return bytes.error();
  return parse_point_cloud(*bytes, path, options);
}

}  // namespace roadgen
