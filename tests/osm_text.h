// OSM files for tests: nodes in metres about an origin.
#pragma once

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "roadgen/geodesy/local_frame.h"

namespace roadgen::test {

using Tags = std::vector<std::pair<std::string, std::string>>;

class OsmText {
 public:
  static Georeference origin() { return {50, 11, 0}; }

  // Rounded to 1e-7 degree as in every OSM file, by up to 6 mm.
  OsmText& node(long id, double x_m, double y_m) {
    const Geodetic at = LocalFrame(origin()).to_geodetic({x_m, y_m, 0});
    return node_at(id, degrees(at.latitude_deg), degrees(at.longitude_deg));
  }
  OsmText& node_at(long id, const std::string& latitude, const std::string& longitude) {
    nodes_ +=
        "<node id=\"" + std::to_string(id) + "\" version=\"1\" lat=\"" + latitude + "\" lon=\"" + longitude + "\"/>\n";
    return *this;
  }
  OsmText& way(long id, const std::vector<long>& nodes, const Tags& tags) {
    ways_ += "<way id=\"" + std::to_string(id) + "\" version=\"1\">";
    for (const long node : nodes) ways_ += "<nd ref=\"" + std::to_string(node) + "\"/>";
    for (const auto& [key, value] : tags) ways_ += "<tag k=\"" + key + "\" v=\"" + value + "\"/>";
    ways_ += "</way>\n";
    return *this;
  }
  std::string text() const { return "<?xml version=\"1.0\"?>\n<osm version=\"0.6\">\n" + nodes_ + ways_ + "</osm>\n"; }

 private:
  static std::string degrees(double x) {
    char text[32];
    std::snprintf(text, sizeof text, "%.7f", x);
    return text;
  }
  std::string nodes_, ways_;
};

}  // namespace roadgen::test
