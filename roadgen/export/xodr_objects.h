// <objects> of an OpenDRIVE road: its paint and its sweeps. Internal to roadgen/export.
//
// Paint is an <object> of type roadMark or crosswalk; a guard rail one of type barrier, pipes and cables of type
// obstacle, each with one <repeat> from end to end; a tunnel is a <tunnel> (ASAM OpenDRIVE 1.7, clauses 13 and 13.11).
// What the standard has no place for follows in userData.
#pragma once

#include "roadgen/export/xml_writer.h"
#include "roadgen/road/network.h"

namespace roadgen {

void write_objects(XmlWriter& out, const Road& road);

bool has_finite_sweeps(const Road& road);

}  // namespace roadgen
