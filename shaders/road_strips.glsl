// The cross section of a road in a pixel: its strips, faces, marks and paint, each by the part that it covers.

// What the pixel shows: the sum of all parts.
struct Pixel {
  vec3 color;      // weighted by coverage
  float coverage;
  float depth;     // the nearest part's
  vec4 road;       // of the part with the most coverage
  vec3 normal;
  float label;
  float most;
  bool on;         // some part lies on this segment
  bool rough;      // not exact for the whole pixel
};

Pixel no_pixel() {
  return Pixel(vec3(0.0), 0.0, 1e30, vec4(-1.0, 0.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), 0.0, 0.0, false, false);
}

void add_part(inout Pixel pixel, float part, vec3 color, Spot spot, float lane) {
  pixel.color += part * color;
  pixel.coverage += part;
  pixel.depth = min(pixel.depth, dot(spot.position, forward.xyz));
  pixel.on = pixel.on || spot.on;
  if (part > pixel.most) {
    pixel.most = part;
    pixel.road = vec4(float(ids.x), arc.z + (arc.w + spot.s), spot.t, lane);
    pixel.normal = spot.normal;
    pixel.label = 2.0;
  }
}

// What all that is seen at a spot shares.
struct Look {
  vec3 noise;
  vec2 width;  // of the boxes over which textures are averaged, along s and t: as the pixel's spread has it
  FrameLight light;
};

Look look_at(Spot spot) {
#ifdef CHANNELS
  return Look(vec3(0.0), vec2(0.0), FrameLight(vec3(0.0), vec3(0.0), 0.0));
#else
  float s = mod(arc.z, NOISE_PERIOD) + (arc.w + spot.s);
  vec2 width = vec2(length(spot.s_step), length(spot.t_step));
  return Look(material_noise(s, spot.t, float(ids.x), spot.s_step.x, spot.s_step.y, spot.t_step.x, spot.t_step.y,
                             section_row(ids.y).w > 0.0), width,
              frame_light(spot.normal, spot.position));
#endif
}

// right, left: t of its borders.
vec3 strip_color(Strip strip, Spot spot, Look look, float right, float left) {
#ifdef CHANNELS
  return vec3(0.0);
#else
  float wheel = 0.0;
  if (strip.driving) {
    float middle = 0.5 * (right + left);
    vec2 part = clamp(vec2(spot.t) + vec2(-0.5, 0.5) * look.width.y, right, left);
    wheel = material_wheel(part.x - middle, part.y - middle);
  }
  float s = mod(arc.z, NOISE_PERIOD) + (arc.w + spot.s);
  return frame_shade(material_color(strip.material, s, spot.t, wheel, look.noise, spot.s_step.x, spot.s_step.y,
                                    spot.t_step.x, spot.t_step.y),
                     look.light);
#endif
}

vec3 paint_color(int color, Look look) {
#ifdef CHANNELS
  return vec3(0.0);
#else
  return frame_shade(marking_color(color), look.light);
#endif
}

// Lays `part` of paint over what covers `under` of the pixel in the colour given.
void add_mark(inout Pixel pixel, float part, float under, vec3 under_color, vec3 color) {
  float over = min(part, under);
  pixel.color += over * (color - under_color);
  if (over > 0.5) pixel.label = 3.0;
}

