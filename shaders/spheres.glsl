// Sets of spheres: what the stages share. A sphere's frame has the axes of the view and its radius for a unit.
#include "lib/object.glsl"
#include "lib/sphere.glsl"
#include "frame.glsl"
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

// A ray of the pixel; its point nearest to the centre is at k = k_nearest; half2: of the chord, squared, in radii.
struct SphereRay {
  vec3 o;
  vec3 d;
  float per_a;  // 1 / d^2
  float k_nearest;
  float half2;
};

SphereRay sphere_ray(vec2 pixel, vec4 origin, vec3 ahead, vec4 place) {
  vec2 at = (pixel - place.xy) * (right.w * place.w);
  SphereRay r;
  r.o = origin.xyz + vec3(at * place.z, 0.0);
  r.d = ahead + vec3(at, 0.0);
  r.per_a = 1.0 / dot(r.d, r.d);
  r.k_nearest = -dot(r.o, r.d) * r.per_a;
  vec3 nearest = r.o + r.d * r.k_nearest;
  r.half2 = 1.0 - dot(nearest, nearest);
  return r;
}

// Where the ray first meets the sphere beyond the near plane; OBJECT_FAR where it does not. From afar both roots are
// plain; an eye near the sphere needs the value there, in double.
float sphere_first(SphereRay r, float at_eye, bool far, float least) {
  float half_ = sqrt(max(r.half2, 0.0) * r.per_a);
  vec2 k = vec2(r.k_nearest - half_, r.k_nearest + half_);
  if (!far) k = object_roots(1.0 / r.per_a, dot(r.o, r.d), at_eye, half_ / r.per_a);
  float first = k.x >= least ? k.x : k.y;
  return r.half2 >= 0.0 && first >= least ? first : OBJECT_FAR;
}
