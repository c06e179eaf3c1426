#include "roadgen/import/opendrive.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <vector>

#include "roadgen/import/plan_curve.h"
#include "roadgen/import/xodr_lanes.h"
#include "roadgen/import/xodr_lateral.h"
#include "roadgen/import/xodr_objects.h"

namespace roadgen {
namespace {

// Greatest break in s from one geometry to the next; less than kLeastPiece_m.
constexpr double kSameStation_m = 1e-3;
constexpr double kGreatest_m = 1e9;
// A spiral or arc that turns more often than this is a mistake.
constexpr double kMostTurning_rad = 100;
// What a foreign curve is certified for where its road is narrower.
constexpr double kLeastHalfWidth_m = 0.5;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * M_PI); }

// How far a foreign file's geometries may miss one another at a joint that is closed.
constexpr double kClosedGap_m = 0.01;
constexpr double kClosedTurn_rad = 1e-3;

// Moves the end onto the next segment's start, and its heading onto the next one's, where they are closer than this; the
// heading at the segment's own start stays. Returns the gap that was closed.
double join_end(Segment& segment, const Segment& next, double most_m, double most_rad) {
  const double gap_m = glm::length(segment.end_m - next.start_m), length_m = segment.chord_length_m();
  const double start_rad = heading_rad(segment, 0), end_rad = heading_rad(segment, 1);
  const double turn_rad = wrapped(heading_rad(next, 0) - end_rad);
  const bool turns = std::abs(turn_rad) > 1e-12 && std::abs(turn_rad) <= most_rad;
  if (gap_m > most_m || gap_m > 0.1 * length_m || (gap_m == 0 && !turns)) return 0;
  segment.end_m = next.start_m;
  const glm::dvec2 chord = segment.chord_m();
  const double chord_rad = std::atan2(chord.y, chord.x);
  segment.slope_start = std::tan(start_rad - chord_rad);
  segment.slope_end = std::tan(end_rad + (turns ? turn_rad : 0) - chord_rad);
  set_arc(segment);
  return gap_m;
}

// Value of +KEY=VALUE in a PROJ string.
std::string proj_value(std::string_view proj, std::string_view key) {
  const std::string wanted = "+" + std::string(key) + "=";
  const std::size_t at = proj.find(wanted);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = proj.substr(at + wanted.size());
  return std::string(rest.substr(0, rest.find_first_of(" \t\r\n")));
}

// A <geometry> of the file.
struct Geometry {
  double s_m = 0, length_m = 0;
  PlanCurve curve = Clothoid{};
  double arc_m = 0;            // of the curve
  std::optional<Segment> own;  // written by us, unrounded
  int line = 0;
};

// A segment and the stretch [from_m, to_m] of the file's s that it stands for; length_m by its geometry.
struct Placed {
  Segment segment;
  double from_m = 0, to_m = 0, length_m = 0;
  bool own = false;  // written by us
};

// Reads one document. The first error stops everything: each step returns early once the source has failed.
class Reader {
 public:
  Reader(std::string_view text, std::string file) : text_(text), source_(text, std::move(file)) {}

  Result<Network> read(Diagnostics* diagnostics);

 private:
  bool failed() const { return source_.failed(); }

  void read_header(pugi::xml_node header);
  void read_origin(pugi::xml_node header);
  void read_road(pugi::xml_node node);
  void note_unkept(pugi::xml_node node);
  void read_links(pugi::xml_node node, Road& road);
  std::optional<PlanCurve> read_shape(pugi::xml_node node, double heading_rad, double length_m);
  std::optional<PlanCurve> read_param_poly3(pugi::xml_node shape, glm::dvec2 start_m, double heading_rad,
                                            double length_m);
  std::optional<Segment> exact_segment(pugi::xml_node node, const PlanCurve& curve);
  Geometry read_geometry(pugi::xml_node node);
  std::vector<Geometry> read_plan(pugi::xml_node node);
  std::vector<Placed> place(const std::vector<Geometry>& plan, const Stations& stations,
                            const std::vector<LaneSection>& sections);
  void join(std::vector<Placed>& placed, bool closed, pugi::xml_node node);
  void take_sections(Road& road, const std::vector<Placed>& placed, std::vector<LaneSection> sections, double end_m);
  void set_profiles(Road& road, const std::vector<Placed>& placed, const Profile& heights, const XodrLateral& lateral,
                    const Stations& stations);

  std::string_view text_;
  XodrSource source_;
  Network network_;
};

