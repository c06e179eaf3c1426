#include "roadgen/export/opendrive.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "roadgen/export/atomic_file.h"
#include "roadgen/export/xml_writer.h"
#include "roadgen/export/xodr_junctions.h"
#include "roadgen/export/xodr_objects.h"
#include "roadgen/export/xodr_records.h"
#include "roadgen/road/crossfall.h"
#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

void write_cubic(XmlWriter& out, const Cubic& c) {
  out.number("a", c.c0).number("b", c.c1).number("c", c.c2).number("d", c.c3).raw("/>\n");
}

void write_header(XmlWriter& out, const Network& network) {
  out.raw("  <header revMajor=\"1\" revMinor=\"7\"").text("name", network.name).raw(" version=\"1.00\"");
  if (const Bounds b = bounds(network); !b.empty()) {
    out.number("north", b.high_m.y).number("south", b.low_m.y).number("east", b.high_m.x).number("west", b.low_m.x);
  }
  out.raw(" vendor=\"roadgen\"");
  if (!network.georeference) {
    out.raw("/>\n");
    return;
  }
  out.raw(">\n");
  const Georeference& origin = *network.georeference;
  if (!origin.projection.empty()) {
    out.raw("    <geoReference>").content(origin.projection).raw("</geoReference>\n    <offset");
    out.number("x", origin.offset_m.x).number("y", origin.offset_m.y).number("z", origin.height_m);
    out.number("hdg", origin.offset_heading_rad).raw("/>\n  </header>\n");
    return;
  }
  out.raw("    <geoReference><![CDATA[+proj=ortho +lat_0=").digits(origin.latitude_deg);
  out.raw(" +lon_0=").digits(origin.longitude_deg);
  out.raw(" +x_0=0 +y_0=0 +ellps=WGS84 +units=m +no_defs]]></geoReference>\n");
  out.user_data("    ", "origin", {origin.latitude_deg, origin.longitude_deg, origin.height_m});
  out.raw("  </header>\n");
}

// The frame of the start tangent. With c = 1 / sqrt(1 + a^2) and s = a c, the chord frame turns by
// (U, V) = L (c x + s f, c f - s x), and f = a x - (2 a + b) x^2 + (a + b) x^3.
void write_geometry(XmlWriter& out, const Segment& segment, bool derived) {
  const double a = segment.slope_start, b = segment.slope_end, length = segment.chord_length_m();
  const double secant = std::sqrt(1 + a * a), c = length / secant, s = a * c;
  out.raw("      <geometry").number("s", segment.s_start_m);
  out.number("x", segment.start_m.x).number("y", segment.start_m.y).number("hdg", heading_rad(segment, 0));
  out.number("length", segment.arc_m).raw(">\n        <paramPoly3 aU=\"0\"");
  out.number("bU", length * secant).number("cU", -s * (2 * a + b)).number("dU", s * (a + b)).raw(" aV=\"0\" bV=\"0\"");
  out.number("cV", -c * (2 * a + b)).number("dV", c * (a + b)).raw(" pRange=\"normalized\"/>\n");
  if (!derived) out.user_data("        ", "chord", {segment.end_m.x, segment.end_m.y, a, b});
  out.raw("      </geometry>\n");
}

// derived: one cubic holds for the whole road.
void write_elevation(XmlWriter& out, const Road& road, bool derived) {
  if (derived && road.segments.front().elevation_m == Cubic{}) return;
  out.raw("    <elevationProfile>\n");
  for (const Segment& segment : std::span(road.segments).first(derived ? 1 : road.segments.size())) {
    out.raw("      <elevation").number("s", segment.s_start_m);
    write_cubic(out, segment.elevation_m);
  }
  out.raw("    </elevationProfile>\n");
}

// Two straight pieces across: the first from the right edge, or 1 m from the reference line where that is nearer.
void write_shape(XmlWriter& out, const Segment& segment, double local_m, double s_m) {
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
void write_shapes(XmlWriter& out, const Road& road) {
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
    out.user_data("      ", "crossfall", {segment.s_start_m, l.c0, l.c1, r.c0, r.c1});
  }
}

