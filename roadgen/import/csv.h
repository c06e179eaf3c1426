// Tracks from tables of text.
//
// The first line that is not blank names the columns, in any order and case; a leading '#' is allowed. Separators are
// comma, semicolon or tab, whichever the header has. Columns:
//   lat, latitude | lon, lng, long, longitude    degrees on WGS84, or
//   x, x_m, east, easting | y, y_m, north, northing    metres, east and north
//   height, h, z, z_m, ele, elev, elevation, alt, altitude    metres; may be missing or empty
//   width, w, width_m    full width of the road in metres; may be missing or empty
//   any name that FieldNames give for width, height or lanes (a number of lanes, the first one of which holds)
// Other columns are ignored with a diagnostic. Lines that are blank or start with '#' are skipped.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "roadgen/import/track.h"

namespace roadgen {

// One track. Rows whose position is empty, nan or inf are left out with a warning.
// Errors: kIo; kParse with the line: not UTF-8, no header, a column named twice, a position that needs two columns and
// has one, a row with fewer or more cells than the header (a truncated file), a cell that is not a number; kData where a
// field that is named is not there.
Result<std::vector<Track>> read_csv(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics);

// Likewise from text; file is the name for errors.
Result<std::vector<Track>> parse_csv(std::string_view text, const std::string& file, const FieldNames& fields,
                                     Diagnostics& diagnostics);

}  // namespace roadgen