// Part of the area that paint covers about (s, t) from the middle of the paint, with the changes of both per step.
float paint_area(vec4 place, vec4 kind, float s, float t, vec2 ss, vec2 ts, vec2 ws) {
  if (kind.x < 2.0) {
    float part = filter_band(s, -0.5 * place.z, 0.5 * place.z, ss.x, ss.y, ws.x, ws.y) *
                 filter_band(t, -0.5 * place.w, 0.5 * place.w, ts.x, ts.y, ws.x, ws.y);
    // Stripes and gaps alternate from the middle outward, a stripe in the middle.
    return kind.x < 1.0 ? part : part * marking_dash(t + 0.5 * kind.z, 2.0 * kind.z, kind.z, ts.x, ts.y);
  }
  float way = kind.w > 0.5 ? -1.0 : 1.0;
  float turn = kind.x == 3.0 || kind.x == 5.0 ? 1.0 : (kind.x == 4.0 || kind.x == 6.0 ? -1.0 : 0.0);
  bool both = kind.x >= 5.0;
  vec2 p = way * vec2(s, t);
  float d = marking_arrow(p.x, p.y, place.z, place.w, turn, both);
  float h = 0.01;
  float ds = (marking_arrow(p.x + h, p.y, place.z, place.w, turn, both) - d) / h * way;
  float dt = (marking_arrow(p.x, p.y + h, place.z, place.w, turn, both) - d) / h * way;
  return filter_step(-d, ds * ss.x + dt * ts.x, ds * ss.y + dt * ts.y);
}

// Within reach of the pixel?
bool near_paint(vec4 place, Spot spot) {
  vec2 spread = vec2(abs(spot.s_step.x) + abs(spot.s_step.y), abs(spot.t_step.x) + abs(spot.t_step.y));
  return abs(spot.s - place.x) <= 0.5 * (place.z + spread.x) && abs(spot.t - place.y) <= 0.5 * (place.w + spread.y);
}

// Only DETAILED roads have more than one level, and paint.
#ifdef DETAILED
#define SPOT(level) spots[level]
#define LOOK(level) looks[level]
#define SPOTS LEVELS
#else
#define SPOT(level) spots[0]
#define LOOK(level) looks[0]
#define SPOTS 1
#endif

// A corner of the cross section: a border at a level.
struct Corner {
  int border;
  int level;
};

float border_t(Corner corner, Spot spot) { return section_border(ids.y, corner.border, height.w + spot.s); }

// Part of the pixel that passes the corner on its left. On a plane not t but t / depth is linear in the picture: its
// gradient at the pixel is that of t and of 1 / depth, weighted.
float left_of(Spot spots[SPOTS], Corner corner) {
  Spot spot = SPOT(corner.level);
  float t = spot.t - border_t(corner, spot);
  vec2 gradient = spot.t_step + t * spot.w_step;
  return filter_step(t, gradient.x, gradient.y);
}

// Where the ray meets the strip or the vertical face between two corners.
Spot spot_between(Spot spots[SPOTS], Corner near, Corner far) {
  Spot spot = SPOT(near.level);
#ifdef DETAILED
  if (near.level != far.level) {
    Spot other = SPOT(far.level);
    float border = border_t(near, spot);
    float width = border_t(far, other) - border;
    float near_h = section_row(ids.y + 1u)[near.level];
    float rise = section_row(ids.y + 1u)[far.level] - near_h;
    float side = dot(spot.left, spot.position.xy) >= 0.0 ? -1.0 : 1.0;
    // Which side of it the ray is on, at both levels.
    float g0 = (spot.h - near_h) * width - (spot.t - border) * rise;
    float g1 = (other.h - near_h) * width - (other.t - border) * rise;
    // Not if it comes in or goes out over a joint in between.
    bool met = (spot.found && other.found) || g0 * g1 <= 0.0;
    // False position, an end that stays twice halved; on a straight road the first is exact.
    RoadSurface r = road_surface();
    Spot first = spot;
    float w0 = 0.0;
    float w1 = 1.0;
    float last = 0.0;
    for (int i = 0; i < 6; ++i) {
      float w = abs(g0 - g1) < 1e-9 ? w0 : clamp(w0 + (w1 - w0) * g0 / (g0 - g1), w0, w1);
      spot.p = mix(first.p, other.p, w);
      spot.h = mix(first.h, other.h, w);
      spot.position = mix(first.position, other.position, w);
      // Not between those of the two: in a bend both neighbours of a joint would take the place for the other's.
      RoadCoord c = road_project(spot.p.x, spot.p.y, r.a, r.b);
      spot.s = surface_s(c, spot.p.x, spot.p.y, r);
      spot.t = c.v * r.chord / cos(road_cubic(spot.s, r.e0, r.e1, r.e2, r.e3));
      float g = (spot.h - near_h) * width - (spot.t - border_t(near, spot)) * rise;
      bool again = g * last > 0.0;
      if (g * g0 > 0.0) {
        w0 = w;
        g0 = g;
        if (again) g1 *= 0.5;
      } else {
        w1 = w;
        g1 = g;
        if (again) g0 *= 0.5;
      }
      last = g;
    }
    spot.on = spot.beyond || (met && (spot.s >= -1e-3 || (ids.w & kOpenStart) != 0u) &&
                              (spot.s <= r.arc + 1e-3 || (ids.w & kOpenEnd) != 0u));
    spot.normal = abs(width) < 1e-6 ? vec3(side * spot.left, 0.0)
                                    : normalize(spot.normal - vec3(rise / width * spot.left, 0.0));
    spread(spot);
  }
#endif
  return spot;
}

