// Markings and edges as functions of (s, t), averaged over a pixel: where a coordinate changes by a per step to the
// right and by b per step up, its values over the pixel are spread as the sum of two uniform variables.

// Part of the pixel where the coordinate is at least 0, when it is d at the pixel's centre: the exact integral of a half
// plane over the square pixel.
FN float filter_step(IN(float) d, IN(float) a, IN(float) b) {
  float wide = max(max(abs(a), abs(b)), float(1e-9));
  // Never quite parallel to a side, where the formula would be 0 / 0; off by at most 0.005.
  float narrow = max(min(abs(a), abs(b)) / wide, float(0.02));
  float x = abs(d) / wide;
  float outer = 0.5 * (1.0 + narrow);
  float inner = 0.5 * (1.0 - narrow);
  float rest = max(outer - x, float(0.0));
  float over = max(inner - x, float(0.0));
  float beyond = clamp((rest * rest - over * over) / (2.0 * narrow), float(0.0), float(1.0));
  return d > 0.0 ? 1.0 - beyond : beyond;
}

// Part of the pixel where the coordinate x lies in [low, high]. wa, wb: the relative changes of 1 / depth; on a plane, not
// x but x / depth is linear in the picture, so that at an edge its gradient is that of x and of 1 / depth, weighted.
FN float filter_band(IN(float) x, IN(float) low, IN(float) high, IN(float) a, IN(float) b, IN(float) wa,
                     IN(float) wb) {
  float l = x - low;
  float h = x - high;
  return max(filter_step(l, a + l * wa, b + l * wb) - filter_step(h, a + h * wa, b + h * wb), float(0.0));
}

FN float filter_band(IN(float) x, IN(float) low, IN(float) high, IN(float) a, IN(float) b) {
  return filter_band(x, low, high, a, b, float(0.0), float(0.0));
}

// Integral from 0 to x of the pulse train that is 1 on [n period, n period + on).
FN float marking_pulse_integral(IN(float) x, IN(float) period, IN(float) on) {
  float n = floor(x / period);
  return n * on + min(x - n * period, on);
}

// Average of the pulse train over [x - width/2, x + width/2].
FN float marking_dash_box(IN(float) x, IN(float) period, IN(float) on, IN(float) width) {
  float w = max(width, float(1e-4));
  return clamp((marking_pulse_integral(x + 0.5 * w, period, on) - marking_pulse_integral(x - 0.5 * w, period, on)) / w,
               float(0.0), float(1.0));
}

// Part of the pixel on the dashes of a broken line. The wider of the two spreads is integrated exactly, the narrower by
// Gauss's rule with two points.
FN float marking_dash(IN(float) x, IN(float) period, IN(float) on, IN(float) a, IN(float) b) {
  float wide = max(abs(a), abs(b));
  float offset = 0.28867513 * min(abs(a), abs(b));
  return 0.5 * (marking_dash_box(x - offset, period, on, wide) + marking_dash_box(x + offset, period, on, wide));
}

// Part of the pixel covered by a border's mark. x: t from the border, s: along the road; the gradients of both
// and the relative ones of 1 / depth.
// Kinds: 1 solid, 2 broken, then two lines, right and left: 3 solid solid, 4 solid broken, 5 broken solid,
// 6 broken broken.
FN float marking_border(IN(int) kind, IN(float) x, IN(float) s, IN(float) width, IN(float) space, IN(float) on,
                        IN(float) off, IN(float) ta, IN(float) tb, IN(float) sa, IN(float) sb, IN(float) wa,
                        IN(float) wb) {
  float dash = float(1.0);
  if (kind == 2 || kind >= 4) dash = marking_dash(s, max(on + off, float(1e-3)), on, sa, sb);
  if (kind <= 2) return filter_band(x, -0.5 * width, 0.5 * width, ta, tb, wa, wb) * dash;
  float near = 0.5 * space;
  float right = filter_band(x, -near - width, -near, ta, tb, wa, wb);
  float left = filter_band(x, near, near + width, ta, tb, wa, wb);
  return clamp(right * (kind >= 5 ? dash : float(1.0)) + left * (kind == 4 || kind == 6 ? dash : float(1.0)),
               float(0.0), float(1.0));
}

// Signed distance from a box of half sizes (w, h), negative inside.
FN float marking_box(IN(float) x, IN(float) y, IN(float) w, IN(float) h) {
  float dx = abs(x) - w;
  float dy = abs(y) - h;
  float out_x = max(dx, float(0.0));
  float out_y = max(dy, float(0.0));
  return sqrt(out_x * out_x + out_y * out_y) + min(max(dx, dy), float(0.0));
}

// Signed distance (a lower bound of it outside) from an arrow head: a triangle with its tip at (tip, 0) in +x, its base
// length back and 2 half wide.
FN float marking_head(IN(float) x, IN(float) y, IN(float) tip, IN(float) back, IN(float) half_width) {
  float slant = sqrt(back * back + half_width * half_width);
  float side = ((x - tip) * half_width + abs(y) * back) / slant;
  return max(side, tip - back - x);
}

// Signed distance from an arrow of the given length and width whose foot is at x = -length / 2, y to the left.
// turn: 0 straight, 1 left, -1 right; with_straight adds the straight arrow to a turning one.
FN float marking_arrow(IN(float) x, IN(float) y, IN(float) length_m, IN(float) width, IN(float) turn,
                       IN(bool) with_straight) {
  float shaft = 0.09 * width + 0.02 * length_m;
  float head = 0.36 * length_m;
  float straight = min(marking_box(x + 0.5 * head, y, 0.5 * (length_m - head), shaft),
                       marking_head(x, y, 0.5 * length_m, head, 0.30 * width));
  if (turn == 0.0) return straight;
  // The branch leaves the shaft sideways; its head lies across.
  float side = y * turn;
  float branch_x = with_straight ? -0.14 * length_m : 0.26 * length_m;
  float reach = 0.5 * width;
  float tip = 0.42 * reach;
  float arm = marking_box(x - branch_x, side - 0.5 * (reach - tip), shaft, 0.5 * (reach - tip) + shaft);
  float point = marking_head(side, x - branch_x, reach, tip, 0.16 * length_m);
  float branch = min(arm, point);
  float foot = marking_box(x + 0.25 * length_m - 0.5 * branch_x, y, 0.25 * length_m + 0.5 * branch_x + shaft, shaft);
  return min(branch, with_straight ? straight : foot);
}

// Albedo of paint: 0 white, 1 yellow, 2 blue, 3 green, 4 red, 5 orange.
FN vec3 marking_color(IN(int) color) {
  if (color == 1) return vec3(0.70, 0.46, 0.05);
  if (color == 2) return vec3(0.06, 0.16, 0.50);
  if (color == 3) return vec3(0.05, 0.30, 0.12);
  if (color == 4) return vec3(0.45, 0.05, 0.04);
  if (color == 5) return vec3(0.70, 0.25, 0.03);
  return vec3(0.68, 0.67, 0.63);
}
