// The ground: a triangle mesh relative to its tile's origin.
#include "frame.glsl"

layout(location = 0) in vec3 in_position;  // relative to the tile's origin, m
layout(location = 1) in vec3 in_normal;
layout(location = 0) uniform vec3 tile;    // the tile's origin relative to the eye, m

out vec3 relative;
out vec3 ground_normal;

void main() {
  relative = in_position + tile;
  ground_normal = in_normal;
  gl_Position = clip_from_relative * vec4(relative, 1.0);
}
