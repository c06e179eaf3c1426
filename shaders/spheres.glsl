// Sets of spheres: what the stages share. A sphere's frame has the axes of the view and its radius for a unit.
#include "lib/object.glsl"
#include "lib/sphere.glsl"
#include "frame.glsl"
#include "objects.glsl"

layout(std430, binding = 3) readonly buffer Spheres { vec4 spheres[]; };               // centre from the set's origin, radius
layout(std430, binding = 4) readonly buffer SphereColors { uvec2 sphere_colors[]; };  // colour; number within the set
layout(location = 0) uniform dvec3 set_from_eye;                                       // the origin, in the view's axes

// In the view's axes, from the eye.
dvec3 sphere_center(vec4 sphere) {
  dvec3 p = dvec3(sphere.xyz);
  return set_from_eye + dvec3(dot(view_right.xyz, p), dot(view_up.xyz, p), dot(view_forward.xyz, p));
}

// Whether the eye is so near, or the centre so far aside, that rays are counted from the eye, not from the centre's depth.
bool sphere_is_near(vec3 center, float radius) {
  return dot(center, center) <= 9.0 * radius * radius || center.z <= radius;
}

// Rays counted from the depth of the centre: o + k d with d = (ahead + a, 1 / r), o = (a depth, 0), a the distance in pixels
// from the centre's image, in the sphere's units at depth 1.
struct SphereView {
  vec4 place;  // xy: the centre's image, pixels; z: its depth, m; w: 1 / radius
  vec2 ahead;
  vec2 slope;  // the centre's image at depth 1
};

SphereView sphere_view(dvec3 center, float radius) {
  dvec2 slope = center.xy * (1.0lf / center.z);
  SphereView v;
  v.place = vec4(vec2(slope * view_size.w + view_size.xy), float(center.z), 1.0 / radius);
  v.slope = vec2(slope);
  v.ahead = v.slope * v.place.w;
  return v;
}

// k of the front, or of the back where the near plane cuts the front off; OBJECT_FAR where the ray passes. clamped: then that
// of the place nearest to the centre.
float sphere_first_far(vec2 pixel, vec4 place, vec2 ahead, float near, bool clamped) {
  vec2 at = (pixel - place.xy) * (right.w * place.w);
  vec2 o = at * place.z;
  vec3 d = vec3(ahead + at, place.w);
  float per_a = 1.0 / dot(d, d);
  float middle = -(o.x * d.x + o.y * d.y) * per_a;
  vec3 nearest = vec3(o + d.xy * middle, d.z * middle);
  float half2 = 1.0 - dot(nearest, nearest);
  float half_ = sqrt(max(half2, 0.0) * per_a);
  float k = place.z + middle - half_ >= near ? middle - half_ : middle + half_;
  return (half2 >= 0.0 || clamped) && place.z + k >= near ? k : OBJECT_FAR;
}

// The same of rays that are counted from the eye. eye: in the sphere's frame; w: the sphere's value there, from double.
float sphere_first_near(vec2 pixel, vec4 eye, float per_radius, float near, bool clamped) {
  vec3 d = vec3((pixel - vec2(view_size.xy)) * right.w, 1.0) * per_radius;
  float a = dot(d, d);
  float half2 = sphere_chord2(eye.xyz, d);
  vec2 k = object_roots(a, dot(eye.xyz, d), eye.w, sqrt(max(half2, 0.0) * a));
  float first = k.x >= near ? k.x : k.y;
  return (half2 >= 0.0 || clamped) && first >= near ? first : OBJECT_FAR;
}

vec4 sphere_eye(dvec3 center, float radius) {
  dvec3 eye = center * (-1.0lf / double(radius));
  return vec4(vec3(eye), float(dot(eye, eye) - 1.0lf));
}