void Reader::read_header(pugi::xml_node header) {
  if (source_.number(header, "revMajor") != 1 && !failed()) {
    source_.fail(ErrorCode::kData, header, "an OpenDRIVE version other than 1.x is not supported yet");
  }
  network_.name = header.attribute("name").value();
  if (!failed()) read_origin(header);
}

void Reader::read_origin(pugi::xml_node header) {
  std::vector<double> origin = numbers_in(user_data(header, "roadgen:origin"));
  const pugi::xml_node reference = header.child("geoReference");
  if (origin.size() != 3) {
    const std::string proj = reference.text().get();
    if (trimmed(proj).empty()) return;
    if (proj_value(proj, "proj") != "ortho") {
      source_.note(reference, "the geoReference is not +proj=ortho and is not kept");
      return;
    }
    origin = numbers_in(proj_value(proj, "lat_0") + " " + proj_value(proj, "lon_0") + " 0");
  }
  if (origin.size() != 3 || std::abs(origin[0]) > 90 || std::abs(origin[1]) > 180) {
    source_.fail(ErrorCode::kParse, reference, "the origin is not a latitude and longitude in degrees");
    return;
  }
  network_.georeference = Georeference{origin[0], origin[1], origin[2]};
}

void Reader::note_unkept(pugi::xml_node node) {
  for (const char* name : {"type", "surface", "railroad"}) {
    if (node.child(name)) source_.note(node.child(name), std::string("<") + name + "> of roads is not kept");
  }
  if (node.attribute("junction").as_int(-1) != -1) {
    source_.note(node, "junctions are not kept: their roads are read as roads");
  }
  if (!std::strcmp(node.attribute("rule").value(), "LHT")) source_.note(node, "left-hand traffic is not kept");
}

void Reader::read_links(pugi::xml_node node, Road& road) {
  for (const pugi::xml_node link : node.child("link").children()) {
    if (link.attribute("elementId").value() == road.id && !std::strcmp(link.attribute("elementType").value(), "road")) {
      road.closed = true;
    } else {
      source_.note(link, "links to other roads are not kept");
    }
  }
}

std::optional<PlanCurve> Reader::read_param_poly3(pugi::xml_node shape, glm::dvec2 start_m, double heading_rad,
                                                  double length_m) {
  const glm::dvec2 offset(source_.number(shape, "aU"), source_.number(shape, "aV"));
  ParametricCubic curve{offset,
                        {source_.number(shape, "bU"), source_.number(shape, "bV")},
                        {source_.number(shape, "cU"), source_.number(shape, "cV")},
                        {source_.number(shape, "dU"), source_.number(shape, "dV")}};
  const std::string range = shape.attribute("pRange").as_string("arcLength");  // the default of OpenDRIVE 1.4
  if (range == "arcLength")
    curve = curve.rescaled(length_m);
  else if (range != "normalized")
    source_.fail(ErrorCode::kParse, shape, "pRange=\"" + range + "\" is neither arcLength nor normalized");
  curve = curve.turned(heading_rad);
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  curve.start_m = start_m + glm::dvec2(c * offset.x - s * offset.y, s * offset.x + c * offset.y);
  return curve;
}

std::optional<PlanCurve> Reader::read_shape(pugi::xml_node node, double heading_rad, double length_m) {
  const glm::dvec2 start(source_.number(node, "x"), source_.number(node, "y"));
  const pugi::xml_node shape = node.find_child(
      [](pugi::xml_node n) { return n.type() == pugi::node_element && std::strcmp(n.name(), "userData") != 0; });
  const std::string kind = shape.name();
  if (kind == "line") return Clothoid{start, heading_rad, length_m, 0, 0};
  if (kind == "arc" || kind == "spiral") {
    const bool arc = kind == "arc";
    const double first = source_.number(shape, arc ? "curvature" : "curvStart");
    const double last = arc ? first : source_.number(shape, "curvEnd");
    if (length_m * std::max(std::abs(first), std::abs(last)) > kMostTurning_rad) {
      source_.fail(ErrorCode::kData, shape, "the geometry turns by more than 100 rad");
    }
    return Clothoid{start, heading_rad, length_m, first, last};
  }
  if (kind == "poly3") {
    const Cubic v = source_.cubic(shape);
    for (const double x : {v.c0, v.c1, v.c2, v.c3}) {
      if (std::abs(x) > kGreatest_m) source_.fail(ErrorCode::kGeometry, shape, "the geometry is beyond 1e9 m");
    }
    if (failed()) return {};
    return PlanCurve::poly3(start, heading_rad, v, length_m);
  }
  if (kind == "paramPoly3") return read_param_poly3(shape, start, heading_rad, length_m);
  if (shape)
    source_.fail(ErrorCode::kData, shape, "the geometry <" + kind + "> is not known");
  else
    source_.fail(ErrorCode::kParse, node, "<geometry> has no shape");
  return {};
}

