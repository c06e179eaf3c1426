// Cookie-cuts the road out of its proxy: (s, t) of the pixel by the road function, then the strips, faces and marks of
// the cross section, each by the part of the pixel that it covers.
#include "lib/road.glsl"
#include "lib/surface.glsl"
#include "lib/marking.glsl"
#include "lib/noise.glsl"
#include "lib/ground.glsl"
#include "lib/material.glsl"
#include "frame.glsl"
#include "sections.glsl"
#include "outputs.glsl"

flat in vec4 shape;
flat in vec4 arc;
flat in vec4 height;
flat in uvec4 ids;
flat in vec2 axis;
in vec3 relative;
#ifdef RELIEF
flat in vec4 superelevation;
flat in vec4 crossfall;
flat in vec4 box;
flat in vec3 eye;
in vec3 point;
#else
in vec2 chord_point;
in vec3 linear;
#endif

const uint kOpenStart = 1u;
const uint kOpenEnd = 2u;

// Where the eye ray meets one level of the cross section.
struct Spot {
  float s;        // from the segment's start
  float t;
  float h;        // above the road surface: the level's, but where the ray does not get there
  float missed;   // what t would still change by until there, at most a pixel
  vec2 p;         // in the chord frame
  vec3 position;  // relative to the eye
  vec3 normal;
  vec2 left;      // unit, horizontal
  vec2 t_step;    // change of t per pixel right and up; 0 for the data channels, which are taken at pixel centres
  vec2 s_step;
  vec2 w_step;    // relative change of 1 / depth, likewise
  bool on;        // false: the ray leaves the segment before or after
};

Spot spot_at(RoadSurface r, vec2 p, RoadCoord c, vec3 position) {
  Spot spot;
  spot.h = spot.missed = 0.0;
  spot.p = p;
  spot.position = position;
  spot.on = true;
  // Clamped before any use: lanes that end in a discard may hold anything.
  spot.s = clamp(surface_arc(c.u, r), 0.0, r.arc);
  float n = clamp(c.v * r.chord, -1e3, 1e3);
  SurfaceSlope slope = surface_at(spot.s, n, r);
  spot.t = n / slope.cosine;
  float df = road_df(c.u, r.a, r.b);
  vec2 tangent = normalize(axis + vec2(-axis.y, axis.x) * df);
  spot.left = vec2(-tangent.y, tangent.x);
  float bend = max(1.0 - c.v * road_ddf(c.u, r.a, r.b) / pow(1.0 + df * df, 1.5), 0.05);
  spot.normal = normalize(vec3(-slope.ahead / bend * tangent - slope.aside * spot.left, 1.0));
#ifdef CHANNELS
  spot.t_step = spot.s_step = spot.w_step = vec2(0.0);
#else
  vec3 step_x = frame_footprint(position, spot.normal, right.xyz);
  vec3 step_y = frame_footprint(position, spot.normal, up.xyz);
  spot.t_step = vec2(dot(spot.left, step_x.xy), dot(spot.left, step_y.xy)) / slope.cosine;
  spot.s_step = vec2(dot(tangent, step_x.xy), dot(tangent, step_y.xy)) / bend;
  spot.w_step = -vec2(dot(forward.xyz, step_x), dot(forward.xyz, step_y)) / max(dot(forward.xyz, position), 1e-3);
#endif
  return spot;
}

#ifdef RELIEF
RoadSurface road_surface() {
  return RoadSurface(shape.x, shape.y, shape.z, shape.w, arc.x, arc.y, height.x, height.y, height.z, superelevation.x,
                     superelevation.y, superelevation.z, superelevation.w, crossfall.x, crossfall.y, crossfall.z,
                     crossfall.w);
}

