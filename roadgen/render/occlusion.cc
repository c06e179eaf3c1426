#include "roadgen/render/occlusion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>

namespace roadgen {
namespace {

// For what single precision may be off: pixels, parts of a distance, and of the numbers that a place is the sum of.
constexpr float kRoom_px = 0.02f, kRoom = 1e-5f, kPlace = 5e-7f;

// Within [low, high]; low where x is not a number.
float clamped(float x, float low, float high) {
  x = x > low ? x : low;
  return x < high ? x : high;
}

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
[[gnu::always_inline]] inline Occlusion::Image Occlusion::image(glm::vec3 c, float r, float slack) const {
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

// Without branches, so that it can be computed for several at a time.
[[gnu::always_inline]] inline Occlusion::Rect Occlusion::rect(const Image& i) const {
  const float reach = i.outside + reach_;
  const auto columns = static_cast<float>(columns_), rows = static_cast<float>(rows_);
  Rect box;
  box.x0 = up(clamped(i.x - reach, 0, columns));
  box.x1 = down(clamped(i.x + reach, -1, columns - 1));
  box.y0 = up(clamped(i.y - reach, 0, rows));
  box.y1 = down(clamped(i.y + reach, -1, rows - 1));
  // The near plane cuts it, or it is behind that.
  const bool cut = !(i.front > near_m_), behind = i.back < near_m_;
  box.x0 = cut ? 0 : box.x0;
  box.x1 = cut ? columns_ - 1 : box.x1;
  box.y0 = cut ? 0 : box.y0;
  box.y1 = behind ? -1 : cut ? rows_ - 1 : box.y1;
  const int count = (box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1);
  box.count = cut ? kMostPixels + 1 : count;
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
    const float room2 = outside * outside - dy * dy;
    const float* row = &depth_m_[static_cast<std::size_t>(y) * columns];
    int open = 0;
    for (int x = r.x0; x <= r.x1; ++x) {
      const float dx = static_cast<float>(x) - i.x;
      open |= static_cast<int>(dx * dx <= room2) & static_cast<int>(row[x] > i.front);
    }
    if (open != 0) return false;
  }
  return true;
}

void Occlusion::cover(const Image& i, const Rect& box) {
  if (i.inside <= 0) return;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const float farthest = i.farthest, middle = i.x, reach = reach_;
  for (int y = box.y0; y <= box.y1; ++y) {
    const float dy = std::abs(static_cast<float>(y) - i.y) + reach_;
    const float room2 = i.inside * i.inside - dy * dy;
    float* row = &depth_m_[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_)];
    for (int x = box.x0; x <= box.x1; ++x) {
      const float dx = std::abs(static_cast<float>(x) - middle) + reach;
      const float most = dx * dx <= room2 ? farthest : kFar;
      row[x] = row[x] < most ? row[x] : most;
    }
  }
}

bool Occlusion::may_see(glm::vec3 center, float radius) const {
  const Image at = image(center, radius, kPlace * glm::length(center));
  const Rect box = rect(at);
  return !box.empty() && (box.countless() || !hidden(at, box));
}

struct Occlusion::Together {
  float x[kTogether], y[kTogether], outside[kTogether], inside[kTogether], front[kTogether], back[kTogether],
      farthest[kTogether];
  int x0[kTogether], x1[kTogether], y0[kTogether], y1[kTogether], count[kTogether], near[kTogether];

  Seen at(std::size_t i, std::uint32_t index) const {
    return {index,
            near[i] != 0,
            {x[i], y[i], outside[i], inside[i], front[i], back[i], farthest[i]},
            {x0[i], x1[i], y0[i], y1[i], count[i]}};
  }
};

void Occlusion::find(std::span<const glm::vec4> spheres, const glm::mat3& view, glm::vec3 origin, float slack,
                     Together& found) const {
  // As plain numbers, which compilers see through.
  const float* numbers = glm::value_ptr(spheres[0]);
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    const float radius = numbers[4 * k + 3];
    const glm::vec3 center = origin + view * glm::vec3(numbers[4 * k], numbers[4 * k + 1], numbers[4 * k + 2]);
    const Image i = image(center, radius, slack);
    const Rect box = rect(i);
    found.x[k] = i.x, found.y[k] = i.y, found.outside[k] = i.outside, found.inside[k] = i.inside;
    found.front[k] = i.front, found.back[k] = i.back, found.farthest[k] = i.farthest;
    found.x0[k] = box.x0, found.x1[k] = box.x1, found.y0[k] = box.y0, found.y1[k] = box.y1;
    found.count[k] = box.count;
    const float three = 3 * radius + slack;
    found.near[k] = static_cast<int>(glm::dot(center, center) <= three * three) |
                    static_cast<int>(center.z <= 1.001f * (radius + near_m_) + slack);
  }
}

void Occlusion::add(std::span<const glm::vec4> spheres, std::uint32_t first, const glm::mat3& view, glm::vec3 origin,
                    float extent) {
  const float slack = kPlace * (glm::length(origin) + extent);
  Together found;
  for (std::size_t begin = 0; begin < spheres.size(); begin += kTogether) {
    const std::size_t n = std::min(kTogether, spheres.size() - begin);
    find(spheres.subspan(begin, n), view, origin, slack, found);
    for (std::size_t i = 0; i < n; ++i) {
      const Seen sphere = found.at(i, first + static_cast<std::uint32_t>(begin + i));
      if (sphere.rect.empty() || (!sphere.rect.countless() && hidden(sphere.image, sphere.rect))) continue;
      seen_.push_back(sphere);
      if (!sphere.rect.countless()) cover(sphere.image, sphere.rect);
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
    // What it covers itself is farther than its front.
    if (!sphere.rect.countless() && hidden(sphere.image, sphere.rect)) continue;
    touch(sphere.rect);
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
