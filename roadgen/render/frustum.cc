#include "roadgen/render/frustum.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace roadgen {

Frustum::Frustum(const Camera& camera, double aspect) {
  const ViewAxes axes = view_axes(camera);
  const double y = std::tan(camera.fov_deg * std::numbers::pi / 360), x = y * aspect;
  const auto side = [](glm::dvec3 normal) { return glm::dvec4(glm::normalize(normal), 0); };
  planes_ = {side(axes.forward * x + axes.right),      side(axes.forward * x - axes.right),
             side(axes.forward * y + axes.up),         side(axes.forward * y - axes.up),
             glm::dvec4(axes.forward, -camera.near_m), glm::dvec4(-axes.forward, camera.far_m)};
}

bool Frustum::may_see(glm::dvec3 center, double radius_m) const {
  return std::all_of(planes_.begin(), planes_.end(), [&](const glm::dvec4& plane) {
    return glm::dot(glm::dvec3(plane), center) + plane.w >= -radius_m;
  });
}

bool Frustum::may_see(glm::dvec3 low_m, glm::dvec3 high_m) const {
  return std::all_of(planes_.begin(), planes_.end(), [&](const glm::dvec4& plane) {
    // The corner that lies farthest inward.
    const glm::dvec3 corner(plane.x > 0 ? high_m.x : low_m.x, plane.y > 0 ? high_m.y : low_m.y,
                            plane.z > 0 ? high_m.z : low_m.z);
    return glm::dot(glm::dvec3(plane), corner) + plane.w >= 0;
  });
}

}  // namespace roadgen
