// OpenDRIVE 1.4 to 1.8 files as a network.
//
// Read: line and paramPoly3 geometry (both parameter ranges) where the curve is the graph of a cubic over its chord;
// elevation; one lane section with the centre lane and one driving lane of equal width on each side; the link of a
// closed road to itself; the origin in <geoReference> (+proj=ortho) or in userData "roadgen:origin". A profile's record
// may begin only where a geometry begins.
// Anything else that would change the road's shape (other geometry, superelevation, lane offsets, more lanes,
// junctions) is an Error that names what is not supported yet. What does not change the shape (road marks other than
// ours, objects, signals, links to other roads, types, speeds) is reported as a diagnostic, once per kind.
#pragma once

#include <string>
#include <string_view>

#include "roadgen/road/network.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Reads a file. Cost: O(size). A file written by write_opendrive gives the same network bit for bit (zeros unsigned).
// Errors: kIo; kParse with the line, for broken XML, missing attributes, numbers that are not finite, geometry without
// length; kData with line and road for what is not supported.
Result<Network> read_opendrive(const std::string& path, Diagnostics* diagnostics = nullptr);

// Likewise from text; file is the name for errors.
Result<Network> parse_opendrive(std::string_view text, const std::string& file, Diagnostics* diagnostics = nullptr);

}  // namespace roadgen
