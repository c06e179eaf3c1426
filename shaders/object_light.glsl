// The light that a point of an object sends to the eye: the sun, all that surrounds it, mirrored and refracted by the
// object's own surface, through the air. What includes this defines, for its kind of objects:
//
//   struct ObjectSite                             a point of one object's surface
//   vec3 object_normal(site, offset)              unit, outward, as far from the point as offset, ENU, m
//   vec2 object_uv(site, offset)
//   bool object_exit(site, direction, out next)   where a ray inside leaves; false: nowhere, as on flat and open shapes
//
// MATERIALS: what the materials that are drawn have, bits. What none has would be computed for all by drivers that run
// both sides of every branch, and compiled.
#include "environment.glsl"

#define MATERIALS_METAL 1   // metal and roughness
#define MATERIALS_PHONG 2
#define MATERIALS_TEXTURE 4
#define MATERIALS_MIRROR 8  // reflection
#define MATERIALS_GLASS 16  // transmission

#if (MATERIALS & (MATERIALS_METAL | MATERIALS_PHONG)) == MATERIALS_PHONG
#define OBJECT_BRDF light_brdf_phong
#elif (MATERIALS & MATERIALS_PHONG) == 0
#define OBJECT_BRDF light_brdf_metal_roughness
#else
#define OBJECT_BRDF light_brdf
#endif

layout(binding = 8) uniform sampler2DArray object_textures;

// How often light may be mirrored within an object before it is taken as going on straight.
const int kMostBounces = 4;

struct ObjectPoint {
  vec3 position;  // relative to the eye, ENU, m
  vec3 normal;    // unit, outward; of flat and open shapes to the eye
  vec3 tint;      // linear, times the material's base colour
};

#if MATERIALS & MATERIALS_TEXTURE
// The texture at the point, over the pixel: gradients are those of the surface there, whatever its neighbours show.
vec3 object_texture(ObjectSite site, float layer, vec3 step_x, vec3 step_y) {
  vec2 uv = object_uv(site, vec3(0.0));
  vec2 along_x = object_uv(site, step_x) - uv;
  vec2 along_y = object_uv(site, step_y) - uv;
  // Over the seam u jumps by 1.
  along_x.x -= round(along_x.x);
  along_y.x -= round(along_y.x);
  // Nothing that is not a number reaches the sampler.
  uv = clamp(uv, vec2(0.0), vec2(1.0));
  return textureGrad(object_textures, vec3(uv, layer), clamp(along_x, vec2(-1.0), vec2(1.0)),
                     clamp(along_y, vec2(-1.0), vec2(1.0))).rgb;
}
#endif

#if MATERIALS & MATERIALS_GLASS
// What comes through the object along d, or through a thin sheet.
vec3 object_through(ObjectSite site, vec3 d, vec3 n, bool within, float ior, float alpha, float width) {
  LightRefraction ray = light_refracted(d, n, within ? 1.0 / ior : ior);
  vec3 direction = ray.direction;
  float kept = 0.0;
  for (int i = 0; i < kMostBounces && !within; ++i) {
    ObjectSite next;
    if (!object_exit(site, direction, next)) {
      if (i == 0) direction = d;
      break;
    }
    vec3 outward = object_normal(next, vec3(0.0));
    ray = light_refracted(direction, -outward, 1.0 / ior);
    if (!ray.total) kept = light_fresnel(clamp(dot(direction, outward), 0.0, 1.0), 1.0 / ior);
    direction = ray.direction;
    if (!ray.total) break;
    site = next;
  }
  return (1.0 - kept) * environment_mirrored(direction, alpha, width);
}
#endif

// Angle between the directions in which neighbouring pixels see the environment mirrored.
float object_mirror_width(ObjectSite site, vec3 position, vec3 mirrored, vec3 step_x, vec3 step_y) {
  vec3 beside = light_mirrored(normalize(position + step_x), object_normal(site, step_x));
  vec3 above = light_mirrored(normalize(position + step_y), object_normal(site, step_y));
  return max(length(beside - mirrored), length(above - mirrored));
}

vec3 object_light(ObjectPoint p, ObjectMaterial m, ObjectSite site) {
  float distance_m = length(p.position);
  vec3 d = p.position / max(distance_m, 1e-6);
  bool within = dot(p.normal, d) > 0.0;
  vec3 n = within ? -p.normal : p.normal;
  float cosine = clamp(-dot(n, d), 1e-4, 1.0);
  vec3 step_x = frame_footprint(p.position, n, right.xyz);
  vec3 step_y = frame_footprint(p.position, n, up.xyz);

  vec3 base = m.base.rgb * p.tint;
#if MATERIALS & MATERIALS_TEXTURE
  if (m.more.y > 0.5) base *= object_texture(site, m.more.y - 1.0, step_x, step_y);
#endif
  float ior = m.more.x;
#if MATERIALS & MATERIALS_METAL
  bool phong = m.base.w > 0.5;
  LightSurface s = light_metal_roughness(base, m.surface.x, m.surface.y, ior);
#else
  const bool phong = true;
  LightSurface s;
#endif
#if MATERIALS & MATERIALS_PHONG
  if (phong) s = light_phong(base, m.specular.rgb, m.specular.w);
#endif
#if MATERIALS & MATERIALS_GLASS
  float transmission = m.surface.w;
#else
  const float transmission = 0.0;
#endif
  s.diffuse *= 1.0 - transmission;

  // What the sun sends.
  LightSurface sunlit = s;
  sunlit.alpha = max(s.alpha, LIGHT_SUN_ALPHA);
  float facing = dot(n, sun.xyz);
  vec3 light = vec3(0.0);
  if (facing > 0.0) light = OBJECT_BRDF(sunlit, n, sun.xyz, -d) * sky_sun_color() * (LIGHT_PI * facing);
#ifdef SUN_KINDS
  if (facing > 0.0) light *= sun_seen(p.position, step_x, step_y);
#endif

  // What comes from all around.
  vec3 part = vec3(0.0);
#if MATERIALS & MATERIALS_METAL
  if (!phong) {
    vec2 split = environment_part(cosine, s.alpha);
    part = s.f0 * split.x + vec3(split.y);
  }
#endif
  light += s.diffuse * environment_diffuse(n) * (vec3(1.0) - part);
#if MATERIALS & (MATERIALS_METAL | MATERIALS_MIRROR | MATERIALS_GLASS)
  vec3 mirrored = light_mirrored(d, n);
  float width = s.alpha < 0.2 ? object_mirror_width(site, p.position, mirrored, step_x, step_y) : 0.0;
#if MATERIALS & MATERIALS_GLASS
  float fresnel = transmission > 0.0 ? light_fresnel(cosine, within ? 1.0 / ior : ior) : 0.0;
  part = mix(part, vec3(fresnel), transmission);
  if (transmission > 0.0) {
    light += base * (transmission * (1.0 - fresnel)) * object_through(site, d, n, within, ior, s.alpha, width);
  }
#endif
  light += part * environment_mirrored(mirrored, s.alpha, width);
#if MATERIALS & MATERIALS_MIRROR
  light = mix(light, environment_mirrored(mirrored, 0.0, width), m.surface.z);
#endif
#endif
  float kept = sky_transmittance(distance_m, sun.w);
  return mix(sky_gradient(max(d.z, 0.0) * 0.5, dot(d, sun.xyz)), light, kept);
}