// Our own files carry the anchors and slopes unrounded; they count only where they agree with the shape.
std::optional<Segment> Reader::exact_segment(pugi::xml_node node, const PlanCurve& curve) {
  const std::string text = user_data(node, "roadgen:chord");
  if (text.empty() || !curve.parametric()) return {};
  const std::vector<double> chord = numbers_in(text);
  const Result<Segment> rounded = segment_from_cubic(*curve.parametric());
  if (chord.size() != 4 || !rounded || glm::length(glm::dvec2(chord[0], chord[1]) - rounded->end_m) > kSamePlace_m ||
      std::abs(chord[2] - rounded->slope_start) > 1e-6 || std::abs(chord[3] - rounded->slope_end) > 1e-6) {
    source_.note(node, "userData roadgen:chord does not agree with the geometry, which is used");
    return {};
  }
  Segment segment = *rounded;
  if (!(glm::length(glm::dvec2(chord[0], chord[1]) - segment.start_m) > 0)) return segment;
  segment.end_m = {chord[0], chord[1]};
  segment.slope_start = chord[2];
  segment.slope_end = chord[3];
  set_arc(segment);
  return segment;
}

Geometry Reader::read_geometry(pugi::xml_node node) {
  Geometry geometry;
  geometry.s_m = source_.number(node, "s");
  geometry.length_m = source_.number(node, "length");
  geometry.line = source_.line(node);
  const double heading = source_.number(node, "hdg");
  if (failed()) return geometry;
  if (!(geometry.length_m > 0)) {
    source_.fail(
        ErrorCode::kParse, node,
        "<geometry> has length=\"" + std::string(node.attribute("length").value()) + "\"; it must be positive");
    return geometry;
  }
  const std::optional<PlanCurve> curve = read_shape(node, heading, geometry.length_m);
  if (failed()) return geometry;
  geometry.curve = *curve;
  for (const double p : {0.0, 0.5, 1.0}) {
    const glm::dvec2 at = curve->position_m(p), along = curve->derivative_m(p);
    const bool usable = std::max({std::abs(at.x), std::abs(at.y), std::abs(along.x), std::abs(along.y)}) <= kGreatest_m;
    if (!usable) source_.fail(ErrorCode::kGeometry, node, "the geometry is beyond 1e9 m");
  }
  geometry.arc_m = curve->arc_m(0, 1);
  if (!failed() && !(geometry.arc_m > 1e-9 && geometry.arc_m <= 4 * kGreatest_m)) {
    source_.fail(ErrorCode::kGeometry, node, "the geometry starts and ends at the same point, or is beyond 1e9 m");
  }
  if (failed()) return geometry;
  geometry.own = exact_segment(node, *curve);
  const double arc = geometry.own ? geometry.own->arc_m : geometry.arc_m;
  if (std::abs(arc - geometry.length_m) > kSamePlace_m * (1 + geometry.length_m)) {
    source_.note(node, "the length of a geometry is not the arc length of its curve, which is used");
  }
  return geometry;
}

std::vector<Geometry> Reader::read_plan(pugi::xml_node node) {
  std::vector<Geometry> plan;
  for (const pugi::xml_node geometry : node.child("planView").children("geometry")) {
    plan.push_back(read_geometry(geometry));
    if (failed()) return plan;
    const double expected = plan.size() == 1 ? 0 : plan[plan.size() - 2].s_m + plan[plan.size() - 2].length_m;
    if (std::abs(plan.back().s_m - expected) > kSameStation_m) {
      source_.fail(ErrorCode::kParse, geometry,
                   "<geometry> does not start where the one before ends: s is off by " +
                       std::to_string(plan.back().s_m - expected) + " m");
    }
  }
  if (!failed() && plan.empty()) source_.fail(ErrorCode::kParse, node, "the road has no <planView> with a <geometry>");
  return plan;
}

// The greatest |t| of the road's edges over [from_m, to_m], which lies in one section.
double half_width_m(const std::vector<LaneSection>& sections, double from_m, double to_m) {
  const auto after = std::partition_point(sections.begin(), sections.end(),
                                          [&](const LaneSection& section) { return section.s_m <= from_m; });
  const LaneSection& section = after == sections.begin() ? *after : *(after - 1);
  const std::vector<Cubic> borders = section.borders_m();
  double most = kLeastHalfWidth_m;
  for (const Cubic& edge : {borders.front(), borders.back()}) {
    const Cubic::Range range = edge.shifted(from_m - section.s_m).range(to_m - from_m);
    most = std::max({most, range.high, -range.low});
  }
  return most;
}

