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
flat in vec3 extent;
in vec3 point;
#else
in vec2 chord_point;
in vec3 linear;
#endif

#ifndef CHANNELS
// Depth of the ground alone, which is drawn before the roads.
layout(binding = 2) uniform sampler2D ground_depth;
layout(binding = 3) uniform sampler2DMS ground_depths;
layout(location = 0) uniform int ground_samples;  // which of them holds it: 1, or the samples of the other; 0: neither
#endif

const uint kOpenStart = 1u;
const uint kOpenEnd = 2u;
const float kNearer = 0.75;  // the least part of its depth that a pixel is given

// Where the eye ray meets one level of the cross section.
struct Spot {
  float s;        // from the segment's start
  float t;
  float h;        // above the road surface: the level's, but where the ray does not get there
  vec2 p;         // in the chord frame
  vec3 position;  // relative to the eye
  vec3 normal;
  vec2 left;      // unit, horizontal
  float bend;     // metres of the plane per metre of s, at this t
  float cosine;   // horizontal metres per metre of t
  vec2 size;      // of the part of the pixel, pixels right and up
  vec2 t_step;    // change of t per pixel right and up; 0 for the data channels, which are taken at pixel centres
  vec2 s_step;
  vec2 w_step;    // relative change of 1 / depth, likewise
  bool on;        // false: the ray leaves the segment before or after
  bool beyond;    // on: also over a joint
  float seen;       // part of the pixel below the silhouette of the crest, 1 where there is none
  vec2 sink;        // change of the depth below the silhouette per pixel right and up, of which it shows `deep` at its middle
  float deep;
  float crest;  // m from the eye: where that is
  bool rough;   // parts of the pixel may see otherwise than its middle's surroundings tell
  float turn;       // curvature of the reference line, 1/m
};

// Part of the pixel: its middle from the pixel's, and its size, both in pixels right and up.
struct Part {
  vec2 at;
  vec2 size;
  bool beyond;  // what lies beyond the segment's joints is taken as if it went on
  float last;   // m from the eye: where the crest is, beyond which the road is hidden
};
#define WHOLE Part(vec2(0.0), vec2(1.0), false, 1e9)

// Sets the changes per pixel.
void spread(inout Spot spot) {
#ifdef CHANNELS
  spot.t_step = spot.s_step = spot.w_step = vec2(0.0);
#else
  vec3 step_x = frame_footprint(spot.position, spot.normal, right.xyz) * spot.size.x;
  vec3 step_y = frame_footprint(spot.position, spot.normal, up.xyz) * spot.size.y;
  vec2 ahead = vec2(spot.left.y, -spot.left.x);
  spot.t_step = vec2(dot(spot.left, step_x.xy), dot(spot.left, step_y.xy)) / spot.cosine;
  spot.s_step = vec2(dot(ahead, step_x.xy), dot(ahead, step_y.xy)) / spot.bend;
  spot.w_step = -vec2(dot(forward.xyz, step_x), dot(forward.xyz, step_y)) / max(dot(forward.xyz, spot.position), 1e-3);
#endif
}

Spot spot_at(RoadSurface r, vec2 p, RoadCoord c, float s, vec3 position, vec2 size) {
  Spot spot;
  spot.h = 0.0;
  spot.p = p;
  spot.position = position;
  spot.on = true;
  spot.seen = 1.0;
  spot.sink = vec2(0.0);
  spot.deep = spot.crest = 1e9;
  spot.rough = false;
  // Clamped before any use: lanes that end in a discard may hold anything.
  spot.s = clamp(s, -r.arc, 2.0 * r.arc);
  float n = clamp(c.v * r.chord, -1e3, 1e3);
  SurfaceSlope slope = surface_beyond(spot.s, n, r);
  spot.t = n / slope.cosine;
  float df = road_df(c.u, r.a, r.b);
  vec2 tangent = normalize(axis + vec2(-axis.y, axis.x) * df);
  spot.left = vec2(-tangent.y, tangent.x);
  float stretch = 1.0 + df * df;
  float turn = road_ddf(c.u, r.a, r.b) / (stretch * sqrt(stretch));
  float bend = max(1.0 - c.v * turn, 0.05);
  spot.turn = turn / r.chord;
  spot.normal = normalize(vec3(-slope.ahead / bend * tangent - slope.aside * spot.left, 1.0));
  spot.bend = bend;
  spot.cosine = slope.cosine;
  spot.size = size;
  spread(spot);
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
  vec3 start;   // m
  vec3 from;
  vec3 toward;
  vec3 along;   // unit, metres
  float reach;  // of `start` from the eye
  vec2 k;       // m from `start`; empty where k.x > k.y
  vec2 wide;    // as far as the surface is continued over the joints, for what shares a pixel with the segment
};

