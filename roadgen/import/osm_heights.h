// Heights of OSM ways: level at 0 but where bridges and tunnels cross other ways. Internal to roadgen/import.
#pragma once

#include <vector>

#include "roadgen/import/osm_course.h"
#include "roadgen/import/osm_junctions.h"

namespace roadgen {

// Heights at distances along a line, increasing; between them a monotone cubic, level beyond them. Empty: 0.
struct HeightProfile {
  std::vector<double> at_m, z_m;

  struct Value {
    double z_m = 0, grade = 0;
  };
  Value value(double distance_m) const;
};

// From the surface of the lower road to that of the upper one: 4.7 m of clear height (RAA 2008, 4.5 m and 0.2 m for new
// pavement) and a deck of 0.8 m.
inline constexpr double kLevel_m = 5.5;
// Ramps have the grade of their class on the mean between two knots; where ways cross so near to one another that this
// does not do, up to this one. A knot may be passed with half as much again.
inline constexpr double kGreatestRamp = 0.12;

// A profile for every line, or none at all where every road lies at 0. Where two lines cross without a common node and
// their layers differ, a tunnel goes down to kLevel_m below the other or else a bridge up to kLevel_m above it: no more
// than that, level between two crossings of one bridge or tunnel, with ramps that go on along all lines that meet it.
// Lines are level where they lie in a junction's area, all of them at one height.
// Findings: crossings of less than kLevel_m, where even kGreatestRamp does not do.
// Cost: O(legs) and O(crossings log crossings) a round, kMostHeightRounds rounds.
std::vector<HeightProfile> find_heights(const OsmScene& scene, const OsmJunctions& junctions,
                                        ElementFindings& findings);
inline constexpr int kMostHeightRounds = 16;

}  // namespace roadgen
