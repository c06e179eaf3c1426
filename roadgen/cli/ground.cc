#include "roadgen/cli/ground.h"

#include <CLI/CLI.hpp>

namespace roadgen::cli {

void add_elevation_options(CLI::App& app, ElevationRequest& request) {
  app.add_option("--dem-encoding", request.encoding, "What its pixels are: heights, terrain-rgb or terrarium")
      ->capture_default_str();
  app.add_option("--dem-datum", request.datum,
                 "What its heights are above: geoid, ellipsoid, as-roads, or file: what it says itself; SRTM's are "
                 "above the geoid EGM96")
      ->capture_default_str();
  app.add_option("--road-datum", request.road_datum,
                 "What the roads' heights are above: geoid, ellipsoid, or file: what the georeference says, else the "
                 "elevation's. Where the two differ the elevation's are converted")
      ->capture_default_str();
  app.add_option("--geoid", request.geoid_path,
                 "Grid of geoid undulations: .gtx, GeoTIFF or .pgm. Default: what PROJ has of the file's geoid, or of "
                 "EGM96");
}

void add_levelling_options(CLI::App& app, LevellingOptions& o) {
  app.add_option("--shoulder", o.shoulder_m, "Level strip beside the carriageway, m")->capture_default_str();
  app.add_option("--cut-slope", o.cut_slope, "Steepest cutting, height / width")->capture_default_str();
  app.add_option("--fill-slope", o.fill_slope, "Steepest embankment")->capture_default_str();
  app.add_option("--cover", o.cover_m, "Least height of a hill over a tunnel's vault, m")->capture_default_str();
  app.add_option("--ditch-depth", o.ditch_depth_m,
                 "Depth of ditches beyond the shoulder below the carriageway's edge, m; 0: none. They end before other "
                 "roads, junctions, bridges and tunnels")
      ->capture_default_str();
  app.add_option("--ditch-bottom", o.ditch_bottom_m, "Width of a ditch's bottom, m")->capture_default_str();
  app.add_option("--ditch-inner-slope", o.ditch_inner_slope, "Slope of a ditch towards the road, height / width")
      ->capture_default_str();
  app.add_option("--ditch-outer-slope", o.ditch_outer_slope, "Slope of a ditch away from the road")
      ->capture_default_str();
}

Result<Elevation> open_elevation(const ElevationRequest& request, const Network& network, Diagnostics& diagnostics) {
  const auto encoding = height_encoding_from_name(request.encoding);
  if (!encoding) return encoding.error();
  const auto own = elevation_datum_from_name(request.datum);
  if (!own) return own.error();
  const auto roads = road_datum_from_name(request.road_datum, network);
  if (!roads) return roads.error();
  return Elevation::open(request.path, &diagnostics, *encoding,
                         {.own = *own, .roads = *roads, .geoid_path = request.geoid_path});
}

}  // namespace roadgen::cli