// at: pixels right and up of the pixel's centre.
Ray eye_ray(RoadSurface r, vec2 at) {
  Ray ray;
  float depth = dot(relative, forward.xyz);
  vec3 aside = right.w * depth * (at.x * right.xyz + at.y * up.xyz);
  ray.start = point + vec3(dot(aside.xy, axis), aside.y * axis.x - aside.x * axis.y, aside.z);
  ray.along = ray.start - eye;
  ray.reach = length(ray.along);
  ray.along /= ray.reach;
  ray.from = vec3(ray.start.xy / r.chord, ray.start.z);
  ray.toward = vec3(ray.along.xy / r.chord, ray.along.z);
  // From the near plane on, as the quads of planar segments are clipped.
  ray.k = vec2(ray.reach * (forward.w / max(depth, 1e-6) - 1.0), 1e6);
  // Within the segment's width and range about its chord's plane.
  clip_interval(ray.k, ray.from.y - box.x, ray.toward.y);
  clip_interval(ray.k, box.y - ray.from.y, -ray.toward.y);
  float rise = road_cubic(r.arc, 0.0, r.z1, r.z2, r.z3);
  float above = ray.from.z - rise * ray.from.x;
  float climb = ray.toward.z - rise * ray.toward.x;
  clip_interval(ray.k, above - box.z, climb);
  clip_interval(ray.k, box.w - above, -climb);
  // Between the joints' lines, which run through the anchors across the tangents (beyond them a neighbour takes over;
  // they overlap by a millimetre; open ends have room for their antialiased edge).
  float hair = 1e-3 / r.chord;
  float room = (box.y - box.x) * 0.5;
  float x0 = ray.from.x + r.a * ray.from.y;
  float x1 = 1.0 - ray.from.x - r.b * ray.from.y;
  vec2 ends = vec2(ray.toward.x + r.a * ray.toward.y, -ray.toward.x - r.b * ray.toward.y);
  ray.wide = ray.k;
  clip_interval(ray.wide, x0 + 1.2, ends.x);
  clip_interval(ray.wide, x1 + 1.2, ends.y);
  clip_interval(ray.k, x0 + ((ids.w & kOpenStart) != 0u ? room : hair), ends.x);
  clip_interval(ray.k, x1 + ((ids.w & kOpenEnd) != 0u ? room : hair), ends.y);
  return ray;
}

// Has the ray met the road from above before it comes over the joint? Within a pixel and a half; what lies deeper is
// hidden.
bool comes_over(RoadSurface r, Ray ray, RoadSearch search, float pixel) {
  float t = r.chord * search.over_v;
  return search.before < 0.0 && search.before > -1.5 * pixel * (ray.reach + ray.k.x) && search.climb < 0.0 &&
         ray.k.x > ray.wide.x && t > section_border(ids.y, 0, height.w) &&
         t < section_border(ids.y, int(section_row(ids.y).x) - 1, height.w);
}

