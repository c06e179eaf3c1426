// Eye rays and the surface of a segment that is not a plane (RELIEF).

const float kNearer = 0.75;  // the least part of its depth that a pixel is given

// Keeps of the interval k the part where value + k slope >= 0.
void clip_interval(inout vec2 k, float value, float slope) {
  float along = abs(slope) < 1e-9 ? (slope < 0.0 ? -1e-9 : 1e-9) : slope;
  float crossing = -value / along;
  if (along > 0.0) {
    k.x = max(k.x, crossing);
  } else {
    k.y = min(k.y, crossing);
  }
}

// The eye ray in chord axes (z in metres), and the part of it over this segment.
struct Ray {
  vec3 start;   // m
  vec3 from;
  vec3 toward;
  vec3 along;   // unit, metres
  float reach;  // of `start` from the eye
  vec2 k;       // m from `start`; empty where k.x > k.y
  vec2 wide;    // as far as the surface is continued over the joints, for what shares a pixel with the segment
};

// at: pixels right and up of the pixel's centre.
Ray eye_ray(RoadSurface r, vec2 at) {
  Ray ray;
  float depth = dot(relative, forward.xyz);
  vec3 aside = right.w * depth * (at.x * right.xyz + at.y * up.xyz);
  ray.start = point + vec3(dot(aside.xy, axis), aside.y * axis.x - aside.x * axis.y, aside.z);
  ray.along = ray.start - eye;
  ray.reach = length(ray.along);
  ray.along /= ray.reach;
  ray.from = vec3(ray.start.xy / r.chord, ray.start.z);
  ray.toward = vec3(ray.along.xy / r.chord, ray.along.z);
  // From the near plane on, as the quads of planar segments are clipped.
  ray.k = vec2(ray.reach * (forward.w / max(depth, 1e-6) - 1.0), 1e6);
  // Within the segment's width and range about its chord's plane.
  clip_interval(ray.k, ray.from.y - box.x, ray.toward.y);
  clip_interval(ray.k, box.y - ray.from.y, -ray.toward.y);
  float rise = road_cubic(r.arc, 0.0, r.z1, r.z2, r.z3);
  float above = ray.from.z - rise * ray.from.x;
  float climb = ray.toward.z - rise * ray.toward.x;
  clip_interval(ray.k, above - box.z, climb);
  clip_interval(ray.k, box.w - above, -climb);
  // Between the joints' lines, which run through the anchors across the tangents (beyond them a neighbour takes over;
  // they overlap by a millimetre; open ends have room for their antialiased edge).
  float hair = 1e-3 / r.chord;
  float room = (box.y - box.x) * 0.5;
  float x0 = ray.from.x + r.a * ray.from.y;
  float x1 = 1.0 - ray.from.x - r.b * ray.from.y;
  vec2 ends = vec2(ray.toward.x + r.a * ray.toward.y, -ray.toward.x - r.b * ray.toward.y);
  ray.wide = ray.k;
  clip_interval(ray.wide, x0 + 1.2, ends.x);
  clip_interval(ray.wide, x1 + 1.2, ends.y);
  clip_interval(ray.k, x0 + ((ids.w & kOpenStart) != 0u ? room : hair), ends.x);
  clip_interval(ray.k, x1 + ((ids.w & kOpenEnd) != 0u ? room : hair), ends.y);
  return ray;
}

// Has the ray met the road from above before it comes over the joint? Within a pixel and a half; what lies deeper is
// hidden.
bool comes_over(RoadSurface r, Ray ray, RoadSearch search, float pixel) {
  float t = r.chord * search.over_v;
  return search.before < 0.0 && search.before > -1.5 * pixel * (ray.reach + ray.k.x) && search.climb < 0.0 &&
         ray.k.x > ray.wide.x && t > section_border(ids.y, 0, height.w) &&
         t < section_border(ids.y, int(section_row(ids.y).x) - 1, height.w);
}

#ifndef CHANNELS
// Is all that the ray may meet behind the ground, in every sample of the pixel?
bool behind_ground(Ray ray) {
  if (ground_samples == 0) return false;
  ivec2 at = ivec2(gl_FragCoord.xy);
  // At least kNearer of the depth where the ray enters is what main() gives it.
  float nearness = forward.w / (kNearer * dot(relative, forward.xyz) * (1.0 + ray.k.x / ray.reach));
  if (ground_samples == 1) return texelFetch(ground_depth, at, 0).x > nearness;
  for (int i = 0; i < ground_samples; ++i) {
    if (texelFetch(ground_depths, at, i).x <= nearness) return false;
  }
  return true;
}

// Sets what part of the pixel is below the silhouette of a crest: the ray passes `deep` below it, m, where it is `away`
// from the eye. side: 1 for a ray above the surface, -1 for one below it.
void sink_below(inout Spot spot, float deep, float away, float side) {
  vec3 slope = spot.normal / spot.normal.z * right.w * away;
  spot.deep = deep;
  spot.crest = away;
  spot.sink = -side * vec2(dot(slope, right.xyz), dot(slope, up.xyz)) * spot.size;
  spot.seen = filter_step(deep, spot.sink.x, spot.sink.y);
}
#endif

