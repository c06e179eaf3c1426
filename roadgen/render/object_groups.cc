#include "roadgen/render/object_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/render/frustum.h"

namespace roadgen {
namespace {

// Every third bit of 21.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// A ball around balls.
std::pair<glm::dvec3, double> around(std::span<const glm::dvec3> centers, std::span<const double> radii) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (std::size_t i = 0; i < centers.size(); ++i) {
    low = glm::min(low, centers[i] - radii[i]);
    high = glm::max(high, centers[i] + radii[i]);
  }
  const glm::dvec3 middle = 0.5 * (low + high);
  double radius = 0;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    radius = std::max(radius, glm::length(centers[i] - middle) + radii[i]);
  }
  return {middle, radius};
}

}  // namespace

std::vector<std::uint32_t> space_order(std::span<const glm::dvec3> centers) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const glm::dvec3& c : centers) low = glm::min(low, c), high = glm::max(high, c);
  const glm::dvec3 size = glm::max(high - low, glm::dvec3(1e-30));
  const double scale = 2097151 / std::max({size.x, size.y, size.z});
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(centers.size());
  for (std::uint32_t i = 0; i < centers.size(); ++i) {
    const glm::dvec3 at = (centers[i] - low) * scale;
    keys[i] = {spread(static_cast<std::uint64_t>(at.x)) | spread(static_cast<std::uint64_t>(at.y)) << 1 |
                   spread(static_cast<std::uint64_t>(at.z)) << 2,
               i};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(centers.size());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& k) { return k.second; });
  return order;
}

std::vector<ObjectGroup> groups_of(std::span<const glm::dvec3> centers_m, std::span<const double> radii_m) {
  std::vector<ObjectGroup> groups;
  for (std::size_t first = 0; first < centers_m.size(); first += kGroupObjects) {
    const std::size_t count = std::min<std::size_t>(kGroupObjects, centers_m.size() - first);
    const auto [center, radius] = around(centers_m.subspan(first, count), radii_m.subspan(first, count));
    groups.push_back({center, radius, static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(count)});
  }
  return groups;
}

std::vector<const ObjectGroup*> visible_groups(std::span<const ObjectGroup> groups, const ObjectView& view) {
  const Frustum frustum(view.camera, static_cast<double>(view.width) / view.height);
  std::vector<std::pair<double, const ObjectGroup*>> seen;
  for (const ObjectGroup& group : groups) {
    const glm::dvec3 from_eye = group.center_m - view.camera.position_m;
    if (frustum.may_see(from_eye, group.radius_m)) seen.emplace_back(glm::length(from_eye) - group.radius_m, &group);
  }
  std::sort(seen.begin(), seen.end());
  std::vector<const ObjectGroup*> sorted(seen.size());
  std::transform(seen.begin(), seen.end(), sorted.begin(), [](const auto& s) { return s.second; });
  return sorted;
}

}  // namespace roadgen
