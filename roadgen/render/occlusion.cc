#include "roadgen/render/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

// For what single precision may be off: pixels, parts of a distance, and of the numbers that a place is the sum of.
constexpr float kRoom_px = 0.02f, kRoom = 1e-5f, kPlace = 5e-7f;

// std::ceil and std::floor of numbers from -1 to 1e9, which older processors have no instruction for.
int up(float x) {
  const int i = static_cast<int>(x);
  return i + (static_cast<float>(i) < x ? 1 : 0);
}
int down(float x) {
  const int i = static_cast<int>(x);
  return i - (static_cast<float>(i) > x ? 1 : 0);
}

}  // namespace

void Occlusion::begin(const Camera& camera, int width, int height, float reach_px) {
  columns_ = width;
  rows_ = height;
  half_width_ = 0.5f * static_cast<float>(width);
  half_height_ = 0.5f * static_cast<float>(height);
  scale_ = static_cast<float>(height / (2 * std::tan(camera.fov_deg * std::numbers::pi / 360)));
  near_m_ = static_cast<float>(camera.near_m);
  reach_ = reach_px;
  depth_m_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_),
                  std::numeric_limits<float>::infinity());
  tile_columns_ = (width + kTile_px - 1) / kTile_px;
  seen_.clear();
}

// A point of the ball is (c + r a) / (c.z - r b), across and up, with a^2 + b^2 <= 1: it is off c / c.z by
// r (c.z a + c b) / (c.z (c.z - r b)), at most by r |c| / (c.z (c.z - r)).
//
// A direction within the angle asin(r / d) of the centre's meets the sphere, and angles are at most distances in the plane
// at depth 1: the circle of radius r / d around the centre's image is covered. The sphere's front is at most as far along
// the view axis as the farthest place of the circle in which it is touched.
Occlusion::Image Occlusion::image(glm::vec3 c, float r, float slack) const {
  const float aside2 = c.x * c.x + c.y * c.y, d = std::sqrt(aside2 + c.z * c.z);
  const float inverse = scale_ / c.z, sine = r / d;
  Image i;
  i.x = half_width_ + c.x * inverse - 0.5f;
  i.y = half_height_ + c.y * inverse - 0.5f;
  i.front = (c.z - r) * (1 - kRoom) - slack;
  i.back = c.z + r + slack;
  i.outside = (r + slack) * d * inverse / i.front + kRoom_px;
  i.inside = (sine - 2 * slack / d) * scale_ - kRoom_px;
  i.farthest = (c.z * (1 - sine * sine) + sine * std::sqrt(aside2)) * (1 + kRoom) + slack;
  return i;
}

Occlusion::Rect Occlusion::rect(const Image& i) const {
  const Rect none = {1, 0, 1, 0, true};
  if (i.back < near_m_) return none;
  if (!(i.front > near_m_)) return {0, columns_ - 1, 0, rows_ - 1, false};
  const float reach = i.outside + reach_;
  if (!(i.x + reach >= 0 && i.y + reach >= 0 && i.x - reach <= static_cast<float>(columns_ - 1) &&
        i.y - reach <= static_cast<float>(rows_ - 1))) {
    return none;
  }
  Rect box = {up(std::max(i.x - reach, 0.0f)), down(std::min(i.x + reach, static_cast<float>(columns_ - 1))),
              up(std::max(i.y - reach, 0.0f)), down(std::min(i.y + reach, static_cast<float>(rows_ - 1))), true};
  if (box.x0 > box.x1 || box.y0 > box.y1) return none;
  if ((box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1) > kMostPixels) box.whole = false;
  return box;
}

bool Occlusion::hidden(const Image& i, const Rect& r) const {
  const auto columns = static_cast<std::size_t>(columns_);
  // Most that are seen are seen in the middle.
  if (depth_m_[static_cast<std::size_t>((r.y0 + r.y1) / 2) * columns + static_cast<std::size_t>((r.x0 + r.x1) / 2)] >
      i.front) {
    return false;
  }
  const float outside = i.outside + reach_;
  for (int y = r.y0; y <= r.y1; ++y) {
    const float dy = std::max(0.0f, std::abs(static_cast<float>(y) - i.y) - reach_);
    const float dx = std::sqrt(std::max(0.0f, outside * outside - dy * dy));
    const int from = std::max(r.x0, up(std::max(i.x - dx, 0.0f)));
    const int to = std::min(r.x1, down(std::max(i.x + dx, -1.0f)));
    const float* row = &depth_m_[static_cast<std::size_t>(y) * columns];
    int open = 0;
    for (int x = from; x <= to; ++x) open += row[x] > i.front ? 1 : 0;
    if (open > 0) return false;
  }
  return true;
}

