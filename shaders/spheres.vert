// A polygon around the circle in which the eye sees a sphere, or the rectangle on the screen. CORNERS vertices a sphere.
#include "frame.glsl"
#include "spheres.glsl"

layout(std430, binding = 5) readonly buffer SphereOrder { uint sphere_order[]; };
#ifndef PROXY_RECTANGLE
layout(location = 3) uniform vec2 corners[CORNERS];  // around the unit circle
#endif

flat out uint sphere_index;
flat out vec4 origin;
flat out vec3 ahead;
flat out vec4 place;
#ifdef IN_PLANE
out vec2 in_plane;  // the place in the circle's plane
#endif

void main() {
  int drawn = gl_VertexID / CORNERS;
  int corner_index = gl_VertexID - drawn * CORNERS;
  sphere_index = sphere_order[drawn];
  vec4 sphere = spheres[sphere_index];
  float radius = sphere.w;
  SphereView v = sphere_view(sphere);
  origin = v.origin;
  ahead = v.ahead;
  place = v.place;
  // The nearest that anything of it can be: what is written is never in front of this.
  float near = float(view_size.w);
  if (float(v.center.z) + radius < near) {
    // Behind the near plane.
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  float depth = near / max(float(v.center.z) - 1.000001 * radius, near);
  vec2 scale = 1.0 / eye_phase.zw;
#ifdef PROXY_RECTANGLE
  // The tangent lines of the projected sphere: (c.x - m c.z)^2 = r^2 (1 + m^2). With b = c.x c.z / a, a = c.z^2 - r^2:
  // m = c.x / c.z + (its difference from there), which is small and computed as such.
  vec2 side = vec2(corner_index == 0 || corner_index == 3 ? 1.0 : -1.0, corner_index < 2 ? 1.0 : -1.0);
  vec3 c = vec3(v.center);
  float a = (c.z - radius) * (c.z + radius);
  if (c.z <= radius * 1.0001) {
    gl_Position = vec4(side, 1.0, 1.0);
  } else {
    vec2 wide = radius * sqrt(c.xy * c.xy + a);
    vec2 base = vec2(v.center.xy / v.center.z);
    vec2 m = base + (base * (radius * radius) + side * wide) / a;
    gl_Position = vec4(m * scale, depth, 1.0);
  }
#else
  vec2 corner = corners[corner_index];
#ifdef IN_PLANE
  in_plane = corner;
#endif
  vec3 eye = -vec3(v.center) / radius;
  float eye2 = dot(eye, eye);
  if (eye2 < 1.03) {
    gl_Position = vec4(corner * 2.0, 1.0, 1.0);
#ifdef IN_PLANE
    in_plane = vec2(0.0);
#endif
    return;
  }
  dvec3 at = v.center + dvec3(sphere_circle(corner.x, corner.y, eye * inversesqrt(eye2), sqrt(eye2)) * radius);
  float w = float(at.z);
  gl_Position = vec4(float(at.x) * scale.x, float(at.y) * scale.y, depth * w, w);
#endif
}
