// The light that a point of an object sends to the eye.
struct ObjectPoint {
  vec3 position;  // relative to the eye, ENU, m
  vec3 normal;    // unit, to the eye
  vec2 uv;
  uint material;
  vec3 tint;      // linear, times the material's base colour
};

vec3 object_light(ObjectPoint p) {
  ObjectMaterial m = object_materials[p.material];
  return frame_radiance(m.base.rgb * p.tint, frame_light(p.normal, p.position));
}