void Occlusion::cover(const Image& i, const Rect& box) {
  for (int y = box.y0; y <= box.y1; ++y) {
    const float dy = std::abs(static_cast<float>(y) - i.y) + reach_;
    const float room2 = i.inside * i.inside - dy * dy;
    if (i.inside <= 0 || room2 <= 0) continue;
    const float dx = std::sqrt(room2) - reach_;
    const int from = std::max(box.x0, up(std::max(i.x - dx, 0.0f)));
    const int to = std::min(box.x1, down(std::max(i.x + dx, -1.0f)));
    float* row = &depth_m_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_)];
    for (int x = from; x <= to; ++x) row[x] = std::min(row[x], i.farthest);
  }
}

bool Occlusion::may_see(glm::vec3 center, float radius) const {
  const Image at = image(center, radius, kPlace * glm::length(center));
  const Rect box = rect(at);
  return !box.whole || (box.x0 <= box.x1 && !hidden(at, box));
}

void Occlusion::add(std::span<const glm::vec4> spheres, std::uint32_t first, const glm::mat3& view, glm::vec3 origin,
                    float extent) {
  const float slack = kPlace * (glm::length(origin) + extent);
  // In two steps, so that the first is computed several spheres at a time.
  constexpr std::size_t kTogether = 64;
  Image images[kTogether];
  bool near[kTogether];
  for (std::size_t begin = 0; begin < spheres.size(); begin += kTogether) {
    const std::size_t n = std::min(kTogether, spheres.size() - begin);
    for (std::size_t i = 0; i < n; ++i) {
      const glm::vec4& sphere = spheres[begin + i];
      const glm::vec3 center = origin + view * glm::vec3(sphere);
      images[i] = image(center, sphere.w, slack);
      near[i] = glm::length(center) <= 3 * sphere.w + slack || center.z <= 1.001f * (sphere.w + near_m_) + slack;
    }
    for (std::size_t i = 0; i < n; ++i) {
      const Rect box = rect(images[i]);
      if (box.whole && (box.x0 > box.x1 || hidden(images[i], box))) continue;
      seen_.push_back({first + static_cast<std::uint32_t>(begin + i), near[i], images[i]});
      if (box.whole) cover(images[i], box);
    }
  }
}

void Occlusion::touch(const Rect& r) {
  for (int y = r.y0 / kTile_px; y <= r.y1 / kTile_px; ++y) {
    std::uint8_t* row = &tiles_[static_cast<std::size_t>(y) * static_cast<std::size_t>(tile_columns_)];
    std::fill(row + r.x0 / kTile_px, row + r.x1 / kTile_px + 1, std::uint8_t{1});
  }
}

std::span<const Occlusion::Seen> Occlusion::finish() {
  tiles_.assign(static_cast<std::size_t>(tile_columns_) * static_cast<std::size_t>((rows_ + kTile_px - 1) / kTile_px),
                0);
  left_.clear();
  for (const Seen& sphere : seen_) {
    const Rect box = rect(sphere.image);
    // What it covers itself is farther than its front.
    if (box.whole && hidden(sphere.image, box)) continue;
    touch(box);
    left_.push_back(sphere);
  }
  seen_.clear();
  return left_;
}

std::vector<Occlusion::Run> Occlusion::touched() const {
  std::vector<Run> runs;
  for (std::size_t at = 0; at < tiles_.size(); ++at) {
    if (!tiles_[at]) continue;
    const auto x = static_cast<std::uint16_t>(at % static_cast<std::size_t>(tile_columns_));
    const auto y = static_cast<std::uint16_t>(at / static_cast<std::size_t>(tile_columns_));
    if (!runs.empty() && runs.back().y == y && runs.back().x_to + 1 == x) {
      ++runs.back().x_to;
    } else {
      runs.push_back({x, x, y});
    }
  }
  return runs;
}

std::vector<Occlusion::Run> Occlusion::all_tiles(int width, int height) {
  std::vector<Run> runs;
  for (int y = 0; y * kTile_px < height; ++y) {
    runs.push_back({0, static_cast<std::uint16_t>((width - 1) / kTile_px), static_cast<std::uint16_t>(y)});
  }
  return runs;
}

}  // namespace roadgen
