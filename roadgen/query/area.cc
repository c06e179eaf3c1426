#include "roadgen/query/area.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace roadgen {
namespace {

bool is_level(const Lib::JunctionCut& c) {
  return c.grade == 0 && c.tilt == 0 && c.fall_left == 0 && c.fall_right == 0;
}

bool is_level(const Lib::JunctionCorner& c) {
  return c.z1 == 0 && c.z2 == 0 && c.z3 == 0 && c.along0 == 0 && c.across0 == 0 && c.along1 == 0 && c.across1 == 0 &&
         c.fall0 == 0 && c.fall1 == 0;
}

}  // namespace

Area::Area(const Junction& junction) : surface_(junction_surface(junction)) {
  const double z = surface_.cuts.front().z;
  level_ = std::all_of(surface_.cuts.begin(), surface_.cuts.end(),
                       [&](const Lib::JunctionCut& c) { return is_level(c) && c.z == z; }) &&
           std::all_of(surface_.corners.begin(), surface_.corners.end(),
                       [&](const Lib::JunctionCorner& c) { return is_level(c) && c.z0 == z; });
  height_m_ = surface_.center_m.z + z;
  set_cells();
}

// Cells that a piece's box touches are the boundary's; all of another cell is where its middle is.
void Area::set_cells() {
  const glm::dvec2 center(surface_.center_m), size(surface_.high_m - surface_.low_m);
  // Half a cell wider than the bounds on every side.
  cells_per_m_ = (kCells - 1) / std::max(size.x, size.y);
  low_m_ = center + 0.5 * glm::dvec2(surface_.low_m + surface_.high_m) - 0.5 * kCells / cells_per_m_;
  cells_.assign(static_cast<std::size_t>(kCells) * kCells, Cell::kOutside);
  const auto at = [&](int x, int y) -> Cell& { return cells_[static_cast<std::size_t>(y) * kCells + x]; };
  const auto mark = [&](glm::dvec2 a, glm::dvec2 b, double margin_m) {
    const glm::dvec2 low = (center + glm::min(a, b) - margin_m - low_m_) * cells_per_m_;
    const glm::dvec2 high = (center + glm::max(a, b) + margin_m - low_m_) * cells_per_m_;
    for (int y = std::max(static_cast<int>(low.y), 0); y <= std::min(static_cast<int>(high.y), kCells - 1); ++y) {
      for (int x = std::max(static_cast<int>(low.x), 0); x <= std::min(static_cast<int>(high.x), kCells - 1); ++x) {
        at(x, y) = Cell::kBoundary;
      }
    }
  };
  constexpr double kMargin_m = 1e-6;
  for (const Lib::JunctionCut& c : surface_.cuts) mark({c.x0, c.y0}, {c.x1, c.y1}, kMargin_m);
  for (const Lib::JunctionCorner& c : surface_.corners) {
    // In parts along the chord; the curve is off it by at most 4/27 (|a| + |b|).
    const double off = c.chord * 4 / 27 * (std::abs(c.a) + std::abs(c.b)) + kMargin_m;
    constexpr int kParts = 8;
    const glm::dvec2 start(c.x0, c.y0), chord = c.chord * glm::dvec2(c.cx, c.cy);
    for (int i = 0; i < kParts; ++i) {
      mark(start + chord * (static_cast<double>(i) / kParts), start + chord * ((i + 1.0) / kParts), off);
    }
  }
  for (int y = 0; y < kCells; ++y) {
    for (int x = 0; x < kCells; ++x) {
      const glm::dvec2 middle = low_m_ + glm::dvec2(x + 0.5, y + 0.5) / cells_per_m_;
      if (at(x, y) != Cell::kBoundary && is_inside(surface_, middle)) at(x, y) = Cell::kInside;
    }
  }
}

}  // namespace roadgen
