#include "roadgen/import/opendrive.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <vector>

#include "roadgen/import/xml_parts.h"
#include "roadgen/import/xodr_areas.h"
#include "roadgen/import/xodr_header.h"
#include "roadgen/import/xodr_lanes.h"
#include "roadgen/import/xodr_lateral.h"
#include "roadgen/import/xodr_links.h"
#include "roadgen/import/xodr_objects.h"
#include "roadgen/import/xodr_plan.h"
#include "roadgen/import/xodr_records.h"
#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

// Bounds of memory, however often a file repeats its elements: 8 GiB of text, of which a part at a time is parsed.
constexpr std::uintmax_t kMostFile_bytes = std::uintmax_t{8} << 30;
constexpr std::size_t kMostChildren = 5'000'000;
constexpr std::size_t kMostTags = 1'000'000;

// A connecting road that follows from its junction's area.
bool is_derived(pugi::xml_node road) { return !user_data(road, "roadgen:derived").empty(); }

// One child of <OpenDRIVE>, read by itself.
struct Part {
  explicit Part(const XmlPart& from, const std::string& file) : source(from.text, file, from.line) {}

  XodrSource source;
  std::optional<Error> malformed;  // not XML
  std::optional<XodrHeader> header;
  std::optional<Road> road;
  bool exact_ends = false;             // the file says which ends of the road are joined
  std::optional<std::string> derived;  // id of a road that is left out
  std::optional<XodrJunction> junction;
  std::optional<Controller> controller;
  std::string other_xml;
};

// Puts the sections, which are in the file's s, on the road's own.
void take_sections(XodrSource& source, Road& road, const std::vector<PlacedSegment>& placed,
                   std::vector<LaneSection> sections, double end_m) {
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
    source.fail(ErrorCode::kData, 0, status.error().message);
  }
}

void set_profiles(XodrSource& source, Road& road, const std::vector<PlacedSegment>& placed, const Profile& heights,
                  const XodrLateral& lateral, const Stations& stations) {
  double deviation = 0;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    Segment& segment = road.segments[i];
    const PlacedSegment& from = placed[i];
    segment.elevation_m = scaled(cubic_from(heights, from.from_m, stations), from.length_m, segment.arc_m);
    const Cubic::Range range = segment.elevation_m.range(segment.arc_m);
    if (!(range.low >= -kGreatestProfile && range.high <= kGreatestProfile)) {
      source.fail(ErrorCode::kData, holding(heights, from.from_m, stations)->line, "the elevation is beyond 1e6 m");
    }
    deviation =
        std::max(deviation, set_lateral(source, lateral, stations, from.from_m, from.to_m, from.length_m, segment));
    if (source.failed()) return;
  }
  if (deviation > kSamePlace_m) {
    char text[96];
    std::snprintf(text, sizeof text, "crossfall and shape are kept as slopes to both sides, to %.3g m", deviation);
    source.note(lateral.first_line(), text);
  }
}

void read_road(Part& part, pugi::xml_node node) {
  XodrSource& source = part.source;
  Road& road = part.road.emplace();
  road.id = source.word(node, "id");
  source.set_element("road " + road.id);
  road.name = node.attribute("name").value();
  road.keep_left = !std::strcmp(node.attribute("rule").value(), "LHT");
  read_links(source, node, road);
  part.exact_ends = read_joined(source, node, road);
  if (source.failed()) return;

  const std::vector<XodrGeometry> plan = read_plan_view(source, node);
  if (source.failed()) return;
  const Profile heights = read_profile(source, node.child("elevationProfile"), "elevation", "s");
  const XodrLateral lateral = read_lateral(source, node);
  if (source.failed()) return;
  const XodrLanes lanes = read_lanes(source, node);
  if (source.failed()) return;

  std::vector<double> starts;
  for (const XodrGeometry& geometry : plan) starts.push_back(geometry.s_m);
  Stations stations(starts, plan.back().s_m + plan.back().length_m);
  for (const double s : lanes.changes_m()) stations.add(s);
  for (const double s : lateral.changes_m()) stations.add(s);
  for (const auto& record : heights) stations.add(record.s_m);

  auto [sections, lane_records] = lane_sections(source, lanes, stations, starts.front());
  if (source.failed()) return;
  std::vector<PlacedSegment> placed = place_segments(source, plan, stations, sections);
  if (source.failed()) return;
  join_segments(source, placed, road.closed, node);
  if (source.failed()) return;
  for (const PlacedSegment& p : placed) road.segments.push_back(p.segment);
  chain_arc_lengths(road);
  take_sections(source, road, placed, std::move(sections), stations.end_m());
  if (source.failed()) return;
  set_profiles(source, road, placed, heights, lateral, stations);
  if (source.failed()) return;
  if (!lane_records.empty()) road.records.edit().lanes = std::move(lane_records);
  read_objects(source, node, road, [&](double s) {
    const auto after =
        std::partition_point(placed.begin() + 1, placed.end(), [&](const PlacedSegment& p) { return p.from_m <= s; });
    const std::size_t i = static_cast<std::size_t>(after - placed.begin()) - 1;
    const Segment& segment = road.segments[i];
    if (placed[i].length_m == segment.arc_m) return s + (segment.s_start_m - placed[i].from_m);
    return segment.s_start_m + (s - placed[i].from_m) * (segment.arc_m / placed[i].length_m);
  });
}

