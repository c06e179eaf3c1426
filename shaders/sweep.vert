// The box around one piece of a sweep: its footprint between the cross sections at its ends, extruded to its range of
// heights. Its back faces are drawn, so that the eye may be inside.
#include "lib/road.glsl"
#include "frame.glsl"
#include "sweep.glsl"

layout(location = 0) in uint in_index;

flat out uint index;
flat out vec2 axis;  // unit chord direction in ENU
flat out vec3 eye;   // in chord axes, metres from the start anchor
out vec3 point;      // likewise

void main() {
  SweepInstance sweep = sweeps[in_index];
  precise vec3 start = (sweep.start_high.xyz - eye_high.xyz) + (sweep.start_low.xyz - eye_low.xyz);
  float chord = length(sweep.shape.xy);
  float a = sweep.shape.z;
  float b = sweep.shape.w;
  axis = sweep.shape.xy / chord;
  index = in_index;

  // Room for antialiased edges, two pixels at the piece's distance, and for posts that stand on its ends.
  float middle_m = length(start + 0.5 * vec3(sweep.shape.xy, 0.0));
  float margin = clamp(2.0 * right.w * middle_m, 0.02, 2.0);
  float pad = margin + (sweep.posts.z > 0.0 ? max(sweep.posts.w, sweep.post.x) : 0.0);
  bool at_left = (gl_VertexID & 1) != 0;
  bool at_end = (gl_VertexID & 2) != 0;
  bool at_top = (gl_VertexID & 4) != 0;
  float y = at_left ? sweep.box.y + margin : sweep.box.x - margin;
  float z = at_top ? sweep.box.w + margin : sweep.box.z - margin;
  float u = at_end ? sweep.place.w : sweep.place.z;
  float slope = road_df(u, a, b);
  float x = chord * u - slope * (y - chord * road_f(u, a, b)) + (at_end ? pad : -pad) * sqrt(1.0 + slope * slope);
  point = vec3(x, y, z);
  eye = vec3(-dot(start.xy, axis), start.x * axis.y - start.y * axis.x, -start.z);
  vec3 relative = start + vec3(axis * x + vec2(-axis.y, axis.x) * y, z);
  gl_Position = clip_from_relative * vec4(relative, 1.0);
}
