// A tessellated road: positions and (s, t) of its vertices, both edges moved outward for their antialiasing as
// road.vert moves its proxy's. What road.frag reads besides is constant or unused.
#include "frame.glsl"

layout(location = 0) in vec3 in_position;  // relative to its copy's origin, m
layout(location = 1) in vec2 in_st;
layout(location = 2) in vec4 in_frame;     // left (unit, horizontal), grade, outward: 1 on the left edge, -1 on the right
layout(location = 3) in vec4 in_copy;      // origin of the copy, ENU, and its road's index

flat out vec4 shape;
flat out vec4 arc;
flat out vec4 height;
flat out uvec4 ids;
flat out vec2 axis;
out vec3 relative;
out vec2 chord_point;
out vec3 linear;
out vec2 st;
out vec3 left_and_grade;

void main() {
  vec3 start = (in_copy.xyz - eye_high.xyz) - eye_low.xyz + in_position;
  float outward = in_frame.w * clamp(2.0 * right.w * length(start), 0.02, 2.0);
  relative = start + vec3(in_frame.xy * outward, 0.0);
  st = vec2(in_st.x, in_st.y + outward);
  left_and_grade = in_frame.xyz;
  ids = uvec4(uint(in_copy.w), 0u, 0u, 0u);
  shape = arc = height = vec4(0.0);
  axis = chord_point = vec2(0.0);
  linear = vec3(0.0);
  gl_Position = clip_from_relative * vec4(relative, 1.0);
  gl_ClipDistance[0] = up.w - dot(relative, forward.xyz);
}
