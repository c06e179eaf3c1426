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

// A vertex of the polygon around the circle in which an eye outside sees the sphere: the circle has the centre C2 and the
// radius r2 of the paper's algorithm 3, here for the unit sphere and an eye at distance `from` in the unit direction
// `toward`; (x, y) lies on a polygon around the unit circle.
FN vec3 sphere_circle(IN(float) x, IN(float) y, IN(vec3) toward, IN(float) from) {
  vec3 other = abs(toward.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  vec3 across = normalize(vec3(other.y * toward.z - other.z * toward.y, other.z * toward.x - other.x * toward.z,
                               other.x * toward.y - other.y * toward.x));
  vec3 up_ = vec3(toward.y * across.z - toward.z * across.y, toward.z * across.x - toward.x * across.z,
                  toward.x * across.y - toward.y * across.x);
  float part = 1.0 / from;
  float radius = sqrt(max(1.0 - part * part, float(0.0)));
  return toward * part + across * (x * radius) + up_ * (y * radius);
}
FN bool sphere_near(IN(vec3) eye, IN(ObjectShape) s) { return dot(eye, eye) < 1.03; }

FN vec3 sphere_outline(IN(vec3) corner, IN(vec3) eye, IN(ObjectShape) s) {
  vec2 q = object_around(corner);
  float from = sqrt(dot(eye, eye));
  return sphere_circle(q.x, q.y, eye * (1.0 / from), from);
}
