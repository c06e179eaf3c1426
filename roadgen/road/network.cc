#include "roadgen/road/network.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

bool is_finite(const Segment& s) {
  const double sum = s.start_m.x + s.start_m.y + s.end_m.x + s.end_m.y + s.slope_start + s.slope_end + s.s_start_m +
                     s.arc_m + s.elevation_m.c0 + s.elevation_m.c1 + s.elevation_m.c2 + s.elevation_m.c3 +
                     s.half_width_m.c0 + s.half_width_m.c1 + s.half_width_m.c2 + s.half_width_m.c3;
  return std::isfinite(sum);
}

std::string at(const Road& road, double s_m, const std::string& what) {
  char text[64];
  std::snprintf(text, sizeof text, ", s = %.3f m: ", s_m);
  return "road " + road.id + text + what;
}

std::string number(const char* format, double x) {
  char text[64];
  std::snprintf(text, sizeof text, format, x);
  return text;
}

void check_segment(const Road& road, const Segment& segment, CheckReport& report) {
  const double s = segment.s_start_m;
  if (!is_finite(segment)) {
    report.problems.push_back(at(road, s, "a number is not finite"));
    return;
  }
  const double length = segment.chord_length_m();
  if (!(length > 0)) {
    report.problems.push_back(at(road, s, "the segment has no length"));
    return;
  }
  report.max_mapping_bound_m = std::max(report.max_mapping_bound_m, segment.v_bound_m());
  report.max_s_bound_m = std::max(report.max_s_bound_m, segment.s_bound_m());
  report.max_arc_error_m = std::max(report.max_arc_error_m, segment.arc_error_m);
  if (!is_admissible(segment)) {
    report.problems.push_back(at(road, s,
                                 "the mapping is not certified to " + number("%g", kMappingTolerance) +
                                     " of the half width (bounds " + number("%.3g", segment.v_bound_m()) +
                                     " m across and " + number("%.3g", segment.s_bound_m()) +
                                     " m along): the road is too wide or too tightly bent here; import it again"));
  }
  if (!(segment.half_width_m.range(segment.arc_m).low > 0)) {
    report.problems.push_back(at(road, s, "the width is not positive"));
  }
}

void check_joint(const Road& road, const Segment& before, const Segment& after, CheckReport& report) {
  const JointGap gap = joint_gap(before, after);
  ++report.joints;
  JointGap& worst = report.worst;
  worst.position_m = std::max(worst.position_m, gap.position_m);
  worst.heading_rad = std::max(worst.heading_rad, gap.heading_rad);
  worst.curvature_per_m = std::max(worst.curvature_per_m, gap.curvature_per_m);
  worst.elevation_m = std::max(worst.elevation_m, gap.elevation_m);
  worst.grade = std::max(worst.grade, gap.grade);
  worst.half_width_m = std::max(worst.half_width_m, gap.half_width_m);

  // Coordinates are doubles: 1e7 m from the origin they step by 2e-9 m.
  const double size = std::max({std::abs(after.start_m.x), std::abs(after.start_m.y), 1.0});
  const double shortest = std::min(before.chord_length_m(), after.chord_length_m());
  const double s = after.s_start_m;
  if (gap.position_m > 1e-9 + 1e-15 * size) {
    report.problems.push_back(at(road, s, "position gap of " + number("%.3g", gap.position_m) + " m"));
  }
  if (gap.heading_rad > 1e-9 + 1e-15 * size / shortest) {
    report.problems.push_back(at(road, s, "heading gap of " + number("%.3g", gap.heading_rad) + " rad"));
  }
  const double s_gap = std::abs(after.s_start_m - before.s_start_m - before.arc_m);
  if (s != 0 && !(s_gap <= 1e-9 + 1e-12 * s)) {
    report.problems.push_back(at(road, s, "arc length jumps by " + number("%.3g", s_gap) + " m"));
  }
  if (gap.elevation_m > 1e-6) {
    report.problems.push_back(at(road, s, "elevation gap of " + number("%.3g", gap.elevation_m) + " m"));
  }
  if (gap.half_width_m > 1e-6) {
    report.problems.push_back(at(road, s, "width gap of " + number("%.3g", 2 * gap.half_width_m) + " m"));
  }
}

}  // namespace

