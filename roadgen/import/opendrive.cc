#include "roadgen/import/opendrive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <vector>

#include "roadgen/import/param_poly3.h"
#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

// Files write s and coordinates with few digits: what counts as the same place.
constexpr double kSamePlace_m = 1e-6;
// Greatest break in s from one geometry to the next.
constexpr double kSameStation_m = 1e-3;
constexpr double kGreatestProfile_m = 1e6;

// A record of a profile: the cubic holds from s_m on, in ds = s - s_m.
struct Record {
  double s_m = 0;
  Cubic cubic;
  int line = 0;
};

// A segment with where the file says it starts and how long it is.
struct Placed {
  Segment segment;
  double s_m = 0, length_m = 0;
};

// Moves the end onto the next anchor where only rounding keeps them apart.
void join_end(Segment& segment, glm::dvec2 next_m) {
  const double gap_m = glm::length(segment.end_m - next_m);
  if (gap_m == 0 || gap_m > kSamePlace_m || glm::length(next_m - segment.start_m) < 10 * kSamePlace_m) return;
  segment.end_m = next_m;
  set_arc(segment);
}

std::vector<double> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  while (!(text = trimmed(text)).empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::optional<double> x = parse_number(text.substr(0, end));
    if (!x || !std::isfinite(*x)) return {};
    numbers.push_back(*x);
    text.remove_prefix(end);
  }
  return numbers;
}

std::string user_data(pugi::xml_node parent, const char* code) {
  return parent.find_child_by_attribute("userData", "code", code).attribute("value").value();
}

// Value of +KEY=VALUE in a PROJ string.
std::string proj_value(std::string_view proj, std::string_view key) {
  const std::string wanted = "+" + std::string(key) + "=";
  const std::size_t at = proj.find(wanted);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = proj.substr(at + wanted.size());
  return std::string(rest.substr(0, rest.find_first_of(" \t\r\n")));
}

// Reads one document. The first error stops everything: each step returns early once error_ is set.
class Reader {
 public:
  Reader(std::string_view text, std::string file) : text_(text), lines_(text), file_(std::move(file)) {}

  Result<Network> read(Diagnostics* diagnostics);

 private:
  // Errors and notes.
  bool failed() const { return error_.has_value(); }
  void fail(ErrorCode code, pugi::xml_node where, std::string message) {
    if (!error_) error_ = Error{code, std::move(message), file_, line(where), element_};
  }
  void unsupported(pugi::xml_node where, const std::string& what) {
    fail(ErrorCode::kData, where, what + " not supported yet");
  }
  void note(pugi::xml_node where, const std::string& what);
  int line(pugi::xml_node node) const { return lines_.line(node.offset_debug()); }

  // Attributes and children; missing or malformed ones are errors.
  double number(pugi::xml_node node, const char* name);
  std::string word(pugi::xml_node node, const char* name);
  Cubic cubic(pugi::xml_node node);
  pugi::xml_node child(pugi::xml_node node, const char* name);

  void read_header(pugi::xml_node header);
  void read_origin(pugi::xml_node header);
  void read_road(pugi::xml_node node);
  void read_links(pugi::xml_node node, Road& road);
  void refuse_lateral(pugi::xml_node node);
  Placed read_geometry(pugi::xml_node node);
  ParametricCubic read_shape(pugi::xml_node node, double heading_rad, double length_m);
  void take_exact_chord(pugi::xml_node node, Segment& segment);
  std::vector<Placed> read_plan(pugi::xml_node node);
  std::vector<Record> read_records(pugi::xml_node parent, const char* name, const char* position);
  std::vector<Record> read_widths(pugi::xml_node node);
  std::vector<Record> read_lane(pugi::xml_node side, const char* id);
  void refuse_lane_offset(pugi::xml_node lanes);
  Cubic profile_over(const std::vector<Record>& records, const Placed& placed, const char* what);
  void close_loop(pugi::xml_node node, Road& road);

  struct Note {
    int line;
    std::string element;
    int count;
  };

  std::string_view text_;
  LineIndex lines_;
  std::string file_, element_;
  std::optional<Error> error_;
  std::map<std::string, Note> notes_;
  Network network_;
};

