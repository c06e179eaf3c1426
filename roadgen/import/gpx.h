// Tracks from GPX 1.0 and 1.1 files (TopoGrafix, https://www.topografix.com/gpx.asp): every segment of every track and
// every route becomes one track; waypoints are ignored.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roadgen/import/track.h"

namespace roadgen {

// Points with a position that is nan or inf are left out with a warning.
// Errors: kIo; kParse with the line: not UTF-8, broken XML, no <gpx>, a point without lat or lon, a value that is not a
// number; kData where there is no track and no route.
Result<std::vector<Track>> read_gpx(const std::string& path, Diagnostics& diagnostics);

// Likewise from text; file is the name for errors.
Result<std::vector<Track>> parse_gpx(std::string_view text, const std::string& file, Diagnostics& diagnostics);

}  // namespace roadgen
