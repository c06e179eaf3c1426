// <planView> of an OpenDRIVE road as segments. Internal to roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clause 9.
#pragma once

#include <optional>
#include <vector>

#include "roadgen/import/plan_curve.h"
#include "roadgen/import/xodr_source.h"
#include "roadgen/road/lane.h"

namespace roadgen {

// A <geometry> of the file.
struct XodrGeometry {
  double s_m = 0, length_m = 0;
  PlanCurve curve = Clothoid{};
  double arc_m = 0;            // of the curve
  std::optional<Segment> own;  // written by us, unrounded
  int line = 0;
};

// A segment and the stretch [from_m, to_m] of the file's s that it stands for; length_m by its geometry.
struct PlacedSegment {
  Segment segment;
  double from_m = 0, to_m = 0, length_m = 0;
  bool own = false;  // written by us
};

// Errors (in source): kParse for missing or malformed attributes, no geometry, one that does not start where the one
// before ends; kData and kGeometry for shapes that are not known, without length or beyond 1e9 m.
std::vector<XodrGeometry> read_plan_view(XodrSource& source, pugi::xml_node node);

// The geometries divided at the stations into segments that are certified for the width of the sections. Errors (in
// source): kGeometry.
std::vector<PlacedSegment> place_segments(XodrSource& source, const std::vector<XodrGeometry>& plan,
                                          const Stations& stations, const std::vector<LaneSection>& sections);

// Closes small gaps between neighbours, and between the last and the first of a closed road. Errors (in source): kData
// for a closed road that does not end where it starts.
void join_segments(XodrSource& source, std::vector<PlacedSegment>& placed, bool closed, pugi::xml_node node);

}  // namespace roadgen
