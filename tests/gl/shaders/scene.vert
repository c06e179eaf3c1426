// Triangles that pierce each other, made up from their number.
out vec3 color;
out vec2 chord;

float noise(uint n) {
  n = (n ^ 61u) ^ (n >> 16);
  n *= 9u;
  n ^= n >> 4;
  n *= 0x27d4eb2du;
  n ^= n >> 15;
  return float(n & 0xffffu) / 65535.0;
}

void main() {
  uint seed = uint(gl_InstanceID) * 64u;
  uint corner = seed + 8u * uint(gl_VertexID);
  vec2 center = vec2(noise(seed), noise(seed + 1u)) * 2.0 - 1.0;
  vec2 offset = vec2(noise(corner + 2u), noise(corner + 3u)) * 2.0 - 1.0;
  color = vec3(noise(seed + 4u), noise(seed + 5u), noise(corner + 6u));
  chord = vec2(noise(corner + 7u), 0.4 * noise(corner + 9u) - 0.2);
  gl_Position = vec4(center + offset, noise(corner + 8u), 1.0);
}
