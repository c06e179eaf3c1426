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
#define PASS in
#include "road_shape.glsl"

#ifndef CHANNELS
// Depth of the ground alone, which is drawn before the roads.
layout(binding = 2) uniform sampler2D ground_depth;
layout(binding = 3) uniform sampler2DMS ground_depths;
layout(location = 0) uniform int ground_samples;  // which of them holds it: 1, or the samples of the other; 0: neither
#endif

const uint kOpenStart = 1u;
const uint kOpenEnd = 2u;

#include "road_spot.glsl"
#ifdef RELIEF
#include "road_ray.glsl"
#endif
#include "road_strips.glsl"

// Part of the pixel that lies between the open ends of the segment.
float within_ends(Spot spot) {
  float low = (ids.w & kOpenStart) != 0u ? 0.0 : -1e9;
  float high = (ids.w & kOpenEnd) != 0u ? shape.w : 1e9;
#ifdef CHANNELS
  return spot.s >= low && spot.s <= high ? 1.0 : 0.0;
#else
  return filter_band(spot.s, low, high, spot.s_step.x, spot.s_step.y);
#endif
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
  Pixel pixel = cross_section(spots, looks, from_below);
  float open = within_ends(spots[0]);
  pixel.color *= open;
  pixel.coverage *= open;
#ifndef CHANNELS
  take_in_parts(sight, spots[0], spots[0].rough || (spots[0].grazed && pixel.coverage < 1.0) || (pixel.on && pixel.rough));
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
  RoadSurface r = road_surface();
#ifndef RELIEF
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
