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
// Properties that fields name give a feature's width, number of lanes, height (where its points have none) and name; one
// that is null or empty leaves the default, one that is no number too, with a warning.
// Points that are not finite are left out with a warning.
// Errors: kIo; kParse where the text is not UTF-8 or GDAL cannot read the file; kData where it holds no line, or where no
// layer has a property that is named.
Result<std::vector<Track>> read_vector(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics);

}  // namespace roadgen
