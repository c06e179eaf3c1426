// The ground's look: material by slope, height and distance from roads, noise that fades with the pixel's footprint, or a
// user's textures. With HOLLOWS, what lies
// in the clear space of tunnels is cut away.
#ifdef HOLLOWS
#include "lib/road.glsl"
#include "lib/marking.glsl"
#include "lib/sweep.glsl"
#endif
#include "lib/noise.glsl"
#include "lib/ground.glsl"
#include "frame.glsl"
#include "outputs.glsl"

in vec3 relative;
in vec3 ground_normal;
in float road_m;

#ifndef CHANNELS
const float kInside = 0.3;  // light within a hill

layout(binding = 5) uniform sampler2D ground_textures[3];  // of grass, rock and gravel, linear light
// Their repeats, m: two, the second turned, whose mixture changes from place to place. Both fit into NOISE_PERIOD, also as
// turned by (3, 4) / 5. Where a pixel holds so much of the ground that repeats would be seen side by side, their mean
// takes over, with the noise of the material's own look.
const float kRepeat_m = 4.0, kTurnedRepeat_m = 12.8, kTextured_m = 0.06;

vec3 ground_texture(sampler2D texture, vec2 place, float footprint, float share, float shade) {
  // Bounded: what is sampled at a place that is not finite, or far off, may never end.
  vec2 p = clamp(place, vec2(-65536.0), vec2(65536.0));
  float size = clamp(footprint, 1e-4, 64.0);
  vec2 turned = vec2(3.0 * p.x + 4.0 * p.y, 3.0 * p.y - 4.0 * p.x) / 5.0;
  vec3 a = textureGrad(texture, p / kRepeat_m, vec2(size / kRepeat_m, 0.0), vec2(0.0, size / kRepeat_m)).rgb;
  vec3 b = textureGrad(texture, turned / kTurnedRepeat_m, vec2(size / kTurnedRepeat_m, 0.0),
                       vec2(0.0, size / kTurnedRepeat_m)).rgb;
  vec3 mean = textureLod(texture, vec2(0.5), 16.0).rgb;
  float near = 1.0 / (1.0 + size * size / (kTextured_m * kTextured_m));
  return mix(mean * shade, mix(a, b, clamp(0.5 + 0.8 * share, 0.0, 1.0)) * mix(shade, 1.0, 0.5), near);
}
#endif

#ifdef HOLLOWS
in vec3 in_tile;
layout(location = 1) uniform uvec2 cut;  // the hollows that the triangles may meet: the first, and how many

// Hollow of terrain/hollow.h, as roadgen/render/renderer.cc packs it.
struct Hollow {
  vec4 start;  // relative to the tile's origin, m
  vec4 shape;  // chord x, y (m), slopes a, b
  vec4 arc;    // arc length (m), c0, c1; depth of the floor
  vec4 axis;   // z0, z1, z2, z3
  vec4 place;  // n0, n1, u0, u1
  vec4 box;    // y0, y1, z0, z1: m from the start, chord axes
  vec4 vault;  // half width, height of the arch's centre, its radius
};
layout(std430, binding = 4) readonly buffer Hollows { Hollow hollows[]; };

bool is_cut_away(Hollow h) {
  SweepPath path = SweepPath(length(h.shape.xy), h.shape.z, h.shape.w, h.arc.x, h.arc.y, h.arc.z, h.axis.x, h.axis.y,
                             h.axis.z, h.axis.w, h.place.x, h.place.y, 0.0, 0.0, 0.0);
  SweepProfile profile = SweepProfile(SWEEP_LINING, h.vault.x, h.vault.y, h.vault.z, 0.0, h.arc.w, 0.0);
  SweepPosts posts = SweepPosts(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
  SweepPiece piece = SweepPiece(path, profile, posts, h.place.z, h.place.w, 0.0, 0.0, h.box.x, h.box.y, h.box.z,
                                h.box.w);
  vec3 from = in_tile - h.start.xyz;
  vec2 chord = h.shape.xy / path.chord;
  return sweep_hollow(dot(from.xy, chord), from.y * chord.x - from.x * chord.y, from.z, piece) < 0.0;
}
#endif

void main() {
#ifdef HOLLOWS
  for (uint i = 0u; i < cut.y; ++i) {
    if (is_cut_away(hollows[cut.x + i])) discard;
  }
#endif
  vec3 normal = normalize(ground_normal);
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(normal, 0.0);
  out_label = vec2(1.0, 0.0);
#else
  vec2 place = relative.xy + eye_phase.xy;
  // Between the pixel's short and long side on the ground: sharp where it faces the eye, calm where it is grazed, by the
  // triangle itself too, which may be seen edge on where the ground's normal is not.
  float distance_m = length(relative);
  vec3 flat_normal = normalize(cross(dFdx(relative), dFdy(relative)));
  float facing = min(abs(dot(normal, relative)), abs(dot(flat_normal, relative))) / distance_m;
  float footprint = distance_m * right.w / sqrt(max(facing, 0.005));
  float altitude = (relative.z - ground.x) * ground.y;
  float steepness = 1.0 - normal.z;
  float broad = noise_fractal(place.x, place.y, 512.0, 3, 0.55, footprint);
  vec3 middle = noise_fractal_slope(place.x, place.y, 64.0, 6, 0.5, footprint);
  float fine = 0.5 * noise_fractal(place.x, place.y, 2.0, 7, 0.95, footprint);
  float bareness = ground_bareness(steepness, altitude, broad, middle.x, fine);
  // Layers of the rock: bands by height, bent by the middle noise.
  float band = relative.z - ground.x + 9.0 * middle.x + 14.0 * broad;
  float strata = noise_value(band, 37.0, 8.0) * noise_band(8.0, footprint) * 0.6 +
                 noise_value(band, 71.0, 32.0) * noise_band(32.0, footprint) * 0.6;
  vec3 grass = ground_grass(altitude, broad, middle.x, fine), rock = ground_rock(middle.x, fine, strata);
  vec3 gravel = ground_gravel(fine);
  int textured = int(ground.z);
  float shade = 1.0 + 0.3 * broad + 0.3 * middle.x + 0.4 * fine;
  if ((textured & 1) != 0) grass = ground_texture(ground_textures[0], place, footprint, middle.x, shade);
  if ((textured & 2) != 0) rock = ground_texture(ground_textures[1], place, footprint, middle.x, shade + 0.5 * strata);
  if ((textured & 4) != 0) gravel = ground_texture(ground_textures[2], place, footprint, middle.x, shade);
  float verge = ground_verge(road_m, middle.x, fine, footprint);
  vec3 albedo = mix(mix(grass, rock, bareness), ground_snow(),
                    ground_snowiness(steepness, altitude, broad, middle.x, fine));
  albedo = mix(albedo, gravel, verge);
  // Bumps of the rock up to 3 m, of the meadow up to 0.6 m.
  vec3 bumped = normalize(normal - vec3(middle.yz, 0.0) * mix(0.7, 4.0, bareness));
  // Over junctions in tunnels it is seen from below: bare rock that no daylight reaches.
  out_color = vec4(gl_FrontFacing ? frame_shade(albedo, frame_light(bumped, relative))
                                  : frame_tone(kInside * ground_rock(middle.x, fine, strata)), 1.0);
#endif
}