const Road* Network::find_road(const std::string& id) const {
  for (const Road& road : roads) {
    if (road.id == id) return &road;
  }
  return nullptr;
}

std::size_t Network::segment_count() const {
  std::size_t count = 0;
  for (const Road& road : roads) count += road.segments.size();
  return count;
}

std::size_t segment_at(const Road& road, double s_m) {
  assert(!road.segments.empty());
  if (road.closed) s_m -= std::floor(s_m / road.length_m()) * road.length_m();
  const auto after = std::upper_bound(road.segments.begin(), road.segments.end(), s_m,
                                      [](double s, const Segment& segment) { return s < segment.s_start_m; });
  return after == road.segments.begin() ? 0 : static_cast<std::size_t>(after - road.segments.begin()) - 1;
}

RoadPose pose_at(const Road& road, double s_m, double t_m) {
  if (road.closed) s_m -= std::floor(s_m / road.length_m()) * road.length_m();
  const Segment& segment = road.segments[segment_at(road, s_m)];
  const double local = std::clamp(s_m - segment.s_start_m, 0.0, segment.arc_m);
  const double u = u_at_arc(segment, local);
  RoadPose pose;
  pose.heading_rad = heading_rad(segment, u);
  const glm::dvec2 left(-std::sin(pose.heading_rad), std::cos(pose.heading_rad));
  pose.position_m = glm::dvec3(position_m(segment, u) + left * t_m, segment.elevation_m.value(local));
  pose.pitch_rad = std::atan(segment.elevation_m.slope(local));
  pose.curvature_per_m = curvature_per_m(segment, u);
  return pose;
}

void chain_arc_lengths(Road& road) {
  double s = 0;
  for (Segment& segment : road.segments) {
    segment.s_start_m = s;
    s += segment.arc_m;
  }
}

void Bounds::add(glm::dvec3 p) {
  low_m = glm::min(low_m, p);
  high_m = glm::max(high_m, p);
}

Bounds bounds(const Segment& segment) {
  Bounds b;
  const Cubic::Range z = segment.elevation_m.range(segment.arc_m);
  for (const glm::dvec2 corner : fitted_quad(segment).corner) {
    const glm::dvec2 p = from_chord(segment, corner);
    b.add({p.x, p.y, z.low});
    b.add({p.x, p.y, z.high});
  }
  return b;
}

Bounds bounds(const Network& network) {
  Bounds all;
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      const Bounds b = bounds(segment);
      all.add(b.low_m);
      all.add(b.high_m);
    }
  }
  return all;
}

JointGap joint_gap(const Segment& before, const Segment& after) {
  JointGap gap;
  gap.position_m = glm::length(after.start_m - before.end_m);
  gap.heading_rad = std::abs(wrapped(heading_rad(after, 0) - heading_rad(before, 1)));
  gap.curvature_per_m = std::abs(curvature_per_m(after, 0) - curvature_per_m(before, 1));
  gap.elevation_m = std::abs(after.elevation_m.value(0) - before.elevation_m.value(before.arc_m));
  gap.grade = std::abs(after.elevation_m.slope(0) - before.elevation_m.slope(before.arc_m));
  gap.half_width_m = std::abs(after.half_width_m.value(0) - before.half_width_m.value(before.arc_m));
  return gap;
}

CheckReport check(const Network& network) {
  CheckReport report;
  for (const Road& road : network.roads) {
    if (road.segments.empty()) {
      report.problems.push_back("road " + road.id + ": no segments");
      continue;
    }
    for (const Segment& segment : road.segments) check_segment(road, segment, report);
    for (std::size_t i = 0; i + 1 < road.segments.size(); ++i) {
      check_joint(road, road.segments[i], road.segments[i + 1], report);
    }
    if (road.closed) check_joint(road, road.segments.back(), road.segments.front(), report);
  }
  return report;
}

}  // namespace roadgen