// Keeps of the interval k the part where value + k slope >= 0.
void clip_interval(inout vec2 k, float value, float slope) {
  float along = abs(slope) < 1e-9 ? (slope < 0.0 ? -1e-9 : 1e-9) : slope;
  float crossing = -value / along;
  if (along > 0.0) {
    k.x = max(k.x, crossing);
  } else {
    k.y = min(k.y, crossing);
  }
}

// The eye ray in chord axes (z in metres), and the part of it over this segment.
struct Ray {
  vec3 from;
  vec3 toward;
  vec3 along;  // unit, metres
  vec2 k;      // m from `point`; empty where k.x > k.y
  float reach; // of `point` from the eye
};

Ray eye_ray(RoadSurface r) {
  Ray ray;
  ray.along = point - eye;
  ray.reach = length(ray.along);
  ray.along /= ray.reach;
  ray.from = vec3(point.xy / r.chord, point.z);
  ray.toward = vec3(ray.along.xy / r.chord, ray.along.z);
  // Between the joints' lines, which run through the anchors across the tangents (beyond them a neighbour takes over;
  // they overlap by a millimetre; open ends have room for their antialiased edge), and within the segment's width and
  // range about its chord's plane.
  float hair = 1e-3 / r.chord;
  float room = (box.y - box.x) * 0.5;
  float before = (ids.w & kOpenStart) != 0u ? room : hair;
  float behind = (ids.w & kOpenEnd) != 0u ? room : hair;
  // From the near plane on, as the quads of planar segments are clipped.
  ray.k = vec2(ray.reach * (forward.w / max(dot(relative, forward.xyz), 1e-6) - 1.0), 1e6);
  clip_interval(ray.k, ray.from.x + r.a * ray.from.y + before, ray.toward.x + r.a * ray.toward.y);
  clip_interval(ray.k, 1.0 - ray.from.x - r.b * ray.from.y + behind, -ray.toward.x - r.b * ray.toward.y);
  clip_interval(ray.k, ray.from.y - box.x, ray.toward.y);
  clip_interval(ray.k, box.y - ray.from.y, -ray.toward.y);
  float rise = road_cubic(r.arc, 0.0, r.z1, r.z2, r.z3);
  float above = ray.from.z - rise * ray.from.x;
  float climb = ray.toward.z - rise * ray.toward.x;
  clip_interval(ray.k, above - box.z, climb);
  clip_interval(ray.k, box.w - above, -climb);
  return ray;
}

// Where the ray meets the surface raised by lift.
Spot intersect(RoadSurface r, Ray ray, float lift) {
  vec3 from = ray.from - vec3(0.0, 0.0, lift);
  vec3 toward = ray.toward;
  vec2 k = ray.k;
  // A thousandth of a pixel, or half a millimetre.
  float tolerance = max(5e-4, 0.001 * right.w * (ray.reach + k.x));
  float limit = max(section_border(ids.y, int(section_rows[ids.y].x) - 1, height.w), -section_border(ids.y, 0, height.w));
  RoadHit hit = surface_find(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.x, k.y, tolerance, limit, r);
  // Rays that touch a crest come no nearer; those that leave over a joint may meet the neighbour.
  bool on = hit.residual <= (hit.k > k.x && hit.k < k.y ? 10.0 : 1.0) * tolerance;
  float above = 0.0;
  float shift = 0.0;
  if (!on) {
    // It passes this level before the segment or after it: held at that end, and moved on across by what it would still
    // go there, so that the pixels at a joint agree on both sides.
    float first = surface_above(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.x, r);
    float last = surface_above(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.y, r);
    bool at_first = abs(first) < abs(last);
    above = at_first ? first : last;
    hit.k = at_first ? k.x : k.y;
    hit.x = from.x + hit.k * toward.x;
    hit.y = from.y + hit.k * toward.y;
    RoadCoord end = road_project(hit.x, hit.y, r.a, r.b);
    hit.u = end.u;
    hit.v = end.v;
    float back = hit.k + (at_first ? 0.1 : -0.1) * (k.y - k.x);
    RoadCoord inside = road_project(from.x + back * toward.x, from.y + back * toward.y, r.a, r.b);
    float climb = surface_above(from.x, from.y, from.z, toward.x, toward.y, toward.z, back, r) - above;
    shift = (inside.v - end.v) * r.chord * above / (abs(climb) < 1e-6 ? -1e-6 : climb);
  }
  vec3 place = point + hit.k * ray.along - eye;
  RoadCoord c;
  c.u = hit.u;
  c.v = hit.v;
  Spot spot = spot_at(r, vec2(hit.x, hit.y), c, vec3(axis * place.x + vec2(-axis.y, axis.x) * place.y, place.z));
  spot.on = on;
  spot.h = lift + above;
  float pixel_t = abs(spot.t_step.x) + abs(spot.t_step.y);
  spot.missed = clamp(-shift, -pixel_t, pixel_t);
  return spot;
}
#endif