#ifndef CHANNELS
// Is all that the ray may meet behind the ground, in every sample of the pixel?
bool behind_ground(Ray ray) {
  if (ground_samples == 0) return false;
  ivec2 at = ivec2(gl_FragCoord.xy);
  // At least kNearer of the depth where the ray enters is what main() gives it.
  float nearness = forward.w / (kNearer * dot(relative, forward.xyz) * (1.0 + ray.k.x / ray.reach));
  if (ground_samples == 1) return texelFetch(ground_depth, at, 0).x > nearness;
  for (int i = 0; i < ground_samples; ++i) {
    if (texelFetch(ground_depths, at, i).x <= nearness) return false;
  }
  return true;
}

// Sets what part of the pixel is below the silhouette of a crest: the ray passes `deep` below it, m, where it is `away`
// from the eye. side: 1 for a ray above the surface, -1 for one below it.
void sink_below(inout Spot spot, float deep, float away, float side) {
  vec3 slope = spot.normal / spot.normal.z * right.w * away;
  spot.deep = deep;
  spot.crest = away;
  spot.sink = -side * vec2(dot(slope, right.xyz), dot(slope, up.xyz)) * spot.size;
  spot.seen = filter_step(deep, spot.sink.x, spot.sink.y);
}
#endif

// Only levels of DETAILED roads, and the silhouettes of the picture, need to know about rays that miss.
#ifdef DETAILED
#define LOOK_ABOUT 2
#elif defined(CHANNELS)
#define LOOK_ABOUT 0
#else
#define LOOK_ABOUT 1
#endif

// Where the ray meets the surface raised by lift; beyond: also over the joints.
Spot intersect(RoadSurface r, Ray ray, float lift, Part part) {
  vec3 from = ray.from - vec3(0.0, 0.0, lift);
  vec3 toward = ray.toward;
  vec2 k = vec2(ray.wide.x, min(ray.wide.y, part.last - ray.reach));
  // A thousandth of a pixel, or half a millimetre.
  float tolerance = max(5e-4, 0.001 * right.w * (ray.reach + k.x));
  RoadSearch search = surface_search(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.x, k.y, tolerance, extent.x,
                                     extent.z, part.beyond ? 0 : LOOK_ABOUT, ray.k.x, ray.k.y, r);
  RoadHit hit = search.hit;
  float pixel = right.w * (abs(right.z) + abs(up.z));
#ifdef CHANNELS
  bool crest = false;
#else
  bool over = comes_over(r, ray, search, pixel);
  bool crest = search.crest && !over && hit.residual < pixel * (ray.reach + hit.k);
#endif
  vec3 place = ray.start + hit.k * ray.along - eye;
  RoadCoord c;
  c.u = hit.u;
  c.v = hit.v;
  Spot spot = spot_at(r, vec2(hit.x, hit.y), c, hit.s,
                      vec3(axis * place.x + vec2(-axis.y, axis.x) * place.y, place.z), part.size);
  vec3 along = spot.position / (ray.reach + hit.k);
  float climb = dot(spot.normal, along) / spot.normal.z;  // relative to the surface
  float toward_it = abs(climb);
  // The place along the ray is known to within the tolerance of the height: neighbours overlap by that.
  float slack = min(tolerance / max(toward_it, 1e-4), 1.0);
  bool within = search.met && hit.k >= ray.k.x - slack && hit.k <= ray.k.y + slack;
#ifndef CHANNELS
  within = within && !(climb > 0.0 && over);
  // Within this over the bend the square of its slope to the surface, the silhouette is within two pixels.
  float room = 4.0 * pixel * (ray.reach + hit.k);
  if (crest) {
    sink_below(spot, -hit.residual, ray.reach + hit.k, sign(search.above));
  } else if (within && (toward_it * toward_it < room * extent.x || toward_it < extent.y)) {
    float dn = dot(spot.left, along.xy);
    float ds = (along.x * spot.left.y - along.y * spot.left.x) / spot.bend;
    float side = climb < 0.0 ? 1.0 : -1.0;
    float n = spot.t * spot.cosine;
    float bend = side * surface_bend(spot.s, n, spot.turn, ds, dn, r);
    // Farther on it may bend more.
    if (toward_it * toward_it < 2.0 * room * bend || toward_it < extent.y) {
      // To where it would run level with the surface, with the bend half way there.
      float onward = toward_it / max(bend, 1e-6);
      bend = side * surface_bend(spot.s + 0.5 * ds * onward, n, spot.turn, ds, dn, r);
      onward = toward_it / max(bend, 1e-6);
      float deep = 0.5 * toward_it * onward;
      // Crossfall to both sides makes a ridge of the reference line: there its slope relative to the surface changes.
      float ridge = -n / (abs(dn) < 1e-6 ? 1e-6 : dn);
      float fold = side * (r.left0 + r.right0 + (r.left1 + r.right1) * spot.s) * abs(dn);
      if (ridge > 0.0 && ridge < onward && fold > 0.0) {
        float rest = max(toward_it - bend * ridge - fold, 0.0);
        onward = ridge + rest / max(bend, 1e-6);
        deep = ridge * (toward_it - 0.5 * bend * ridge) + 0.5 * rest * (onward - ridge);
      }
      int last = int(section_row(ids.y).x) - 1;
      float away = min(abs(spot.t - section_border(ids.y, 0, height.w + spot.s)),
                       abs(spot.t - section_border(ids.y, last, height.w + spot.s)));
      float step = abs(spot.t_step.x) + abs(spot.t_step.y);
      spot.rough = (away < 1.5 * step && toward_it * toward_it < room * abs(bend)) ||
                   (abs(spot.t) < step && abs(fold) > 0.3 * toward_it);
      sink_below(spot, deep, ray.reach + hit.k + onward, side);
    }
  }
#endif
  spot.beyond = part.beyond;
  spot.on = (crest && spot.seen > 0.0) || (part.beyond ? search.met : within);
  spot.h = lift + search.above;
  return spot;
}
#endif

