// The road surface in space: the road function (road.glsl) plus its profile of height, superelevation and crossfall, and
// its intersection with a ray. Cross sections stand in vertical planes perpendicular to the horizontal tangent, so the
// surface is a height field over (s, n), n the horizontal distance from the reference line, positive to the left:
//
//   z(s, n) = elevation(s) + n tan(superelevation(s)) - |n| crossfall(s) of n's side,
//
// and OpenDRIVE's t, measured in the tilted cross section, is n / cos(superelevation).
// Frame: x, y in the chord frame (units of L), z in metres above the start anchor.

struct RoadSurface {
  float chord;  // L, m
  float a;      // slopes
  float b;
  float arc;    // arc length, m
  float c0;     // inner coefficients of road_arc
  float c1;
  float z1;     // height above the start anchor: z1 s + z2 s^2 + z3 s^3
  float z2;
  float z3;
  float e0;     // superelevation, rad: e0 + e1 s + e2 s^2 + e3 s^3, rising to the left
  float e1;
  float e2;
  float e3;
  float left0;  // crossfall to the left of the reference line: left0 + left1 s, falling outward
  float left1;
  float right0;  // and to the right
  float right1;
};

// Arc length in metres from the start anchor.
FN float surface_arc(IN(float) u, IN(RoadSurface) r) {
  return r.chord * road_arc(u, r.a, r.b, r.arc / r.chord, r.c0, r.c1);
}

// s at a place that road_project has found: before and behind the segment, the tangent at the anchor goes on.
FN float surface_s(IN(RoadCoord) c, IN(float) x, IN(float) y, IN(RoadSurface) r) {
  float s = surface_arc(c.u, r);
  if (c.u > 0.0 && c.u < 1.0) return s;
  float df = road_df(c.u, r.a, r.b);
  return s + r.chord * ((x - c.u) + (y - road_f(c.u, r.a, r.b)) * df) / sqrt(1.0 + df * df);
}

// What the surface does at (s, n).
struct SurfaceSlope {
  float height;  // m above the start anchor
  float ahead;   // dz/ds at constant n
  float aside;   // dz/dn
  float cosine;  // t = n / cosine
};

FN SurfaceSlope surface_at(IN(float) s, IN(float) n, IN(RoadSurface) r) {
  float e = road_cubic(s, r.e0, r.e1, r.e2, r.e3);
  float tilt = sin(e) / cos(e);
  float fall = n > 0.0 ? r.left0 + r.left1 * s : -(r.right0 + r.right1 * s);
  float fall1 = n > 0.0 ? r.left1 : -r.right1;
  SurfaceSlope z;
  z.height = road_cubic(s, float(0.0), r.z1, r.z2, r.z3) + n * (tilt - fall);
  z.aside = tilt - fall;
  z.ahead = road_dcubic(s, r.z1, r.z2, r.z3) + n * (road_dcubic(s, r.e1, r.e2, r.e3) * (1.0 + tilt * tilt) - fall1);
  z.cosine = cos(e);
  return z;
}

// The same; before and behind the segment, the profile goes on with the slope and the curvature that it has there.
FN SurfaceSlope surface_beyond(IN(float) s, IN(float) n, IN(RoadSurface) r) {
  float inside = clamp(s, float(0.0), r.arc);
  float beyond = s - inside;
  float bend = 2.0 * r.z2 + 6.0 * r.z3 * inside;
  SurfaceSlope z = surface_at(inside, n, r);
  z.height += beyond * (z.ahead + 0.5 * bend * beyond);
  z.ahead += bend * beyond;
  return z;
}

struct RoadHit {
  float k;         // along the ray
  float x;         // chord frame
  float y;
  float u;
  float v;
  float s;
  float residual;  // |z of the ray - z of the surface| at the end of the iteration, m
};

// Where the ray (x, y, z) + k (dx, dy, dz) meets the plane through the segment's chord: where to begin.
FN float surface_chord_plane(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                             IN(RoadSurface) r) {
  float rise = road_cubic(r.arc, float(0.0), r.z1, r.z2, r.z3);
  float tilt = road_cubic(0.5 * r.arc, r.e0, r.e1, r.e2, r.e3) * r.chord;
  float approach = dz - rise * dx - tilt * dy;
  approach = abs(approach) < 1e-6 ? float(-1e-6) : approach;
  return (rise * x + tilt * y - z) / approach;
}

