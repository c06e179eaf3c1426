#include "roadgen/road/sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <type_traits>

#include "roadgen/road/network.h"
#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

struct Findings {
  const Road& road;
  double s_m;
  std::vector<std::string> list;

  void add(double at_m, const std::string& what) {
    char text[64];
    std::snprintf(text, sizeof text, ", s = %.3f m: ", at_m);
    list.push_back("road " + road.id + text + what);
  }
  // Requires value > low (or >= where equal is allowed); false for NaN and infinity too.
  void at_least(double value, double low, bool or_equal, const char* name) {
    if (std::isfinite(value) && (value > low || (or_equal && value == low))) return;
    char text[160];
    std::snprintf(text, sizeof text, "%s must be %s %g, is %g", name, or_equal ? "at least" : "above", low, value);
    add(s_m, text);
  }
  void at_most(double value, double high, const char* name, const char* of) {
    if (!(value > high)) return;
    char text[160];
    std::snprintf(text, sizeof text, "%s must be at most %s, %g, is %g", name, of, high, value);
    add(s_m, text);
  }
};

void check_shape(const Tunnel& x, Findings& found) {
  found.at_least(x.half_width_m, 0, false, "the tunnel's half width");
  found.at_least(x.wall_height_m, 0, true, "the height of the tunnel's walls");
  found.at_least(x.arch_rise_m, 0, false, "the rise of the tunnel's arch");
  found.at_most(x.arch_rise_m, x.half_width_m, "the rise of the tunnel's arch", "its half width");
  found.at_least(x.lining_m, 0, false, "the thickness of the tunnel's lining");
  found.at_least(x.head_wall_m, 0, true, "the thickness of the tunnel's head walls");
  found.at_least(x.head_margin_m, 0, true, "the margin of the tunnel's head walls");
  found.at_least(x.walkway_m, 0, true, "the width of the tunnel's walkways");
  found.at_most(x.walkway_m, x.half_width_m, "the width of the tunnel's walkways", "its half width");
  found.at_least(x.lamp_spacing_m, 0, false, "the spacing of the tunnel's lamps");
}

void check_shape(const GuardRail& x, Findings& found) {
  found.at_least(x.beam_height_m, 0, false, "the height of the rail's beam");
  found.at_least(x.beam_depth_m, 0, false, "the depth of the rail's beam");
  found.at_least(x.sheet_m, 0, false, "the thickness of the rail's sheet");
  found.at_least(x.top_m, x.beam_height_m, true, "the top of the rail");
  if (x.post_spacing_m == 0) return;
  found.at_least(x.post_spacing_m, 0.5, true, "the spacing of the rail's posts");
  found.at_least(x.post_along_m, 0, false, "the side of the rail's posts");
  found.at_least(x.post_across_m, 0, false, "the side of the rail's posts");
}

void check_shape(const Pipe& x, Findings& found) {
  found.at_least(x.radius_m, 0, false, "the pipe's radius");
  if (!std::isfinite(x.height_m)) found.add(found.s_m, "the pipe's height is not finite");
}

void check_shape(const Cable& x, Findings& found) {
  found.at_least(x.radius_m, 0, false, "the cable's radius");
  found.at_least(x.height_m, 0, false, "the cable's height");
  found.at_least(x.span_m, 1, true, "the cable's span");
  found.at_least(x.sag_m, 0, true, "the cable's sag");
  found.at_most(x.sag_m, x.height_m, "the cable's sag", "its height");
  found.at_least(x.pole_radius_m, 0, true, "the radius of the cable's poles");
  found.at_least(x.pole_above_m, 0, true, "the height of the cable's poles above it");
}

auto members(auto& shape) {
  using Shape = std::remove_cvref_t<decltype(shape)>;
  auto& x = shape;
  if constexpr (std::is_same_v<Shape, Tunnel>) {
    return std::tie(x.half_width_m, x.wall_height_m, x.arch_rise_m, x.lining_m, x.head_wall_m, x.head_margin_m,
                    x.walkway_m, x.lamp_spacing_m);
  } else if constexpr (std::is_same_v<Shape, GuardRail>) {
    return std::tie(x.top_m, x.beam_height_m, x.beam_depth_m, x.sheet_m, x.post_spacing_m, x.post_along_m,
                    x.post_across_m);
  } else if constexpr (std::is_same_v<Shape, Pipe>) {
    return std::tie(x.radius_m, x.height_m);
  } else {
    return std::tie(x.radius_m, x.height_m, x.span_m, x.sag_m, x.pole_radius_m, x.pole_above_m);
  }
}

