#include "roadgen/export/opendrive.h"

#include <charconv>
#include <cmath>
#include <set>
#include <string_view>

#include "roadgen/export/atomic_file.h"

namespace roadgen {
namespace {

// Appends to a text; XML by hand, since the file's form is fixed and attribute order is part of being
// identical.
class Writer {
 public:
  Writer& raw(std::string_view text) {
    text_ += text;
    return *this;
  }
  // name="x", shortest digits that bring the same double back, whatever the locale.
  Writer& number(const char* name, double x) {
    text_ += ' ';
    text_ += name;
    text_ += "=\"";
    digits(x);
    text_ += '"';
    return *this;
  }
  Writer& text(const char* name, std::string_view value) {
    text_ += ' ';
    text_ += name;
    text_ += "=\"";
    for (const char c : value) escape(c);
    text_ += '"';
    return *this;
  }
  void digits(double x) {
    char buffer[32];
    const auto end = std::to_chars(buffer, buffer + sizeof buffer, x == 0 ? 0.0 : x).ptr;  // no "-0"
    text_.append(buffer, end);
  }
  std::string take() { return std::move(text_); }

 private:
  void escape(char c) {
    switch (c) {
      case '&': text_ += "&amp;"; break;
      case '<': text_ += "&lt;"; break;
      case '>': text_ += "&gt;"; break;
      case '"': text_ += "&quot;"; break;
      case '\n':
      case '\r':
      case '\t': text_ += ' '; break;
      default:
        if (static_cast<unsigned char>(c) >= 0x20) text_ += c;  // XML 1.0 has no other control characters
    }
  }

