// The part of the world that a camera sees, for culling.
#pragma once

#include <array>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/camera.h"

namespace roadgen {

// Six planes about the eye; everything given is relative to it, ENU, m. Conservative: what is drawn is never refused;
// near an edge of the view something outside of it may pass.
class Frustum {
 public:
  // Requires: a camera that check_camera passes, aspect (width over height) > 0.
  Frustum(const Camera& camera, double aspect);
  bool may_see(glm::dvec3 center, double radius_m) const;
  bool may_see(glm::dvec3 low_m, glm::dvec3 high_m) const;

 private:
  std::array<glm::dvec4, 6> planes_;  // unit normal inward and offset: left, right, bottom, top, near, far
};

}  // namespace roadgen
