// One road segment per instance: its attributes advance once per instance (the paper's stream frequency divider), its
// corners come from gl_VertexID. Without RELIEF: the fitted quad of the paper's Fig. 5, in a plane. With RELIEF: the
// same quad extruded, along the plane of the segment's chord, to the surface's range about that plane; the pixel shader
// starts from its back faces.
#include "lib/road.glsl"
#include "lib/surface.glsl"
#include "frame.glsl"

// RoadInstance of roadgen/render/road_instance.h.
layout(location = 0) in vec3 in_start;
layout(location = 1) in uint in_tile;
layout(location = 2) in vec4 in_shape;
layout(location = 3) in vec4 in_arc;
layout(location = 4) in vec4 in_height;
layout(location = 5) in vec4 in_superelevation;
layout(location = 6) in vec4 in_box;
layout(location = 7) in uvec4 in_ids;     // road, section, paint, flags
layout(location = 8) in float in_section_s;
layout(location = 9) in uvec2 in_crossfall;

// Origins of the tiles, ENU, each as two floats.
layout(std430, binding = 0) readonly buffer Tiles { vec4 tiles[]; };

#define PASS out
#include "road_shape.glsl"

// What the footprint is drawn larger by at a corner, in the plane of the chord; in units of the chord's length.
struct Room {
  float pixel;   // its size there, m
  // For the antialiased edge: ROOM pixels, as seen at their slant. A pixel that the edge cuts has its centre within 0.71
  // of it, and its samples within 0.36 more; the rest is for the slant, which is that of the corners.
  float beside;
  // Neighbours overlap by a hair, so rounding leaves no crack; for the picture by most of a pixel: whoever holds its
  // centre covers all of its samples. Open ends have an antialiased edge.
  float beyond;
  bool folds;    // the surface may have a silhouette other than its edges, or hold less than it needs beside it
};
#define ROOM 1.5

// bend: how much steeper than the chord the surface may be anywhere.
Room room_at(vec3 start, float rise, float bend, bool at_end, bool at_left) {
  float chord = length(in_shape.xy);
  vec2 ahead = in_shape.xy / chord;
  vec2 aside = vec2(-ahead.y, ahead.x);
  float y = at_left ? in_box.y : in_box.x;
  float x = at_end ? 1.0 - in_shape.w * y : -in_shape.z * y;
  vec3 corner = start + vec3(chord * (ahead * x + aside * y), rise * x);
  float away = length(corner);
  // Of a step from a line on the ground, straight away from it, what is seen as distance from it: all where the line runs
  // toward the eye, the sine of the elevation where it runs across. x: for the lines across the road, y: along it.
  float sine = max(abs(corner.z) / away, 0.003);
  vec2 view = abs(vec2(dot(corner.xy, aside), dot(corner.xy, ahead))) / away;
  vec2 slant = sine / sqrt(view.yx * view.yx + view * view * sine * sine);
  Room room;
  room.pixel = right.w * away;
  room.beside = clamp(ROOM * room.pixel / slant.y, 0.02, 25.0) / chord;
  bool is_open = (in_ids.w & (at_end ? 2u : 1u)) != 0u;
  room.beyond = clamp((is_open ? ROOM : 0.8) * room.pixel / slant.x, 0.01, 25.0) / chord;
  // The lines through the anchors must not cross within it.
  float turn = (in_shape.w - in_shape.z) * (at_left ? 1.0 : -1.0);
  if (turn > 0.0) room.beside = min(room.beside, max(0.8 / turn - abs(y), 0.02 / chord));
  // The eye is as high above the plane of the chord as it is for all its points, and sees it at this sine.
  float seen = abs(corner.z - rise / chord * dot(corner.xy, ahead)) / (away * sqrt(1.0 + rise * rise / (chord * chord)));
  room.folds = seen < max(bend, 0.75 * sine) || room.beside * chord * slant.y < room.pixel;
  return room;
}

#ifdef RELIEF
// How much steeper than its chord the surface may be: along by its height and by superelevation, across by that and by
// crossfall.
float steepening(vec2 left, vec2 right_fall) {
  float arc_m = in_arc.x;
  vec3 power = vec3(arc_m, arc_m * arc_m, arc_m * arc_m * arc_m);
  float mean = road_cubic(arc_m, 0.0, in_height.x, in_height.y, in_height.z) / arc_m;
  vec3 e = abs(in_superelevation.yzw);
  float side = max(-in_box.x, in_box.y) * length(in_shape.xy);
  float along = abs(in_height.x - mean) + 2.0 * abs(in_height.y) * power.x + 3.0 * abs(in_height.z) * power.y +
                side * (e.x + 2.0 * e.y * power.x + 3.0 * e.z * power.y);
  vec2 fall = max(abs(left), abs(right_fall));
  float across = abs(in_superelevation.x) + dot(e, power) + max(fall.x, fall.y);
  return 1.5 * (along + across);
}
#endif