#ifndef DETAILED
// How far the border is past the pixel, seen along `flip`: beyond 0 neither it nor its mark touches the pixel. Positive
// where the pixel lies on its far side.
float clear_of(Spot spot, int border, float reach, float flip) {
  float t = spot.t - border_t(Corner(border, 0), spot);
  vec2 gradient = abs(spot.t_step) + abs(t * spot.w_step);
  float room = reach + 0.51 * (gradient.x + gradient.y);
  return flip * t > 0.0 ? max(flip * t - room, 0.0) : min(flip * t + room, 0.0);
}
#endif

// Is a dash's end that the pixel shows askew in it? Parts across and along are multiplied, as if each were spread alike
// over the other: off by up to their correlation.
bool ends_askew(Mark mark, float over, Spot spot) {
  float slant = abs(dot(spot.s_step, spot.t_step)) / max(length(spot.s_step) * length(spot.t_step), 1e-12);
  float most = slant + length(spot.w_step);
  if (most < 0.2) return false;
  float dash = marking_dash(height.w + spot.s + mark.phase, max(mark.on + mark.off, 1e-3), mark.on, spot.s_step.x,
                            spot.s_step.y);
  float band = clamp(over / max(dash, 1e-6), 0.0, 1.0);
  return most * sqrt(dash * (1.0 - dash) * band * (1.0 - band)) > 0.05;
}

