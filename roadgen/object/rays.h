// Rays in double against objects: all that a ray meets of one, the nearest of a scene. The functions are those that the
// pixels of the picture are computed by (shaders/lib).
//
//   const ObjectRays rays(scene);
//   if (const auto hit = rays.nearest(eye_m, direction)) use(hit->position_m, hit->normal);
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/object/object.h"
#include "roadgen/object/primitive.h"

namespace roadgen {

struct ObjectHit {
  std::uint32_t instance = 0;  // ObjectScene::instances
  double t = 0;                // along the ray, in units of its direction
  int face = 0;                // the shape's own numbers of its faces, shaders/lib
  glm::dvec3 position_m{0, 0, 0};
  glm::dvec3 normal{0, 0, 1};  // unit; outward of a solid, of a flat or open shape against the ray
  glm::dvec2 uv{0, 0};
};

// All places where origin_m + t direction meets the primitive, every t, ordered: of a solid by turns where the ray enters
// and leaves. At most 4. Requires: direction not 0, of any length. Cost: the closed form, for a torus some iterations.
std::vector<ObjectHit> all_hits(const Primitive& primitive, glm::dvec3 origin_m, glm::dvec3 direction);

// A scene in a tree of Embree. Immutable, so any number of threads may ask at once.
class ObjectRays {
 public:
  // Requires: a scene that check() passes. Cost: O(n log n); about 300 bytes an object, 100 a sphere of a set.
  explicit ObjectRays(const ObjectScene& scene);
  ObjectRays(ObjectRays&&) noexcept;
  ObjectRays& operator=(ObjectRays&&) noexcept;
  ~ObjectRays();

  // The nearest hit with t in [t_from, t_to]. Requires: direction finite and not 0, t_from >= 0. Cost: O(log n) on average.
  std::optional<ObjectHit> nearest(glm::dvec3 origin_m, glm::dvec3 direction, double t_from = 0,
                                   double t_to = std::numeric_limits<double>::infinity()) const;
  // The primitive of an instance, made at the call for spheres of sets.
  Primitive primitive_of(std::uint32_t instance) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace roadgen
