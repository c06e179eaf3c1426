// Lit as the ray-cast spheres are, but not by what only their rays know: nothing is mirrored sharply or seen through.
#include "frame.glsl"
#include "objects.glsl"

in vec3 normal;
in vec3 position;
flat in vec3 tint;
layout(location = 0) out vec4 out_color;

struct ObjectSite {
  vec3 normal;
};
vec3 object_normal(ObjectSite site, vec3 offset) { return site.normal; }
vec2 object_uv(ObjectSite site, vec3 offset) { return vec2(0.0); }
bool object_exit(ObjectSite site, vec3 direction, out ObjectSite next) {
  next = site;
  return false;
}

#define MATERIALS 2  // Phong
#include "object_light.glsl"

void main() {
  ObjectPoint p;
  p.position = position;
  p.normal = normalize(normal);
  p.tint = tint;
  out_color = vec4(frame_tone(object_light(p, object_materials[0], ObjectSite(p.normal))), 1.0);
}
