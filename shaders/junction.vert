// One junction per instance: the box around its surface, whose back faces the pixel shader starts from.
#include "frame.glsl"
#include "junctions.glsl"

flat out uint junction;
flat out vec3 eye;   // from the centre, ENU
flat out vec3 low;   // the box
flat out vec3 high;
out vec3 point;      // from the centre

void main() {
  junction = uint(gl_InstanceID);
  JunctionHeader header = headers[junction];
  precise vec3 center = (header.center_high.xyz - eye_high.xyz) + (header.center_low.xyz - eye_low.xyz);
  eye = -center;
  // Room for the antialiased edge, two pixels at the junction's distance, and for what lies under its corners.
  float margin = clamp(2.0 * right.w * length(center), 0.02, 2.0) + header.phase.z;
  low = header.low.xyz - margin;
  high = header.high.xyz + margin;
  point = mix(low, high, bvec3((gl_VertexID & 2) != 0, (gl_VertexID & 1) != 0, (gl_VertexID & 4) != 0));
  gl_Position = clip_from_relative * vec4(center + point, 1.0);
}
