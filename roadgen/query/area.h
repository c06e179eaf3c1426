// A junction's area as a query sees it: whether it holds a point, and how the ground runs there. A part of RoadIndex
// (road_index.h).
#pragma once

#include <cstdint>
#include <vector>

#include "roadgen/road/junction.h"

namespace roadgen {

class Area {
 public:
  // Requires: problems(junction) is empty.
  explicit Area(const Junction& junction);

  // is_inside(surface(), point_m); away from the boundary by a table.
  bool holds(glm::dvec2 point_m) const {
    const double x = (point_m.x - low_m_.x) * cells_per_m_, y = (point_m.y - low_m_.y) * cells_per_m_;
    if (!(x >= 0 && y >= 0 && x < kCells && y < kCells)) return false;
    const Cell cell = cells_[static_cast<std::size_t>(y) * kCells + static_cast<std::size_t>(x)];
    return cell == Cell::kBoundary ? is_inside(surface_, point_m) : cell == Cell::kInside;
  }
  // height_at(surface(), point_m); where all pieces are level that is one height.
  JunctionPoint ground_at(glm::dvec2 point_m) const {
    return level_ ? JunctionPoint{height_m_, {0, 0}} : height_at(surface_, point_m);
  }
  double height_m(glm::dvec2 point_m) const { return level_ ? height_m_ : height_m_at(surface_, point_m); }
  const JunctionSurface& surface() const { return surface_; }

 private:
  static constexpr int kCells = 48;  // along each side
  enum class Cell : std::uint8_t { kOutside, kInside, kBoundary };

  void set_cells();

  JunctionSurface surface_;
  bool level_ = false;
  double height_m_ = 0;
  glm::dvec2 low_m_{0, 0};
  double cells_per_m_ = 0;
  std::vector<Cell> cells_;
};

}  // namespace roadgen
