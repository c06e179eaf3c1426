// Pixels of one object against its rays in double: what tests of objects share.
#pragma once

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include <glm/geometric.hpp>

#include "roadgen/object/rays.h"
#include "roadgen/render/renderer.h"
#include "tests/object_shapes.h"

namespace roadgen::test {

// What the rays say of a pixel.
inline std::optional<ObjectHit> cast(const Primitive& p, const Camera& camera, int width, int height, double x,
                                     double y) {
  const glm::dvec3 ray = pixel_ray(camera, width, height, x, y);
  for (const ObjectHit& hit : all_hits(p, camera.position_m, ray)) {
    if (hit.t >= camera.near_m) return hit;
  }
  return std::nullopt;
}

// Pixels this near to a silhouette or an edge may fall on either side (of 1 pixel).
inline constexpr double kEdge_px = 0.01;
// Whether within kEdge_px of the pixel's centre the ray meets the same surface.
inline bool same_around(const Primitive& p, const Camera& camera, int width, int height, int x, int y,
                        const std::optional<ObjectHit>& hit) {
  for (int i = 0; i < 8; ++i) {
    const double turn = i * std::numbers::pi / 4;
    const auto other = cast(p, camera, width, height, x + kEdge_px * std::cos(turn), y + kEdge_px * std::sin(turn));
    if (other.has_value() != hit.has_value()) return false;
    if (!hit) continue;
    if (other->face != hit->face) return false;
    // Another part of the surface, as at an inner silhouette.
    if (std::abs(other->t - hit->t) > 0.05 * hit->t || glm::dot(other->normal, hit->normal) < 0.9) return false;
  }
  return true;
}

// The last kind is a sphere of a set.
inline constexpr int kOfSet = kShapeKinds;
inline constexpr int kAllKinds = kShapeKinds + 1;

// Adds a shape of the kind; returns what it is drawn as.
inline Primitive add_shape(ObjectScene& scene, int kind, const glm::dmat4& transform, ShapeRandom& random) {
  if (kind != kOfSet) {
    scene.objects.push_back({.name = "", .shape = random_shape(kind, random), .transform = transform});
    return primitive(scene.objects.back());
  }
  if (scene.sphere_sets.empty()) scene.sphere_sets.emplace_back().origin_m = glm::dvec3(transform[3]);
  SphereSet& set = scene.sphere_sets[0];
  const auto radius = static_cast<float>(glm::length(transform[0]));
  set.items.push_back({glm::vec3(glm::dvec3(transform[3]) - set.origin_m), radius});
  Object same;
  same.shape = Sphere{set.origin_m + glm::dvec3(set.items.back().center), radius};
  return primitive(same);
}

inline const char* kind_name(int kind, ShapeRandom& random) {
  return kind == kOfSet ? "sphere of a set" : shape_name(random_shape(kind, random));
}

}  // namespace roadgen::test
