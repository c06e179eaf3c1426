// Tracks: the points of roads as files hold them, before cleaning and before any change of coordinates.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "roadgen/road/result.h"

namespace roadgen {

// A point as read. x and y are finite; heights may be void values, widths may be nonsense: clean_track decides.
struct TrackPoint {
  double x = 0;                         // longitude in degrees east, or metres
  double y = 0;                         // latitude in degrees north, or metres
  std::optional<double> height_m = {};  // none where the file has none
  std::optional<double> width_m = {};   // of the whole road
  int index = 0;                        // 1-based number of the point in its track
  int line = 0;                         // 1-based line in the file, or 0 where the reader does not tell
};

// One line string of a file; it becomes one road.
struct Track {
  std::string file;
  std::string element;    // the feature's id, track number, ...; empty where the file is one track
  std::string name;       // for people
  bool geodetic = true;   // longitude and latitude on WGS84, not metres
  bool recorded = false;  // by a moving GPS receiver, not surveyed or drawn on a map
  std::optional<int> lanes = {};  // of both directions; nonsense is left out with a diagnostic
  std::vector<TrackPoint> points = {};
};

// Where a file says what, if not under the names that its reader knows: columns of a .csv, properties of the features of
// a .geojson, .kml, .shp or .gpkg, elements of a .gpx. Empty: not given.
struct FieldNames {
  std::string width;   // of the whole road, metres
  std::string lanes;   // number of lanes of both directions, in [1, kMostLanes]
  std::string height;  // metres
  std::string name;    // of the road; not of a .csv
};

// All tracks of a file, by the ending of its name: .csv and .txt (see csv.h), .gpx (see gpx.h), .geojson, .json, .kml,
// .shp and .gpkg (see ogr.h). Points whose position is missing or not finite are left out with a diagnostic.
// Errors: kIo; kParse with the line where known; kData where the file holds no line, or not a field that is named.
Result<std::vector<Track>> read_tracks(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics);

// The number of lanes that x stands for; none, with a warning (told once for an element), where that makes no sense.
std::optional<int> lane_count(double x, const std::string& file, int line, const std::string& element,
                              Diagnostics& diagnostics);

// "point 7" or "points 7-9"; with the lines of the file where they are known.
std::string points_text(const TrackPoint& first, const TrackPoint& last);

// The file's name without folder and ending.
std::string stem(const std::string& path);

}  // namespace roadgen
