// roadgen import: measured centre lines to an OpenDRIVE network.
#include "roadgen/cli/import_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>

#include "roadgen/cli/command.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/export/opendrive.h"
#include "roadgen/import/html_report.h"
#include "roadgen/import/text_file.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen import";

struct Options {
  std::vector<std::string> sources, fields;
  std::string output, report, origin, tangents = "fit", closed = "auto";
  ImportOptions import;
  HeightRequest heights;
};

// "LAT,LON" or "LAT,LON,H".
Result<Georeference> parse_origin(const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(',', start), text.size());
    const std::optional<double> number = parse_number(std::string_view(text).substr(start, end - start));
    if (!number) break;
    numbers.push_back(*number);
    start = end + 1;
    if (end == text.size() && numbers.size() >= 2 && numbers.size() <= 3) {
      return Georeference{numbers[0], numbers[1], numbers.size() == 3 ? numbers[2] : 0};
    }
  }
  return Error{ErrorCode::kUsage, "--origin " + text + ": expected LAT,LON or LAT,LON,H in degrees and metres"};
}

void declare(CLI::App& app, Options& o) {
  app.add_option("SRC", o.sources,
                 "Files: .csv (lat,lon or x,y [,height][,width], with a header line), .gpx, .geojson, .kml, "
                 ".shp, .gpkg. "
                 "One road for each line in them. Or one file of OpenStreetMap, .osm, .osm.gz, .osm.bz2 or .osm.pbf: "
                 "its streets, with junctions")
      ->required();
  app.add_option("-o,--output", o.output, "OpenDRIVE file to write")->required();
  app.add_option("--origin", o.origin,
                 "LAT,LON[,H]: where the local frame stands, degrees and metres. Default: centre of the data "
                 "at height 0");
  app.add_option("--max-error", o.import.max_error_m,
                 "Greatest allowed distance of a point from the road, m. Default: 0.1, or 3 for GPX tracks");
  app.add_option("--max-height-error", o.import.max_height_error_m,
                 "Greatest allowed height of a point above or below the road, m. Default: 0.1 to 1 by their "
                 "roughness, or 3 for GPX tracks");
  app.add_option("--tangents", o.tangents,
                 "fit: least squares; catmull-rom: through points, tangents from neighbours; curvature: through "
                 "points, with continuous curvature")
      ->check(CLI::IsMember({"fit", "catmull-rom", "curvature"}))
      ->capture_default_str();
  app.add_option("--width", o.import.width_m,
                 "Width of the whole road where the file has none, m; of two lanes where it has a number of them")
      ->capture_default_str();
  app.add_option("--field", o.fields,
                 "WHAT=NAME: where the files say the road's width (m), number of lanes, height (m) or name, WHAT being "
                 "one of these words: a column of a .csv, a property of features. May be given several times");
  app.add_option("--closed", o.closed, "auto, yes or no: whether a line is a loop")
      ->check(CLI::IsMember({"auto", "yes", "no"}))
      ->capture_default_str();
  app.add_flag("--reject-outliers", o.import.reject_outliers,
               "Leave out points that lie off the course of their neighbours by more than 3 times the allowed error");
  app.add_flag("--left-hand", o.import.left_hand_traffic, "OpenStreetMap: traffic keeps left");
  app.add_option("--heights", o.heights.dem_path,
                 "Elevation file: the roads' heights are fitted to its ground, those of the source forgotten");
  app.add_option("--dem-encoding", o.heights.encoding, "What its pixels are: heights, terrain-rgb or terrarium")
      ->capture_default_str();
  app.add_option("--dem-datum", o.heights.datum, "What its heights are above: geoid, ellipsoid or file: what it says")
      ->capture_default_str();
  app.add_option("--road-datum", o.heights.road_datum,
                 "With --heights: what the roads' heights shall be above: geoid, ellipsoid or file: the elevation's")
      ->capture_default_str();
  app.add_option("--geoid", o.heights.geoid_path,
                 "Grid of geoid undulations: .gtx, GeoTIFF or .pgm. Default: what PROJ has");
  app.add_option("--max-grade", o.heights.fit.max_grade,
                 "With --heights: greatest grade, rise per length. Default: by the road's class, 0.06 to 0.2");
  app.add_option("--max-vertical-curvature", o.heights.fit.max_curvature_per_m,
                 "With --heights: greatest curvature of crests and sags, 1/m. Default: by class, 1/3000 to 1/100");
  app.add_option("--smoothing", o.heights.fit.smoothing_m,
                 "With --heights: waves of the ground shorter than about six times this are smoothed away, m")
      ->capture_default_str();
  app.add_option("--report", o.report,
                 "Certificates and diagnostics: JSON, - for standard output; or a page with plan and plots, .html");
}

Status take_field(const std::string& text, FieldNames& fields) {
  const std::size_t at = text.find('=');
  const std::string what = text.substr(0, at), name = at == text.npos ? "" : text.substr(at + 1);
  std::string* const field = what == "width"    ? &fields.width
                             : what == "lanes"  ? &fields.lanes
                             : what == "height" ? &fields.height
                             : what == "name"   ? &fields.name
                                                : nullptr;
  if (field && !name.empty()) {
    *field = name;
    return Done{};
  }
  return Error{ErrorCode::kUsage, "--field " + text + ": expected width=NAME, lanes=NAME, height=NAME or name=NAME"};
}

