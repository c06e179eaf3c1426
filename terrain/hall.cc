#include "terrain/hall.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>

namespace roadgen {
namespace {

constexpr double kStep_m = 2;

}  // namespace

bool Hall::is_above(glm::dvec3 point_m) const {
  const glm::dvec2 at(point_m);
  return is_inside(surface, at) && point_m.z < height_m_at(surface, at) + height_m;
}

Box Hall::box() const {
  const glm::dvec2 center(surface.center_m);
  return {glm::dvec3(center + glm::dvec2(surface.low_m), 0), glm::dvec3(center + glm::dvec2(surface.high_m), 0)};
}

// A step beyond the boundary too, so that nothing is missed between the places.
bool is_covered(const Hall& hall, const std::function<double(glm::dvec2)>& ground_m, double cover_m) {
  const Box box = hall.box();
  const glm::dvec2 low = glm::dvec2(box.low_m) - kStep_m, size = glm::dvec2(box.high_m) + kStep_m - low;
  const glm::ivec2 count(glm::ceil(size / kStep_m));
  for (int i = 0; i <= count.x; ++i) {
    for (int j = 0; j <= count.y; ++j) {
      const glm::dvec2 at = low + size * glm::dvec2(i, j) / glm::dvec2(count);
      if (signed_distance_m(hall.surface, at, 2 * kStep_m) < -kStep_m) continue;
      if (!(ground_m(at) >= height_m_at(hall.surface, at) + hall.height_m + cover_m)) return false;
    }
  }
  return true;
}

}  // namespace roadgen
