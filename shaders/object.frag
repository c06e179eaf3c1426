// Casts the pixel's ray at one object. NAME_HITS and so on are the primitive's functions. ONE_SURFACE: no part of it hides
// another.
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

// Of the object, read once.
ObjectShape shape = object_shape(objects[index]);
// Its columns are the rows of the shape's frame from the world.
mat3 inverse_ = mat3(vec3(objects[index].inverse[0].xyz), vec3(objects[index].inverse[1].xyz),
                     vec3(objects[index].inverse[2].xyz));

struct ObjectRay {
  vec3 o;
  vec3 d;
  float at_o;
};

// Through a place of the picture, in pixels.
ObjectRay ray_at(vec2 pixel) {
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

vec3 in_shape(vec3 v) { return v * inverse_; }

vec3 object_normal(ObjectSite site, vec3 offset) {
  return normalize(inverse_ * NAME_NORMAL(site.p + in_shape(offset), site.face, shape));
}

vec2 object_uv(ObjectSite site, vec3 offset) {
  return NAME_UV(site.p + in_shape(offset), site.face, shape);
}

// Of a solid every second hit leaves it.
bool object_exit(ObjectSite site, vec3 direction, out ObjectSite next) {
  next = site;
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

// What the ray through a place of the picture meets first.
struct ObjectMet {
  bool any;
  float k;
  ObjectSite site;
  vec2 pixel;
};

// Of the view through it, 1 along the view axis.
vec3 met_direction(ObjectMet met) {
  vec2 from_middle = (met.pixel - vec2(view_size.xy)) * right.w;
  return forward.xyz + right.xyz * from_middle.x + up.xyz * from_middle.y;
}

// Unit; of open shapes to the eye.
vec3 met_normal(ObjectMet met) {
  vec3 normal = object_normal(met.site, vec3(0.0));
  return (shape.flags & OBJECT_SOLID) == 0 && dot(normal, met_direction(met)) > 0.0 ? -normal : normal;
}

#ifndef IN_TEXTURE_SPACE
ObjectMet met_at(vec2 pixel) {
  ObjectRay ray = ray_at(pixel);
  ObjectHits hits = NAME_HITS(ray.o, ray.d, ray.at_o, shape);
  int first = object_first(hits, forward.w - place.z);
  float k = hits.k[0];
  int face = hits.face[0];
  for (int i = 1; i < 4; ++i) {
    k = first == i ? hits.k[i] : k;
    face = first == i ? hits.face[i] : face;
  }
  return ObjectMet(first >= 0, k, ObjectSite(ray.o + ray.d * k, face), pixel);
}
#endif

#ifndef CHANNELS
vec3 tone_of(ObjectMet met) {
  ObjectPoint point;
  point.position = met_direction(met) * (place.z + met.k);
  point.normal = met_normal(met);
  point.tint = vec3(1.0);
  ObjectMaterial material = object_materials[floatBitsToUint(objects[index].axes[1].w)];
  return frame_tone(object_light(point, material, met.site));
}
#endif

#if SAMPLES > 1
layout(location = 2) uniform int sample_count;              // SAMPLES, unknown to compilers: they would write the loop out
layout(location = 3) uniform vec2 sample_places[SAMPLES];  // from the pixel's centre

// Samples that see surfaces whose normals are farther apart than this (cosine) are shaded apart.
const float kSameSurface = 0.9;

// What the samples of a pixel see, of which there is one colour: the surface at the centre, or else at the first sample on
// the object, and the first that is another one, as beyond a rim or where a box cuts an open surface off before its back.
struct ObjectPixel {
  int mask;
  ObjectMet met;
  ObjectMet other;
  int samples;  // of met
  int others;   // of other; < SAMPLES
};

// All by one call: compilers take far longer over two.
ObjectPixel pixel_at(vec2 center) {
  ObjectPixel pixel;
  pixel.mask = 0;
  pixel.met = ObjectMet(false, 0.0, ObjectSite(vec3(0.0), 0), center);
  pixel.other = pixel.met;
  pixel.samples = 0;
  pixel.others = 0;
  vec3 normal = vec3(0.0);
  for (int i = -1; i < sample_count; ++i) {
    bool at_center = i < 0;
    if (!at_center && (gl_SampleMaskIn[0] & (1 << i)) == 0) continue;
    ObjectMet met = met_at(at_center ? center : center + sample_places[max(i, 0)]);
    if (!met.any) continue;
#ifdef ONE_SURFACE
    if (!pixel.met.any) pixel.met = met;
    const bool same = true;
#else
    vec3 there = met_normal(met);
    if (!pixel.met.any) {
      pixel.met = met;
      normal = there;
    }
    bool same = met.site.face == pixel.met.site.face && dot(there, normal) > kSameSurface;
#endif
    if (at_center) continue;
    pixel.mask |= 1 << i;
    if (same) {
      ++pixel.samples;
    } else {
      if (pixel.others == 0) pixel.other = met;
      ++pixel.others;
    }
  }
  if (pixel.samples == 0) {
    pixel.met = pixel.other;
    pixel.samples = pixel.others;
    pixel.others = 0;
  }
  return pixel;
}
#endif

void main() {
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
  ObjectMet met = ObjectMet(true, forward.w / max(gl_FragCoord.z, 1e-30) - place.z, ObjectSite(vec3(in_plane, 0.0), 0),
                            gl_FragCoord.xy);
#elif SAMPLES > 1
  ObjectPixel pixel = pixel_at(gl_FragCoord.xy);
  gl_SampleMask[0] = pixel.mask;
  if (pixel.mask == 0) discard;
  ObjectMet met = pixel.met;
#else
  ObjectMet met = met_at(gl_FragCoord.xy);
#if defined(IN_PLANE) && defined(PROXY_OUTLINE)
  if (dot(in_plane, in_plane) > 1.0) met.any = false;
#endif
  if (!met.any) discard;
#endif
#ifdef CHANNELS
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(met_normal(met), 0.0);
  out_label = vec2(5.0, float(first_instance + floatBitsToUint(objects[index].axes[0].w)));
#else
#if SAMPLES > 1 && !defined(ONE_SURFACE)
  // Once, or twice where there are others: a loop whose end compilers do not know, since drivers that run both sides of every
  // branch leave loops early.
  vec3 sum = vec3(0.0);
  for (int i = 0; i <= pixel.others; i += max(pixel.others, 1)) {
    sum += float(i == 0 ? pixel.samples : pixel.others) * tone_of(met);
    met = pixel.other;
  }
  met = pixel.met;
  out_color = vec4(sum / float(pixel.samples + pixel.others), 1.0);
#else
  out_color = vec4(tone_of(met), 1.0);
#endif
#endif
#ifndef IN_TEXTURE_SPACE
  gl_FragDepth = min(forward.w / max(place.z + met.k, forward.w), gl_FragCoord.z);
#endif
}
