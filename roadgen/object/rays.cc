#include "roadgen/object/rays.h"

#include <algorithm>
#include <cmath>

#include <embree3/rtcore.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace roadgen {
namespace {

// The ray in the primitive's frame, from its place nearest to the centre, so that nothing is lost far away.
struct LocalRay {
  glm::dvec3 o, d;
  double t;  // of o
};

LocalRay local_ray(const Primitive& p, glm::dvec3 origin_m, glm::dvec3 direction) {
  const glm::dmat3 inverse = glm::inverse(p.axes);
  const glm::dvec3 o = inverse * (origin_m - p.center_m), d = inverse * direction;
  const double t = -glm::dot(o, d) / glm::dot(d, d);
  return {inverse * (origin_m - p.center_m + direction * t), d, t};
}

ObjectHit made(const Primitive& p, const LocalRay& ray, double k, int face, glm::dvec3 origin_m, glm::dvec3 direction) {
  const PrimitiveRow& row = primitive_row(p.kind);
  const glm::dvec3 at = ray.o + ray.d * k;
  ObjectHit hit;
  hit.t = ray.t + k;
  hit.face = face;
  hit.position_m = origin_m + direction * hit.t;
  hit.normal = glm::normalize(glm::transpose(glm::inverse(p.axes)) * row.normal(at, face, p.shape));
  const bool open = (p.shape.flags & OBJECT_SOLID) == 0;
  if (open && glm::dot(hit.normal, direction) > 0) hit.normal = -hit.normal;
  hit.uv = row.uv(at, face, p.shape);
  return hit;
}

}  // namespace

std::vector<ObjectHit> all_hits(const Primitive& p, glm::dvec3 origin_m, glm::dvec3 direction) {
  const PrimitiveRow& row = primitive_row(p.kind);
  const LocalRay ray = local_ray(p, origin_m, direction);
  const ObjectLib::ObjectHits met = row.hits(ray.o, ray.d, row.value(ray.o, p.shape), p.shape);
  std::vector<ObjectHit> hits;
  for (int i = 0; i < met.count; ++i) hits.push_back(made(p, ray, met.k[i], met.face[i], origin_m, direction));
  return hits;
}

struct ObjectRays::State {
  std::vector<Primitive> primitives;  // of the objects
  std::vector<SphereSet> sets;
  std::vector<std::uint32_t> set_starts;  // instance of each set's first sphere
  std::uint32_t instances = 0;
  glm::dvec3 middle_m{0, 0, 0};  // Embree's floats are relative to it
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  ~State() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }
  Primitive primitive_of(std::uint32_t instance) const;
};

Primitive ObjectRays::State::primitive_of(std::uint32_t instance) const {
  if (instance < primitives.size()) return primitives[instance];
  const auto after = std::upper_bound(set_starts.begin(), set_starts.end(), instance);
  const std::size_t set = static_cast<std::size_t>(after - set_starts.begin()) - 1;
  const SphereSet::Item& item = sets[set].items[instance - set_starts[set]];
  Primitive p;
  p.center_m = sets[set].origin_m + glm::dvec3(item.center);
  p.axes = glm::dmat3(static_cast<double>(item.radius));
  p.shape.flags = OBJECT_SOLID;
  return p;
}

