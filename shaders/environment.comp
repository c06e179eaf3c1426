// Fills one level of the environment's cube, as roadgen/render/environment.cc asks by define:
//   FROM_SKY       level 0 from the procedural sky and plain ground, without the sun, which lights objects by itself
//   FROM_PANORAMA  level 0 from an image whose rows go from the zenith down, its middle column to the east, columns
//                  clockwise seen from above
//   FILTER         a level from the cube as it is: the mean over the lobe of a roughness, seen along its normal
#include "lib/sky.glsl"
#include "lib/light.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba16f, binding = 0) writeonly uniform imageCube level;

#ifdef FROM_SKY
layout(location = 0) uniform vec3 toward_sun;
#endif
#ifdef FROM_PANORAMA
layout(binding = 0) uniform sampler2D panorama;
#endif
#ifdef FILTER
layout(binding = 0) uniform samplerCube source;
layout(location = 0) uniform float alpha;
layout(location = 1) uniform int samples;
layout(location = 2) uniform float texel;  // solid angle of a texel of the source in the middle of a face
#endif

// OpenGL's own order of faces: +x, -x, +y, -y, +z, -z; q in [-1, 1].
vec3 cube_direction(uint face, vec2 q) {
  if (face == 0u) return vec3(1.0, -q.y, -q.x);
  if (face == 1u) return vec3(-1.0, -q.y, q.x);
  if (face == 2u) return vec3(q.x, 1.0, q.y);
  if (face == 3u) return vec3(q.x, -1.0, -q.y);
  if (face == 4u) return vec3(q.x, -q.y, 1.0);
  return vec3(-q.x, -q.y, -1.0);
}

#ifdef FROM_SKY
vec3 radiance(vec3 d, float width) {
  vec3 sky = sky_gradient(d.z, dot(d, toward_sun));
  vec3 ground = mix(vec3(0.15, 0.16, 0.09), sky, exp(min(d.z, 0.0) * 14.0));
  return mix(ground, sky, smoothstep(-0.5 * width, 0.5 * width, d.z));
}
#endif
#ifdef FROM_PANORAMA
vec3 radiance(vec3 d, float width) {
  vec2 size = vec2(textureSize(panorama, 0));
  // Its own level of detail: none is left to derivatives, which know nothing of the seam. Rows are as wide as the angle
  // between them; toward the poles columns are narrower, which the mean over the texel makes up for.
  float detail = max(log2(width * size.y / LIGHT_PI), 0.0);
  vec2 place = vec2(0.5 - atan(d.y, d.x) / (2.0 * LIGHT_PI), acos(clamp(d.z, -1.0, 1.0)) / LIGHT_PI);
  return textureLod(panorama, place, detail).rgb;
}
#endif

#ifdef FILTER
vec3 mean(vec3 n) {
  vec3 aside = normalize(abs(n.z) < 0.9 ? cross(vec3(0.0, 0.0, 1.0), n) : cross(vec3(1.0, 0.0, 0.0), n));
  vec3 ahead = cross(n, aside);
  vec3 sum = vec3(0.0);
  float weight = 0.0;
  for (int i = 0; i < samples; ++i) {
    // Hammersley's points.
    vec3 h = light_half_vector((float(i) + 0.5) / float(samples), float(bitfieldReverse(uint(i))) * 2.3283064e-10, alpha);
    vec3 l = vec3(2.0 * h.z * h.x, 2.0 * h.z * h.y, 2.0 * h.z * h.z - 1.0);
    if (!(l.z > 0.0)) continue;
    // Each sample stands for its part of the lobe, and is taken from a level whose texels are about as wide.
    float density = 0.25 * light_distribution(vec3(0.0, 0.0, 1.0), h, alpha);
    float detail = 0.5 * log2(1.0 / (float(samples) * max(density, 1e-6)) / texel) + 1.0;
    sum += l.z * textureLod(source, aside * l.x + ahead * l.y + n * l.z, max(detail, 0.0)).rgb;
    weight += l.z;
  }
  return sum / weight;
}
#endif

void main() {
  int size = imageSize(level).x;
  if (any(greaterThanEqual(gl_GlobalInvocationID.xy, uvec2(size)))) return;
  uint face = gl_GlobalInvocationID.z;
#ifdef FILTER
  vec2 q = (vec2(gl_GlobalInvocationID.xy) + 0.5) * (2.0 / float(size)) - 1.0;
  vec3 light = mean(normalize(cube_direction(face, q)));
#else
  vec3 light = vec3(0.0);
  for (int i = 0; i < 16; ++i) {
    vec2 q = (vec2(gl_GlobalInvocationID.xy) + (vec2(float(i & 3), float(i >> 2)) + 0.5) * 0.25) * (2.0 / float(size)) - 1.0;
    light += radiance(normalize(cube_direction(face, q)), 0.25 * 1.5 / float(size)) * 0.0625;
  }
#endif
  imageStore(level, ivec3(gl_GlobalInvocationID), vec4(min(light, vec3(60000.0)), 1.0));
}
