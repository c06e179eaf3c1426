// Ways that lie so close to one another that their carriageways overlap. Internal to roadgen/import.
#pragma once

#include <vector>

#include "roadgen/import/osm_heights.h"
#include "roadgen/import/osm_junctions.h"

namespace roadgen {

// Findings: pairs of lines closer than kOverlap of what their carriageways need side by side, at less than kLevel_m / 2
// of difference in height, outside the areas that they share: ways that cross without a node, carriageways drawn too
// close to one another, a way that leads through another one's junction. Lines that touch at a node without an area have
// been told already.
// Cost: O(legs log legs) for legs of some hundred metres that do not crowd; of places crowded by more than kMostCrowded
// legs within 64 m only so many are looked at.
void find_overlaps(const OsmScene& scene, const OsmJunctions& junctions, const std::vector<HeightProfile>& heights,
                   ElementFindings& findings);
inline constexpr double kOverlap = 0.8;
inline constexpr std::size_t kMostCrowded = 500;

}  // namespace roadgen
