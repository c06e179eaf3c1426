// Internal, not installed: objects in groups of neighbours, which are culled and ordered together. No OpenGL.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/render/camera.h"

namespace roadgen {

// What a frame shows objects in.
struct ObjectView {
  Camera camera;
  int width = 1, height = 1, samples = 1;
  bool channels = false;             // else the picture
  std::uint32_t first_instance = 0;  // of the instance channel
  // The framebuffer that is drawn into, and its depth texture.
  unsigned framebuffer = 0, depth = 0;
};

// A ball around a range of objects.
struct ObjectGroup {
  glm::dvec3 center_m;
  double radius_m;
  std::uint32_t first, count;
};
inline constexpr std::uint32_t kGroupObjects = 128;

// An order in which neighbours in the list are neighbours in space (Morton's curve, 2^21 steps a side). Cost: O(n log n).
std::vector<std::uint32_t> space_order(std::span<const glm::dvec3> centers_m);

// The ranges of kGroupObjects balls each. Requires: as many radii as centres.
std::vector<ObjectGroup> groups_of(std::span<const glm::dvec3> centers_m, std::span<const double> radii_m);

// Those that the camera may see, near ones first. Cost: O(n + v log v), n groups, v seen.
std::vector<const ObjectGroup*> visible_groups(std::span<const ObjectGroup> groups, const ObjectView& view);

}  // namespace roadgen
