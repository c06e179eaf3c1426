// Measured centre lines to a road network, with a certificate for every road.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roadgen/fit/fit.h"
#include "roadgen/fit/heights.h"
#include "roadgen/import/clean.h"
#include "roadgen/road/network.h"
#include "roadgen/road/result.h"

namespace roadgen {

struct ImportOptions {
  // Origin of the local frame. Default: the centre of the box around all points, rounded to 1e-6 degree so that it can
  // be quoted, at height 0, so that z is the source's height there.
  std::optional<Georeference> origin = {};
  // Greatest allowed horizontal distance of a point from the road, in [kLeastMaxError_m, kGreatestMaxError_m].
  // Default: kMapError_m, or kGpsError_m for recorded tracks (GPX).
  std::optional<double> max_error_m = {};
  TangentSource tangents = TangentSource::kFit;
  Tangents catmull_rom = Tangents::kUniform;
  // Greatest allowed vertical distance of a point from the road, in the same range; heights that no road can follow are
  // left out with a warning. Default: by the heights' own roughness, see height_tolerance_m; kGpsError_m for recorded
  // tracks.
  std::optional<double> max_height_error_m = {};
  FieldNames fields = {};  // where the files say widths, lanes, heights and names
  // Of the whole road, where the file has none, and half of it for each lane where the file has a number of lanes; in
  // [kLeastWidth_m, kGreatestWidth_m]. Default: 7
  double width_m = 7;
  Closed closed = Closed::kAuto;
  bool reject_outliers = false;    // FitOptions::reject_outliers
  bool left_hand_traffic = false;  // OSM files: lanes and traffic keep left
  // OSM files: tunnels keep their vaults where ramps left no room for them, since other heights will be given to all roads,
  // by fit_heights, which takes the vaults away then. Default: no
  bool heights_follow = false;
};
inline constexpr double kLeastMaxError_m = 0.001, kGreatestMaxError_m = 100;
// Public centre lines come rounded to 1e-6 degree: up to 0.056 m in each direction. A smaller error would fit the
// rounding, with more segments and worse curvature.
inline constexpr double kMapError_m = 0.1;
// Heights of a survey are good to centimetres, those of coarse elevation models come in steps of metres. What is allowed
// is three times the mean distance of a height from the straight line between its neighbours, within these bounds.
inline constexpr double kLeastHeightError_m = 0.1, kGreatestHeightError_m = 1;
double height_tolerance_m(std::span<const Sample> samples);
// A GPS receiver is off by about 2 m rms, more beside walls and trees, and its track has kinks that no vehicle drove.
inline constexpr double kGpsError_m = 3;

struct ImportResult {
  Network network;                        // roads "1", "2", ... in the order of the files
  std::vector<Certificate> certificates;  // one for each road, in order
  std::vector<double> allowed_error_m;    // likewise: the max_error_m that it was fitted to
  // What each was fitted to; empty for OSM files, whose roads follow their ways by construction.
  std::vector<std::vector<Sample>> samples = {};
  std::optional<HeightFitReport> heights = {};  // where the network's heights were fitted to the ground afterwards
  Diagnostics diagnostics;                      // every repair, by file, line and element
  double greatest_distance_m = 0;               // of a point from the origin, horizontally; 0 for metres
};

// Called with the part that is done, in [0, 1], and what is being done.
using Progress = std::function<void(double part, const std::string& what)>;

// An OSM file (see osm_network.h) is imported alone. Of other files:
// Reads, cleans and fits every track of the files (see track.h and clean.h for what that is). All files share one
// frame: either all hold latitudes and longitudes or all hold metres.
// Tracks with fewer than two distinct points are left out with a warning where others remain.
// Errors: kUsage for options out of range, an origin given for metres, no files; else as the readers, clean_track and
// fit_road, with file and element.
Result<ImportResult> import_files(const std::vector<std::string>& paths, const ImportOptions& options,
                                  const Progress& progress = {});

// Warns where points lie so far from the origin that lengths appear shortened.
void add_distance_warning(ImportResult& result, const std::string& path);

// The report of an import as JSON: {"origin", "length_distortion", "roads": [...], "heights": {...}, "diagnostics": [...]};
// origin and length_distortion are absent for metres, heights where none were fitted.
std::string import_report(const ImportResult& result);

}  // namespace roadgen
