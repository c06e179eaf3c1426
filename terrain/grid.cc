#include "terrain/grid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace roadgen {
namespace {

constexpr int kRelaxations = 16;

struct Place {
  int cell;
  double fraction;
};

// The cell and the place in it along one axis, clamped to the grid.
Place place(double x, int posts) {
  x = std::clamp(x, 0.0, static_cast<double>(posts - 1));
  const int cell = std::min(static_cast<int>(x), std::max(posts - 2, 0));
  return {cell, x - cell};
}

// Catmull-Rom weights of the posts -1, 0, 1, 2.
void catmull_rom(double t, double (&w)[4]) {
  w[0] = t * (-0.5 + t * (1 - 0.5 * t));
  w[1] = 1 + t * t * (-2.5 + 1.5 * t);
  w[2] = t * (0.5 + t * (2 - 1.5 * t));
  w[3] = t * t * (-0.5 + 0.5 * t);
}

// Half the resolution: the mean of what is known of each 2 x 2 block.
void pull(const Grid& fine, const std::vector<std::uint8_t>& known, Grid& coarse, std::vector<std::uint8_t>& some) {
  coarse.columns = (fine.columns + 1) / 2;
  coarse.rows = (fine.rows + 1) / 2;
  coarse.values.assign(static_cast<std::size_t>(coarse.columns) * coarse.rows, 0);
  some.assign(coarse.values.size(), 0);
  for (int row = 0; row < coarse.rows; ++row) {
    for (int column = 0; column < coarse.columns; ++column) {
      double sum = 0;
      int count = 0;
      for (int y = 2 * row; y < std::min(2 * row + 2, fine.rows); ++y) {
        for (int x = 2 * column; x < std::min(2 * column + 2, fine.columns); ++x) {
          if (!known[static_cast<std::size_t>(y) * fine.columns + x]) continue;
          sum += fine.at(x, y);
          ++count;
        }
      }
      if (count == 0) continue;
      coarse.at(column, row) = static_cast<float>(sum / count);
      some[static_cast<std::size_t>(row) * coarse.columns + column] = 1;
    }
  }
}

// Gauss-Seidel on the unknown posts, with free borders.
void relax(Grid& grid, const std::vector<std::size_t>& unknown) {
  const auto columns = static_cast<std::size_t>(grid.columns);
  for (int pass = 0; pass < kRelaxations; ++pass) {
    for (const std::size_t i : unknown) {
      const std::size_t x = i % columns, y = i / columns;
      double sum = 0;
      int count = 0;
      if (x > 0) sum += grid.values[i - 1], ++count;
      if (x + 1 < columns) sum += grid.values[i + 1], ++count;
      if (y > 0) sum += grid.values[i - columns], ++count;
      if (y + 1 < static_cast<std::size_t>(grid.rows)) sum += grid.values[i + columns], ++count;
      if (count > 0) grid.values[i] = static_cast<float>(sum / count);
    }
  }
}

}  // namespace

double sample_bilinear(const Grid& grid, glm::dvec2 point_m) {
  const Place x = place((point_m.x - grid.origin_m.x) / grid.step_m.x, grid.columns);
  const Place y = place((point_m.y - grid.origin_m.y) / grid.step_m.y, grid.rows);
  const int x1 = std::min(x.cell + 1, grid.columns - 1), y1 = std::min(y.cell + 1, grid.rows - 1);
  const double low = grid.at(x.cell, y.cell) * (1 - x.fraction) + grid.at(x1, y.cell) * x.fraction;
  const double high = grid.at(x.cell, y1) * (1 - x.fraction) + grid.at(x1, y1) * x.fraction;
  return low * (1 - y.fraction) + high * y.fraction;
}

double sample_bicubic(const Grid& grid, glm::dvec2 point_m) {
  const Place x = place((point_m.x - grid.origin_m.x) / grid.step_m.x, grid.columns);
  const Place y = place((point_m.y - grid.origin_m.y) / grid.step_m.y, grid.rows);
  double wx[4], wy[4];
  catmull_rom(x.fraction, wx);
  catmull_rom(y.fraction, wy);
  double height = 0;
  for (int j = 0; j < 4; ++j) {
    const int row = std::clamp(y.cell + j - 1, 0, grid.rows - 1);
    double line = 0;
    for (int i = 0; i < 4; ++i) line += wx[i] * grid.at(std::clamp(x.cell + i - 1, 0, grid.columns - 1), row);
    height += wy[j] * line;
  }
  return height;
}

std::size_t fill_holes(Grid& grid, const std::vector<std::uint8_t>& known) {
  assert(known.size() == grid.values.size());
  std::vector<std::size_t> unknown;
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (!known[i]) unknown.push_back(i);
  }
  if (unknown.empty() || unknown.size() == known.size()) return 0;
  Grid coarse;
  std::vector<std::uint8_t> some;
  pull(grid, known, coarse, some);
  fill_holes(coarse, some);
  // Post (x, y) lies at (x/2 - 1/4, y/2 - 1/4) of the coarse grid, whose posts are the middles of the blocks.
  coarse.origin_m = {0.5, 0.5};
  coarse.step_m = {2, 2};
  const auto columns = static_cast<std::size_t>(grid.columns);
  for (const std::size_t i : unknown) {
    grid.values[i] = static_cast<float>(
        sample_bilinear(coarse, {static_cast<double>(i % columns), static_cast<double>(i / columns)}));
  }
  relax(grid, unknown);
  return unknown.size();
}

}  // namespace roadgen
