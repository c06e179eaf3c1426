// Shadows that objects cast by the sun: each pixel asks the objects themselves, along rays toward the sun's disc. All rays
// are nearly parallel, so the objects lie in a grid across the sun's direction, and a pixel asks those of one cell.
// As roadgen/render/sun_grid.cc writes it.
#include "lib/object.glsl"
#include "lib/sphere.glsl"
#include "lib/quadric.glsl"
#include "lib/cone.glsl"
#include "lib/polyhedron.glsl"
#include "lib/torus.glsl"
#include "lib/planar.glsl"

#ifdef SUN_KINDS

layout(std140, binding = 3) uniform SunGrid {
  vec4 sun_across;  // unit axes across the sun's direction; w: the eye along them from the grid's corner, m
  vec4 sun_along;
  vec4 sun_eye;     // the eye from the origin that objects are counted from, m; w: 1 / side of a cell
  ivec4 sun_grid;   // columns, rows
};
// Where each cell's list begins, in order of rows, and where the last one ends; then the lists: numbers of objects, or
// kSphere and those of spheres.
layout(std430, binding = 7) readonly buffer SunCells { uint sun_cells[]; };
// Seven rows each: centre, radius of a ball around it; rows of the shape's frame, w: kind, opacity; p0 to p9, flags.
layout(std430, binding = 8) readonly buffer SunObjects { vec4 sun_objects[]; };
layout(std430, binding = 9) readonly buffer SunSpheres { vec4 sun_spheres[]; };  // centre, radius

const uint kSunSphere = 0x80000000u;
const float kSunDisc = 0.00465;  // tangent of its radius
const int kSunRays = 16;
const float kSunPixel = 0.564;  // radius of the disc that is as large as a pixel

// The ray's offset at its origin, in pixels, and of its direction, in radii of the sun: even over a disc each, and neither
// follows the other.
vec2 sun_offset(int i, float turns) {
  float turn = 2.39996323 * turns * float(i);
  return sqrt((float(i) + 0.5) / float(kSunRays)) * vec2(cos(turn), sin(turn));
}

// The last of what the ray from o along d meets, or -OBJECT_FAR.
float sun_last(vec3 o, vec3 d, int kind, ObjectShape s) {
  // From the place nearest to the shape's middle, for the digits of single precision.
  float ahead = -dot(o, d) / dot(d, d);
  vec3 p = o + d * ahead;
  ObjectHits h = object_none();
  // Only the kinds that the scene has, bits of SUN_KINDS: the others would have to be compiled.
#if SUN_KINDS & 1
  if (kind == 0) h = sphere_hits(p, d, sphere_value(p, s), s);
#endif
#if SUN_KINDS & 2
  if (kind == 1) h = quadric_hits(p, d, quadric_value(p, s), s);
#endif
#if SUN_KINDS & 4
  if (kind == 2) h = cone_hits(p, d, cone_value(p, s), s);
#endif
#if SUN_KINDS & 8
  if (kind == 3) h = box_hits(p, d, 0.0, s);
#endif
#if SUN_KINDS & 16
  if (kind == 4) h = tetra_hits(p, d, 0.0, s);
#endif
#if SUN_KINDS & 32
  if (kind == 5) h = torus_hits(p, d, 0.0, s);
#endif
#if SUN_KINDS & 64
  if (kind == 6) h = disc_hits(p, d, 0.0, s);
#endif
#if SUN_KINDS & 128
  if (kind == 7) h = conic_hits(p, d, 0.0, s);
#endif
#if SUN_KINDS & 256
  if (kind == 8) h = triangle_hits(p, d, 0.0, s);
#endif
#if SUN_KINDS & 512
  if (kind == 9) h = rhomb_hits(p, d, 0.0, s);
#endif
  float last = -OBJECT_FAR;
  for (int i = 0; i < 4; ++i) last = i < h.count ? h.k[i] : last;
  return ahead + last;
}

