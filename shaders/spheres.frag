// Which sphere a pixel, or a sample, sees: its index and depth alone. What it looks like is computed once a pixel
// (spheres_light.frag), however many spheres lie behind one another there.
#include "frame.glsl"
#include "spheres.glsl"

flat in uint sphere_index;
flat in vec4 place;
#ifdef NEAR
flat in vec4 eye;
#else
flat in vec2 ahead;
#endif
#ifdef IN_PLANE
in vec2 in_plane;
#endif
#if SAMPLES > 1
layout(location = 40) uniform vec2 sample_places[SAMPLES];  // from the pixel's centre
#endif

layout(depth_less) out float gl_FragDepth;
layout(location = 0) out uint out_index;  // 1 + index

float first_at(vec2 pixel) {
#ifdef NEAR
  return sphere_first_near(pixel, eye, place.w, forward.w, false);
#else
  return sphere_first_far(pixel, place, ahead, forward.w, false);
#endif
}

void main() {
#if defined(IN_PLANE) && SAMPLES == 1
  if (dot(in_plane, in_plane) > 1.0) discard;
#endif
  float k = first_at(gl_FragCoord.xy);
#if SAMPLES > 1
  int mask = 0;
  for (int i = 0; i < SAMPLES; ++i) {
    float met = first_at(gl_FragCoord.xy + sample_places[i]);
    if (met == OBJECT_FAR) continue;
    mask |= 1 << i;
    // The centre is not on the sphere: the depth of the first sample that is.
    if (k == OBJECT_FAR) k = met;
  }
  gl_SampleMask[0] = mask;
#endif
  if (k == OBJECT_FAR) discard;
  out_index = sphere_index + 1u;
  gl_FragDepth = forward.w / (place.z + k);
}
