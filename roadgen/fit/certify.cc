// What a road is worth against its source.
//
// The polyline's edge e from sample S to sample S' and the piece C of the curve between their feet P and P', in
// coordinates along and across e. Every point of C is as near to e as the worst control point of C's Bezier form, since
// the distance from a segment is convex. And a point of e at x between the feet's own x faces a point of C, which is
// continuous, so it is within the greatest |y| of C; at x before P's it is nearer to P than S is, after P' likewise.
#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>

#include "roadgen/fit/fit.h"
#include "roadgen/fit/locate.h"

namespace roadgen {
namespace {

using Bezier = std::array<glm::dvec2, 4>;

// Bounds need not be closer than this to what they bound.
constexpr double kTightness = 1e-3, kTightness_m = 1e-6;
constexpr int kMostHalvings = 16;

// The part u0 to u1 of the segment's centre line. A cubic's control values are its ends and what its slopes there lead to.
Bezier bezier(const Segment& segment, double u0, double u1) {
  const double a = segment.slope_start, b = segment.slope_end, h = (u1 - u0) / 3;
  const double f0 = Lib::road_f(u0, a, b), f1 = Lib::road_f(u1, a, b);
  const glm::dvec2 control[] = {
      {u0, f0}, {u0 + h, f0 + h * Lib::road_df(u0, a, b)}, {u1 - h, f1 - h * Lib::road_df(u1, a, b)}, {u1, f1}};
  Bezier c;
  for (std::size_t k = 0; k < 4; ++k) c[k] = from_chord(segment, control[k]);
  return c;
}

struct Edge {
  glm::dvec2 from_m, to_m;

