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

float half_width_m(float u, RoadSurface r) {
  return road_cubic(clamp(surface_arc(u, r), 0.0, r.arc), half_width.x, half_width.y, half_width.z, half_width.w);
}

#ifdef RELIEF
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

// Where the eye ray meets the surface, in chord axes (metres); false where it does not on this segment.
bool intersect(RoadSurface r, out RoadHit hit, out vec3 place) {
  vec3 along = point - eye;
  float reach = length(along);
  along /= reach;
  vec3 from = vec3(point.xy / r.chord, point.z);
  vec3 toward = vec3(along.xy / r.chord, along.z);
  // The part of the ray between the joints' lines, which run through the anchors across the tangents (beyond them a
  // neighbour takes over; they overlap by a millimetre), and within the segment's width and range of heights.
  float hair = 1e-3 / r.chord;
  vec2 k = vec2(-reach, 1e6);
  clip_interval(k, from.x + r.a * from.y + hair, toward.x + r.a * toward.y);
  clip_interval(k, 1.0 - from.x - r.b * from.y + hair, -toward.x - r.b * toward.y);
  clip_interval(k, from.y - box.x, toward.y);
  clip_interval(k, box.y - from.y, -toward.y);
  clip_interval(k, from.z - box.z, toward.z);
  clip_interval(k, box.w - from.z, -toward.z);
  if (!(k.x <= k.y)) return false;

  float start = surface_chord_plane(from.x, from.z, toward.x, toward.z, r);
  // A hundredth of a pixel, or a millimetre.
  float tolerance = max(1e-3, 0.01 * right.w * (reach + k.x));
  hit = surface_intersect(from.x, from.y, from.z, toward.x, toward.y, toward.z, start, k.x, k.y, r);
  if (hit.residual > tolerance) {
    k = surface_bracket(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.x, k.y, r);
    hit = surface_intersect(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.x, k.x, k.y, r);
  }
  // A ray nearly along the surface may meet it twice, once beside the road: look from the far end too.
  bool beside = hit.residual > tolerance || abs(hit.v) * r.chord > half_width_m(hit.u, r);
  if (beside && abs(toward.z - surface_height(1.0, r) * toward.x) < 0.03) {
    RoadHit other = surface_intersect(from.x, from.y, from.z, toward.x, toward.y, toward.z, k.y, k.x, k.y, r);
    if (other.residual <= tolerance && abs(other.v) < abs(hit.v)) hit = other;
  }
  place = point + hit.k * along;
  return hit.residual <= tolerance;
}
#endif

vec3 carriageway_albedo(float s, float t, float w, vec2 footprint, out float marking) {
  float fine = max(footprint.x, footprint.y);
  float wheel = exp(-pow(abs(abs(t) - 0.5 * w) - 0.8, 2.0) * 6.0);
  float broad = noise_fractal(arc.w + s + 17.0 * height.w, t * 4.0, 32.0, 3, 0.6, fine);
  float grain = noise_fractal(arc.w + s, t, 0.25, 5, 1.3, sqrt(footprint.x * footprint.y)) * 0.22;
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
#else
  p = chord_point;
  c = road_project_linear(linear.x, linear.y, linear.z, p.x, p.y, r.a, r.b);
#endif
  // Clamped before any use: lanes that end in a discard may hold anything.
  float s = clamp(surface_arc(c.u, r), 0.0, r.arc);
  float t = clamp(c.v * r.chord, -1e3, 1e3);
  float w = half_width_m(c.u, r);

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
  float depth = dot(position, forward.xyz);
#ifndef CHANNELS
  // One depth serves all samples of the pixel; the ground has one at each. The nearest that the road has within the
  // pixel keeps the ground below it out of all of them.
  depth -= 0.5 * (abs(dot(step_x, forward.xyz)) + abs(dot(step_y, forward.xyz)));
#endif
  gl_FragDepth = forward.w / max(depth, forward.w);
#endif
}
