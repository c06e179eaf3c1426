// Cookie-cuts a junction's carriageway out of its box: intersects the eye ray with the surface, then asks how far the
// place lies within the area.
#include "lib/road.glsl"
#include "lib/junction.glsl"
#include "lib/noise.glsl"
#include "lib/ground.glsl"
#include "lib/marking.glsl"
#include "lib/material.glsl"
#include "frame.glsl"
#include "junctions.glsl"
#include "outputs.glsl"

flat in uint junction;
flat in vec3 eye;
flat in vec3 low;
flat in vec3 high;
in vec3 point;

JunctionCut cut_at(uint i) {
  vec4 a = cut_rows[4u * i];
  vec4 b = cut_rows[4u * i + 1u];
  vec4 c = cut_rows[4u * i + 2u];
  return JunctionCut(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z);
}

JunctionCorner corner_at(uint i) {
  vec4 a = corner_rows[6u * i];
  vec4 b = corner_rows[6u * i + 1u];
  vec4 c = corner_rows[6u * i + 2u];
  vec4 d = corner_rows[6u * i + 3u];
  vec4 e = corner_rows[6u * i + 4u];
  return JunctionCorner(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, c.z, c.w, d.x, d.y, d.z, d.w, e.x, e.y, e.z,
                        e.w, corner_rows[6u * i + 5u].x);
}

JunctionHeight height_at(vec2 p) {
  uvec4 range = headers[junction].range;
  JunctionHeight h = junction_height_begin();
  for (uint i = 0u; i < range.y; ++i) h = junction_height_add_cut(h, p.x, p.y, cut_at(range.x + i));
  for (uint i = 0u; i < range.w; ++i) h = junction_height_add_corner(h, p.x, p.y, corner_at(range.z + i));
  return h;
}

JunctionSide side_at(vec2 p) {
  uvec4 range = headers[junction].range;
  JunctionSide side = junction_side_begin();
  for (uint i = 0u; i < range.y; ++i) side = junction_side_add_cut(side, p.x, p.y, cut_at(range.x + i));
  for (uint i = 0u; i < range.w; ++i) side = junction_side_add_corner(side, p.x, p.y, corner_at(range.z + i));
  return side;
}

// A place of the surface on the eye ray, from the centre.
struct Spot {
  vec3 place;
  vec3 position;   // relative to the eye
  vec3 normal;     // unit, toward the eye's side
  vec3 step_x;     // change per pixel right and up
  vec3 step_y;
  float coverage;  // part of the pixel that lies within the area
  bool under;      // beyond its corners, or on their edge
};

Spot spot_at(vec3 place, JunctionHeight h) {
  Spot spot;
  spot.place = place;
  spot.position = place - eye;
  spot.normal = normalize(vec3(-h.zx, -h.zy, 1.0));
  if (dot(spot.normal, spot.position) > 0.0) spot.normal = -spot.normal;
  spot.step_x = frame_footprint(spot.position, spot.normal, right.xyz);
  spot.step_y = frame_footprint(spot.position, spot.normal, up.xyz);
  JunctionSide side = side_at(place.xy);
  float inside_m = junction_open_distance(side);
  vec2 n = vec2(side.nx, side.ny);
  float ahead_m = dot(n, spot.step_x.xy), aside_m = dot(n, spot.step_y.xy);
  spot.under = inside_m < 0.5 * (abs(ahead_m) + abs(aside_m));
  inside_m += headers[junction].phase.z;
#ifdef CHANNELS
  spot.coverage = inside_m >= 0.0 ? 1.0 : 0.0;
#else
  spot.coverage = filter_step(inside_m, ahead_m, aside_m);
#endif
  return spot;
}

// Height of the ray above the surface at k, and how it changes with k.
vec2 above(vec3 along, float k, out JunctionHeight h) {
  vec3 p = point + k * along;
  h = height_at(p.xy);
  return vec2(p.z - h.z, along.z - h.zx * along.x - h.zy * along.y);
}

// Newton from k inside [a, b], between whose ends the ray crosses the surface; first: the sign of the height above it
// at a; rate: what that height changes by per metre, at most.
bool refine(vec3 along, float a, float b, float k, float first, float rate, float tolerance, out Spot spot) {
  JunctionHeight h;
  for (int i = 0; i < 20; ++i) {
    vec2 f = above(along, k, h);
    float next = k - f.x / f.y;
    if (abs(f.x) <= tolerance) {
      // The last step, by the slope at hand.
      spot = spot_at(point + clamp(next, k - tolerance / rate, k + tolerance / rate) * along, h);
      return spot.coverage > 0.0;
    }
    if (f.x * first > 0.0) {
      a = k;
    } else {
      b = k;
    }
    if (b - a < abs(f.x) / rate) return false;
    k = next > a && next < b ? next : 0.5 * (a + b);
  }
  return false;
}

