// <objects>, <signals> and <type> of an OpenDRIVE road: paint (stop lines, crosswalks and arrows), structures, and all
// else as records. Internal to roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clauses 10.3, 13 and 14.
#pragma once

#include "roadgen/import/xodr_records.h"
#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

// Fills paint, sweeps and records of the road, whose sections are there. An object counts as paint by its type and
// subtype, or by its name: crosswalks, stop lines (roadMark signalLines, or signals of type 294 over the lanes that they
// are valid for, which stay signals too) and arrows with at most one turn, which must lie within 0.1 rad of a right angle
// to the road; structures are what read_sweeps knows. Errors (in source): kParse for malformed attributes of paint and
// structures; kData where they lie beyond 1e6 m. Other objects and signals that are malformed are left out, with notes.
void read_objects(XodrSource& source, const pugi::xml_node& node, Road& road, const StationMap& station_m);

}  // namespace roadgen
