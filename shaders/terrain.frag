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
  // Between the pixel's short and long side on the ground: sharp where it faces the eye, calm where it is grazed.
  float distance_m = length(relative);
  float facing = abs(dot(normal, relative)) / distance_m;
  float footprint = distance_m * right.w / sqrt(max(facing, 0.05));
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
  vec3 albedo = ground_albedo(bareness, steepness, altitude, broad, middle.x, fine, strata);
  // Bumps of the rock up to 3 m, of the meadow up to 0.6 m.
  vec3 bumped = normalize(normal - vec3(middle.yz, 0.0) * mix(0.7, 4.0, bareness));
  out_color = vec4(frame_shade(albedo, frame_light(bumped, relative)), 1.0);
#endif
}
