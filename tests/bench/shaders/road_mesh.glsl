// A spot of a tessellated road, for the very functions of road.frag.
#define main cookie_cut
#include "road.frag"
#undef main

in vec2 st;
in vec3 left_and_grade;

Spot mesh_spot() {
  Spot spot;
  spot.s = st.x;
  spot.t = st.y;
  spot.p = vec2(0.0);
  spot.position = relative;
  spot.left = normalize(left_and_grade.xy);
  spot.normal = normalize(vec3(-left_and_grade.z * vec2(spot.left.y, -spot.left.x), 1.0));
  spot.s_step = vec2(dFdx(st.x), dFdy(st.x));
  spot.t_step = vec2(dFdx(st.y), dFdy(st.y));
  spot.w_step = vec2(0.0);
  spot.h = 0.0;
  spot.on = true;
  return spot;
}
