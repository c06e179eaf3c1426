// Profiles swept along the road's curve, and rays cast at them: pipes, cables, guard rails on posts, tunnels. A piece
// is one profile over a part of one segment (road.glsl) over which the height of its axis is a cubic of s.
//
// Cross sections are vertical planes perpendicular to the horizontal tangent of the centre line. In one, n is the
// horizontal distance from the axis (left positive) and h the height above it; the axis itself stands n0 + n1 s left of
// the centre line, at the height z(s). A profile is a function D(n, h) that is at most the distance from it and changes
// by at most 1 per metre (negative inside).
//
// Steps. Along a ray of unit speed, n and h move with the speeds dn, dh, and these change by at most bend_n, bend_h per
// metre and horizontal speed squared, so D(k + e) >= D(k) - |(dn, dh)| e - bend e^2 / 2: a step to where the right side
// is 0 cannot pass the profile. A ray along a rail is thus stepped by what it has left across the rail, not along it.
// Where D is convex its own slope may stand for |(dn, dh)|, and a set that is an intersection is not entered before
// the last of its parts: sweep_time of each, and their maximum.
// Frame: metres along the chord (x), to its left (y) and up (z) from the start anchor.

#define SWEEP_TUBE 0
#define SWEEP_BEAM 1
#define SWEEP_LINING 2
#define SWEEP_HEAD_WALL 3
#define SWEEP_FAR 1e6
#define SWEEP_STEPS 96
#define SWEEP_WALKWAY 0.12

struct SweepPath {
  float chord;  // L, m
  float a;      // slopes
  float b;
  float arc;    // arc length of the segment, m
  float c0;     // inner coefficients of road_arc
  float c1;
  float z0;     // the axis above the start anchor: z0 + z1 s + z2 s^2 + z3 s^3
  float z1;
  float z2;
  float z3;
  float n0;     // the axis left of the centre line: n0 + n1 s
  float n1;
  float bend_n;  // greatest |d2n/dk2|, |d2h/dk2|, |d2s/dk2| along a ray whose horizontal speed is 1
  float bend_h;
  float bend_s;
};

// By kind. TUBE: radius. BEAM: half height, depth, half thickness, +1 where the ridges face left and -1 where right;
// the back is at n = 0. LINING and HEAD_WALL, around a vault: its half width, height of the arch's centre, radius of the
// arch; then LINING: thickness, depth of the foot below h = 0, half width between the walkways along the walls;
// HEAD_WALL: half width, depth of the foot, top.
struct SweepProfile {
  int kind;
  float p0;
  float p1;
  float p2;
  float p3;
  float p4;
  float p5;
};

// Posts or poles at s = first + i spacing, i < count (0: none), upright prisms around n on the axis' scale.
struct SweepPosts {
  float first;
  float spacing;
  float count;
  float half_s;  // half sides along the road and across; half_s = -half_n: round, of radius half_n
  float half_n;
  float n;
  float low;     // h of foot and top
  float high;
};

struct SweepPiece {
  SweepPath path;
  SweepProfile profile;
  SweepPosts posts;
  float u0;  // ends
  float u1;
  float end0;  // 1 where the profile ends there, 0 where a neighbour goes on
  float end1;
  float y0;  // box in the frame above, m
  float y1;
  float z0;
  float z1;
};

// The profiles ------------------------------------------------------------------------------------------------------

// The hollow of a tunnel, open below: between walls at +-half, under an arch of the given radius around (0, centre).
FN float sweep_vault(IN(float) n, IN(float) h, IN(float) half_width, IN(float) centre, IN(float) radius) {
  float rise = max(h - centre, float(0.0));
  return max(abs(n) - half_width, sqrt(n * n + rise * rise) - radius);
}

