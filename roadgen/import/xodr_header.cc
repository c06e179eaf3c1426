#include "roadgen/import/xodr_header.h"

#include <map>
#include <pugixml.hpp>

#include "roadgen/geodesy/local_frame.h"

namespace roadgen {
namespace {

constexpr std::string_view kBlank = " \t\r\n";

std::string without_blanks_around(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlank);
  return first == text.npos ? "" : std::string(text.substr(first, text.find_last_not_of(kBlank) - first + 1));
}

// The parameters of a PROJ string.
std::map<std::string, std::string> parameters(std::string_view proj) {
  std::map<std::string, std::string> found;
  while (!(proj = proj.substr(std::min(proj.find_first_not_of(kBlank), proj.size()))).empty()) {
    std::string_view word = proj.substr(0, proj.find_first_of(kBlank));
    proj.remove_prefix(word.size());
    if (word.starts_with('+')) word.remove_prefix(1);
    const std::size_t equals = std::min(word.find('='), word.size());
    found[std::string(word.substr(0, equals))] = word.substr(std::min(equals + 1, word.size()));
  }
  return found;
}

// The origin, where the string is the orthographic projection of WGS84 about it and nothing else: the file format's
// nearest to a topocentric frame (roadgen/export/opendrive.h).
std::optional<Georeference> topocentric(std::string_view proj) {
  std::map<std::string, std::string> all = parameters(proj);
  if (all["proj"] != "ortho") return {};
  Georeference origin;
  for (const auto& [key, value] : all) {
    const std::optional<double> x = parse_number(value);
    if (key == "lat_0" && x)
      origin.latitude_deg = *x;
    else if (key == "lon_0" && x)
      origin.longitude_deg = *x;
    else if (!(key == "proj" || key == "no_defs" || key == "type" || (key == "units" && value == "m") ||
               ((key == "ellps" || key == "datum") && value == "WGS84") ||
               ((key == "x_0" || key == "y_0") && x == 0.0)))
      return {};
  }
  return check_georeference(origin) ? std::optional(origin) : std::nullopt;
}

std::optional<Georeference> read_georeference(XodrSource& source, const pugi::xml_node& header) {
  const pugi::xml_node node = header.child("geoReference"), offset = header.child("offset");
  Georeference found;
  if (const std::vector<double> own = numbers_in(user_data(header, "roadgen:origin")); own.size() == 3) {
    found = {own[0], own[1], own[2]};
    if (const Status status = check_georeference(found); !status) {
      source.fail(ErrorCode::kParse, node, status.error().message);
    }
    return found;
  }
  found.offset_m = {source.number_or(offset, "x", 0), source.number_or(offset, "y", 0)};
  found.height_m = source.number_or(offset, "z", 0);
  found.offset_heading_rad = source.number_or(offset, "hdg", 0);
  found.projection = without_blanks_around(node.text().get());
  const bool moved = found.offset_m != glm::dvec2(0, 0) || found.height_m != 0 || found.offset_heading_rad != 0;
  if (source.failed()) return {};
  if (found.projection.empty()) {
    if (moved) source.note(offset, "an <offset> without a geoReference is not kept");
    return {};
  }
  if (!moved) {
    if (auto origin = topocentric(found.projection)) return origin;
  }
  if (const Status status = check_georeference(found); !status) {
    source.note(node,
                "the geoReference is not kept, so the network has no place on the Earth: " + status.error().message);
    return {};
  }
  const Geodetic origin = LocalFrame(found).to_geodetic({0, 0, 0});
  if (std::abs(origin.latitude_deg) <= 90 && std::abs(origin.longitude_deg) <= 180) {
    found.latitude_deg = origin.latitude_deg, found.longitude_deg = origin.longitude_deg;
  }
  return found;
}

}  // namespace

XodrHeader read_header(XodrSource& source, const pugi::xml_node& node) {
  XodrHeader header;
  if (source.number(node, "revMajor") != 1 && !source.failed()) {
    source.fail(ErrorCode::kData, node, "an OpenDRIVE version other than 1.x is not supported yet");
  }
  header.name = node.attribute("name").value();
  if (!source.failed()) header.georeference = read_georeference(source, node);
  note_others(source, node, "the header", {"geoReference", "offset", "userData"});
  return header;
}

}  // namespace roadgen
