// <header> of an OpenDRIVE file. Internal to roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clauses 7.1 and 8.5.
#pragma once

#include <optional>
#include <string>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

struct XodrHeader {
  std::string name;
  std::optional<Georeference> georeference;
};

// A georeference is topocentric where the file is our own, or <geoReference> an orthographic projection of WGS84 without
// offset; otherwise it is the projection with the file's <offset>. One that is no projected system in metres is not kept,
// and a note says why. Errors (in source): kParse for malformed numbers and our own origin; kData for a version other
// than 1.x.
XodrHeader read_header(XodrSource& source, const pugi::xml_node& node);

}  // namespace roadgen
