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

FN bool cone_near(IN(vec3) eye, IN(ObjectShape) s) {
  return abs(eye.z) < 1.02 && sqrt(eye.x * eye.x + eye.y * eye.y) < s.p0 + s.p1 * eye.z + 0.02;
}

// The side's tangent planes through the eye touch at the angles `middle` +- `half_`: cos(half_) = w / rho. What is seen of
// the solid ends there, and at an arc of either end between them: at the far one of an end that is seen from outside, else
// at the near one. The polygon's other lines are tangents of these arcs, in even steps.
// corner.y: at least 5. An eye over an end within the side's cone sees this end alone; one beyond the apex the wider.
FN vec3 cone_outline(IN(vec3) corner, IN(vec3) eye, IN(ObjectShape) s) {
  const float kTurn = float(6.28318530717958648);
  float w = s.p0 + s.p1 * eye.z;
  float rho = sqrt(eye.x * eye.x + eye.y * eye.y);
  float over = eye.z < 0.0 ? float(-1.0) : float(1.0);
  float n = corner.y;
  // The first `count` corners are on the end z = `end`, on the arc `from` to from + arc; the others on the other.
  float end = over;
  float count = n;
  float from = float(0.0);
  float arc = kTurn;
  if (rho > abs(w)) {
    float middle = atan(eye.y, eye.x);
    float half_ = acos(w / rho);
    float near_arc = 2.0 * half_;
    bool outside = abs(eye.z) > 1.0;
    arc = outside ? kTurn - near_arc : near_arc;
    // An apex takes one.
    count = clamp(floor(n * arc / (arc + near_arc) + 0.5), float(1.0), n - 1.0);
    if (s.p0 + s.p1 * end == 0.0) count = float(1.0);
    if (s.p0 - s.p1 * end == 0.0) count = n - 1.0;
    from = outside ? middle + half_ : middle - half_;
    if (corner.x >= count) {
      // On from where the first arc ends, around the near one; back where the first was the near one, too.
      end = -end;
      from = outside ? middle - half_ : middle + half_;
      arc = outside ? near_arc : -near_arc;
    }
  } else if (w <= 0.0) {
    end = s.p1 < 0.0 ? float(-1.0) : float(1.0);
  }
  bool later = corner.x >= count;
  float step_ = arc / (later ? n - count : count);
  float turn = from + step_ * (corner.x - (later ? count : float(0.0)) + 0.5);
  float radius = (s.p0 + s.p1 * end) / cos(0.5 * step_);
  return vec3(radius * cos(turn), radius * sin(turn), end);
}
