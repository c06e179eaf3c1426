// Lit as the ray-cast spheres are.
#include "frame.glsl"
#include "objects.glsl"
#include "object_light.glsl"

in vec3 normal;
in vec3 position;
flat in vec3 tint;
layout(location = 0) out vec4 out_color;

void main() {
  ObjectPoint p;
  p.position = position;
  p.normal = normalize(normal);
  p.uv = vec2(0.0);
  p.material = 0u;
  p.tint = tint;
  out_color = vec4(frame_tone(object_light(p)), 1.0);
}
