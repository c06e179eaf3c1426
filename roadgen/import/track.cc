#include "roadgen/import/track.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "roadgen/import/csv.h"
#include "roadgen/import/gpx.h"
#include "roadgen/import/ogr.h"
#include "roadgen/road/network.h"

namespace roadgen {

Result<std::vector<Track>> read_tracks(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });

  if (ending == ".csv" || ending == ".txt") return read_csv(path, fields, diagnostics);
  if (ending == ".gpx") return read_gpx(path, fields, diagnostics);
  for (const char* known : {".geojson", ".json", ".kml", ".shp", ".gpkg"}) {
    if (ending == known) return read_vector(path, fields, diagnostics);
  }
  // A missing file is the likelier slip.
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return Error{ErrorCode::kIo, "no such file; check the path", path};
  if (std::filesystem::is_directory(path, ignored)) {
    return Error{ErrorCode::kIo, "is a folder; name a file in it", path};
  }
  return Error{ErrorCode::kParse,
               "is of an unknown kind: the name must end in .csv, .txt, .geojson, .json, .gpx, .kml, .shp, .gpkg, .osm, "
               ".osm.gz, .osm.bz2 or .osm.pbf",
               path};
}

std::optional<int> lane_count(double x, const std::string& file, int line, const std::string& element,
                              Diagnostics& diagnostics) {
  if (x >= 1 && x <= kMostLanes && x == std::round(x)) return static_cast<int>(x);
  diagnostics.push_back({Severity::kWarning,
                         "the number of lanes is not one of 1 to " + std::to_string(kMostLanes) + ": the default is used",
                         file, line, element});
  return {};
}

std::string points_text(const TrackPoint& first, const TrackPoint& last) {
  if (first.index == last.index) return "point " + std::to_string(first.index);
  return "points " + std::to_string(first.index) + "-" + std::to_string(last.index);
}

std::string stem(const std::string& path) { return std::filesystem::path(path).stem().string(); }

}  // namespace roadgen
