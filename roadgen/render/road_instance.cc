#include "roadgen/render/road_instance.h"

#include <algorithm>
#include <cmath>

namespace roadgen {

SplitPosition split(glm::dvec3 p) {
  const glm::vec3 high(p);
  return {high, glm::vec3(p - glm::dvec3(high))};
}

RoadInstance road_instance(const Segment& segment, std::size_t road_index) {
  RoadInstance r;
  const Cubic& z = segment.elevation_m;
  const SplitPosition start = split({segment.start_m.x, segment.start_m.y, z.c0});
  r.start_high = start.high;
  r.start_low = start.low;
  r.shape = glm::dvec4(segment.chord_m(), segment.slope_start, segment.slope_end);
  r.arc = glm::dvec4(segment.arc_m, segment.arc_c0, segment.arc_c1, segment.s_start_m);
  r.height = glm::dvec4(z.c1, z.c2, z.c3, std::fmod(segment.s_start_m, kNoisePeriod_m));
  const Cubic& w = segment.half_width_m;
  r.half_width = glm::dvec4(w.c0, w.c1, w.c2, w.c3);
  const Quad quad = fitted_quad(segment);
  const Cubic::Range range = z.range(segment.arc_m);
  r.box = glm::dvec4(quad.y_low, quad.y_high, range.low - z.c0, range.high - z.c0);
  r.road = glm::dvec2(static_cast<double>(road_index), std::fmod(segment.s_start_m, kDashPeriod_m));
  return r;
}

double planar_deviation_m(const Segment& segment) {
  const double length = segment.chord_length_m(), arc = segment.arc_m;
  const Cubic& z = segment.elevation_m;
  const double rise = z.value(arc) - z.c0;
  // Along the centre line, at u: z(s) against rise * u. First against rise * s / arc, then s / arc against u.
  Cubic off = z;
  off.c0 = 0;
  off.c1 -= rise / arc;
  const Cubic::Range along = off.range(arc);
  const double steep = std::max({std::abs(segment.slope_start), std::abs(segment.slope_end)});
  if (rise == 0 && along.low == 0 && along.high == 0) return 0;
  // |s / arc - u| <= max |ds/du / arc - 1| / 2 <= (q - 1) / 2 with q = max sqrt(1 + f'^2); |f'| <= 4/3 max(|a|, |b|).
  const double slope = 4.0 / 3.0 * steep;
  const double stretch = 0.5 * (std::sqrt(1 + slope * slope) - 1);
  // Across: the point (u, v) lies at x = u - v f' / q.
  const double lean = segment.max_half_width_m() / length * slope;
  return std::max(-along.low, along.high) + std::abs(rise) * (stretch + lean);
}

}  // namespace roadgen
