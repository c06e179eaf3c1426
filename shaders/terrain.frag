// The ground's look: material by slope and height, noise that fades with the pixel's footprint.
#include "lib/noise.glsl"
#include "lib/ground.glsl"
#include "frame.glsl"
#include "outputs.glsl"

in vec3 relative;
in vec3 ground_normal;

void main() {
  vec3 normal = normalize(ground_normal);
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(normal, 0.0);
  out_label = vec2(1.0, 0.0);
#else
  vec2 place = relative.xy + eye_phase.xy;
  float footprint = length(relative) * right.w * 1.5;
  float broad = noise_fractal(place.x, place.y, 512.0, 3, 0.55, footprint);
  float middle = noise_fractal(place.x, place.y, 32.0, 3, 0.6, footprint);
  float fine = noise_fractal(place.x, place.y, 2.0, 4, 0.7, footprint);
  float altitude = (relative.z - ground.x) * ground.y;
  vec3 albedo = ground_albedo(1.0 - normal.z, altitude, broad, middle, fine);
  out_color = vec4(frame_tone(frame_shade(albedo, normal, relative)), 1.0);
#endif
}
