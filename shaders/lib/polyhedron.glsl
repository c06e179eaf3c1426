// Convex solids as the ray's parts in their half spaces. No numbers.
// box: [-1, 1]^3, every parallelepiped under an affine map; faces 1 and 2 across x, 3 and 4 across y, 5 and 6 across z.
// tetra: x, y, z >= -1/4 and x + y + z <= 1/4, every tetrahedron; faces 1 to 3 across x, y, z, face 4 the slanted one.

FN float box_value(IN(vec3) p, IN(ObjectShape) s) { return max(max(abs(p.x), abs(p.y)), abs(p.z)) - 1.0; }

FN ObjectHits box_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  return object_add_span(object_none(), quadric_box(o, d));
}

FN vec3 box_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return quadric_normal(p, face, s); }

FN vec2 box_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) { return quadric_uv(p, face, s); }

FN float tetra_value(IN(vec3) p, IN(ObjectShape) s) {
  return max(max(-p.x, -p.y), max(-p.z, p.x + p.y + p.z)) - 0.25;
}

FN ObjectHits tetra_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  ObjectSpan span = object_span(-float(OBJECT_FAR), float(OBJECT_FAR), 0);
  span = object_cut(span, -0.25 - o.x, -d.x, 1);
  span = object_cut(span, -0.25 - o.y, -d.y, 2);
  span = object_cut(span, -0.25 - o.z, -d.z, 3);
  span = object_cut(span, o.x + o.y + o.z - 0.25, d.x + d.y + d.z, 4);
  return object_add_span(object_none(), span);
}

FN vec3 tetra_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  if (face == 4) return vec3(1.0, 1.0, 1.0);
  return face == 1 ? vec3(-1.0, 0.0, 0.0) : (face == 2 ? vec3(0.0, -1.0, 0.0) : vec3(0.0, 0.0, -1.0));
}

FN vec2 tetra_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  return face == 1 ? vec2(p.y + 0.25, p.z + 0.25) : vec2(p.x + 0.25, (face == 2 ? p.z : p.y) + 0.25);
}

FN vec3 box_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
FN vec3 tetra_proxy(IN(vec3) q, IN(ObjectShape) s) { return q; }