// Only levels of DETAILED roads, and the silhouettes of the picture, need to know about rays that miss.
#ifdef DETAILED
#define LOOK_ABOUT 2
#elif defined(CHANNELS)
#define LOOK_ABOUT 0
#else
#define LOOK_ABOUT 1
#endif

// Where the ray meets the surface raised by lift; beyond: also over the joints.
Spot intersect(RoadSurface r, Ray ray, float lift, Part part) {
  vec3 from = ray.from - vec3(0.0, 0.0, lift);
  vec3 toward = ray.toward;
  vec2 k = vec2(ray.wide.x, min(ray.wide.y, part.last - ray.reach));
  vec2 own = part.beyond ? k : ray.k;
  // A thousandth of a pixel, or half a millimetre.
  float tolerance = max(5e-4, 0.001 * right.w * (ray.reach + k.x));
  RoadSearch search = surface_search(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.x, k.y, tolerance, extent.x,
                                     extent.z, part.beyond ? 0 : LOOK_ABOUT, own.x, own.y, r);
  RoadHit hit = search.hit;
  bool found = search.met;
#ifdef DETAILED
  // What a face or a ramp shows lies between its levels, and these may be met over a joint: as if the segment went on.
  for (int i = 0; i < 2 && !search.met && !part.beyond && ray.k.x <= ray.k.y; ++i) {
    float above;
    float climb;
    RoadHit at = surface_step(from.x, from.y, from.z, toward.x, toward.y, toward.z, hit.k, hit.u, r, above, climb);
    float onward = -above / climb;
    found = climb < 0.0 && hit.k + onward >= ray.wide.x && hit.k + onward <= ray.wide.y &&
            abs(onward) * extent.x < 0.2 * abs(climb);
    if (!found) break;
    at = surface_step(from.x, from.y, from.z, toward.x, toward.y, toward.z, hit.k + onward,
                      clamp(at.u + onward * at.du, 0.0, 1.0), r, above, climb);
    hit = at;
    search.above = above;
  }
#endif
  float pixel = right.w * (abs(right.z) + abs(up.z));
#ifdef CHANNELS
  bool crest = false;
#else
  bool over = comes_over(r, ray, search, pixel);
  bool crest = search.crest && !over && hit.residual < pixel * (ray.reach + hit.k);
#endif
  vec3 place = ray.start + hit.k * ray.along - eye;
  RoadCoord c;
  c.u = hit.u;
  c.v = hit.v;
  Spot spot = spot_at(r, vec2(hit.x, hit.y), c, hit.s,
                      vec3(axis * place.x + vec2(-axis.y, axis.x) * place.y, place.z), part.size);
  vec3 along = spot.position / (ray.reach + hit.k);
  float climb = dot(spot.normal, along) / spot.normal.z;  // relative to the surface
  float toward_it = abs(climb);
  // The place along the ray is known to within the tolerance of the height: neighbours overlap by that.
  float slack = min(tolerance / max(toward_it, 1e-4), 1.0);
  bool within = search.met && hit.k >= ray.k.x - slack && hit.k <= ray.k.y + slack;
#ifndef CHANNELS
  within = within && !(climb > 0.0 && over);
  // Within this over the bend the square of its slope to the surface, the silhouette is within two pixels.
  float room = 4.0 * pixel * (ray.reach + hit.k);
  if (crest) {
    sink_below(spot, -hit.residual, ray.reach + hit.k, sign(search.above));
  } else if (within && (toward_it * toward_it < room * extent.x || toward_it < extent.y)) {
    float dn = dot(spot.left, along.xy);
    float ds = (along.x * spot.left.y - along.y * spot.left.x) / spot.bend;
    float side = climb < 0.0 ? 1.0 : -1.0;
    float n = spot.t * spot.cosine;
    float bend = side * surface_bend(spot.s, n, spot.turn, ds, dn, r);
    // Farther on it may bend more.
    if (toward_it * toward_it < 2.0 * room * bend || toward_it < extent.y) {
      // To where it would run level with the surface, with the bend half way there.
      float onward = toward_it / max(bend, 1e-6);
      bend = side * surface_bend(spot.s + 0.5 * ds * onward, n, spot.turn, ds, dn, r);
      onward = toward_it / max(bend, 1e-6);
      float deep = 0.5 * toward_it * onward;
      // Crossfall to both sides makes a ridge of the reference line: there its slope relative to the surface changes.
      float ridge = -n / (abs(dn) < 1e-6 ? 1e-6 : dn);
      float fold = side * (r.left0 + r.right0 + (r.left1 + r.right1) * spot.s) * abs(dn);
      if (ridge > 0.0 && ridge < onward && fold > 0.0) {
        float rest = max(toward_it - bend * ridge - fold, 0.0);
        onward = ridge + rest / max(bend, 1e-6);
        deep = ridge * (toward_it - 0.5 * bend * ridge) + 0.5 * rest * (onward - ridge);
      }
      spot.grazed = toward_it * toward_it < room * abs(bend);
      spot.rough = abs(spot.t) < abs(spot.t_step.x) + abs(spot.t_step.y) && abs(fold) > 0.3 * toward_it;
      sink_below(spot, deep, ray.reach + hit.k + onward, side);
    }
  }
#endif
  spot.beyond = part.beyond;
  spot.found = found;
  spot.on = (crest && spot.seen > 0.0) || (part.beyond ? search.met : within);
  spot.h = lift + search.above;
  return spot;
}
