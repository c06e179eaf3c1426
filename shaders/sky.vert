// One triangle over the whole view, at infinity.
#include "frame.glsl"

out vec3 direction;

void main() {
  vec2 corner = vec2((gl_VertexID & 1) * 4 - 1, (gl_VertexID & 2) * 2 - 1);
  direction = frame_corner_ray(corner);
  gl_Position = vec4(corner, 0.0, 1.0);
}
