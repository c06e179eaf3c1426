// Sets of spheres: what the stages share. A sphere's frame has the axes of the view and its radius for a unit.
#include "lib/object.glsl"
#include "lib/sphere.glsl"
#include "frame.glsl"
#include "objects.glsl"

// The spheres that are drawn, as roadgen/render/sphere_batch.cc takes them from double. Of those that are not near:
//   place: xy: the centre's image, pixels; z: its depth, m; w: radius, m
//   look: colour; number within the set; 0
// Of near ones, to which the eye is so near, or the centre so far aside, that rays are counted from the eye, not from the
// centre's depth; and where the near plane may cut the front off:
//   place: xyz: the eye in the sphere's frame; w: the sphere's value there
//   look: colour; number within the set; radius, as bits
layout(binding = 9) uniform samplerBuffer sphere_places;
layout(binding = 10) uniform usamplerBuffer sphere_looks;
vec4 sphere_place(uint slot) { return texelFetch(sphere_places, int(slot)); }
uvec4 sphere_look(uint slot) { return texelFetch(sphere_looks, int(slot)); }

// Rays counted from the depth of the centre: o + k d, o the place there as seen from the centre, d 1 along the view axis.
// Half the chord is sqrt(half2) / d^2; where half2 < 0 the ray passes. By Lagrange's identity it is a difference of squares
// that are no larger than the sphere.
struct SphereRay {
  vec2 o;
  vec2 d;
  float d2;
  float half2;
};

SphereRay sphere_ray(vec2 pixel, vec4 place) {
  SphereRay r;
  r.o = (pixel - place.xy) * (right.w * place.z);
  r.d = pixel * right.w - eye_phase.zw;
  r.d2 = dot(r.d, r.d) + 1.0;
  float across = r.o.x * r.d.y - r.o.y * r.d.x;
  r.half2 = place.w * place.w * r.d2 - (dot(r.o, r.o) + across * across);
  return r;
}

// k of the front; where the ray passes, of the place nearest to the centre.
float sphere_front(SphereRay r) { return -(dot(r.o, r.d) + sqrt(max(r.half2, 0.0))) / r.d2; }

// Near ones: k from the eye of the front, or of the back where the near plane cuts the front off; OBJECT_FAR where the ray
// passes. clamped: then that of the place nearest to the centre. eye: place of a near one.
float sphere_first_near(vec2 pixel, vec4 eye, float per_radius, float near, bool clamped) {
  vec3 d = vec3((pixel - vec2(view_size.xy)) * right.w, 1.0) * per_radius;
  float a = dot(d, d);
  float half2 = sphere_chord2(eye.xyz, d);
  vec2 k = object_roots(a, dot(eye.xyz, d), eye.w, sqrt(max(half2, 0.0) * a));
  float first = k.x >= near ? k.x : k.y;
  return (half2 >= 0.0 || clamped) && first >= near ? first : OBJECT_FAR;
}