  std::string text_;
};

void write_cubic(Writer& out, const Cubic& c) {
  out.number("a", c.c0).number("b", c.c1).number("c", c.c2).number("d", c.c3).raw("/>\n");
}

void write_header(Writer& out, const Network& network) {
  out.raw("  <header revMajor=\"1\" revMinor=\"7\"").text("name", network.name).raw(" version=\"1.00\"");
  if (const Bounds b = bounds(network); !b.empty()) {
    out.number("north", b.high_m.y).number("south", b.low_m.y).number("east", b.high_m.x).number("west", b.low_m.x);
  }
  out.raw(" vendor=\"roadgen\"");
  if (!network.georeference) {
    out.raw("/>\n");
    return;
  }
  const Georeference& origin = *network.georeference;
  out.raw(">\n    <geoReference><![CDATA[+proj=ortho +lat_0=").digits(origin.latitude_deg);
  out.raw(" +lon_0=").digits(origin.longitude_deg);
  out.raw(" +x_0=0 +y_0=0 +ellps=WGS84 +units=m +no_defs]]></geoReference>\n");
  out.raw("    <userData code=\"roadgen:origin\" value=\"").digits(origin.latitude_deg);
  out.raw(" ").digits(origin.longitude_deg);
  out.raw(" ").digits(origin.height_m);
  out.raw("\"/>\n  </header>\n");
}

// The frame of the start tangent. With c = 1 / sqrt(1 + a^2) and s = a c, the chord frame turns by
// (U, V) = L (c x + s f, c f - s x), and f = a x - (2 a + b) x^2 + (a + b) x^3.
void write_geometry(Writer& out, const Segment& segment) {
  const double a = segment.slope_start, b = segment.slope_end, length = segment.chord_length_m();
  const double secant = std::sqrt(1 + a * a), c = length / secant, s = a * c;
  out.raw("      <geometry").number("s", segment.s_start_m);
  out.number("x", segment.start_m.x).number("y", segment.start_m.y).number("hdg", heading_rad(segment, 0));
  out.number("length", segment.arc_m).raw(">\n        <paramPoly3 aU=\"0\"");
  out.number("bU", length * secant).number("cU", -s * (2 * a + b)).number("dU", s * (a + b)).raw(" aV=\"0\" bV=\"0\"");
  out.number("cV", -c * (2 * a + b)).number("dV", c * (a + b)).raw(" pRange=\"normalized\"/>\n");
  out.raw("        <userData code=\"roadgen:chord\" value=\"").digits(segment.end_m.x);
  out.raw(" ").digits(segment.end_m.y);
  out.raw(" ").digits(a);
  out.raw(" ").digits(b);
  out.raw("\"/>\n      </geometry>\n");
}

bool is_constant(const Cubic& c) { return c.c1 == 0 && c.c2 == 0 && c.c3 == 0; }

void write_widths(Writer& out, const Road& road) {
  const Cubic* before = nullptr;
  for (const Segment& segment : road.segments) {
    const Cubic& width = segment.left_m;
    if (before && is_constant(*before) && is_constant(width) && before->c0 == width.c0) continue;
    before = &width;
    out.raw("            <width").number("sOffset", segment.s_start_m);
    write_cubic(out, width);
  }
}

void write_driving_lane(Writer& out, const Road& road, const char* id) {
  out.raw("          <lane id=\"").raw(id).raw("\" type=\"driving\" level=\"false\">\n");
  if (road.closed) {
    out.raw("            <link>\n              <predecessor id=\"").raw(id);
    out.raw("\"/>\n              <successor id=\"").raw(id).raw("\"/>\n            </link>\n");
  }
  write_widths(out, road);
  out.raw(
      "            <roadMark sOffset=\"0\" type=\"solid\" weight=\"standard\" color=\"white\" width=\"0.12\" "
      "laneChange=\"none\"/>\n          </lane>\n");
}

void write_lanes(Writer& out, const Road& road) {
  out.raw("    <lanes>\n      <laneSection s=\"0\">\n        <left>\n");
  write_driving_lane(out, road, "1");
  out.raw(
      "        </left>\n        <center>\n          <lane id=\"0\" type=\"none\" level=\"false\">\n"
      "            <roadMark sOffset=\"0\" type=\"broken\" weight=\"standard\" color=\"white\" "
      "width=\"0.12\" "
      "laneChange=\"both\"/>\n          </lane>\n        </center>\n        <right>\n");
  write_driving_lane(out, road, "-1");
  out.raw("        </right>\n      </laneSection>\n    </lanes>\n");
}

void write_road(Writer& out, const Road& road) {
  out.raw("  <road").text("name", road.name).number("length", road.length_m()).text("id", road.id);
  out.raw(" junction=\"-1\" rule=\"RHT\">\n");
  if (road.closed) {
    out.raw("    <link>\n      <predecessor elementType=\"road\"").text("elementId", road.id);
    out.raw(" contactPoint=\"end\"/>\n      <successor elementType=\"road\"").text("elementId", road.id);
    out.raw(" contactPoint=\"start\"/>\n    </link>\n");
  }
  out.raw("    <planView>\n");
  for (const Segment& segment : road.segments) write_geometry(out, segment);
  out.raw("    </planView>\n    <elevationProfile>\n");
  for (const Segment& segment : road.segments) {
    out.raw("      <elevation").number("s", segment.s_start_m);
    write_cubic(out, segment.elevation_m);
  }
  out.raw("    </elevationProfile>\n");
  write_lanes(out, road);
  out.raw("  </road>\n");
}

bool is_finite(const Segment& s) {
  const Cubic &z = s.elevation_m, &w = s.left_m;
  return std::isfinite(s.start_m.x + s.start_m.y + s.end_m.x + s.end_m.y + s.slope_start + s.slope_end + s.s_start_m +
                       s.arc_m + z.c0 + z.c1 + z.c2 + z.c3 + w.c0 + w.c1 + w.c2 + w.c3);
}

Status check_roads(const Network& network) {
  std::set<std::string_view> ids;
  for (const Road& road : network.roads) {
    const std::string element = "road " + road.id;
    if (road.id.empty()) return Error{ErrorCode::kData, "a road has no id; give every road one"};
    if (!ids.insert(road.id).second) return Error{ErrorCode::kData, "the id is used twice", {}, 0, element};
    if (road.segments.empty()) return Error{ErrorCode::kData, "the road has no segments", {}, 0, element};
    for (const Segment& segment : road.segments) {
      if (!is_finite(segment)) return Error{ErrorCode::kData, "a number is not finite", {}, 0, element};
    }
  }
  return Done{};
}

}  // namespace

Result<std::string> opendrive_text(const Network& network) {
  if (Status status = check_roads(network); !status) return status.error();
  Writer out;
  out.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenDRIVE>\n");
  write_header(out, network);
  for (const Road& road : network.roads) write_road(out, road);
  out.raw("</OpenDRIVE>\n");
  return out.take();
}

Status write_opendrive(const Network& network, const std::string& path) {
  Result<std::string> text = opendrive_text(network);
  if (!text) {
    Error error = text.error();
    error.file = path;
    return error;
  }
  return write_file(path, *text);
}

}  // namespace roadgen
