// A polygon around the circle in which the eye sees a sphere, or the rectangle on the screen. CORNERS vertices a sphere.
// NEAR: for spheres that sphere_is_near names.
#include "frame.glsl"
#include "spheres.glsl"

layout(std430, binding = 5) readonly buffer SphereOrder { uint sphere_order[]; };
layout(location = 1) uniform uint first_drawn;  // in sphere_order
#ifndef PROXY_RECTANGLE
layout(location = 3) uniform vec2 corners[CORNERS];  // around the unit circle
#endif

flat out uint sphere_index;
flat out vec4 place;  // SphereView; NEAR: w alone
#ifdef NEAR
flat out vec4 eye;
#else
flat out vec2 ahead;
#endif
#ifdef IN_PLANE
out vec2 in_plane;  // the place in the circle's plane
#endif

void main() {
  int drawn = gl_VertexID / CORNERS;
  int corner_index = gl_VertexID - drawn * CORNERS;
  sphere_index = sphere_order[first_drawn + uint(drawn)];
  vec4 sphere = spheres[sphere_index];
  float radius = sphere.w;
  dvec3 center = sphere_center(sphere);
  vec3 c = vec3(center);
  float near = forward.w;
#ifdef IN_PLANE
  in_plane = vec2(0.0);
#endif
#ifdef NEAR
  place = vec4(0.0, 0.0, 0.0, 1.0 / radius);
  eye = sphere_eye(center, radius);
  // Behind the near plane, or all over the screen.
  bool behind = c.z + radius < near;
  bool around = dot(eye.xyz, eye.xyz) < 1.03 || c.z <= radius * 1.0001;
#else
  SphereView v = sphere_view(center, radius);
  place = v.place;
  ahead = v.ahead;
#endif
  // The nearest that anything of it can be: what is written is never in front of this.
  float depth = near / max(c.z - 1.00001 * radius, near);
  vec2 scale = 1.0 / eye_phase.zw;
#ifdef PROXY_RECTANGLE
  vec2 side = vec2(corner_index == 0 || corner_index == 3 ? 1.0 : -1.0, corner_index < 2 ? 1.0 : -1.0);
#ifdef NEAR
  if (behind || around) {
    gl_Position = behind ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(side, 1.0, 1.0);
    return;
  }
  vec2 slope = c.xy / c.z;
#else
  vec2 slope = v.slope;
#endif
  // The tangent lines of the projected sphere: planes through the eye of normal (1, 0, -m) touch where (c.x - m c.z)^2 =
  // r^2 (1 + m^2). With a = c.z^2 - r^2: m = c.x / c.z + (its difference from there), which is small and computed as such.
  float a = (c.z - radius) * (c.z + radius);
  vec2 wide = radius * sqrt(c.xy * c.xy + a);
  gl_Position = vec4((slope + (slope * (radius * radius) + side * wide) / a) * scale, depth, 1.0);
#else
  vec2 corner = corners[corner_index];
#ifdef NEAR
  if (behind || around) {
    gl_Position = behind ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(corner * 2.0, 1.0, 1.0);
    return;
  }
#endif
#ifdef IN_PLANE
  in_plane = corner;
#endif
  float from2 = dot(c, c);
  vec3 q = sphere_circle(corner.x, corner.y, -c * inversesqrt(from2), sqrt(from2) / radius) * radius;
  dvec3 at = center + dvec3(q);
  gl_Position = vec4(float(at.x) * scale.x, float(at.y) * scale.y, depth * float(at.z), float(at.z));
#endif
}
