#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include <glm/geometric.hpp>

#include "roadgen/road/network.h"

namespace roadgen {
namespace {

// Files write widths that end at 0 with few digits.
constexpr double kWidthRounding_m = 1e-4;
// Paint may reach this far beyond the edge.
constexpr double kPaintOver_m = 0.01;
constexpr double kSteepestSuperelevation_rad = 0.25 * std::numbers::pi;
constexpr double kSteepestGrade = 1;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

bool is_finite(const Cubic& c) { return std::isfinite(c.c0 + c.c1 + c.c2 + c.c3); }
bool is_finite(const Linear& l) { return std::isfinite(l.c0 + l.c1); }

bool is_finite(const Segment& s) {
  return std::isfinite(s.start_m.x + s.start_m.y + s.end_m.x + s.end_m.y + s.slope_start + s.slope_end + s.s_start_m +
                       s.arc_m) &&
         is_finite(s.elevation_m) && is_finite(s.superelevation_rad) && is_finite(s.crossfall_left) &&
         is_finite(s.crossfall_right) && is_finite(s.left_m) && is_finite(s.right_m);
}

bool is_finite(const Mark& m) { return std::isfinite(m.width_m + m.space_m + m.on_m + m.off_m + m.phase_m); }

bool is_finite(const LaneSection& section) {
  bool finite = std::isfinite(section.s_m) && is_finite(section.offset_m) && is_finite(section.center_mark);
  for (const auto* side : {&section.left, &section.right}) {
    for (const Lane& lane : *side) {
      finite = finite && is_finite(lane.width_m) && is_finite(lane.mark) &&
               std::isfinite(lane.inner_height_m + lane.outer_height_m);
    }
  }
  return finite;
}

bool is_finite(const Paint& p) { return std::isfinite(p.s_m + p.t_m + p.length_m + p.width_m + p.stripe_m); }

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

// The findings about a road, those of one kind counted and the first of them told.
class Findings {
 public:
  explicit Findings(const Road& road) : road_(road) {}

  void add(double s_m, const char* kind, const std::string& what) {
    const auto [found, is_new] = index_.try_emplace(kind, found_.size());
    if (is_new) found_.push_back({s_m, what, 0});
    ++found_[found->second].count;
  }

  std::vector<std::string> texts() const {
    std::vector<std::string> texts;
    for (const Finding& f : found_) {
      const std::string more = f.count > 1 ? " (and so in " + std::to_string(f.count - 1) + " more places)" : "";
      texts.push_back(at(road_, f.s_m, f.what + more));
    }
    return texts;
  }