Status settle(Options& o) {
  for (const std::string& field : o.fields) {
    if (Status status = take_field(field, o.import.fields); !status) return status;
  }
  if (!o.origin.empty()) {
    const Result<Georeference> origin = parse_origin(o.origin);
    if (!origin) return origin.error();
    o.import.origin = *origin;
  }
  o.import.tangents = o.tangents == "fit" ? TangentSource::kFit : TangentSource::kCatmullRom;
  if (o.tangents == "curvature") o.import.catmull_rom = Tangents::kCurvature;
  o.import.heights_follow = !o.heights.dem_path.empty();
  o.import.closed = o.closed == "auto" ? Closed::kAuto : o.closed == "yes" ? Closed::kYes : Closed::kNo;

  // Before the work, not after it.
  std::error_code ignored;
  for (const std::string& source : o.sources) {
    if (std::filesystem::equivalent(source, o.output, ignored)) {
      return Error{ErrorCode::kUsage, "is a source and the output: name another output", o.output};
    }
  }
  const auto plain = [](const std::string& path) { return std::filesystem::absolute(path).lexically_normal(); };
  if (!o.report.empty() && plain(o.report) == plain(o.output)) {
    return Error{ErrorCode::kUsage, "is the output and the report: name two files", o.output};
  }
  if (Status status = check_writable(o.output); !status) return status;
  return o.report.empty() || o.report == "-" ? Status(Done{}) : check_writable(o.report);
}

// More roads than this are told in one line.
constexpr std::size_t kMostTold = 200;

void print_certificates(const ImportResult& result) {
  if (result.certificates.size() > kMostTold) {
    double length_m = 0, worst_m = 0;
    for (const Certificate& c : result.certificates) {
      length_m += c.length_m;
      worst_m = std::max(worst_m, c.max_error_m);
    }
    fmt::print(stderr, "{} roads, {:.3f} km, {} segments, {} junctions; greatest distance of a point {:.2f} m\n",
               result.network.roads.size(), length_m / 1000, result.network.segment_count(),
               result.network.junctions.size(), worst_m);
    return;
  }
  fmt::print(stderr, "{:>4} {:28} {:>6} {:>10} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8}\n", "road", "name", "closed",
             "length m", "points", "segm.", "max m", "rms m", "bound m", "height m");
  for (std::size_t i = 0; i < result.certificates.size(); ++i) {
    const Certificate& c = result.certificates[i];
    fmt::print(stderr, "{:>4} {:28.28} {:>6} {:>10.2f} {:>7} {:>7} {:>8.4f} {:>8.4f} {:>8.4f} {:>8.3f}\n", c.id,
               result.network.roads[i].name, c.closed ? "yes" : "no", c.length_m, c.samples, c.segments, c.max_error_m,
               c.rms_error_m, c.bound_m, c.max_elevation_error_m);
  }
}

// The centre lines are those that were certified but for what divided segments are off.
void take_heights(ImportResult& result, const HeightFitReport& heights) {
  result.heights = heights;
  for (std::size_t i = 0; i < result.certificates.size(); ++i) {
    Certificate& c = result.certificates[i];
    if (c.segments == result.network.roads[i].segments.size()) continue;
    c.segments = result.network.roads[i].segments.size();
    c.bound_m += kDividedGap_m;
  }
}

void print_heights(const HeightFitReport& h) {
  fmt::print(
      stderr,
      "heights: {:.2f} m rms from the ground at {} samples, fill up to {:.1f} m, cut up to {:.1f} m; greatest grade "
      "{:.1f} %, least vertical radius {:.0f} m; {} roads beyond their limits\n",
      h.rms_m, h.samples, h.highest_fill_m, h.deepest_cut_m, 100 * h.max_grade,
      h.max_curvature_per_m > 0 ? 1 / h.max_curvature_per_m : 1e9, std::max(h.over_grade, h.over_curvature));
}

}  // namespace

int import_command(const Arguments& arguments, LayOnGround lay_on_ground) {
  CLI::App app("Fits roads to measured centre lines and writes them as OpenDRIVE 1.7.", kName);
  Options o;
  declare(app, o);
  if (const auto code = parse(app, arguments)) return *code;
  if (Status status = settle(o); !status) return fail(kName, status.error());

  ProgressLine progress;
  Result<ImportResult> result =
      import_files(o.sources, o.import, [&](double part, const std::string& what) { progress.show(part, what); });
  if (result && !o.heights.dem_path.empty()) {
    progress.show(1, "fitting heights");
    const Result<HeightFitReport> heights = lay_on_ground(result->network, o.heights, result->diagnostics);
    if (!heights) {
      result = heights.error();
    } else {
      take_heights(*result, *heights);
    }
  }
  progress.clear();
  if (!result) return fail(kName, result.error());

  if (Status status = write_opendrive(result->network, o.output); !status) return fail(kName, status.error());
  if (!o.report.empty()) {
    const bool page = std::filesystem::path(o.report).extension() == ".html";
    const std::string report = page ? import_html(*result) : import_report(*result);
    if (Status status = put_out(report, o.report); !status) return fail(kName, status.error());
  }
  print_diagnostics(result->diagnostics, o.report.empty() ? "; --report FILE lists them" : ", in " + o.report);
  print_certificates(*result);
  if (result->heights) print_heights(*result->heights);
  return kExitDone;
}

}  // namespace roadgen::cli
