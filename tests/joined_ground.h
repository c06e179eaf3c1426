// The ground at a level of detail as tiles of their own, for looking at it in the data channels, which show all triangles.
#pragma once

#include <span>
#include <vector>

#include "terrain/detail.h"
#include "terrain/ground_source.h"
#include "terrain/terrain.h"

namespace roadgen::test {

inline std::vector<TerrainMesh> joined(std::span<const TerrainMesh> tiles, const Detail& detail) {
  std::vector<TerrainMesh> result(tiles.begin(), tiles.end());
  std::vector<std::uint32_t> chosen;
  for (TerrainMesh& tile : result) {
    select_triangles(view_of(tile), static_cast<std::uint32_t>(tile.bands.size()), detail, chosen);
    const std::size_t whole = tile.whole();
    for (TerrainMesh::Cut& cut : tile.cuts) {
      cut.first = static_cast<std::uint32_t>(cut.first - whole + chosen.size());
    }
    chosen.insert(chosen.end(), tile.triangles.begin() + static_cast<std::ptrdiff_t>(whole), tile.triangles.end());
    tile.triangles = chosen;
    tile.nodes.clear();
  }
  return result;
}

// The coarsest level there is: what an eye very far away sees.
inline std::vector<TerrainMesh> coarsest(std::span<const TerrainMesh> tiles) {
  return joined(tiles, {.eye_m = {0, 0, 1e12}, .room_m = 0, .part = 1});
}

inline std::size_t triangle_count(std::span<const TerrainMesh> tiles) {
  std::size_t count = 0;
  for (const TerrainMesh& tile : tiles) count += tile.triangles.size() / 3;
  return count;
}

}  // namespace roadgen::test
