// The torus around the z axis: the circle of radius 1, tube of radius p0 < 1.
//
// With unit d and o the ray's point nearest to the centre, the quartic is
//   (k^2 + g)^2 - 4 ((d.x^2 + d.y^2) k^2 + 2 (o.x d.x + o.y d.y) k + o.x^2 + o.y^2),  g = o^2 + 1 - p0^2,
// and has its extremes where k^3 + (g - 2 d.x^2 - 2 d.y^2) k - 2 (o.x d.x + o.y d.y) = 0, a cubic in its short form. Between
// them it is monotone, so a sign that changes brackets exactly one root, and no root is without one: no hole, at worst
// a pair of roots nearer to each other than the digits. Signs and roots are not taken from the quartic, which loses
// digits, but from D(p) = (sqrt(x^2 + y^2) - 1)^2 + z^2 - p0^2, which is zero and negative where it is. An extreme that is
// off by e changes D there by e^2 only.

FN float torus_value(IN(vec3) p, IN(ObjectShape) s) {
  float out_ = sqrt(p.x * p.x + p.y * p.y) - 1.0;
  return out_ * out_ + p.z * p.z - s.p0 * s.p0;
}

// The root of k^3 + p k + q between the extremes or alone: `which` 0 to 2, ascending; with one root all are that one.
FN float torus_extreme(IN(float) p, IN(float) q, IN(int) which) {
  float third = p * 0.33333333333333333;
  float root = float(0.0);
  float inside = 0.25 * q * q + third * third * third;
  if (inside < 0.0) {
    float size = sqrt(-third);
    float angle = acos(clamp(-0.5 * q / (size * size * size), float(-1.0), float(1.0))) * 0.33333333333333333;
    // 2 pi / 3 on: the least; without: the greatest.
    root = 2.0 * size * cos(angle + (which == 0 ? 2.0943951023931955 : (which == 1 ? 4.1887902047863910 : 0.0)));
  } else {
    float cube = 0.5 * abs(q) + sqrt(inside);
    float one = pow(max(cube, float(1e-30)), float(0.33333333333333333));
    root = one - third / one;
    if (q > 0.0) root = -root;
  }
  float slope = 3.0 * root * root + p;
  return abs(slope) < 1e-3 ? root : root - (root * (root * root + p) + q) / slope;
}

// The root of D along a ray of unit speed between two places of unlike signs: Newton's method, and halving where that
// leaves the bracket.
FN float torus_root(IN(float) k_low, IN(float) k_high, IN(bool) entering, IN(vec3) o, IN(vec3) d, IN(ObjectShape) s) {
  float low = k_low;
  float high = k_high;
  float k = 0.5 * (low + high);
  for (int i = 0; i < 48; ++i) {
    vec3 p = o + d * k;
    float around = sqrt(p.x * p.x + p.y * p.y);
    float out_ = around - 1.0;
    float value = out_ * out_ + p.z * p.z - s.p0 * s.p0;
    if ((value > 0.0) == entering) {
      low = k;
    } else {
      high = k;
    }
    float slope = 2.0 * (out_ * (p.x * d.x + p.y * d.y) / max(around, float(1e-20)) + p.z * d.z);
    float next = k - value / (slope == 0.0 ? float(1e-20) : slope);
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    if (abs(next - k) <= 1e-7 * abs(k) + 1e-12) return next;
    k = next;
  }
  return k;
}

// A root counted from the ray's own origin: near that, the digits that the way by the middle lost.
FN float torus_polish(IN(float) k, IN(vec3) o, IN(vec3) d, IN(ObjectShape) s) {
  vec3 p = o + d * k;
  float around = sqrt(p.x * p.x + p.y * p.y);
  float out_ = around - 1.0;
  float slope = 2.0 * (out_ * (p.x * d.x + p.y * d.y) / max(around, float(1e-20)) + p.z * d.z);
  float step = (out_ * out_ + p.z * p.z - s.p0 * s.p0) / (slope == 0.0 ? float(1.0) : slope);
  // At a double root the step says nothing.
  return abs(step) * length(d) < 1e-5 ? k - step : k;
}