namespace {

// What a query carries through Embree, whose own rays are single precision and only find the boxes.
struct Query {
  RTCIntersectContext context;
  glm::dvec3 origin_m, direction;
  double t_from, t_to;
  std::optional<ObjectHit> hit;
};

float down(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float up(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

}  // namespace

ObjectRays::ObjectRays(const ObjectScene& objects) : state_(std::make_unique<State>()) {
  State& s = *state_;
  for (const Object& object : objects.objects) s.primitives.push_back(primitive(object));
  s.sets = objects.sphere_sets;
  s.instances = static_cast<std::uint32_t>(s.primitives.size());
  for (const SphereSet& set : s.sets) {
    s.set_starts.push_back(s.instances);
    s.instances += static_cast<std::uint32_t>(set.items.size());
  }
  if (s.instances == 0) return;
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (std::uint32_t i = 0; i < s.instances; ++i) {
    const ObjectBounds b = bounds(s.primitive_of(i));
    low = glm::min(low, b.low_m), high = glm::max(high, b.high_m);
  }
  s.middle_m = 0.5 * (low + high);
  s.device = rtcNewDevice(nullptr);
  s.scene = rtcNewScene(s.device);
  // Robust: the traversal of boxes loses none to rounding.
  rtcSetSceneFlags(s.scene, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(s.device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, s.instances);
  rtcSetGeometryUserData(geometry, &s);
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* a) {
        const State& state = *static_cast<const State*>(a->geometryUserPtr);
        const ObjectBounds b = bounds(state.primitive_of(a->primID));
        // Wider by what a float ray from afar may be off.
        const glm::dvec3 lowest = b.low_m - state.middle_m, highest = b.high_m - state.middle_m;
        const glm::dvec3 room = 1e-6 * (glm::abs(lowest) + glm::abs(highest));
        a->bounds_o->lower_x = down(lowest.x - room.x), a->bounds_o->upper_x = up(highest.x + room.x);
        a->bounds_o->lower_y = down(lowest.y - room.y), a->bounds_o->upper_y = up(highest.y + room.y);
        a->bounds_o->lower_z = down(lowest.z - room.z), a->bounds_o->upper_z = up(highest.z + room.z);
      },
      nullptr);
  rtcSetGeometryIntersectFunction(geometry, [](const RTCIntersectFunctionNArguments* a) {
    if (!a->valid[0]) return;
    Query& query = *reinterpret_cast<Query*>(a->context);
    const State& state = *static_cast<const State*>(a->geometryUserPtr);
    const Primitive p = state.primitive_of(a->primID);
    for (const ObjectHit& hit : all_hits(p, query.origin_m, query.direction)) {
      if (hit.t < query.t_from || hit.t > query.t_to) continue;
      query.hit = hit;
      query.hit->instance = a->primID;
      query.t_to = hit.t;
      RTCRayHit& ray = *reinterpret_cast<RTCRayHit*>(a->rayhit);
      ray.ray.tfar = std::min(ray.ray.tfar, up(hit.t * (1 + 1e-6)));
      ray.hit.geomID = a->geomID;
      ray.hit.primID = a->primID;
      break;
    }
  });
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(s.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(s.scene);
}

ObjectRays::ObjectRays(ObjectRays&&) noexcept = default;
ObjectRays& ObjectRays::operator=(ObjectRays&&) noexcept = default;
ObjectRays::~ObjectRays() = default;

Primitive ObjectRays::primitive_of(std::uint32_t instance) const { return state_->primitive_of(instance); }

std::optional<ObjectHit> ObjectRays::nearest(glm::dvec3 origin_m, glm::dvec3 direction, double t_from,
                                             double t_to) const {
  const State& s = *state_;
  if (!s.scene) return std::nullopt;
  Query query;
  rtcInitIntersectContext(&query.context);
  query.origin_m = origin_m;
  query.direction = direction;
  query.t_from = t_from;
  query.t_to = t_to;
  RTCRayHit ray{};
  const glm::vec3 o = origin_m - s.middle_m, d = direction;
  ray.ray.org_x = o.x, ray.ray.org_y = o.y, ray.ray.org_z = o.z;
  ray.ray.dir_x = d.x, ray.ray.dir_y = d.y, ray.ray.dir_z = d.z;
  // Embree's range begins at 0 and holds ours.
  ray.ray.tnear = std::max(0.0f, down(t_from * (1 - 1e-6)));
  ray.ray.tfar = std::isfinite(t_to) ? up(t_to * (1 + 1e-6)) : std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0u;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(s.scene, &query.context, &ray);
  return query.hit;
}

}  // namespace roadgen
