// The road function: one segment in its chord frame, where the start anchor is (0, 0), the end anchor is (1, 0), and
// lengths are divided by the chord length L. The centre line is the graph of the cubic
//
//   f(x) = a x (1 - x)^2 - b x^2 (1 - x),        f(0) = f(1) = 0, f'(0) = a, f'(1) = b.
//
// A point (x, y) gets u, the parameter of the nearest point of the centre line, and v, its signed distance (left
// positive) from it. Source: Loviscach 2005, Paving Procedural Roads with Pixel Shaders, section 3, equations 1 to 5;
// the Newton steps on equation 1 are ours. C++: shaders/lib/glsl.h.

struct RoadCoord {
  float u;  // 0 at the start anchor, 1 at the end anchor
  float v;  // signed distance / L, positive to the left
};

FN float road_f(IN(float) x, IN(float) a, IN(float) b) {
  float w = float(1.0) - x;
  return x * w * (w * a - x * b);
}

FN float road_df(IN(float) x, IN(float) a, IN(float) b) {
  float w = float(1.0) - x;
  return w * (w - 2.0 * x) * a + x * (x - 2.0 * w) * b;
}

FN float road_ddf(IN(float) x, IN(float) a, IN(float) b) {
  return (6.0 * x - 4.0) * a + (6.0 * x - 2.0) * b;
}

// Equation 4. All three are linear in (x, y), so a vertex shader may compute them and let the rasterizer interpolate.
FN float road_alpha(IN(float) y, IN(float) a, IN(float) b) { return 3.0 * y * (a + b); }
FN float road_beta(IN(float) y, IN(float) a, IN(float) b) { return float(-1.0) - (4.0 * a + 2.0 * b) * y; }
FN float road_gamma(IN(float) x, IN(float) y, IN(float) a) { return x + y * a; }

// Equation 3: the root near x of equation 2, which is equation 1 with f(u) dropped. Exact on the lines u = 0 and u = 1.
FN float road_u1(IN(float) alpha, IN(float) beta, IN(float) gamma) {
  return 2.0 * gamma / (sqrt(max(beta * beta - 4.0 * alpha * gamma, float(0.0))) - beta);
}

// The simpler approximation that the paper rejects, kept to be compared with in tests.
FN float road_u2(IN(float) x, IN(float) y, IN(float) a, IN(float) b) {
  return (x + y * a) / (1.0 + (a - b) * y);
}

// One Newton step on equation 1, F(u) = x - u + (y - f(u)) f'(u) = 0. Where u is exact already (both joints) the step
// is zero, so the paper's proof of tangent continuity holds after it. F' is at most about -1 + |v| |curvature|; it is
// kept away from 0 so that points beyond the centre of curvature stay finite.
FN float road_newton(IN(float) u, IN(float) x, IN(float) y, IN(float) a, IN(float) b) {
  float d = y - road_f(u, a, b);
  float df = road_df(u, a, b);
  float slope = min(d * road_ddf(u, a, b) - df * df - 1.0, float(-0.05));
  return u - (x - u + d * df) / slope;
}

// Equation 5: the signed distance, given u. An error e of u changes v by O(e^2) only.
FN float road_v(IN(float) u, IN(float) x, IN(float) y, IN(float) a, IN(float) b) {
  float df = road_df(u, a, b);
  return ((y - road_f(u, a, b)) - (x - u) * df) / sqrt(df * df + 1.0);
}

// The mapping of the paper: equations 3 and 5.
FN RoadCoord road_project_paper(IN(float) x, IN(float) y, IN(float) a, IN(float) b) {
  RoadCoord c;
  c.u = road_u1(road_alpha(y, a, b), road_beta(y, a, b), road_gamma(x, y, a));
  c.v = road_v(c.u, x, y, a, b);
  return c;
}

// The mapping with (alpha, beta, gamma) at hand: equation 3, two Newton steps, equation 5. u is clamped to [0, 1]. One
// step would do for v, whose error is of second order in u's; the arc length at u takes u's own.
FN RoadCoord road_project_linear(IN(float) alpha, IN(float) beta, IN(float) gamma, IN(float) x, IN(float) y,
                                 IN(float) a, IN(float) b) {
  RoadCoord c;
  c.u = clamp(road_u1(alpha, beta, gamma), float(0.0), float(1.0));
  c.u = clamp(road_newton(c.u, x, y, a, b), float(0.0), float(1.0));
  c.u = clamp(road_newton(c.u, x, y, a, b), float(0.0), float(1.0));
  c.v = road_v(c.u, x, y, a, b);
  return c;
}

FN RoadCoord road_project(IN(float) x, IN(float) y, IN(float) a, IN(float) b) {
  return road_project_linear(road_alpha(y, a, b), road_beta(y, a, b), road_gamma(x, y, a), x, y, a, b);
}

// Arc length from the start anchor to u, in units of arc / L: a polynomial of degree 5 whose value and slope are exact
// at both ends (so textures are C1 across joints) and whose two inner coefficients c0, c1 make it exact at u = 1/4 and
// 3/4. arc is the whole length / L.
FN float road_arc(IN(float) u, IN(float) a, IN(float) b, IN(float) arc, IN(float) c0, IN(float) c1) {
  float w = float(1.0) - u;
  return u * w * (w * sqrt(1.0 + a * a) - u * sqrt(1.0 + b * b)) + u * u * (3.0 - 2.0 * u) * arc +
         u * u * w * w * (c0 + c1 * (u - 0.5));
}

// d road_arc / du.
FN float road_darc(IN(float) u, IN(float) a, IN(float) b, IN(float) arc, IN(float) c0, IN(float) c1) {
  float w = float(1.0) - u;
  return w * (w - 2.0 * u) * sqrt(1.0 + a * a) + u * (u - 2.0 * w) * sqrt(1.0 + b * b) + 6.0 * u * w * arc +
         2.0 * u * w * (w - u) * (c0 + c1 * (u - 0.5)) + u * u * w * w * c1;
}

// A profile (elevation, half width, ...): the cubic c0 + c1 s + c2 s^2 + c3 s^3 of the arc length s from the segment's
// start, in metres; as in OpenDRIVE.
FN float road_cubic(IN(float) s, IN(float) c0, IN(float) c1, IN(float) c2, IN(float) c3) {
  return c0 + s * (c1 + s * (c2 + s * c3));
}

FN float road_dcubic(IN(float) s, IN(float) c1, IN(float) c2, IN(float) c3) {
  return c1 + s * (2.0 * c2 + s * 3.0 * c3);
}