// Part of the pixel on the road's side of the line through an anchor across the tangent, whose slope is given; x, y from
// that anchor, along: 1 for a start, -1 for an end.
float open_end(float x, float y, float slope, float along, Spot spot, vec2 size) {
  float inside_m = along * shape.x * (x + slope * y) / sqrt(1.0 + slope * slope);
#ifdef CHANNELS
  return inside_m >= 0.0 ? 1.0 : 0.0;
#else
  vec2 inward = along * normalize(axis + vec2(-axis.y, axis.x) * slope);
  vec3 step_x = frame_footprint(spot.position, spot.normal, right.xyz);
  vec3 step_y = frame_footprint(spot.position, spot.normal, up.xyz);
  return filter_step(inside_m, dot(inward, step_x.xy) * size.x, dot(inward, step_y.xy) * size.y);
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
    spot.on = spot.beyond || ((spot.s >= -1e-3 || (ids.w & kOpenStart) != 0u) &&
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
// both neighbours of a joint fill their pixels.
Pixel cross_section(Spot spots[SPOTS], Look looks[SPOTS]) {
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

// The underside of a bridge.
Pixel underside(Spot spots[SPOTS], Look looks[SPOTS]) {
  Pixel pixel = no_pixel();
  float part = left_of(spots, Corner(0, 0)) - left_of(spots, Corner(int(section_row(ids.y).x) - 1, 0));
  if (part > 0.0) add_part(pixel, part, strip_color(Strip(1, 0, 0, false, 0.0), SPOT(0), LOOK(0), 0.0, 0.0), SPOT(0), 0.0);
  return pixel;
}

// Parts, right and up, each about as long as wide on the road. Paint has more corners than dashes have.
ivec2 division(Spot spot) {
  float across = length(vec2(spot.s_step.x, spot.t_step.x));
  float upward = length(vec2(spot.s_step.y, spot.t_step.y));
  float ratio = max(across, upward) / max(min(across, upward), 1e-9);
#ifdef DETAILED
  int few = ratio > 8.0 ? 1 : (ratio > 2.0 ? 2 : 4);
  int many = 16 / few;
#else
  int few = ratio > 4.0 ? 1 : 2;
  int many = 8 / few;
#endif
  return upward > across ? ivec2(few, many) : ivec2(many, few);
}

// What a part of the pixel shows.
struct Sight {
  Pixel pixel;
  float seen;   // part of it below the silhouette of the crest; 0 where it misses the road
  ivec2 parts;  // in which it is better taken, right and up; 0: none
  Part within;  // what they divide: where the crest is
};

Sight no_sight() { return Sight(no_pixel(), 0.0, ivec2(0), WHOLE); }

// Near a crest what is seen is the pixel's strip below it, and changes fast toward it.
void take_in_parts(inout Sight sight, Spot spot, bool rough) {
  if (rough) sight.parts = division(spot);
  float pixel = abs(spot.sink.x) + abs(spot.sink.y);
  if (spot.deep > 2.0 * pixel) return;
  bool lies = abs(spot.sink.x) > abs(spot.sink.y);  // to its side
  if (sight.parts.x == 0) sight.parts = lies ? ivec2(8, 1) : ivec2(1, 8);
  sight.within.last = spot.crest;
  float hidden = 1.0 - spot.seen;
  if (lies) {
    sight.within.size.x = spot.seen;
    sight.within.at.x = 0.5 * sign(spot.sink.x) * hidden;
  } else {
    sight.within.size.y = spot.seen;
    sight.within.at.y = 0.5 * sign(spot.sink.y) * hidden;
  }
}

// looks: those of the whole pixel serve all its parts.
Sight look_through(RoadSurface r, Part part, inout Look looks[SPOTS]) {
  Sight sight = no_sight();
  Spot spots[SPOTS];
#ifdef RELIEF
  Ray ray = eye_ray(r, part.at);
  if (!(ray.wide.x <= ray.wide.y)) return sight;
#ifndef CHANNELS
  if (!part.beyond && behind_ground(ray)) return sight;
#endif
#ifdef DETAILED
  int levels = int(section_row(ids.y).y);
  for (int i = 0; i < levels; ++i) spots[i] = intersect(r, ray, section_row(ids.y + 1u)[i], part);
#else
  spots[0] = intersect(r, ray, 0.0, part);
#endif
#ifndef DETAILED
  if (!spots[0].on) return sight;  // a neighbour's
#endif
#else
  // Where the part's ray meets the segment's plane.
  vec3 plane = vec3(-road_cubic(r.arc, 0.0, r.z1, r.z2, r.z3) / r.chord * axis, 1.0);
  float depth = dot(relative, forward.xyz);
  vec3 toward = relative / depth + right.w * (part.at.x * right.xyz + part.at.y * up.xyz);
  float reach = dot(plane, relative) / dot(plane, toward);
  if (!(reach > 0.0)) return sight;
  vec3 position = reach * toward;
  vec2 step_m = position.xy - relative.xy;
  vec2 step = vec2(dot(step_m, axis), step_m.y * axis.x - step_m.x * axis.y) / r.chord;
  vec2 p = chord_point + step;
  RoadCoord c = road_project_linear(linear.x + road_alpha(step.y, r.a, r.b),
                                    linear.y + road_beta(step.y, r.a, r.b) + 1.0,
                                    linear.z + road_gamma(step.x, step.y, r.a), p.x, p.y, r.a, r.b);
  spots[0] = spot_at(r, p, c, surface_s(c, p.x, p.y, r), position, part.size);
#endif
  sight.seen = spots[0].seen;
  bool from_below = dot(spots[0].normal, spots[0].position) > 0.0;
  if (from_below) spots[0].normal = -spots[0].normal;
  if (!part.beyond) {
    looks[0] = look_at(spots[0]);
#ifdef DETAILED
    for (int i = 1; i < levels; ++i) looks[i] = look_at(spots[i]);
#endif
  }
  Pixel pixel;
  if (from_below) {
    pixel = underside(spots, looks);
  } else {
    pixel = cross_section(spots, looks);
  }
  vec2 at = spots[0].p;
  float open = 1.0;
  if ((ids.w & kOpenStart) != 0u) open *= open_end(at.x, at.y, r.a, 1.0, spots[0], part.size);
  if ((ids.w & kOpenEnd) != 0u) open *= open_end(at.x - 1.0, at.y, r.b, -1.0, spots[0], part.size);
  pixel.color *= open;
  pixel.coverage *= open;
#ifndef CHANNELS
  take_in_parts(sight, spots[0], spots[0].rough || (pixel.on && pixel.rough));
#endif
#if defined(RELIEF) && !defined(CHANNELS)
  // One depth serves all samples of the pixel; the ground has one at each. The nearest that the road has within the
  // pixel keeps the ground below it out of all of them. Where the ray grazes the road, that is bounded: it must not come
  // before the road that hides it.
  float spread = 0.5 * (abs(spots[0].w_step.x) + abs(spots[0].w_step.y)) * dot(spots[0].position, forward.xyz);
  if (!from_below) pixel.depth -= min(spread, (1.0 - kNearer) * pixel.depth);
#endif
  sight.pixel = pixel;
  return sight;
}

void main() {
#ifdef RELIEF
  RoadSurface r = road_surface();
#else
  RoadSurface r = RoadSurface(shape.x, shape.y, shape.z, shape.w, arc.x, arc.y, height.x, height.y, height.z,
                              0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
  // Beyond the joints' lines the neighbours take over.
  float hair = 1e-5;
  if (chord_point.x + r.a * chord_point.y < -hair && (ids.w & kOpenStart) == 0u) discard;
  if (1.0 - chord_point.x - r.b * chord_point.y < -hair && (ids.w & kOpenEnd) == 0u) discard;
#endif
  // First the pixel as a whole; where that is not exact enough, again in parts. The segment that has the pixel's centre
  // goes on over its joints, so that no gap is left between it and its neighbours.
  Sight whole = no_sight();
  Pixel pixel = no_pixel();
  Look looks[SPOTS];
  for (int i = 0; i < SPOTS; ++i) looks[i] = Look(vec3(0.0), vec2(0.0), FrameLight(vec3(0.0), vec3(0.0), 0.0));
  int parts = 0;
  float share = 0.0;
  for (int i = -1; i < parts; ++i) {
    Part part = WHOLE;
    if (i >= 0) {
      part.size = 1.0 / vec2(whole.parts);
      part.at = (vec2(float(i % whole.parts.x), float(i / whole.parts.x)) + 0.5) * part.size - 0.5;
      part.at = whole.within.at + part.at * whole.within.size;
      part.size *= whole.within.size;
      part.beyond = true;
      part.last = whole.within.last;
    }
    Sight sight = look_through(r, part, looks);
    if (i < 0) {
      whole = sight;
      parts = sight.parts.x * sight.parts.y;
      pixel = sight.pixel;
      share = 1.0;
      if (parts > 0) {
        pixel.color = vec3(0.0);
        pixel.coverage = share = 0.0;
      }
    } else {
      // What misses below a crest meets road that this segment does not know; else it looks past the road.
      if (sight.seen == 0.0 && whole.within.last == 1e9) share += 1.0;
      pixel.color += sight.seen * sight.pixel.color;
      pixel.coverage += sight.seen * sight.pixel.coverage;
      pixel.depth = min(pixel.depth, sight.pixel.depth);
      pixel.on = pixel.on || sight.pixel.on;
      share += sight.seen;
    }
  }
  pixel.color *= whole.seen / max(share, 1e-6);
  pixel.coverage *= whole.seen / max(share, 1e-6);
  if (!(pixel.coverage > 0.0) || !pixel.on) discard;
#ifdef CHANNELS
  out_road = pixel.road;
  out_normal = vec4(pixel.normal, 0.0);
  out_label = vec2(pixel.label, float(ids.x) + 1.0);
#else
  out_color = vec4(pixel.color / pixel.coverage, pixel.coverage);
#endif
#ifdef RELIEF
  gl_FragDepth = forward.w / max(pixel.depth, forward.w);
#endif
}
