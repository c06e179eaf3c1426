#include "roadgen/export/xodr_records.h"

#include <algorithm>
#include <tuple>

namespace roadgen {
namespace {

// A word that may be missing.
void optional(XmlWriter& out, const char* name, const std::string& word) {
  if (!word.empty()) out.text(name, word);
}

const char* yes_or_no(bool yes) { return yes ? "yes" : "no"; }

void write_sizes(XmlWriter& out, const ObjectSize& size) {
  if (size.length_m != 0) out.number("length", size.length_m);
  if (size.width_m != 0) out.number("width", size.width_m);
  if (size.height_m != 0) out.number("height", size.height_m);
  if (size.radius_m != 0) out.number("radius", size.radius_m);
}

void write_validities(XmlWriter& out, const std::vector<LaneValidity>& validities) {
  for (const LaneValidity& v : validities) {
    out.raw("        <validity").text("fromLane", std::to_string(v.from)).text("toLane", std::to_string(v.to));
    out.raw("/>\n");
  }
}

void write_repeat(XmlWriter& out, const ObjectRepeat& r) {
  out.raw("        <repeat").number("s", r.s_m).number("length", r.length_m).number("distance", r.distance_m);
  out.number("tStart", r.t_start_m).number("tEnd", r.t_end_m);
  out.number("zOffsetStart", r.z_offset_start_m).number("zOffsetEnd", r.z_offset_end_m);
  out.number("lengthStart", r.start.length_m).number("lengthEnd", r.end.length_m);
  out.number("widthStart", r.start.width_m).number("widthEnd", r.end.width_m);
  out.number("heightStart", r.start.height_m).number("heightEnd", r.end.height_m);
  out.number("radiusStart", r.start.radius_m).number("radiusEnd", r.end.radius_m);
  if (r.straight) out.text("detachFromReferenceLine", "true");
  out.raw("/>\n");
}

void write_outline(XmlWriter& out, const Outline& outline) {
  out.raw("          <outline");
  optional(out, "id", outline.id);
  optional(out, "fillType", outline.fill);
  optional(out, "laneType", outline.lane_type);
  if (outline.outer) out.text("outer", *outline.outer ? "true" : "false");
  if (outline.closed) out.text("closed", *outline.closed ? "true" : "false");
  out.raw(">\n");
  for (const OutlineCorner& c : outline.corners) {
    if (outline.on_road) {
      out.raw("            <cornerRoad").number("s", c.along_m).number("t", c.across_m).number("dz", c.up_m);
    } else {
      out.raw("            <cornerLocal").number("u", c.along_m).number("v", c.across_m).number("z", c.up_m);
    }
    out.number("height", c.height_m);
    if (c.id >= 0) out.text("id", std::to_string(c.id));
    out.raw("/>\n");
  }
  out.raw("          </outline>\n");
}

void write_signal(XmlWriter& out, const RoadSignal& s) {
  out.raw("      <signal").number("s", s.s_m).number("t", s.t_m).text("id", s.id);
  optional(out, "name", s.name);
  out.text("dynamic", yes_or_no(s.dynamic)).text("orientation", orientation_name(s.orientation));
  out.number("zOffset", s.z_offset_m);
  optional(out, "country", s.country);
  optional(out, "countryRevision", s.country_revision);
  out.text("type", s.type).text("subtype", s.subtype);
  if (s.value) out.number("value", *s.value);
  optional(out, "unit", s.unit);
  if (s.length_m != 0) out.number("length", s.length_m);
  if (s.height_m != 0) out.number("height", s.height_m);
  if (s.width_m != 0) out.number("width", s.width_m);
  optional(out, "text", s.text);
  out.number("hOffset", s.heading_rad).number("pitch", s.pitch_rad).number("roll", s.roll_rad).raw(">\n");
  write_validities(out, s.validities);
  write_kept(out, "        ", s.other_xml);
  if (s.is_painted) out.user_data("        ", "painted", {}, "yes");
  out.raw("      </signal>\n");
}

}  // namespace

const char* orientation_name(Orientation orientation) {
  switch (orientation) {
    case Orientation::kAll: return "none";
    case Orientation::kAlong: return "+";
    case Orientation::kAgainst: return "-";
  }
  return "none";
}

void write_kept(XmlWriter& out, const char* indent, const std::string& xml) {
  if (!xml.empty()) out.raw(indent).raw(xml).raw("\n");
}

void write_speed(XmlWriter& out, const char* indent, const char* offset, const SpeedLimit& speed) {
  constexpr const char* kUnits[] = {"m/s", "km/h", "mph"};
  if (speed.kind == SpeedLimit::Kind::kNone) return;
  out.raw(indent).raw("<speed").raw(offset);
  switch (speed.kind) {
    case SpeedLimit::Kind::kNone: break;
    case SpeedLimit::Kind::kMax:
      out.number("max", speed.value).text("unit", kUnits[static_cast<std::size_t>(speed.unit)]);
      break;
    case SpeedLimit::Kind::kNoLimit: out.text("max", "no limit"); break;
    case SpeedLimit::Kind::kUndefined: out.text("max", "undefined"); break;
  }
  out.raw("/>\n");
}

void write_types(XmlWriter& out, const Road& road) {
  for (const RoadType& type : road.records->types) {
    out.raw("    <type").number("s", type.s_m).text("type", type.type);
    optional(out, "country", type.country);
    out.raw(">\n");
    write_speed(out, "      ", "", type.speed);
    out.raw("    </type>\n");
  }
}

void write_object(XmlWriter& out, const RoadObject& o) {
  out.raw("      <object").text("id", o.id);
  optional(out, "name", o.name);
  optional(out, "type", o.type);
  optional(out, "subtype", o.subtype);
  out.number("s", o.s_m).number("t", o.t_m).number("zOffset", o.z_offset_m);
  out.number("hdg", o.heading_rad).number("pitch", o.pitch_rad).number("roll", o.roll_rad);
  out.text("orientation", orientation_name(o.orientation)).text("dynamic", yes_or_no(o.dynamic));
  if (o.perpendicular) out.text("perpToRoad", "true");
  if (o.valid_length_m != 0) out.number("validLength", o.valid_length_m);
  write_sizes(out, o.size);
  out.raw(">\n");
  for (const ObjectRepeat& repeat : o.repeats) write_repeat(out, repeat);
  if (!o.outlines.empty()) {
    out.raw("        <outlines>\n");
    for (const Outline& outline : o.outlines) write_outline(out, outline);
    out.raw("        </outlines>\n");
  }
  write_kept(out, "        ", o.material_xml);
  write_validities(out, o.validities);
  write_kept(out, "        ", o.other_xml);
  out.raw("      </object>\n");
}

void write_bridge(XmlWriter& out, const Bridge& bridge) {
  out.raw("      <bridge").text("id", bridge.id);
  optional(out, "name", bridge.name);
  optional(out, "type", bridge.type);
  out.number("s", bridge.s_start_m).number("length", bridge.s_end_m - bridge.s_start_m).raw(">\n");
  out.user_data("        ", "end", {bridge.s_end_m});  // which the sum may miss by a bit
  out.raw("      </bridge>\n");
}

void write_signals(XmlWriter& out, const Road& road) {
  const RoadRecords& records = *road.records;
  if (records.signals.empty() && records.other_signals_xml.empty()) return;
  out.raw("    <signals>\n");
  for (const RoadSignal& signal : records.signals) write_signal(out, signal);
  write_kept(out, "      ", records.other_signals_xml);
  out.raw("    </signals>\n");
}

void write_controllers(XmlWriter& out, const Network& network) {
  for (const Controller& controller : network.controllers) {
    out.raw("  <controller").text("id", controller.id);
    optional(out, "name", controller.name);
    if (controller.sequence) out.text("sequence", std::to_string(*controller.sequence));
    out.raw(">\n");
    for (const Controller::Control& control : controller.controls) {
      out.raw("    <control").text("signalId", control.signal);
      optional(out, "type", control.type);
      out.raw("/>\n");
    }
    out.raw("  </controller>\n");
  }
}

const LaneRecord* lane_record(const Road& road, std::size_t section, int lane) {
  const std::vector<LaneRecord>& all = road.records->lanes;
  const auto found = std::partition_point(all.begin(), all.end(), [&](const LaneRecord& r) {
    return std::tuple(std::size_t{r.section}, -r.lane) < std::tuple(section, -lane);
  });
  return found != all.end() && found->section == section && found->lane == lane ? &*found : nullptr;
}

}  // namespace roadgen