// Part of the pixel on the road's side of the line through an anchor across the tangent, whose slope is given; x, y from
// that anchor, along: 1 for a start, -1 for an end.
float open_end(float x, float y, float slope, float along, Spot spot) {
  float inside_m = along * shape.x * (x + slope * y) / sqrt(1.0 + slope * slope);
#ifdef CHANNELS
  return inside_m >= 0.0 ? 1.0 : 0.0;
#else
  vec2 inward = along * normalize(axis + vec2(-axis.y, axis.x) * slope);
  vec3 step_x = frame_footprint(spot.position, spot.normal, right.xyz);
  vec3 step_y = frame_footprint(spot.position, spot.normal, up.xyz);
  return filter_step(inside_m, dot(inward, step_x.xy), dot(inward, step_y.xy));
#endif
}

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
};

Pixel no_pixel() {
  return Pixel(vec3(0.0), 0.0, 1e30, vec4(-1.0, 0.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), 0.0, 0.0, false);
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
  return Look(material_noise(s, spot.t, float(ids.x), spot.s_step.x, spot.s_step.y, spot.t_step.x, spot.t_step.y), width,
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
  return frame_shade(material_color(strip.material, s, spot.t, wheel, look.noise, look.width.x, look.width.y),
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
float paint_area(vec4 place, vec4 kind, float s, float t, vec2 ss, vec2 ts) {
  if (kind.x < 2.0) {
    float part = filter_band(s, -0.5 * place.z, 0.5 * place.z, ss.x, ss.y) *
                 filter_band(t, -0.5 * place.w, 0.5 * place.w, ts.x, ts.y);
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

float paint_part(uint row, Spot spot) {
  vec4 place = paint_rows[2u * row];
  vec4 kind = paint_rows[2u * row + 1u];
  float s = spot.s - place.x;
  float t = spot.t - place.y;
#ifdef CHANNELS
  return paint_area(place, kind, s, t, vec2(0.0), vec2(0.0));
#else
  vec2 spread = vec2(abs(spot.s_step.x) + abs(spot.s_step.y), abs(spot.t_step.x) + abs(spot.t_step.y));
  if (abs(s) > 0.5 * (place.z + spread.x) || abs(t) > 0.5 * (place.w + spread.y)) return 0.0;
  // Corners are no half planes: eight parts of the pixel, two across and four up, where it is longest on the road.
  float sum = 0.0;
  for (int i = 0; i < 8; ++i) {
    vec2 at = vec2(float(i & 1) * 0.5 - 0.25, float(i >> 1) * 0.25 - 0.375);
    sum += paint_area(place, kind, s + dot(spot.s_step, at), t + dot(spot.t_step, at), spot.s_step * vec2(0.5, 0.25),
                      spot.t_step * vec2(0.5, 0.25));
  }
  return 0.125 * sum;
#endif
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
  float t = spot.t + spot.missed - border_t(corner, spot);
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
    float near_h = section_rows[ids.y + 1u][near.level];
    float rise = section_rows[ids.y + 1u][far.level] - near_h;
    float side = dot(spot.left, spot.position.xy) >= 0.0 ? -1.0 : 1.0;
    // Which side of it the ray is on, at both levels.
    float g0 = (spot.h - near_h) * width - (spot.t - border) * rise;
    float g1 = (other.h - near_h) * width - (other.t - border) * rise;
    // On this segment where the ray goes from one side to the other; with both levels at hand also in the pixels that
    // it covers in part.
    spot.on = (spot.on && other.on) || g0 * g1 <= 0.0;
    // False position; on a straight road the first is exact.
    RoadSurface r = road_surface();
    Spot first = spot;
    float w0 = 0.0;
    float w1 = 1.0;
    for (int i = 0; i < 4; ++i) {
      float w = abs(g0 - g1) < 1e-9 ? w0 : clamp(w0 + (w1 - w0) * g0 / (g0 - g1), w0, w1);
      spot.p = mix(first.p, other.p, w);
      spot.s = mix(first.s, other.s, w);
      spot.h = mix(first.h, other.h, w);
      spot.position = mix(first.position, other.position, w);
      spot.t = road_project(spot.p.x, spot.p.y, r.a, r.b).v * r.chord / cos(road_cubic(spot.s, r.e0, r.e1, r.e2, r.e3));
      float g = (spot.h - near_h) * width - (spot.t - border_t(near, spot)) * rise;
      if (g * g0 > 0.0) {
        w0 = w;
        g0 = g;
      } else {
        w1 = w;
        g1 = g;
      }
    }
    spot.normal = abs(width) < 1e-6 ? vec3(side * spot.left, 0.0)
                                    : normalize(spot.normal - vec3(rise / width * spot.left, 0.0));
  }
#endif
  return spot;
}

// The strips from the eye's side to the far one. What is nearer hides what is farther: `open` is the part of the pixel
// that nothing up to here has taken. A ray that leaves the segment between two levels counts where it leaves, so that
// both neighbours of a joint fill their pixels.
Pixel cross_section(Spot spots[SPOTS], Look looks[SPOTS]) {
  Pixel pixel = no_pixel();
  int borders = int(section_rows[ids.y].x);
  // Does the ray run to the left as it goes?
  bool leftward = dot(SPOT(0).left, SPOT(0).position.xy) >= 0.0;
  int onward = leftward ? 1 : -1;
  float flip = leftward ? 1.0 : -1.0;
  float shift = leftward ? 0.0 : 1.0;
  Corner corner = Corner(leftward ? 0 : borders - 1, 0);
  float open = shift + flip * left_of(spots, corner);
  float before = 0.0;  // what the strip before covers, at this corner's level
  vec3 before_color = vec3(0.0);
  for (int i = 0; i < borders; ++i) {
    bool last = i + 1 == borders;
    Strip strip = last ? Strip(0, corner.level, corner.level, false, 0.0)
                       : section_strip(ids.y, leftward ? corner.border : corner.border - 1);
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
    // The mark on the border just passed, over the strips on both sides of it.
    float under = before + part;
    if (under > 0.0) {
      Mark mark = section_mark(ids.y, corner.border);
      if (mark.kind > 0) {
        float over = marking_border(mark.kind, spot.t - border_t(corner, spot), height.w + spot.s, mark.width, mark.space,
                                    mark.on, mark.off, spot.t_step.x, spot.t_step.y, spot.s_step.x, spot.s_step.y);
        if (over > 0.0) {
          add_mark(pixel, over, under, (before * before_color + part * color) / under, paint_color(mark.color, LOOK(corner.level)));
        }
      }
    }
    before = part;
    before_color = color;
    corner = far;
  }
#ifdef DETAILED
  uint paint = ids.z >> 8u;
  for (uint i = 0u; i < (ids.z & 255u); ++i) {
    vec4 kind = paint_rows[2u * (paint + i) + 1u];
    float over = SPOT(0).on ? paint_part(paint + i, SPOT(0)) : 0.0;
    if (over > 0.0 && pixel.coverage > 0.0) {
      add_mark(pixel, over, pixel.coverage, pixel.color / pixel.coverage, paint_color(int(kind.y), LOOK(0)));
    }
  }
#endif
  return pixel;
}

// The underside of a bridge.
Pixel underside(Spot spots[SPOTS], Look looks[SPOTS]) {
  Pixel pixel = no_pixel();
  float part = left_of(spots, Corner(0, 0)) - left_of(spots, Corner(int(section_rows[ids.y].x) - 1, 0));
  if (part > 0.0) add_part(pixel, part, strip_color(Strip(1, 0, 0, false, 0.0), SPOT(0), LOOK(0), 0.0, 0.0), SPOT(0), 0.0);
  return pixel;
}

void main() {
#ifdef RELIEF
  RoadSurface r = road_surface();
  Ray ray = eye_ray(r);
  if (!(ray.k.x <= ray.k.y)) discard;
  Spot spots[SPOTS];
#ifdef DETAILED
  int levels = int(section_rows[ids.y].y);
  for (int i = 0; i < levels; ++i) spots[i] = intersect(r, ray, section_rows[ids.y + 1u][i]);
#else
  spots[0] = intersect(r, ray, 0.0);
#endif
#else
  RoadSurface r = RoadSurface(shape.x, shape.y, shape.z, shape.w, arc.x, arc.y, height.x, height.y, height.z,
                              0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
  // Beyond the joints' lines the neighbours take over.
  float hair = 1e-5;
  if (chord_point.x + r.a * chord_point.y < -hair && (ids.w & kOpenStart) == 0u) discard;
  if (1.0 - chord_point.x - r.b * chord_point.y < -hair && (ids.w & kOpenEnd) == 0u) discard;
  Spot spots[SPOTS];
  spots[0] = spot_at(r, chord_point,
                     road_project_linear(linear.x, linear.y, linear.z, chord_point.x, chord_point.y, r.a, r.b),
                     relative);
#endif
  bool from_below = dot(spots[0].normal, spots[0].position) > 0.0;
  if (from_below) spots[0].normal = -spots[0].normal;
  Look looks[SPOTS];
  looks[0] = look_at(spots[0]);
#ifdef DETAILED
  for (int i = 1; i < levels; ++i) looks[i] = look_at(spots[i]);
#endif
  Pixel pixel;
  if (from_below) {
    pixel = underside(spots, looks);
  } else {
    pixel = cross_section(spots, looks);
  }
  float coverage = pixel.coverage;
  vec2 p = spots[0].p;
  if ((ids.w & kOpenStart) != 0u) coverage *= open_end(p.x, p.y, r.a, 1.0, spots[0]);
  if ((ids.w & kOpenEnd) != 0u) coverage *= open_end(p.x - 1.0, p.y, r.b, -1.0, spots[0]);
  if (!(coverage > 0.0) || !pixel.on) discard;
#ifdef CHANNELS
  out_road = pixel.road;
  out_normal = vec4(pixel.normal, 0.0);
  out_label = vec2(pixel.label, float(ids.x) + 1.0);
#else
  out_color = vec4(pixel.color / pixel.coverage, coverage);
#endif
#ifdef RELIEF
  float depth = pixel.depth;
#ifndef CHANNELS
  // One depth serves all samples of the pixel; the ground has one at each. The nearest that the road has within the
  // pixel keeps the ground below it out of all of them.
  vec3 step_x = frame_footprint(spots[0].position, spots[0].normal, right.xyz);
  vec3 step_y = frame_footprint(spots[0].position, spots[0].normal, up.xyz);
  depth -= 0.5 * (abs(dot(step_x, forward.xyz)) + abs(dot(step_y, forward.xyz)));
#endif
  gl_FragDepth = forward.w / max(depth, forward.w);
#endif
}
