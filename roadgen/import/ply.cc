// The .ply format of point_cloud.h.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <vector>

#include "roadgen/import/point_cloud_sink.h"
#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

static_assert(std::endian::native == std::endian::little, "binary_little_endian values are copied as they are");

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct TypeName {
  std::string_view name;
  Type type;
};
constexpr TypeName kTypes[] = {
    {"char", Type::kInt8},   {"int8", Type::kInt8},     {"uchar", Type::kUint8},   {"uint8", Type::kUint8},
    {"short", Type::kInt16}, {"int16", Type::kInt16},   {"ushort", Type::kUint16}, {"uint16", Type::kUint16},
    {"int", Type::kInt32},   {"int32", Type::kInt32},   {"uint", Type::kUint32},   {"uint32", Type::kUint32},
    {"float", Type::kFloat}, {"float32", Type::kFloat}, {"double", Type::kDouble}, {"float64", Type::kDouble}};

constexpr std::size_t size_of(Type type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

std::optional<Type> type_of(std::string_view name) {
  for (const TypeName& known : kTypes) {
    if (known.name == name) return known.type;
  }
  return {};
}

// What a vertex's property means to us.
enum Role { kX, kY, kZ, kRadius, kRed, kGreen, kBlue, kOther };
Role role_of(std::string_view name) {
  constexpr std::string_view kNames[] = {"x", "y", "z", "radius", "red", "green", "blue"};
  for (int i = 0; i < kOther; ++i) {
    if (kNames[i] == name) return static_cast<Role>(i);
  }
  return kOther;
}

struct Property {
  Role role = kOther;
  Type type = Type::kFloat;
  std::optional<Type> count;  // of a list: the type of its length
};

struct PlyElement {
  bool vertex = false;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool ascii = true;
  std::vector<PlyElement> elements;
};

// Bytes and words of the file, from its beginning on.
class Source {
 public:
  Source(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  Error error(const std::string& why) const { return {ErrorCode::kParse, why, file_, line_}; }
  std::size_t left() const { return bytes_.size() - at_; }
  int line() const { return line_; }

  bool line(std::string_view& text) {
    if (at_ == bytes_.size()) return false;
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    text = trimmed(bytes_.substr(at_, end - at_));
    at_ = std::min(end + 1, bytes_.size());
    ++line_;
    return true;
  }

  // The next value; nothing at the end, or where it is not a number.
  std::optional<double> value(Type type, bool ascii) { return ascii ? word() : binary(type); }

 private:
  std::optional<double> word() {
    constexpr std::string_view kBlank = " \t\r\n";
    while (at_ < bytes_.size() && kBlank.find(bytes_[at_]) != kBlank.npos) line_ += bytes_[at_++] == '\n';
    const std::size_t end = std::min(bytes_.find_first_of(kBlank, at_), bytes_.size());
    const auto found = parse_number(bytes_.substr(at_, end - at_));
    at_ = end;
    return found;
  }

  template <class T>
  double copied() {
    T x;
    std::memcpy(&x, bytes_.data() + at_, sizeof x);
    at_ += sizeof x;
    return static_cast<double>(x);
  }
  std::optional<double> binary(Type type) {
    if (left() < size_of(type)) return {};
    switch (type) {
      case Type::kInt8: return copied<std::int8_t>();
      case Type::kUint8: return copied<std::uint8_t>();
      case Type::kInt16: return copied<std::int16_t>();
      case Type::kUint16: return copied<std::uint16_t>();
      case Type::kInt32: return copied<std::int32_t>();
      case Type::kUint32: return copied<std::uint32_t>();
      case Type::kFloat: return copied<float>();
      case Type::kDouble: return copied<double>();
    }
    return {};
  }

  std::string_view bytes_;
  std::string file_;
  std::size_t at_ = 0;
  int line_ = 0;
};

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> found;
  while (!line.empty() && found.size() < 8) {
    const std::size_t end = std::min(line.find_first_of(" \t"), line.size());
    if (end > 0) found.push_back(line.substr(0, end));
    line = line.substr(std::min(end + 1, line.size()));
  }
  return found;
}

// One line of the header after the first two. Errors: kParse.
Status add_to(Header& header, std::string_view line, const Source& source) {
  const std::vector<std::string_view> word = words(line);
  if (word.empty() || word[0] == "comment" || word[0] == "obj_info") return Done{};
  if (word[0] == "element" && word.size() == 3) {
    const auto count = parse_number(word[2]);
    if (!count || !(*count >= 0 && *count <= 1e15) || *count != std::floor(*count)) {
      return source.error("the number of elements must be an integer of 0 or more");
    }
    header.elements.push_back({word[1] == "vertex", static_cast<std::size_t>(*count), {}});
    return Done{};
  }
  const bool list = word[0] == "property" && word.size() == 5 && word[1] == "list";
  if (header.elements.empty() || !(list || (word[0] == "property" && word.size() == 3))) {
    return source.error("expected 'element NAME COUNT', 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  }
  const auto type = type_of(word[list ? 3 : 1]);
  const auto count = list ? type_of(word[2]) : std::optional<Type>();
  if (!type || (list && !count)) return source.error("an unknown type: char to uint32, float and double are known");
  if (header.elements.back().properties.size() == 256) return source.error("more than 256 properties");
  header.elements.back().properties.push_back({list ? kOther : role_of(word.back()), *type, count});
  return Done{};
}

Result<Header> parse_header(Source& source) {
  Header header;
  std::string_view line;
  if (!source.line(line) || line != "ply") return source.error("a .ply file begins with the line 'ply'");
  if (!source.line(line) || (line != "format ascii 1.0" && line != "format binary_little_endian 1.0")) {
    return source.error("expected 'format ascii 1.0' or 'format binary_little_endian 1.0'");
  }
  header.ascii = line == "format ascii 1.0";
  while (source.line(line)) {
    if (line == "end_header") return header;
    if (Status s = add_to(header, line, source); !s) return s.error();
  }
  return source.error("the header has no end: 'end_header' is missing");
}

// Reads one element's values; those that mean something to us go to `value`.
Status read_element(Source& source, const PlyElement& element, bool ascii, double* value) {
  const auto cut = [&] { return source.error("the data end early, or hold what is not a number"); };
  for (const Property& property : element.properties) {
    if (property.count) {
      const auto length = source.value(*property.count, ascii);
      if (!length || !(*length >= 0 && *length <= static_cast<double>(source.left()))) return cut();
      for (double i = 0; i < *length; ++i) {
        if (!source.value(property.type, ascii)) return cut();
      }
    } else {
      const auto found = source.value(property.type, ascii);
      if (!found) return cut();
      value[property.role] = *found;
    }
  }
  return Done{};
}

bool has(const PlyElement& element, Role role) {
  for (const Property& property : element.properties) {
    if (property.role == role) return true;
  }
  return false;
}

// A colour's value to 0 to 255.
std::uint8_t to_byte(double value, Type type) {
  const double full = type == Type::kFloat || type == Type::kDouble ? 255 * value : value;
  return full > 0 ? static_cast<std::uint8_t>(std::lround(std::min(full, 255.0))) : std::uint8_t{0};
}

}  // namespace

Result<SphereSet> parse_ply(std::string_view bytes, const std::string& file, const PointCloudOptions& options) {
  Source source(bytes, file);
  const auto header = parse_header(source);
  if (!header) return header.error();
  for (const PlyElement& element : header->elements) {
    double value[kOther + 1] = {0, 0, 0, options.radius, 0, 0, 0, 0};
    if (!element.vertex) {
      // One without values would be passed over a count of times that nothing bounds.
      if (element.properties.empty()) continue;
      for (std::size_t i = 0; i < element.count; ++i) {
        if (Status s = read_element(source, element, header->ascii, value); !s) return s.error();
      }
      continue;
    }
    if (!has(element, kX) || !has(element, kY) || !has(element, kZ)) {
      return Error{ErrorCode::kParse, "its vertices must have the properties x, y and z", file};
    }
    if (!has(element, kRadius) && !(options.radius > 0)) {
      return Error{ErrorCode::kData, "its vertices have no property 'radius': give a radius for all", file};
    }
    Type color = Type::kUint8;
    const bool colored = has(element, kRed) && has(element, kGreen) && has(element, kBlue);
    for (const Property& property : element.properties) {
      if (property.role == kRed) color = property.type;
    }
    PointCloudSink sink(file);
    for (std::size_t i = 0; i < element.count; ++i) {
      if (Status s = read_element(source, element, header->ascii, value); !s) return s.error();
      const auto byte = [&](Role role) { return colored ? to_byte(value[role], color) : std::uint8_t{255}; };
      if (Status s = sink.add({value[kX], value[kY], value[kZ]}, value[kRadius],
                              {byte(kRed), byte(kGreen), byte(kBlue), 255}, header->ascii ? source.line() : 0);
          !s) {
        return s.error();
      }
    }
    return sink.finish();
  }
  return Error{ErrorCode::kParse, "has no element 'vertex'", file};
}

}  // namespace roadgen
