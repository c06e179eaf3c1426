// Tiles of the screen in which spheres were drawn, as rectangles of a row.
//
// What the light needs of the frame, the environment and the material goes with them, flat, in the 15 vectors that OpenGL
// has at least: llvmpipe looks up each number of a block at each use anew, and whether the block has it.
#include "frame.glsl"
#include "spheres.glsl"
#ifndef CHANNELS
#include "environment.glsl"
#endif

layout(std430, binding = 5) readonly buffer TileRuns { uvec2 tile_runs[]; };  // first and last of a row; the row
layout(location = 3) uniform vec2 tile_size;                                   // where the screen is 2 wide and high
#ifndef CHANNELS
layout(std140, binding = 4) uniform SetMaterial { ObjectMaterial set_material; };
#endif

layout(location = 0) flat out vec4 given_right;
layout(location = 1) flat out vec4 given_up;
layout(location = 2) flat out vec4 given_forward;
layout(location = 3) flat out vec4 given_sun;
layout(location = 4) flat out vec4 given_material[4];  // last row: zw: tangents of half the field of view
#ifndef CHANNELS
layout(location = 8) flat out vec4 given_harmonics[7];
#endif

void main() {
  uvec2 run = tile_runs[gl_VertexID / 6];
  int corner = gl_VertexID % 6;
  bool right_side = corner == 1 || corner == 2 || corner == 4;
  bool top = corner == 2 || corner == 4 || corner == 5;
  vec2 tile = vec2(float(right_side ? (run.x >> 16) + 1u : run.x & 0xffffu), float(run.y + (top ? 1u : 0u)));
  given_right = right;
  given_up = up;
  given_forward = forward;
  given_sun = sun;
#ifdef CHANNELS
  given_material = vec4[](vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0, 0.0, eye_phase.zw));
#else
  given_material = vec4[](set_material.base, set_material.surface, set_material.specular,
                          vec4(set_material.more.xy, eye_phase.zw));
  for (int i = 0; i < 27; ++i) given_harmonics[i / 4][i % 4] = environment_harmonics[i / 3][i % 3];
  given_harmonics[6].w = 0.0;
#endif
  gl_Position = vec4(tile * tile_size - vec2(1.0), 0.0, 1.0);
}
