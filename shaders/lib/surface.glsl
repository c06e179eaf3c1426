// The road surface in space: the road function (road.glsl) plus a profile of height, and its intersection with a ray.
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
};

// Arc length in metres from the start anchor.
FN float surface_arc(IN(float) u, IN(RoadSurface) r) {
  return r.chord * road_arc(u, r.a, r.b, r.arc / r.chord, r.c0, r.c1);
}

FN float surface_height(IN(float) u, IN(RoadSurface) r) {
  return road_cubic(surface_arc(u, r), float(0.0), r.z1, r.z2, r.z3);
}

// dz/ds at u.
FN float surface_grade(IN(float) u, IN(RoadSurface) r) {
  return road_dcubic(surface_arc(u, r), r.z1, r.z2, r.z3);
}

struct RoadHit {
  float k;         // along the ray
  float x;         // chord frame
  float y;
  float u;
  float v;
  float residual;  // |z of the ray - z of the surface| at the end of the iteration, m
};

// Where the ray (x, y, z) + k (dx, dy, dz) meets the plane through the segment's chord: where to begin.
FN float surface_chord_plane(IN(float) x, IN(float) z, IN(float) dx, IN(float) dz, IN(RoadSurface) r) {
  float rise = surface_height(float(1.0), r);
  float approach = dz - rise * dx;
  approach = abs(approach) < 1e-6 ? float(-1e-6) : approach;
  return (rise * x - z) / approach;
}

// Where the ray (x, y, z) + k (dx, dy, dz), k in [k_low, k_high], meets the surface: Newton from k_start, kept inside
// the interval. The surface is level across, so its height depends on u alone, and
// du/dk = (dx + f' dy) / (1 + f'^2 - (y - f) f'') from equation 1.
FN RoadHit surface_intersect(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                             IN(float) k_start, IN(float) k_low, IN(float) k_high, IN(RoadSurface) r) {
  RoadHit hit;
  hit.k = clamp(k_start, k_low, k_high);
  for (int i = 0; i < 7; ++i) {
    hit.x = x + hit.k * dx;
    hit.y = y + hit.k * dy;
    RoadCoord c = road_project(hit.x, hit.y, r.a, r.b);
    hit.u = c.u;
    hit.v = c.v;
    float above = z + hit.k * dz - surface_height(c.u, r);
    hit.residual = abs(above);
    float df = road_df(c.u, r.a, r.b);
    float turn = max(1.0 + df * df - (hit.y - road_f(c.u, r.a, r.b)) * road_ddf(c.u, r.a, r.b), float(0.05));
    float du = (c.u > 0.0 && c.u < 1.0) ? (dx + df * dy) / turn : float(0.0);
    float ds = r.chord * road_darc(c.u, r.a, r.b, r.arc / r.chord, r.c0, r.c1) * du;
    float closing = dz - surface_grade(c.u, r) * ds;
    closing = abs(closing) < 1e-6 ? float(-1e-6) : closing;
    if (i < 6) hit.k = clamp(hit.k - above / closing, k_low, k_high);
  }
  return hit;
}

// Height of the ray above the surface at k.
FN float surface_above(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz, IN(float) k,
                       IN(RoadSurface) r) {
  RoadCoord c = road_project(x + k * dx, y + k * dy, r.a, r.b);
  return z + k * dz - surface_height(c.u, r);
}

// Halves [k_low, k_high] twelve times, keeping the end where the ray is on the other side of the surface than at k_low:
// a short interval (x to y of the result) for rays so nearly along the surface that Newton strays.
FN vec2 surface_bracket(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                        IN(float) k_low, IN(float) k_high, IN(RoadSurface) r) {
  float first = surface_above(x, y, z, dx, dy, dz, k_low, r);
  vec2 k = vec2(k_low, k_high);
  for (int i = 0; i < 12; ++i) {
    float middle = 0.5 * (k.x + k.y);
    if (surface_above(x, y, z, dx, dy, dz, middle, r) * first > 0.0) {
      k.x = middle;
    } else {
      k.y = middle;
    }
  }
  return k;
}
