#include "roadgen/import/osm_network.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "roadgen/import/local_frame.h"
#include "roadgen/import/osm_junctions.h"
#include "roadgen/import/osm_road.h"
#include "roadgen/import/parallel.h"
#include "roadgen/road/crossing.h"

namespace roadgen {
namespace {

constexpr std::size_t kChunk = 256;
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
  void make_roads(const OsmScene& scene);
  void make_areas();

  const ImportOptions& options_;
  const Progress& progress_;
  ElementFindings& findings_;
  OsmData data_;
  OsmGraph graph_;
  OsmJunctions junctions_;
  std::vector<HeightProfile> heights_;  // [line]
  ImportResult result_;
  std::vector<std::uint32_t> first_road_, road_count_;  // [line]
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

void OsmImport::make_roads(const OsmScene& scene) {
  const std::size_t lines = graph_.lines.size();
  const std::vector<std::uint32_t> ordinal = ordinals();
  std::vector<char> joined(2 * lines, 0);
  for (const OsmJunction& junction : junctions_.all) {
    for (const LineEnd end : junction.ends) joined[end] = 1;
  }
  struct Made {
    std::vector<LineRoads> lines;
    ElementFindings findings{""};
  };
  std::vector<Made> made((lines + kChunk - 1) / kChunk, Made{{}, findings_.empty_copy()});
  for_chunks(lines, kChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    Course course;
    LinePlan plan;
    made[chunk].lines.resize(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      if (junctions_.absorbed[i]) continue;
      const OsmLine& line = graph_.lines[i];
      load_course(scene, line, course);
      if (course.points_m.empty()) continue;
      plan.cut_start_m = junctions_.cut_m[2 * i];
      plan.cut_end_m = junctions_.cut_m[2 * i + 1];
      plan.joined_start = joined[2 * i];
      plan.joined_end = joined[2 * i + 1];
      plan.heights = heights_[i].at_m.empty() ? nullptr : &heights_[i];
      plan.ids.clear();
      for (const OsmPiece& piece : course.pieces) {
        const auto same = [&](const OsmPiece& p) { return p.way == piece.way && p.first == piece.first; };
        const auto at = std::find_if(graph_.pieces.begin() + line.first_piece, graph_.pieces.end(), same);
        const std::uint32_t n = ordinal[static_cast<std::size_t>(at - graph_.pieces.begin())];
        const bool again = line.closed && &piece == &course.pieces.back() && course.pieces.size() > 1;
        plan.ids.push_back(std::to_string(data_.ways[piece.way].id) + (n > 0 ? "." + std::to_string(n + 1) : "") +
                           (again ? ".0" : ""));
      }
      Result<LineRoads> roads = make_line_roads(scene, course, line, plan, made[chunk].findings);
      if (roads) {
        made[chunk].lines[i - begin] = std::move(*roads);
      } else {
        made[chunk].findings.add(Severity::kError, "ways that no road follows", roads.error().element,
                                 "no road follows it, left out: " + roads.error().message);
      }
    }
  });
  first_road_.assign(lines, 0);
  road_count_.assign(lines, 0);
  Network& network = result_.network;
  for (std::size_t chunk = 0; chunk < made.size(); ++chunk) {
    findings_.add(made[chunk].findings);
    for (std::size_t k = 0; k < made[chunk].lines.size(); ++k) {
      LineRoads& roads = made[chunk].lines[k];
      first_road_[chunk * kChunk + k] = static_cast<std::uint32_t>(network.roads.size());
      road_count_[chunk * kChunk + k] = static_cast<std::uint32_t>(roads.roads.size());
      std::move(roads.roads.begin(), roads.roads.end(), std::back_inserter(network.roads));
      std::move(roads.certificates.begin(), roads.certificates.end(), std::back_inserter(result_.certificates));
    }
    made[chunk].lines = {};
  }
  result_.allowed_error_m.assign(network.roads.size(), kNodeError_m);
}

void OsmImport::make_areas() {
  Network& network = result_.network;
  const std::size_t count = junctions_.all.size();
  struct Made {
    std::vector<Crossing> crossings;
    ElementFindings findings{""};
  };
  std::vector<Made> made((count + kChunk - 1) / kChunk, Made{{}, findings_.empty_copy()});
  for_chunks(count, kChunk, [&](std::size_t chunk, std::size_t begin, std::size_t end) {
    std::vector<EndOfRoad> ends;
    for (std::size_t k = begin; k < end; ++k) {
      const OsmJunction& junction = junctions_.all[k];
      ends.clear();
      for (const LineEnd e : junction.ends) {
        const std::size_t line = line_of(e);
        if (road_count_[line] == 0) continue;
        const std::size_t road = first_road_[line] + (is_at_end(e) ? road_count_[line] - 1 : 0);
        ends.push_back({&network.roads[road], is_at_end(e)});
      }
      const std::string id = std::to_string(data_.node_ids[junction.node]);
      Result<Crossing> crossing = make_crossing(id, ends, {.corner_radius_m = junction.radius_m});
      if (crossing) {
        made[chunk].crossings.push_back(std::move(*crossing));
      } else {
        made[chunk].findings.add(Severity::kWarning, "junctions without an area", "node " + id,
                                 "no area fits between its roads, which end before it: " + crossing.error().message);
      }
    }
  });
  for (Made& of : made) {
    findings_.add(of.findings);
    for (Crossing& crossing : of.crossings) {
      network.junctions.push_back(std::move(crossing.junction));
      std::move(crossing.corners.begin(), crossing.corners.end(), std::back_inserter(network.roads));
    }
    of.crossings = {};
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
  heights_ = find_heights(scene, findings_);
  show(0.6, "laying roads");
  make_roads(scene);
  show(0.8, "laying junctions");
  make_areas();
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
