#include "roadgen/export/opendrive.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <string_view>

#include "roadgen/export/atomic_file.h"
#include "roadgen/road/crossfall.h"

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

void write_elevation(Writer& out, const Road& road) {
  out.raw("    <elevationProfile>\n");
  for (const Segment& segment : road.segments) {
    out.raw("      <elevation").number("s", segment.s_start_m);
    write_cubic(out, segment.elevation_m);
  }
  out.raw("    </elevationProfile>\n");
}

// Two straight pieces across: the first from the right edge, or 1 m from the reference line where that is nearer.
void write_shape(Writer& out, const Segment& segment, double local_m, double s_m) {
  const double e = segment.superelevation_rad.value(local_m);
  const double left = tilted_fall(segment.crossfall_left.value(local_m), e, 1);
  const double right = tilted_fall(segment.crossfall_right.value(local_m), e, -1);
  const double edge = std::min(segment.right_m.value(local_m), -1.0);
  out.raw("      <shape").number("s", s_m).number("t", edge);
  write_cubic(out, {edge * right, right, 0, 0});
  out.raw("      <shape").number("s", s_m).number("t", 0);
  write_cubic(out, {0, -left, 0, 0});
}

bool has_crossfall(const Segment& segment) {
  return segment.crossfall_left != Linear{} || segment.crossfall_right != Linear{};
}

// A station where a segment starts, one at the road's end, and one just before a joint where the slopes jump.
void write_shapes(Writer& out, const Road& road) {
  constexpr double kBeforeJump_m = 5e-4;
  for (std::size_t i = 0; i < road.segments.size(); ++i) {
    const Segment& segment = road.segments[i];
    write_shape(out, segment, 0, segment.s_start_m);
    const double end = segment.s_start_m + segment.arc_m;
    if (i + 1 == road.segments.size()) {
      write_shape(out, segment, segment.arc_m, end);
      continue;
    }
    const auto jump = [&](const Linear& before, const Linear& after) {
      return std::abs(before.value(segment.arc_m) - after.c0) > 1e-9;
    };
    const Segment& next = road.segments[i + 1];
    if (jump(segment.crossfall_left, next.crossfall_left) || jump(segment.crossfall_right, next.crossfall_right)) {
      write_shape(out, segment, segment.arc_m, std::max(end - kBeforeJump_m, 0.5 * (segment.s_start_m + end)));
    }
  }
  for (const Segment& segment : road.segments) {
    const Linear &l = segment.crossfall_left, &r = segment.crossfall_right;
    out.raw("      <userData code=\"roadgen:crossfall\" value=\"").digits(segment.s_start_m);
    for (const double x : {l.c0, l.c1, r.c0, r.c1}) {
      out.raw(" ").digits(x);
    }
    out.raw("\"/>\n");
  }
}

void write_lateral(Writer& out, const Road& road) {
  const auto& all = road.segments;
  const bool tilts =
      std::any_of(all.begin(), all.end(), [](const Segment& s) { return s.superelevation_rad != Cubic{}; });
  const bool falls = std::any_of(all.begin(), all.end(), has_crossfall);
  if (!tilts && !falls) return;
  out.raw("    <lateralProfile>\n");
  for (const Segment& segment : all) {
    if (!tilts) break;
    out.raw("      <superelevation").number("s", segment.s_start_m);
    write_cubic(out, segment.superelevation_rad);
  }
  if (falls) write_shapes(out, road);
  out.raw("    </lateralProfile>\n");
}

constexpr const char* kColors[] = {"white", "yellow", "blue", "green", "red", "orange"};
const char* name_of(PaintColor color) { return kColors[static_cast<std::size_t>(color)]; }

enum class Side { kRight = -1, kCenter = 0, kLeft = 1 };

// OpenDRIVE names the inner line of two first, and the left one on the centre lane; we the right one.
const char* mark_type(MarkKind kind, Side side) {
  switch (kind) {
    case MarkKind::kNone: return "none";
    case MarkKind::kSolid: return "solid";
    case MarkKind::kBroken: return "broken";
    case MarkKind::kSolidSolid: return "solid solid";
    case MarkKind::kSolidBroken: return side == Side::kLeft ? "solid broken" : "broken solid";
    case MarkKind::kBrokenSolid: return side == Side::kLeft ? "broken solid" : "solid broken";
    case MarkKind::kBrokenBroken: return "broken broken";
  }
  return "none";
}

// From the side of the broken line the line may be crossed; ids increase to the left.
const char* lane_change(MarkKind kind) {
  switch (kind) {
    case MarkKind::kSolid:
    case MarkKind::kSolidSolid: return "none";
    case MarkKind::kSolidBroken: return "decrease";
    case MarkKind::kBrokenSolid: return "increase";
    default: return "both";
  }
}

