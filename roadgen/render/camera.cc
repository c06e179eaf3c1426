#include "roadgen/render/camera.h"

#include <cmath>
#include <numbers>

namespace roadgen {
namespace {

double radians(double degrees) { return degrees * std::numbers::pi / 180; }

}  // namespace

Status check_camera(const Camera& camera) {
  const double sum = camera.position_m.x + camera.position_m.y + camera.position_m.z + camera.yaw_deg +
                     camera.pitch_deg + camera.roll_deg;
  if (!std::isfinite(sum)) return Error{ErrorCode::kUsage, "the camera's position and angles must be finite numbers"};
  if (!(camera.fov_deg > 0 && camera.fov_deg <= 170)) {
    return Error{ErrorCode::kUsage, "the field of view must lie in (0, 170] degrees"};
  }
  if (!(camera.near_m > 0)) return Error{ErrorCode::kUsage, "the near plane must lie in front of the camera"};
  if (!(camera.far_m > camera.near_m)) {
    return Error{ErrorCode::kUsage, "the far plane must lie beyond the near plane"};
  }
  return Done{};
}

ViewAxes view_axes(const Camera& camera) {
  const double cy = std::cos(radians(camera.yaw_deg)), sy = std::sin(radians(camera.yaw_deg));
  const double cp = std::cos(radians(camera.pitch_deg)), sp = std::sin(radians(camera.pitch_deg));
  const double cr = std::cos(radians(camera.roll_deg)), sr = std::sin(radians(camera.roll_deg));
  const glm::dvec3 forward(cp * cy, cp * sy, sp);
  const glm::dvec3 level_right(sy, -cy, 0);
  const glm::dvec3 level_up(-sp * cy, -sp * sy, cp);
  return {forward, level_right * cr - level_up * sr, level_up * cr + level_right * sr};
}

glm::dmat4 clip_from_relative(const Camera& camera, double aspect) {
  const ViewAxes axes = view_axes(camera);
  const double scale = 1 / std::tan(radians(camera.fov_deg) / 2);
  glm::dmat4 m(0.0);
  for (int column = 0; column < 3; ++column) {
    m[column][0] = axes.right[column] * scale / aspect;
    m[column][1] = axes.up[column] * scale;
    m[column][3] = axes.forward[column];
  }
  m[3][2] = camera.near_m;
  return m;
}

glm::dvec3 pixel_ray(const Camera& camera, int width, int height, double x, double y) {
  const ViewAxes axes = view_axes(camera);
  const double pixel = 2 * std::tan(radians(camera.fov_deg) / 2) / height;
  return axes.forward + axes.right * ((x + 0.5 - 0.5 * width) * pixel) + axes.up * ((0.5 * height - y - 0.5) * pixel);
}

}  // namespace roadgen