 private:
  struct Finding {
    double s_m;
    std::string what;
    int count;
  };
  const Road& road_;
  std::map<std::string, std::size_t> index_;
  std::vector<Finding> found_;
};

// Where on [0, length_m] the cubic is least.
double least_at(const Cubic& c, double length_m) {
  double best = 0;
  constexpr int kProbes = 64;
  for (int i = 1; i <= kProbes; ++i) {
    const double s = length_m * i / kProbes;
    if (c.value(s) < c.value(best)) best = s;
  }
  return best;
}

void find_bad_widths(const Road& road, Findings& findings) {
  for (std::size_t i = 0; i < road.sections.size(); ++i) {
    const LaneSection& section = road.sections[i];
    const double end = i + 1 < road.sections.size() ? road.sections[i + 1].s_m : road.length_m();
    const double length = std::max(end - section.s_m, 0.0);
    double widest = 0;
    const auto look = [&](const std::vector<Lane>& lanes, int sign) {
      for (std::size_t k = 0; k < lanes.size(); ++k) {
        const Cubic::Range range = lanes[k].width_m.range(length);
        widest = std::max(widest, range.high);
        if (range.low >= -kWidthRounding_m) continue;
        const std::string id = std::to_string(sign * (static_cast<int>(k) + 1));
        findings.add(
            section.s_m + least_at(lanes[k].width_m, length), "lane width",
            "lane " + id + " has a negative width of " + number("%.3g", range.low) + " m, so that its borders cross");
      }
    };
    look(section.left, 1);
    look(section.right, -1);
    if (!(widest > kWidthRounding_m)) findings.add(section.s_m, "no width", "no lane has any width");
  }
}

void find_steep_profiles(const Segment& segment, Findings& findings) {
  const double s = segment.s_start_m, arc = segment.arc_m;
  const Cubic::Range bank = segment.superelevation_rad.range(arc);
  const double most = std::max(-bank.low, bank.high);
  if (most > kSteepestSuperelevation_rad) {
    findings.add(s, "superelevation",
                 "superelevation of " + number("%.1f", most * 180 / std::numbers::pi) + " degrees, beyond 45");
  }
  const Cubic& z = segment.elevation_m;
  const Cubic::Range grade = Cubic{z.c1, 2 * z.c2, 3 * z.c3, 0}.range(arc);
  const double steepest = std::max(-grade.low, grade.high);
  if (steepest > kSteepestGrade) {
    findings.add(s, "grade", "grade of " + number("%.0f", 100 * steepest) + " %, beyond 100 %");
  }
  double fall = 0;
  for (const Linear& side : {segment.crossfall_left, segment.crossfall_right}) {
    fall = std::max({fall, std::abs(side.c0), std::abs(side.value(arc))});
  }
  if (fall > kSteepestGrade) {
    findings.add(s, "crossfall", "crossfall of " + number("%.0f", 100 * fall) + " %, beyond 100 %");
  }
}

void find_tight_bend(const Segment& segment, Findings& findings) {
  constexpr int kProbes = 32;
  for (int i = 0; i <= kProbes; ++i) {
    const double u = static_cast<double>(i) / kProbes, curvature = curvature_per_m(segment, u);
    const double local = arc_at(segment, u);
    const double inner = curvature > 0 ? segment.left_m.value(local) : -segment.right_m.value(local);
    if (!(std::abs(curvature) * inner >= 1)) continue;
    findings.add(segment.s_start_m + local, "tight bend",
                 "radius of " + number("%.3g", 1 / std::abs(curvature)) + " m, less than the " + number("%.3g", inner) +
                     " m to the inner edge");
    return;
  }
}

void find_bad_paint(const Road& road, Findings& findings) {
  for (const Paint& p : road.paint) {
    if (!is_finite(p)) {
      findings.add(0, "finite", "a number of the paint is not finite");
      continue;
    }
    if (!(p.length_m > 0 && p.width_m > 0 && p.stripe_m > 0)) {
      findings.add(p.s_m, "paint size", "paint whose length, width or stripe is not positive");
      continue;
    }
    const double s = std::clamp(p.s_m, 0.0, road.length_m());
    const Segment& segment = road.segments[segment_at(road, s)];
    const double local = std::clamp(s - segment.s_start_m, 0.0, segment.arc_m);
    if (s != p.s_m || p.t_m + 0.5 * p.width_m > segment.left_m.value(local) + kPaintOver_m ||
        p.t_m - 0.5 * p.width_m < segment.right_m.value(local) - kPaintOver_m) {
      findings.add(p.s_m, "paint place", "paint outside the road, at t = " + number("%.2f", p.t_m) + " m");
    }
  }
}

// Every section starts at a joint, and every segment has the section that holds there.
void find_bad_sections(const Road& road, Findings& findings) {
  if (road.sections.empty()) {
    findings.add(0, "sections", "no lane sections");
    return;
  }
  constexpr double kSameStation_m = 1e-6;
  for (const LaneSection& section : road.sections) {
    const auto joint = std::partition_point(road.segments.begin(), road.segments.end(), [&](const Segment& segment) {
      return segment.s_start_m < section.s_m - kSameStation_m;
    });
    if (joint == road.segments.end() || joint->s_start_m > section.s_m + kSameStation_m)
      findings.add(section.s_m, "section start", "a lane section starts elsewhere than at a joint");
  }
  for (const Segment& segment : road.segments) {
    const std::size_t i = segment.section;
    const bool holds = i < road.sections.size() && road.sections[i].s_m <= segment.s_start_m + kSameStation_m &&
                       (i + 1 == road.sections.size() || road.sections[i + 1].s_m > segment.s_start_m);
    if (!holds)
      findings.add(segment.s_start_m, "section of", "a segment does not have the lane section that holds there");
  }
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
  // Strips along a junction's corner may taper away.
  const Cubic::Range width = (segment.left_m - segment.right_m).range(segment.arc_m);
  if (!(width.low > -kWidthRounding_m && width.high > 0)) {
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

bool is_finite(const Road& road) {
  const auto finite = [](const auto& x) { return is_finite(x); };
  return std::all_of(road.segments.begin(), road.segments.end(), finite) &&
         std::all_of(road.sections.begin(), road.sections.end(), finite) &&
         std::all_of(road.paint.begin(), road.paint.end(), finite) && is_sound(*road.records);
}

OddValues odd_values(const Road& road) {
  if (road.segments.empty()) return {};
  Findings problems(road), warnings(road);
  for (const LaneSection& section : road.sections) {
    if (!is_finite(section)) problems.add(0, "finite section", "a number of a lane section is not finite");
  }
  for (const Segment& segment : road.segments) {
    if (!is_finite(segment) || !(segment.chord_length_m() > 0)) continue;  // told by check()
    find_steep_profiles(segment, warnings);
    find_tight_bend(segment, problems);
  }
  find_bad_sections(road, problems);
  find_bad_widths(road, problems);
  find_bad_paint(road, problems);
  return {problems.texts(), warnings.texts()};
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
    for (const Segment& segment : road.segments) check_segment(road, segment, report);
    OddValues odd = odd_values(road);
    for (std::string& problem : odd.problems) report.problems.push_back(std::move(problem));
    for (std::string& warning : odd.warnings) report.warnings.push_back(std::move(warning));
    for (const Sweep& sweep : road.sweeps) {
      for (std::string& problem : problems(road, sweep)) report.problems.push_back(std::move(problem));
    }
    if (!is_sound(*road.records)) {
      report.problems.push_back("road " + road.id +
                                ": an object, signal or speed has a number that is not finite, or a negative size");
    }
    for (const Bridge& bridge : road.bridges) {
      if (!is_on(bridge, road)) {
        report.problems.push_back(at(road, bridge.s_start_m, "a bridge has no length or reaches beyond the road"));
      }
    }
    for (std::size_t i = 0; i + 1 < road.segments.size(); ++i) {
      check_joint(road, road.segments[i], road.segments[i + 1], report);
    }
    if (road.closed) check_joint(road, road.segments.back(), road.segments.front(), report);
  }
  for (const Junction& junction : network.junctions) {
    for (std::string& problem : problems(junction)) report.problems.push_back(std::move(problem));
  }
  for (std::string& problem : link_problems(network)) report.problems.push_back(std::move(problem));
  return report;
}

}  // namespace roadgen
