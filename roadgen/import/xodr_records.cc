#include "roadgen/import/xodr_records.h"

#include <iterator>
#include <pugixml.hpp>
#include <sstream>

namespace roadgen {
namespace {

bool contains(std::initializer_list<std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The numbers of an element and its parts; the first fault is what is told.
class Fields {
 public:
  double required(const pugi::xml_node& node, const char* name) {
    if (!node.attribute(name)) fail(std::string("<") + node.name() + "> lacks the attribute " + name);
    return number(node, name);
  }
  double number(const pugi::xml_node& node, const char* name, double fallback = 0) {
    const pugi::xml_attribute attribute = node.attribute(name);
    if (!attribute) return fallback;
    const std::optional<double> x = parse_number(attribute.value());
    if (x && std::abs(*x) <= kGreatestProfile) return *x;
    fail(std::string("the attribute ") + name + " of <" + node.name() + "> is not a number within 1e6");
    return fallback;
  }
  double size(const pugi::xml_node& node, const char* name, double fallback = 0) {
    const double x = number(node, name, fallback);
    if (x < 0) fail(std::string("the attribute ") + name + " of <" + node.name() + "> is negative");
    return x;
  }
  int integer(const pugi::xml_node& node, const char* name) {
    const double x = required(node, name);
    if (x != std::round(x)) fail(std::string("the attribute ") + name + " of <" + node.name() + "> is not an integer");
    return static_cast<int>(x);
  }
  void fail(std::string what) {
    if (fault_.empty()) fault_ = std::move(what);
  }
  // Whether all is well; otherwise tells.
  bool are_sound(XodrSource& source, const pugi::xml_node& node) const {
    if (fault_.empty()) return true;
    const std::string road = source.element(), id = node.attribute("id").value();
    if (!id.empty()) source.set_element(road + (road.empty() ? "" : ": ") + node.name() + " " + id);
    source.note(node, std::string("<") + node.name() + "> is not kept: " + fault_);
    source.set_element(road);
    return false;
  }

 private:
  std::string fault_;
};

bool is_yes(const pugi::xml_node& node, const char* name) {
  const std::string_view word = node.attribute(name).value();
  return word == "yes" || word == "true" || word == "1";
}

std::optional<bool> yes_or_no(const pugi::xml_node& node, const char* name) {
  return node.attribute(name) ? std::optional(is_yes(node, name)) : std::nullopt;
}

std::vector<LaneValidity> validities_of(Fields& fields, const pugi::xml_node& node) {
  std::vector<LaneValidity> all;
  for (const pugi::xml_node v : node.children("validity")) {
    all.push_back({fields.integer(v, "fromLane"), fields.integer(v, "toLane")});
  }
  return all;
}

ObjectSize size_at(Fields& fields, const pugi::xml_node& repeat, const std::string& which, const ObjectSize& like) {
  const auto size = [&](const char* name, double fallback) {
    return fields.size(repeat, (name + which).c_str(), fallback);
  };
  return {size("length", like.length_m), size("width", like.width_m), size("height", like.height_m),
          size("radius", like.radius_m)};
}

// From one s to another of the road; to the bit where they are the file's.
double mapped_length(const StationMap& station_m, double s_m, double length_m) {
  const double from = station_m(s_m), to = station_m(s_m + length_m);
  return from == s_m && to == s_m + length_m ? length_m : std::max(to - from, 0.0);
}

ObjectRepeat repeat_of(Fields& fields, const pugi::xml_node& node, const RoadObject& object,
                       const StationMap& station_m) {
  ObjectRepeat r;
  const double s = fields.required(node, "s"), length = fields.size(node, "length");
  r.s_m = station_m(s);
  r.length_m = mapped_length(station_m, s, length);
  r.distance_m = fields.size(node, "distance");
  r.t_start_m = fields.number(node, "tStart", object.t_m);
  r.t_end_m = fields.number(node, "tEnd", r.t_start_m);
  r.z_offset_start_m = fields.number(node, "zOffsetStart", object.z_offset_m);
  r.z_offset_end_m = fields.number(node, "zOffsetEnd", r.z_offset_start_m);
  r.start = size_at(fields, node, "Start", object.size);
  r.end = size_at(fields, node, "End", r.start);
  r.straight = is_yes(node, "detachFromReferenceLine");
  return r;
}

Outline outline_of(Fields& fields, const pugi::xml_node& node, const StationMap& station_m) {
  Outline outline{.outer = yes_or_no(node, "outer"),
                  .closed = yes_or_no(node, "closed"),
                  .id = node.attribute("id").value(),
                  .fill = node.attribute("fillType").value(),
                  .lane_type = node.attribute("laneType").value()};
  outline.on_road = !node.child("cornerRoad").empty();
  if (outline.on_road && node.child("cornerLocal")) fields.fail("an outline has corners of both kinds");
  for (const pugi::xml_node c : node.children(outline.on_road ? "cornerRoad" : "cornerLocal")) {
    OutlineCorner corner;
    corner.along_m = outline.on_road ? station_m(fields.required(c, "s")) : fields.required(c, "u");
    corner.across_m = fields.required(c, outline.on_road ? "t" : "v");
    corner.up_m = fields.number(c, outline.on_road ? "dz" : "z");
    corner.height_m = fields.number(c, "height");
    if (c.attribute("id")) corner.id = fields.integer(c, "id");
    outline.corners.push_back(corner);
  }
  return outline;
}

}  // namespace

Orientation orientation_of(const pugi::xml_node& node) {
  const std::string_view word = node.attribute("orientation").value();
  return word == "+" ? Orientation::kAlong : word == "-" ? Orientation::kAgainst : Orientation::kAll;
}

std::string element_xml(const pugi::xml_node& node) {
  std::ostringstream text;
  node.print(text, "", pugi::format_raw);
  return text.str();
}

std::string elements_xml(const pugi::xml_node& node, std::initializer_list<std::string_view> names) {
  std::string text;
  for (const pugi::xml_node child : node.children()) {
    const bool own = std::string_view(child.attribute("code").value()).starts_with("roadgen:");
    if (child.type() == pugi::node_element && contains(names, child.name()) && !own) text += element_xml(child);
  }
  return text;
}

std::string other_xml(XodrSource& source, const pugi::xml_node& node, const std::string& where,
                      std::initializer_list<std::string_view> kept, std::initializer_list<std::string_view> known) {
  for (const pugi::xml_node child : node.children()) {
    const std::string_view name = child.name();
    if (child.type() != pugi::node_element || contains(known, name) || contains(kept, name)) continue;
    source.note(child, "<" + std::string(name) + "> of " + where + " is not kept");
  }
  return elements_xml(node, kept);
}

std::optional<RoadObject> read_object(XodrSource& source, const pugi::xml_node& node, const StationMap& station_m) {
  Fields fields;
  RoadObject o{.id = node.attribute("id").value(),
               .name = node.attribute("name").value(),
               .type = node.attribute("type").value(),
               .subtype = node.attribute("subtype").value()};
  o.s_m = station_m(fields.required(node, "s"));
  o.t_m = fields.required(node, "t");
  o.z_offset_m = fields.number(node, "zOffset");
  o.heading_rad = fields.number(node, "hdg");
  o.pitch_rad = fields.number(node, "pitch");
  o.roll_rad = fields.number(node, "roll");
  o.orientation = orientation_of(node);
  o.dynamic = is_yes(node, "dynamic");
  o.perpendicular = is_yes(node, "perpToRoad");
  o.valid_length_m = fields.size(node, "validLength");
  o.size = {fields.size(node, "length"), fields.size(node, "width"), fields.size(node, "height"),
            fields.size(node, "radius")};
  for (const pugi::xml_node r : node.children("repeat")) o.repeats.push_back(repeat_of(fields, r, o, station_m));
  for (const pugi::xml_node& parent : {node, node.child("outlines")}) {
    for (const pugi::xml_node x : parent.children("outline")) {
      o.outlines.push_back(outline_of(fields, x, station_m));
    }
  }
  o.validities = validities_of(fields, node);
  if (!fields.are_sound(source, node)) return {};
  o.material_xml = elements_xml(node, {"material"});
  o.other_xml =
      other_xml(source, node, "objects", {"parkingSpace", "markings", "borders", "surface", "skeleton", "userData"},
                {"repeat", "outline", "outlines", "validity", "material"});
  return o;
}

std::optional<RoadSignal> read_signal(XodrSource& source, const pugi::xml_node& node, const StationMap& station_m) {
  Fields fields;
  RoadSignal s{.id = node.attribute("id").value(),
               .name = node.attribute("name").value(),
               .type = node.attribute("type").value(),
               .subtype = node.attribute("subtype").value(),
               .country = node.attribute("country").value(),
               .country_revision = node.attribute("countryRevision").value()};
  s.s_m = station_m(fields.required(node, "s"));
  s.t_m = fields.required(node, "t");
  s.z_offset_m = fields.number(node, "zOffset");
  s.heading_rad = fields.number(node, "hOffset");
  s.pitch_rad = fields.number(node, "pitch");
  s.roll_rad = fields.number(node, "roll");
  s.orientation = orientation_of(node);
  s.dynamic = is_yes(node, "dynamic");
  if (node.attribute("value")) s.value = fields.number(node, "value");
  s.unit = node.attribute("unit").value();
  s.text = node.attribute("text").value();
  s.length_m = fields.size(node, "length");
  s.width_m = fields.size(node, "width");
  s.height_m = fields.size(node, "height");
  s.is_painted = !user_data(node, "roadgen:painted").empty();
  s.validities = validities_of(fields, node);
  if (!fields.are_sound(source, node)) return {};
  s.other_xml =
      other_xml(source, node, "signals",
                {"dependency", "reference", "positionRoad", "positionInertial", "semantics", "userData"}, {"validity"});
  return s;
}

std::optional<Bridge> read_bridge(XodrSource& source, const pugi::xml_node& node, double road_m,
                                  const StationMap& station_m) {
  Fields fields;
  const double s = fields.required(node, "s");
  double end = s + fields.required(node, "length");
  const std::vector<double> exact = numbers_in(user_data(node, "roadgen:end"));
  if (exact.size() == 1 && std::abs(exact[0] - end) <= kSamePlace_m) end = exact[0];
  Bridge bridge{.s_start_m = std::max(station_m(s), 0.0),
                .s_end_m = std::min(station_m(end), road_m),
                .id = node.attribute("id").value(),
                .name = node.attribute("name").value(),
                .type = node.attribute("type").value()};
  if (!(bridge.s_start_m < bridge.s_end_m)) fields.fail("it has no length on its road");
  if (!fields.are_sound(source, node)) return {};
  note_others(source, node, "bridges", {"userData"});
  return bridge;
}

SpeedLimit read_speed(XodrSource& source, const pugi::xml_node& node) {
  const std::string_view max = node.attribute("max").value(), unit = node.attribute("unit").as_string("m/s");
  if (max == "no limit") return {.kind = SpeedLimit::Kind::kNoLimit};
  if (max == "undefined") return {.kind = SpeedLimit::Kind::kUndefined};
  const std::optional<double> value = parse_number(max);
  constexpr std::string_view kUnits[] = {"m/s", "km/h", "mph"};
  const auto known = std::find(std::begin(kUnits), std::end(kUnits), unit);
  if (!value || !(*value >= 0 && *value <= kGreatestProfile) || known == std::end(kUnits)) {
    source.note(node, "a <speed> is not kept: max and unit are not a speed in m/s, km/h or mph");
    return {};
  }
  return {SpeedLimit::Kind::kMax, static_cast<SpeedLimit::Unit>(known - std::begin(kUnits)), *value};
}

std::vector<RoadType> read_types(XodrSource& source, const pugi::xml_node& road, const StationMap& station_m) {
  std::vector<RoadType> types;
  for (const pugi::xml_node node : road.children("type")) {
    Fields fields;
    RoadType type{.s_m = station_m(fields.required(node, "s")),
                  .type = node.attribute("type").value(),
                  .country = node.attribute("country").value()};
    if (!types.empty() && type.s_m < types.back().s_m) fields.fail("the records are not in order");
    if (!fields.are_sound(source, node)) continue;
    if (const pugi::xml_node speed = node.child("speed")) type.speed = read_speed(source, speed);
    note_others(source, node, "<type>", {"speed", "userData"});
    types.push_back(std::move(type));
  }
  return types;
}

Controller read_controller(XodrSource& source, const pugi::xml_node& node) {
  Controller controller{.id = node.attribute("id").value(), .name = node.attribute("name").value()};
  if (const std::optional<double> x = parse_number(node.attribute("sequence").value()); x && std::abs(*x) <= 1e9) {
    controller.sequence = static_cast<int>(*x);
  }
  for (const pugi::xml_node control : node.children("control")) {
    controller.controls.push_back({control.attribute("signalId").value(), control.attribute("type").value()});
  }
  note_others(source, node, "controllers", {"control", "userData"});
  return controller;
}

}  // namespace roadgen
