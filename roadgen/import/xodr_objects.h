// <objects> and <signals> of an OpenDRIVE road: paint (stop lines, crosswalks and arrows) and structures. Internal to
// roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clauses 13 and 14.
#pragma once

#include <functional>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

// Fills paint and sweeps of the road, whose sections are there; station_m takes the file's s to the road's. An object
// counts by its type and subtype, or by its name: crosswalks, stop lines (roadMark signalLines, or signals of type 294
// over the lanes that they are valid for) and arrows with at most one turn, which must lie within 0.1 rad of a right
// angle to the road; and what read_sweeps knows. What else there is, is noted by type. Errors (in source): kParse for
// malformed attributes; kData beyond 1e6 m.
void read_objects(XodrSource& source, const pugi::xml_node& node, Road& road,
                  const std::function<double(double)>& station_m);

}  // namespace roadgen
