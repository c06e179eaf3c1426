// Any quadric in the box [-1, 1]^3: p0 xx, p1 yy, p2 zz, p3 xy, p4 xz, p5 yz, p6 x, p7 y, p8 z, p9 one, the greatest of
// about 1. With OBJECT_SOLID what is < 0 in the box, closed by its faces; else the surface, seen from both sides. With
// OBJECT_MEETS_ALL two planes, where a ray's discriminant is below 0 by rounding only.
// Faces: 0 the quadric; of the box 1 and 2 across x, 3 and 4 across y, 5 and 6 across z, low and high.

FN vec3 quadric_slope(IN(vec3) p, IN(ObjectShape) s) {
  return vec3(2.0 * s.p0 * p.x + s.p3 * p.y + s.p4 * p.z + s.p6, s.p3 * p.x + 2.0 * s.p1 * p.y + s.p5 * p.z + s.p7,
              s.p4 * p.x + s.p5 * p.y + 2.0 * s.p2 * p.z + s.p8);
}

FN float quadric_value(IN(vec3) p, IN(ObjectShape) s) {
  return p.x * (s.p0 * p.x + s.p3 * p.y + s.p4 * p.z + s.p6) + p.y * (s.p1 * p.y + s.p5 * p.z + s.p7) +
         p.z * (s.p2 * p.z + s.p8) + s.p9;
}

FN float quadric_form(IN(vec3) d, IN(ObjectShape) s) {
  return d.x * (s.p0 * d.x + s.p3 * d.y + s.p4 * d.z) + d.y * (s.p1 * d.y + s.p5 * d.z) + s.p2 * d.z * d.z;
}

// The ray's part within the box.
FN ObjectSpan quadric_box(IN(vec3) o, IN(vec3) d) {
  ObjectSpan box = object_span(-float(OBJECT_FAR), float(OBJECT_FAR), 0);
  box = object_cut(box, -1.0 - o.x, -d.x, 1);
  box = object_cut(box, o.x - 1.0, d.x, 2);
  box = object_cut(box, -1.0 - o.y, -d.y, 3);
  box = object_cut(box, o.y - 1.0, d.y, 4);
  box = object_cut(box, -1.0 - o.z, -d.z, 5);
  return object_cut(box, o.z - 1.0, d.z, 6);
}

// A root, made exact to the digits that the surface itself has.
FN float quadric_polish(IN(float) k, IN(vec3) o, IN(vec3) d, IN(ObjectShape) s) {
  vec3 p = o + d * k;
  float slope = dot(quadric_slope(p, s), d);
  float step = quadric_value(p, s) / (slope == 0.0 ? float(1.0) : slope);
  // At a double root the step says nothing.
  return abs(step) * length(d) < 1e-4 ? k - step : k;
}

FN ObjectHits quadric_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  ObjectHits none = object_none();
  ObjectSpan box = quadric_box(o, d);
  if (!(box.from < box.to)) return none;
  float a = quadric_form(d, s);
  float b = 0.5 * dot(quadric_slope(o, s), d);
  float discriminant = b * b - a * at_o;
  bool solid = (s.flags & OBJECT_SOLID) != 0;
  if ((s.flags & OBJECT_MEETS_ALL) != 0) discriminant = max(discriminant, float(0.0));
  if (!(discriminant >= 0.0)) return solid && a < 0.0 ? object_add_span(none, box) : none;
  vec2 k = object_roots(a, b, at_o, sqrt(discriminant));
  float k1 = abs(k.x) < 1e6 ? quadric_polish(k.x, o, d, s) : k.x;
  float k2 = abs(k.y) < 1e6 ? quadric_polish(k.y, o, d, s) : k.y;
  if (!solid) {
    ObjectHits h = none;
    if (k1 >= box.from && k1 <= box.to) h = object_add(h, k1, 0);
    if (k2 >= box.from && k2 <= box.to) h = object_add(h, k2, 0);
    return h;
  }
  if (a >= 0.0) return object_add_span(none, object_both(box, object_span(k1, k2, 0)));
  ObjectHits h = object_add_span(none, object_both(box, object_span(-float(OBJECT_FAR), k1, 0)));
  return object_add_span(h, object_both(box, object_span(k2, float(OBJECT_FAR), 0)));
}

FN vec3 quadric_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face == 0) return quadric_slope(p, s);
  float side = (face & 1) != 0 ? float(-1.0) : float(1.0);
  return face <= 2 ? vec3(side, 0.0, 0.0) : (face <= 4 ? vec3(0.0, side, 0.0) : vec3(0.0, 0.0, side));
}

FN vec2 quadric_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face == 1 || face == 2) return vec2(0.5 + 0.5 * p.y, 0.5 + 0.5 * p.z);
  if (face == 3 || face == 4) return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.z);
  return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y);
}

FN vec3 quadric_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
