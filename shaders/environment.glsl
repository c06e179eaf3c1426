// The light from all around, as roadgen/render/environment.h makes it.
#include "lib/light.glsl"

layout(std140, binding = 2) uniform EnvironmentLight {
  vec4 environment_harmonics[9];
  vec4 environment_cube;  // x: number of the last level
};
layout(binding = 6) uniform samplerCube environment_map;
layout(binding = 7) uniform sampler2D environment_table;

#ifndef FRAME_GIVEN
vec3 environment_harmonic(int i) { return environment_harmonics[i].rgb; }
#endif

// What a white diffuse surface sends out.
vec3 environment_diffuse(vec3 n) {
  // Written out, since drivers leave a loop over light_harmonic, with its many returns, a loop.
  vec3 sum = environment_harmonic(0) * light_harmonic(0, n) + environment_harmonic(1) * light_harmonic(1, n) +
             environment_harmonic(2) * light_harmonic(2, n) + environment_harmonic(3) * light_harmonic(3, n) +
             environment_harmonic(4) * light_harmonic(4, n) + environment_harmonic(5) * light_harmonic(5, n) +
             environment_harmonic(6) * light_harmonic(6, n) + environment_harmonic(7) * light_harmonic(7, n) +
             environment_harmonic(8) * light_harmonic(8, n);
  return max(sum, vec3(0.0));
}

// What a surface of this alpha mirrors. d: unit; width: angle between the directions of neighbouring pixels, whose mean is
// taken as a wider lobe: half of a lobe lies within 2 alpha, of a square within 0.4 of its side.
vec3 environment_mirrored(vec3 d, float alpha, float width) {
  float wide = min(0.2 * width, 1.0);
  float rough = sqrt(sqrt(alpha * alpha + wide * wide));
  // Clamped, so that nothing that is not a number reaches the sampler.
  float detail = clamp(rough, 0.0, 1.0) * environment_cube.x;
  bool sound = dot(d, d) > 0.5;
  return textureLod(environment_map, sound ? d : vec3(0.0, 0.0, 1.0), detail).rgb;
}

// Part of the mirrored light that comes back: f0 x + y.
vec2 environment_part(float cosine, float alpha) {
  return textureLod(environment_table, vec2(clamp(cosine, 0.0, 1.0), sqrt(clamp(alpha, 0.0, 1.0))), 0.0).xy;
}
