// One triangle over the whole view, at infinity.
#include "frame.glsl"

layout(location = 0) uniform vec2 view;  // tangents of half the field of view, horizontal and vertical
out vec3 direction;

void main() {
  vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
  direction = forward.xyz + right.xyz * (corner.x * view.x) + up.xyz * (corner.y * view.y);
  gl_Position = vec4(corner, 0.0, 1.0);
}
