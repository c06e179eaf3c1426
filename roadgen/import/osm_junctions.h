// Where lines of OSM ways end at the junctions between them. Internal to roadgen/import.
#pragma once

#include <cstdint>
#include <vector>

#include "roadgen/import/osm_course.h"
#include "roadgen/road/junction.h"

namespace roadgen {

// Nodes that share one area: a junction, or several that lie so close together that no road fits between them.
struct OsmJunction {
  std::uint32_t node = 0;             // the one of the lowest id
  std::vector<LineEnd> ends;          // of the lines that lead to it
  std::vector<std::uint32_t> inside;  // lines that lie within the area
  double radius_m = 6;                // of its corners
  bool area = false;                  // otherwise roads just touch at the node
};

struct OsmJunctions {
  std::vector<OsmJunction> all;
  std::vector<double> cut_m;   // [LineEnd]: what is cut off the line there
  std::vector<char> absorbed;  // [line]: lies within an area
};

// Cuts every line's ends back so far that the area between them has corners of the radius of the lesser class, or what
// fits; where a line would vanish its two junctions become one. An area that cannot be: a finding with the node, and
// cuts of 0. Cost: that of one to eight make_junction a junction, on all cores.
OsmJunctions place_junctions(const OsmScene& scene, ElementFindings& findings);

// The arm that a line has at its end, level, once `cut_m` are cut off.
JunctionArm level_arm(const EndView& view, double cut_m);

}  // namespace roadgen
