#include "roadgen/import/osm_network.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <numeric>

#include <glm/geometric.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "roadgen/import/osm_junctions.h"
#include "roadgen/import/osm_overlaps.h"
#include "roadgen/import/osm_road.h"
#include "roadgen/road/crossing.h"
#include "roadgen/road/parallel.h"
#include "roadgen/road/vault_room.h"

namespace roadgen {
namespace {

constexpr std::size_t kChunk = 256, kBatch = 64 * kChunk;
constexpr double kUnit_deg = 1e-7;

// Centre of the box around all nodes, rounded so that it can be quoted. Where the box would be wider than half the
// globe it crosses the antimeridian.
Georeference centre_of(const OsmData& data) {
  double south = 90, north = -90, west = 180, east = -180, west_of_0 = -180, east_of_0 = 180;
  for (const std::uint32_t node : data.refs) {
    const double x = kUnit_deg * data.locations[node].longitude, y = kUnit_deg * data.locations[node].latitude;
    south = std::min(south, y), north = std::max(north, y);
    west = std::min(west, x), east = std::max(east, x);
    (x < 0 ? west_of_0 : east_of_0) = x < 0 ? std::max(west_of_0, x) : std::min(east_of_0, x);
  }
  if (east - west > 180) {
    west = east_of_0;
    east = west_of_0 + 360;
  }
  const auto rounded = [](double degrees) { return std::round(degrees * 1e6) / 1e6; };
  return {rounded((south + north) / 2), rounded(std::remainder((west + east) / 2, 360)), 0};
}

// On the plane of the origin, at height 0.
std::vector<glm::dvec2> positions(const OsmData& data, const LocalFrame& frame) {
  std::vector<glm::dvec2> all(data.locations.size());
  for_chunks(all.size(), 1 << 14, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const OsmLocation& at = data.locations[i];
      all[i] = glm::dvec2(frame.to_local_m({kUnit_deg * at.latitude, kUnit_deg * at.longitude, 0}));
    }
  });
  return all;
}

class OsmImport {
 public:
  OsmImport(const ImportOptions& options, const Progress& progress, ElementFindings& findings)
      : options_(options), progress_(progress), findings_(findings) {}
  Result<ImportResult> run(OsmData data, const std::string& path);

 private:
  void show(double part, const char* what) const {
    if (progress_) progress_(part, what);
  }
  std::vector<std::uint32_t> ordinals() const;
  LinePlan plan_of(std::size_t line, const Course& course) const;
  std::string junction_id(const OsmJunction& junction) const { return std::to_string(data_.node_ids[junction.node]); }
  void make_roads(const OsmScene& scene, const std::vector<std::uint32_t>& which);
  void take_roads(std::size_t line, LineRoads made);
  std::vector<std::uint32_t> make_areas(const std::vector<std::uint32_t>& which);
  void make_all(const OsmScene& scene);
  Road* road_at(LineEnd end);
  void link_to_junction(LineEnd end, const std::string& id);
  void link_ends();
  void take_all();
  void make_room();

  const ImportOptions& options_;
  const Progress& progress_;
  ElementFindings& findings_;
  OsmData data_;
  OsmGraph graph_;
  OsmJunctions junctions_;
  std::vector<HeightProfile> heights_;  // [line]
  ImportResult result_;
  std::vector<std::uint32_t> ordinal_;  // [piece]: how many of its way come before it
  struct Range {
    std::uint32_t first = 0, count = 0;
  };
  std::vector<Range> range_;                // [line]: its roads
  std::vector<Junction> areas_;             // [junction]
  std::vector<std::vector<Road>> corners_;  // [junction]
};

// Of every piece, how many of its way come before it.
std::vector<std::uint32_t> OsmImport::ordinals() const {
  // Parts of a way with missing nodes follow one another.
  std::vector<std::uint32_t> owner(data_.ways.size());
  for (std::uint32_t w = 0; w < owner.size(); ++w) {
    owner[w] = w > 0 && data_.ways[w].id == data_.ways[w - 1].id ? owner[w - 1] : w;
  }
  std::vector<std::uint32_t> seen(data_.ways.size(), 0), ordinal;
  ordinal.reserve(graph_.pieces.size());
  for (const OsmPiece& piece : graph_.pieces) ordinal.push_back(seen[owner[piece.way]]++);
  return ordinal;
}

