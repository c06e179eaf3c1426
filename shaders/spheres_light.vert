// Tiles of the screen in which spheres were drawn, as rectangles of a row.
#include "frame.glsl"
#include "spheres.glsl"

layout(std430, binding = 5) readonly buffer TileRuns { uvec2 tile_runs[]; };  // first and last of a row; the row
layout(location = 3) uniform vec2 tile_size;                                   // where the screen is 2 wide and high

void main() {
  uvec2 run = tile_runs[gl_VertexID / 6];
  int corner = gl_VertexID % 6;
  bool right_side = corner == 1 || corner == 2 || corner == 4;
  bool top = corner == 2 || corner == 4 || corner == 5;
  vec2 tile = vec2(float(right_side ? (run.x >> 16) + 1u : run.x & 0xffffu), float(run.y + (top ? 1u : 0u)));
  gl_Position = vec4(tile * tile_size - vec2(1.0), 0.0, 1.0);
}
