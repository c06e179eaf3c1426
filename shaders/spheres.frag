// Which sphere a pixel, or a sample, sees: its slot and depth alone. What it looks like is computed once a pixel
// (spheres_light.frag), however many spheres lie behind one another there.

// Beside the slot what it needs of the frame, for the reason that spheres_light.vert names. The unit of length is the near
// plane's distance, so that it needs no more.
flat in uvec4 slot_and_lens;
vec4 right = vec4(0.0, 0.0, 0.0, uintBitsToFloat(slot_and_lens.y));
vec4 up = vec4(0.0);
vec4 forward = vec4(0.0, 0.0, 0.0, 1.0);
vec4 sun = vec4(0.0);
vec4 eye_phase = vec4(0.0, 0.0, uintBitsToFloat(slot_and_lens.zw));
#define FRAME_GIVEN
#include "frame.glsl"
#include "spheres.glsl"

flat in vec4 place;
#ifdef NEAR
flat in float per_radius;
#endif
#ifdef IN_PLANE
in vec2 in_plane;
#endif
#if SAMPLES > 1
layout(location = 40) uniform vec2 sample_places[SAMPLES];  // from the pixel's centre
#endif

layout(depth_less) out float gl_FragDepth;
layout(location = 0) out uint out_index;  // 1 + slot

// Depth in the buffer of what the ray meets; 0 where it passes.
float depth_at(vec2 pixel) {
#ifdef NEAR
  float k = sphere_first_near(pixel, place, per_radius, 1.0, false);
  return k == OBJECT_FAR ? 0.0 : 1.0 / k;
#else
  SphereRay r = sphere_ray(pixel, place);
  return r.half2 < 0.0 ? 0.0 : 1.0 / (place.z + sphere_front(r));
#endif
}

void main() {
#if defined(IN_PLANE) && SAMPLES == 1
  if (dot(in_plane, in_plane) > 1.0) discard;
#endif
  float depth = depth_at(gl_FragCoord.xy);
#if SAMPLES > 1
  int mask = 0;
  for (int i = 0; i < SAMPLES; ++i) {
    float met = depth_at(gl_FragCoord.xy + sample_places[i]);
    if (met == 0.0) continue;
    mask |= 1 << i;
    // The centre is not on the sphere: the depth of the first sample that is.
    if (depth == 0.0) depth = met;
  }
  gl_SampleMask[0] = mask;
#endif
  if (depth == 0.0) discard;
  out_index = slot_and_lens.x + 1u;
  gl_FragDepth = depth;
}