LinePlan OsmImport::plan_of(std::size_t i, const Course& course) const {
  const OsmLine& line = graph_.lines[i];
  LinePlan plan;
  plan.cut_start_m = junctions_.cut_m[2 * i];
  plan.cut_end_m = junctions_.cut_m[2 * i + 1];
  plan.joined_start = plan.cut_start_m > 0;
  plan.joined_end = plan.cut_end_m > 0;
  const auto is_shared = [&](std::uint32_t node) {
    return std::binary_search(graph_.nodes.begin(), graph_.nodes.end(), node);
  };
  plan.touches_start = !plan.joined_start && is_shared(line.node_start);
  plan.touches_end = !plan.joined_end && is_shared(line.node_end);
  plan.heights = heights_.empty() || heights_[i].at_m.empty() ? nullptr : &heights_[i];
  for (const OsmPiece& piece : course.pieces) {
    const auto same = [&](const OsmPiece& p) { return p.way == piece.way && p.first == piece.first; };
    const auto at = std::find_if(graph_.pieces.begin() + line.first_piece, graph_.pieces.end(), same);
    const std::uint32_t n = ordinal_[static_cast<std::size_t>(at - graph_.pieces.begin())];
    // A loop's first piece may come again as its last.
    const bool again = line.closed && &piece == &course.pieces.back() && course.pieces.size() > 1;
    plan.ids.push_back(std::to_string(data_.ways[piece.way].id) + (n > 0 ? "." + std::to_string(n + 1) : "") +
                       (again ? ".0" : ""));
  }
  return plan;
}

// Makes the roads of the given lines, some at a time, so that no more than those are in memory twice.
void OsmImport::make_roads(const OsmScene& scene, const std::vector<std::uint32_t>& which) {
  std::vector<LineRoads> made;
  std::vector<ElementFindings> found;
  for (std::size_t first = 0; first < which.size(); first += kBatch) {
    const std::size_t count = std::min(kBatch, which.size() - first);
    made.assign(count, {});
    found.assign((count + kChunk - 1) / kChunk, findings_.empty_copy());
    for_chunks(count, kChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
      Course course;
      for (std::size_t k = begin; k < end; ++k) {
        const std::size_t i = which[first + k];
        load_course(scene, graph_.lines[i], course);
        if (junctions_.absorbed[i] || course.points_m.empty()) continue;
        Result<LineRoads> roads = make_line_roads(scene, course, graph_.lines[i], plan_of(i, course), found[chunk]);
        if (roads) {
          made[k] = std::move(*roads);
        } else {
          found[chunk].add(Severity::kError, "ways that no road follows", roads.error().element,
                           "no road follows it, left out: " + roads.error().message);
        }
      }
    });
    for (std::size_t k = 0; k < count; ++k) take_roads(which[first + k], std::move(made[k]));
    for (const ElementFindings& of : found) findings_.add(of);
  }
}

// In place of those that the line had, if it had as many.
void OsmImport::take_roads(std::size_t line, LineRoads made) {
  std::vector<Road>& roads = result_.network.roads;
  Range& range = range_[line];
  if (made.roads.size() != range.count) {
    for (std::size_t k = range.first; k < range.first + range.count; ++k) {
      roads[k] = {};
      result_.certificates[k] = {};
    }
    range = {static_cast<std::uint32_t>(roads.size()), static_cast<std::uint32_t>(made.roads.size())};
    roads.resize(roads.size() + range.count);
    result_.certificates.resize(roads.size());
  }
  std::move(made.roads.begin(), made.roads.end(), roads.begin() + range.first);
  std::move(made.certificates.begin(), made.certificates.end(), result_.certificates.begin() + range.first);
}

