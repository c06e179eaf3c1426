// Casts the pixel's ray at one object. NAME_HITS and so on are the primitive's functions.
#include "frame.glsl"
#include "objects.glsl"
#include "outputs.glsl"

flat in uvec2 what;
flat in vec4 origin;
flat in vec3 ahead;
#ifndef SPHERES
layout(std430, binding = 3) readonly buffer Objects { ObjectInstance objects[]; };
flat in vec3 per_x;
flat in vec3 per_y;
#endif
flat in vec4 place;
#ifdef IN_PLANE
in vec2 in_plane;
#endif
layout(location = 1) uniform uint first_instance;  // of the channel
layout(location = 2) uniform uint set_material;

#if defined(IN_PLANE) && defined(PROXY_FLAT)
// The rasterizer's own depth is the shape's.
#define IN_TEXTURE_SPACE
#else
// What is written is never nearer than the polygon: hidden ones may be left out before they are computed.
layout(depth_less) out float gl_FragDepth;
#endif

struct ObjectRay {
  vec3 o;
  vec3 d;
  float at_o;
};

// Through a place of the picture, in pixels.
ObjectRay ray_at(vec2 pixel, ObjectShape shape) {
  vec2 at = pixel - place.xy;
#ifdef SPHERES
  vec3 across = vec3(at * (right.w * place.w), 0.0);
#else
  vec3 across = per_x * at.x + per_y * at.y;
#endif
  ObjectRay r;
  r.o = origin.xyz + across * place.z;
  r.d = ahead + across;
  r.at_o = origin.w;
#ifdef AT_EYE
  if (place.z > 0.0) r.at_o = NAME_VALUE(r.o, shape);
#endif
  return r;
}

#include "object_light.glsl"

// Which samples of the pixel the object covers: the surface is shaded once, its outline is taken at each of them.
#if SAMPLES > 1
layout(location = 3) uniform vec2 sample_places[SAMPLES];  // from the pixel's centre
#endif

void main() {
#ifdef SPHERES
  ObjectShape shape;
  shape.flags = OBJECT_SOLID;
#else
  ObjectInstance object = objects[what.x];
  ObjectShape shape = object_shape(object);
#endif
  vec2 pixel = gl_FragCoord.xy;
#ifdef IN_TEXTURE_SPACE
#if SAMPLES > 1
  int mask = 0;
  vec2 plane_x = dFdx(in_plane);
  vec2 plane_y = dFdy(in_plane);
  for (int i = 0; i < SAMPLES; ++i) {
    vec2 at = in_plane + plane_x * sample_places[i].x + plane_y * sample_places[i].y;
    if (NAME_INSIDE(at, shape) <= 0.0) mask |= 1 << i;
  }
  gl_SampleMask[0] = mask;
  if (mask == 0) discard;
#else
  if (NAME_INSIDE(in_plane, shape) > 0.0) discard;
#endif
  vec3 p = vec3(in_plane, 0.0);
  int face = 0;
  float depth = forward.w / max(gl_FragCoord.z, 1e-30);
#else
  float least = forward.w - place.z;
  ObjectRay ray = ray_at(pixel, shape);
  ObjectHits hits = NAME_HITS(ray.o, ray.d, ray.at_o, shape);
  int first = object_first(hits, least);
#if defined(IN_PLANE) && defined(PROXY_ROUND)
  if (dot(in_plane, in_plane) > 1.0) first = -1;
#endif
#if SAMPLES > 1
  int mask = 0;
  for (int i = 0; i < SAMPLES; ++i) {
    if ((gl_SampleMaskIn[0] & (1 << i)) == 0) continue;
    vec2 at = gl_FragCoord.xy + sample_places[i];
    ObjectRay other = ray_at(at, shape);
    ObjectHits met = NAME_HITS(other.o, other.d, other.at_o, shape);
    int number = object_first(met, least);
    if (number < 0) continue;
    mask |= 1 << i;
    if (first >= 0) continue;
    // The centre is not on the object: shade where the first sample is.
    pixel = at;
    ray = other;
    hits = met;
    first = number;
  }
  gl_SampleMask[0] = mask;
#endif
  if (first < 0) discard;
  float k = hits.k[0];
  int face = hits.face[0];
  for (int i = 1; i < 4; ++i) {
    k = first == i ? hits.k[i] : k;
    face = first == i ? hits.face[i] : face;
  }
  vec3 p = ray.o + ray.d * k;
  float depth = place.z + k;
#endif
  vec3 slope = NAME_NORMAL(p, face, shape);
#ifdef SPHERES
  vec3 normal = right.xyz * slope.x + up.xyz * slope.y + forward.xyz * slope.z;
#else
  vec3 normal = vec3(object.inverse[0].xyz) * slope.x + vec3(object.inverse[1].xyz) * slope.y +
                vec3(object.inverse[2].xyz) * slope.z;
#endif
  normal = normalize(normal);
  vec2 from_middle = (pixel - vec2(view_size.xy)) * right.w;
  vec3 direction = forward.xyz + right.xyz * from_middle.x + up.xyz * from_middle.y;
  bool open = (shape.flags & OBJECT_SOLID) == 0;
  if (open && dot(normal, direction) > 0.0) normal = -normal;
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(normal, 0.0);
#ifdef SPHERES
  out_label = vec2(5.0, float(first_instance + what.y));
#else
  out_label = vec2(5.0, float(first_instance + floatBitsToUint(object.axes[0].w)));
#endif
#else
  ObjectPoint point;
  point.position = direction * depth;
  point.normal = dot(normal, direction) > 0.0 ? -normal : normal;
  point.uv = NAME_UV(p, face, shape);
#ifdef SPHERES
  point.material = set_material;
  vec3 color = unpackUnorm4x8(what.x).rgb;
  point.tint = color * color;
#else
  point.material = floatBitsToUint(object.axes[1].w);
  point.tint = vec3(1.0);
#endif
  out_color = vec4(frame_tone(object_light(point)), 1.0);
#endif
#ifndef IN_TEXTURE_SPACE
  gl_FragDepth = min(forward.w / max(depth, forward.w), gl_FragCoord.z);
#endif
}