std::vector<Placed> Reader::place(const std::vector<Geometry>& plan, const Stations& stations,
                                  const std::vector<LaneSection>& sections) {
  std::vector<Placed> placed;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const Geometry& g = plan[i];
    std::vector<double> at = stations.between(g.s_m, i + 1 < plan.size() ? plan[i + 1].s_m : stations.end_m());
    at.push_back(i + 1 < plan.size() ? plan[i + 1].s_m : stations.end_m());
    if (at.size() == 2 && g.own) {
      placed.push_back({*g.own, at[0], at[1], g.length_m, true});
      continue;
    }
    const double scale = g.length_m / g.arc_m;
    double p0 = 0;
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
      const double p1 = k + 2 == at.size() ? 1 : g.curve.p_at_arc((at[k + 1] - g.s_m) / scale);
      std::vector<CurvePiece> pieces;
      if (!divide_curve(g.curve, p0, p1, half_width_m(sections, at[k], at[k + 1]), pieces)) {
        source_.fail(ErrorCode::kGeometry, g.line, "the geometry stops or reverses on the spot");
        return placed;
      }
      double from = at[k];
      for (const CurvePiece& piece : pieces) {
        const double length = scale * g.curve.arc_m(piece.p0, piece.p1);
        const double to = &piece == &pieces.back() ? at[k + 1] : from + length;
        placed.push_back({piece.segment, from, to, length});
        from = to;
      }
      p0 = p1;
    }
  }
  return placed;
}

void Reader::join(std::vector<Placed>& placed, bool closed, pugi::xml_node node) {
  double widest = 0;
  const auto join_pair = [&](Placed& before, const Placed& after) {
    // What we wrote ourselves is exact.
    const bool exact = before.own && after.own;
    widest = std::max(widest, join_end(before.segment, after.segment, exact ? kSamePlace_m : kClosedGap_m,
                                       exact ? 0 : kClosedTurn_rad));
  };
  for (std::size_t i = 0; i + 1 < placed.size(); ++i) join_pair(placed[i], placed[i + 1]);
  if (closed && glm::length(placed.back().segment.end_m - placed.front().segment.start_m) > kClosedGap_m) {
    source_.fail(ErrorCode::kData, node, "the road is linked to itself but does not end where it starts");
    return;
  }
  if (closed) join_pair(placed.back(), placed.front());
  if (widest > kSamePlace_m) source_.note(node, "gaps between geometries of up to 0.01 m are closed");
}

// Puts the sections, which are in the file's s, on the road's own.
void Reader::take_sections(Road& road, const std::vector<Placed>& placed, std::vector<LaneSection> sections,
                           double end_m) {
  std::size_t joint = 0;
  std::vector<double> start_m;
  for (LaneSection& section : sections) {
    while (joint + 1 < placed.size() && placed[joint].from_m < section.s_m) ++joint;
    start_m.push_back(road.segments[joint].s_start_m);
  }
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const bool last = i + 1 == sections.size();
    const double length = (last ? end_m : sections[i + 1].s_m) - sections[i].s_m;
    const double arc = (last ? road.length_m() : start_m[i + 1]) - start_m[i];
    sections[i].offset_m = scaled(sections[i].offset_m, length, arc);
    for (auto* side : {&sections[i].left, &sections[i].right}) {
      for (Lane& lane : *side) lane.width_m = scaled(lane.width_m, length, arc);
    }
  }
  for (std::size_t i = 0; i < sections.size(); ++i) sections[i].s_m = start_m[i];
  if (Status status = set_sections(road, std::move(sections)); !status) {
    source_.fail(ErrorCode::kData, 0, status.error().message);
  }
}

void Reader::set_profiles(Road& road, const std::vector<Placed>& placed, const Profile& heights,
                          const XodrLateral& lateral, const Stations& stations) {
  double deviation = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Segment& segment = road.segments[i];
    const Placed& from = placed[i];
    segment.elevation_m = scaled(cubic_from(heights, from.from_m, stations), from.length_m, segment.arc_m);
    const Cubic::Range range = segment.elevation_m.range(segment.arc_m);
    if (!(range.low >= -kGreatestProfile && range.high <= kGreatestProfile)) {
      source_.fail(ErrorCode::kData, holding(heights, from.from_m, stations)->line, "the elevation is beyond 1e6 m");
    }
    deviation =
        std::max(deviation, set_lateral(source_, lateral, stations, from.from_m, from.to_m, from.length_m, segment));
    if (failed()) return;
  }
  if (deviation > kSamePlace_m) {
    char text[96];
    std::snprintf(text, sizeof text, "crossfall and shape are kept as slopes to both sides, to %.3g m", deviation);
    source_.note(lateral.first_line(), text);
  }
}