// The areas of the given junctions. Those that cannot be are given up: their lines are to be made again.
std::vector<std::uint32_t> OsmImport::make_areas(const std::vector<std::uint32_t>& which) {
  std::vector<std::string> why(which.size());
  std::vector<std::uint32_t> bare(which.size(), 0);
  for_chunks(which.size(), kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<EndOfRoad> ends;
    for (std::size_t k = begin; k < end; ++k) {
      const OsmJunction& junction = junctions_.all[which[k]];
      ends.clear();
      for (const LineEnd e : junction.ends) {
        const Range& range = range_[line_of(e)];
        if (range.count == 0) continue;
        const std::size_t road = range.first + (is_at_end(e) ? range.count - 1 : 0);
        ends.push_back({&result_.network.roads[road], is_at_end(e)});
      }
      Result<Crossing> crossing = make_crossing(junction_id(junction), ends, {.corner_radius_m = junction.radius_m});
      if (crossing) {
        areas_[which[k]] = std::move(crossing->junction);
        corners_[which[k]] = std::move(crossing->corners);
        bare[k] = static_cast<std::uint32_t>(crossing->bare.size());
      } else {
        why[k] = crossing.error().message;
      }
    }
  });
  std::vector<std::uint32_t> again;
  for (std::size_t k = 0; k < which.size(); ++k) {
    OsmJunction& junction = junctions_.all[which[k]];
    if (bare[k] > 0) {
      findings_.add(Severity::kWarning, "junctions with bare corners", "node " + junction_id(junction),
                    "nothing lies along " + std::to_string(bare[k]) + " of its corners, which are too tight");
    }
    if (why[k].empty()) continue;
    findings_.add(Severity::kWarning, "junctions without an area", "node " + junction_id(junction),
                  "no area fits between its roads, which just touch: " + why[k]);
    junction.area = false;
    areas_[which[k]] = {};
    corners_[which[k]].clear();
    for (const LineEnd end : junction.ends) {
      junctions_.cut_m[end] = 0;
      again.push_back(static_cast<std::uint32_t>(line_of(end)));
    }
    for (const std::uint32_t line : junction.inside) {
      junctions_.absorbed[line] = 0;
      again.push_back(line);
    }
  }
  std::sort(again.begin(), again.end());
  again.erase(std::unique(again.begin(), again.end()), again.end());
  return again;
}

// Roads and areas, until no area has to be given up.
void OsmImport::make_all(const OsmScene& scene) {
  const auto all_of = [](std::size_t count) {
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    return all;
  };
  // There is at most one road a piece: memory that is not used is not touched.
  result_.network.roads.reserve(graph_.pieces.size() + graph_.lines.size());
  result_.certificates.reserve(graph_.pieces.size() + graph_.lines.size());
  range_.resize(graph_.lines.size());
  areas_.resize(junctions_.all.size());
  corners_.resize(junctions_.all.size());
  std::vector<std::uint32_t> lines = all_of(range_.size()), areas = all_of(areas_.size());
  while (!lines.empty()) {
    make_roads(scene, lines);
    show(0.8, "laying junctions");
    lines = make_areas(areas);
    areas.clear();
    for (std::uint32_t k = 0; k < junctions_.all.size() && !lines.empty(); ++k) {
      const auto is_moved = [&](LineEnd e) {
        return std::binary_search(lines.begin(), lines.end(), static_cast<std::uint32_t>(line_of(e)));
      };
      const OsmJunction& junction = junctions_.all[k];
      if (junction.area && std::any_of(junction.ends.begin(), junction.ends.end(), is_moved)) areas.push_back(k);
    }
  }
}

// The road that has the line's end; none where no road came of the line.
Road* OsmImport::road_at(LineEnd end) {
  const Range& range = range_[line_of(end)];
  if (range.count == 0) return nullptr;
  Road& road = result_.network.roads[range.first + (is_at_end(end) ? range.count - 1 : 0)];
  return road.closed ? nullptr : &road;
}

void OsmImport::link_to_junction(LineEnd end, const std::string& id) {
  if (Road* road = road_at(end)) {
    (is_at_end(end) ? road->successor : road->predecessor) = {RoadLink::To::kJunction, id};
  }
}

