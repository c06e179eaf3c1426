// What an OpenDRIVE road has beside its lanes, as records: objects, signals, road types and speeds; controllers. Internal to
// roadgen/import.
//
// Source: ASAM OpenDRIVE 1.7, clauses 10.3, 11.7.4, 13 and 14, and 1.8 where that has more.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "roadgen/import/xodr_source.h"
#include "roadgen/road/network.h"

namespace roadgen {

using StationMap = std::function<double(double)>;  // from the file's s to the road's

// An <object> or a <signal>. None, with a note that names it and says why, where a number is missing, malformed, beyond
// 1e6 or a negative size.
std::optional<RoadObject> read_object(XodrSource& source, const pugi::xml_node& node, const StationMap& station_m);
std::optional<RoadSignal> read_signal(XodrSource& source, const pugi::xml_node& node, const StationMap& station_m);

// A <bridge>, cut off at the ends of its road, of length road_m. None, with a note, as above.
std::optional<Bridge> read_bridge(XodrSource& source, const pugi::xml_node& node, double road_m,
                                  const StationMap& station_m);

// The <type> records of a road; those that are out of order or malformed are left out, with a note.
std::vector<RoadType> read_types(XodrSource& source, const pugi::xml_node& road, const StationMap& station_m);

// The limit of a <speed>; of kind kNone, with a note, where it is malformed.
SpeedLimit read_speed(XodrSource& source, const pugi::xml_node& node);

Controller read_controller(XodrSource& source, const pugi::xml_node& node);

Orientation orientation_of(const pugi::xml_node& node);

// The element as text, without blanks between elements.
std::string element_xml(const pugi::xml_node& node);
// The children of these names, one behind the other; userData of our own files is left out.
std::string elements_xml(const pugi::xml_node& node, std::initializer_list<std::string_view> names);
// The same; children of further names are noted as note_others does. known: read elsewhere.
std::string other_xml(XodrSource& source, const pugi::xml_node& node, const std::string& where,
                      std::initializer_list<std::string_view> kept, std::initializer_list<std::string_view> known);

}  // namespace roadgen
