// Internal, not installed: which of many small spheres can be seen at all, found on the CPU before anything is drawn.
//
// A pixel knows how far away, at most, the nearest surface is that covers all its samples; a sphere that is farther than
// that in all pixels whose samples it may cover is hidden. Spheres come near ones first, group by group; what later ones
// of a group hide is found at the end. Conservative: what is seen anywhere is never left out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/camera.h"

namespace roadgen {

class Occlusion {
 public:
  // Spheres and groups that touch more pixels than this count as seen.
  static constexpr int kMostPixels = 4096;
  // Sides of the tiles that touched() tells of, pixels.
  static constexpr int kTile_px = 8;

  // Of a ball on the screen, in pixels from the middle of the first one: its centre's image, radii of circles around that
  // which it lies within and which it covers; depths of its front and back, and the greatest at which it is touched from
  // the eye. All but the depths mean nothing where front <= the near plane.
  struct Image {
    float x, y, outside, inside, front, back, farthest;
  };
  // Pixels, inclusive, that it may touch; none where x0 > x1 or y0 > y1.
  struct Rect {
    int x0, x1, y0, y1;
    int count;  // more than kMostPixels also where the near plane cuts it
    bool countless() const { return count > kMostPixels; }
    bool empty() const { return x0 > x1 || y0 > y1; }
  };
  struct Seen {
    std::uint32_t index;
    bool near;  // as shaders/spheres.glsl has it, or about to be
    Image image;
    Rect rect;
  };
  // Tiles from x_from to x_to, inclusive, of a row.
  struct Run {
    std::uint16_t x_from, x_to, y, none = 0;
  };

  // Begins a frame. reach_px: how far from the pixel's centre its samples lie at most, across or up: 0 where the centre is
  // the only one. Requires: a camera that check_camera passes. Cost: O(pixels).
  void begin(const Camera& camera, int width, int height, float reach_px);
  // Whether a ball may be seen, for the balls that were added before. Center: in the axes of the view (right, up,
  // forward), from the eye. Cost: O(pixels that it touches).
  bool may_see(glm::vec3 center, float radius) const;
  // Adds the spheres (centre from `origin`, radius) that may be seen, first + i, and hides what is behind them from later
  // ones. view: rows right, up, forward times a position; origin: in those axes, from the eye; extent: no centre
  // is farther from the origin.
  void add(std::span<const glm::vec4> spheres, std::uint32_t first, const glm::mat3& view, glm::vec3 origin,
           float extent);
  // Those that may be seen of what was added since the last call, in its order, and the tiles that they touch.
  // Valid until the next call of add or finish.
  std::span<const Seen> finish();
  std::vector<Run> touched() const;
  // Whether a circle around it, so many times as large as what it lies within, is in the picture.
  bool within(const Image& i, float times) const {
    const float reach = times * i.outside;
    return i.x - reach > -0.5f && i.y - reach > -0.5f && i.x + reach < 2 * half_width_ - 0.5f &&
           i.y + reach < 2 * half_height_ - 0.5f;
  }
  static std::vector<Run> all_tiles(int width, int height);

 private:
  // slack: what the centre may be off by.
  Image image(glm::vec3 center, float radius, float slack) const;
  Rect rect(const Image& i) const;
  // Whether all samples that it may cover have something nearer.
  bool hidden(const Image& i, const Rect& r) const;
  void cover(const Image& i, const Rect& box);
  void touch(const Rect& r);
  // What image and rect say of no more than kTogether spheres, each number in an array.
  static constexpr std::size_t kTogether = 64;
  struct Together;
  void find(std::span<const glm::vec4> spheres, const glm::mat3& view, glm::vec3 origin, float slack,
            Together& found) const;

  int columns_ = 0, rows_ = 0, tile_columns_ = 0;
  float half_width_ = 0, half_height_ = 0, scale_ = 0;  // pixels; pixels a unit at distance 1
  float near_m_ = 0, reach_ = 0;
  std::vector<float> depth_m_;  // of each pixel: nothing farther than this is seen
  std::vector<std::uint8_t> tiles_;
  std::vector<Seen> seen_, left_;
};

}  // namespace roadgen
