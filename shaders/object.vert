// A polygon or a hull that covers one object on the screen, and the object's rays: in its own frame they are linear in the
// pixel, o + k d with d = ahead + x per_x + y per_y, (x, y) pixels from `place`, and o = origin + place.z (x per_x + y per_y).
// place.z is the depth that k is counted from: that of the object's centre, or 0 where the eye is near it.
// What is drawn, PROXY_OUTLINE, PROXY_RECTANGLE, PROXY_FLAT or PROXY_HULL; NAME_PROXY, NAME_NEAR and NAME_OUTLINE are the
// primitive's own functions.
#include "frame.glsl"
#include "objects.glsl"

layout(std430, binding = 3) readonly buffer Objects { ObjectInstance objects[]; };
layout(location = 0) in uint in_index;
layout(location = 1) in vec3 in_corner;

flat out uint index;
flat out vec4 origin;  // w: the shape's value there, in double where it is the eye
flat out vec3 ahead;
flat out vec3 per_x;
flat out vec3 per_y;
flat out vec3 place;  // xy: pixels; z: m
#ifdef IN_PLANE
out vec2 in_plane;  // the place in the plane of the shape or of its circle
#endif

#ifdef AT_EYE
// The shape's value at an eye that is near it, which single precision would not tell from 0.
double sphere_at_eye(dvec3 e, ObjectShape s) { return dot(e, e) - 1.0lf; }
double cone_at_eye(dvec3 e, ObjectShape s) {
  double radius = double(s.p0) + double(s.p1) * e.z;
  return e.x * e.x + e.y * e.y - radius * radius;
}
double quadric_at_eye(dvec3 e, ObjectShape s) {
  if ((s.flags & OBJECT_PLANES) != 0) return 0.0lf;  // not used
  return e.x * (s.p0 * e.x + s.p3 * e.y + s.p4 * e.z + s.p6) + e.y * (s.p1 * e.y + s.p5 * e.z + s.p7) +
         e.z * (s.p2 * e.z + s.p8) + s.p9;
}
#endif

// The whole screen, for an object around the eye.
vec4 whole_screen(vec2 corner, float depth) { return vec4(corner * 2.0, depth, 1.0); }

void main() {
  ObjectInstance object = objects[in_index];
  ObjectShape shape = object_shape(object);
  dvec3 from_eye = object.center.xyz - dvec3(view_right.w, view_up.w, view_forward.w);
  dvec3 center = dvec3(dot(view_right.xyz, from_eye), dot(view_up.xyz, from_eye), dot(view_forward.xyz, from_eye));
  float radius = float(object.center.w);
  vec3 corner = in_corner;
  index = in_index;
  float pixel = float(view_size.z);
  float near = forward.w;

  // The eye in the object's frame.
  dvec3 eye_exact = -dvec3(dot(object.inverse[0].xyz, from_eye), dot(object.inverse[1].xyz, from_eye),
                           dot(object.inverse[2].xyz, from_eye));
  vec3 eye = vec3(eye_exact);
  float eye2 = dot(eye, eye);

  // Where the rays begin, and at which pixel they are counted from.
  bool far = eye2 > 9.0 && center.z > double(radius);
  dvec2 base = far ? center.xy / (center.z * view_size.z) : dvec2(0.0);
  place = vec3(vec2(base + view_size.xy), far ? float(center.z) : 0.0);
  vec3 through = vec3(vec2(base * view_size.z), 1.0);
  vec3 row0 = object_in_view(object.inverse[0].xyz);
  vec3 row1 = object_in_view(object.inverse[1].xyz);
  vec3 row2 = object_in_view(object.inverse[2].xyz);
  ahead = vec3(dot(row0, through), dot(row1, through), dot(row2, through));
  per_x = vec3(row0.x, row1.x, row2.x) * pixel;
  per_y = vec3(row0.y, row1.y, row2.y) * pixel;
  origin = far ? vec4(0.0) : vec4(eye, 0.0);
#ifdef AT_EYE
  if (!far) origin.w = float(AT_EYE(eye_exact, shape));
#endif

  if (float(center.z) + radius < near) {
    // Behind the near plane.
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  // The nearest that anything of it can be: what is written is never in front of this.
  float depth = near / max(float(center.z) - 1.000001 * radius, near);
  vec2 scale = 1.0 / eye_phase.zw;
#ifdef PROXY_RECTANGLE
  // The tangent lines of the projected conic: planes through the eye of normal (1, 0, -m) touch where
  // (c.x - m c.z)^2 = |n.x - m n.z|^2, n the rows of the axes; likewise across y.
  dvec3 a0 = object_in_view(dvec3(object.axes[0].xyz));
  dvec3 a1 = object_in_view(dvec3(object.axes[1].xyz));
  dvec3 a2 = object_in_view(dvec3(object.axes[2].xyz));
  dvec3 squares = a0 * a0 + a1 * a1 + a2 * a2;
  dvec2 mixed = a0.xy * a0.z + a1.xy * a1.z + a2.xy * a2.z;
  double a = center.z * center.z - squares.z;
  dvec2 b = center.xy * center.z - mixed;
  dvec2 disc = b * b - a * (center.xy * center.xy - squares.xy);
  vec2 side = sign(object_around(corner));
  if (a <= 1e-6 * center.z * center.z || center.z <= 0.0 || disc.x <= 0.0 || disc.y <= 0.0) {
    gl_Position = whole_screen(side, 1.0);
  } else {
    vec2 m = vec2((b + dvec2(side) * sqrt(disc)) / a);
    gl_Position = vec4(m * scale, depth, 1.0);
  }
#else
#ifdef PROXY_OUTLINE
#ifdef IN_PLANE
  in_plane = vec2(0.0);
#endif
  if (NAME_NEAR(eye, shape)) {
    gl_Position = whole_screen(object_around(corner) * corner.z, 1.0);
    return;
  }
  vec3 q = NAME_OUTLINE(corner, eye, shape);
#ifdef IN_PLANE
  in_plane = object_around(corner);
#endif
#else
  vec3 q = NAME_PROXY(corner, shape);
#ifdef IN_PLANE
  in_plane = corner.xy;
#endif
#endif
  vec3 offset = object.axes[0].xyz * q.x + object.axes[1].xyz * q.y + object.axes[2].xyz * q.z;
  dvec3 at = center + dvec3(object_in_view(dvec3(offset)));
  float w = float(at.z);
#if defined(IN_PLANE) && defined(PROXY_FLAT)
  gl_Position = vec4(float(at.x) * scale.x, float(at.y) * scale.y, near, w);
#else
  gl_Position = vec4(float(at.x) * scale.x, float(at.y) * scale.y, depth * w, w);
#endif
#endif
}
