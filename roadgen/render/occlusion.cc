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
Occlusion::Image Occlusion::image(glm::vec3 c, float r) const {
  const float front = c.z - r, inverse = 1 / c.z, part = r * inverse / front * scale_;
  return {half_width_ + c.x * inverse * scale_,
          half_height_ + c.y * inverse * scale_,
          part * std::sqrt(c.z * c.z + c.x * c.x) + kRoom_cells,
          part * std::sqrt(c.z * c.z + c.y * c.y) + kRoom_cells,
          front,
          c.z + r};
}

Occlusion::Rect Occlusion::rect(const Image& i) const {
  if (i.back < near_m_) return {1, 0, 1, 0, true};
  if (!(i.front > near_m_)) return {0, 0, 0, 0, false};
  const auto cell = [](float at, int count) {
    return static_cast<int>(std::clamp(at, 0.0f, static_cast<float>(count - 1)));
  };
  Rect box = {cell(i.x - i.dx, columns_), cell(i.x + i.dx, columns_), cell(i.y - i.dy, rows_), cell(i.y + i.dy, rows_),
              true};
  if (i.x + i.dx < 0 || i.y + i.dy < 0 || i.x - i.dx > 2 * half_width_ || i.y - i.dy > 2 * half_height_) {
    box.x0 = 1, box.x1 = 0;
  }
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
void Occlusion::cover(glm::vec3 c, float r, const Image& i, const Rect& box) {
  const float d2 = glm::dot(c, c), part = r * r / d2;
  const float inside = std::sqrt(part) * scale_ - kRoom_cells;
  // No cell fits into it.
  if (inside < 0.71f) return;
  const float tilt2 = std::max(0.0f, 1 - c.z * c.z / d2);
  const float farthest = (c.z * (1 - part) + r * std::sqrt((1 - part) * tilt2)) * (1 + kRoom);
  const float x = i.x, y = i.y;
  for (int row = box.y0; row <= box.y1; ++row) {
    const float dy = std::max(std::abs(static_cast<float>(row) - y), std::abs(static_cast<float>(row + 1) - y));
    const float room2 = inside * inside - dy * dy;
    if (room2 <= 0.25f) continue;
    const float dx = std::sqrt(room2);
    const int from = std::max(box.x0, static_cast<int>(std::ceil(x - dx)));
    const int to = std::min(box.x1, static_cast<int>(std::floor(x + dx)) - 1);
    float* cells = &depth_m_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_)];
    for (int at = from; at <= to; ++at) cells[at] = std::min(cells[at], farthest);
  }
}

bool Occlusion::may_see(glm::vec3 center, float radius) const {
  const Image at = image(center, radius);
  const Rect box = rect(at);
  return !box.whole || (box.x0 <= box.x1 && !hidden(box, at.front * (1 - kRoom)));
}

void Occlusion::add(const glm::vec4* spheres, std::uint32_t first, std::uint32_t count, const glm::mat3& view,
                    glm::vec3 origin, std::vector<std::uint32_t>& seen) {
  // In two steps, so that the first is computed several spheres at a time.
  constexpr std::uint32_t kTogether = 64;
  glm::vec3 centers[kTogether];
  Image images[kTogether];
  for (std::uint32_t begin = 0; begin < count; begin += kTogether) {
    const std::uint32_t n = std::min(kTogether, count - begin);
    const glm::vec4* const some = spheres + first + begin;
    for (std::uint32_t i = 0; i < n; ++i) {
      centers[i] = origin + view * glm::vec3(some[i]);
      images[i] = image(centers[i], some[i].w);
    }
    for (std::uint32_t i = 0; i < n; ++i) {
      const Rect box = rect(images[i]);
      if (box.whole && (box.x0 > box.x1 || hidden(box, images[i].front * (1 - kRoom)))) continue;
      seen.push_back(first + begin + i);
      if (box.whole) cover(centers[i], some[i].w, images[i], box);
    }
  }
}

}  // namespace roadgen
