// A tessellated road whose markings and wheel tracks come from a texture of one period: red, the part that is paint;
// green, the wear by wheels.
#include "road_mesh.glsl"

layout(binding = 0) uniform sampler2D markings;
layout(location = 1) uniform vec2 size;   // of the texture along s and t, m

#ifdef PROBES
layout(location = 2) uniform int probes;  // greatest anisotropy

// The filter that GL_EXT_texture_filter_anisotropic describes, for drivers that do not tell its levels apart: up to
// `probes` trilinear ones along the footprint's longer axis.
vec2 anisotropic(vec2 place, vec2 dx, vec2 dy) {
  vec2 texels = vec2(textureSize(markings, 0));
  float px = length(dx * texels);
  float py = length(dy * texels);
  float longer = max(px, py);
  float n = clamp(ceil(longer / max(min(px, py), 1e-6)), 1.0, float(probes));
  vec2 axis_step = px > py ? dx : dy;
  vec2 sum = vec2(0.0);
  for (float i = 1.0; i <= n; i += 1.0) {
    sum += textureLod(markings, place + axis_step * (i / (n + 1.0) - 0.5), log2(longer / n)).rg;
  }
  return sum / n;
}
#endif

void main() {
  Spot spots[SPOTS];
  spots[0] = mesh_spot();
  Spot spot = spots[0];
  Look look = look_at(spot);
  float coverage = left_of(spots, Corner(0, 0)) - left_of(spots, Corner(int(section_row(ids.y).x) - 1, 0));
  if (!(coverage > 0.0)) discard;
  vec2 place = vec2(fract(spot.s / size.x), clamp(spot.t / size.y + 0.5, 0.0, 1.0));
  vec2 dx = clamp(vec2(spot.s_step.x, spot.t_step.x) / size, -1e3, 1e3);
  vec2 dy = clamp(vec2(spot.s_step.y, spot.t_step.y) / size, -1e3, 1e3);
#ifdef PROBES
  vec2 found = anisotropic(place, dx, dy);
#else
  vec2 found = textureGrad(markings, place, dx, dy).rg;
#endif
  vec3 asphalt = material_color(0, spot.s, spot.t, found.g, look.noise, 0.0, 0.0, 0.0, 0.0);
  out_color = vec4(mix(frame_shade(asphalt, look.light), paint_color(0, look), found.r), coverage);
}
