// In place of shaders/spheres.frag: every pixel of the polygon counts as accepted.
flat in uvec4 slot_and_lens;
layout(location = 0) out uint out_index;

void main() {
  out_index = slot_and_lens.x + 1u;
  gl_FragDepth = 1.0;
}
