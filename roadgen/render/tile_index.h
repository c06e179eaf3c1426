// Which tiles of the roads a camera sees, and in which order they are drawn. No OpenGL.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "roadgen/render/frustum.h"
#include "roadgen/render/road_instance.h"

namespace roadgen {

// What decides about a tile.
struct TileView {
  Camera camera;
  int width = 1, height = 1;      // pixels
  double haze_range_m = 9000;     // e-folding length of the view through air
  double least_contribution = 0;  // TileIndex::contribution below which a tile is dropped; 0: none is
};

// An upper bound of what a surface changes in the picture, of 1, when it takes the place of another one that is at least
// as far away, where `clear` is the air's transmittance up to it. Haze tends to a bright sky, where the tone curve is
// flat. Holds for albedos up to 0.9, roads near the eye's horizon and any sun; tested against shaders/lib/sky.glsl.
inline double haze_contrast(double clear) { return clear * std::max(0.6, clear); }

// A bounding volume hierarchy over the tiles. Immutable after construction.
class TileIndex {
 public:
  TileIndex() = default;
  // Cost: O(n log n), n tiles; 136 bytes a tile.
  explicit TileIndex(std::span<const RoadTile> tiles);

  // Fills `visible` with the indices of the tiles whose roads may touch the picture (by frustum, far plane included) and
  // that are not dropped for their contribution, far to near: by the number of tile borders between the eye and the
  // tile, which for tiles that hold what begins in them is the order along every ray. Cost: O(v log v + v log n), v visible.
  void select(const TileView& view, std::vector<std::uint32_t>& visible) const;
  // All tiles in the same order.
  void select_all(const TileView& view, std::vector<std::uint32_t>& visible) const;

  // What leaving out all within the box changes in a pixel, as a part of 1, if nothing lies beyond. The roads in the box
  // are within `reach` pixels of the line that is the eye's horizon, since they are at most e above or below the eye and
  // at least d away; they cover at most that part of a pixel's height, in colours that the air has faded:
  //   contribution = min(1, reach) * haze_contrast(exp(-d / haze_range)).
  // On level ground what all dropped tiles together change is at most least_contribution (the nearest dropped tile's band
  // holds all farther ones, which are fainter). In any world it is at most 2 c (1 + ln(1 / c)), c = least_contribution:
  // what is seen at x pixels from the horizon is fainter than c / x. Both in a picture of exact coverage; one of n
  // samples per pixel takes that band or misses it in steps of 1 / n.
  // A box at the eye's own height has reach 0, one beside or behind the image plane contributes 1.
  // What quads and boxes reach beyond a box of footprints, relative to the eye: room for edges that are antialiased over
  // pixels which are long on the ground. An upper bound of room_at in shaders/road.vert, whose ROOM is a hair less
  // than kEdgeRoom_px.
  static constexpr double kEdgeRoom_px = 1.51, kLeastSine = 0.003, kGreatestRoom_m = 25;
  static glm::dvec3 room_m(const TileView& view, glm::dvec3 low_m, glm::dvec3 high_m);
  static double contribution(const TileView& view, glm::dvec3 low_m, glm::dvec3 high_m);

 private:
  struct Node {
    glm::dvec3 low_m, high_m;
    std::uint32_t first = 0;  // leaf: the tile; inner: the left child, the right one after it
    bool is_leaf = false;
  };
  void sort(const TileView& view, std::vector<std::uint32_t>& tiles) const;

  std::vector<Node> nodes_;
  std::vector<glm::dvec3> cells_;  // of every tile, in kTileSize_m
};

}  // namespace roadgen
