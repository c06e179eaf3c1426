// In place of shaders/sky.vert: nothing, since the peer draws no sky. What is cleared stays black.
out vec3 direction;

void main() {
  direction = vec3(0.0);
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}
