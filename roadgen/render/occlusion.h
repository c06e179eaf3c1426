// Internal, not installed: which of many small spheres can be seen at all, found on the CPU before anything is drawn.
//
// The picture is cut into cells of kCell_px pixels. A cell that one sphere covers as a whole remembers how far away the
// front of that sphere is at most; a sphere that is farther than that in all the cells that it touches is hidden. Spheres
// come near ones first, group by group. Conservative: what is seen anywhere is never left out.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/camera.h"

namespace roadgen {

class Occlusion {
 public:
  static constexpr int kCell_px = 1;
  // Spheres and groups that touch more cells than this count as seen.
  static constexpr int kMostCells = 4096;

  // Begins a frame. Requires: a camera that check_camera passes. Cost: O(cells).
  void begin(const Camera& camera, int width, int height);
  // Whether a ball may be seen, for the balls that were added before. Center: in the axes of the view (right, up,
  // forward), from the eye. Cost: O(cells that it touches).
  bool may_see(glm::vec3 center, float radius) const;
  // Appends the indices of the spheres (centre from `origin`, radius) that may be seen, first + i, and hides what is
  // behind them from later ones. view: rows right, up, forward times a position; origin: in those axes, from the eye.
  void add(const glm::vec4* spheres, std::uint32_t first, std::uint32_t count, const glm::mat3& view, glm::vec3 origin,
           std::vector<std::uint32_t>& seen);

 private:
  // Of a ball on the screen: centre and half extents, in cells; depths of its front and
  // back. The others mean nothing where front <= near_m_.
  struct Image {
    float x, y, dx, dy, front, back;
  };
  struct Rect {
    int x0, x1, y0, y1;  // cells, inclusive; empty where x0 > x1
    bool whole;          // within the picture, or nothing to say: count as seen
  };
  Image image(glm::vec3 center, float radius) const;
  Rect rect(const Image& i) const;
  bool hidden(const Rect& r, float nearest) const;
  void cover(glm::vec3 center, float radius, const Image& i, const Rect& box);

  int columns_ = 0, rows_ = 0;
  float half_width_ = 0, half_height_ = 0, scale_ = 0;  // cells; cells a unit at distance 1
  float near_m_ = 0;
  std::vector<float> depth_m_;  // of each cell: nothing farther than this is seen
};

}  // namespace roadgen
