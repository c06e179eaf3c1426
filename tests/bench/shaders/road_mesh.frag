// A tessellated road, shaded as road.frag shades.
#include "road_mesh.glsl"

void main() {
  Spot spots[SPOTS];
  spots[0] = mesh_spot();
  Look looks[SPOTS];
  looks[0] = look_at(spots[0]);
  Pixel pixel = cross_section(spots, looks, false);
  if (!(pixel.coverage > 0.0)) discard;
  out_color = vec4(pixel.color / pixel.coverage, pixel.coverage);
}
