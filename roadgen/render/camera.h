// A pinhole camera in the world, and the projection that all passes share.
#pragma once

#include <limits>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/road/result.h"

namespace roadgen {

struct Camera {
  glm::dvec3 position_m{0, 0, 0};  // ENU
  double yaw_deg = 0;              // counter-clockwise from east
  double pitch_deg = 0;            // up positive, in [-90, 90]
  double roll_deg = 0;             // right side down positive
  double fov_deg = 50;             // vertical, in (0, 170]
  double near_m = 0.1;             // > 0
  // > near_m. Whole parts of the scene beyond it are left out; nothing is cut off at it.
  double far_m = std::numeric_limits<double>::infinity();
};

// Errors: kUsage: a number that is not finite, or out of its range.
Status check_camera(const Camera& camera);

// Unit axes of the view in ENU.
struct ViewAxes {
  glm::dvec3 forward, right, up;
};
ViewAxes view_axes(const Camera& camera);

// Clip from eye-relative ENU: reversed depth, near plane at 1, infinity at 0, so that
// depth along the view axis = near_m / depth-buffer value.
glm::dmat4 clip_from_relative(const Camera& camera, double aspect);

// Direction (not unit: 1 along the view axis) through the centre of pixel (x, y), y down from the top row.
glm::dvec3 pixel_ray(const Camera& camera, int width, int height, double x, double y);

}  // namespace roadgen
