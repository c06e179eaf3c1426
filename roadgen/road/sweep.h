// Structures along a road: a profile swept along its curve between two arc lengths, cross sections in vertical planes
// perpendicular to the horizontal tangent. Drawn without tessellation (shaders/lib/sweep.glsl).
//
//   road.sweeps.push_back({.s_start_m = 40, .s_end_m = 200, .t_m = -4.2, .shape = GuardRail{}});
//   for (const std::string& problem : problems(road, road.sweeps.back())) ...
#pragma once

#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <glm/vec3.hpp>

namespace roadgen {

struct Road;

// A vault open below: vertical walls, an arch (part of a circle) over them, a lining of even thickness, and a head wall
// around each portal. t is that of its middle.
struct Tunnel {
  double half_width_m = 5;     // clear; > 0
  double wall_height_m = 2.6;  // of the vertical walls above the road; >= 0
  double arch_rise_m = 4;      // of the arch above the walls; in (0, half_width_m]
  double lining_m = 0.45;      // > 0
  double head_wall_m = 0.8;    // thickness of the head walls; 0: none
  double head_margin_m = 1.2;  // of the head walls beyond the lining, to the sides and above; >= 0
  double walkway_m = 1.5;      // width of the walkways along both walls, in [0, half_width_m)
  double lamp_spacing_m = 12;  // > 0
  bool operator==(const Tunnel&) const = default;
};

// A W beam (two ridges toward the road) on posts behind it. t is that of the beam's back.
// Defaults: AASHTO M 180 (beam), EN 1317 practice (posts).
struct GuardRail {
  double top_m = 0.75;          // upper edge above the road; > beam_height_m
  double beam_height_m = 0.31;  // > 0
  double beam_depth_m = 0.081;  // back to ridge; > 0
  double sheet_m = 0.003;       // thickness; > 0
  double post_spacing_m = 4;    // >= 0.5; 0: no posts
  double post_along_m = 0.06;   // sides of a post; > 0
  double post_across_m = 0.12;
  bool operator==(const GuardRail&) const = default;
};

struct Pipe {
  double radius_m = 0.3;  // > 0
  double height_m = 0.6;  // of the axis above the road
  bool operator==(const Pipe&) const = default;
};

// A cable in parabolas between poles that stand every span_m from its start.
struct Cable {
  double radius_m = 0.012;      // > 0
  double height_m = 7;          // of the cable at the poles above the road
  double span_m = 45;           // >= 1
  double sag_m = 0.9;           // in the middle of a whole span, shorter ones less by the square; in [0, height_m)
  double pole_radius_m = 0.13;  // 0: no poles
  double pole_above_m = 0.3;    // of the poles above the cable
  bool operator==(const Cable&) const = default;
};

// Order as SweepShape's alternatives.
enum class SweepKind { kTunnel, kGuardRail, kPipe, kCable };
using SweepShape = std::variant<Tunnel, GuardRail, Pipe, Cable>;

struct Sweep {
  double s_start_m = 0;  // along the road, 0 <= s_start < s_end <= its length
  double s_end_m = 0;
  double t_m = 0;      // offset of the swept axis at s_start, horizontally, left positive
  double t_slope = 0;  // and its change per metre of s
  SweepShape shape;
  std::optional<glm::dvec3> albedo = {};  // linear, [0, 1]; default: the kind's material

  SweepKind kind() const { return static_cast<SweepKind>(shape.index()); }
  bool operator==(const Sweep&) const = default;
};

// The numbers of a shape in the order of its members, for files; and back, none where that kind has another count.
std::vector<double> shape_numbers(const SweepShape& shape);
std::optional<SweepShape> shape_from_numbers(SweepKind kind, std::span<const double> numbers);

// How deep walls, posts and poles reach below the road's height.
inline constexpr double kSweepFoot_m = 0.6;
// Least part of its length that a road's centre line may keep at the inside of a sweep: 1 - n / radius of curvature.
inline constexpr double kLeastStretch = 0.2;

// The parts of a sweep of good numbers between the segments that bend too tightly for it, at least least_m long; along the road.
std::vector<Sweep> parts_between_tight_bends(const Road& road, const Sweep& sweep, double least_m);

// What is wrong with a sweep, each "road R, s = 12.300 m: what"; empty where nothing is. A sweep with a bad number is
// not drawn, one that runs past the road is cut off there, and where the road bends tighter than it allows there is a gap.
// Cost: O(segments).
std::vector<std::string> problems(const Road& road, const Sweep& sweep);

}  // namespace roadgen
