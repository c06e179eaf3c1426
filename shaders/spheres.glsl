// Sets of spheres: what the stages share. A sphere's frame has the axes of the view and its radius for a unit.
#include "lib/object.glsl"
#include "lib/sphere.glsl"
#include "objects.glsl"

layout(std430, binding = 3) readonly buffer Spheres { vec4 spheres[]; };               // centre from the set's origin, radius
layout(std430, binding = 4) readonly buffer SphereColors { uvec2 sphere_colors[]; };  // colour; number within the set
layout(location = 0) uniform dvec3 set_from_eye;                                       // the origin, in the view's axes

struct SphereView {
  dvec3 center;  // in the view's axes, from the eye
  vec4 origin;   // of the rays, in the sphere's frame; w: the sphere's value there
  vec3 ahead;    // a ray's direction is ahead + (pixels from place, 0) * pixel / radius
  vec4 place;    // xy: pixels; z: depth of the rays' origin, 0 where that is the eye; w: 1 / radius
};

SphereView sphere_view(vec4 sphere) {
  SphereView v;
  dvec3 p = dvec3(sphere.xyz);
  v.center = set_from_eye + dvec3(dot(view_right.xyz, p), dot(view_up.xyz, p), dot(view_forward.xyz, p));
  float part = 1.0 / sphere.w;
  vec3 center = vec3(v.center);
  vec3 eye = -center * part;
  bool far = dot(eye, eye) > 9.0 && center.z > sphere.w;
  dvec2 base = far ? v.center.xy / (v.center.z * view_size.z) : dvec2(0.0);
  v.place = vec4(vec2(base + view_size.xy), far ? center.z : 0.0, part);
  v.ahead = vec3(vec2(base * view_size.z), 1.0) * part;
  v.origin = vec4(0.0);
  if (!far) {
    dvec3 exact = v.center / double(sphere.w);
    v.origin = vec4(eye, float(dot(exact, exact) - 1.0lf));
  }
  return v;
}

struct SphereRay {
  vec3 o;
  vec3 d;
  float at_o;
};

SphereRay sphere_ray(vec2 pixel, vec4 origin, vec3 ahead, vec4 place) {
  vec2 at = (pixel - place.xy) * (float(view_size.z) * place.w);
  vec3 o = origin.xyz + vec3(at * place.z, 0.0);
  return SphereRay(o, ahead + vec3(at, 0.0), place.z > 0.0 ? dot(o, o) - 1.0 : origin.w);
}

// Where the ray first meets the sphere beyond the near plane; OBJECT_FAR where it does not.
float sphere_first(SphereRay r, float least) {
  float half2 = sphere_chord2(r.o, r.d);
  float a = dot(r.d, r.d);
  vec2 k = object_roots(a, dot(r.o, r.d), r.at_o, sqrt(max(half2, 0.0) * a));
  float first = k.x >= least ? k.x : k.y;
  return half2 >= 0.0 && first >= least ? first : OBJECT_FAR;
}
