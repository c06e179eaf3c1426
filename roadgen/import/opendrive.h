// OpenDRIVE 1.4 to 1.8 files as a network.
//
// Read:
// * Geometry: line, arc, spiral, poly3 and paramPoly3 (both parameter ranges), divided into segments that keep the
//   curve's points and tangents at their ends, lie within kPlanTolerance_m of it, and are certified for the road's width
//   (plan_curve.h). Gaps of up to 1 cm between geometries are closed.
// * Elevation, superelevation, crossfall and shape (xodr_lateral.h says how), lane sections with offsets, widths or
//   borders, heights, materials and road marks. A record may begin anywhere: segments and sections are divided there, s
//   of the file kept to kPlanArcTolerance_m a segment. Records within 2 mm of a joint are moved to it. Broken lines begin
//   anew with each section.
// * Objects and signals: stop lines, crosswalks and arrows as paint, guard rails and tunnels as sweeps (xodr_sweeps.h),
//   bridges; all others as records (Road::records), with road types, speeds, and access and rules of lanes. Elements
//   within them that have no member of their own are kept as text.
// * Links of roads and lanes; ends that are linked and meet are joined. Controllers, stations, junction groups.
// * <geoReference> as PROJ string or WKT with the header's <offset>, or the origin in userData "roadgen:origin".
// * Junctions of every type, as nodes of the road graph, and default ones as areas: where the connecting roads of a crossing make one carriageway
//   with its arms, the area is laid between the ends of the arms (add_crossing) and takes their place in pictures and
//   queries (roads_in_areas); elsewhere a note says why the connecting roads stay (xodr_areas.h).
// What is not kept (elements that the standard does not know there, ...) is told once per kind, and so is what no real
// road has, see odd_values, and links that do not agree.
#pragma once

#include <string>
#include <string_view>

#include "roadgen/road/network.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Reads a file. Cost: O(size). A file written by write_opendrive gives the same network bit for bit (zeros unsigned).
// Errors: kIo; kParse with the line, for broken XML, missing attributes, numbers that are not finite, geometry without
// length; kData with line and road for what is not supported, and for more than 8 GiB, 5,000,000 children of <OpenDRIVE>
// or 1,000,000 elements in one of them.
Result<Network> read_opendrive(const std::string& path, Diagnostics* diagnostics = nullptr);

// Likewise from text; file is the name for errors.
Result<Network> parse_opendrive(std::string_view text, const std::string& file, Diagnostics* diagnostics = nullptr);

}  // namespace roadgen