void write_line(Writer& out, const Mark& mark, double t_m, bool broken) {
  out.raw("                <line").number("length", broken ? mark.on_m : 1).number("space", broken ? mark.off_m : 0);
  out.number("tOffset", t_m);
  out.number("sOffset", broken && mark.phase_m > 0 ? mark.on_m + mark.off_m - mark.phase_m : 0)
      .number("width", mark.width_m)
      .raw("/>\n");
}

void write_lines(Writer& out, const Mark& mark, const char* type) {
  out.raw("              <type").text("name", type).number("width", mark.width_m).raw(">\n");
  const double near = 0.5 * (mark.space_m + mark.width_m);
  switch (mark.kind) {
    case MarkKind::kBroken: write_line(out, mark, 0, true); break;
    default:
      write_line(out, mark, near, mark.kind == MarkKind::kSolidBroken || mark.kind == MarkKind::kBrokenBroken);
      write_line(out, mark, -near, mark.kind == MarkKind::kBrokenSolid || mark.kind == MarkKind::kBrokenBroken);
  }
  out.raw("              </type>\n");
}

void write_mark(Writer& out, const Mark& mark, Side side) {
  if (mark == Mark{}) return;
  const char* type = mark_type(mark.kind, side);
  out.raw("            <roadMark sOffset=\"0\"").text("type", type).raw(" weight=\"standard\"");
  out.text("color", name_of(mark.color)).number("width", mark.width_m).text("laneChange", lane_change(mark.kind));
  out.raw(">\n");
  if (mark.kind != MarkKind::kNone && mark.kind != MarkKind::kSolid) write_lines(out, mark, type);
  out.raw("              <userData code=\"roadgen:mark\" value=\"").digits(mark.width_m);
  for (const double x : {mark.space_m, mark.on_m, mark.off_m, mark.phase_m}) out.raw(" ").digits(x);
  out.raw("\"/>\n            </roadMark>\n");
}

// The lane of the section before or after that goes on where this one ends or starts, 0 for none: the one on the same
// side that holds its middle.
int linked_lane(const LaneSection& from, double from_ds_m, std::size_t border, const LaneSection& to, double to_ds_m,
                int id) {
  const std::vector<Cubic> borders = from.borders_m();
  const double right = borders[border].value(from_ds_m), left = borders[border + 1].value(from_ds_m);
  if (!(left - right > 1e-3)) return 0;
  const int found = lane_at(to, to_ds_m, 0.5 * (left + right));
  return (found > 0) == (id > 0) ? found : 0;
}

// Where a section ends, from its start.
double section_length_m(const Road& road, std::size_t index) {
  return (index + 1 < road.sections.size() ? road.sections[index + 1].s_m : road.length_m()) - road.sections[index].s_m;
}

void write_lane_link(Writer& out, const Road& road, std::size_t index, int id) {
  const std::size_t count = road.sections.size();
  const LaneSection& section = road.sections[index];
  const std::size_t border = static_cast<std::size_t>(static_cast<int>(section.right.size()) + (id > 0 ? id - 1 : id));
  int before = 0, after = 0;
  if (index > 0 || road.closed) {
    const std::size_t other = index > 0 ? index - 1 : count - 1;
    before = linked_lane(section, 0, border, road.sections[other], section_length_m(road, other), id);
  }
  if (index + 1 < count || road.closed) {
    const LaneSection& other = road.sections[index + 1 < count ? index + 1 : 0];
    after = linked_lane(section, section_length_m(road, index), border, other, 0, id);
  }
  if (before == 0 && after == 0) return;
  out.raw("            <link>\n");
  if (before != 0) out.raw("              <predecessor").text("id", std::to_string(before)).raw("/>\n");
  if (after != 0) out.raw("              <successor").text("id", std::to_string(after)).raw("/>\n");
  out.raw("            </link>\n");
}

struct Surface {
  const char* name;
  double friction;  // of dry tyres, since the standard wants a number
};
constexpr Surface kSurfaces[] = {{"asphalt", 0.8}, {"concrete", 0.8}, {"paving", 0.7},
                                 {"grass", 0.4},   {"gravel", 0.5},   {"curbstone", 0.7}};

