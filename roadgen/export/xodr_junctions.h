// Links of OpenDRIVE roads, and <junction>. Internal to roadgen/export.
//
// A junction's area is stored by what make_junction needs to lay it again: userData "roadgen:area" (corner radius,
// underlap) and one "roadgen:arm" for every arm (JunctionArm's numbers, then the road's id). A junction without an area
// says so by "roadgen:area" of value "none".
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>
#include "roadgen/export/xml_writer.h"

#include "roadgen/road/movement.h"
#include "roadgen/road/network.h"

namespace roadgen {

// The road's <link>: what lies beyond its ends.
void write_links(XmlWriter& out, const Road& road);
// userData "roadgen:joined": joined_start and joined_end, where an end is linked or joined.
void write_joined(XmlWriter& out, const Road& road);

using LinksById = std::map<std::string_view, const JunctionLinks*>;
LinksById links_by_id(const Network& network);

// The ways through an area that lists none: movements, with ids of their own that no road has.
struct DerivedWay {
  Movement movement;
  std::string id;
};
std::vector<DerivedWay> derived_ways(const Network& network, const RoadsById& roads, const LinksById& listed,
                                     const Junction& area);

void write_junctions(XmlWriter& out, const Network& network, const RoadsById& roads);

// Errors: kData for a junction without id, or with that of another, or with an area that make_junction would not lay.
Status check_junctions(const Network& network);

}  // namespace roadgen