// The strips from the eye's side to the far one. What is nearer hides what is farther: `open` is the part of the pixel
// that nothing up to here has taken. A ray that leaves the segment between two levels counts where it leaves, so that
// both neighbours of a joint fill their pixels. below: the underside of a bridge, one strip of concrete.
Pixel cross_section(Spot spots[SPOTS], Look looks[SPOTS], bool below) {
  Pixel pixel = no_pixel();
  int borders = int(section_row(ids.y).x);
  // Does the ray run to the left as it goes?
  bool leftward = dot(SPOT(0).left, SPOT(0).position.xy) >= 0.0;
  int onward = leftward ? 1 : -1;
  float flip = leftward ? 1.0 : -1.0;
  float shift = leftward ? 0.0 : 1.0;
  Corner corner = Corner(leftward ? 0 : borders - 1, 0);
  int i = 0;
#ifndef DETAILED
  // Most pixels lie within one strip: not what they are past entirely, nor what comes after them.
  float reach = section_row(ids.y).z;
  while (i + 1 < borders && clear_of(spots[0], corner.border + onward, reach, flip) > 0.0 &&
         clear_of(spots[0], corner.border, reach, flip) > 0.0) {
    ++i;
    corner.border += onward;
  }
#endif
  float open = shift + flip * left_of(spots, corner);
  float before = 0.0;  // what the strip before covers, at this corner's level
  vec3 before_color = vec3(0.0);
  float road = 0.0;  // what is seen at level 0, where paint lies
  vec3 road_color = vec3(0.0);
  for (; i < borders; ++i) {
    bool last = i + 1 == borders;
    Strip strip = last ? Strip(0, corner.level, corner.level, false, 0.0)
                       : section_strip(ids.y, leftward ? corner.border : corner.border - 1);
    if (below) strip = Strip(1, 0, 0, false, 0.0);
    Corner far = Corner(corner.border, leftward ? strip.right_level : strip.left_level);
#ifdef DETAILED
    if (far.level != corner.level) {
      // A vertical face.
      float beyond = shift + flip * left_of(spots, far);
      float part = max(open - beyond, 0.0);
      if (part > 0.0) {
        Spot spot = spot_between(spots, corner, far);
        add_part(pixel, part, strip_color(Strip(5, 0, 0, false, 0.0), spot, look_at(spot), spot.t, spot.t), spot, strip.lane);
      }
      open = min(open, beyond);
      before = 0.0;
      corner = far;
    }
#endif
    float part = 0.0;
    vec3 color = vec3(0.0);
    Spot spot = SPOT(corner.level);
    if (!last) {
      far = Corner(corner.border + onward, leftward ? strip.left_level : strip.right_level);
      if (below) far.border = leftward ? borders - 1 : 0;
      float beyond = shift + flip * left_of(spots, far);
      part = max(open - beyond, 0.0);
      open = min(open, beyond);
      if (part > 0.0) {
        spot = spot_between(spots, corner, far);
        float right_t = border_t(leftward ? corner : far, spot);
        float left_t = border_t(leftward ? far : corner, spot);
#ifdef DETAILED
        if (corner.level != far.level) {
          color = strip_color(strip, spot, look_at(spot), right_t, left_t);
        } else {
          color = strip_color(strip, spot, LOOK(corner.level), right_t, left_t);
        }
#else
        color = strip_color(strip, spot, LOOK(corner.level), right_t, left_t);
#endif
        add_part(pixel, part, color, spot, strip.lane);
      }
    }
    if (below) break;
    vec3 bare_color = pixel.color - (corner.level == 0 && far.level == 0 ? part * color : vec3(0.0));
    // The mark on the border just passed, over the strips on both sides of it.
    float under = before + part;
    if (under > 0.0) {
      Mark mark = section_mark(ids.y, corner.border);
      if (mark.kind > 0) {
        float t = spot.t - border_t(corner, spot);
        float over = marking_border(mark.kind, t, height.w + spot.s + mark.phase, mark.width, mark.space, mark.on, mark.off,
                                    spot.t_step.x, spot.t_step.y, spot.s_step.x, spot.s_step.y, spot.w_step.x,
                                    spot.w_step.y);
        if (over > 0.0) {
          if (over < 1.0 && mark.kind != 1 && mark.kind != 3) pixel.rough = pixel.rough || ends_askew(mark, over, spot);
          add_mark(pixel, over, under, (before * before_color + part * color) / under, paint_color(mark.color, LOOK(corner.level)));
        }
      }
    }
    if (corner.level == 0 && far.level == 0) {
      road += part;
      road_color += pixel.color - bare_color;
    }
    before = part;
    before_color = color;
    corner = far;
#ifndef DETAILED
    if (clear_of(spots[0], corner.border, reach, flip) < 0.0) break;
#endif
  }
#ifdef DETAILED
  uint paint = ids.z >> 8u;
  for (uint i = 0u; i < (ids.z & 255u); ++i) {
    vec4 place = paint_rows[2u * (paint + i)];
    if (!SPOT(0).on || !near_paint(place, SPOT(0))) continue;
    vec4 kind = paint_rows[2u * (paint + i) + 1u];
    float over = paint_area(place, kind, SPOT(0).s - place.x, SPOT(0).t - place.y, SPOT(0).s_step, SPOT(0).t_step,
                            SPOT(0).w_step);
    // An arrow's outline is known by its nearest line alone.
    if (kind.x >= 2.0 || (over > 0.0 && over < 1.0)) pixel.rough = true;
    if (over > 0.0 && road > 0.0) add_mark(pixel, over, road, road_color / road, paint_color(int(kind.y), LOOK(0)));
  }
#endif
  return pixel;
}
