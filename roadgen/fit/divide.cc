#include "roadgen/fit/divide.h"

#include <algorithm>
#include <cmath>

namespace roadgen {
namespace {

std::vector<Segment> parts_of(const Segment& whole, int count) {
  std::vector<Segment> parts;
  for (int i = 0; i < count; ++i) {
    const double u0 = static_cast<double>(i) / count, u1 = static_cast<double>(i + 1) / count, s0 = arc_at(whole, u0);
    // The whole's own ends and headings at its ends, to the last bit.
    Segment part = make_segment(i == 0 ? whole.start_m : position_m(whole, u0),
                                i + 1 == count ? whole.end_m : position_m(whole, u1), heading_rad(whole, u0),
                                heading_rad(whole, u1), whole.max_half_width_m());
    part.elevation_m = whole.elevation_m.shifted(s0);
    part.superelevation_rad = whole.superelevation_rad.shifted(s0);
    part.crossfall_left = {whole.crossfall_left.value(s0), whole.crossfall_left.c1};
    part.crossfall_right = {whole.crossfall_right.value(s0), whole.crossfall_right.c1};
    part.left_m = whole.left_m.shifted(s0);
    part.right_m = whole.right_m.shifted(s0);
    part.section = whole.section;
    set_bound(part);
    parts.push_back(part);
  }
  return parts;
}

bool is_faithful(const Segment& whole, const std::vector<Segment>& parts) {
  double length = 0;
  for (const Segment& part : parts) {
    for (const double u : {0.25, 0.5, 0.75}) {
      if (nearest(whole, position_m(part, u)).distance_m > 0.5 * kDividedGap_m) return false;
    }
    if (!is_admissible(part)) return false;
    length += part.arc_m;
  }
  return std::abs(length - whole.arc_m) < kDividedShift_m;
}

}  // namespace

void divide_segments(Road& road, double longest_m) {
  std::vector<Segment> divided;
  for (const Segment& whole : road.segments) {
    const int count = static_cast<int>(std::ceil(whole.arc_m / longest_m - 1e-6));
    if (count > 1) {
      std::vector<Segment> parts = parts_of(whole, count);
      if (is_faithful(whole, parts)) {
        divided.insert(divided.end(), parts.begin(), parts.end());
        continue;
      }
    }
    divided.push_back(whole);
  }
  const double length = road.length_m();
  road.segments = std::move(divided);
  chain_arc_lengths(road);
  // What lies at joints stays there.
  for (std::size_t i = road.segments.size(); i-- > 0;) {
    const Segment& segment = road.segments[i];
    if (segment.section < road.sections.size()) road.sections[segment.section].s_m = segment.s_start_m;
  }
  const auto keep_within = [&](auto& part) {
    part.s_end_m = part.s_end_m >= length ? road.length_m() : std::min(part.s_end_m, road.length_m());
  };
  for (Bridge& bridge : road.bridges) keep_within(bridge);
  for (Sweep& sweep : road.sweeps) keep_within(sweep);
}

}  // namespace roadgen