void write_lane(Writer& out, const Road& road, std::size_t index, int id) {
  const LaneSection& section = road.sections[index];
  const Lane& lane =
      id > 0 ? section.left[static_cast<std::size_t>(id - 1)] : section.right[static_cast<std::size_t>(-id - 1)];
  out.raw("          <lane").text("id", std::to_string(id)).text("type", lane_type_name(lane.type));
  out.raw(" level=\"false\">\n");
  write_lane_link(out, road, index, id);
  out.raw("            <width sOffset=\"0\"");
  write_cubic(out, lane.width_m);
  write_mark(out, lane.mark, id > 0 ? Side::kLeft : Side::kRight);
  if (lane.material != default_material(lane.type)) {
    const Surface& surface = kSurfaces[static_cast<std::size_t>(lane.material)];
    out.raw("            <material sOffset=\"0\"").text("surface", surface.name);
    out.number("friction", surface.friction).raw("/>\n");
  }
  if (lane.inner_height_m != 0 || lane.outer_height_m != 0) {
    out.raw("            <height sOffset=\"0\"").number("inner", lane.inner_height_m);
    out.number("outer", lane.outer_height_m).raw("/>\n");
  }
  out.raw("          </lane>\n");
}

void write_section(Writer& out, const Road& road, std::size_t index) {
  const LaneSection& section = road.sections[index];
  out.raw("      <laneSection").number("s", section.s_m).raw(">\n");
  if (!section.left.empty()) {
    out.raw("        <left>\n");
    for (int id = static_cast<int>(section.left.size()); id > 0; --id) write_lane(out, road, index, id);
    out.raw("        </left>\n");
  }
  out.raw("        <center>\n          <lane id=\"0\" type=\"none\" level=\"false\">\n");
  write_mark(out, section.center_mark, Side::kCenter);
  out.raw("          </lane>\n        </center>\n");
  if (!section.right.empty()) {
    out.raw("        <right>\n");
    for (int id = -1; id >= -static_cast<int>(section.right.size()); --id) write_lane(out, road, index, id);
    out.raw("        </right>\n");
  }
  out.raw("      </laneSection>\n");
}

void write_lanes(Writer& out, const Road& road) {
  out.raw("    <lanes>\n");
  const auto moved = [](const LaneSection& section) { return section.offset_m != Cubic{}; };
  if (std::any_of(road.sections.begin(), road.sections.end(), moved)) {
    for (const LaneSection& section : road.sections) {
      out.raw("      <laneOffset").number("s", section.s_m);
      write_cubic(out, section.offset_m);
    }
  }
  for (std::size_t i = 0; i < road.sections.size(); ++i) write_section(out, road, i);
  out.raw("    </lanes>\n");
}

struct ObjectType {
  const char *type, *subtype;
};
// In the order of PaintKind.
constexpr ObjectType kObjects[] = {{"roadMark", "signalLines"},       {"crosswalk", "zebra"},
                                   {"roadMark", "arrowStraight"},     {"roadMark", "arrowLeft"},
                                   {"roadMark", "arrowRight"},        {"roadMark", "arrowStraightLeft"},
                                   {"roadMark", "arrowStraightRight"}};

void write_objects(Writer& out, const Road& road) {
  if (road.paint.empty()) return;
  out.raw("    <objects>\n");
  for (std::size_t i = 0; i < road.paint.size(); ++i) {
    const Paint& paint = road.paint[i];
    const ObjectType& object = kObjects[static_cast<std::size_t>(paint.kind)];
    out.raw("      <object").text("id", road.id + "-" + std::to_string(i + 1)).text("type", object.type);
    out.text("subtype", object.subtype).number("s", paint.s_m).number("t", paint.t_m).raw(" zOffset=\"0\"");
    out.number("hdg", paint.against ? std::numbers::pi : 0).raw(" pitch=\"0\" roll=\"0\"");
    out.text("orientation", paint.against ? "-" : "+").number("length", paint.length_m);
    out.number("width", paint.width_m).raw(" height=\"0\">\n        <userData code=\"roadgen:paint\" value=\"");
    out.digits(static_cast<int>(paint.color));
    out.raw(" ").digits(paint.stripe_m);
    out.raw("\"/>\n      </object>\n");
  }
  out.raw("    </objects>\n");
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
  out.raw("    </planView>\n");
  write_elevation(out, road);
  write_lateral(out, road);
  write_lanes(out, road);
  write_objects(out, road);
  out.raw("  </road>\n");
}

Status check_roads(const Network& network) {
  std::set<std::string_view> ids;
  for (const Road& road : network.roads) {
    const std::string element = "road " + road.id;
    if (road.id.empty()) return Error{ErrorCode::kData, "a road has no id; give every road one"};
    if (!ids.insert(road.id).second) return Error{ErrorCode::kData, "the id is used twice", {}, 0, element};
    if (road.segments.empty()) return Error{ErrorCode::kData, "the road has no segments", {}, 0, element};
    if (road.sections.empty()) return Error{ErrorCode::kData, "the road has no lane sections", {}, 0, element};
    if (!is_finite(road)) return Error{ErrorCode::kData, "a number is not finite", {}, 0, element};
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
