#include "lib/road.glsl"
in vec3 color;
in vec2 chord;
layout(location = 0) out vec4 picture;

void main() {
  RoadCoord c = road_project(chord.x, chord.y, 0.4, -0.3);
  float ramp = clamp((0.05 - abs(c.v)) * 100.0, 0.0, 1.0);
  picture = vec4(mix(color, vec3(c.u), ramp), 1.0);
}
