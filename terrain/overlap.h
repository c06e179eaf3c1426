// A place where two carriageways lie above one another, so that no ground is just below both.
#pragma once

#include <glm/vec2.hpp>

namespace roadgen {

struct Overlap {
  glm::dvec2 at_m{0, 0};
  double apart_m = 0;  // their difference in height there
};

}  // namespace roadgen