// Ends of lines in areas and at nodes without one to junctions; the two at a node where lines just end to one another.
void OsmImport::link_ends() {
  std::vector<char> is_linked(2 * graph_.lines.size(), 0);
  for (const OsmJunction& junction : junctions_.all) {
    if (!junction.area) continue;
    const std::string id = junction_id(junction);
    for (const LineEnd end : junction.ends) {
      link_to_junction(end, id);
      is_linked[end] = 1;
    }
  }
  for (std::size_t k = 0; k < graph_.nodes.size(); ++k) {
    const std::string id = std::to_string(data_.node_ids[graph_.nodes[k]]);
    bool touched = false;
    for (std::size_t i = graph_.first_end[k]; i < graph_.first_end[k + 1]; ++i) {
      const LineEnd end = graph_.ends[i];
      if (is_linked[end] || junctions_.absorbed[line_of(end)]) continue;
      link_to_junction(end, id);
      is_linked[end] = 1;
      touched = touched || road_at(end);
    }
    if (touched) result_.network.junction_links.push_back({id, ""});
  }
  std::vector<std::pair<std::uint32_t, LineEnd>> loose;
  for (std::size_t i = 0; i < graph_.lines.size(); ++i) {
    const OsmLine& line = graph_.lines[i];
    if (line.closed) continue;
    const auto end = static_cast<LineEnd>(2 * i);
    if (!is_linked[end]) loose.emplace_back(line.node_start, end);
    if (!is_linked[end + 1]) loose.emplace_back(line.node_end, end + 1);
  }
  std::sort(loose.begin(), loose.end());
  for (std::size_t i = 0; i + 1 < loose.size(); ++i) {
    if (loose[i].first != loose[i + 1].first) continue;
    const LineEnd a = loose[i].second, b = loose[i + 1].second;
    Road *from = road_at(a), *to = road_at(b);
    if (from && from == to) {
      // A road linked to itself would be a closed one, which has no corner there.
      const std::string id = std::to_string(data_.node_ids[loose[i].first]);
      link_to_junction(a, id);
      link_to_junction(b, id);
      result_.network.junction_links.push_back({id, ""});
    } else if (from && to) {
      link_roads(*from, is_at_end(a), *to, is_at_end(b));
    }
    ++i;
  }
}

// Leaves out what was replaced, and adds the corners' strips.
void OsmImport::take_all() {
  Network& network = result_.network;
  std::erase_if(network.roads, [](const Road& road) { return road.segments.empty(); });
  std::erase_if(result_.certificates, [](const Certificate& c) { return c.id.empty(); });
  result_.allowed_error_m.assign(network.roads.size(), kNodeError_m);
  std::erase_if(areas_, [](const Junction& junction) { return junction.arms.empty(); });
  network.junctions = std::move(areas_);
  for (std::vector<Road>& corners : corners_) {
    std::move(corners.begin(), corners.end(), std::back_inserter(network.roads));
  }
}

// Vaults end where roads pass through them.
void OsmImport::make_room() {
  for (const VaultGap& gap : trim_vaults(result_.network)) {
    char text[96];
    std::snprintf(text, sizeof text, "no room for its vault from s = %.1f m to %.1f m, where a road passes above",
                  gap.s_start_m, gap.s_end_m);
    findings_.add(Severity::kWarning, "tunnels without room", "road " + result_.network.roads[gap.road].id, text);
  }
}

Result<ImportResult> OsmImport::run(OsmData data, const std::string& path) {
  data_ = std::move(data);
  const Georeference origin = options_.origin ? *options_.origin : centre_of(data_);
  const LocalFrame frame(origin);
  const std::vector<glm::dvec2> positions_m = positions(data_, frame);
  for (const std::uint32_t node : data_.refs) {
    result_.greatest_distance_m = std::max(result_.greatest_distance_m, glm::length(positions_m[node]));
  }
  show(0.3, "joining ways");
  graph_ = make_graph(data_, positions_m, findings_);
  const OsmScene scene{data_, positions_m, graph_, options_.left_hand_traffic};
  show(0.35, "placing junctions");
  junctions_ = place_junctions(scene, findings_);
  show(0.5, "finding heights");
  heights_ = find_heights(scene, junctions_, findings_);
  find_overlaps(scene, junctions_, heights_, findings_);
  show(0.6, "laying roads");
  ordinal_ = ordinals();
  make_all(scene);
  link_ends();
  take_all();
  if (!options_.heights_follow) make_room();
  Network& network = result_.network;
  network.georeference = origin;
  network.name = stem(stem(path));
  if (network.roads.empty()) return Error{ErrorCode::kData, "no road comes of its ways", path};
  return std::move(result_);
}

}  // namespace

Result<ImportResult> import_osm(const std::string& path, const ImportOptions& options, const Progress& progress) {
  if (progress) progress(0, "reading " + path);
  ElementFindings findings(path);
  Result<OsmData> data = read_osm(path, findings);
  if (!data) return data.error();
  Result<ImportResult> result = OsmImport(options, progress, findings).run(std::move(*data), path);
  if (!result) return result;
  findings.append_to(result->diagnostics);
  add_distance_warning(*result, path);
  if (progress) progress(1, "done");
  return result;
}

}  // namespace roadgen
