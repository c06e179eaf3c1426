// Casts the eye ray at one piece of a sweep: profile and posts, their silhouettes by what they cover of the pixel.
#include "lib/road.glsl"
#include "lib/marking.glsl"
#include "lib/noise.glsl"
#include "lib/sweep.glsl"
#include "frame.glsl"
#include "outputs.glsl"
#include "sweep.glsl"

flat in uint index;
flat in vec2 axis;
flat in vec3 eye;
in vec3 point;

SweepPiece piece_of(SweepInstance i) {
  SweepPath path = SweepPath(length(i.shape.xy), i.shape.z, i.shape.w, i.arc.x, i.arc.y, i.arc.z, i.axis.x, i.axis.y,
                             i.axis.z, i.axis.w, i.place.x, i.place.y, i.bends.z, i.bends.w, i.kinds.x);
  SweepProfile profile = SweepProfile(int(i.kinds.y), i.profile.x, i.profile.y, i.profile.z, i.profile.w, i.bends.x,
                                      i.bends.y);
  SweepPosts posts = SweepPosts(i.posts.x, i.posts.y, i.posts.z, i.posts.w, i.post.x, i.post.y, i.post.z, i.post.w);
  return SweepPiece(path, profile, posts, i.place.z, i.place.w, i.ends.x, i.ends.y, i.box.x, i.box.y, i.box.z, i.box.w);
}

vec3 world(vec3 chord) { return vec3(axis * chord.x + vec2(-axis.y, axis.x) * chord.y, chord.z); }

// Zinc: half diffuse, half a blurred mirror of sky and ground.
vec3 metal(vec3 albedo, vec3 normal, vec3 position) {
  vec3 mirrored = reflect(normalize(position), normal);
  vec3 sky = sky_gradient(max(mirrored.z, 0.0), dot(mirrored, sun.xyz));
  vec3 around = mix(vec3(0.10, 0.10, 0.08), sky, smoothstep(-0.25, 0.25, mirrored.z));
  float clear = sky_transmittance(length(position), sun.w);
  return 0.6 * frame_radiance(albedo, frame_light(normal, position)) + 0.4 * (1.0 - clear) * frame_radiance(vec3(0.0), frame_light(normal, position)) +
         0.7 * clear * albedo * mix(vec3(dot(around, vec3(0.3, 0.6, 0.1))), around, 0.45);
}

// Light inside a tunnel at a place so far from its ends: daylight fading from the portals, lamps along the crown.
vec3 tunnel_light(SweepInstance i, float s, vec3 normal) {
  float from = s + i.start_low.w;
  float day = sweep_daylight(min(from, i.kinds.z - s));
  vec3 lamps = vec3(0.42, 0.38, 0.31) * sweep_lamplight(from, i.arc.w);
  return sky_ambient(normal.z) * day + lamps * (1.0 - day);
}

vec3 body_light(SweepInstance i, SweepPiece p, SweepPoint c, vec3 normal, vec3 position, vec3 direction,
                bool cap) {
  vec3 albedo = i.albedo.rgb;
  if (i.albedo.w > 0.5) return metal(albedo, normal, position);
  // A pixel's size on the surface.
  float pixel = length(position) * right.w;
  float facing = max(abs(dot(normal, direction)), 0.1);
  float s = c.s + i.kinds.w;
  // Around the vault, from the crown; over an end, its own plane.
  float rise = c.h - p.profile.p1;
  float around = rise > 0.0 ? atan(abs(c.n), rise) * p.profile.p2 : 1.5708 * p.profile.p2 - rise;
  around = c.n < 0.0 ? -around : around;
  if (cap) s = c.n, around = c.h;
  if (normal.z > 0.5 && c.h < 0.5) around = c.n;
  float fine = pixel / sqrt(facing);
  float grain = 0.09 * noise_fractal(s, around * 2.0, 4.0, 5, 0.75, fine);
  albedo *= 1.0 + grain;
  bool lining = p.profile.kind == SWEEP_LINING;
  float hollow = sweep_vault(c.n, c.h, p.profile.p0, p.profile.p1, p.profile.p2);
  bool inside = (lining || p.profile.kind == SWEEP_HEAD_WALL) && (!cap || (lining && p.end0 + p.end1 < 0.5)) &&
                hollow < min(0.1, 0.5 * i.profile.w);
  if (!inside) return frame_radiance(albedo, frame_light(normal, position));
  // Rings of the lining every 10 m, dirt low on the walls, not on the walkways.
  float along = c.s + i.start_low.w;
  float pixel_s = pixel / max(sqrt(1.0 - min(c.ds * c.ds, 0.9999)), 0.02);
  albedo *= 1.0 - 0.35 * marking_dash_box(along, 10.0, 0.06, pixel_s);
  albedo *= normal.z > 0.5 ? 0.9 : mix(0.6, 1.0, smoothstep(0.0, 1.6, c.h + 0.4 * grain));
  vec3 light = albedo * tunnel_light(i, c.s, normal);
  // Lamps under the crown.
  float lamp = marking_dash_box(along - 0.5 * i.arc.w + 0.6, i.arc.w, 1.2, pixel_s) *
               filter_band(c.n, -0.14, 0.14, pixel / facing, 0.0) * (normal.z < -0.5 ? 1.0 : 0.0);
  return mix(light, vec3(2.6, 2.3, 1.7), lamp);
}

