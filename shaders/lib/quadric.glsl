// Any quadric in the box [-1, 1]^3: p0 xx, p1 yy, p2 zz, p3 xy, p4 xz, p5 yz, p6 x, p7 y, p8 z, p9 one, the greatest of
// about 1. With OBJECT_SOLID what is < 0 in the box, closed by its faces; else the surface, seen from both sides. With
// OBJECT_PLANES the product of two planes, p0 x + p1 y + p2 z + p3 and p4 x + p5 y + p6 z + p7, whose roots are exact
// where they cross, unlike those of the product.
// Faces: 0 the quadric; of the box 1 and 2 across x, 3 and 4 across y, 5 and 6 across z, low and high; 7 and 8 the planes.

FN vec3 quadric_slope(IN(vec3) p, IN(ObjectShape) s) {
  return vec3(2.0 * s.p0 * p.x + s.p3 * p.y + s.p4 * p.z + s.p6, s.p3 * p.x + 2.0 * s.p1 * p.y + s.p5 * p.z + s.p7,
              s.p4 * p.x + s.p5 * p.y + 2.0 * s.p2 * p.z + s.p8);
}

FN float quadric_plane(IN(vec3) p, IN(int) which, IN(ObjectShape) s) {
  return which == 7 ? s.p0 * p.x + s.p1 * p.y + s.p2 * p.z + s.p3 : s.p4 * p.x + s.p5 * p.y + s.p6 * p.z + s.p7;
}

FN float quadric_value(IN(vec3) p, IN(ObjectShape) s) {
  if ((s.flags & OBJECT_PLANES) != 0) return quadric_plane(p, 7, s) * quadric_plane(p, 8, s);
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

// The surface alone, or what is inside: between the roots where `between`, else around them.
FN ObjectHits quadric_in_box(IN(vec2) k, IN(int) face_x, IN(int) face_y, IN(bool) between, IN(ObjectSpan) box,
                             IN(ObjectShape) s) {
  ObjectHits h = object_none();
  if ((s.flags & OBJECT_SOLID) == 0) {
    if (k.x >= box.from && k.x <= box.to) h = object_add(h, k.x, face_x);
    if (k.y >= box.from && k.y <= box.to) h = object_add(h, k.y, face_y);
    return h;
  }
  ObjectSpan first = object_span(between ? k.x : -float(OBJECT_FAR), between ? k.y : k.x, face_x);
  if (between) first.face_to = face_y;
  h = object_add_span(h, object_both(box, first));
  if (between) return h;
  return object_add_span(h, object_both(box, object_span(k.y, float(OBJECT_FAR), face_y)));
}

FN ObjectHits quadric_planes_hits(IN(vec3) o, IN(vec3) d, IN(ObjectSpan) box, IN(ObjectShape) s) {
  float v7 = quadric_plane(o, 7, s);
  float v8 = quadric_plane(o, 8, s);
  float d7 = s.p0 * d.x + s.p1 * d.y + s.p2 * d.z;
  float d8 = s.p4 * d.x + s.p5 * d.y + s.p6 * d.z;
  float k7 = -v7 / (abs(d7) < 1e-25 ? float(1e-25) : d7);
  float k8 = -v8 / (abs(d8) < 1e-25 ? float(1e-25) : d8);
  bool between = (d7 >= 0.0) == (d8 >= 0.0);
  if (k7 <= k8) return quadric_in_box(vec2(k7, k8), 7, 8, between, box, s);
  return quadric_in_box(vec2(k8, k7), 8, 7, between, box, s);
}

FN ObjectHits quadric_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  ObjectHits none = object_none();
  ObjectSpan box = quadric_box(o, d);
  if (!(box.from < box.to)) return none;
  if ((s.flags & OBJECT_PLANES) != 0) return quadric_planes_hits(o, d, box, s);
  float a = quadric_form(d, s);
  float b = 0.5 * dot(quadric_slope(o, s), d);
  float discriminant = b * b - a * at_o;
  bool solid = (s.flags & OBJECT_SOLID) != 0;
  if (!(discriminant >= 0.0)) return solid && a < 0.0 ? object_add_span(none, box) : none;
  vec2 k = object_roots(a, b, at_o, sqrt(discriminant));
  float k1 = abs(k.x) < 1e6 ? quadric_polish(k.x, o, d, s) : k.x;
  float k2 = abs(k.y) < 1e6 ? quadric_polish(k.y, o, d, s) : k.y;
  return quadric_in_box(vec2(k1, k2), 0, 0, a >= 0.0, box, s);
}

// The last k of quadric_hits, or -OBJECT_FAR, without a list of them: for rays that only ask what is in their way.
FN float quadric_last(IN(vec3) o, IN(vec3) d, IN(ObjectShape) s) {
  ObjectSpan box = quadric_box(o, d);
  if (!(box.from < box.to)) return -float(OBJECT_FAR);
  bool solid = (s.flags & OBJECT_SOLID) != 0;
  float a = quadric_form(d, s);
  float b = 0.5 * dot(quadric_slope(o, s), d);
  float at_o = quadric_value(o, s);
  float discriminant = b * b - a * at_o;
  if (!(discriminant >= 0.0)) return solid && a < 0.0 ? box.to : -float(OBJECT_FAR);
  vec2 k = object_roots(a, b, at_o, sqrt(discriminant));
  if (solid && a >= 0.0) {
    float to = min(box.to, k.y);
    return to > max(box.from, k.x) ? to : -float(OBJECT_FAR);
  }
  // Inside of a solid around the roots; an open one is the roots.
  if (solid && box.to > k.y) return box.to;
  if (k.y >= box.from && k.y <= box.to) return k.y;
  if (solid && box.to < k.x) return box.to;
  return k.x >= box.from && k.x <= box.to ? k.x : -float(OBJECT_FAR);
}

FN vec3 quadric_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face == 0) return quadric_slope(p, s);
  // Outward of the product's inside: along the plane's normal where the other plane is above 0.
  if (face == 7) return vec3(s.p0, s.p1, s.p2) * (quadric_plane(p, 8, s) < 0.0 ? float(-1.0) : float(1.0));
  if (face == 8) return vec3(s.p4, s.p5, s.p6) * (quadric_plane(p, 7, s) < 0.0 ? float(-1.0) : float(1.0));
  float side = (face & 1) != 0 ? float(-1.0) : float(1.0);
  return face <= 2 ? vec3(side, 0.0, 0.0) : (face <= 4 ? vec3(0.0, side, 0.0) : vec3(0.0, 0.0, side));
}

FN vec2 quadric_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face == 1 || face == 2) return vec2(0.5 + 0.5 * p.y, 0.5 + 0.5 * p.z);
  if (face == 3 || face == 4) return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.z);
  return vec2(0.5 + 0.5 * p.x, 0.5 + 0.5 * p.y);
}

FN vec3 quadric_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
