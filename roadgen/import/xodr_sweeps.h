// <tunnel>, and <object>s that are guard rails, pipes and cables. Internal to roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clause 13.
#pragma once

#include <functional>
#include <vector>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

// A sweep and its place among those of its road; foreign ones come last.
struct XodrSweep {
  double order = 1e300;
  Sweep sweep;
};

// Appends the sweeps that the element stands for; returns false where it is none. Our own come back as they were.
// Others have default dimensions, but that a tunnel is as wide as it must be for the road's lanes, and a guard rail as
// high as the file says. An object whose name, type or subtype says guard rail goes from end to end of each <repeat>, or
// of its own length along the road. What reaches beyond the road is cut off; what has no length or impossible sizes is
// dropped, with notes. Requires: the road's segments and sections. Errors (in source): kParse for malformed attributes.
bool read_sweeps(XodrSource& source, const pugi::xml_node& element, const Road& road,
                 const std::function<double(double)>& station_m, std::vector<XodrSweep>& sweeps);

}  // namespace roadgen
