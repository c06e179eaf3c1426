// A regular grid of heights over the plane, its smooth interpolation, and the filling of holes from around them.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

namespace roadgen {

// Heights at origin + step * (column, row). Requires: columns, rows >= 1, step > 0, values.size() == columns * rows.
struct Grid {
  glm::dvec2 origin_m{0, 0};
  glm::dvec2 step_m{1, 1};
  int columns = 0, rows = 0;
  std::vector<float> values;  // row by row, from the origin

  float& at(int column, int row) { return values[static_cast<std::size_t>(row) * columns + column]; }
  float at(int column, int row) const { return values[static_cast<std::size_t>(row) * columns + column]; }
};

// Interpolated height. Outside the grid that of the nearest place of its border. Cost: O(1), no allocation.
// Bilinear is continuous; bicubic (Catmull-Rom: passes through every post, and is exact for quadratic ground) is C1.
double sample_bilinear(const Grid& grid, glm::dvec2 point_m);
double sample_bicubic(const Grid& grid, glm::dvec2 point_m);

// Gives every post with known[i] == 0 the height of a membrane stretched between the known posts: continuous, without
// new extremes. Returns the number of posts filled. Requires: known.size() == values.size().
// Errors: with nothing known the values stay and 0 is returned. Cost: O(posts).
// Source: the pull-push pyramid of Gortler et al. 1996, then relaxation of Laplace's equation on every level.
std::size_t fill_holes(Grid& grid, const std::vector<std::uint8_t>& known);

}  // namespace roadgen