FN ObjectHits torus_hits(IN(vec3) o, IN(vec3) d, IN(float) at_o, IN(ObjectShape) s) {
  ObjectHits h = object_none();
  float speed = length(d);
  vec3 e = d * (1.0 / speed);
  float shift = -dot(o, e);
  vec3 near = o + e * shift;
  // A sphere around it, with room so that the torus is not touched at its ends.
  float radius = 1.01 * (1.0 + s.p0);
  float reach2 = radius * radius - dot(near, near);
  if (!(reach2 > 0.0)) return h;
  float reach = sqrt(reach2);
  float flat_ = e.x * e.x + e.y * e.y;
  float lean = near.x * e.x + near.y * e.y;
  float p = dot(near, near) + 1.0 - s.p0 * s.p0 - 2.0 * flat_;
  float from = -reach;
  bool inside = false;
  for (int i = 0; i < 4; ++i) {
    float to = i == 3 ? reach : clamp(torus_extreme(p, -2.0 * lean, i), from, reach);
    bool then = i < 3 && torus_value(near + e * to, s) < 0.0;
    if (then != inside) h = object_add(h, torus_polish((torus_root(from, to, then, near, e, s) + shift) / speed, o, d, s), 0);
    inside = then;
    from = to;
  }
  return h;
}

FN vec3 torus_normal(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  float part = 1.0 - 1.0 / max(sqrt(p.x * p.x + p.y * p.y), float(1e-20));
  return vec3(p.x * part, p.y * part, p.z);
}

// Around the axis, and around the tube from its outermost line.
FN vec2 torus_uv(IN(vec3) p, IN(int) face, IN(ObjectShape) s) {
  return vec2(object_turn(p.y, p.x), object_turn(p.z, sqrt(p.x * p.x + p.y * p.y) - 1.0));
}

FN bool torus_near(IN(vec3) eye, IN(ObjectShape) s) { return dot(eye, eye) < 1.06 * (1.0 + s.p0) * (1.0 + s.p0); }

// How far out in the unit direction u, across the unit direction `toward` of an eye at distance `from`, the eye sees the
// torus, projected to the plane through the centre across `toward`: the greatest (u p) / (1 - toward p / from). Of all
// tangent planes u p + h (toward p) = const the one through the eye, by Dinkelbach's method: h from the point that is
// farthest along the plane's normal, again and again; it grows toward the solution, quadratically.
// 1e-5 more than found, for what the steps and the digits leave.
FN float torus_reach(IN(vec3) u, IN(vec3) toward, IN(float) from, IN(ObjectShape) s) {
  float reach = float(0.0);
  for (int i = 0; i < 5; ++i) {
    vec3 g = u + toward * (reach / from);
    float flat_ = 1.0 / max(sqrt(g.x * g.x + g.y * g.y), float(1e-20));
    vec3 p = g * (s.p0 / sqrt(dot(g, g))) + vec3(g.x * flat_, g.y * flat_, 0.0);
    reach = dot(u, p) / (1.0 - dot(toward, p) / from);
  }
  return reach * 1.00001;
}

// The outer polygon is of tangent planes through the eye, in the even steps of the ellipse that the ring about is seen as.
// The inner one is a circle's in z = 0: a ray that passes there at the distance 1 - x from the axis and climbs at the angle
// c is at least x sin(c) away from the ring's middle line, so with the least c of all rays within it passes the tube.
FN vec3 torus_outline(IN(vec3) corner, IN(vec3) eye, IN(ObjectShape) s) {
  float from = sqrt(dot(eye, eye));
  float rho = sqrt(eye.x * eye.x + eye.y * eye.y);
  vec3 toward = eye * (1.0 / from);
  vec3 a = rho > 1e-6 * from ? vec3(-eye.y / rho, eye.x / rho, 0.0) : vec3(1.0, 0.0, 0.0);
  vec3 b = vec3(-toward.z * a.y, toward.z * a.x, toward.x * a.y - toward.y * a.x);
  float step_ = 6.28318530717958648 / corner.y;
  float turn = corner.x * step_;
  if (corner.z == 0.0) {
    float climb = abs(eye.z) / sqrt(eye.z * eye.z + (rho + 1.0) * (rho + 1.0));
    float radius = max(1.0 - s.p0 / max(climb, float(1e-6)), float(0.0));
    float x = radius * cos(turn + 0.5 * step_);
    float y = (eye.z < 0.0 ? -radius : radius) * sin(turn + 0.5 * step_);
    return vec3(x * a.x - y * a.y, x * a.y + y * a.x, 0.0);
  }
  // Two neighbouring lines and where they meet.
  float wide = 1.0 / (1.0 + s.p0);
  float high = 1.0 / (abs(toward.z) + s.p0);
  vec2 one = normalize(vec2(wide * cos(turn), high * sin(turn)));
  vec2 two = normalize(vec2(wide * cos(turn + step_), high * sin(turn + step_)));
  float reach_one = torus_reach(a * one.x + b * one.y, toward, from, s);
  float reach_two = torus_reach(a * two.x + b * two.y, toward, from, s);
  float turned = 1.0 / (one.x * two.y - one.y * two.x);
  return a * ((reach_one * two.y - reach_two * one.y) * turned) + b * ((reach_two * one.x - reach_one * two.x) * turned);
}
