// In place of shaders/spheres.frag: every pixel of the polygon counts as accepted.
flat in uint sphere_slot;
layout(location = 0) out uint out_index;

void main() {
  out_index = sphere_slot + 1u;
  gl_FragDepth = 1.0;
}
