// The unit sphere; under an affine map every ellipsoid. No numbers.

FN float sphere_value(IN(vec3) p, IN(ObjectShape) s) { return dot(p, p) - 1.0; }

// Half the chord's length squared in units of the sphere's radius, from the ray's point nearest to the centre, which
// loses no digits at the silhouette; < 0: the ray passes.
FN float sphere_chord2(IN(vec3) o, IN(vec3) d) {
  vec3 nearest = o - d * (dot(o, d) / dot(d, d));
  return 1.0 - dot(nearest, nearest);
}

FN ObjectHits sphere_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  float half2 = sphere_chord2(o, d);
  if (!(half2 >= 0.0)) return object_none();
  float a = dot(d, d);
  vec2 k = object_roots(a, dot(o, d), at_o, sqrt(half2 * a));
  return object_add(object_add(object_none(), k.x, 0), k.y, 0);
}

FN vec3 sphere_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return p; }

// Longitude from x, latitude from the south pole.
FN vec2 sphere_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  return vec2(object_turn(p.y, p.x), 0.5 + atan(p.z, sqrt(p.x * p.x + p.y * p.y)) * 0.31830989);
}