void Reader::note(pugi::xml_node where, const std::string& what) {
  const auto [at, is_new] = notes_.try_emplace(what, Note{0, element_, 0});
  if (is_new) at->second.line = line(where);
  ++at->second.count;
}

double Reader::number(pugi::xml_node node, const char* name) {
  const pugi::xml_attribute attribute = node.attribute(name);
  const std::string tag = std::string("<") + node.name() + ">";
  if (!attribute) {
    fail(ErrorCode::kParse, node, tag + " lacks the attribute " + name);
    return 0;
  }
  const std::optional<double> value = parse_number(attribute.value());
  if (!value || !std::isfinite(*value)) {
    fail(ErrorCode::kParse, node,
         tag + " has " + name + "=\"" + attribute.value() + "\", which is not a finite number");
    return 0;
  }
  return *value;
}

std::string Reader::word(pugi::xml_node node, const char* name) {
  const pugi::xml_attribute attribute = node.attribute(name);
  if (!attribute || !*attribute.value()) {
    fail(ErrorCode::kParse, node, std::string("<") + node.name() + "> lacks the attribute " + name);
  }
  return attribute.value();
}

Cubic Reader::cubic(pugi::xml_node node) {
  return {number(node, "a"), number(node, "b"), number(node, "c"), number(node, "d")};
}

pugi::xml_node Reader::child(pugi::xml_node node, const char* name) {
  const pugi::xml_node found = node.child(name);
  if (!found) fail(ErrorCode::kParse, node, std::string("<") + node.name() + "> lacks <" + name + ">");
  return found;
}

void Reader::read_header(pugi::xml_node header) {
  if (failed()) return;
  if (number(header, "revMajor") != 1 && !failed()) unsupported(header, "an OpenDRIVE version other than 1.x is");
  network_.name = header.attribute("name").value();
  read_origin(header);
}

void Reader::read_origin(pugi::xml_node header) {
  std::vector<double> origin = numbers_in(user_data(header, "roadgen:origin"));
  const pugi::xml_node reference = header.child("geoReference");
  if (origin.size() != 3) {
    const std::string proj = reference.text().get();
    if (trimmed(proj).empty()) return;
    if (proj_value(proj, "proj") != "ortho") {
      note(reference, "the geoReference is not +proj=ortho and is not kept");
      return;
    }
    origin = numbers_in(proj_value(proj, "lat_0") + " " + proj_value(proj, "lon_0") + " 0");
  }
  if (origin.size() != 3 || std::abs(origin[0]) > 90 || std::abs(origin[1]) > 180) {
    fail(ErrorCode::kParse, reference, "the origin is not a latitude and longitude in degrees");
    return;
  }
  network_.georeference = Georeference{origin[0], origin[1], origin[2]};
}

void Reader::read_links(pugi::xml_node node, Road& road) {
  for (const pugi::xml_node link : node.child("link").children()) {
    if (link.attribute("elementId").value() == road.id && !std::strcmp(link.attribute("elementType").value(), "road")) {
      road.closed = true;
    } else {
      note(link, "links to other roads are not kept");
    }
  }
}

void Reader::refuse_lateral(pugi::xml_node node) {
  for (const pugi::xml_node record : node.child("lateralProfile").children()) {
    const bool flat = !std::strcmp(record.name(), "superelevation") && record.attribute("a").as_double() == 0 &&
                      record.attribute("b").as_double() == 0 && record.attribute("c").as_double() == 0 &&
                      record.attribute("d").as_double() == 0;
    if (!flat) return unsupported(record, std::string("<") + record.name() + "> is");
  }
}

