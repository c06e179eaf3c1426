// Sky, sun and a few high clouds; with PANORAMA, what the environment shows.
#include "lib/noise.glsl"
#include "frame.glsl"
#include "outputs.glsl"
#include "environment.glsl"

in vec3 direction;

void main() {
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(0.0);
  out_label = vec2(0.0);
#elif defined(PANORAMA)
  out_color = vec4(frame_tone(environment_mirrored(normalize(direction), 0.0, right.w)), 1.0);
#else
  vec3 d = normalize(direction);
  float toward = dot(d, sun.xyz);
  vec3 color = sky_gradient(d.z, toward);
  if (d.z > 0.02) {
    // A thin layer at 6 km, drawn out by the wind.
    vec2 place = d.xy / d.z * 6000.0;
    float footprint = right.w * 6000.0 / (d.z * d.z);
    float shape = noise_fractal(place.x * 0.06, place.y * 0.11, 512.0, 5, 0.55, footprint * 0.1);
    float cover = smoothstep(0.15, 1.1, shape) * smoothstep(0.02, 0.22, d.z) * 0.75;
    color = mix(color, vec3(1.0, 0.98, 0.96) * (0.85 + 0.4 * max(toward, 0.0)), cover);
  }
  color += vec3(12.0, 11.0, 9.0) * sky_sun_disc(toward);
  out_color = vec4(frame_tone(color), 1.0);
#endif
}
