// Areas of OpenDRIVE junctions: our own file's as they were; elsewhere laid between the ends of the roads that meet.
// Internal to roadgen/import.
#pragma once

#include <vector>

#include "roadgen/import/xodr_links.h"
#include "roadgen/road/network.h"

namespace roadgen {

// Adds to the network, whose roads are all there, the areas of its junctions.
//
// Another program's junction has its carriageway in its connecting roads, one over the other. It gets an area, with
// add_crossing, where that is the same carriageway: the lanes of the connecting roads lie within kMostOutside_m of the
// area and kMostStep_m of its height, and cover all of it but kMostFree. Otherwise its roads stay what is drawn, and a
// note says why.
void add_areas(XodrSource& source, const std::vector<XodrJunction>& junctions, Network& network);

}  // namespace roadgen
