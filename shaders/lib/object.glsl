// What all ray-cast objects share: rays in the object's own frame, what they meet, intervals of solids.
//
// An object is a shape of about unit size around the origin (ObjectShape) under an affine map. Its ray is o + k d in that
// frame; d need not be unit, so k is the same number in the world. For the digits of single precision o is a point of the
// ray near the object, or the eye itself where the eye is near. A shape NAME has a file NAME.glsl (or one with its kin) of
//   float NAME_value(p, shape)             < 0 inside of a solid, 0 on the surface
//   ObjectHits NAME_hits(o, d, at_o, shape)  at_o: NAME_value(o), which at the eye is known in double
//   vec3 NAME_normal(p, face, shape)       outward, not unit; a covector of the frame
//   vec2 NAME_uv(p, face, shape)           in [0, 1]
// and what covers it on the screen, either, of a hull or a flat shape,
//   vec3 NAME_proxy(q, shape)              a corner of the mesh that its row of the table names, in the shape's frame
// or, of tangent planes through the eye, the same of any convex shape that the eye is outside of,
//   bool NAME_near(eye, shape)             whether the eye is in it, or so near that digits do not tell
//   vec3 NAME_outline(corner, eye, shape)  corner.x of corner.y corners of a polygon around what the eye sees, in their
//                                          order; of a ring corner.z is 1, and 0 on the polygon within its hole
// Source: S. M. Ranta, J. M. Singh, P. J. Narayanan, GPU Objects, 2006, algorithm 1.

#define OBJECT_FAR 1e30
#define OBJECT_SOLID 1
#define OBJECT_PLANES 2

// The numbers that a shape has in its frame, by kind: each NAME.glsl says which.
struct ObjectShape {
  float p0;
  float p1;
  float p2;
  float p3;
  float p4;
  float p5;
  float p6;
  float p7;
  float p8;
  float p9;
  int flags;  // OBJECT_SOLID, OBJECT_PLANES
};

FN ObjectShape object_solid() {
  ObjectShape s;
  s.p0 = float(0.0);
  s.p1 = float(0.0);
  s.p2 = float(0.0);
  s.p3 = float(0.0);
  s.p4 = float(0.0);
  s.p5 = float(0.0);
  s.p6 = float(0.0);
  s.p7 = float(0.0);
  s.p8 = float(0.0);
  s.p9 = float(0.0);
  s.flags = OBJECT_SOLID;
  return s;
}

// In the order of k. Of a solid the first enters it, the second leaves it, and so on. face: the shape's own numbers.
struct ObjectHits {
  int count;
  float k[4];
  int face[4];
};

FN ObjectHits object_none() {
  ObjectHits h;
  h.count = 0;
  for (int i = 0; i < 4; ++i) {
    h.k[i] = float(OBJECT_FAR);
    h.face[i] = 0;
  }
  return h;
}

FN ObjectHits object_add(IN(ObjectHits) hits, IN(float) k, IN(int) face) {
  ObjectHits h = hits;
  h.k[h.count] = k;
  h.face[h.count] = face;
  h.count += 1;
  return h;
}

// The first hit at k >= least, or -1.
FN int object_first(IN(ObjectHits) h, IN(float) least) {
  for (int i = 0; i < h.count; ++i) {
    if (h.k[i] >= least) return i;
  }
  return -1;
}

// A part of the ray; empty where from > to.
struct ObjectSpan {
  float from;
  float to;
  int face_from;
  int face_to;
};

FN ObjectSpan object_span(IN(float) from, IN(float) to, IN(int) face) {
  ObjectSpan s;
  s.from = from;
  s.to = to;
  s.face_from = face;
  s.face_to = face;
  return s;
}

// What of a span lies where value + k slope <= 0.
FN ObjectSpan object_cut(IN(ObjectSpan) span, IN(float) value, IN(float) slope, IN(int) face) {
  ObjectSpan s = span;
  if (abs(slope) < 1e-30) {
    if (value > 0.0) s.to = -float(OBJECT_FAR);
    return s;
  }
  float k = -value / slope;
  if (slope > 0.0) {
    if (k < s.to) {
      s.to = k;
      s.face_to = face;
    }
  } else if (k > s.from) {
    s.from = k;
    s.face_from = face;
  }
  return s;
}

FN ObjectSpan object_both(IN(ObjectSpan) a, IN(ObjectSpan) b) {
  ObjectSpan s = a;
  if (b.from > s.from) {
    s.from = b.from;
    s.face_from = b.face_from;
  }
  if (b.to < s.to) {
    s.to = b.to;
    s.face_to = b.face_to;
  }
  return s;
}

FN ObjectHits object_add_span(IN(ObjectHits) hits, IN(ObjectSpan) s) {
  if (!(s.from < s.to)) return hits;
  return object_add(object_add(hits, s.from, s.face_from), s.to, s.face_to);
}

// The roots of a k^2 + 2 b k + c = 0 in their order, neither by a difference that loses digits; root = sqrt(b^2 - a c).
FN vec2 object_roots(IN(float) a, IN(float) b, IN(float) c, IN(float) root) {
  float q = b > 0.0 ? -b - root : root - b;
  float one = q / (abs(a) < 1e-25 ? float(1e-25) : a);
  float two = q == 0.0 ? one : c / q;
  return vec2(min(one, two), max(one, two));
}

// Corner `corner.x` of a polygon of `corner.y` sides around the unit circle.
FN vec2 object_around(IN(vec3) corner) {
  float half_ = 3.14159265358979324 / corner.y;
  float turn = (2.0 * corner.x + 1.0) * half_;
  float out_ = 1.0 / cos(half_);
  return vec2(out_ * cos(turn), out_ * sin(turn));
}

// The angle of (x, y) as a part of a turn, in [0, 1).
FN float object_turn(IN(float) y, IN(float) x) {
  float turn = x == 0.0 && y == 0.0 ? float(0.0) : atan(y, x) * 0.15915494;
  return turn < 0.0 ? turn + 1.0 : turn;
}