template <class Shape>
std::optional<SweepShape> shape_from(std::span<const double> numbers) {
  Shape shape;
  auto all = members(shape);
  if (numbers.size() != std::tuple_size_v<decltype(all)>) return std::nullopt;
  std::size_t next = 0;
  std::apply([&](auto&... member) { ((member = numbers[next++]), ...); }, all);
  return shape;
}

}  // namespace

std::vector<double> shape_numbers(const SweepShape& shape) {
  return std::visit(
      [](const auto& x) {
        return std::apply([](const auto&... member) { return std::vector<double>{member...}; }, members(x));
      },
      shape);
}

std::optional<SweepShape> shape_from_numbers(SweepKind kind, std::span<const double> numbers) {
  switch (kind) {
    case SweepKind::kTunnel: return shape_from<Tunnel>(numbers);
    case SweepKind::kGuardRail: return shape_from<GuardRail>(numbers);
    case SweepKind::kPipe: return shape_from<Pipe>(numbers);
    case SweepKind::kCable: return shape_from<Cable>(numbers);
  }
  return std::nullopt;
}

std::vector<std::string> bad_numbers(const Road& road, const Sweep& sweep) {
  Findings found{road, sweep.s_start_m, {}};
  if (road.segments.empty()) {
    found.add(0, "a sweep along a road without segments");
    return found.list;
  }
  if (!std::isfinite(sweep.s_start_m) || !std::isfinite(sweep.s_end_m) || !std::isfinite(sweep.t_m) ||
      !std::isfinite(sweep.t_slope)) {
    found.add(0, "a number of the sweep's place is not finite");
    return found.list;
  }
  if (!(sweep.s_end_m > sweep.s_start_m)) found.add(sweep.s_start_m, "the sweep ends before it starts");
  std::visit([&](const auto& shape) { check_shape(shape, found); }, sweep.shape);
  if (const auto& c = sweep.albedo;
      c && !(c->x >= 0 && c->x <= 1 && c->y >= 0 && c->y <= 1 && c->z >= 0 && c->z <= 1)) {
    found.add(sweep.s_start_m, "the sweep's albedo must lie in 0 to 1");
  }
  return found.list;
}

std::vector<std::string> problems(const Road& road, const Sweep& sweep) {
  Findings found{road, sweep.s_start_m, bad_numbers(road, sweep)};
  if (!found.list.empty()) return found.list;
  // Rounding of lengths that a file holds in millimetres is no fault.
  constexpr double kSlack_m = 1e-3;
  const double length = road.length_m();
  if (sweep.s_start_m < -kSlack_m) found.add(sweep.s_start_m, "the sweep starts before the road");
  if (sweep.s_end_m > length + kSlack_m) found.add(length, "the sweep ends beyond the road");
  for (const double s : tight_places(road, sweep)) {
    found.add(s, "the road bends too tightly here for the sweep beside it, which has a gap");
  }
  return found.list;
}

std::vector<Sweep> parts_between_tight_bends(const Road& road, const Sweep& sweep, double least_m) {
  if (!(sweep.s_end_m - sweep.s_start_m >= least_m)) return {};
  const std::vector<double> tight = tight_places(road, sweep);
  if (tight.empty()) return {sweep};
  std::vector<Sweep> parts;
  double from = sweep.s_start_m;
  // A part has ends of its own, with head walls that may be too wide there: it is looked at again.
  const auto add_to = [&](double to) {
    Sweep part = sweep;
    part.s_start_m = from;
    part.s_end_m = to;
    part.t_m += sweep.t_slope * (from - sweep.s_start_m);
    const std::vector<Sweep> more = parts_between_tight_bends(road, part, least_m);
    parts.insert(parts.end(), more.begin(), more.end());
  };
  for (const double s_m : tight) {
    const Segment& segment = road.segments[segment_at(road, s_m + 1e-6)];
    add_to(segment.s_start_m);
    from = segment.s_start_m + segment.arc_m;
  }
  add_to(sweep.s_end_m);
  return parts;
}

}  // namespace roadgen
