#include "roadgen/render/flight.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// A point of the road; beyond an open road's ends, along its last tangent.
glm::dvec3 extended(const Road& road, double s_m) {
  const double length = road.length_m();
  const RoadPose pose = pose_at(road, road.closed ? s_m : std::clamp(s_m, 0.0, length), 0);
  if (road.closed) return pose.position_m;
  const double beyond = s_m < 0 ? s_m : std::max(s_m - length, 0.0);
  return pose.position_m + beyond * glm::dvec3(std::cos(pose.heading_rad), std::sin(pose.heading_rad), 0);
}

// Mean over [s - half, s + half] with weights that fall to 0 at both ends.
glm::dvec3 smoothed(const Road& road, double s_m, double half_m) {
  constexpr int kSamples = 24;
  glm::dvec3 sum(0);
  double weights = 0;
  for (int i = -kSamples; i <= kSamples; ++i) {
    const double x = static_cast<double>(i) / (kSamples + 1), weight = (1 - x * x) * (1 - x * x);
    sum += weight * extended(road, s_m + x * half_m);
    weights += weight;
  }
  return sum / weights;
}

}  // namespace

Camera drive_camera(const Road& road, double s_m, double t_m, double height_m) {
  const RoadPose pose = pose_at(road, s_m, t_m);
  Camera camera;
  camera.position_m = pose.position_m + glm::dvec3(0, 0, height_m);
  camera.yaw_deg = pose.heading_rad * kDegrees;
  camera.pitch_deg = pose.pitch_rad * kDegrees;
  return camera;
}

Camera flight_camera(const Road& road, double s_m, const FlightOptions& options) {
  Camera camera;
  camera.position_m = smoothed(road, s_m, options.smooth_m) + glm::dvec3(0, 0, options.height_m);
  const glm::dvec3 toward = smoothed(road, s_m + options.ahead_m, options.smooth_m) - camera.position_m;
  camera.yaw_deg = std::atan2(toward.y, toward.x) * kDegrees;
  camera.pitch_deg = std::atan2(toward.z, std::hypot(toward.x, toward.y)) * kDegrees;
  return camera;
}

}  // namespace roadgen
