// A street grid as an OpenStreetMap file.
#pragma once

#include <cstddef>
#include <string>

namespace roadgen::test {

// Writes about `ways` ways of two blocks of 100 m each, of several classes, in the format that the name ends in
// (.osm, .osm.gz, .osm.pbf): crossings at every node within. Returns their number. Throws what libosmium throws.
// Cost: 1 us and no memory a way.
std::size_t write_osm_city(const std::string& path, std::size_t ways);

}  // namespace roadgen::test