ParametricCubic Reader::read_shape(pugi::xml_node node, double heading_rad, double length_m) {
  const glm::dvec2 start(number(node, "x"), number(node, "y"));
  const pugi::xml_node shape = node.find_child([](pugi::xml_node n) { return std::strcmp(n.name(), "userData") != 0; });
  if (!std::strcmp(shape.name(), "line")) return ParametricCubic{start, {length_m, 0}}.turned(heading_rad);
  if (std::strcmp(shape.name(), "paramPoly3")) {
    if (shape)
      unsupported(shape, std::string("geometry <") + shape.name() + "> is");
    else
      fail(ErrorCode::kParse, node, "<geometry> has no shape");
    return {};
  }
  const glm::dvec2 offset(number(shape, "aU"), number(shape, "aV"));
  ParametricCubic curve{offset,
                        {number(shape, "bU"), number(shape, "bV")},
                        {number(shape, "cU"), number(shape, "cV")},
                        {number(shape, "dU"), number(shape, "dV")}};
  const std::string range = shape.attribute("pRange").as_string("arcLength");  // the default of OpenDRIVE 1.4
  if (range == "arcLength")
    curve = curve.rescaled(length_m);
  else if (range != "normalized")
    fail(ErrorCode::kParse, shape, "pRange=\"" + range + "\" is neither arcLength nor normalized");
  curve = curve.turned(heading_rad);
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  curve.start_m = start + glm::dvec2(c * offset.x - s * offset.y, s * offset.x + c * offset.y);
  return curve;
}

// Our own files carry the anchors and slopes unrounded; they count only where they agree with the shape.
void Reader::take_exact_chord(pugi::xml_node node, Segment& segment) {
  const std::string text = user_data(node, "roadgen:chord");
  if (text.empty()) return;
  const std::vector<double> chord = numbers_in(text);
  if (chord.size() != 4 || glm::length(glm::dvec2(chord[0], chord[1]) - segment.end_m) > kSamePlace_m ||
      std::abs(chord[2] - segment.slope_start) > 1e-6 || std::abs(chord[3] - segment.slope_end) > 1e-6) {
    note(node, "userData roadgen:chord does not agree with the geometry, which is used");
    return;
  }
  if (glm::length(glm::dvec2(chord[0], chord[1]) - segment.start_m) < 10 * kSamePlace_m) return;
  segment.end_m = {chord[0], chord[1]};
  segment.slope_start = chord[2];
  segment.slope_end = chord[3];
  set_arc(segment);
}

Placed Reader::read_geometry(pugi::xml_node node) {
  Placed placed;
  placed.s_m = number(node, "s");
  placed.length_m = number(node, "length");
  const double heading = number(node, "hdg");
  if (failed()) return placed;
  if (!(placed.length_m > 0)) {
    fail(ErrorCode::kParse, node,
         "<geometry> has length=\"" + std::string(node.attribute("length").value()) + "\"; it must be positive");
    return placed;
  }
  const ParametricCubic curve = read_shape(node, heading, placed.length_m);
  if (failed()) return placed;
  Result<Segment> segment = segment_from_cubic(curve);
  if (!segment) {
    fail(ErrorCode::kData, node, segment.error().message);
    return placed;
  }
  placed.segment = *segment;
  take_exact_chord(node, placed.segment);
  if (std::abs(placed.segment.arc_m - placed.length_m) > kSamePlace_m * (1 + placed.length_m)) {
    note(node, "the length of a geometry is not the arc length of its curve, which is used");
  }
  return placed;
}

std::vector<Placed> Reader::read_plan(pugi::xml_node node) {
  std::vector<Placed> plan;
  for (const pugi::xml_node geometry : child(node, "planView").children("geometry")) {
    plan.push_back(read_geometry(geometry));
    if (failed()) return plan;
    const double expected = plan.size() == 1 ? 0 : plan[plan.size() - 2].s_m + plan[plan.size() - 2].length_m;
    if (std::abs(plan.back().s_m - expected) > kSameStation_m) {
      fail(ErrorCode::kParse, geometry,
           "<geometry> does not start where the one before ends: s is off by " +
               std::to_string(plan.back().s_m - expected) + " m");
    }
    if (plan.size() == 1) continue;
    join_end(plan[plan.size() - 2].segment, plan.back().segment.start_m);
  }
  if (!failed() && plan.empty()) fail(ErrorCode::kParse, node, "<planView> has no geometry");
  return plan;
}

