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
                     s.superelevation_rad.c0 + s.superelevation_rad.c1 + s.superelevation_rad.c2 +
                     s.superelevation_rad.c3 + s.crossfall_left.c0 + s.crossfall_left.c1 + s.crossfall_right.c0 +
                     s.crossfall_right.c1 + s.left_m.c0 + s.left_m.c1 + s.left_m.c2 + s.left_m.c3 + s.right_m.c0 +
                     s.right_m.c1 + s.right_m.c2 + s.right_m.c3;
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
  if (!((segment.left_m - segment.right_m).range(segment.arc_m).low > 0)) {
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
  worst.superelevation_rad = std::max(worst.superelevation_rad, gap.superelevation_rad);
  worst.edge_m = std::max(worst.edge_m, gap.edge_m);

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
  if (gap.edge_m > 1e-6 && before.section == after.section) {
    report.problems.push_back(at(road, s, "width gap of " + number("%.3g", gap.edge_m) + " m"));
  }
  if (gap.superelevation_rad > 1e-6) {
    report.problems.push_back(at(road, s, "superelevation gap of " + number("%.3g", gap.superelevation_rad) + " rad"));
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

double surface_height_m(const Road& road, const Segment& segment, double local_s_m, double t_m) {
  const double n = t_m * std::cos(segment.superelevation_rad.value(local_s_m));
  return surface_at(segment, local_s_m, n).height +
         lane_height_m(section_of(road, segment), section_offset_m(road, segment) + local_s_m, t_m);
}

RoadPose pose_at(const Road& road, double s_m, double t_m) {
  if (road.closed) s_m -= std::floor(s_m / road.length_m()) * road.length_m();
  const Segment& segment = road.segments[segment_at(road, s_m)];
  const double local = std::clamp(s_m - segment.s_start_m, 0.0, segment.arc_m);
  const double u = u_at_arc(segment, local);
  RoadPose pose;
  pose.heading_rad = heading_rad(segment, u);
  const glm::dvec2 left(-std::sin(pose.heading_rad), std::cos(pose.heading_rad));
  pose.curvature_per_m = curvature_per_m(segment, u);
  const double n = t_m * std::cos(segment.superelevation_rad.value(local));
  const Lib::SurfaceSlope surface = surface_at(segment, local, n);
  pose.position_m = glm::dvec3(position_m(segment, u) + left * n, surface_height_m(road, segment, local, t_m));
  pose.pitch_rad = std::atan(surface.ahead / std::max(1 - n * pose.curvature_per_m, 0.05));
  pose.roll_rad = std::atan(surface.aside);
  return pose;
}

const LaneSection& section_of(const Road& road, const Segment& segment) {
  static const LaneSection none;
  return segment.section < road.sections.size() ? road.sections[segment.section] : none;
}

double section_offset_m(const Road& road, const Segment& segment) {
  return segment.s_start_m - section_of(road, segment).s_m;
}

Status set_sections(Road& road, std::vector<LaneSection> sections) {
  constexpr double kSameStation_m = 1e-6;
  if (sections.empty() || std::abs(sections.front().s_m) > kSameStation_m) {
    return Error{ErrorCode::kData, "no lane section starts at s = 0", {}, 0, "road " + road.id};
  }
  std::size_t next = 0;
  std::vector<Cubic> borders;
  for (Segment& segment : road.segments) {
    if (next < sections.size() && segment.s_start_m >= sections[next].s_m - kSameStation_m) {
      sections[next].s_m = segment.s_start_m;
      borders = sections[next++].borders_m();
    }
    if (next < sections.size() && sections[next].s_m < segment.s_start_m + segment.arc_m - kSameStation_m) {
      return Error{ErrorCode::kData, at(road, sections[next].s_m, "a lane section starts within a segment")};
    }
    segment.section = static_cast<std::uint32_t>(next - 1);
    const double by = segment.s_start_m - sections[next - 1].s_m;
    segment.right_m = borders.front().shifted(by);
    segment.left_m = borders.back().shifted(by);
    set_bound(segment);
  }
  if (next < sections.size()) {
    return Error{ErrorCode::kData, at(road, sections[next].s_m, "a lane section starts beyond the road's end")};
  }
  road.sections = std::move(sections);
  return Done{};
}

void two_lane_sections(Road& road) {
  road.sections.clear();
  const auto side = [](const Cubic& width) {
    std::vector<Lane> lanes(1);
    lanes[0].mark.kind = MarkKind::kSolid;
    lanes[0].width_m = width;
    // No room for shoulders on a path.
    if (width.c0 < 4 * kEdgeStrip_m) return lanes;
    lanes[0].width_m.c0 -= kEdgeStrip_m;
    lanes.push_back({.type = LaneType::kShoulder, .width_m = {kEdgeStrip_m}, .mark = {}});
    return lanes;
  };
  const Segment* first = nullptr;
  for (Segment& segment : road.segments) {
    const bool shared = first && first->left_m.is_constant() && first->right_m.is_constant() &&
                        segment.left_m == first->left_m && segment.right_m == first->right_m;
    if (!shared) {
      first = &segment;
      LaneSection section;
      section.s_m = segment.s_start_m;
      section.center_mark.kind = MarkKind::kBroken;
      section.left = side(segment.left_m);
      section.right = side(-segment.right_m);
      road.sections.push_back(std::move(section));
    }
    segment.section = static_cast<std::uint32_t>(road.sections.size() - 1);
  }
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
  const Cubic::Range z = height_range_m(segment);
  for (const glm::dvec2 corner : fitted_quad(segment).corner) {
    const glm::dvec2 p = from_chord(segment, corner);
    b.add({p.x, p.y, z.low});
    b.add({p.x, p.y, z.high});
  }
  return b;
}

Bounds bounds(const Junction& junction) {
  Bounds b;
  const auto add = [&](const Bounds& other) {
    b.add(other.low_m);
    b.add(other.high_m);
  };
  for (const auto& corner : junction.corners) {
    for (const Segment& segment : corner) add(bounds(segment));
  }
  for (const JunctionArm& arm : junction.arms) {
    for (const double n : {arm.left_m, 0.0, arm.right_m}) b.add(glm::dvec3(cut_point_m(arm, n), cut_height_m(arm, n)));
  }
  return b;
}

Bounds bounds(const Network& network) {
  Bounds all;
  for (const Junction& junction : network.junctions) {
    const Bounds b = bounds(junction);
    all.add(b.low_m);
    all.add(b.high_m);
  }
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
  gap.superelevation_rad = std::abs(after.superelevation_rad.value(0) - before.superelevation_rad.value(before.arc_m));
  gap.edge_m = std::max(std::abs(after.left_m.value(0) - before.left_m.value(before.arc_m)),
                        std::abs(after.right_m.value(0) - before.right_m.value(before.arc_m)));
  return gap;
}

CheckReport check(const Network& network) {
  CheckReport report;
  for (const Road& road : network.roads) {
    if (road.segments.empty()) {
      report.problems.push_back("road " + road.id + ": no segments");
      continue;
    }
    if (road.sections.empty()) report.problems.push_back("road " + road.id + ": no lane sections; it is not drawn");
    for (const Segment& segment : road.segments) check_segment(road, segment, report);
    for (std::size_t i = 0; i + 1 < road.segments.size(); ++i) {
      check_joint(road, road.segments[i], road.segments[i + 1], report);
    }
    if (road.closed) check_joint(road, road.segments.back(), road.segments.front(), report);
  }
  for (const Junction& junction : network.junctions) {
    for (std::string& problem : problems(junction)) report.problems.push_back(std::move(problem));
  }
  return report;
}

}  // namespace roadgen
