// The report of an import as a page to look at.
#pragma once

#include <string>

#include "roadgen/import/import.h"

namespace roadgen {

// Of more roads than this only those with the greatest part of their allowed error get plots of their own.
inline constexpr std::size_t kMostPlottedRoads = 40;
// And the table and the list of diagnostics end here, with a line that says how many are left out.
inline constexpr std::size_t kMostRows = 1000;
// Of a network of more segments the plan shows each road in one colour.
inline constexpr std::size_t kMostPlannedSegments = 20000;

// One HTML file with its pictures in it (SVG), for any browser, without scripts: a table of the certificates; a plan of
// the network, coloured by the greatest distance of a point from each segment, as part of the error that was allowed; and
// for each road, along s, the signed distances of its points, its curvature and its elevation with the points' heights.
// Cost: about 10 us a point, 100 bytes a segment of the plan and 100 kB a road with plots.
std::string import_html(const ImportResult& result);

}  // namespace roadgen
