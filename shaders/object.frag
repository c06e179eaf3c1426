// Casts the pixel's ray at one object. NAME_HITS and so on are the primitive's functions.
#include "frame.glsl"
#include "objects.glsl"
#include "outputs.glsl"

flat in uint index;
flat in vec4 origin;
flat in vec3 ahead;
layout(std430, binding = 3) readonly buffer Objects { ObjectInstance objects[]; };
flat in vec3 per_x;
flat in vec3 per_y;
flat in vec3 place;
#ifdef IN_PLANE
in vec2 in_plane;
#endif
layout(location = 1) uniform uint first_instance;  // of the channel

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
  vec3 across = per_x * at.x + per_y * at.y;
  ObjectRay r;
  r.o = origin.xyz + across * place.z;
  r.d = ahead + across;
  r.at_o = origin.w;
#ifdef AT_EYE
  if (place.z > 0.0) r.at_o = NAME_VALUE(r.o, shape);
#endif
  return r;
}

struct ObjectSite {
  vec3 p;    // in the shape's frame
  int face;
};

vec3 in_shape(vec3 v) {
  return vec3(dot(vec3(objects[index].inverse[0].xyz), v), dot(vec3(objects[index].inverse[1].xyz), v),
              dot(vec3(objects[index].inverse[2].xyz), v));
}

vec3 object_normal(ObjectSite site, vec3 offset) {
  vec3 slope = NAME_NORMAL(site.p + in_shape(offset), site.face, object_shape(objects[index]));
  return normalize(vec3(objects[index].inverse[0].xyz) * slope.x + vec3(objects[index].inverse[1].xyz) * slope.y +
                   vec3(objects[index].inverse[2].xyz) * slope.z);
}

vec2 object_uv(ObjectSite site, vec3 offset) {
  return NAME_UV(site.p + in_shape(offset), site.face, object_shape(objects[index]));
}

// Of a solid every second hit leaves it.
bool object_exit(ObjectSite site, vec3 direction, out ObjectSite next) {
  next = site;
  ObjectShape shape = object_shape(objects[index]);
  if ((shape.flags & OBJECT_SOLID) == 0) return false;
  vec3 d = in_shape(direction);
  // Face 0 is where the value is 0; the others are cuts.
  ObjectHits hits = NAME_HITS(site.p, d, site.face == 0 ? 0.0 : NAME_VALUE(site.p, shape), shape);
  // Shapes are about 1 large.
  float least = 1e-4 * inversesqrt(dot(d, d));
  for (int i = 1; i < 4; i += 2) {
    if (i >= hits.count || hits.k[i] < least) continue;
    next.p = site.p + d * hits.k[i];
    next.face = hits.face[i];
    return true;
  }
  return false;
}

#ifndef CHANNELS
#include "object_light.glsl"
#endif

// Which samples of the pixel the object covers: the surface is shaded once, its outline is taken at each of them.
#if SAMPLES > 1
layout(location = 2) uniform int sample_count;              // SAMPLES, unknown to compilers: they would write the loop out
layout(location = 3) uniform vec2 sample_places[SAMPLES];  // from the pixel's centre
#endif

void main() {
  ObjectInstance object = objects[index];
  ObjectShape shape = object_shape(object);
  vec2 pixel = gl_FragCoord.xy;
#ifdef IN_TEXTURE_SPACE
#if SAMPLES > 1
  int mask = 0;
  vec2 plane_x = dFdx(in_plane);
  vec2 plane_y = dFdy(in_plane);
  for (int i = 0; i < sample_count; ++i) {
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
  // The pixel's centre, then its samples, in one place: compilers take far longer over two.
  float least = forward.w - place.z;
  ObjectRay ray;
  ObjectHits hits;
  int first = -1;
#if SAMPLES > 1
  int mask = 0;
  for (int i = -1; i < sample_count; ++i) {
    if (i >= 0 && (gl_SampleMaskIn[0] & (1 << i)) == 0) continue;
    bool centre = i < 0;
    vec2 at = centre ? pixel : gl_FragCoord.xy + sample_places[max(i, 0)];
#else
  {
    const bool centre = true;
    vec2 at = pixel;
#endif
    ObjectRay other = ray_at(at, shape);
    ObjectHits met = NAME_HITS(other.o, other.d, other.at_o, shape);
    int number = object_first(met, least);
#if defined(IN_PLANE) && defined(PROXY_ROUND)
    if (centre && dot(in_plane, in_plane) > 1.0) number = -1;
#endif
#if SAMPLES > 1
    if (number < 0) continue;
    if (!centre) mask |= 1 << i;
    // Where the centre is not on the object it is shaded where the first sample is.
    if (first >= 0) continue;
#endif
    pixel = at;
    ray = other;
    hits = met;
    first = number;
  }
#if SAMPLES > 1
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
  vec3 normal = vec3(object.inverse[0].xyz) * slope.x + vec3(object.inverse[1].xyz) * slope.y +
                vec3(object.inverse[2].xyz) * slope.z;
  normal = normalize(normal);
  vec2 from_middle = (pixel - vec2(view_size.xy)) * right.w;
  vec3 direction = forward.xyz + right.xyz * from_middle.x + up.xyz * from_middle.y;
  bool open = (shape.flags & OBJECT_SOLID) == 0;
  if (open && dot(normal, direction) > 0.0) normal = -normal;
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(normal, 0.0);
  out_label = vec2(5.0, float(first_instance + floatBitsToUint(object.axes[0].w)));
#else
  ObjectPoint point;
  point.position = direction * depth;
  point.normal = normal;
  point.tint = vec3(1.0);
  ObjectMaterial material = object_materials[floatBitsToUint(object.axes[1].w)];
  out_color = vec4(frame_tone(object_light(point, material, ObjectSite(p, face))), 1.0);
#endif
#ifndef IN_TEXTURE_SPACE
  gl_FragDepth = min(forward.w / max(depth, forward.w), gl_FragCoord.z);
#endif
}