SweepPoint place_at(float k, vec3 along, SweepPiece p) {
  vec3 at = point + k * along;
  return sweep_locate(at.x, at.y, at.z, along.x, along.y, along.z, p.path);
}

#ifndef CHANNELS
// A tunnel's floor: just above the road, which was drawn in daylight and is darkened from there.
const float floor_m = 0.05;

// Where the ray comes down to the floor of the tunnel, or lies below it at an end; SWEEP_FAR where it does not. k: the
// ray's part within the piece.
float floor_at(SweepInstance i, vec3 along, vec2 k, SweepPiece p) {
  SweepPoint first = place_at(k.x, along, p);
  if (first.h < floor_m) {
    bool portal = min(first.s + i.start_low.w, i.kinds.z - first.s) < 2.0;
    return portal && first.h > -0.1 && abs(first.n) < p.profile.p5 ? k.x : SWEEP_FAR;
  }
  SweepPoint c = place_at(k.y, along, p);
  if (c.h > floor_m) return SWEEP_FAR;
  float at = k.y;
  for (int step = 0; step < 3; ++step) {
    at = clamp(at - (c.h - floor_m) / min(c.dh, -1e-4), k.x, k.y);
    c = place_at(at, along, p);
  }
  return abs(c.n) < p.profile.p5 ? at : SWEEP_FAR;
}
#endif

void main() {
  SweepInstance i = sweeps[index];
  SweepPiece p = piece_of(i);
  vec3 along = point - eye;
  float reach = length(along);
  along /= reach;
  vec3 direction = world(along);
  float ahead = max(dot(direction, forward.xyz), 1e-3);
  float near = -reach + forward.w / ahead;
  SweepCast found = sweep_cast(point.x, point.y, point.z, along.x, along.y, along.z, near, reach, right.w * ahead, p);
#ifdef CHANNELS
  bool post = found.posts.met > 0.5 && !(found.body.met > 0.5 && found.body.k <= found.posts.k);
  if (!post && found.body.met < 0.5) discard;
  float k = post ? found.posts.k : found.body.k;
  SweepPoint c = place_at(k, along, p);
  vec3 normal = world(post ? sweep_post_normal(c, p.path, p.posts) : sweep_normal(c, p.path, p.profile));
  out_road = vec4(-1.0, 0.0, 0.0, 0.0);
  out_normal = vec4(normal, 0.0);
  out_label = vec2(4.0, i.start_high.w + 1.0);
#else
  float k = SWEEP_FAR;
  vec4 body = vec4(0.0);
  vec4 posts = vec4(0.0);
  if (found.body.coverage > 0.0) {
    k = found.body.k;
    SweepPoint c = place_at(k, along, p);
    vec3 normal = world(sweep_normal(c, p.path, p.profile));
    vec3 position = direction * (reach + k);
    // Through an end: its own plane.
    bool cap = found.body.met > 0.5 && sweep_distance(c.n, c.h, p.profile) < -2e-3 && found.body.steps < 1.5;
    if (cap) normal = world(vec3(c.tx, c.ty, 0.0)) * (c.ds < 0.0 ? 1.0 : -1.0);
    body = vec4(body_light(i, p, c, normal, position, direction, cap), found.body.coverage);
  }
  if (found.posts.coverage > 0.0) {
    SweepPoint c = place_at(found.posts.k, along, p);
    vec3 normal = world(sweep_post_normal(c, p.path, p.posts));
    vec3 position = direction * (reach + found.posts.k);
    vec3 wood = vec3(0.16, 0.12, 0.085);
    bool pole = p.posts.half_s < 0.0;
    posts = vec4(pole ? frame_radiance(wood, frame_light(normal, position)) : metal(0.85 * i.albedo.rgb, normal, position),
                 found.posts.coverage);
  }
  bool posts_first = found.posts.k < found.body.k;
  vec4 front = posts_first ? posts : body;
  vec4 back = posts_first ? body : posts;
  if (posts.a > 0.0) k = min(k, found.posts.k);
  if (p.profile.kind == SWEEP_LINING) {
    vec2 span = sweep_interval(point.x, point.y, point.z, along.x, along.y, along.z, near, 0.0, 0.0, p);
    if (found.body.met > 0.5) span.y = min(span.y, found.body.k);
    float low = span.x <= span.y ? floor_at(i, along, span, p) : SWEEP_FAR;
    if (low < SWEEP_FAR) {
      SweepPoint c = place_at(low, along, p);
      // The road was drawn in full daylight: what remains of it under the tunnel's own.
      vec3 light = tunnel_light(i, c.s, vec3(0.0, 0.0, 1.0));
      float day = dot(light, vec3(0.4)) / dot(sky_sun_color() * max(sun.z, 0.1) + sky_ambient(1.0), vec3(0.4));
      front = vec4(0.0);
      back = vec4(0.05 * light * vec3(1.0, 0.9, 0.75), clamp(1.0 - 0.75 * day, 0.0, 0.97));
      k = low;
    }
  }
  float behind = back.a * (1.0 - front.a);
  float alpha = front.a + behind;
  if (!(alpha > 0.002)) discard;
  out_color = vec4(frame_tone((front.rgb * front.a + back.rgb * behind) / alpha), alpha);
#endif
  gl_FragDepth = forward.w / max(ahead * (reach + k), forward.w);
}
