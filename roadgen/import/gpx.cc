#include "roadgen/import/gpx.h"

#include <cmath>
#include <cstring>
#include <pugixml.hpp>

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

class Reader {
 public:
  Reader(std::string_view text, const std::string& file, Diagnostics& diagnostics)
      : text_(text), lines_(text), file_(file), diagnostics_(diagnostics) {}

  Result<std::vector<Track>> read();

 private:
  Error error(pugi::xml_node node, const std::string& message) const {
    return {ErrorCode::kParse, message, file_, lines_.line(node.offset_debug())};
  }
  Result<double> number(pugi::xml_node node, const char* value, const std::string& what) const;
  Result<TrackPoint> read_point(pugi::xml_node node) const;
  Status read_line(pugi::xml_node line, const char* point_name, const std::string& element, const std::string& name);
  Status read_track(pugi::xml_node node, int number);

  std::string_view text_;
  LineIndex lines_;
  const std::string& file_;
  Diagnostics& diagnostics_;
  std::vector<Track> tracks_;
};

Result<double> Reader::number(pugi::xml_node node, const char* value, const std::string& what) const {
  const std::optional<double> parsed = parse_number(value);
  if (!parsed) return error(node, what + " '" + std::string(value).substr(0, 40) + "' is not a number");
  return *parsed;
}

Result<TrackPoint> Reader::read_point(pugi::xml_node node) const {
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
  point.line = lines_.line(node.offset_debug());
  return point;
}

Status Reader::read_line(pugi::xml_node line, const char* point_name, const std::string& element,
                         const std::string& name) {
  Track track{file_, element, name.empty() ? element : name, true, is(line, "trkseg")};
  int first_bad = 0, bad = 0;
  for (const pugi::xml_node node : line.children()) {
    if (!is(node, point_name)) continue;
    Result<TrackPoint> point = read_point(node);
    if (!point) return point.error();
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
  return std::move(tracks_);
}

}  // namespace

Result<std::vector<Track>> parse_gpx(std::string_view text, const std::string& file, Diagnostics& diagnostics) {
  return Reader(text, file, diagnostics).read();
}

Result<std::vector<Track>> read_gpx(const std::string& path, Diagnostics& diagnostics) {
  const Result<std::string> text = read_file(path);
  if (!text) return text.error();
  return parse_gpx(*text, path, diagnostics);
}

}  // namespace roadgen
