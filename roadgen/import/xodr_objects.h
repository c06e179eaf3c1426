// <objects> and <signals> of an OpenDRIVE road that are paint: stop lines, crosswalks and arrows. Internal to
// roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clauses 13 and 14.
#pragma once

#include <functional>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

// The paint of the road, whose sections are there; station_m takes the file's s to the road's. An object counts by its
// type and subtype, or by its name: crosswalks, stop lines (roadMark signalLines, or signals of type 294 over the lanes
// that they are valid for) and arrows with at most one turn. It must lie within 0.1 rad of a right angle to the road.
// What else there is, is noted. Errors (in source): kParse for malformed attributes; kData beyond 1e6 m.
std::vector<Paint> read_paint(XodrSource& source, const pugi::xml_node& node, const Road& road,
                              const std::function<double(double)>& station_m);

}  // namespace roadgen
