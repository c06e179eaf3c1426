// The picture, or the data, of the spheres that spheres.frag found, once a pixel.
layout(location = 0) flat in vec4 right;  // as in frame.glsl
layout(location = 1) flat in vec4 up;
layout(location = 2) flat in vec4 forward;
layout(location = 3) flat in vec4 sun;
layout(location = 4) flat in vec4 given_material[4];
#ifndef CHANNELS
layout(location = 8) flat in vec4 given_harmonics[7];
#endif
vec4 eye_phase = vec4(0.0, 0.0, given_material[3].zw);
#ifndef CHANNELS
vec3 environment_harmonic(int i) {
  int k = 3 * i;
  return vec3(given_harmonics[k / 4][k % 4], given_harmonics[(k + 1) / 4][(k + 1) % 4],
              given_harmonics[(k + 2) / 4][(k + 2) % 4]);
}
#endif
#define FRAME_GIVEN
#include "frame.glsl"
#include "spheres.glsl"
#include "outputs.glsl"

#if SAMPLES > 1
layout(binding = 4) uniform usampler2DMS seen;
layout(location = 40) uniform vec2 sample_places[SAMPLES];
#else
layout(binding = 4) uniform usampler2D seen;
#endif
layout(location = 1) uniform uint first_instance;  // of the channel

struct SpherePoint {
  vec3 position;  // relative to the eye, ENU
  vec3 normal;    // outward
  vec3 direction; // 1 along the view axis
  vec3 local;     // on the unit sphere, in ENU
  float per_radius;
};

// Requires: the sphere is met by the ray there, or passed within rounding. NEAR: where some of the set's are near.
SpherePoint sphere_point(uint slot, vec2 pixel) {
  vec4 place = sphere_place(slot);
  float per_radius = 1.0 / place.w;
  SphereRay ray = sphere_ray(pixel, place);
  float k = sphere_front(ray);
  float depth = place.z + k;
  // From the centre: the ray's place at the centre's depth, and on from there. On the unit sphere, in the view's axes.
  vec3 p = vec3(ray.o + ray.d * k, k) * per_radius;
#ifdef NEAR
  uint radius = sphere_look(slot).z;
  if (radius != 0u) {
    per_radius = 1.0 / uintBitsToFloat(radius);
    depth = sphere_first_near(pixel, place, per_radius, forward.w, true);
    p = place.xyz + vec3(ray.d, 1.0) * (depth * per_radius);
  }
#endif
  SpherePoint s;
  s.direction = forward.xyz + right.xyz * ray.d.x + up.xyz * ray.d.y;
  s.position = s.direction * depth;
  s.local = right.xyz * p.x + up.xyz * p.y + forward.xyz * p.z;
  s.normal = normalize(s.local);
  s.per_radius = per_radius;
  return s;
}

struct ObjectSite {
  vec3 p;  // on the unit sphere, in ENU
  float part;  // 1 / radius
};

vec3 object_normal(ObjectSite site, vec3 offset) { return normalize(site.p + offset * site.part); }

vec2 object_uv(ObjectSite site, vec3 offset) {
  ObjectShape none = ObjectShape(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0);
  return sphere_uv(normalize(site.p + offset * site.part), 0, none);
}

bool object_exit(ObjectSite site, vec3 direction, out ObjectSite next) {
  next = site;
  next.p -= direction * (2.0 * dot(site.p, direction));
  return true;
}

#ifndef CHANNELS
#include "object_light.glsl"

vec3 sphere_light(uint slot, vec2 pixel) {
  SpherePoint s = sphere_point(slot, pixel);
  ObjectPoint p;
  p.position = s.position;
  p.normal = s.normal;
  vec3 color = unpackUnorm4x8(sphere_look(slot).x).rgb;
  p.tint = color * color;
  ObjectMaterial material =
      ObjectMaterial(given_material[0], given_material[1], given_material[2], given_material[3]);
  return object_light(p, material, ObjectSite(s.normal, s.per_radius));
}
#endif

void main() {
#if SAMPLES > 1
  // Each sphere of the pixel once, by how many samples it has.
  uint ids[SAMPLES];
  int mask = 0;
  for (int i = 0; i < SAMPLES; ++i) {
    ids[i] = texelFetch(seen, ivec2(gl_FragCoord.xy), i).x;
    if (ids[i] != 0u) mask |= 1 << i;
  }
  if (mask == 0) discard;
  vec3 sum = vec3(0.0);
  float count = 0.0;
  for (int i = 0; i < SAMPLES; ++i) {
    if (ids[i] == 0u) continue;
    float same = 0.0;
    for (int k = 0; k < SAMPLES; ++k) {
      if (ids[k] != ids[i]) continue;
      // Computed where it was met before.
      if (k < i) {
        same = 0.0;
        break;
      }
      same += 1.0;
    }
    if (same == 0.0) continue;
    vec2 off = same == float(SAMPLES) ? vec2(0.0) : sample_places[i];
    sum += same * frame_tone(sphere_light(ids[i] - 1u, gl_FragCoord.xy + off));
    count += same;
  }
  gl_SampleMask[0] = mask;
  out_color = vec4(sum / count, 1.0);
#else
  uint id = texelFetch(seen, ivec2(gl_FragCoord.xy), 0).x;
  if (id == 0u) discard;
#ifdef CHANNELS
  SpherePoint s = sphere_point(id - 1u, gl_FragCoord.xy);
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(s.normal, 0.0);
  out_label = vec2(5.0, float(first_instance + sphere_look(id - 1u).y));
#else
  out_color = vec4(frame_tone(sphere_light(id - 1u, gl_FragCoord.xy)), 1.0);
#endif
#endif
}