std::vector<Record> Reader::read_records(pugi::xml_node parent, const char* name, const char* position) {
  std::vector<Record> records;
  for (const pugi::xml_node node : parent.children(name)) {
    records.push_back({number(node, position), cubic(node), line(node)});
    if (failed()) return records;
    if (records.size() > 1 && records.back().s_m <= records[records.size() - 2].s_m) {
      fail(ErrorCode::kParse, node, std::string("<") + name + "> records are not in order of " + position);
    }
  }
  return records;
}

// The record that holds over a geometry, relative to the geometry's start.
Cubic Reader::profile_over(const std::vector<Record>& records, const Placed& placed, const char* what) {
  const Record* holds = nullptr;
  for (const Record& record : records) {
    if (record.s_m <= placed.s_m + kSamePlace_m)
      holds = &record;
    else if (record.s_m < placed.s_m + placed.length_m - kSamePlace_m && !error_) {
      error_ = Error{ErrorCode::kData,
                     std::string("a record of the ") + what + " that begins within a geometry is not supported yet",
                     file_, record.line, element_};
    }
  }
  if (!holds) return {};
  const double by = placed.s_m - holds->s_m;
  const Cubic result = holds->cubic.shifted(std::abs(by) <= kSamePlace_m ? 0 : by);
  const Cubic::Range range = result.range(placed.segment.arc_m);
  if (!(std::abs(range.low) <= kGreatestProfile_m && std::abs(range.high) <= kGreatestProfile_m) && !error_) {
    error_ = Error{ErrorCode::kData, std::string("the ") + what + " is beyond 1e6 m", file_, holds->line, element_};
  }
  return result;
}

void Reader::refuse_lane_offset(pugi::xml_node lanes) {
  for (const Record& record : read_records(lanes, "laneOffset", "s")) {
    const Cubic& c = record.cubic;
    if ((c.c0 != 0 || c.c1 != 0 || c.c2 != 0 || c.c3 != 0) && !failed()) {
      error_ = Error{ErrorCode::kData, "<laneOffset> is not supported yet", file_, record.line, element_};
    }
  }
}

std::vector<Record> Reader::read_lane(pugi::xml_node side, const char* id) {
  int count = 0;
  for (const pugi::xml_node lane : side.children("lane")) {
    if (word(lane, "id") != id || ++count > 1) unsupported(lane, "more than one lane on each side is");
  }
  const pugi::xml_node lane = child(side, "lane");
  if (failed()) return {};
  const std::string type = word(lane, "type");
  if (type != "driving") unsupported(lane, "a lane of type \"" + type + "\" is");
  for (const pugi::xml_node part : lane.children()) {
    const std::string name = part.name();
    if (name == "border")
      unsupported(part, "a lane <border> is");
    else if (name == "roadMark" && std::strcmp(part.attribute("type").value(), "solid"))
      note(part, "road marks are not kept: edges become solid, the centre broken");
    else if (name != "width" && name != "roadMark" && name != "link")
      note(part, "<" + name + "> of lanes is not kept");
  }
  return read_records(lane, "width", "sOffset");
}

std::vector<Record> Reader::read_widths(pugi::xml_node node) {
  const pugi::xml_node lanes = child(node, "lanes");
  if (failed()) return {};
  refuse_lane_offset(lanes);
  const pugi::xml_node section = child(lanes, "laneSection");
  if (section.next_sibling("laneSection"))
    unsupported(section.next_sibling("laneSection"), "more than one lane section is");
  if (failed()) return {};
  if (!section.child("left") || !section.child("right")) unsupported(section, "a road without lanes on both sides is");
  const pugi::xml_node mark = section.child("center").child("lane").child("roadMark");
  if (mark && std::strcmp(mark.attribute("type").value(), "broken"))
    note(mark, "road marks are not kept: edges become solid, the centre broken");
  if (failed()) return {};

  const std::vector<Record> left = read_lane(section.child("left"), "1"),
                            right = read_lane(section.child("right"), "-1");
  if (failed()) return {};
  const auto same = [](const Record& a, const Record& b) {
    return a.s_m == b.s_m && a.cubic.c0 == b.cubic.c0 && a.cubic.c1 == b.cubic.c1 && a.cubic.c2 == b.cubic.c2 &&
           a.cubic.c3 == b.cubic.c3;
  };
  if (!std::equal(left.begin(), left.end(), right.begin(), right.end(), same))
    unsupported(section, "lanes of different widths on the two sides are");
  if (!failed() && (left.empty() || left.front().s_m > kSamePlace_m))
    fail(ErrorCode::kParse, section, "a lane has no <width> at its start");
  return left;
}

