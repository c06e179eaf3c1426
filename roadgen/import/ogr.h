// Tracks from vector files by GDAL: GeoJSON, KML, Shapefile, GeoPackage.
#pragma once

#include <string>
#include <vector>

#include "roadgen/import/track.h"

namespace roadgen {

// Every LineString, and every part of a MultiLineString, of every layer becomes a track; curves are divided into
// chords, other geometry is counted in a diagnostic. Coordinates in another system are changed to WGS84 by PROJ; a
// layer without a system counts as metres, with a warning. The element is the property id (or name, or the feature's
// number), the name the property name; the case of property names does not matter.
// Points that are not finite are left out with a warning.
// Errors: kIo; kParse where the text is not UTF-8 or GDAL cannot read the file; kData where it holds no line.
Result<std::vector<Track>> read_vector(const std::string& path, Diagnostics& diagnostics);

}  // namespace roadgen