// The first place of the area that the ray meets for k in [near, far].
bool intersect(vec3 along, float near, float far, float tolerance, out Spot spot) {
  // The ray nears or leaves the surface by closing, give or take spread, per metre.
  vec4 plane = headers[junction].plane;
  float closing = along.z - dot(plane.xy, along.xy);
  float spread = 1.2 * plane.w * length(along.xy) + 1e-4;
  float rate = abs(closing) + spread;
  // Within the surface's greatest distance from the plane.
  float k = (plane.z + dot(plane.xy, point.xy) - point.z) / (abs(closing) < 1e-6 ? 1e-6 : closing);
  float slack = headers[junction].low.w / max(abs(closing), 1e-6);
  near = max(near, k - slack);
  far = min(far, k + slack);
  if (!(near < far)) return false;
  if (abs(closing) > spread) {
    // One crossing at most, near that of the plane. Where that is far beside the area, none.
    vec2 p = point.xy + k * along.xy;
    JunctionSide side = side_at(p);
    float margin = (headers[junction].low.x - low.x) + slack * length(along.xy);
    if (!side.inside && min(side.corner, side.cut) > margin) return false;
    return refine(along, near, far, clamp(k, near, far), -closing, rate, tolerance, spot);
  }
  // One along the surface may cross it several times, outside the area too. Steps that cannot reach it, and none below
  // 0.7 m: the crown of an arm is some metres wide.
  JunctionHeight h;
  float least = max(0.7, (far - near) / 64.0);
  float a = near;
  vec2 fa = above(along, a, h);
  for (int i = 0; i < 64 && a < far; ++i) {
    float b = min(a + max(abs(fa.x) / rate, least), far);
    vec2 fb = above(along, b, h);
    if (fa.x * fb.x > 0.0 && fa.x * fa.y < 0.0 && fb.x * fb.y > 0.0) {
      // Nearing the surface at one end and leaving it at the other: perhaps through it in between.
      float turn = a + (b - a) * fa.y / (fa.y - fb.y);
      vec2 f = above(along, turn, h);
      if (f.x * fa.x <= 0.0) {
        if (refine(along, a, turn, mix(a, turn, fa.x / (fa.x - f.x)), fa.x, rate, tolerance, spot)) return true;
        a = turn;
        fa = f;
      }
    }
    if (fa.x * fb.x <= 0.0) {
      if (refine(along, a, b, mix(a, b, fa.x / (fa.x - fb.x)), fa.x, rate, tolerance, spot)) return true;
    }
    a = b;
    fa = fb;
  }
  return false;
}

#ifndef CHANNELS
// The junction's own asphalt, and within 8 m of a cut more and more that of the road which ends there.
vec3 albedo_at(Spot spot) {
  vec2 width = abs(spot.step_x.xy) + abs(spot.step_y.xy);
  JunctionHeader header = headers[junction];
  vec2 p = header.phase.xy + spot.place.xy;
  vec3 albedo = material_albedo(0, p.x, p.y, 0.0, 0.0, width.x, width.y);
  for (uint i = 0u; i < header.range.y; ++i) {
    JunctionCut c = cut_at(header.range.x + i);
    float across = c.left - c.right;
    vec2 left = vec2(c.x0 - c.x1, c.y0 - c.y1) / across;
    vec2 d = spot.place.xy - vec2(c.x1, c.y1);
    float n = dot(d, left) + c.right;
    float ahead = d.x * left.y - d.y * left.x;
    float beyond = n - clamp(n, c.right, c.left);
    float part = 1.0 - smoothstep(0.0, 8.0, sqrt(ahead * ahead + beyond * beyond));
    if (!(part > 0.0)) continue;
    vec4 road = cut_rows[4u * (header.range.x + i) + 3u];
    float from_middle = n - 0.5 * (n > 0.0 ? c.left : c.right);
    float width_t = dot(abs(left), width);
    float wheel = material_wheel(from_middle - 0.5 * width_t, from_middle + 0.5 * width_t);
    albedo = mix(albedo, material_albedo(0, road.x + road.y * ahead, road.y * n, wheel, road.z,
                                         dot(abs(left.yx), width), width_t), part);
  }
  return albedo;
}
#endif

void main() {
  vec3 along = point - eye;
  float reach = length(along);
  along /= reach;
  // The part of the ray within the box, measured from its back.
  vec3 slow = vec3(lessThan(abs(along), vec3(1e-9)));
  vec3 inverse = 1.0 / mix(along, vec3(1e-9), slow);
  vec3 k0 = (low - point) * inverse;
  vec3 k1 = (high - point) * inverse;
  vec3 enter = min(k0, k1);
  vec3 leave = max(k0, k1);
  float near = max(max(enter.x, enter.y), max(enter.z, reach * (forward.w / max(dot(along, forward.xyz) * reach, 1e-6) - 1.0)));
  float far = min(leave.x, min(leave.y, leave.z));
  if (!(near < far)) discard;
  // A hundredth of a pixel, or a millimetre.
  float tolerance = max(1e-3, 0.01 * right.w * (reach + near));
  Spot spot;
  if (!intersect(along, near, far, tolerance, spot)) discard;
#ifdef CHANNELS
  uvec4 ids = headers[junction].ids;
  out_road = vec4(-2.0 - float(ids.x), spot.place.xy, 0.0);
  out_normal = vec4(spot.normal, 0.0);
  out_label = vec2(2.0, float(ids.y));
#else
  out_color = vec4(frame_shade(albedo_at(spot), frame_light(spot.normal, spot.position)), spot.coverage);
#endif
  float depth = dot(spot.position, forward.xyz);
#ifndef CHANNELS
  // One depth serves all samples of the pixel: the nearest within it, as for roads.
  depth -= 0.5 * (abs(dot(spot.step_x, forward.xyz)) + abs(dot(spot.step_y, forward.xyz)));
#endif
  // Strips along the corners lie on it.
  if (spot.under && headers[junction].phase.z > 0.0) depth += 0.02;
  gl_FragDepth = forward.w / max(depth, forward.w);
}
