// Tracks from GPX 1.0 and 1.1 files (TopoGrafix, https://www.topografix.com/gpx.asp): every segment of every track and
// every route becomes one track; waypoints are ignored.
//
// Fields that the caller names are elements, whatever their namespace and case, of a point or its <extensions>, else of the
// segment, track or route that it belongs to.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roadgen/import/track.h"

namespace roadgen {

// Points with a position that is nan or inf are left out with a warning.
// Errors: kIo; kParse with the line: not UTF-8, broken XML, no <gpx>, a point without lat or lon, a value that is not a
// number; kData where there is no track and no route, or nowhere a field that is named.
Result<std::vector<Track>> read_gpx(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics);

// Likewise from text; file is the name for errors.
Result<std::vector<Track>> parse_gpx(std::string_view text, const std::string& file, const FieldNames& fields,
                                     Diagnostics& diagnostics);

}  // namespace roadgen