void Reader::close_loop(pugi::xml_node node, Road& road) {
  const glm::dvec2 start = road.segments.front().start_m;
  if (glm::length(road.segments.back().end_m - start) > kSameStation_m) {
    return fail(ErrorCode::kData, node, "the road is linked to itself but does not end where it starts");
  }
  join_end(road.segments.back(), start);
}

void Reader::read_road(pugi::xml_node node) {
  Road road;
  road.id = word(node, "id");
  element_ = "road " + road.id;
  road.name = node.attribute("name").value();
  if (node.attribute("junction").as_int(-1) != -1) unsupported(node, "a road of a junction is");
  for (const char* name : {"type", "objects", "signals", "surface", "railroad"}) {
    if (node.child(name)) note(node.child(name), std::string("<") + name + "> of roads is not kept");
  }
  read_links(node, road);
  refuse_lateral(node);
  if (failed()) return;

  const std::vector<Placed> plan = read_plan(node);
  if (failed()) return;
  const std::vector<Record> heights = read_records(node.child("elevationProfile"), "elevation", "s");
  if (failed()) return;
  const std::vector<Record> widths = read_widths(node);
  if (failed()) return;
  for (const Placed& placed : plan) {
    Segment segment = placed.segment;
    segment.elevation_m = profile_over(heights, placed, "elevation");
    segment.set_half_width_m(profile_over(widths, placed, "width"));
    road.segments.push_back(segment);
  }
  if (road.closed) close_loop(node, road);
  if (failed()) return;
  for (Segment& segment : road.segments) set_bound(segment);
  chain_arc_lengths(road);
  two_lane_sections(road);
  network_.roads.push_back(std::move(road));
}

Result<Network> Reader::read(Diagnostics* diagnostics) {
  if (Status status = check_utf8(text_, file_); !status) return status.error();
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text_.data(), text_.size());
  if (!parsed) {
    return Error{ErrorCode::kParse, std::string("is not well-formed XML (truncated?): ") + parsed.description(), file_,
                 lines_.line(parsed.offset)};
  }
  const pugi::xml_node root = document.child("OpenDRIVE");
  if (!root) return Error{ErrorCode::kParse, "is not OpenDRIVE: there is no <OpenDRIVE> element", file_, 1};

  read_header(child(root, "header"));
  std::set<std::string> ids;
  for (const pugi::xml_node node : root.children()) {
    element_.clear();
    const std::string name = node.name();
    if (name == "junction")
      unsupported(node, "<junction> is");
    else if (name == "road")
      read_road(node);
    else if (name != "header")
      note(node, "<" + name + "> is not kept");
    if (failed()) return *error_;
    if (name == "road" && !ids.insert(network_.roads.back().id).second) {
      fail(ErrorCode::kParse, node, "the id is used twice");
      return *error_;
    }
  }
  if (network_.roads.empty()) return Error{ErrorCode::kData, "holds no roads", file_};
  if (diagnostics) {
    for (const auto& [what, seen] : notes_) {
      const std::string times = seen.count > 1 ? " (" + std::to_string(seen.count) + " times, first here)" : "";
      diagnostics->push_back({Severity::kWarning, what + times, file_, seen.line, seen.element});
    }
  }
  return std::move(network_);
}

}  // namespace

Result<Network> parse_opendrive(std::string_view text, const std::string& file, Diagnostics* diagnostics) {
  return Reader(text, file).read(diagnostics);
}

Result<Network> read_opendrive(const std::string& path, Diagnostics* diagnostics) {
  const Result<std::string> text = read_file(path);
  if (!text) return text.error();
  return parse_opendrive(*text, path, diagnostics);
}

}  // namespace roadgen
