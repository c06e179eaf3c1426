// Parts of the plane z = 0, seen from both sides. Each has an inside in the plane's (x, y), which may also be tested where
// the rasterizer interpolates them (the paper's texture space).
// disc: x^2 + y^2 <= 1, every ellipse under an affine map. conic: p0 x^2 + p1 y^2 + p2 x y + p3 x + p4 y + p5 <= 0 in
// [-1, 1]^2. triangle: x, y >= -1/3 and x + y <= 1/3. rhomb: [-1, 1]^2, every parallelogram.

FN float disc_inside(IN(vec2) p, IN(ObjectShape) s) { return p.x * p.x + p.y * p.y - 1.0; }

FN float conic_inside(IN(vec2) p, IN(ObjectShape) s) {
  float curve = p.x * (s.p0 * p.x + s.p2 * p.y + s.p3) + p.y * (s.p1 * p.y + s.p4) + s.p5;
  return max(curve, max(abs(p.x), abs(p.y)) - 1.0);
}

FN float triangle_inside(IN(vec2) p, IN(ObjectShape) s) {
  return max(max(-p.x, -p.y), p.x + p.y) - 0.33333333333333333;
}

FN float rhomb_inside(IN(vec2) p, IN(ObjectShape) s) { return max(abs(p.x), abs(p.y)) - 1.0; }

// Where the ray meets the plane; OBJECT_FAR where it runs along it.
FN float planar_meet(IN(vec3) o, IN(vec3) d) { return abs(d.z) < 1e-30 ? float(OBJECT_FAR) : -o.z / d.z; }

FN vec2 planar_at(IN(vec3) o, IN(vec3) d, IN(float) k) { return vec2(o.x + d.x * k, o.y + d.y * k); }

FN ObjectHits planar_hits(IN(float) k, IN(bool) inside) {
  if (!inside || !(abs(k) < OBJECT_FAR)) return object_none();
  return object_add(object_none(), k, 0);
}

FN ObjectHits disc_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  float k = planar_meet(o, d);
  return planar_hits(k, disc_inside(planar_at(o, d, k), s) <= 0.0);
}

FN ObjectHits conic_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  float k = planar_meet(o, d);
  return planar_hits(k, conic_inside(planar_at(o, d, k), s) <= 0.0);
}

FN ObjectHits triangle_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  float k = planar_meet(o, d);
  return planar_hits(k, triangle_inside(planar_at(o, d, k), s) <= 0.0);
}

FN ObjectHits rhomb_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  float k = planar_meet(o, d);
  return planar_hits(k, rhomb_inside(planar_at(o, d, k), s) <= 0.0);
}

FN float disc_value(IN(vec3) p, IN(ObjectShape) s) { return abs(p.z); }
FN float conic_value(IN(vec3) p, IN(ObjectShape) s) { return abs(p.z); }
FN float triangle_value(IN(vec3) p, IN(ObjectShape) s) { return abs(p.z); }
FN float rhomb_value(IN(vec3) p, IN(ObjectShape) s) { return abs(p.z); }

FN vec3 disc_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec3(0.0, 0.0, 1.0); }
FN vec3 conic_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec3(0.0, 0.0, 1.0); }
FN vec3 triangle_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec3(0.0, 0.0, 1.0); }
FN vec3 rhomb_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec3(0.0, 0.0, 1.0); }

FN vec2 disc_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y); }
FN vec2 conic_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y); }
// The barycentric coordinates of the second and the third corner.
FN vec2 triangle_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  return vec2(p.x + 0.33333333333333333, p.y + 0.33333333333333333);
}
FN vec2 rhomb_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y); }

FN vec3 disc_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
FN vec3 conic_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
FN vec3 triangle_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
FN vec3 rhomb_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