void Reader::read_road(pugi::xml_node node) {
  Road road;
  road.id = source_.word(node, "id");
  source_.set_element("road " + road.id);
  road.name = node.attribute("name").value();
  note_unkept(node);
  read_links(node, road);
  if (failed()) return;

  const std::vector<Geometry> plan = read_plan(node);
  if (failed()) return;
  const Profile heights = read_profile(source_, node.child("elevationProfile"), "elevation", "s");
  const XodrLateral lateral = read_lateral(source_, node);
  if (failed()) return;
  const XodrLanes lanes = read_lanes(source_, node);
  if (failed()) return;

  std::vector<double> starts;
  for (const Geometry& geometry : plan) starts.push_back(geometry.s_m);
  Stations stations(starts, plan.back().s_m + plan.back().length_m);
  for (const double s : lanes.changes_m()) stations.add(s);
  for (const double s : lateral.changes_m()) stations.add(s);
  for (const auto& record : heights) stations.add(record.s_m);

  std::vector<LaneSection> sections = lane_sections(source_, lanes, stations, starts.front());
  if (failed()) return;
  std::vector<Placed> placed = place(plan, stations, sections);
  if (failed()) return;
  join(placed, road.closed, node);
  if (failed()) return;
  for (const Placed& p : placed) road.segments.push_back(p.segment);
  chain_arc_lengths(road);
  take_sections(road, placed, std::move(sections), stations.end_m());
  if (failed()) return;
  set_profiles(road, placed, heights, lateral, stations);
  if (failed()) return;
  road.paint = read_paint(source_, node, road, [&](double s) {
    const auto after =
        std::partition_point(placed.begin() + 1, placed.end(), [&](const Placed& p) { return p.from_m <= s; });
    const std::size_t i = static_cast<std::size_t>(after - placed.begin()) - 1;
    const Segment& segment = road.segments[i];
    if (placed[i].length_m == segment.arc_m) return s + (segment.s_start_m - placed[i].from_m);
    return segment.s_start_m + (s - placed[i].from_m) * (segment.arc_m / placed[i].length_m);
  });
  network_.roads.push_back(std::move(road));
}

Result<Network> Reader::read(Diagnostics* diagnostics) {
  if (Status status = check_utf8(text_, source_.file()); !status) return status.error();
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(text_.data(), text_.size());
  if (!parsed) {
    source_.fail(ErrorCode::kParse, LineIndex(text_).line(parsed.offset),
                 std::string("is not well-formed XML (truncated?): ") + parsed.description());
    return source_.error();
  }
  const pugi::xml_node root = document.child("OpenDRIVE");
  if (!root) return Error{ErrorCode::kParse, "is not OpenDRIVE: there is no <OpenDRIVE> element", source_.file(), 1};

  if (const pugi::xml_node header = root.child("header"))
    read_header(header);
  else
    source_.fail(ErrorCode::kParse, root, "<OpenDRIVE> lacks <header>");
  std::set<std::string> ids;
  for (const pugi::xml_node node : root.children()) {
    if (failed()) return source_.error();
    source_.set_element("");
    const std::string name = node.name();
    if (name == "road") {
      read_road(node);
      if (!failed() && !ids.insert(network_.roads.back().id).second) {
        source_.fail(ErrorCode::kParse, node, "the id is used twice");
      }
    } else if (name == "junction") {
      source_.note(node, "junctions are not kept: their roads are read as roads");
    } else if (name != "header" && node.type() == pugi::node_element) {
      source_.note(node, "<" + name + "> is not kept");
    }
  }
  if (failed()) return source_.error();
  if (network_.roads.empty()) return Error{ErrorCode::kData, "holds no roads", source_.file()};
  if (diagnostics) {
    for (Diagnostic& note : source_.notes()) diagnostics->push_back(std::move(note));
    for (const Road& road : network_.roads) {
      OddValues odd = odd_values(road);
      for (auto* texts : {&odd.problems, &odd.warnings}) {
        for (std::string& text : *texts) {
          diagnostics->push_back({Severity::kWarning, std::move(text), source_.file()});
        }
      }
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
