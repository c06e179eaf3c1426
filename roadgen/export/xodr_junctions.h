// Links of OpenDRIVE roads, and <junction>. Internal to roadgen/export.
//
// A junction's area is stored by what make_junction needs to lay it again: userData "roadgen:area" (corner radius,
// underlap) and one "roadgen:arm" for every arm (JunctionArm's numbers, then the road's id). A junction without an area
// says so by "roadgen:area" of value "none".
//
// OpenDRIVE wants a connection in every junction. One that no way leads through, as where no area fits between roads of
// OpenStreetMap, stands whole in a <userData> of the root, code "roadgen:junction" and its place among all junctions as
// value; and the links to it in a <userData code="roadgen:link"> of their road.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/export/xml_writer.h"
#include "roadgen/road/movement.h"
#include "roadgen/road/network.h"

namespace roadgen {

using JunctionIds = std::set<std::string_view>;
// Junctions that no way leads through. Cost: O(n log n).
JunctionIds closed_junctions(const Network& network, const RoadsById& roads);

// The road's <link>: what lies beyond its ends, without closed junctions.
void write_links(XmlWriter& out, const Road& road, const JunctionIds& closed);
// userData "roadgen:link": the links to those.
void write_closed_links(XmlWriter& out, const Road& road, const JunctionIds& closed);
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

// All junctions that are not closed, or all that are.
void write_junctions(XmlWriter& out, const Network& network, const RoadsById& roads, const JunctionIds& closed,
                     bool closed_ones);

// Errors: kData for a junction without id, or with that of another, or with an area that make_junction would not lay.
Status check_junctions(const Network& network);

}  // namespace roadgen
