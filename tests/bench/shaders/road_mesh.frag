// A tessellated road shaded by the very functions of road.frag, which get (s, t) from the mesh.
#define main cookie_cut
#include "road.frag"
#undef main

in vec2 st;
in vec3 left_and_grade;

void main() {
  Spot spots[SPOTS];
  Spot spot;
  spot.s = st.x;
  spot.t = st.y;
  spot.p = vec2(0.0);
  spot.position = relative;
  spot.left = normalize(left_and_grade.xy);
  spot.normal = normalize(vec3(-left_and_grade.z * vec2(spot.left.y, -spot.left.x), 1.0));
  spot.s_step = vec2(dFdx(st.x), dFdy(st.x));
  spot.t_step = vec2(dFdx(st.y), dFdy(st.y));
  spot.on = true;
  spots[0] = spot;
  Look looks[SPOTS];
  looks[0] = look_at(spot);
  Pixel pixel = cross_section(spots, looks);
  if (!(pixel.coverage > 0.0)) discard;
  out_color = vec4(pixel.color / pixel.coverage, pixel.coverage);
}
