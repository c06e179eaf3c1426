// In place of shaders/spheres.frag: every pixel of the polygon counts as accepted.
flat in uint sphere_index;
layout(location = 0) out uint out_index;

void main() {
  out_index = sphere_index + 1u;
  gl_FragDepth = 1.0;
}
