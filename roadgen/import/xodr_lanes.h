// <lanes> of an OpenDRIVE road as cross sections. Internal to roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clause 11. A section of the file is divided where a record of a lane's width, border,
// height, material, mark, speed, access or rule begins, or one of the lane offset, so that each part holds one of each.
#pragma once

#include <vector>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/lane.h"
#include "roadgen/road/records.h"

namespace roadgen {

struct LaneHeights {
  double inner_m = 0, outer_m = 0;
};

// A lane of the file; s from the road's start.
struct XodrLane {
  int id = 0;
  int line = 0;
  LaneType type = LaneType::kNone;
  Profile widths, borders;  // borders count where there are no widths
  std::vector<From<Mark>> marks;
  std::vector<From<LaneHeights>> heights;
  std::vector<From<Material>> materials;
  std::vector<From<SpeedLimit>> speeds;
  std::vector<From<std::string>> accesses, rules;  // the elements that begin at s, as text, their sOffset 0
};

struct XodrLaneSection {
  double s_m = 0;
  int line = 0;
  bool single_side = false;           // says nothing about a side that has no lanes
  std::vector<XodrLane> left, right;  // from the centre outward
  std::vector<From<Mark>> center_marks;
};

struct XodrLanes {
  Profile offsets;
  std::vector<XodrLaneSection> sections;

  // Where a cross section must begin, in no order.
  std::vector<double> changes_m() const;
};

// Reads <lanes> of the road. Errors (in source): kParse for missing or malformed attributes, records or sections out of
// order, lane ids that are not 1, 2, ... on the left and -1, -2, ... on the right.
XodrLanes read_lanes(XodrSource& source, const pugi::xml_node& road);

// The cross sections at the stations that changes_m fall on, s and lengths in the file's s, and what else holds for their
// lanes. Errors (in source): no section at the road's start; a width beyond 1e6 m.
struct LaneSections {
  std::vector<LaneSection> sections;
  std::vector<LaneRecord> records;
};
LaneSections lane_sections(XodrSource& source, const XodrLanes& lanes, const Stations& stations, double start_m);

}  // namespace roadgen
