// In place of shaders/sky.frag: black, since the peer draws no sky.
#include "frame.glsl"
#include "outputs.glsl"

void main() {
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(0.0);
  out_label = vec2(0.0);
#else
  out_color = vec4(0.0, 0.0, 0.0, 1.0);
#endif
}