// Part of the sun's disc that is seen from a surface's pixel. position: relative to the eye; step_x, step_y: how it
// changes per pixel. Accuracy: positions are single precision from the middle of all objects; nearer than 1e-3 of an
// object's size nothing hides the sun, so that surfaces do not hide it from themselves.
float sun_seen(vec3 position, vec3 step_x, vec3 step_y) {
  vec2 place = vec2(dot(sun_across.xyz, position) + sun_across.w, dot(sun_along.xyz, position) + sun_along.w) * sun_eye.w;
  // Also where it is not a number.
  if (!(all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(sun_grid.xy))))) return 1.0;
  uint cell = uint(place.y) * uint(sun_grid.x) + uint(place.x);
  uint from = sun_cells[cell], to = sun_cells[cell + 1u];
  if (from == to) return 1.0;
  vec3 at = position + sun_eye.xyz;
  // A quarter of a cell is what objects have as a margin there.
  float wide = max(length(step_x), length(step_y)) * kSunPixel;
  float kept = min(1.0, 0.25 / max(wide * sun_eye.w, 1e-6));
  step_x *= kept * kSunPixel;
  step_y *= kept * kSunPixel;
  wide *= kept;
  float slack = 4e-7 * max(max(abs(at.x), abs(at.y)), abs(at.z));

  const uint all_rays = (1u << kSunRays) - 1u;
  uint hidden = 0u;
  float clear = 1.0;
  for (uint i = from; i < to; ++i) {
    uint entry = sun_cells[i];
    bool is_sphere = (entry & kSunSphere) != 0u;
    uint row = 7u * entry;
    vec4 ball = is_sphere ? sun_spheres[entry & ~kSunSphere] : sun_objects[row];
    vec3 o = at - ball.xyz;
    float k = -dot(o, sun.xyz);
    float beam = wide + kSunDisc * max(k, 0.0);
    float across = length(o + sun.xyz * k);
    if (across > ball.w + beam || k < -ball.w) continue;
    float least = max(1e-3 * ball.w, slack);
    uint met = 0u;
    if (is_sphere) {
      if (k + sqrt(max(ball.w * ball.w - across * across, 0.0)) <= least) continue;
      if (across < ball.w - beam) return 0.0;
    }
    int kind = is_sphere ? 0 : int(sun_objects[row + 1u].w);
    ObjectShape s = ObjectShape(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, OBJECT_SOLID);
    vec3 x = vec3(1.0 / ball.w, 0.0, 0.0), y = x.yxz, z = x.yzx;
    float opacity = 1.0;
    if (!is_sphere) {
      x = sun_objects[row + 1u].xyz;
      y = sun_objects[row + 2u].xyz;
      z = sun_objects[row + 3u].xyz;
      opacity = sun_objects[row + 2u].w;
      vec4 a = sun_objects[row + 4u], b = sun_objects[row + 5u], c = sun_objects[row + 6u];
      s = ObjectShape(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, int(c.z));
    }
    for (int ray = 0; ray < kSunRays; ++ray) {
      if ((hidden & (1u << ray)) != 0u) continue;
      vec2 start = sun_offset(ray, 1.0);
      vec2 lean = sun_offset(ray, 2.0) * kSunDisc;
      vec3 from_middle = o + step_x * start.x + step_y * start.y;
      vec3 d = sun.xyz + sun_across.xyz * lean.x + sun_along.xyz * lean.y;
      vec3 p = vec3(dot(x, from_middle), dot(y, from_middle), dot(z, from_middle));
      if (sun_last(p, vec3(dot(x, d), dot(y, d), dot(z, d)), kind, s) > least) met |= 1u << ray;
    }
    if (opacity < 1.0) {
      clear *= 1.0 - opacity * float(bitCount(met)) / float(kSunRays);
    } else {
      hidden |= met;
      if (hidden == all_rays) return 0.0;
    }
  }
  return clear * (1.0 - float(bitCount(hidden)) / float(kSunRays));
}
#endif
