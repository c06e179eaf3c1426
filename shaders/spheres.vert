// A polygon around the circle in which the eye sees a sphere, or the rectangle on the screen.
// NEAR: for near spheres.
#include "frame.glsl"
#include "spheres.glsl"

layout(location = 1) uniform uint first_drawn;  // slot
#ifdef PROXY_RECTANGLE
const int corner_count = 4;
#else
layout(location = 2) uniform int corner_count;
layout(location = 3) uniform vec2 corners[32];  // around the unit circle
#endif

// Rasterizers round corners to 1/256 of a pixel.
const float kProxyRoom_px = 0.01;

flat out uvec4 slot_and_lens;
flat out vec4 place;  // lengths in distances of the near plane
#ifdef NEAR
flat out float per_radius;  // likewise
#endif
#ifdef IN_PLANE
out vec2 in_plane;  // the place in the circle's plane
#endif

void main() {
  int drawn = gl_VertexID / corner_count;
  int corner_index = gl_VertexID - drawn * corner_count;
  uint sphere_slot = first_drawn + uint(drawn);
  slot_and_lens = uvec4(sphere_slot, floatBitsToUint(vec3(right.w, eye_phase.zw)));
  place = sphere_place(sphere_slot);
#ifdef NEAR
  float radius = uintBitsToFloat(sphere_look(sphere_slot).z);
  per_radius = forward.w / radius;
  vec3 c = -place.xyz * radius;
  vec2 slope = c.xy / c.z;
#else
  float radius = place.w;
  vec2 slope = place.xy * right.w - eye_phase.zw;
  vec3 c = vec3(slope, 1.0) * place.z;
  place.zw /= forward.w;
#endif
  float near = forward.w;
  vec2 scale = 1.0 / eye_phase.zw;
  // The nearest that anything of it can be: what is written is never in front of this.
  float depth = near / max(c.z - 1.00001 * radius, near);
#ifdef NEAR
#ifdef IN_PLANE
  in_plane = vec2(0.0);
#endif
  // Behind the near plane, or all over the screen.
  bool behind = c.z + radius < near;
  if (behind || dot(place.xyz, place.xyz) < 1.03 || c.z <= radius * 1.0001) {
    gl_Position = behind ? vec4(2.0, 2.0, 2.0, 1.0) : vec4(corners[corner_index] * 2.0, 1.0, 1.0);
    return;
  }
#endif
#ifdef PROXY_RECTANGLE
  // The tangent lines of the projected sphere: planes through the eye of normal (1, 0, -m) touch where (c.x - m c.z)^2 =
  // r^2 (1 + m^2). With a = c.z^2 - r^2: m = c.x / c.z + (its difference from there), which is small and computed as such.
  vec2 side = vec2(corner_index == 0 || corner_index == 3 ? 1.0 : -1.0, corner_index < 2 ? 1.0 : -1.0);
  float a = (c.z - radius) * (c.z + radius);
  vec2 wide = radius * sqrt(c.xy * c.xy + a);
  vec2 m = slope + (slope * (radius * radius) + side * wide) / a;
  gl_Position = vec4((m + side * (kProxyRoom_px * right.w)) * scale, depth, 1.0);
#else
  vec2 corner = corners[corner_index] * (1.0 + kProxyRoom_px * right.w * c.z / radius);
#ifdef IN_PLANE
  in_plane = corner;
#endif
  float from2 = dot(c, c);
  vec3 q = sphere_circle(corner.x, corner.y, -c * inversesqrt(from2), sqrt(from2) / radius) * radius;
  // Counted from the centre's slope, which is known from double and to a thousandth of a pixel.
  float w = c.z + q.z;
  gl_Position = vec4((slope * w + (q.xy - slope * q.z)) * scale, depth * w, w);
#endif
  // llvmpipe fills its last vector of vertices with what no one draws, and where one of those is not a number it clips all
  // triangles one by one.
  if (isnan(gl_Position.x)) gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
}
