// Spots of a road that a pixel shows, and how (s, t) change over it.

// Where the eye ray meets one level of the cross section.
struct Spot {
  float s;        // from the segment's start
  float t;
  float h;        // above the road surface: the level's, but where the ray does not get there
  vec2 p;         // in the chord frame
  vec3 position;  // relative to the eye
  vec3 normal;
  vec2 left;      // unit, horizontal
  float bend;     // metres of the plane per metre of s, at this t
  float cosine;   // horizontal metres per metre of t
  vec2 size;      // of the part of the pixel, pixels right and up
  vec2 t_step;    // change of t per pixel right and up; 0 for the data channels, which are taken at pixel centres
  vec2 s_step;
  vec2 w_step;    // relative change of 1 / depth, likewise
  bool on;        // false: the ray leaves the segment before or after
  bool beyond;    // on: also over a joint
  bool found;   // the ray gets to the level, if need be over a joint
  float seen;       // part of the pixel below the silhouette of the crest, 1 where there is none
  vec2 sink;        // change of the depth below the silhouette per pixel right and up, of which it shows `deep` at its middle
  float deep;
  float crest;  // m from the eye: where that is
  bool grazed;      // by the ray, within two pixels of a crest
  bool rough;   // parts of the pixel may see otherwise than its middle's surroundings tell
  float turn;       // curvature of the reference line, 1/m
};

// Part of the pixel: its middle from the pixel's, and its size, both in pixels right and up.
struct Part {
  vec2 at;
  vec2 size;
  bool beyond;  // what lies beyond the segment's joints is taken as if it went on
  float last;   // m from the eye: where the crest is, beyond which the road is hidden
};
#define WHOLE Part(vec2(0.0), vec2(1.0), false, 1e9)

// Sets the changes per pixel.
void spread(inout Spot spot) {
#ifdef CHANNELS
  spot.t_step = spot.s_step = spot.w_step = vec2(0.0);
#else
  vec3 step_x = frame_footprint(spot.position, spot.normal, right.xyz) * spot.size.x;
  vec3 step_y = frame_footprint(spot.position, spot.normal, up.xyz) * spot.size.y;
  vec2 ahead = vec2(spot.left.y, -spot.left.x);
  spot.t_step = vec2(dot(spot.left, step_x.xy), dot(spot.left, step_y.xy)) / spot.cosine;
  spot.s_step = vec2(dot(ahead, step_x.xy), dot(ahead, step_y.xy)) / spot.bend;
  spot.w_step = -vec2(dot(forward.xyz, step_x), dot(forward.xyz, step_y)) / max(dot(forward.xyz, spot.position), 1e-3);
#endif
}

Spot spot_at(RoadSurface r, vec2 p, RoadCoord c, float s, vec3 position, vec2 size) {
  Spot spot;
  spot.h = 0.0;
  spot.p = p;
  spot.position = position;
  spot.on = spot.found = true;
  spot.beyond = false;
  spot.seen = 1.0;
  spot.sink = vec2(0.0);
  spot.deep = spot.crest = 1e9;
  spot.rough = spot.grazed = false;
  // Clamped before any use: lanes that end in a discard may hold anything.
  spot.s = clamp(s, -r.arc, 2.0 * r.arc);
  float n = clamp(c.v * r.chord, -1e3, 1e3);
  SurfaceSlope slope = surface_beyond(spot.s, n, r);
  spot.t = n / slope.cosine;
  float df = road_df(c.u, r.a, r.b);
  vec2 tangent = normalize(axis + vec2(-axis.y, axis.x) * df);
  spot.left = vec2(-tangent.y, tangent.x);
  float stretch = 1.0 + df * df;
  float turn = road_ddf(c.u, r.a, r.b) / (stretch * sqrt(stretch));
  float bend = max(1.0 - c.v * turn, 0.05);
  spot.turn = turn / r.chord;
  spot.normal = normalize(vec3(-slope.ahead / bend * tangent - slope.aside * spot.left, 1.0));
  spot.bend = bend;
  spot.cosine = slope.cosine;
  spot.size = size;
  spread(spot);
  return spot;
}