  double distance_m(glm::dvec2 p) const {
    const glm::dvec2 e = to_m - from_m;
    const double length2 = glm::dot(e, e);
    const double w = length2 > 0 ? std::clamp(glm::dot(p - from_m, e) / length2, 0.0, 1.0) : 0;
    return glm::length(p - from_m - w * e);
  }
  // From the line through both ends.
  double across_m(glm::dvec2 p) const {
    const glm::dvec2 e = to_m - from_m, q = p - from_m;
    const double length = glm::length(e);
    return length > 0 ? std::abs(e.x * q.y - e.y * q.x) / length : glm::length(q);
  }
};

// Raises bound_m to an upper bound of a convex distance over the curve: that at its control points, of halves while this
// is far above that at their ends.
template <class Distance>
void raise(double& bound_m, const Bezier& c, Distance&& distance, int halvings = 0) {
  const double at_ends = std::max(distance(c[0]), distance(c[3]));
  const double hull = std::max({at_ends, distance(c[1]), distance(c[2])});
  if (hull <= bound_m) return;
  if (hull - at_ends <= kTightness_m + kTightness * at_ends || halvings == kMostHalvings) {
    bound_m = hull;
    return;
  }
  const glm::dvec2 ab = 0.5 * (c[0] + c[1]), bc = 0.5 * (c[1] + c[2]), cd = 0.5 * (c[2] + c[3]);
  const glm::dvec2 abc = 0.5 * (ab + bc), bcd = 0.5 * (bc + cd), middle = 0.5 * (abc + bcd);
  raise(bound_m, {c[0], ab, abc, middle}, distance, halvings + 1);
  raise(bound_m, {middle, bcd, cd, c[3]}, distance, halvings + 1);
}

struct Foot {
  std::size_t segment;
  double u;
};

// Visits the Bezier pieces of the road from one foot forward to another, over the seam of a closed road where need be.
template <class Visit>
void for_pieces(const Road& road, Foot from, Foot to, Visit&& visit) {
  const std::size_t count = road.segments.size();
  for (std::size_t i = from.segment;; i = (i + 1) % count) {
    const bool is_last = i == to.segment && (i != from.segment || to.u >= from.u);
    const double u0 = i == from.segment ? from.u : 0, u1 = is_last ? to.u : 1;
    if (u1 > u0) visit(bezier(road.segments[i], u0, u1));
    if (is_last) return;
    from = {count, 0};  // its segment may come again, whole
  }
}

void bound_both_ways(const Road& road, std::span<const Sample> samples, const std::vector<Located>& located,
                     Certificate& c) {
  const std::size_t count = samples.size();
  const auto foot = [&](std::size_t i) { return Foot{located[i].segment, located[i].u}; };
  for (std::size_t i = 0; i < count; ++i) {
    const Segment& segment = road.segments[located[i].segment];
    c.source_to_curve_m =
        std::max(c.source_to_curve_m, glm::length(samples[i].position_m - position_m(segment, located[i].u)));
  }
  const auto add = [&](Foot from, Foot to, const Edge& edge) {
    for_pieces(road, from, to, [&](const Bezier& piece) {
      raise(c.curve_to_source_m, piece, [&](glm::dvec2 p) { return edge.distance_m(p); });
      raise(c.source_to_curve_m, piece, [&](glm::dvec2 p) { return edge.across_m(p); });
    });
  };
  for (std::size_t i = 0; i + (road.closed ? 0 : 1) < count; ++i) {
    const std::size_t next = (i + 1) % count;
    // Noise may lead backward; on a loop the shorter way is meant.
    const double ahead = located[next].s_m - located[i].s_m;
    const bool is_far = road.closed && std::abs(ahead) > 0.5 * c.length_m;
    const bool is_forward = is_far ? ahead < 0 : ahead >= 0;
    const Foot from = foot(is_forward ? i : next), to = foot(is_forward ? next : i);
    add(from, to, {samples[i].position_m, samples[next].position_m});
  }
  if (road.closed || count == 0) return;
  const auto [first, last] = std::minmax_element(located.begin(), located.end(),
                                                 [](const Located& a, const Located& b) { return a.s_m < b.s_m; });
  const glm::dvec2 start = samples[static_cast<std::size_t>(first - located.begin())].position_m;
  const glm::dvec2 end = samples[static_cast<std::size_t>(last - located.begin())].position_m;
  const auto to_end_of_curve = [&](Foot from, Foot to, glm::dvec2 sample) {
    for_pieces(road, from, to, [&](const Bezier& piece) {
      raise(c.curve_to_source_m, piece, [&](glm::dvec2 p) { return glm::length(p - sample); });
    });
  };
  to_end_of_curve({0, 0}, {first->segment, first->u}, start);
  to_end_of_curve({last->segment, last->u}, {road.segments.size() - 1, 1}, end);
}

}  // namespace

Certificate certify(const Road& road, std::span<const Sample> samples, std::size_t anchors) {
  Certificate c;
  c.id = road.id;
  c.closed = road.closed;
  c.length_m = road.length_m();
  c.samples = samples.size();
  c.anchors = anchors;
  c.segments = road.segments.size();
  if (road.segments.empty()) return c;

  const std::vector<Located> located = locate(road, samples);
  double sum = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Segment& segment = road.segments[located[i].segment];
    const double z = segment.elevation_m.value(located[i].s_m - segment.s_start_m);
    c.max_error_m = std::max(c.max_error_m, located[i].distance_m);
    c.max_elevation_error_m = std::max(c.max_elevation_error_m, std::abs(z - samples[i].elevation_m));
    sum += located[i].distance_m * located[i].distance_m;
  }
  if (!samples.empty()) c.rms_error_m = std::sqrt(sum / static_cast<double>(samples.size()));
  bound_both_ways(road, samples, located, c);

  double mapping_m = 0;
  for (const Segment& segment : road.segments) {
    mapping_m = std::max(mapping_m, segment.v_bound_m());
  }
  c.bound_m = c.max_error_m + mapping_m;
  for (std::size_t i = 0; i + (road.closed ? 0 : 1) < road.segments.size(); ++i) {
    const JointGap gap = joint_gap(road.segments[i], road.segments[i + 1 == road.segments.size() ? 0 : i + 1]);
    c.max_heading_jump_rad = std::max(c.max_heading_jump_rad, gap.heading_rad);
    c.max_curvature_jump_per_m = std::max(c.max_curvature_jump_per_m, gap.curvature_per_m);
  }
  return c;
}

}  // namespace roadgen
