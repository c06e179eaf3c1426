#include "terrain/hollow.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "terrain/clipped.h"
#include "terrain/plates.h"

namespace roadgen {
namespace {

constexpr double kRounding_m = 0.01;  // of tile-relative floats, and more

// How much lower than the axis the carriageway's surface may be anywhere under the vault.
double surface_depth_m(const Road& road, const Segment& segment, double half_width_m) {
  const auto most = [&](const auto& profile) {
    const double a = profile.value(0), b = profile.value(segment.arc_m);
    return std::max(std::abs(a), std::abs(b));
  };
  const Cubic::Range tilt = segment.superelevation_rad.range(segment.arc_m);
  const double lean = std::tan(std::min(std::max(std::abs(tilt.low), std::abs(tilt.high)), 1.4));
  const double fall = std::max(most(segment.crossfall_left), most(segment.crossfall_right));
  return 2 * half_width_m * (lean + fall) - lowest_lane_m(road, segment);
}

}  // namespace

glm::dvec3 Hollow::local(glm::dvec3 point_m) const {
  const glm::dvec3 d = point_m - start_m;
  return {axis.x * d.x + axis.y * d.y, axis.x * d.y - axis.y * d.x, d.z};
}

bool Hollow::holds(glm::dvec3 point_m) const {
  const glm::dvec3 p = local(point_m);
  return Lib::sweep_hollow(p.x, p.y, p.z, piece) < 0;
}

bool Hollow::is_above(glm::dvec3 point_m) const {
  Lib::SweepPiece bottomless = piece;
  bottomless.z0 = -SWEEP_FAR;
  bottomless.profile.p4 = SWEEP_FAR;
  const glm::dvec3 p = local(point_m);
  return Lib::sweep_hollow(p.x, p.y, p.z, bottomless) < 0;
}

Hollow::Floor Hollow::floor_at(glm::dvec2 point_m) const {
  const glm::dvec3 p = local({point_m, start_m.z});
  const Lib::SweepPoint c = Lib::sweep_locate(p.x, p.y, 0.0, 0.0, 0.0, 1.0, piece.path);
  const glm::dvec2 ahead = c.tx * axis + c.ty * glm::dvec2(-axis.y, axis.x);
  if (std::abs(c.n) > half_walkways_m) return {start_m.z - c.h + SWEEP_WALKWAY, c.grade / c.stretch * ahead};
  const double cosine = std::cos(segment.superelevation_rad.value(c.s));
  const double n = c.n + piece.path.n0 + piece.path.n1 * c.s;
  const double on = std::clamp(n, cosine * segment.right_m.value(c.s), cosine * segment.left_m.value(c.s));
  const Lib::SurfaceSlope slope = surface_at(segment, c.s, on);
  const double aside = on == n ? slope.aside : 0;
  return {slope.height, slope.ahead / c.stretch * ahead + aside * glm::dvec2(-ahead.y, ahead.x)};
}

bool Hollow::may_meet(const std::array<glm::dvec3, 3>& triangle) const {
  Clipped clipped(std::array<glm::dvec3, 3>{local(triangle[0]), local(triangle[1]), local(triangle[2])});
  clipped.clip({0, 1, 0}, piece.y1 + kRounding_m);
  clipped.clip({0, -1, 0}, kRounding_m - piece.y0);
  clipped.clip({0, 0, 1}, piece.z1 + kRounding_m);
  clipped.clip({0, 0, -1}, kRounding_m - piece.z0);
  // The cross sections at the ends, as in sweep_hollow.
  const Lib::SweepPath& r = piece.path;
  const auto end = [&](double u, double sign) {
    const double slope = Lib::road_df(u, r.a, r.b), f = Lib::road_f(u, r.a, r.b);
    clipped.clip({sign, sign * slope, 0},
                 sign * r.chord * (u + slope * f) + kRounding_m * std::sqrt(1 + slope * slope));
  };
  end(piece.u0, -1);
  end(piece.u1, 1);
  return !clipped.empty();
}

Box Hollow::box() const {
  glm::dvec2 low(1e300), high(-1e300);
  for (const double u : {piece.u0, piece.u1}) {
    const double slope = Lib::road_df(u, piece.path.a, piece.path.b), f = Lib::road_f(u, piece.path.a, piece.path.b);
    for (const double y : {piece.y0, piece.y1}) {
      const double x = piece.path.chord * u - slope * (y - piece.path.chord * f);
      const glm::dvec2 p = glm::dvec2(start_m) + x * axis + y * glm::dvec2(-axis.y, axis.x);
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
  }
  return {glm::dvec3(low - kRounding_m, 0), glm::dvec3(high + kRounding_m, 0)};
}

void add_hollows(const Road& road, const SweepPart& part, double s_from_m, double s_to_m,
                 std::vector<Hollow>& hollows) {
  const Segment& segment = road.segments[part.segment];
  const auto& tunnel = std::get<Tunnel>(road.sweeps[part.sweep].shape);
  const double from = std::max(s_from_m - segment.s_start_m, arc_at(segment, part.piece.u0));
  const double to = std::min(s_to_m - segment.s_start_m, arc_at(segment, part.piece.u1));
  if (!(to > from)) return;
  Hollow h;
  h.start_m = {segment.start_m, segment.elevation_m.c0};
  h.axis = segment.chord_m() / segment.chord_length_m();
  h.piece = part.piece;
  h.segment = segment;
  Lib::SweepProfile& vault = h.piece.profile;
  vault.p0 += 0.5 * tunnel.lining_m;
  vault.p2 += 0.5 * tunnel.lining_m;
  vault.p4 = Hollow::kFloor_m + surface_depth_m(road, segment, tunnel.half_width_m);
  h.half_width_m = tunnel.half_width_m + tunnel.lining_m;
  h.height_m = tunnel.wall_height_m + tunnel.arch_rise_m + tunnel.lining_m;
  h.half_walkways_m = tunnel.half_width_m - tunnel.walkway_m;
  const Lib::SweepPath& r = part.piece.path;
  const Cubic axis{r.z0, r.z1, r.z2, r.z3};
  const int pieces = std::max(1, static_cast<int>(std::ceil((to - from) / Hollow::kLongest_m)));
  for (int i = 0; i < pieces; ++i) {
    h.s0_m = from + (to - from) * i / pieces;
    h.s1_m = from + (to - from) * (i + 1) / pieces;
    h.piece.u0 = u_at_arc(segment, h.s0_m);
    h.piece.u1 = u_at_arc(segment, h.s1_m);
    h.from_start_m = segment.s_start_m + h.s0_m - s_from_m;
    h.to_end_m = s_to_m - segment.s_start_m - h.s1_m;
    const Cubic::Range z = axis.shifted(h.s0_m).range(h.s1_m - h.s0_m);
    h.piece.z0 = z.low - vault.p4;
    h.piece.z1 = z.high + vault.p1 + vault.p2;
    hollows.push_back(h);
  }
}

}  // namespace roadgen
