// OpenStreetMap files to a road network: carriageways by class and tags, junctions with areas at shared nodes.
#pragma once

#include <string>

#include "roadgen/import/import.h"

namespace roadgen {

// Reads .osm, .osm.gz, .osm.bz2 and .osm.pbf files. Of ImportOptions origin and left_hand_traffic matter.
//
// Ways of the classes in osm_tags.cc become roads with the lanes, widths, shoulders, sidewalks and marks of their class
// where no tag says otherwise; a road goes on through ways of equal tags. Its id is that of its first way, followed by
// ".2" and so on where a way gives several roads; its name and class are the way's. Nodes that ways share become
// junctions, whose id is that of the node; of nodes so close together that no road fits between them, the first one's.
// Heights: 0, but for bridges and tunnels where they cross other ways (osm_heights.h).
// Certificates: the samples are the ways' nodes outside junction areas.
// Findings name ways and nodes; see the parts of the import.
// Errors: as read_osm; kData where no road comes about.
// Cost: about 0.1 ms of one core and 6.5 kB of memory a way of two blocks with a junction, on all cores; the result does
// not depend on their number.
Result<ImportResult> import_osm(const std::string& path, const ImportOptions& options, const Progress& progress = {});

}  // namespace roadgen
