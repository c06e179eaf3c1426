// Between z = -1 and z = 1, around that axis, within the radius p0 + p1 z >= 0: cylinders (p1 = 0), cones, frusta, closed
// by their ends. Faces: 0 the side, 1 the end at z = -1, 2 that at z = 1.

FN float cone_value(IN(vec3) p, IN(ObjectShape) s) {
  float radius = s.p0 + s.p1 * p.z;
  return p.x * p.x + p.y * p.y - radius * radius;
}

FN ObjectHits cone_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  ObjectHits none = object_none();
  ObjectSpan slab = object_span(-float(OBJECT_FAR), float(OBJECT_FAR), 0);
  slab = object_cut(slab, -1.0 - o.z, -d.z, 1);
  slab = object_cut(slab, o.z - 1.0, d.z, 2);
  // The radius along the ray is w + k dw: one more coordinate of the ray, whose square counts as negative.
  float w = s.p0 + s.p1 * o.z;
  float dw = s.p1 * d.z;
  float a = d.x * d.x + d.y * d.y - dw * dw;
  float b = o.x * d.x + o.y * d.y - w * dw;
  // b^2 - a c by Lagrange's identity: squares of areas, without the cancellation.
  float xy = o.x * d.y - o.y * d.x;
  float xw = o.x * dw - w * d.x;
  float yw = o.y * dw - w * d.y;
  float discriminant = xw * xw + yw * yw - xy * xy;
  if (a < 0.0) discriminant = max(discriminant, float(0.0));
  if (!(discriminant >= 0.0)) return none;
  vec2 k = object_roots(a, b, at_o, sqrt(discriminant));
  if (a >= 0.0) return object_add_span(none, object_both(slab, object_span(k.x, k.y, 0)));
  // Steeper than the side: inside from there on where the radius grows, and before where it shrinks.
  if (dw > 0.0) return object_add_span(none, object_both(slab, object_span(k.y, float(OBJECT_FAR), 0)));
  return object_add_span(none, object_both(slab, object_span(-float(OBJECT_FAR), k.x, 0)));
}

FN vec3 cone_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face != 0) return vec3(0.0, 0.0, face == 1 ? float(-1.0) : float(1.0));
  return vec3(p.x, p.y, -s.p1 * (s.p0 + s.p1 * p.z));
}

// Around and up; on the ends as seen from above.
FN vec2 cone_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face != 0) return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y);
  return vec2(object_turn(p.y, p.x), 0.5 + 0.5 * p.z);
}

// A vertex of the prism around the unit cylinder, at this solid.
FN vec3 cone_proxy(IN(vec3) q, IN(ObjectShape) s) {
  float radius = s.p0 + s.p1 * q.z;
  return vec3(q.x * radius, q.y * radius, q.z);
}
