// What an OpenDRIVE road has beside its lanes, as records: the counterpart of roadgen/import/xodr_records.h. Internal to
// roadgen/export.
//
// Source: ASAM OpenDRIVE 1.7, clauses 10.3, 11.7.4, 13 and 14.
#pragma once

#include "roadgen/export/xml_writer.h"
#include "roadgen/road/network.h"

namespace roadgen {

const char* orientation_name(Orientation orientation);

// Elements that are kept as text; nothing where there are none.
void write_kept(XmlWriter& out, const char* indent, const std::string& xml);

void write_types(XmlWriter& out, const Road& road);
void write_object(XmlWriter& out, const RoadObject& object);
void write_bridge(XmlWriter& out, const Bridge& bridge);
void write_signals(XmlWriter& out, const Road& road);
void write_controllers(XmlWriter& out, const Network& network);

// The record of a lane in a section, or null. Cost: O(log n).
const LaneRecord* lane_record(const Road& road, std::size_t section, int lane);
void write_speed(XmlWriter& out, const char* indent, const char* offset, const SpeedLimit& speed);

}  // namespace roadgen
