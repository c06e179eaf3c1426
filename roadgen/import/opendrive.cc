#include "roadgen/import/opendrive.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <vector>

#include "roadgen/import/xodr_areas.h"
#include "roadgen/import/xodr_lanes.h"
#include "roadgen/import/xodr_lateral.h"
#include "roadgen/import/xodr_links.h"
#include "roadgen/import/xodr_objects.h"
#include "roadgen/import/xodr_plan.h"

namespace roadgen {
namespace {

// Value of +KEY=VALUE in a PROJ string.
std::string proj_value(std::string_view proj, std::string_view key) {
  const std::string wanted = "+" + std::string(key) + "=";
  const std::size_t at = proj.find(wanted);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = proj.substr(at + wanted.size());
  return std::string(rest.substr(0, rest.find_first_of(" \t\r\n")));
}

// A connecting road that follows from its junction's area.
bool is_derived(pugi::xml_node road) { return !user_data(road, "roadgen:derived").empty(); }

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
  void connect();
  void note_unkept(pugi::xml_node node);
  void take_sections(Road& road, const std::vector<PlacedSegment>& placed, std::vector<LaneSection> sections,
                     double end_m);
  void set_profiles(Road& road, const std::vector<PlacedSegment>& placed, const Profile& heights,
                    const XodrLateral& lateral, const Stations& stations);

  std::string_view text_;
  XodrSource source_;
  Network network_;
  std::vector<bool> exact_ends_;  // of the roads: the file says which ends are joined
  std::vector<XodrJunction> junctions_;
  std::set<std::string> derived_;  // ids of roads that are left out, since they follow from areas
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
}

// Puts the sections, which are in the file's s, on the road's own.
void Reader::take_sections(Road& road, const std::vector<PlacedSegment>& placed, std::vector<LaneSection> sections,
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

void Reader::set_profiles(Road& road, const std::vector<PlacedSegment>& placed, const Profile& heights,
                          const XodrLateral& lateral, const Stations& stations) {
  double deviation = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Segment& segment = road.segments[i];
    const PlacedSegment& from = placed[i];
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
  road.keep_left = !std::strcmp(node.attribute("rule").value(), "LHT");
  note_unkept(node);
  read_links(source_, node, road);
  exact_ends_.push_back(read_joined(source_, node, road));
  if (failed()) return;

  const std::vector<XodrGeometry> plan = read_plan_view(source_, node);
  if (failed()) return;
  const Profile heights = read_profile(source_, node.child("elevationProfile"), "elevation", "s");
  const XodrLateral lateral = read_lateral(source_, node);
  if (failed()) return;
  const XodrLanes lanes = read_lanes(source_, node);
  if (failed()) return;

  std::vector<double> starts;
  for (const XodrGeometry& geometry : plan) starts.push_back(geometry.s_m);
  Stations stations(starts, plan.back().s_m + plan.back().length_m);
  for (const double s : lanes.changes_m()) stations.add(s);
  for (const double s : lateral.changes_m()) stations.add(s);
  for (const auto& record : heights) stations.add(record.s_m);

  std::vector<LaneSection> sections = lane_sections(source_, lanes, stations, starts.front());
  if (failed()) return;
  std::vector<PlacedSegment> placed = place_segments(source_, plan, stations, sections);
  if (failed()) return;
  join_segments(source_, placed, road.closed, node);
  if (failed()) return;
  for (const PlacedSegment& p : placed) road.segments.push_back(p.segment);
  chain_arc_lengths(road);
  take_sections(road, placed, std::move(sections), stations.end_m());
  if (failed()) return;
  set_profiles(road, placed, heights, lateral, stations);
  if (failed()) return;
  read_objects(source_, node, road, [&](double s) {
    const auto after =
        std::partition_point(placed.begin() + 1, placed.end(), [&](const PlacedSegment& p) { return p.from_m <= s; });
    const std::size_t i = static_cast<std::size_t>(after - placed.begin()) - 1;
    const Segment& segment = road.segments[i];
    if (placed[i].length_m == segment.arc_m) return s + (segment.s_start_m - placed[i].from_m);
    return segment.s_start_m + (s - placed[i].from_m) * (segment.arc_m / placed[i].length_m);
  });
  network_.roads.push_back(std::move(road));
}

// Links and junctions, once all roads are there.
void Reader::connect() {
  for (XodrJunction& junction : junctions_) {
    if (!junction.area) continue;
    std::erase_if(junction.links.connections, [&](const Connection& c) { return derived_.contains(c.connecting); });
  }
  // Our own file's areas without ways through them are areas alone.
  for (const XodrJunction& junction : junctions_) {
    const bool lone = junction.area && junction.links.connections.empty() && junction.links.name.empty();
    if (!lone) network_.junction_links.push_back(junction.links);
  }
  add_areas(source_, junctions_, network_);
  settle_links(source_, network_);
  exact_ends_.resize(network_.roads.size(), true);  // roads around corners, which have no links
  join_linked_ends(network_, exact_ends_);
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
  std::set<std::string> ids, junction_ids;
  for (const pugi::xml_node node : root.children()) {
    if (failed()) return source_.error();
    source_.set_element("");
    const std::string name = node.name();
    if (name == "road" && is_derived(node)) {
      derived_.insert(node.attribute("id").value());
    } else if (name == "road") {
      read_road(node);
      if (!failed() && !ids.insert(network_.roads.back().id).second) {
        source_.fail(ErrorCode::kParse, node, "the id is used twice");
      }
    } else if (name == "junction") {
      junctions_.push_back(read_junction(source_, node));
      source_.set_element("junction " + junctions_.back().links.id);
      if (!failed() && !junction_ids.insert(junctions_.back().links.id).second) {
        source_.fail(ErrorCode::kParse, node, "the id is used twice");
      }
    } else if (name != "header" && node.type() == pugi::node_element) {
      source_.note(node, "<" + name + "> is not kept");
    }
  }
  if (failed()) return source_.error();
  if (network_.roads.empty()) return Error{ErrorCode::kData, "holds no roads", source_.file()};
  connect();
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