void write_lateral(XmlWriter& out, const Road& road) {
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

void write_line(XmlWriter& out, const Mark& mark, double t_m, bool broken) {
  out.raw("                <line").number("length", broken ? mark.on_m : 1).number("space", broken ? mark.off_m : 0);
  out.number("tOffset", t_m);
  out.number("sOffset", broken && mark.phase_m > 0 ? mark.on_m + mark.off_m - mark.phase_m : 0)
      .number("width", mark.width_m)
      .raw("/>\n");
}

void write_lines(XmlWriter& out, const Mark& mark, const char* type) {
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

void write_mark(XmlWriter& out, const Mark& mark, Side side) {
  if (mark == Mark{}) return;
  const char* type = mark_type(mark.kind, side);
  out.raw("            <roadMark sOffset=\"0\"").text("type", type).raw(" weight=\"standard\"");
  out.text("color", name_of(mark.color)).number("width", mark.width_m).text("laneChange", lane_change(mark.kind));
  out.raw(">\n");
  if (mark.kind != MarkKind::kNone && mark.kind != MarkKind::kSolid) write_lines(out, mark, type);
  out.user_data("              ", "mark", {mark.width_m, mark.space_m, mark.on_m, mark.off_m, mark.phase_m});
  out.raw("            </roadMark>\n");
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

// Of a road's first or last section, to the lanes of the road linked there; elsewhere to the neighbouring section.
std::vector<int> lanes_beyond(const Road& road, std::size_t index, int id, bool after) {
  const std::size_t count = road.sections.size();
  std::vector<int> ids;
  if (index == (after ? count - 1 : 0) && !road.closed) {
    for (const LaneLink& link : (after ? road.successor : road.predecessor).lanes) {
      if (link.from == id) ids.push_back(link.to);
    }
    return ids;
  }
  const LaneSection& section = road.sections[index];
  const std::size_t border = static_cast<std::size_t>(static_cast<int>(section.right.size()) + (id > 0 ? id - 1 : id));
  const std::size_t other = after ? (index + 1) % count : (index + count - 1) % count;
  const int found = linked_lane(section, after ? section_length_m(road, index) : 0, border, road.sections[other],
                                after ? 0 : section_length_m(road, other), id);
  if (found != 0) ids.push_back(found);
  return ids;
}

void write_lane_link(XmlWriter& out, const Road& road, std::size_t index, int id) {
  const std::vector<int> before = lanes_beyond(road, index, id, false), after = lanes_beyond(road, index, id, true);
  if (before.empty() && after.empty()) return;
  out.raw("            <link>\n");
  for (const int lane : before) out.raw("              <predecessor").text("id", std::to_string(lane)).raw("/>\n");
  for (const int lane : after) out.raw("              <successor").text("id", std::to_string(lane)).raw("/>\n");
  out.raw("            </link>\n");
}

struct Surface {
  const char* name;
  double friction;  // of dry tyres, since the standard wants a number
};
constexpr Surface kSurfaces[] = {{"asphalt", 0.8}, {"concrete", 0.8}, {"paving", 0.7},
                                 {"grass", 0.4},   {"gravel", 0.5},   {"curbstone", 0.7}};

void write_lane(XmlWriter& out, const Road& road, std::size_t index, int id) {
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
  const LaneRecord* record = lane_record(road, index, id);
  if (record) {
    write_speed(out, "            ", " sOffset=\"0\"", record->speed);
    write_kept(out, "            ", record->access_xml);
  }
  if (lane.inner_height_m != 0 || lane.outer_height_m != 0) {
    out.raw("            <height sOffset=\"0\"").number("inner", lane.inner_height_m);
    out.number("outer", lane.outer_height_m).raw("/>\n");
  }
  if (record) write_kept(out, "            ", record->rule_xml);
  out.raw("          </lane>\n");
}

void write_section(XmlWriter& out, const Road& road, std::size_t index) {
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

void write_lanes(XmlWriter& out, const Road& road) {
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

// derived: what of it only our own reader needs is left out, since it leaves out the road.
void write_road(XmlWriter& out, const Road& road, const JunctionIds& closed, bool derived = false) {
  out.raw("  <road").text("name", road.name).number("length", road.length_m()).text("id", road.id);
  out.text("junction", road.junction.empty() ? "-1" : road.junction)
      .text("rule", road.keep_left ? "LHT" : "RHT")
      .raw(">\n");
  write_links(out, road, closed);
  write_types(out, road);
  out.raw("    <planView>\n");
  for (const Segment& segment : road.segments) write_geometry(out, segment, derived);
  out.raw("    </planView>\n");
  write_elevation(out, road, derived);
  write_lateral(out, road);
  write_lanes(out, road);
  write_objects(out, road);
  write_signals(out, road);
  write_kept(out, "    ", road.records->other_xml);
  if (derived) {
    out.user_data("    ", "derived", {}, "way");
  } else {
    write_joined(out, road);
    write_closed_links(out, road, closed);
  }
  out.raw("  </road>\n");
}

// The texts of `count` parts in their order, made on all cores, eight chunks at a time. A chunk is best some 20 KB.
template <class Write>
void write_parts(XmlWriter& out, std::size_t count, std::size_t chunk_size, const Write& write) {
  const std::size_t batch = 8 * chunk_size;
  std::vector<std::string> texts;
  for (std::size_t first = 0; first < count; first += batch) {
    const std::size_t parts = std::min(batch, count - first);
    texts.assign((parts + chunk_size - 1) / chunk_size, {});
    for_chunks(parts, chunk_size, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      XmlWriter part;
      for (std::size_t i = begin; i < end; ++i) write(part, first + i);
      texts[chunk] = part.take();
    });
    for (const std::string& text : texts) out.raw(text);
  }
}

// The connecting roads that follow from areas.
void write_derived_roads(XmlWriter& out, const Network& network, const RoadsById& roads, const JunctionIds& closed) {
  const LinksById listed = links_by_id(network);
  write_parts(out, network.junctions.size(), 1, [&](XmlWriter& part, std::size_t i) {
    const Junction& area = network.junctions[i];
    for (const DerivedWay& way : derived_ways(network, roads, listed, area)) {
      write_road(part, connecting_road(network, roads, area, way.movement, way.id), closed, true);
    }
  });
}

Status check_roads(const Network& network, const RoadsById& roads) {
  for (const Road& road : network.roads) {
    const std::string element = "road " + road.id;
    if (road.id.empty()) return Error{ErrorCode::kData, "a road has no id; give every road one"};
    if (&network.roads[roads.at(road.id)] != &road) {
      return Error{ErrorCode::kData, "the id is used twice", {}, 0, element};
    }
    if (road.segments.empty()) return Error{ErrorCode::kData, "the road has no segments", {}, 0, element};
    if (road.sections.empty()) return Error{ErrorCode::kData, "the road has no lane sections", {}, 0, element};
    if (!is_finite(road) || !has_finite_sweeps(road))
      return Error{ErrorCode::kData, "a number is not finite", {}, 0, element};
    if (!std::all_of(road.bridges.begin(), road.bridges.end(), [&](const Bridge& b) { return is_on(b, road); }))
      return Error{ErrorCode::kData, "a bridge has no length or reaches beyond the road", {}, 0, element};
  }
  return Done{};
}

}  // namespace

namespace {

Status check_network(const Network& network, const RoadsById& roads) {
  if (Status status = check_roads(network, roads); !status) return status;
  return check_junctions(network);
}

void write_network(XmlWriter& out, const Network& network, const RoadsById& roads) {
  const JunctionIds closed = closed_junctions(network, roads);
  out.raw("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<OpenDRIVE>\n");
  write_header(out, network);
  write_parts(out, network.roads.size(), 4,
              [&](XmlWriter& part, std::size_t i) { write_road(part, network.roads[i], closed); });
  write_derived_roads(out, network, roads, closed);
  write_controllers(out, network);
  write_junctions(out, network, roads, closed, false);
  write_kept(out, "  ", network.other_xml);
  write_junctions(out, network, roads, closed, true);
  out.raw("</OpenDRIVE>\n");
}

}  // namespace

Result<std::string> opendrive_text(const Network& network) {
  const RoadsById roads = roads_by_id(network);
  if (Status status = check_network(network, roads); !status) return status.error();
  XmlWriter out;
  write_network(out, network, roads);
  return out.take();
}

Status write_opendrive(const Network& network, const std::string& path) {
  const RoadsById roads = roads_by_id(network);
  if (const Status status = check_network(network, roads); !status) {
    Error error = status.error();
    error.file = path;
    return error;
  }
  return write_file(path, [&](const TakeBytes& take) {
    XmlWriter out(take);
    write_network(out, network, roads);
    out.flush();
  });
}

}  // namespace roadgen