// The ray (x, y, z) + k (dx, dy, dz) at k against the surface: where that is, its height above the surface, and how fast
// that changes with k (never 0, so that Newton's next step is k - above / climb). From equation 1, du/dk = (dx + f' dy) / (1 + f'^2 - (y - f) f''), and n changes with the part of
// (dx, dy) across the tangent.
FN RoadHit surface_step(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz, IN(float) k,
                        IN(RoadSurface) r, OUT(float) above, OUT(float) climb) {
  RoadHit hit;
  hit.k = k;
  hit.x = x + k * dx;
  hit.y = y + k * dy;
  RoadCoord c = road_project(hit.x, hit.y, r.a, r.b);
  hit.u = c.u;
  hit.v = c.v;
  hit.s = surface_s(c, hit.x, hit.y, r);
  SurfaceSlope surface = surface_beyond(hit.s, c.v * r.chord, r);
  above = z + k * dz - surface.height;
  hit.residual = abs(above);
  float df = road_df(c.u, r.a, r.b);
  float turn = max(1.0 + df * df - (hit.y - road_f(c.u, r.a, r.b)) * road_ddf(c.u, r.a, r.b), float(0.05));
  float slant = sqrt(1.0 + df * df);
  float ahead = c.u > 0.0 && c.u < 1.0 ? road_darc(c.u, r.a, r.b, r.arc / r.chord, r.c0, r.c1) / turn : 1.0 / slant;
  float ds = r.chord * ahead * (dx + df * dy);
  float dn = r.chord * (dy - df * dx) / slant;
  climb = dz - surface.ahead * ds - surface.aside * dn;
  climb = abs(climb) < 1e-6 ? float(-1e-6) : climb;
  return hit;
}

// Where the ray (x, y, z) + k (dx, dy, dz), k in [k_low, k_high], meets the surface: Newton from k_start, kept inside
// the interval.
FN RoadHit surface_intersect(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                             IN(float) k_start, IN(float) k_low, IN(float) k_high, IN(RoadSurface) r) {
  float above;
  float climb;
  RoadHit hit = surface_step(x, y, z, dx, dy, dz, clamp(k_start, k_low, k_high), r, above, climb);
  for (int i = 0; i < 6; ++i) {
    hit = surface_step(x, y, z, dx, dy, dz, clamp(hit.k - above / climb, k_low, k_high), r, above, climb);
  }
  return hit;
}

// Height of the ray above the surface at k.
FN float surface_above(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz, IN(float) k,
                       IN(RoadSurface) r) {
  float px = x + k * dx;
  float py = y + k * dy;
  RoadCoord c = road_project(px, py, r.a, r.b);
  return z + k * dz - surface_beyond(surface_s(c, px, py, r), c.v * r.chord, r).height;
}

// The same, whatever the ray: Newton from the plane through the chord, to a residual of a fiftieth of tolerance; where
// that strays, since the ray runs nearly along the surface, again from within a short interval that halving finds; and
// where such a ray misses, or meets the surface farther than limit (m) from the reference line, from the far end, since
// it may meet it twice. All in one loop, so that no pixel pays for steps that none of its neighbours needs.
// residual > tolerance: it does not meet it.
FN RoadHit surface_find(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                        IN(float) k_low, IN(float) k_high, IN(float) tolerance, IN(float) limit, IN(RoadSurface) r) {
  float low = k_low;
  float high = k_high;
  float k = surface_chord_plane(x, y, z, dx, dy, dz, r);
  bool along = abs(dz - road_cubic(r.arc, float(0.0), r.z1, r.z2, r.z3) * dx) < 0.03;
  RoadHit hit;
  RoadHit other;  // what the run from the near end has found
  float first = float(0.0);
  int task = 0;  // 0 Newton, 1 the side at the near end, 2 halving, 3 Newton again, 4 Newton from the far end
  int left = 7;  // steps left for it
  for (int i = 0; i < 40; ++i) {
    float above;
    float climb;
    hit = surface_step(x, y, z, dx, dy, dz, clamp(k, low, high), r, above, climb);
    left = left - 1;
    k = hit.k - above / climb;
    if (task == 1) {
      first = above;
      task = 2;
      left = 12;
      k = 0.5 * (low + high);
    } else if (task == 2) {
      if (above * first > 0.0) {
        low = hit.k;
      } else {
        high = hit.k;
      }
      k = left > 0 ? 0.5 * (low + high) : low;
      if (left == 0) {
        task = 3;
        left = 7;
      }
    } else if (hit.residual <= 0.02 * tolerance || left == 0) {
      bool missed = hit.residual > tolerance;
      if (task == 0 && missed) {
        task = 1;
        k = low;
      } else if (task != 4 && along && (missed || r.chord * abs(hit.v) > limit)) {
        other = hit;
        task = 4;
        left = 7;
        low = k_low;
        high = k_high;
        k = high;
      } else {
        break;
      }
    }
  }
  if (task == 4 && !(hit.residual <= tolerance && abs(hit.v) < abs(other.v))) return other;
  return hit;
}

// Where between k_low and k_high, at which its height above the surface has the changes climb_low < 0 < climb_high (or
// the reverse), the ray comes nearest to the surface: false position on the change, an end that stays twice halved
// (Illinois).
FN RoadHit surface_nearest(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                           IN(float) k_low, IN(float) k_high, IN(float) climb_low, IN(float) climb_high,
                           IN(RoadSurface) r) {
  float low = k_low;
  float high = k_high;
  float first = climb_low;
  float last = climb_high;
  float before = float(0.0);
  RoadHit hit;
  for (int i = 0; i < 8; ++i) {
    float above;
    float climb;
    hit = surface_step(x, y, z, dx, dy, dz, (low * last - high * first) / (last - first), r, above, climb);
    bool again = climb * before > 0.0;
    if (climb * first > 0.0) {
      low = hit.k;
      first = climb;
      if (again) last = 0.5 * last;
    } else {
      high = hit.k;
      last = climb;
      if (again) first = 0.5 * first;
    }
    before = climb;
  }
  return hit;
}