pugi::xml_parse_result parse(pugi::xml_document& document, std::string_view text) {
  return document.load_buffer(text.data(), text.size(), pugi::parse_default, pugi::encoding_utf8);
}

Error not_well_formed(const XodrSource& source, const pugi::xml_parse_result& parsed) {
  return {ErrorCode::kParse, std::string("is not well-formed XML (truncated?): ") + parsed.description(), source.file(),
          source.line(parsed.offset)};
}

void read_part(Part& part, const XmlPart& from) {
  pugi::xml_document document;
  if (const pugi::xml_parse_result parsed = parse(document, from.text); !parsed) {
    part.malformed = not_well_formed(part.source, parsed);
    return;
  }
  const pugi::xml_node node = document.first_child();
  const std::string name = node.name();
  if (name == "header") {
    part.header = read_header(part.source, node);
  } else if (name == "road" && is_derived(node)) {
    part.derived = node.attribute("id").value();
  } else if (name == "road") {
    read_road(part, node);
  } else if (name == "junction" || (name == "userData" && holds_junction(node))) {
    part.junction = read_junction(part.source, node);
  } else if (name == "controller") {
    part.controller = read_controller(part.source, node);
  } else if (name == "station" || name == "junctionGroup" || name == "userData" || name == "dataQuality") {
    part.other_xml = element_xml(node);
  } else {
    part.source.note(node, "<" + name + "> is not kept");
  }
}

// Reads one document. The first error stops everything: each step returns early once the source has failed.
class Reader {
 public:
  // own: where the text is, if it may be forgotten as it is read; else null.
  Reader(std::string_view text, std::string file, std::string* own)
      : text_(text), own_(own), source_({}, std::move(file)) {}

  Result<Network> read(Diagnostics* diagnostics);

 private:
  Status read_parts(const std::vector<XmlPart>& parts);
  Status take(Part& part, int line);
  void place_closed_junctions();
  Status check_size(const XmlParts& parts) const;
  Status check_root(const XmlParts& parts) const;
  void connect();

  std::string_view text_;
  std::string* own_;
  XodrSource source_;  // of the whole: notes of all parts
  std::optional<XodrHeader> header_;
  Network network_;
  std::vector<bool> exact_ends_;  // of the roads
  std::vector<XodrJunction> junctions_, closed_junctions_;
  std::set<std::string> derived_;  // ids of roads that are left out, since they follow from areas
  std::set<std::string> road_ids_, junction_ids_;
};

// Puts the junctions that the file has elsewhere among the others.
void Reader::place_closed_junctions() {
  if (closed_junctions_.empty()) return;
  std::stable_sort(closed_junctions_.begin(), closed_junctions_.end(),
                   [](const XodrJunction& a, const XodrJunction& b) { return *a.place < *b.place; });
  std::vector<XodrJunction> all;
  all.reserve(junctions_.size() + closed_junctions_.size());
  std::size_t next = 0;
  for (XodrJunction& closed : closed_junctions_) {
    while (next < junctions_.size() && all.size() < *closed.place) all.push_back(std::move(junctions_[next++]));
    all.push_back(std::move(closed));
  }
  while (next < junctions_.size()) all.push_back(std::move(junctions_[next++]));
  junctions_ = std::move(all);
}

