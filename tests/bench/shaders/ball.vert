// A tessellated sphere, instanced: what the ray-cast ones are compared with.
#include "frame.glsl"

layout(location = 0) in vec3 in_corner;  // on the unit sphere
layout(location = 1) in vec4 in_sphere;  // centre relative to the eye, radius
layout(location = 2) in vec4 in_color;

out vec3 normal;
out vec3 position;
flat out vec3 tint;

void main() {
  normal = in_corner;
  position = in_sphere.xyz + in_corner * in_sphere.w;
  tint = in_color.rgb * in_color.rgb;
  gl_Position = clip_from_relative * vec4(position, 1.0);
}
