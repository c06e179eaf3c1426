#include "roadgen/render/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

// For what single precision may be off: parts of a cell, and of a distance.
constexpr float kRoom_cells = 0.02f, kRoom = 1e-5f;

}  // namespace

void Occlusion::begin(const Camera& camera, int width, int height) {
  columns_ = (width + kCell_px - 1) / kCell_px;
  rows_ = (height + kCell_px - 1) / kCell_px;
  half_width_ = 0.5f * static_cast<float>(width) / kCell_px;
  half_height_ = 0.5f * static_cast<float>(height) / kCell_px;
  scale_ = static_cast<float>(height / (2 * std::tan(camera.fov_deg * std::numbers::pi / 360) * kCell_px));
  near_m_ = static_cast<float>(camera.near_m);
  depth_m_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                  std::numeric_limits<float>::infinity());
}

// A point of the ball is (c.x + r a) / (c.z - r b) with a^2 + b^2 <= 1, so it is within r sqrt(c.z^2 + c.x^2) /
// (c.z (c.z - r)) of c.x / c.z.
Occlusion::Rect Occlusion::rect(glm::vec3 c, float r) const {
  const float front = c.z - r;
  if (!(front > near_m_)) return {0, 0, 0, 0, false};
  const float inverse = 1 / c.z, part = r * inverse / front;
  const float x = half_width_ + c.x * inverse * scale_, y = half_height_ + c.y * inverse * scale_;
  const float dx = part * std::sqrt(c.z * c.z + c.x * c.x) * scale_ + kRoom_cells;
  const float dy = part * std::sqrt(c.z * c.z + c.y * c.y) * scale_ + kRoom_cells;
  const auto cell = [](float at, int count) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(count - 1)));
  };
  Rect box = {cell(x - dx, columns_), cell(x + dx, columns_), cell(y - dy, rows_), cell(y + dy, rows_), true};
  if (x + dx < 0 || y + dy < 0 || x - dx > 2 * half_width_ || y - dy > 2 * half_height_) box.x0 = 1, box.x1 = 0;
  if ((box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1) > kMostCells) box.whole = false;
  return box;
}

bool Occlusion::hidden(const Rect& r, float nearest) const {
  for (int y = r.y0; y <= r.y1; ++y) {
    const float* row = &depth_m_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_)];
    for (int x = r.x0; x <= r.x1; ++x) {
      if (row[x] > nearest) return false;
    }
  }
  return true;
}

// A direction within the angle asin(r / d) of the centre's meets the sphere, and angles are at most distances in the plane
// at depth 1: the circle of radius r / d around the centre's image is covered. The sphere's front is at most as far along
// the view axis as the farthest place of the circle in which it is touched.
void Occlusion::cover(glm::vec3 c, float r, const Rect& box) {
  const float d2 = glm::dot(c, c), d = std::sqrt(d2);
  const float inside = r / d * scale_ - kRoom_cells;
  // No cell fits into it.
  if (inside < 0.71f) return;
  const float tilt2 = std::max(0.0f, 1 - c.z * c.z / d2), part = r * r / d2;
  const float farthest = (c.z * (1 - part) + r * std::sqrt(std::max(0.0f, (1 - part) * tilt2))) * (1 + kRoom);
  const float x = half_width_ + c.x / c.z * scale_, y = half_height_ + c.y / c.z * scale_;
  for (int row = box.y0; row <= box.y1; ++row) {
    const float dy = std::max(std::abs(static_cast<float>(row) - y), std::abs(static_cast<float>(row + 1) - y));
    const float room2 = inside * inside - dy * dy;
    if (room2 <= 0.25f) continue;
    const float dx = std::sqrt(room2);
    const int from = std::max(box.x0, static_cast<int>(std::ceil(x - dx)));
    const int to = std::min(box.x1, static_cast<int>(std::floor(x + dx)) - 1);
    float* cells = &depth_m_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_)];
    for (int i = from; i <= to; ++i) cells[i] = std::min(cells[i], farthest);
  }
}

bool Occlusion::may_see(glm::vec3 center, float radius) const {
  const Rect box = rect(center, radius);
  return !box.whole || (box.x0 <= box.x1 && !hidden(box, (center.z - radius) * (1 - kRoom)));
}

void Occlusion::add(const glm::vec4* spheres, std::uint32_t first, std::uint32_t count, const glm::mat3& view,
                    glm::vec3 origin, std::vector<std::uint32_t>& seen) {
  for (std::uint32_t i = 0; i < count; ++i) {
    const glm::vec4& sphere = spheres[first + i];
    const glm::vec3 center = origin + view * glm::vec3(sphere);
    const Rect box = rect(center, sphere.w);
    if (box.whole && (box.x0 > box.x1 || hidden(box, (center.z - sphere.w) * (1 - kRoom)))) continue;
    seen.push_back(first + i);
    if (box.whole) cover(center, sphere.w, box);
  }
}

}  // namespace roadgen
