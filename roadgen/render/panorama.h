// Pictures of all that surrounds a place: equirectangular, the middle column to the east (+x), columns clockwise seen from
// above, rows from the zenith down.
#pragma once

#include <filesystem>

#include "roadgen/render/image.h"
#include "roadgen/road/result.h"

namespace roadgen {

// An OpenEXR or Radiance file (.exr, .hdr), as linear radiance in the channels R, G, B. Values that are not finite or
// below 0 become 0, those above 60,000 that. Errors: kUsage for another ending; kIo; kData: not about twice as wide as
// high, larger than 16,384 pixels, without three channels.
Result<ImageF> read_panorama(const std::filesystem::path& path);

}  // namespace roadgen
