// roadgen terrain: the ground levelled along the roads, as a GeoTIFF, and what is proven of it, as JSON.
#include "terrain/terrain.h"

#include <algorithm>
#include <array>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/cli/ground.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/query/road_index.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen terrain";
using Json = nlohmann::ordered_json;

// The roads of an overlap, and where it is.
Json describe(const Overlap& overlap, const RoadIndex& index) {
  constexpr double kAbout_m = 1;
  std::array<RoadPoint, 8> room;
  const std::size_t count = std::min(index.candidates(overlap.at_m, kAbout_m, room), room.size());
  Json roads = Json::array(), junctions = Json::array();
  const auto add = [](Json& to, const std::string& id) {
    if (std::find(to.begin(), to.end(), id) == to.end()) to.push_back(id);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const Network& network = index.network();
    if (room[i].junction >= 0) {
      add(junctions, network.junctions[static_cast<std::size_t>(room[i].junction)].id);
    } else if (room[i].has_road()) {
      add(roads, network.roads[room[i].at.road].id);
    }
  }
  return {{"at", {overlap.at_m.x, overlap.at_m.y}},
          {"apart_m", overlap.apart_m},
          {"roads", roads},
          {"junctions", junctions}};
}

Json describe(const Elevation& elevation, const Network& network, const TerrainReport& report,
              const TerrainOptions& options) {
  Json overlaps = Json::array();
  const RoadIndex index(network);
  for (std::size_t i = 0; i < std::min(report.overlap_places, report.overlaps.size()); ++i) {
    overlaps.push_back(describe(report.overlaps[i], index));
  }
  return {
      {"clearance_min_m", report.clearance_min_m},
      {"clearance_max_m", report.clearance_max_m},
      {"clearance_max_at", {report.clearance_max_at_m.x, report.clearance_max_at_m.y}},
      {"wanted_min_m", options.least_clearance_m},
      {"wanted_max_m", options.most_clearance_m},
      {"bridge_parts", report.bridge_parts},
      {"bridge_m", report.bridge_m},
      {"assumed_bridge_parts", report.assumed_bridge_parts},
      {"assumed_bridge_m", report.assumed_bridge_m},
      {"tunnel_parts", report.tunnel_parts},
      {"tunnel_m", report.tunnel_m},
      {"tunnel_areas", report.tunnel_areas},
      {"triangles_cut_for_tunnels", report.triangles_cut},
      {"triangles_under_roads", report.triangles_under_roads},
      {"too_deep_part", report.too_deep},
      {"too_deep_by_overlap_part", report.too_deep_by_overlap},
      {"triangles_too_deep", report.triangles_too_deep},
      {"triangles_too_deep_by_overlap", report.triangles_too_deep_by_overlap},
      {"over_other_roads_m2", report.over_others_m2},
      {"overlap_places", report.overlap_places},
      {"overlaps", overlaps},
      {"triangles_lowered", report.triangles_lowered},
      {"lowered_max_m", report.lowered_max_m},
      {"deepest_cut_m", report.deepest_cut_m},
      {"highest_fill_m", report.highest_fill_m},
      {"voids_filled", report.voids_filled},
      {"heights_above", elevation.datum() == VerticalDatum::kUnknown ? "as the roads" : name_of(elevation.datum())},
      {"vertical_datum", elevation.vertical_datum().empty() ? Json() : Json(elevation.vertical_datum())},
      {"triangles", report.triangles},
      {"vertices", report.vertices},
      {"tiles", report.tiles},
      {"tolerance_factor", report.tolerance_factor},
      {"spacing_m", report.spacing_m},
      {"finest_spacing_m", report.finest_spacing_m},
      {"natural_spacing_m", report.natural_spacing_m},
      {"area",
       {{"low", {report.area.low_m.x, report.area.low_m.y}}, {"high", {report.area.high_m.x, report.area.high_m.y}}}},
      {"seconds", report.seconds}};
}

}  // namespace

int run_terrain(const Arguments& arguments) {
  CLI::App app(
      "Levels the ground along the roads, proves how far every carriageway lies above it, and writes it. Bridges leave "
      "the "
      "ground alone: it never comes nearer to them than --gap, but the greatest clearance is that outside of them. "
      "Tunnels "
      "keep the hill where it covers their vault by --cover; elsewhere they are cut open.",
      kName);
  ElevationRequest dem;
  std::string network_path, output;
  TerrainOptions options;
  double post_m = 5;
  app.add_option("DEM", dem.path, "Elevation: SRTM .hgt (also zipped), GeoTIFF or ASCII grid")->required();
  add_elevation_options(app, dem);
  app.add_option("NET", network_path, "OpenDRIVE file")->required();
  app.add_option("-o,--output", output, "GeoTIFF of heights, longitude and latitude in WGS84; over tunnels the hill's");
  app.add_option("--post", post_m, "Distance of the GeoTIFF's posts, m")->capture_default_str();
  app.add_option("--margin", options.margin_m, "How far the ground reaches beyond the roads, m")->capture_default_str();
  app.add_option("--spacing", options.spacing_m, "Distance of the mesh's posts under roads, m")->capture_default_str();
  app.add_option("--gap", options.least_clearance_m, "Every carriageway lies above the ground by at least this, m")
      ->capture_default_str();
  app.add_option("--depth", options.most_clearance_m, "... and by at most this where the posts allow, m")
      ->capture_default_str();
  add_levelling_options(app, options.levelling);
  app.add_option("--max-triangles", options.max_triangles,
                 "The mesh gets coarser, but not under roads, until it has no more triangles")
      ->capture_default_str();
  if (const auto code = parse(app, arguments)) return *code;
  if (!output.empty()) {
    if (Status status = check_writable(output); !status) return fail(kName, status.error());
  }

  Diagnostics diagnostics;
  const Result<Network> network = read_opendrive(network_path, &diagnostics);
  if (!network) return fail(kName, network.error());
  const Result<Elevation> elevation = open_elevation(dem, *network, diagnostics);
  print_diagnostics(diagnostics, "");
  if (!elevation) return fail(kName, elevation.error());
  // Between the two, so that neither bound is reached without need.
  options.levelling.gap_m = 0.7 * options.least_clearance_m + 0.3 * options.most_clearance_m;
  ProgressLine progress;
  options.progress = [&](double part) { progress.show(part, "terrain"); };
  const Result<Terrain> terrain = Terrain::build(*network, &*elevation, options);
  progress.clear();
  if (!terrain) return fail(kName, terrain.error());
  if (!output.empty()) {
    if (Status status =
            write_terrain(*terrain, *network, post_m, output, elevation->datum(), elevation->vertical_datum());
        !status)
      return fail(kName, status.error());
  }
  if (Status status = put_out(describe(*elevation, *network, terrain->report(), options).dump(2) + "\n", ""); !status) {
    return fail(kName, status.error());
  }
  return kExitDone;
}

}  // namespace roadgen::cli