// Links and junctions, once all roads are there.
void Reader::connect() {
  place_closed_junctions();
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

// Whether what is made of the parts stays within bounds.
Status Reader::check_size(const XmlParts& parts) const {
  if (parts.children.size() > kMostChildren) {
    return Error{ErrorCode::kData,
                 "holds more than " + std::to_string(kMostChildren) + " roads, junctions and others; divide it",
                 source_.file()};
  }
  for (const XmlPart& part : parts.children) {
    if (part.tags <= kMostTags) continue;
    return Error{ErrorCode::kData,
                 "a road or other part of <OpenDRIVE> holds more than " + std::to_string(kMostTags) + " elements",
                 source_.file(), part.line};
  }
  return Done{};
}

// The root, in a document without its children.
Status Reader::check_root(const XmlParts& parts) const {
  const std::string text = std::string(parts.before) + std::string(parts.after.text);
  pugi::xml_document document;
  pugi::xml_parse_result parsed = parse(document, text);
  if (!parsed && !parts.children.empty()) {
    // The last child took the rest where one of its tags is not closed: it says better where.
    const XmlPart& last = parts.children.back();
    const pugi::xml_parse_result child = parse(document, last.text);
    if (!child) return not_well_formed(XodrSource(last.text, source_.file(), last.line), child);
  }
  const XodrSource before(parts.before, source_.file());
  if (const auto end = static_cast<std::ptrdiff_t>(parts.before.size()); !parsed && parsed.offset >= end) {
    parsed.offset -= end;
    return not_well_formed(XodrSource(parts.after.text, source_.file(), parts.after.line), parsed);
  }
  if (!parsed) return not_well_formed(before, parsed);
  const pugi::xml_node root = document.child("OpenDRIVE");
  if (!root) return Error{ErrorCode::kParse, "is not OpenDRIVE: there is no <OpenDRIVE> element", source_.file(), 1};
  const auto is_header = [](const XmlPart& part) { return part.text.starts_with("<header"); };
  if (std::any_of(parts.children.begin(), parts.children.end(), is_header)) return Done{};
  return Error{ErrorCode::kParse, "<OpenDRIVE> lacks <header>", source_.file(), before.line(root)};
}

// Adds what was read of a part to the whole.
Status Reader::take(Part& part, int line) {
  if (part.source.failed()) return part.source.error();
  source_.add_notes(part.source);
  const auto twice = [&](const char* what, const std::string& id) {
    return Error{ErrorCode::kParse, "the id is used twice", source_.file(), line, what + id};
  };
  if (part.header && !header_) header_ = std::move(part.header);
  if (part.derived) derived_.insert(std::move(*part.derived));
  if (part.road) {
    if (!road_ids_.insert(part.road->id).second) return twice("road ", part.road->id);
    network_.roads.push_back(std::move(*part.road));
    exact_ends_.push_back(part.exact_ends);
  }
  if (part.controller) network_.controllers.push_back(std::move(*part.controller));
  network_.other_xml += part.other_xml;
  if (part.junction) {
    if (!junction_ids_.insert(part.junction->links.id).second) return twice("junction ", part.junction->links.id);
    (part.junction->place ? closed_junctions_ : junctions_).push_back(std::move(*part.junction));
  }
  return Done{};
}

// Reads the parts on all cores, some at a time. What is not XML is told before what is in it.
Status Reader::read_parts(const std::vector<XmlPart>& parts) {
  constexpr std::size_t kBatch = 128, kChunk = 4;
  Status status = Done{};
  for (std::size_t first = 0; first < parts.size(); first += kBatch) {
    std::vector<std::optional<Part>> batch(std::min(kBatch, parts.size() - first));
    for_chunks(batch.size(), kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        read_part(batch[i].emplace(parts[first + i], source_.file()), parts[first + i]);
    });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      if (batch[i]->malformed) return *batch[i]->malformed;
      if (status) status = take(*batch[i], parts[first + i].line);
    }
    const std::string_view last = parts[first + batch.size() - 1].text;
    if (own_) forget(*own_, 0, static_cast<std::size_t>(last.data() + last.size() - own_->data()));
  }
  return status;
}

Result<Network> Reader::read(Diagnostics* diagnostics) {
  if (Status status = check_utf8(text_, source_.file()); !status) return status.error();
  const XmlParts parts = xml_parts(text_, kMostChildren);
  if (Status status = check_size(parts); !status) return status.error();
  if (Status status = check_root(parts); !status) return status.error();
  if (Status status = read_parts(parts.children); !status) return status.error();
  if (header_) network_.name = std::move(header_->name), network_.georeference = header_->georeference;
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
  return Reader(text, file, nullptr).read(diagnostics);
}

Result<Network> read_opendrive(const std::string& path, Diagnostics* diagnostics) {
  Result<std::string> text = read_file(path, kMostFile_bytes);
  if (!text) return text.error();
  return Reader(*text, path, &*text).read(diagnostics);
}

}  // namespace roadgen
