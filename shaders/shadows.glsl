// Shadows that objects cast by the sun: each pixel asks the objects themselves, along rays toward the sun's disc. All rays
// are nearly parallel, so the objects lie in a grid across the sun's direction, and a pixel asks those of one cell.
// As roadgen/render/sun_grid.cc writes it.
#include "lib/object.glsl"
#include "lib/quadric.glsl"
#include "lib/torus.glsl"

#ifdef SUN_KINDS

// Of SUN_KINDS: what casts shadows. All objects but tori are quadrics in boxes (roadgen/render/sun_shape.h).
#define SUN_SPHERES 1
#define SUN_QUADRICS 2
#define SUN_TORI 4

const int kSunRays = 16;

layout(std140, binding = 3) uniform SunGrid {
  vec4 sun_across;  // unit axes across the sun's direction; w: the eye along them from the grid's corner, m
  vec4 sun_along;
  vec4 sun_eye;     // the eye from the origin that objects are counted from, m; w: 1 / side of a cell
  ivec4 sun_grid;   // columns, rows
  // Of each ray: the offset of its origin, in radii of a pixel, and of its direction, tangents: even over a disc each,
  // and neither follows the other.
  vec4 sun_rays[kSunRays];
};
// Where each cell's list begins, in order of rows, and where the last one ends; then the lists: numbers of objects, or
// kSphere and those of spheres.
layout(binding = 11) uniform usamplerBuffer sun_cells;
// Seven rows each: centre, radius of a ball around it; rows of the shape's frame, w: whether it is a torus, opacity; p0 to
// p9, flags.
layout(binding = 12) uniform samplerBuffer sun_objects;
layout(binding = 13) uniform samplerBuffer sun_spheres;  // centre, radius
uint sun_cell(uint i) { return texelFetch(sun_cells, int(i)).x; }
vec4 sun_object(uint row) { return texelFetch(sun_objects, int(row)); }
vec4 sun_sphere(uint i) { return texelFetch(sun_spheres, int(i)); }

const uint kSunSphere = 0x80000000u;
const float kSunDisc = 0.00465;  // tangent of its radius
const float kSunPixel = 0.564;   // radius of the disc that is as large as a pixel

// The rays of a pixel that an object or a sphere hides, bits. o: from its centre; least: nothing nearer hides.
#if SUN_KINDS & SUN_SPHERES
uint sun_behind_sphere(vec3 o, vec3 step_x, vec3 step_y, float radius, float least) {
  vec3 toward = sun.xyz, toward_x = sun_across.xyz, toward_y = sun_along.xyz;
  uint met = 0u;
  for (int ray = 0; ray < kSunRays; ++ray) {
    vec4 r = sun_rays[ray];
    vec3 p = o + step_x * r.x + step_y * r.y;
    vec3 d = toward + toward_x * r.z + toward_y * r.w;
    // Squares from the place nearest to the centre, for the digits of single precision.
    float per_d2 = 1.0 / dot(d, d);
    float k = -dot(p, d) * per_d2;
    vec3 nearest = p + d * k;
    float half2 = (radius * radius - dot(nearest, nearest)) * per_d2;
    if (half2 >= 0.0 && k + sqrt(half2) > least) met |= 1u << ray;
  }
  return met;
}
#endif

#if SUN_KINDS & (SUN_QUADRICS | SUN_TORI)
uint sun_behind_object(uint row, vec3 o, vec3 step_x, vec3 step_y, float least, uint hidden) {
  mat3 into = transpose(mat3(sun_object(row + 1u).xyz, sun_object(row + 2u).xyz, sun_object(row + 3u).xyz));
  vec4 a = sun_object(row + 4u), b = sun_object(row + 5u), c = sun_object(row + 6u);
  ObjectShape s = ObjectShape(a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w, c.x, c.y, int(c.z));
  bool torus = sun_object(row + 1u).w != 0.0;
  vec3 from = into * o, from_x = into * step_x, from_y = into * step_y;
  vec3 toward = into * sun.xyz, toward_x = into * sun_across.xyz, toward_y = into * sun_along.xyz;
  uint met = 0u;
  for (int ray = 0; ray < kSunRays; ++ray) {
    if ((hidden & (1u << ray)) != 0u) continue;
    vec4 r = sun_rays[ray];
    vec3 d = toward + toward_x * r.z + toward_y * r.w;
    vec3 p = from + from_x * r.x + from_y * r.y;
    float k = -dot(p, d) / dot(d, d);
    p += d * k;
    float last = -OBJECT_FAR;
#if SUN_KINDS & SUN_QUADRICS
    if (!torus) last = quadric_last(p, d, s);
#endif
#if SUN_KINDS & SUN_TORI
    if (torus) {
      ObjectHits hits = torus_hits(p, d, 0.0, s);
      for (int i = 0; i < 4; ++i) last = i < hits.count ? hits.k[i] : last;
    }
#endif
    if (k + last > least) met |= 1u << ray;
  }
  return met;
}
#endif

// Part of the sun's disc that is seen from a surface's pixel. position: relative to the eye; step_x, step_y: how it
// changes per pixel. Accuracy: positions are single precision from the middle of all objects; nearer than 1e-3 of an
// object's size nothing hides the sun, so that surfaces do not hide it from themselves.
float sun_seen(vec3 position, vec3 step_x, vec3 step_y) {
  vec2 place = vec2(dot(sun_across.xyz, position) + sun_across.w, dot(sun_along.xyz, position) + sun_along.w) * sun_eye.w;
  // Also where it is not a number.
  if (!(all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(sun_grid.xy))))) return 1.0;
  uint cell = uint(place.y) * uint(sun_grid.x) + uint(place.x);
  uint from = sun_cell(cell), to = sun_cell(cell + 1u);
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
    uint entry = sun_cell(i);
    bool is_sphere = (entry & kSunSphere) != 0u;
    uint row = 7u * entry;
    vec4 ball = is_sphere ? sun_sphere(entry & ~kSunSphere) : sun_object(row);
    vec3 o = at - ball.xyz;
    float k = -dot(o, sun.xyz);
    float beam = wide + kSunDisc * max(k, 0.0);
    float across = length(o + sun.xyz * k);
    if (across > ball.w + beam || k < -ball.w) continue;
    float least = max(1e-3 * ball.w, slack);
    uint met = 0u;
    float opacity = 1.0;
#if SUN_KINDS & SUN_SPHERES
    if (is_sphere) {
      if (k + sqrt(max(ball.w * ball.w - across * across, 0.0)) <= least) continue;
      if (across < ball.w - beam) return 0.0;
      met = sun_behind_sphere(o, step_x, step_y, ball.w, least);
    }
#endif
#if SUN_KINDS & (SUN_QUADRICS | SUN_TORI)
    if (!is_sphere) {
      opacity = sun_object(row + 2u).w;
      met = sun_behind_object(row, o, step_x, step_y, least, hidden);
    }
#endif
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
