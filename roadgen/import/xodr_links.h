// Links of OpenDRIVE roads and lanes, and <junction> as a node of the road graph. Internal to roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clauses 8.2, 11.4 and 12.
#pragma once

#include <optional>
#include <vector>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

// A <junction>; area and arms as our own files carry them.
struct XodrJunction {
  JunctionLinks links;
  int line = 0;
  std::optional<std::size_t> place;  // among all junctions, where the file has it elsewhere
  bool own = false;                  // says itself whether it has an area
  struct Area {
    double corner_radius_m = 0, underlap_m = 0;
    std::vector<JunctionArm> arms;
  };
  std::optional<Area> area;
};

// Of the root: whether it holds a junction that no way leads through (roadgen/export/xodr_junctions.h).
bool holds_junction(const pugi::xml_node& user_data);

// Reads the junction that the road lies in, its links with those of its first and last lanes, and whether it is closed.
void read_links(XodrSource& source, const pugi::xml_node& node, Road& road);

// Takes joined_start and joined_end where our own file says them; returns whether it does.
bool read_joined(XodrSource& source, const pugi::xml_node& node, Road& road);

// Errors (in source): kParse where the id is missing or a number malformed.
XodrJunction read_junction(XodrSource& source, const pugi::xml_node& node);

// Drops links to what the network does not have, with notes, and notes those that the other side does not return.
void settle_links(XodrSource& source, Network& network);

}  // namespace roadgen
