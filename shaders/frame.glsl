// What all stages know of the frame. Positions on the GPU are relative to the eye, along the ENU axes.
#include "lib/sky.glsl"

// FRAME_GIVEN: what includes this has what it needs of it by the same names.
#ifndef FRAME_GIVEN
layout(std140, binding = 0) uniform Frame {
  mat4 clip_from_relative;  // reversed depth: near plane 1, infinity 0
  vec4 eye_high;            // eye in ENU metres = eye_high + eye_low (two floats hold what one double does)
  vec4 eye_low;
  vec4 eye_phase;           // xy: eye modulo NOISE_PERIOD; zw: tangents of half the field of view, across and up
  vec4 forward;             // unit view axes in ENU; forward.w: near plane distance, m
  vec4 right;               // right.w: size of a pixel at distance 1
  vec4 up;                  // up.w: far plane distance, m
  vec4 sun;                 // unit direction toward the sun; w: haze range, m
  vec4 ground;              // x: lowest ground relative to the eye, m; y: 1 / relief, per m;
                            // z: which materials have textures: 1 grass, 2 rock, 4 gravel
};
#endif

// The view direction (1 along the view axis) at a corner of the picture, each coordinate of which is -1 or 1.
vec3 frame_corner_ray(vec2 corner) {
  return forward.xyz + right.xyz * (corner.x * eye_phase.z) + up.xyz * (corner.y * eye_phase.w);
}

// Change of a surface point per pixel step along `axis` (view right or up), by the tangent plane there.
vec3 frame_footprint(vec3 position, vec3 normal, vec3 axis) {
  float depth = max(dot(position, forward.xyz), 1e-3);
  vec3 direction = position / depth;
  vec3 step_dir = axis * right.w;
  float facing = dot(normal, direction);
  facing = abs(facing) < 1e-4 ? (facing < 0.0 ? -1e-4 : 1e-4) : facing;
  return depth * (step_dir - direction * (dot(normal, step_dir) / facing));
}

#include "shadows.glsl"

// What falls on a surface with this normal, and the air before it. position: relative to the eye.
struct FrameLight {
  vec3 light;
  vec3 air;
  float clear;
};

FrameLight frame_light(vec3 normal, vec3 position) {
  FrameLight l;
  float lit = max(dot(normal, sun.xyz), 0.0);
#ifdef SUN_KINDS
  if (lit > 0.0) {
    lit *= sun_seen(position, frame_footprint(position, normal, right.xyz), frame_footprint(position, normal, up.xyz));
  }
#endif
  l.light = sky_sun_color() * lit + sky_ambient(normal.z);
  float distance_m = length(position);
  vec3 direction = position / max(distance_m, 1e-6);
  l.clear = sky_transmittance(distance_m, sun.w);
  l.air = sky_gradient(max(direction.z, 0.0) * 0.5, dot(direction, sun.xyz));
  return l;
}

vec3 frame_tone(vec3 light) { return vec3(sky_tone(light.x), sky_tone(light.y), sky_tone(light.z)); }

// What arrives from a diffuse surface, and what the picture shows of it.
vec3 frame_radiance(vec3 albedo, FrameLight l) { return mix(l.air, albedo * l.light, l.clear); }
vec3 frame_shade(vec3 albedo, FrameLight l) { return frame_tone(frame_radiance(albedo, l)); }
