#include "roadgen/import/gpx.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <pugixml.hpp>
#include <set>

#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

// The tag's name without its namespace prefix.
const char* local_name(pugi::xml_node node) {
  const char* colon = std::strrchr(node.name(), ':');
  return colon ? colon + 1 : node.name();
}

bool is(pugi::xml_node node, const char* name) { return !std::strcmp(local_name(node), name); }

pugi::xml_node child(pugi::xml_node node, const char* name) {
  return node.find_child([&](pugi::xml_node n) { return is(n, name); });
}

bool is_named(pugi::xml_node node, const std::string& name) {
  const std::string_view own = local_name(node);
  return std::equal(own.begin(), own.end(), name.begin(), name.end(),
                    [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
}

// The element of that name of a point, segment, track or route, or of its extensions.
pugi::xml_node field(pugi::xml_node node, const std::string& name) {
  if (name.empty()) return {};
  const auto named = [&](pugi::xml_node n) { return is_named(n, name); };
  const pugi::xml_node own = node.find_child(named);
  return own ? own : child(node, "extensions").find_node(named);
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& file, const FieldNames& fields, Diagnostics& diagnostics)
      : text_(text), lines_(text), file_(file), fields_(fields), diagnostics_(diagnostics) {}

  Result<std::vector<Track>> read();

 private:
  Error error(pugi::xml_node node, const std::string& message) const {
    return {ErrorCode::kParse, message, file_, lines_.line(node.offset_debug())};
  }
  Result<double> number(pugi::xml_node node, const char* value, const std::string& what) const;
  Result<TrackPoint> read_point(pugi::xml_node node, const Track& of);
  Status read_line(pugi::xml_node line, const char* point_name, const std::string& element, const std::string& name);
  // The first of a node and those that hold it that has a field which the caller names. Cost: O(children).
  pugi::xml_node given(pugi::xml_node node, const std::string& name);
  // A field's number; none, told once of a track, where it is not one.
  std::optional<double> number_of(pugi::xml_node field, const std::string& name, const std::string& element);
  Status check_fields() const;
  Status read_track(pugi::xml_node node, int number);

  std::string_view text_;
  LineIndex lines_;
  const std::string& file_;
  const FieldNames& fields_;
  Diagnostics& diagnostics_;
  std::set<std::string> met_;   // of the names in fields_
  std::set<std::string> told_;  // elements of which one is not a number
  std::vector<Track> tracks_;
};

pugi::xml_node Reader::given(pugi::xml_node node, const std::string& name) {
  for (pugi::xml_node at = node; at && !is(at, "gpx"); at = at.parent()) {
    if (const pugi::xml_node found = field(at, name)) return found;
  }
  return {};
}

std::optional<double> Reader::number_of(pugi::xml_node field, const std::string& name, const std::string& element) {
  if (!field) return {};
  met_.insert(name);
  const std::optional<double> value = parse_number(field.text().get());
  if (value && std::isfinite(*value)) return value;
  if (*field.text().get() && told_.insert(element + ' ' + name).second) {
    diagnostics_.push_back({Severity::kWarning, "the element " + name + " is not a number: the default is used", file_,
                            lines_.line(field.offset_debug()), element});
  }
  return {};
}

Status Reader::check_fields() const {
  for (const std::string* name : {&fields_.width, &fields_.lanes, &fields_.height, &fields_.name}) {
    if (!name->empty() && !met_.contains(*name)) {
      return Error{ErrorCode::kData, "has no element '" + *name + "'", file_};
    }
  }
  return Done{};
}

Result<double> Reader::number(pugi::xml_node node, const char* value, const std::string& what) const {
  const std::optional<double> parsed = parse_number(value);
  if (!parsed) return error(node, what + " '" + std::string(value).substr(0, 40) + "' is not a number");
  return *parsed;
}

Result<TrackPoint> Reader::read_point(pugi::xml_node node, const Track& of) {
  for (const char* name : {"lat", "lon"}) {
    if (!node.attribute(name)) return error(node, std::string("<") + node.name() + "> lacks the attribute " + name);
  }
  const Result<double> latitude = number(node, node.attribute("lat").value(), "latitude");
  if (!latitude) return latitude.error();
  const Result<double> longitude = number(node, node.attribute("lon").value(), "longitude");
  if (!longitude) return longitude.error();
  TrackPoint point{*longitude, *latitude};
  if (const pugi::xml_node height = child(node, "ele"); height && *height.text().get()) {
    const Result<double> value = number(height, height.text().get(), "elevation");
    if (!value) return value.error();
    if (!std::isnan(*value)) point.height_m = *value;
  }
  if (const auto height = number_of(field(node, fields_.height), fields_.height, of.element)) point.height_m = height;
  point.width_m = number_of(field(node, fields_.width), fields_.width, of.element);
  point.line = lines_.line(node.offset_debug());
  return point;
}

Status Reader::read_line(pugi::xml_node line, const char* point_name, const std::string& element,
                         const std::string& name) {
  Track track{file_, element, name.empty() ? element : name, true, is(line, "trkseg")};
  if (const pugi::xml_node own = given(line, fields_.name)) {
    met_.insert(fields_.name);
    if (*own.text().get()) track.name = own.text().get();
  }
  if (const auto lanes = number_of(given(line, fields_.lanes), fields_.lanes, element)) {
    track.lanes = lane_count(*lanes, file_, lines_.line(line.offset_debug()), element, diagnostics_);
  }
  const auto height = number_of(given(line, fields_.height), fields_.height, element);
  const auto width = number_of(given(line, fields_.width), fields_.width, element);
  int first_bad = 0, bad = 0;
  for (const pugi::xml_node node : line.children()) {
    if (!is(node, point_name)) continue;
    Result<TrackPoint> point = read_point(node, track);
    if (!point) return point.error();
    if (!point->height_m) point->height_m = height;
    if (!point->width_m) point->width_m = width;
    if (!std::isfinite(point->x) || !std::isfinite(point->y)) {
      if (bad++ == 0) first_bad = point->line;
      continue;
    }
    point->index = static_cast<int>(track.points.size()) + 1;
    track.points.push_back(*point);
  }
  if (bad > 0) {
    diagnostics_.push_back(
        {Severity::kWarning,
         "position not finite: " + std::to_string(bad) + (bad == 1 ? " point" : " points, first here,") + " left out",
         file_, first_bad, element});
  }
  if (!track.points.empty()) tracks_.push_back(std::move(track));
  return Done{};
}

Status Reader::read_track(pugi::xml_node node, int number) {
  const std::string name = child(node, "name").text().get();
  int count = 0, segment = 0;
  for (const pugi::xml_node part : node.children()) count += is(part, "trkseg");
  for (const pugi::xml_node part : node.children()) {
    if (!is(part, "trkseg")) continue;
    ++segment;
    const std::string suffix = count > 1 ? " segment " + std::to_string(segment) : "";
    const std::string element = "track " + std::to_string(number) + suffix;
    Status status = read_line(part, "trkpt", element, name.empty() ? "" : name + suffix);
    if (!status) return status;
  }
  return Done{};
}

Result<std::vector<Track>> Reader::read() {
  if (Status status = check_utf8(text_, file_); !status) return status.error();
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text_.data(), text_.size());
  if (!parsed) {
    return Error{ErrorCode::kParse, std::string("is not well-formed XML (truncated?): ") + parsed.description(), file_,
                 lines_.line(parsed.offset)};
  }
  const pugi::xml_node root = child(document, "gpx");
  if (!root) return Error{ErrorCode::kParse, "is not GPX: there is no <gpx> element", file_, 1};

  int tracks = 0, routes = 0;
  for (const pugi::xml_node node : root.children()) {
    Status status = Done{};
    if (is(node, "trk")) status = read_track(node, ++tracks);
    if (is(node, "rte")) {
      status = read_line(node, "rtept", "route " + std::to_string(++routes), child(node, "name").text().get());
    }
    if (!status) return status.error();
  }
  if (tracks_.empty()) return Error{ErrorCode::kData, "holds no track and no route with points", file_};
  if (Status status = check_fields(); !status) return status.error();
  return std::move(tracks_);
}

}  // namespace

Result<std::vector<Track>> parse_gpx(std::string_view text, const std::string& file, const FieldNames& fields,
                                     Diagnostics& diagnostics) {
  return Reader(text, file, fields, diagnostics).read();
}

Result<std::vector<Track>> read_gpx(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics) {
  const Result<std::string> text = read_file(path);
  if (!text) return text.error();
  return parse_gpx(*text, path, fields, diagnostics);
}

}  // namespace roadgen