// Whether the whole segment lies beyond the far plane. rise: of its chord, m.
bool beyond_far(vec3 start, float rise) {
  vec3 ahead = vec3(in_shape.xy, rise);
  vec3 aside = vec3(-in_shape.y, in_shape.x, 0.0);
  float y = max(-in_box.x, in_box.y);
  float x = 0.5 + y * max(abs(in_shape.z), abs(in_shape.w));
  float nearest = dot(start + 0.5 * ahead, forward.xyz) - x * abs(dot(ahead, forward.xyz)) -
                  y * abs(dot(aside, forward.xyz)) - max(-in_box.z, in_box.w) * abs(forward.z);
  return nearest > up.w;
}

void main() {
  precise vec3 start = (tiles[2u * in_tile].xyz - eye_high.xyz) + (tiles[2u * in_tile + 1u].xyz - eye_low.xyz) + in_start;
  float rise = road_cubic(in_arc.x, 0.0, in_height.x, in_height.y, in_height.z);
  // What lies beyond the far plane has no area.
  gl_Position = vec4(0.0, 0.0, 0.0, 1.0);
  float chord = length(in_shape.xy);
  float a = in_shape.z;
  float b = in_shape.w;
  axis = in_shape.xy / chord;
  shape = vec4(chord, a, b, in_arc.x);
  arc = vec4(in_arc.y, in_arc.z, in_arc.w, in_height.w);
  height = vec4(in_height.xyz, in_section_s);
  ids = in_ids;

  bool at_left = (gl_VertexID & 1) != 0;
  bool at_end = (gl_VertexID & 2) != 0;
#ifdef RELIEF
  bool at_top = (gl_VertexID & 4) != 0;
  vec2 left = unpackHalf2x16(in_crossfall.x);
  vec2 right_fall = unpackHalf2x16(in_crossfall.y);
  // The whole box has the widest of its corners'.
  float bend = steepening(left, right_fall);
  Room room = room_at(start, rise, bend, false, false);
  for (int i = 1; i < 4; ++i) {
    Room other = room_at(start, rise, bend, i >= 2, (i & 1) != 0);
    room.pixel = max(room.pixel, other.pixel);
    room.beside = max(room.beside, other.beside);
    room.beyond = max(room.beyond, other.beyond);
    room.folds = room.folds || other.folds;
  }
  // Every ray in the box is followed: no more than pays. Rays that pass above a fold or an open end, which antialiasing
  // shows in part, need the box to be higher; where there is none, all that meet the surface do so within its range, but
  // for rounding.
  room.beyond = min(room.beyond, 2.0 * room.pixel / chord);
#ifdef DETAILED
  // Raised lanes end in the air.
  room.folds = true;
#endif
  float lift = room.folds || (in_ids.w & 3u) != 0u ? ROOM * room.pixel : 0.002 + 0.05 * room.pixel;
  box = in_box + vec4(-room.beside, room.beside, -lift, lift);
#else
  Room room = room_at(start, rise, 0.0, at_end, at_left);
#ifdef CHANNELS
  // The rasterizer rounds corners to a part of a pixel, each segment's its own.
  room.beyond = max(0.05 * room.beyond, 1e-5);
#endif
#endif
  float y = at_left ? in_box.y + room.beside : in_box.x - room.beside;
  float x = at_end ? 1.0 - b * y + room.beyond : -a * y - room.beyond;
#ifdef RELIEF
  superelevation = in_superelevation;
  crossfall = vec4(left.x, (left.y - left.x) / in_arc.x, right_fall.x, (right_fall.y - right_fall.x) / in_arc.x);
  vec3 local = vec3(x * chord, y * chord, rise * x + (at_top ? box.w : box.z));
  point = local;
  RoadSurface r = road_surface();
  float side = chord * max(-in_box.x, in_box.y);
  // The box holds the road on both sides of its bend: what it leaves beyond that is the road's half width, or where the road
  // runs at a slope to the chord the part of it that stands on the chord.
  vec3 bow = vec3(road_f(0.25, a, b), road_f(0.5, a, b), road_f(0.75, a, b));
  float bow_low = min(min(bow.x, 0.0), min(bow.y, bow.z));
  float bow_high = max(max(bow.x, 0.0), max(bow.y, bow.z));
  float slope = max(abs(a), abs(b));
  float half_width = chord * max(bow_low - in_box.x, in_box.y - bow_high) * sqrt(1.0 + slope * slope);
  extent = vec3(surface_most_bend(side, r), dot(abs(left + right_fall), vec2(3.0)), half_width);
  eye = vec3(-dot(start.xy, axis), start.x * axis.y - start.y * axis.x, -start.z);
#else
  vec3 local = vec3(x * chord, y * chord, rise * x);
  chord_point = vec2(x, y);
  linear = vec3(road_alpha(y, a, b), road_beta(y, a, b), road_gamma(x, y, a));
#endif
  relative = start + vec3(axis * local.x + vec2(-axis.y, axis.x) * local.y, local.z);
  gl_Position = beyond_far(start, rise) ? vec4(0.0, 0.0, 0.0, 1.0) : clip_from_relative * vec4(relative, 1.0);
}
