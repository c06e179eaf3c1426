// A small town built through the C++ interface: streets with kerbs and sidewalks, markings of every kind, a banked bend,
// a hill.
#pragma once

#include "roadgen/road/network.h"

namespace roadgen::demo {

// Errors: as road_from_anchors and set_sections.
Result<Network> town();

}  // namespace roadgen::demo
