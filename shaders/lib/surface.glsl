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

// tan(e) by Lambert's continued fraction: relative error at most 2e-18 up to 45 degrees, 2e-13 up to 80, 5e-11 up to 115;
// rounding comes on top. Cheaper than a sine and a cosine.
FN float surface_tan(IN(float) e) {
  float q = e * e;
  return e * (34459425.0 - q * (4729725.0 - q * (135135.0 - q * (990.0 - q)))) /
         (34459425.0 - q * (16216200.0 - q * (945945.0 - q * (13860.0 - q * 45.0))));
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
  float tilt = surface_tan(e);
  float fall = n > 0.0 ? r.left0 + r.left1 * s : -(r.right0 + r.right1 * s);
  float fall1 = n > 0.0 ? r.left1 : -r.right1;
  SurfaceSlope z;
  z.height = road_cubic(s, float(0.0), r.z1, r.z2, r.z3) + n * (tilt - fall);
  z.aside = tilt - fall;
  z.ahead = road_dcubic(s, r.z1, r.z2, r.z3) + n * (road_dcubic(s, r.e1, r.e2, r.e3) * (1.0 + tilt * tilt) - fall1);
  z.cosine = (abs(e) < 1.5707963 ? float(1.0) : float(-1.0)) / sqrt(1.0 + tilt * tilt);
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

// Second change, per metre, of the height above the surface of a point that moves evenly: ds, dn its changes of s and n
// per metre; turn: curvature of the reference line, 1/m, whose own change is left out.
FN float surface_bend(IN(float) s, IN(float) n, IN(float) turn, IN(float) ds, IN(float) dn, IN(RoadSurface) r) {
  float inside = clamp(s, float(0.0), r.arc);
  SurfaceSlope z = surface_at(inside, n, r);
  float e = road_cubic(inside, r.e0, r.e1, r.e2, r.e3);
  float steep = 1.0 / (z.cosine * z.cosine);
  float e1 = road_dcubic(inside, r.e1, r.e2, r.e3);
  float e2 = 2.0 * r.e2 + 6.0 * r.e3 * inside;
  float along = 2.0 * r.z2 + 6.0 * r.z3 * inside + n * steep * (e2 + 2.0 * e1 * e1 * surface_tan(e));
  float twist = e1 * steep - (n > 0.0 ? r.left1 : -r.right1);
  float room = max(1.0 - n * turn, float(0.05));
  return -(along * ds * ds + 2.0 * twist * ds * dn - z.aside * turn * room * ds * ds +
           z.ahead * 2.0 * turn * ds * dn / room);
}

// A bound of |surface_bend| on the segment within `side`, m, of the reference line, whatever the line's direction.
FN float surface_most_bend(IN(float) side, IN(RoadSurface) r) {
  float arc2 = r.arc * r.arc;
  float turn = max(abs(4.0 * r.a + 2.0 * r.b), abs(2.0 * r.a + 4.0 * r.b)) / r.chord;
  float fall = max(max(abs(r.left0), abs(r.left0 + r.left1 * r.arc)), max(abs(r.right0), abs(r.right0 + r.right1 * r.arc)));
  float aside = abs(r.e0) + abs(r.e1) * r.arc + abs(r.e2) * arc2 + abs(r.e3) * arc2 * r.arc + fall;
  float ahead = abs(r.z1) + 2.0 * abs(r.z2) * r.arc + 3.0 * abs(r.z3) * arc2;
  float e1 = abs(r.e1) + 2.0 * abs(r.e2) * r.arc + 3.0 * abs(r.e3) * arc2;
  float e2 = 2.0 * abs(r.e2) + 6.0 * abs(r.e3) * r.arc;
  float twist = e1 + max(abs(r.left1), abs(r.right1));
  return 1.5 * (2.0 * abs(r.z2) + 6.0 * abs(r.z3) * r.arc + side * e2 + 2.0 * twist + (aside + 2.0 * ahead) * turn);
}

// How far a height above the surface, changing by climb per metre, cannot come down to it, if that change falls by at
// most `falls` per metre.
FN float surface_free(IN(float) above, IN(float) climb, IN(float) falls) {
  float root = sqrt(climb * climb + 2.0 * falls * above);
  return climb < 0.0 ? 2.0 * above / (root - climb) : (root + climb) / falls;
}

struct RoadHit {
  float k;         // along the ray
  float x;         // chord frame
  float y;
  float u;
  float v;
  float s;
  float residual;  // |z of the ray - z of the surface| at the end of the iteration, m
  float du;        // changes of u, v and s with k
  float dv;
  float ds;
};

// Where the ray (x, y, z) + k (dx, dy, dz) nearly meets the surface, to begin with: from the plane through the chord, two
// Newton steps on what a straight road with a parabola's height and its crossfall would have.
FN float surface_begin(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                       IN(RoadSurface) r) {
  float rise = road_cubic(r.arc, float(0.0), r.z1, r.z2, r.z3);
  float bulge = 4.0 * (road_cubic(0.5 * r.arc, float(0.0), r.z1, r.z2, r.z3) - 0.5 * rise);
  float tilt = road_cubic(0.5 * r.arc, r.e0, r.e1, r.e2, r.e3) * r.chord;
  float approach = dz - rise * dx - tilt * dy;
  approach = abs(approach) < 1e-6 ? float(-1e-6) : approach;
  float k = (rise * x + tilt * y - z) / approach;
  for (int i = 0; i < 2; ++i) {
    float px = x + k * dx;
    float py = y + k * dy;
    float u = clamp(px, float(0.0), float(1.0));
    float fall = (py > 0.0 ? r.left0 : -r.right0) * r.chord;
    float above = z + k * dz - rise * px - (tilt - fall) * py - bulge * u * (1.0 - u);
    float climb = approach + fall * dy - bulge * (1.0 - 2.0 * u) * dx;
    if (abs(climb) > 0.02) k = k - above / climb;
  }
  return k;
}

// Where surface_step begins if nothing better is known: equation 3 and a Newton step on equation 1.
FN float surface_guess(IN(float) x, IN(float) y, IN(RoadSurface) r) {
  float u = road_u1(road_alpha(y, r.a, r.b), road_beta(y, r.a, r.b), road_gamma(x, y, r.a));
  return clamp(road_newton(clamp(u, float(0.0), float(1.0)), x, y, r.a, r.b), float(0.0), float(1.0));
}

// The ray (x, y, z) + k (dx, dy, dz) at k against the surface: where that is, by a Newton step on equation 1 from `guess`,
// its height above the surface, and how fast that changes with k (never 0, so that Newton's next step is
// k - above / climb). From equation 1, du/dk = (dx + f' dy) / (1 + f'^2 - (y - f) f''), and n changes with the part of
// (dx, dy) across the tangent.
FN RoadHit surface_step(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz, IN(float) k,
                        IN(float) guess, IN(RoadSurface) r, OUT(float) above, OUT(float) climb) {
  RoadHit hit;
  hit.k = k;
  hit.x = x + k * dx;
  hit.y = y + k * dy;
  RoadCoord c;
  c.u = clamp(road_newton(guess, hit.x, hit.y, r.a, r.b), float(0.0), float(1.0));
  c.v = road_v(c.u, hit.x, hit.y, r.a, r.b);
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
  hit.du = (dx + df * dy) / turn;
  hit.dv = (dy - df * dx) / slant;
  hit.ds = r.chord * ahead * (dx + df * dy);
  climb = dz - surface.ahead * hit.ds - surface.aside * r.chord * hit.dv;
  climb = abs(climb) < 1e-6 ? float(-1e-6) : climb;
  return hit;
}

// What becomes of a ray.
struct RoadSearch {
  RoadHit hit;   // where it meets the surface; else where it comes nearest, or the nearer end
  float above;   // of the ray there, where it meets it only to within the tolerance 0
  bool met;
  bool crest;    // it does not, and comes nearest between the ends
  float before;  // its height above the surface at the first end and the change of that, where they were asked for
  float climb;
  float over_v;  // v where it would have met the surface before, by those
};

// What the ray (x, y, z) + k (dx, dy, dz) does, whatever the ray. First Newton from surface_begin, for k in
// [k_low, k_high], at once on k and on u, to a residual of a fiftieth of tolerance, the last step taken along the
// tangents (bend: a bound of |surface_bend|, which tells how far they serve). Where the bend leaves no room for the ray to
// meet the surface between k_first and there, or proves that it misses, that is the end of it. Else it is followed from
// k_first in steps that cannot pass over a meeting (surface_free: Newton's, shortened by the bend), to the first one
// within limit (m) of the reference line or to k_last. What runs along the surface for so long that the steps do not
// suffice meets it where Newton's method finds it from there, the first time or, if it dips, a later one. Then, if asked to look (1; 2: also for rays that can come nearest
// at the ends alone), what it does in [k_first, k_last]: for one that comes out of the surface, how it stands at k_first;
// for one that misses, where it comes nearest, by false position on the change of its height, an end that stays twice
// halved (Illinois). All in one loop, so that no pixel pays for steps that none of its neighbours needs, and with one text
// for all steps.
FN RoadSearch surface_search(IN(float) x, IN(float) y, IN(float) z, IN(float) dx, IN(float) dy, IN(float) dz,
                             IN(float) k_low, IN(float) k_high, IN(float) tolerance, IN(float) bend,
                             IN(float) limit, IN(int) look, IN(float) k_first, IN(float) k_last, IN(RoadSurface) r) {
  const int kNewton = 0, kFirst = 1, kFollow = 2, kLast = 3, kNearest = 4;
  const int kHurry = 16;  // of the steps that follow a ray, the last
  RoadSearch search;
  search.met = search.crest = false;
  search.above = search.before = search.climb = search.over_v = float(0.0);
  float low = k_low;
  float high = k_high;
  float k = surface_begin(x, y, z, dx, dy, dz, r);
  // How fast the change of the height above the surface can fall, over sags, and rise, over crests.
  float bend0 = 3.0 * r.z2;
  float bend1 = bend0 + 9.0 * r.z3 * r.arc;
  float rest = max(bend - abs(bend0) - abs(bend1 - bend0), float(1e-6));
  float falls = rest + max(max(bend0, bend1), float(0.0));
  float rises = rest - min(min(bend0, bend1), float(0.0));
  float none = float(0.0);
  RoadHit hit = RoadHit(k, none, none, none, none, none, none, none, none, none);
  RoadHit other = hit;      // what an earlier run has found
  float side = float(1.0);  // of the surface that the ray is followed on: 1 above, -1 below
  float first = float(0.0);
  float last = float(0.0);
  float before = float(0.0);
  bool known = false;       // how the ray stands at k_first
  bool gone = false;        // that it misses
  bool aside = false;       // it has met the surface, but beyond the limit
  float reach = k_low;      // where Newton's method has ended
  float reached = float(0.0);  // and the height above the surface there
  bool between = false;     // there is a meeting between low and high
  bool lands = false;       // a part of the ray was left out before this step
  bool leapt = false;       // and that was beside the road
  int task = kNewton;
  int left = 7;      // steps left for it
  bool jump = true;  // to a k that the last one does not lead to
  for (int i = 0; i < 80; ++i) {
    float to = clamp(k, low, high);
    float guess = clamp(hit.u + (to - hit.k) * hit.du, float(0.0), float(1.0));
    if (jump) guess = surface_guess(x + to * dx, y + to * dy, r);
    float above;
    float climb;
    hit = surface_step(x, y, z, dx, dy, dz, to, guess, r, above, climb);
    left = left - 1;
    k = hit.k - above / climb;
    jump = task != kNewton;
    bool done = false;
    // What the tangents leave of the next step, and what the last one has left of u.
    float onward = clamp(k, low, high) - hit.k;
    float ahead = r.chord * (hit.u - guess);
    float turn = abs(road_ddf(hit.u, r.a, r.b)) + 6.0 * abs((r.a + r.b) * hit.v);
    float strays = (bend + turn / r.chord) * (onward * onward + ahead * ahead);
    bool close = strays <= 0.02 * tolerance;
    if (task == kFollow) close = close && abs(above + climb * onward) + strays <= tolerance;
    if (task <= kFollow && task != kFirst && close) {
      hit.residual = abs(above + climb * onward) + strays;
      hit.k += onward;
      hit.x += onward * dx;
      hit.y += onward * dy;
      hit.u = hit.u > 0.0 && hit.u < 1.0 ? clamp(hit.u + onward * hit.du, float(0.0), float(1.0)) : hit.u;
      hit.v += onward * hit.dv;
      hit.s += onward * hit.ds;
    }
    if (task == kNewton) {
      if (close || left == 0) {
        if (hit.residual > tolerance) {
          // At an end, beyond which alone it would come nearer: before it could have met the surface in between, it would
          // have to level out, and bend back by as much as it is away.
          gone = ((hit.k >= high && k > high) || (hit.k <= low && k < low)) &&
                 bend * (high - low) < abs(climb) + sqrt(climb * climb + 2.0 * bend * hit.residual);
          done = gone;
        } else {
          bool comes_first = hit.k > k_first;
          float steep = 2.0 * abs(climb);
          bool enters = climb < 0.0;
          bool alone = (k_last - hit.k) * (enters ? rises : falls) <= steep;
          done = comes_first ? (hit.k - k_first) * (enters ? falls : rises) <= steep &&
                                   (r.chord * abs(hit.v) <= limit || alone)
                             : alone;
        }
        if (!done) {
          done = !(k_first <= k_last);
          reach = hit.k;
          reached = close ? float(0.0) : above;
          task = kFirst;
          low = k_first;
          high = k_last;
          k = k_first;
        }
      }
    } else if (task == kFirst) {
      known = true;
      search.before = above;
      search.climb = climb;
      float df = road_df(hit.u, r.a, r.b);
      search.over_v = hit.v - above / climb * (dy - df * dx) / sqrt(1.0 + df * df);
      if (search.met) {
        hit = other;
        break;
      }
      other = hit;
      side = above < 0.0 ? float(-1.0) : float(1.0);
      // Neighbours overlap by the tolerance.
      done = climb < 0.0 && hit.residual <= tolerance;
      task = gone ? kLast : kFollow;
      left = 40;
      k = gone ? k_last : hit.k + surface_free(abs(above), side * climb, above < 0.0 ? rises : falls);
    } else if (task == kFollow) {
      if (lands) side = above < 0.0 ? float(-1.0) : float(1.0);
      lands = false;
      // How far the ray has still to go beside the road, and to the edge where it leaves it.
      float comes = hit.v > 0.0 ? -hit.dv : hit.dv;
      float inward = comes > 1e-9 ? max(abs(hit.v) - limit / r.chord, float(0.0)) / comes : float(0.0);
      float across = (limit / r.chord + (comes > 0.0 ? abs(hit.v) : -abs(hit.v))) / max(abs(comes), float(1e-9));
      if (close) {
        bool off = r.chord * abs(hit.v) > limit;
        done = !off || hit.k >= k_last || left <= 0;
        // On from there on the side that the ray comes to, and by so much that what grazes is not met again and again.
        side = climb < 0.0 ? float(-1.0) : float(1.0);
        low = hit.k;
        high = k_last;
        between = false;
        lands = leapt = true;
        k = hit.k + max(surface_free(tolerance, abs(climb), side < 0.0 ? rises : falls), 0.9 * inward);
        if (off && !aside) {
          other = hit;
          left = max(left, 30);
        }
        if (off && aside && done) hit = other;
        aside = aside || off;
      } else if (left <= kHurry && left > 0 && (hit.k < k_last || side * above < 0.0)) {
        // Steps run out: by Newton's method, within what is known. First over what lies beside the road.
        if (side * above < 0.0) {
          high = hit.k;
          between = true;
        } else {
          low = hit.k;
          if (reach > low && reach < high && side * reached <= tolerance) {
            high = reach;
            between = true;
          }
        }
        if (!between && !leapt && inward > 0.0) {
          k = hit.k + 0.9 * inward;
          lands = leapt = true;
        } else if (!(k > low && k < high)) {
          k = between ? 0.5 * (low + high) : across > 0.01 ? hit.k + across : k_last;
        }
      } else if (side * above < 0.0) {
        // The bend does not bound what the fold at the reference line does.
        high = hit.k;
        k = 0.5 * (low + high);
      } else {
        low = hit.k;
        k = hit.k + surface_free(abs(above), side * climb, side < 0.0 ? rises : falls);
        if (k >= high && high < k_last) k = 0.5 * (low + high);
        done = left <= 0;
        if (hit.k >= k_last) {
          gone = true;
          done = aside || look == 0 || hit.residual <= tolerance;
          task = kLast;
        }
      }
      if (done && aside && !close) hit = other;
    }
    if (task == kLast && !done && hit.k >= k_last) {
      float away = search.before < 0.0 ? float(-1.0) : float(1.0);
      search.crest = away * search.climb < 0.0 && away * climb > 0.0;
      search.above = above;
      if (!search.crest) {
        if (abs(search.before) < abs(above)) {
          hit = other;
          search.above = search.before;
        }
        break;
      }
      task = kNearest;
      left = 8;
      first = search.climb;
      last = climb;
      low = k_first;
      high = k_last;
      k = (low * last - high * first) / (last - first);
    } else if (task == kNearest) {
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
      search.above = above;
      if (left == 0) break;
      k = (low * last - high * first) / (last - first);
    }
    if (done) {
      // Rays that touch a crest come no nearer.
      search.met = hit.residual <= (gone ? 1.0 : 10.0) * tolerance;
      bool steady = gone && look < 2 && bend * (high - low) < abs(climb);  // nor comes it nearest between the ends
      if (steady || known || look == 0 || !(k_first <= k_last) ||
          (search.met && (climb < 0.0 || !(k_first > k_low)))) {
        break;
      }
      other = hit;
      task = kFirst;
      k = k_first;
      low = k_first;
      high = k_last;
    }
  }
  search.hit = hit;
  return search;
}
