// The network's lines as GeoJSON.
#pragma once

#include <string>

#include "roadgen/road/network.h"

namespace roadgen {

// A FeatureCollection (RFC 7946): for every road its reference line and all lane borders as LineStrings of longitude,
// latitude (degrees, WGS84, 1e-9) and height (m), none farther than max_error_m from the road's own curve; positions are
// at most 100 m apart, over which the Earth's bend is 0.2 mm. Properties: "road" (id), "name", "kind" ("reference line"
// or "lane border"), and of a border "lane" (the id of the lane whose outer border it is; 0: the middle) and "mark" (as
// OpenDRIVE names it). One line a lane section.
// Errors: kUsage for an error not in [1e-4, 1e3] m; kData for a network without georeference.
Result<std::string> geojson_text(const Network& network, double max_error_m = 0.05);

}  // namespace roadgen
