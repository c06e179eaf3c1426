#include "roadgen/object/placement.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

namespace roadgen {

glm::dmat4 placement_frame(const RoadPose& pose, const Placement& placement) {
  const double heading = pose.heading_rad + placement.heading_rad;
  const double c = std::cos(heading), s = std::sin(heading);
  const glm::dvec3 origin = pose.position_m + glm::dvec3(0, 0, placement.h_m);
  return {{c, s, 0, 0}, {-s, c, 0, 0}, {0, 0, 1, 0}, glm::dvec4(origin, 1)};
}

bool is_similarity(const glm::dmat4& map) {
  const glm::dvec3 x(map[0]), y(map[1]), z(map[2]);
  const double scale = glm::dot(x, x), slack = 1e-6 * scale;
  return scale > 0 && std::isfinite(scale) && std::abs(glm::dot(y, y) - scale) <= slack &&
         std::abs(glm::dot(z, z) - scale) <= slack && std::abs(glm::dot(x, y)) <= slack &&
         std::abs(glm::dot(x, z)) <= slack && std::abs(glm::dot(y, z)) <= slack;
}

void transform(SphereSet& set, const glm::dmat4& world_from_set) {
  const glm::dmat3 turn(world_from_set);
  const auto scale = static_cast<float>(glm::length(turn[0]));
  set.origin_m = glm::dvec3(world_from_set * glm::dvec4(set.origin_m, 1));
  for (SphereSet::Item& item : set.items) {
    item.center = glm::vec3(turn * glm::dvec3(item.center));
    item.radius *= scale;
  }
}

}  // namespace roadgen