// Squared distance of (px, py) from the line between (ax, ay) and (bx, by).
FN float sweep_line2(IN(float) px, IN(float) py, IN(float) ax, IN(float) ay, IN(float) bx, IN(float) by) {
  float dx = bx - ax;
  float dy = by - ay;
  float k = clamp(((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy), float(0.0), float(1.0));
  float ex = px - ax - k * dx;
  float ey = py - ay - k * dy;
  return ex * ex + ey * ey;
}

// Corners of the upper half of the W: depth as a part of the beam's, height as a part of the half height.
FN vec2 sweep_beam_corner(IN(int) i) {
  if (i == 0) return vec2(0.0, 0.0);
  if (i == 1) return vec2(0.0, 0.14);
  if (i == 2) return vec2(1.0, 0.40);
  if (i == 3) return vec2(1.0, 0.62);
  if (i == 4) return vec2(0.14, 0.90);
  return vec2(0.0, 1.0);
}

// The sheet of a W beam: five straight strips each half, mirrored at h = 0.
FN float sweep_beam(IN(float) n, IN(float) h, IN(float) half_height, IN(float) depth, IN(float) half_thickness,
                    IN(float) facing) {
  float m = n * facing;
  float q = abs(h);
  float least = float(SWEEP_FAR);
  vec2 from = vec2(0.0, 0.0);
  for (int i = 1; i < 6; ++i) {
    vec2 to = sweep_beam_corner(i);
    least = min(least, sweep_line2(m, q, from.x * depth, from.y * half_height, to.x * depth, to.y * half_height));
    from = to;
  }
  return sqrt(least) - half_thickness;
}

// D(n, h).
FN float sweep_distance(IN(float) n, IN(float) h, IN(SweepProfile) p) {
  if (p.kind == SWEEP_TUBE) return sqrt(n * n + h * h) - p.p0;
  if (p.kind == SWEEP_BEAM) return sweep_beam(n, h, p.p0, p.p1, p.p2, p.p3);
  float hollow = sweep_vault(n, h, p.p0, p.p1, p.p2);
  float outside = float(0.0);
  if (p.kind == SWEEP_LINING) {
    outside = max(sweep_vault(n, h, p.p0 + p.p3, p.p1, p.p2 + p.p3), -p.p4 - h);
    hollow = max(hollow, -max(p.p5 - abs(n), h - SWEEP_WALKWAY));
  } else {
    outside = max(abs(n) - p.p3, max(h - p.p5, -p.p4 - h));
  }
  return max(outside, -hollow);
}

// Greatest en n + eh h over the profile, (en, eh) unit: where its silhouette lies.
FN float sweep_support(IN(float) en, IN(float) eh, IN(SweepProfile) p) {
  if (p.kind == SWEEP_TUBE) return p.p0;
  if (p.kind == SWEEP_BEAM) {
    float most = float(-SWEEP_FAR);
    for (int i = 1; i < 6; ++i) {
      vec2 corner = sweep_beam_corner(i);
      most = max(most, en * p.p3 * corner.x * p.p1 + abs(eh) * corner.y * p.p0);
    }
    return most + p.p2;
  }
  if (p.kind == SWEEP_HEAD_WALL) return abs(en) * p.p3 + max(eh * p.p5, -eh * p.p4);
  float half_width = p.p0 + p.p3;
  float radius = p.p2 + p.p3;
  if (eh > 0.0 && abs(en) * radius <= half_width) return radius + eh * p.p1;
  float shoulder = p.p1 + sqrt(max(radius * radius - half_width * half_width, float(0.0)));
  return abs(en) * half_width + max(eh * shoulder, -eh * p.p4);
}

// Outward normal in the cross section, by central differences of D.
FN vec2 sweep_profile_normal(IN(float) n, IN(float) h, IN(SweepProfile) p) {
  float e = float(5e-4);
  float x = sweep_distance(n + e, h, p) - sweep_distance(n - e, h, p);
  float y = sweep_distance(n, h + e, p) - sweep_distance(n, h - e, p);
  float size = sqrt(x * x + y * y);
  if (!(size > 1e-6)) return vec2(0.0, 1.0);
  return vec2(x / size, y / size);
}

// Rays --------------------------------------------------------------------------------------------------------------

struct SweepPoint {
  float s;
  float n;   // from the axis
  float h;
  float ds;  // their rates along the ray
  float dn;
  float dh;
  float tx;  // unit tangent of the centre line, chord frame
  float ty;
  float stretch;  // metres along the tangent per metre of s, here
  float grade;    // of the axis, dz/ds
};

// The place (x, y, z) on a ray of direction (dx, dy, dz). One Newton step more than road_project: sweeps stand outside
// the footprint for which its bound is certified.
FN SweepPoint sweep_locate(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                           IN(SweepPath) r) {
  float px = x / r.chord;
  float py = y / r.chord;
  RoadCoord c = road_project(px, py, r.a, r.b);
  float u = clamp(road_newton(c.u, px, py, r.a, r.b), float(0.0), float(1.0));
  float offset = r.chord * road_v(u, px, py, r.a, r.b);
  float df = road_df(u, r.a, r.b);
  float q = sqrt(1.0 + df * df);
  SweepPoint p;
  p.tx = 1.0 / q;
  p.ty = df / q;
  p.stretch = max(1.0 - offset * road_ddf(u, r.a, r.b) / (q * q * q * r.chord), float(0.05));
  // Beyond the segment's ends s runs on along the tangent, so that posts at a joint are whole.
  float beyond = r.chord * (px - u + (py - road_f(u, r.a, r.b)) * df) / q;
  p.s = r.chord * road_arc(u, r.a, r.b, r.arc / r.chord, r.c0, r.c1) + beyond / p.stretch;
  p.n = offset - r.n0 - r.n1 * p.s;
  p.h = z - road_cubic(p.s, r.z0, r.z1, r.z2, r.z3);
  p.grade = road_dcubic(p.s, r.z1, r.z2, r.z3);
  p.ds = (dx * p.tx + dy * p.ty) / p.stretch;
  p.dn = dy * p.tx - dx * p.ty - r.n1 * p.ds;
  p.dh = dz - p.grade * p.ds;
  return p;
}

// Lower bound of the time until a gap closes that now closes with the given speed (negative: opens), which changes by
// at most bend.
FN float sweep_time(IN(float) gap, IN(float) closing, IN(float) bend) {
  if (!(gap > 0.0)) return float(0.0);
  float root = sqrt(closing * closing + 2.0 * bend * gap);
  if (closing > 0.0) return 2.0 * gap / (closing + root);
  return (root - closing) / max(bend, float(1e-7));
}

// The same for |x| - half > 0.
FN float sweep_slab_time(IN(float) x, IN(float) half_width, IN(float) dx, IN(float) bend) {
  return sweep_time(abs(x) - half_width, x > 0.0 ? -dx : dx, bend);
}

// Lower bound of the time until the ray meets the profile, at least as long as one that brings it `least` nearer.
FN float sweep_step(IN(SweepPoint) c, IN(float) distance, IN(float) least, IN(float) bend_n, IN(float) bend_h,
                    IN(SweepProfile) p) {
  float bend = sqrt(bend_n * bend_n + bend_h * bend_h);
  float time = sweep_time(max(distance, least), sqrt(c.dn * c.dn + c.dh * c.dh), bend);
  if (p.kind == SWEEP_TUBE) {
    float r = max(sqrt(c.n * c.n + c.h * c.h), float(1e-6));
    return max(time, sweep_time(r - p.p0, -(c.n * c.dn + c.h * c.dh) / r, bend));
  }
  if (p.kind == SWEEP_BEAM) {
    float across = sweep_slab_time(c.n * p.p3 - 0.5 * p.p1, 0.5 * p.p1 + p.p2, c.dn * p.p3, bend_n);
    return max(time, max(across, sweep_slab_time(c.h, p.p0 + p.p2, c.dh, bend_h)));
  }
  time = max(time, sweep_time(-p.p4 - c.h, c.dh, bend_h));
  float rise = max(c.h - p.p1, float(0.0));
  float r = max(sqrt(c.n * c.n + rise * rise), float(1e-6));
  if (p.kind == SWEEP_LINING) {
    time = max(time, sweep_slab_time(c.n, p.p0 + p.p3, c.dn, bend_n));
    float closing = -(c.n * c.dn + rise * c.dh) / r;
    time = max(time, sweep_time(r - p.p2 - p.p3, closing, bend));
  } else {
    time = max(time, sweep_slab_time(c.n, p.p3, c.dn, bend_n));
    time = max(time, sweep_time(c.h - p.p5, -c.dh, bend_h));
  }
  // In the hollow: out through a wall or the arch, whichever comes first.
  float walls = min(sweep_time(p.p0 - c.n, c.dn, bend_n), sweep_time(p.p0 + c.n, -c.dn, bend_n));
  walls = min(walls, sweep_time(p.p2 - r, sqrt(c.dn * c.dn + c.dh * c.dh), bend));
  if (p.kind == SWEEP_LINING) {
    float across = min(sweep_time(p.p5 - c.n, c.dn, bend_n), sweep_time(p.p5 + c.n, -c.dn, bend_n));
    walls = min(walls, max(across, sweep_time(c.h - SWEEP_WALKWAY, -c.dh, bend_h)));
  }
  return max(time, walls);
}

// Keeps of the interval k (x to y) the part where value + k slope >= 0.
FN vec2 sweep_keep(IN(vec2) k, IN(float) value, IN(float) slope) {
  float along = abs(slope) < 1e-9 ? (slope < 0.0 ? float(-1e-9) : float(1e-9)) : slope;
  float crossing = -value / along;
  if (along > 0.0) return vec2(max(k.x, crossing), k.y);
  return vec2(k.x, min(k.y, crossing));
}

// The ray's part between the cross sections at the piece's ends, `pad` outside, and within its box, `margin` wider.
// Empty: x > y.
FN vec2 sweep_interval(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                       IN(float) k_low, IN(float) pad, IN(float) margin, IN(SweepPiece) p) {
  float chord = p.path.chord;
  float f0 = road_df(p.u0, p.path.a, p.path.b);
  float f1 = road_df(p.u1, p.path.a, p.path.b);
  float from = x - p.u0 * chord + f0 * (y - chord * road_f(p.u0, p.path.a, p.path.b));
  float to = p.u1 * chord - x - f1 * (y - chord * road_f(p.u1, p.path.a, p.path.b));
  vec2 k = vec2(k_low, float(SWEEP_FAR));
  k = sweep_keep(k, from + pad * sqrt(1.0 + f0 * f0), dx + f0 * dy);
  k = sweep_keep(k, to + pad * sqrt(1.0 + f1 * f1), -dx - f1 * dy);
  k = sweep_keep(k, y - p.y0 + margin, dy);
  k = sweep_keep(k, p.y1 + margin - y, -dy);
  k = sweep_keep(k, z - p.z0 + margin, dz);
  return sweep_keep(k, p.z1 + margin - z, -dz);
}

struct SweepHit {
  float k;         // along the ray; SWEEP_FAR where nothing is met
  float coverage;  // of the pixel, 0 to 1; of misses that come near too
  float met;       // 1 where the ray itself meets it
  float residual;  // of a meeting: |D|, m
  float steps;
};

FN SweepHit sweep_nothing() {
  SweepHit hit;
  hit.k = float(SWEEP_FAR);
  hit.coverage = float(0.0);
  hit.met = float(0.0);
  hit.residual = float(0.0);
  hit.steps = float(0.0);
  return hit;
}

// Part of a pixel of width `pixel` around the ray that lies inside the profile's silhouette: the profile's extent and
// the ray's place across the ray's direction in the cross section, where the ray does not move.
FN float sweep_silhouette(IN(SweepPoint) c, IN(float) pixel, IN(SweepProfile) p) {
  float speed = max(sqrt(c.dn * c.dn + c.dh * c.dh), float(1e-6));
  float en = -c.dh / speed;
  float eh = c.dn / speed;
  float lean = c.grade / c.stretch * eh;
  float width = pixel * sqrt(1.0 + lean * lean);
  return filter_band(en * c.n + eh * c.h, -sweep_support(-en, -eh, p), sweep_support(en, eh, p), width, float(0.0));
}

// Negative while the ray nears the profile seen from outside, positive while it leaves: by the distance from the part
// of the profile's middle that its side here is around.
FN float sweep_leaving(IN(SweepPoint) c, IN(SweepProfile) p) {
  if (p.kind <= SWEEP_BEAM) return c.n * c.dn + c.h * c.dh;
  if (p.kind == SWEEP_LINING) return c.n * c.dn + max(c.h - p.p1, float(0.0)) * c.dh;
  return abs(c.n) - p.p3 > c.h - p.p5 ? c.n * c.dn : c.dh;
}

// Where the ray (x, y, z) + k (dx, dy, dz) of unit speed, k in [k_low, k_high], first meets the profile. reach + k is
// the distance from the eye, pixel a pixel's size at distance 1. The meeting is where D falls to the tolerance: half a
// millimetre or a hundredth of a pixel.
FN SweepHit sweep_march(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                        IN(float) k_low, IN(float) k_high, IN(float) reach, IN(float) pixel, IN(SweepPiece) piece) {
  SweepPath r = piece.path;
  SweepProfile p = piece.profile;
  SweepHit hit = sweep_nothing();
  float level = dx * dx + dy * dy;
  float k = k_low;
  float leaving = float(0.0);
  float k_before = k_low;
  // The passage of the nearest miss.
  float closest = float(SWEEP_FAR);
  float k0 = float(0.0);
  float k1 = float(0.0);
  float r0 = float(0.0);
  float r1 = float(0.0);
  for (int i = 0; i < SWEEP_STEPS; ++i) {
    SweepPoint c = sweep_locate(x + k * dx, y + k * dy, z + k * dz, dx, dy, dz, r);
    float distance = sweep_distance(c.n, c.h, p);
    float width = pixel * max(reach + k, float(1e-3));
    float tolerance = max(0.01 * width, float(5e-4));
    hit.steps = hit.steps + 1.0;
    if (distance < tolerance) {
      hit.k = k;
      hit.met = float(1.0);
      hit.residual = abs(distance);
      if (i == 0) hit.residual = float(0.0);
      if (i == 0 && (c.ds > 0.0 ? piece.end0 : piece.end1) > 0.5) {
        // Through the end: its edge, a pixel of which is wider by the slant, where no side is seen beyond it.
        vec2 m = sweep_profile_normal(c.n, c.h, p);
        float away = m.x * c.dn + m.y * c.dh;
        float slant = away / max(abs(c.ds * c.stretch), float(0.05));
        hit.coverage = clamp(0.5 - distance / (width * sqrt(1.0 + slant * slant)), float(0.0), float(1.0));
        if (away < 0.0) hit.coverage = float(1.0);
      } else {
        hit.coverage = sweep_silhouette(c, width, p);
        // The road's own bends and crests have silhouettes too: there the ray dives in by less than half a pixel and
        // turns back, deepest closing^2 / (2 turning) below the tangent plane of the meeting.
        vec2 m = sweep_profile_normal(c.n, c.h, p);
        float closing = -(m.x * c.dn + m.y * c.dh);
        float bend = max(sqrt(r.bend_n * r.bend_n + r.bend_h * r.bend_h) * level, float(1e-6));
        if (closing * closing < bend * width) {
          float e = min(sqrt(width / bend), float(2.0));
          SweepPoint q = sweep_locate(x + (k + e) * dx, y + (k + e) * dy, z + (k + e) * dz, dx, dy, dz, r);
          float turning = max((m.x * q.dn + m.y * q.dh + closing) / e, float(1e-9));
          hit.coverage = min(hit.coverage, 0.5 + 0.5 * closing * closing / (turning * width));
        }
      }
      return hit;
    }
    // Misses by less than half a pixel.
    // At an end that the ray leaves the nearest place lies in the neighbour, which covers it.
    float rate = sweep_leaving(c, p);
    bool elsewhere = p.kind <= SWEEP_BEAM && ((i == 0 && rate > 0.0) || (k >= k_high && rate < 0.0));
    float near = elsewhere ? float(0.0) : 0.5 - distance / width;
    if (near > hit.coverage) {
      near = min(near, sweep_silhouette(c, width, p));
      if (near > hit.coverage) {
        hit.coverage = near;
        hit.k = k;
      }
    }
    // Between approach and departure lies the nearest place.
    if (leaving < 0.0 && rate > 0.0 && distance > 0.0 && distance / width < closest) {
      closest = distance / width;
      k0 = k_before;
      k1 = k;
      r0 = leaving;
      r1 = rate;
    }
    leaving = rate;
    k_before = k;
    if (k >= k_high) break;
    k = min(k + 0.98 * sweep_step(c, distance, 2.0 * tolerance, r.bend_n * level, r.bend_h * level, p), k_high);
  }
  // A miss: four steps of the false position toward the nearest place.
  for (int j = 0; j < 4; ++j) {
    if (!(k0 < k1)) break;
    float middle = k0 + (k1 - k0) * clamp(r0 / (r0 - r1), float(0.02), float(0.98));
    SweepPoint q = sweep_locate(x + middle * dx, y + middle * dy, z + middle * dz, dx, dy, dz, r);
    float there = sweep_leaving(q, p);
    float wide = pixel * max(reach + middle, float(1e-3));
    float near = min(0.5 - sweep_distance(q.n, q.h, p) / wide, sweep_silhouette(q, wide, p));
    if (near > hit.coverage) {
      hit.coverage = near;
      hit.k = middle;
    }
    if (there < 0.0) {
      k0 = middle;
      r0 = there;
      r1 = r1 * 0.5;
    } else {
      k1 = middle;
      r1 = there;
      r0 = r0 * 0.5;
    }
  }
  return hit;
}

// One post against the ray that is at k in the place c, straight in the post's surroundings, and starts at k_low;
// offset: s from the post.
FN SweepHit sweep_post(IN(SweepPoint) c, IN(float) k, IN(float) k_low, IN(float) offset, IN(float) pixel,
                       IN(SweepPath) r, IN(SweepPosts) posts) {
  SweepHit hit = sweep_nothing();
  // From the axis where the post stands: upright, not along the axis.
  float x = offset * c.stretch;
  float y = c.n + r.n1 * offset - posts.n;
  float h = c.h + c.grade * offset;
  float dx = c.ds * c.stretch;
  float dy = c.dn + r.n1 * c.ds;
  float dh = c.dh + c.grade * c.ds;
  float speed = max(sqrt(dx * dx + dy * dy), float(1e-6));
  float side = abs(x * dy - y * dx) / speed;
  bool is_round = posts.half_s < 0.0;
  float extent = is_round ? posts.half_n : (posts.half_s * abs(dy) + posts.half_n * abs(dx)) / speed;
  float middle = -(x * dx + y * dy) / (speed * speed);
  // In and out, horizontally; of a ray beside the post, both at its nearest place.
  float from = middle;
  float to = middle;
  if (side < extent) {
    if (is_round) {
      float half_way = sqrt(extent * extent - side * side) / speed;
      from = middle - half_way;
      to = middle + half_way;
    } else {
      float ix = 1.0 / (abs(dx) < 1e-6 ? float(1e-6) : abs(dx));
      float iy = 1.0 / (abs(dy) < 1e-6 ? float(1e-6) : abs(dy));
      float mx = dx > 0.0 ? -x : x;
      float my = dy > 0.0 ? -y : y;
      from = max((mx - posts.half_s) * ix, (my - posts.half_n) * iy);
      to = min((mx + posts.half_s) * ix, (my + posts.half_n) * iy);
    }
  }
  from = max(from, k_low - k);
  if (to < from) return hit;
  // Vertically, and what the top covers.
  float h_from = h + from * dh;
  float h_to = h + to * dh;
  float lowest = min(h_from, h_to);
  float below = clamp(0.5 + (posts.high - lowest) / pixel, float(0.0), float(1.0));
  if (max(h_from, h_to) < posts.low) below = float(0.0);
  hit.k = k + from;
  if (h_from > posts.high && dh < 0.0 && lowest < posts.high) hit.k = k + (posts.high - h) / dh;
  hit.coverage = min(filter_band(side, -extent, extent, pixel, float(0.0)), below);
  hit.met = side < extent && lowest < posts.high && max(h_from, h_to) > posts.low ? float(1.0) : float(0.0);
  return hit;
}

// The first post that the ray meets, or else the one that covers most of the pixel; coverage: of all up to there.
FN SweepHit sweep_posts(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                        IN(float) k_low, IN(float) k_high, IN(float) reach, IN(float) pixel, IN(SweepPath) r,
                        IN(SweepPosts) p) {
  SweepHit hit = sweep_nothing();
  float level = dx * dx + dy * dy;
  float half_s = abs(p.half_s);
  float clear = float(1.0);  // part of the pixel that no post has covered yet
  float most = float(0.0);
  float k = k_low;
  for (int i = 0; i < SWEEP_STEPS; ++i) {
    if (k > k_high) break;
    hit.steps = hit.steps + 1.0;
    SweepPoint c = sweep_locate(x + k * dx, y + k * dy, z + k * dz, dx, dy, dz, r);
    float width = pixel * max(reach + k, float(1e-3));
    float margin = 0.5 * width + 2e-3;
    // Over the post's height, beside it, and between it and the next one to the other side: all three must end.
    float index = clamp(floor((c.s - p.first) / p.spacing + 0.5), float(0.0), p.count - 1.0);
    float offset = c.s - p.first - index * p.spacing;
    float other = offset > 0.0 ? offset - p.spacing : offset + p.spacing;
    float spread = (half_s + margin) / c.stretch;
    float time = min(sweep_slab_time(offset, spread, c.ds, r.bend_s * level),
                     sweep_slab_time(other, spread, c.ds, r.bend_s * level));
    time = max(time, sweep_slab_time(c.n - p.n, p.half_n + margin + abs(r.n1) * spread, c.dn, r.bend_n * level));
    time = max(time, sweep_slab_time(c.h - 0.5 * (p.low + p.high), 0.5 * (p.high - p.low) + margin + abs(c.grade) * spread,
                                     c.dh,
                                     r.bend_h * level));
    if (time > 0.0) {
      k = k + 0.98 * time + 1e-3;
      continue;
    }
    SweepHit post = sweep_post(c, k, k_low, offset, width, r, p);
    if (post.coverage > 0.0 && post.k <= k_high) {
      clear = clear * (1.0 - post.coverage);
      if (post.met > 0.5 || post.coverage > most) {
        most = post.coverage;
        hit.k = post.k;
      }
      if (post.met > 0.5) {
        hit.met = float(1.0);
        break;
      }
    }
    k = k + (half_s + p.half_n + 2.0 * margin) / max(sqrt(level), float(0.05));
  }
  hit.coverage = 1.0 - clear;
  return hit;
}

struct SweepCast {
  SweepHit body;   // the profile
  SweepHit posts;  // only in front of what hides them
};

// All of a piece along a ray of unit speed whose part from k_low on is looked at.
FN SweepCast sweep_cast(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                        IN(float) k_low, IN(float) reach, IN(float) pixel, IN(SweepPiece) p) {
  SweepCast found;
  found.body = sweep_nothing();
  found.posts = sweep_nothing();
  float margin = pixel * reach;
  // Neighbours overlap by a millimetre.
  vec2 k = sweep_interval(x, y, z, dx, dy, dz, k_low, float(1e-3), margin, p);
  if (k.x <= k.y) found.body = sweep_march(x, y, z, dx, dy, dz, k.x, k.y, reach, pixel, p);
  if (p.posts.count < 0.5) return found;
  k = sweep_interval(x, y, z, dx, dy, dz, k_low, max(p.posts.half_s, p.posts.half_n) + margin, margin, p);
  if (found.body.met > 0.5 && found.body.coverage > 0.99) k.y = min(k.y, found.body.k);
  if (k.x <= k.y) found.posts = sweep_posts(x, y, z, dx, dy, dz, k.x, k.y, reach, pixel, p.path, p.posts);
  return found;
}

// Unit normal in chord axes of the profile where the ray meets it: the gradient of D(n, h), with the gradients of n and
// h in space.
FN vec3 sweep_normal(IN(SweepPoint) c, IN(SweepPath) r, IN(SweepProfile) p) {
  vec2 m = sweep_profile_normal(c.n, c.h, p);
  float along = -(m.x * r.n1 + m.y * c.grade) / c.stretch;
  vec3 normal = vec3(-m.x * c.ty + along * c.tx, m.x * c.tx + along * c.ty, m.y);
  return normalize(normal);
}

// Likewise of a post.
FN vec3 sweep_post_normal(IN(SweepPoint) c, IN(SweepPath) r, IN(SweepPosts) p) {
  float offset = c.s - p.first - floor((c.s - p.first) / p.spacing + 0.5) * p.spacing;
  float x = offset * c.stretch;
  float y = c.n + r.n1 * offset - p.n;
  if (c.h + c.grade * offset > p.high - 1e-3) return vec3(0.0, 0.0, 1.0);
  if (p.half_s >= 0.0) {
    bool ahead = abs(x) - p.half_s > abs(y) - p.half_n;
    float turn = (ahead ? x : y) < 0.0 ? float(-1.0) : float(1.0);
    x = ahead ? turn : float(0.0);
    y = ahead ? float(0.0) : turn;
  }
  float size = max(sqrt(x * x + y * y), float(1e-6));
  return vec3((x * c.tx - y * c.ty) / size, (x * c.ty + y * c.tx) / size, 0.0);
}

// The hollow ----------------------------------------------------------------------------------------------------------

// Negative in the clear space of a tunnel's piece: under its vault (profile p0 to p2), above its floor (p4 below the
// axis), between its ends, beyond which neighbours overlap by two millimetres, and within its box.
FN float sweep_hollow(IN(float) x, IN(float) y, IN(float) z, IN(SweepPiece) p) {
  float chord = p.path.chord;
  float f0 = road_df(p.u0, p.path.a, p.path.b);
  float f1 = road_df(p.u1, p.path.a, p.path.b);
  float from = x - p.u0 * chord + f0 * (y - chord * road_f(p.u0, p.path.a, p.path.b));
  float to = p.u1 * chord - x - f1 * (y - chord * road_f(p.u1, p.path.a, p.path.b));
  from = from + 2e-3 * sqrt(1.0 + f0 * f0);
  to = to + 2e-3 * sqrt(1.0 + f1 * f1);
  float outside = max(max(-from, -to), max(max(p.y0 - y, y - p.y1), max(p.z0 - z, z - p.z1)));
  if (outside >= 0.0) return outside;
  SweepPoint c = sweep_locate(x, y, z, float(0.0), float(0.0), float(1.0), p.path);
  return max(outside, max(sweep_vault(c.n, c.h, p.profile.p0, p.profile.p1, p.profile.p2), -p.profile.p4 - c.h));
}

// Light -------------------------------------------------------------------------------------------------------------

// Part of the daylight that comes in so far from the nearer portal, with a floor for what walls reflect.
FN float sweep_daylight(IN(float) depth_m) { return 0.02 + 0.98 * exp(-max(depth_m, float(0.0)) / 9.0); }

// Light of the lamps, one every spacing from the tunnel's start, on a place at s from there.
FN float sweep_lamplight(IN(float) s, IN(float) spacing) {
  float x = s / spacing;
  float d = 2.0 * abs(x - floor(x) - 0.5);  // 1 under a lamp, 0 between two
  return 0.55 + 0.45 * d * d * (3.0 - 2.0 * d);
}
