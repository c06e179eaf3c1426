// Cookie-cuts the road out of its proxy: (u, v) of the pixel by the road function, then markings and edges by (s, t).
#include "lib/road.glsl"
#include "lib/surface.glsl"
#include "lib/marking.glsl"
#include "lib/noise.glsl"
#include "lib/ground.glsl"
#include "frame.glsl"
#include "outputs.glsl"

flat in vec4 shape;
flat in vec4 arc;
flat in vec4 height;
flat in vec4 half_width;
flat in vec3 axis_dash;
in vec3 relative;
#ifdef RELIEF
flat in vec4 box;
flat in vec3 eye;
in vec3 point;
#else
in vec2 chord_point;
in vec3 linear;
#endif

#ifdef RELIEF
// Where the eye ray meets the surface, in chord axes (metres); false where it does not within this segment's box.
bool intersect(RoadSurface r, out RoadHit hit, out vec3 place) {
  vec3 along = point - eye;
  float reach = length(along);
  along /= reach;
  // The ray's part inside the box, from `point` backward: k <= 0.
  float x_low = min(min(-r.a * box.x, -r.a * box.y), 0.0) * r.chord - 1.0;
  float x_high = max(max(1.0 - r.b * box.x, 1.0 - r.b * box.y), 1.0) * r.chord + 1.0;
  vec3 low = vec3(x_low, box.x * r.chord - 3.0, box.z - 0.02);
  vec3 high = vec3(x_high, box.y * r.chord + 3.0, box.w + 0.02);
  vec3 slope = vec3(abs(along.x) < 1e-7 ? 1e-7 : along.x, abs(along.y) < 1e-7 ? 1e-7 : along.y,
                    abs(along.z) < 1e-7 ? 1e-7 : along.z);
  vec3 k0 = (low - point) / slope;
  vec3 k1 = (high - point) / slope;
  vec3 k_in = min(k0, k1);
  vec3 k_out = max(k0, k1);
  float k_low = max(max(k_in.x, k_in.y), max(k_in.z, -reach));
  float k_high = max(min(min(k_out.x, k_out.y), k_out.z), k_low);
  vec3 from = vec3(point.xy / r.chord, point.z);
  vec3 toward = vec3(along.xy / r.chord, along.z);
  float start = surface_chord_plane(from.x, from.z, toward.x, toward.z, r);
  // A hundredth of a pixel, or a millimetre.
  float tolerance = max(1e-3, 0.01 * right.w * (reach + k_low));
  hit = surface_intersect(from.x, from.y, from.z, toward.x, toward.y, toward.z, start, k_low, k_high, r);
  if (hit.residual > tolerance) {
    // Rays that nearly touch a crest: once more from the middle.
    start = 0.5 * (k_low + k_high);
    hit = surface_intersect(from.x, from.y, from.z, toward.x, toward.y, toward.z, start, k_low, k_high, r);
  }
  place = point + hit.k * along;
  return hit.residual <= tolerance && reach + hit.k > 0.0;
}
#endif

vec3 carriageway_albedo(float s, float t, float w, vec2 footprint, out float marking) {
  float fine = max(footprint.x, footprint.y);
  float wheel = exp(-pow(abs(abs(t) - 0.5 * w) - 0.8, 2.0) * 6.0);
  float broad = noise_fractal(arc.w + s + 17.0 * height.w, t * 4.0, 32.0, 3, 0.6, fine);
  float grain = noise_fractal(arc.w + s, t, 0.5, 6, 0.9, sqrt(footprint.x * footprint.y)) * 0.5;
  vec3 asphalt = ground_asphalt(wheel, broad, grain);
  // Edge lines 12 cm wide, 20 cm inside the edge; a broken centre line, 3 m on and 6 m off.
  float inner = abs(t);
  float edge = marking_stripe(inner, w - 0.32, w - 0.20, footprint.y);
  float center = marking_stripe(t, -0.06, 0.06, footprint.y) * marking_dash(axis_dash.z + s, 9.0, 3.0, footprint.x);
  marking = clamp(edge + center, 0.0, 1.0) * (0.94 + 0.06 * grain);
  return mix(asphalt, vec3(0.68, 0.67, 0.63), marking);
}

void main() {
  RoadSurface r = RoadSurface(shape.x, shape.y, shape.z, shape.w, arc.x, arc.y, height.x, height.y, height.z);
  vec2 axis = axis_dash.xy;
  vec2 p;
  RoadCoord c;
  vec3 position = relative;
#ifdef RELIEF
  RoadHit hit;
  vec3 place;
  if (!intersect(r, hit, place)) discard;
  p = vec2(hit.x, hit.y);
  c.u = hit.u;
  c.v = hit.v;
  vec3 from_eye = place - eye;
  position = vec3(axis * from_eye.x + vec2(-axis.y, axis.x) * from_eye.y, from_eye.z);
  // Beyond the joints' lines, which run through the anchors across the tangents, a neighbour takes over.
  float hair = 1e-3 / r.chord;
  if (p.x + r.a * p.y < -hair || 1.0 - p.x - r.b * p.y < -hair) discard;
#else
  p = chord_point;
  c = road_project_linear(linear.x, linear.y, linear.z, p.x, p.y, r.a, r.b);
#endif
  // Clamped before any use: lanes that end in a discard may hold anything.
  float s = clamp(surface_arc(c.u, r), 0.0, r.arc);
  float t = clamp(c.v * r.chord, -1e3, 1e3);
  float w = road_cubic(s, half_width.x, half_width.y, half_width.z, half_width.w);

  // Tangent frame of the surface, level across.
  float df = road_df(c.u, r.a, r.b);
  vec2 tangent = normalize(axis + vec2(-axis.y, axis.x) * df);
  vec2 left = vec2(-tangent.y, tangent.x);
  float bend = max(1.0 - c.v * road_ddf(c.u, r.a, r.b) / pow(1.0 + df * df, 1.5), 0.05);
  float grade = road_dcubic(s, r.z1, r.z2, r.z3) / bend;
  vec3 normal = normalize(vec3(-grade * tangent, 1.0));

  vec3 step_x = frame_footprint(position, normal, right.xyz);
  vec3 step_y = frame_footprint(position, normal, up.xyz);
  float width_t = abs(dot(left, step_x.xy)) + abs(dot(left, step_y.xy));
  float width_s = (abs(dot(tangent, step_x.xy)) + abs(dot(tangent, step_y.xy))) / bend;
#ifdef CHANNELS
  if (abs(t) > w) discard;
  float marking;
  carriageway_albedo(s, t, w, vec2(0.0), marking);
  out_road = vec4(height.w, arc.z + s, t, t < 0.0 ? -1.0 : 1.0);
  out_normal = vec4(normal, 0.0);
  out_label = vec2(marking > 0.5 ? 3.0 : 2.0, height.w + 1.0);
#else
  float coverage = marking_stripe(t, -w, w, width_t);
  if (!(coverage > 0.0)) discard;
  float marking;
  vec3 albedo = carriageway_albedo(s, t, w, vec2(width_s, width_t), marking);
  out_color = vec4(frame_tone(frame_shade(albedo, normal, position)), coverage);
#endif
#ifdef RELIEF
  gl_FragDepth = forward.w / max(dot(position, forward.xyz), forward.w);
#endif
}
