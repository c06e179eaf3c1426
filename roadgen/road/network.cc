#include "roadgen/road/network.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

std::string at(const Road& road, double s_m, const std::string& what) {
  char text[64];
  std::snprintf(text, sizeof text, ", s = %.3f m: ", s_m);
  return "road " + road.id + text + what;
}

}  // namespace

const Road* Network::find_road(const std::string& id) const {
  for (const Road& road : roads) {
    if (road.id == id) return &road;
  }
  return nullptr;
}

RoadsById roads_by_id(const Network& network) {
  RoadsById roads;
  roads.reserve(network.roads.size());
  for (std::size_t i = 0; i < network.roads.size(); ++i) roads.emplace(network.roads[i].id, i);
  return roads;
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

void lean(RoadPose& pose, glm::dvec2 tangent, glm::dvec2 gradient) {
  pose.grade = glm::dot(tangent, gradient);
  pose.pitch_rad = std::atan(pose.grade);
  pose.roll_rad = std::atan(tangent.x * gradient.y - tangent.y * gradient.x);
  pose.normal = glm::dvec3(-gradient, 1) / std::sqrt(1 + glm::dot(gradient, gradient));
}

RoadPose pose_at(const Road& road, double s_m, double t_m) {
  if (road.closed) s_m -= std::floor(s_m / road.length_m()) * road.length_m();
  const Segment& segment = road.segments[segment_at(road, s_m)];
  return pose_in(road, segment, s_m - segment.s_start_m, t_m);
}

RoadPose pose_in(const Road& road, const Segment& segment, double local_s_m, double t_m) {
  const double local = std::clamp(local_s_m, 0.0, segment.arc_m), u = u_at_arc(segment, local);
  const double a = segment.slope_start, b = segment.slope_end, df = Lib::road_df(u, a, b);
  const glm::dvec2 chord = segment.chord_m(), aside(-chord.y, chord.x), along = chord + aside * df;
  const double length = glm::length(along);  // of the chord, times sqrt(1 + df^2)
  const glm::dvec2 tangent = along / length, left(-tangent.y, tangent.x);
  RoadPose pose;
  pose.heading_rad = std::atan2(along.y, along.x);
  pose.curvature_per_m = Lib::road_ddf(u, a, b) / ((1 + df * df) * length);
  const double tilt = segment.superelevation_rad.value(local), n = t_m * std::cos(tilt);
  const Lib::SurfaceSlope surface = surface_at(segment, local, n);
  const LaneSurface lanes = lane_surface(section_of(road, segment), section_offset_m(road, segment) + local, t_m);
  pose.position_m = glm::dvec3(position_m(segment, u) + left * n, surface.height + lanes.height_m);
  // t = n / cos(superelevation) changes along a line of constant n.
  const double turn = t_m * std::tan(tilt) * segment.superelevation_rad.slope(local);
  const double ahead = surface.ahead + lanes.along + lanes.across * turn;
  const double across = surface.aside + lanes.across / surface.cosine;
  lean(pose, tangent, tangent * grade_at(ahead, n, pose.curvature_per_m) + left * across);
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

void divide_into_lanes(Road& road, int lanes) {
  std::vector<LaneSection> sections;
  const auto part = [](double by, const Cubic& c) { return Cubic{by * c.c0, by * c.c1, by * c.c2, by * c.c3}; };
  // Lanes of one width over the width of a side.
  const auto side = [&](int count, const Cubic& width) {
    std::vector<Lane> all(static_cast<std::size_t>(count));
    if (all.empty()) return all;
    for (Lane& lane : all) {
      lane.width_m = part(1.0 / count, width);
      lane.mark.kind = MarkKind::kBroken;
    }
    all.back().mark.kind = MarkKind::kSolid;
    // No room for shoulders on a path.
    if (all.back().width_m.c0 < 4 * kEdgeStrip_m) return all;
    all.back().width_m.c0 -= kEdgeStrip_m;
    all.push_back({.type = LaneType::kShoulder, .width_m = {kEdgeStrip_m}, .mark = {}});
    return all;
  };
  const int to_left = lanes / 2, to_right = lanes - to_left;
  const Segment* first = nullptr;
  for (const Segment& segment : road.segments) {
    const bool shared = first && first->left_m.is_constant() && first->right_m.is_constant() &&
                        segment.left_m == first->left_m && segment.right_m == first->right_m;
    if (shared) continue;
    first = &segment;
    LaneSection section;
    section.s_m = segment.s_start_m;
    section.center_mark.kind = lanes == 1 ? MarkKind::kSolid : lanes < 4 ? MarkKind::kBroken : MarkKind::kSolidSolid;
    if (to_left != to_right) {
      section.offset_m = segment.left_m - part(1.0 * to_left / lanes, segment.left_m - segment.right_m);
    }
    section.left = side(to_left, segment.left_m - section.offset_m);
    section.right = side(to_right, section.offset_m - segment.right_m);
    sections.push_back(std::move(section));
  }
  // Sections that start with the segments always fit; the edges become their borders, to a rounding.
  if (!sections.empty()) (void)set_sections(road, std::move(sections));
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

// The part's box is that of the curve between its ends; these lean from it by the curve's slope.
Bounds bounds(const Road& road, const SweepPart& part) {
  const Segment& segment = road.segments[part.segment];
  const Lib::SweepPiece& piece = part.piece;
  const double chord = segment.chord_length_m(), a = segment.slope_start, b = segment.slope_end;
  double steep = 0;
  for (const double u : {piece.u0, piece.u1}) steep = std::max(steep, std::abs(Lib::road_df(u, a, b)));
  const Cubic::Range f = curve_range(a, b);
  const double widest = std::max(piece.y1 - chord * f.low, chord * f.high - piece.y0);
  Bounds box;
  for (const double x : {piece.u0 - steep * widest / chord, piece.u1 + steep * widest / chord}) {
    for (const double y : {piece.y0, piece.y1}) {
      const glm::dvec2 p = from_chord(segment, {x, y / chord});
      box.add({p, segment.elevation_m.c0 + piece.z0});
      box.add({p, segment.elevation_m.c0 + piece.z1});
    }
  }
  return box;
}

Bounds bounds(const Network& network) {
  Bounds all;
  const auto add = [&](const Bounds& b) {
    all.add(b.low_m);
    all.add(b.high_m);
  };
  for (const Junction& junction : network.junctions) add(bounds(junction));
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) add(bounds(segment));
    for (std::size_t i = 0; i < road.sweeps.size(); ++i) {
      for (const SweepPart& part : sweep_parts(road, i)) add(bounds(road, part));
    }
  }
  return all;
}

}  // namespace roadgen
