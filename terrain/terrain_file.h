// Terrain kept in a file, so that what was built once is read the next time.
//
//   const std::uint64_t key = terrain_key(network_text, &elevation, options);
//   auto terrain = read_terrain("net.ground", key);
//   if (!terrain) terrain = Terrain::build(network, &elevation, options), write_terrain_file(*terrain, key, "net.ground");
//
// The file is of this program's own making, for the machine that wrote it: a cache, never a source.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "terrain/terrain.h"

namespace roadgen {

// What the ground depends on, as one number: the network's file, the elevation's posts and place (nullptr: none), the
// options but for `progress`, the program's version. Two that differ have the same number once in 2^64. Cost: 1 s per GB.
std::uint64_t terrain_key(std::string_view network_file, const Elevation* elevation, const TerrainOptions& options);

// Writes all of the terrain, whole or not at all. Errors: kIo. Cost: some 100 bytes a triangle.
Status write_terrain_file(const Terrain& terrain, std::uint64_t key, const std::string& path);

// The terrain that was written, to the bit. Errors: kIo where there is no such file; kData where it is another key's, was cut
// short or damaged, which a checksum tells.
Result<Terrain> read_terrain_file(const std::string& path, std::uint64_t key);

}  // namespace roadgen
