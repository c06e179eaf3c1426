#include "roadgen/road/sweep_piece.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

struct Interval {
  double low, high;
};

// The road's surface at offset t, above z = 0, over s from the segment's start: its height and slope at both ends.
Cubic surface_under(const Segment& segment, double t_m) {
  const auto at = [&](double s) { return surface_at(segment, s, t_m * std::cos(segment.superelevation_rad.value(s))); };
  const Lib::SurfaceSlope start = at(0), end = at(segment.arc_m);
  return Cubic::hermite(start.height, start.ahead, end.height, end.ahead, segment.arc_m);
}

// What one piece after the other is made of: a profile over [s_from, s_to] of the road.
struct Course {
  double s_from_m, s_to_m;
  Lib::SweepProfile profile{};
  Interval n{0, 0}, h{0, 0};       // the profile's extent from the axis
  Lib::SweepPosts posts{};         // first: s along the road of the post with index 0
  bool ends = true;                // not where another course goes on
  double height_m = 0;             // of the axis above the road
  std::optional<Cubic> axis = {};  // over s - s_from_m, above z = 0: instead of the road's height
};

Lib::SweepProfile profile(int kind, double p0, double p1 = 0, double p2 = 0, double p3 = 0, double p4 = 0,
                          double p5 = 0) {
  return {kind, p0, p1, p2, p3, p4, p5};
}

std::vector<Course> courses(const Road&, const Sweep& sweep, const Tunnel& x) {
  const double a = x.half_width_m, radius = (a * a + x.arch_rise_m * x.arch_rise_m) / (2 * x.arch_rise_m);
  const double crown = x.wall_height_m + x.arch_rise_m, centre = crown - radius;
  const double side = a + x.lining_m, top = crown + x.lining_m;
  const double wall = std::min(x.head_wall_m, 0.4 * (sweep.s_end_m - sweep.s_start_m));
  std::vector<Course> list = {
      {.s_from_m = sweep.s_start_m + wall,
       .s_to_m = sweep.s_end_m - wall,
       .profile = profile(SWEEP_LINING, a, centre, radius, x.lining_m, kSweepFoot_m, a - x.walkway_m),
       .n = {-side, side},
       .h = {-kSweepFoot_m, top},
       .ends = wall == 0}};
  if (wall == 0) return list;
  for (const double s : {sweep.s_start_m, sweep.s_end_m - wall}) {
    const double out = side + x.head_margin_m, high = top + x.head_margin_m;
    list.push_back({.s_from_m = s,
                    .s_to_m = s + wall,
                    .profile = profile(SWEEP_HEAD_WALL, a, centre, radius, out, kSweepFoot_m, high),
                    .n = {-out, out},
                    .h = {-kSweepFoot_m, high}});
  }
  return list;
}

std::vector<Course> courses(const Road&, const Sweep& sweep, const GuardRail& x) {
  // The ridges face the road.
  const double facing = sweep.t_m + 0.5 * sweep.t_slope * (sweep.s_end_m - sweep.s_start_m) < 0 ? 1 : -1;
  const double half = 0.5 * x.beam_height_m, sheet = 0.5 * x.sheet_m, axis = x.top_m - half;
  Course rail{.s_from_m = sweep.s_start_m,
              .s_to_m = sweep.s_end_m,
              .profile = profile(SWEEP_BEAM, half - sheet, x.beam_depth_m, sheet, facing),
              .n = {-x.beam_depth_m - sheet, x.beam_depth_m + sheet},
              .h = {-half, half},
              .height_m = axis};
  if (x.post_spacing_m > 0) {
    const double count = std::floor((sweep.s_end_m - sweep.s_start_m) / x.post_spacing_m) + 1;
    const double behind = -facing * (0.5 * x.post_across_m + sheet);
    rail.posts = {sweep.s_start_m,
                  x.post_spacing_m,
                  count,
                  0.5 * x.post_along_m,
                  0.5 * x.post_across_m,
                  behind,
                  -axis - kSweepFoot_m,
                  half - 0.1 * x.beam_height_m};
  }
  return {rail};
}

std::vector<Course> courses(const Road&, const Sweep& sweep, const Pipe& x) {
  return {{.s_from_m = sweep.s_start_m,
           .s_to_m = sweep.s_end_m,
           .profile = profile(SWEEP_TUBE, x.radius_m),
           .n = {-x.radius_m, x.radius_m},
           .h = {-x.radius_m, x.radius_m},
           .height_m = x.height_m}};
}

// Height of the surface under the sweep at s of the road.
double surface_height_m(const Road& road, const Sweep& sweep, double s_m) {
  const Segment& segment = road.segments[segment_at(road, s_m)];
  const double t = sweep.t_m + sweep.t_slope * (s_m - sweep.s_start_m);
  return surface_under(segment, t).value(std::clamp(s_m - segment.s_start_m, 0.0, segment.arc_m));
}

std::vector<Course> courses(const Road& road, const Sweep& sweep, const Cable& x) {
  std::vector<Course> list;
  const double length = sweep.s_end_m - sweep.s_start_m;
  const int spans = static_cast<int>(std::ceil(length / x.span_m - 1e-9));
  for (int i = 0; i < spans; ++i) {
    const double from = i * x.span_m, to = std::min(length, from + x.span_m), span = to - from;
    // Between the poles' tops, less a parabola.
    const double z0 = surface_height_m(road, sweep, sweep.s_start_m + from) + x.height_m;
    const double z1 = surface_height_m(road, sweep, sweep.s_start_m + to) + x.height_m;
    const double curve = 4 * x.sag_m / (x.span_m * x.span_m);
    Course course{.s_from_m = sweep.s_start_m + from,
                  .s_to_m = sweep.s_start_m + to,
                  .profile = profile(SWEEP_TUBE, x.radius_m),
                  .n = {-x.radius_m, x.radius_m},
                  .h = {-x.radius_m, x.radius_m},
                  .ends = false,
                  .axis = Cubic{z0, (z1 - z0) / span - curve * span, curve, 0}};
    if (x.pole_radius_m > 0) {
      const bool last = i + 1 == spans;
      course.posts = {course.s_from_m, span, last ? 2.0 : 1.0,           -x.pole_radius_m,
                      x.pole_radius_m, 0,    -x.height_m - kSweepFoot_m, x.pole_above_m};
    }
    list.push_back(course);
  }
  return list;
}

// Bounds of f and its derivatives on [u0, u1].
struct CurveBounds {
  Interval f, df, ddf;
  double dddf;
};

CurveBounds curve_bounds(const Segment& segment, double u0, double u1) {
  const double a = segment.slope_start, b = segment.slope_end;
  const auto around = [](double x, double y) { return Interval{std::min(x, y), std::max(x, y)}; };
  CurveBounds c{};
  c.ddf = around(Lib::road_ddf(u0, a, b), Lib::road_ddf(u1, a, b));  // linear in u
  c.dddf = 6 * std::abs(a + b);
  c.f = {1e300, -1e300}, c.df = c.f;
  constexpr int kSamples = 16;
  for (int i = 0; i <= kSamples; ++i) {
    const double u = u0 + (u1 - u0) * i / kSamples, f = Lib::road_f(u, a, b), df = Lib::road_df(u, a, b);
    c.f = {std::min(c.f.low, f), std::max(c.f.high, f)};
    c.df = {std::min(c.df.low, df), std::max(c.df.high, df)};
  }
  // Between two samples a function departs from its chord by at most the greatest second derivative times step^2 / 8.
  const double step = (u1 - u0) / kSamples;
  const double f_slack = std::max(-c.ddf.low, c.ddf.high) * step * step / 8, df_slack = c.dddf * step * step / 8;
  c.f = {c.f.low - std::abs(f_slack), c.f.high + std::abs(f_slack)};
  c.df = {c.df.low - df_slack, c.df.high + df_slack};
  return c;
}

double magnitude(const Interval& x) { return std::max(std::abs(x.low), std::abs(x.high)); }

// Least 1 - curvature n for n in [low, high] metres.
double least_stretch(const CurveBounds& c, double chord_m, const Interval& n) {
  double most = 0;
  for (const double k : {c.ddf.low, c.ddf.high}) most = std::max({most, k * n.low / chord_m, k * n.high / chord_m});
  return 1 - most;
}

// The part of a course on a segment; false where the segment bends too tightly.
bool make_piece(const Sweep& sweep, const Course& course, const Segment& segment, Interval s, SweepPart& part) {
  const double chord = segment.chord_length_m();
  Lib::SweepPiece& piece = part.piece;
  piece.profile = course.profile;
  piece.end0 = course.ends && segment.s_start_m + s.low <= course.s_from_m + 1e-6 ? 1 : 0;
  piece.end1 = course.ends && segment.s_start_m + s.high >= course.s_to_m - 1e-6 ? 1 : 0;
  piece.u0 = u_at_arc(segment, s.low), piece.u1 = u_at_arc(segment, s.high);
  const double t = sweep.t_m + sweep.t_slope * (segment.s_start_m - sweep.s_start_m), base = segment.elevation_m.c0;
  const Cubic axis =
      course.axis ? course.axis->shifted(segment.s_start_m - course.s_from_m) : surface_under(segment, t);
  piece.path = {chord,
                segment.slope_start,
                segment.slope_end,
                segment.arc_m,
                segment.arc_c0,
                segment.arc_c1,
                axis.c0 + course.height_m - base,
                axis.c1,
                axis.c2,
                axis.c3,
                t,
                sweep.t_slope,
                0,
                0,
                0};

  // The posts whose s lies on this piece; the last of the course also at its end.
  Interval n = course.n, h = course.h;
  const Lib::SweepPosts& posts = course.posts;
  if (posts.count > 0) {
    const bool last = segment.s_start_m + s.high >= course.s_to_m - 1e-6;
    const auto index = [&](double local) { return (segment.s_start_m + local - posts.first) / posts.spacing; };
    const double begin = std::max(0.0, std::ceil(index(s.low) - 1e-9));
    const double end =
        std::min(posts.count, last ? std::floor(index(s.high) + 1e-6) + 1 : std::ceil(index(s.high) - 1e-9));
    if (end > begin) {
      piece.posts = posts;
      piece.posts.first = posts.first + begin * posts.spacing - segment.s_start_m;
      piece.posts.count = end - begin;
      n = {std::min(n.low, posts.n - posts.half_n), std::max(n.high, posts.n + posts.half_n)};
      h = {std::min(h.low, posts.low), std::max(h.high, posts.high)};
    }
  }
  const double pad = piece.posts.count > 0 ? std::max(posts.half_s, posts.half_n) : 0;

  // The box: across the chord by the curve and the offsets from it, upward by the axis.
  const CurveBounds c = curve_bounds(segment, piece.u0, piece.u1);
  const double t0 = t + sweep.t_slope * s.low, t1 = t + sweep.t_slope * s.high;
  n = {n.low + std::min(t0, t1), n.high + std::max(t0, t1)};
  const double steep = magnitude(c.df), lean = 1 / std::sqrt(1 + steep * steep);
  piece.y0 = chord * c.f.low + n.low * (n.low < 0 ? 1 : lean) - pad * steep;
  piece.y1 = chord * c.f.high + n.high * (n.high > 0 ? 1 : lean) + pad * steep;
  const double span = s.high - s.low;
  const Cubic here = axis.shifted(s.low);
  const Cubic::Range height = here.range(span);
  const double grade = std::max({std::abs(here.slope(0)), std::abs(here.slope(span)),
                                 here.c3 != 0 && -here.c2 / (3 * here.c3) > 0 && -here.c2 / (3 * here.c3) < span
                                     ? std::abs(here.slope(-here.c2 / (3 * here.c3)))
                                     : 0.0});
  piece.z0 = height.low + course.height_m - base + h.low - grade * pad;
  piece.z1 = height.high + course.height_m - base + h.high + grade * pad;

  // How far a ray's n, h and s can be from straight within the box: see SweepPath. With K the curvature, q the stretch
  // and a ray of horizontal speed 1: n'' = -K (T d)^2 / q, s'' = (2 K (N d) s' + K' n s'^2) / q, and z(s) by the chain
  // rule.
  const Interval across{piece.y0 - chord * c.f.high, piece.y1 - chord * c.f.low};
  part.least_stretch = least_stretch(c, chord, across);
  if (!std::isfinite(mapping_bound(segment.slope_start, segment.slope_end, magnitude(n) / chord).v) ||
      !(least_stretch(c, chord, n) >= kLeastStretch) || !(part.least_stretch >= 0.5 * kLeastStretch)) {
    return false;
  }
  const double q = part.least_stretch, curvature = magnitude(c.ddf) / chord;
  const double turn = (c.dddf + 3 * steep * magnitude(c.ddf) * magnitude(c.ddf)) / (chord * chord);
  const double second = std::max(std::abs(here.second(0)), std::abs(here.second(span)));
  const double bend_s = curvature / (q * q) + turn * magnitude(across) / (q * q * q);
  piece.path.bend_s = kBendMargin * bend_s;
  piece.path.bend_n = kBendMargin * (curvature / q + std::abs(sweep.t_slope) * bend_s);
  piece.path.bend_h = kBendMargin * (second / (q * q) + grade * bend_s);
  part.steepest = std::hypot(grade, sweep.t_slope);
  return true;
}

glm::dvec3 material(SweepKind kind) {
  switch (kind) {
    case SweepKind::kTunnel: return {0.29, 0.28, 0.265};
    case SweepKind::kGuardRail: return {0.42, 0.44, 0.46};
    case SweepKind::kPipe: return {0.30, 0.31, 0.32};
    case SweepKind::kCable: return {0.05, 0.05, 0.055};
  }
  return {0.5, 0.5, 0.5};
}

// Every part of a sweep with good numbers; `tight` takes the s of those that cannot be.
std::vector<SweepPart> all_parts(const Road& road, const Sweep& whole, std::vector<double>& tight) {
  Sweep sweep = whole;
  sweep.s_start_m = std::max(0.0, whole.s_start_m);
  sweep.s_end_m = std::min(road.length_m(), whole.s_end_m);
  sweep.t_m += whole.t_slope * (sweep.s_start_m - whole.s_start_m);
  std::vector<SweepPart> parts;
  if (!(sweep.s_end_m > sweep.s_start_m)) return parts;
  const auto list = std::visit([&](const auto& shape) { return courses(road, sweep, shape); }, sweep.shape);
  for (const Course& course : list) {
    for (std::size_t i = segment_at(road, std::max(0.0, course.s_from_m)); i < road.segments.size(); ++i) {
      const Segment& segment = road.segments[i];
      if (segment.s_start_m >= course.s_to_m) break;
      const Interval s{std::max(0.0, course.s_from_m - segment.s_start_m),
                       std::min(segment.arc_m, course.s_to_m - segment.s_start_m)};
      constexpr double kLeast_m = 1e-6;
      if (!(s.high - s.low > kLeast_m)) continue;
      SweepPart part;
      part.segment = i;
      part.s_from_m = segment.s_start_m - sweep.s_start_m;
      part.s_left_m = sweep.s_end_m - segment.s_start_m;
      part.albedo = sweep.albedo.value_or(material(sweep.kind()));
      if (const auto* tunnel = std::get_if<Tunnel>(&sweep.shape)) part.lamp_spacing_m = tunnel->lamp_spacing_m;
      if (make_piece(sweep, course, segment, s, part)) {
        parts.push_back(part);
      } else if (tight.empty() || tight.back() < segment.s_start_m + s.low) {
        tight.push_back(segment.s_start_m + s.low);
      }
    }
  }
  return parts;
}

}  // namespace

std::vector<SweepPart> sweep_parts(const Road& road, std::size_t sweep) {
  std::vector<double> tight;
  if (!bad_numbers(road, road.sweeps[sweep]).empty()) return {};
  std::vector<SweepPart> parts = all_parts(road, road.sweeps[sweep], tight);
  for (SweepPart& part : parts) part.sweep = sweep;
  return parts;
}

std::vector<double> tight_places(const Road& road, const Sweep& sweep) {
  std::vector<double> tight;
  all_parts(road, sweep, tight);
  return tight;
}

double lipschitz(const SweepPart& part) {
  const double m = part.steepest;
  return std::max(1.0, 1 / part.least_stretch) * (0.5 * m + std::sqrt(1 + 0.25 * m * m));
}

std::optional<SweepMeeting> cast(const Road& road, const SweepPart& part, glm::dvec3 origin_m, glm::dvec3 direction,
                                 double pixel, double from_m) {
  const Segment& segment = road.segments[part.segment];
  const glm::dvec2 axis = glm::normalize(segment.chord_m());
  const auto turned = [&](glm::dvec3 v) {
    return glm::dvec3(axis.x * v.x + axis.y * v.y, axis.x * v.y - axis.y * v.x, v.z);
  };
  const glm::dvec3 o = turned(origin_m - glm::dvec3(segment.start_m, segment.elevation_m.c0)), d = turned(direction);
  const Lib::SweepCast found = Lib::sweep_cast(o.x, o.y, o.z, d.x, d.y, d.z, from_m, 0.0, pixel, part.piece);
  const bool post = found.posts.met > 0.5 && !(found.body.met > 0.5 && found.body.k <= found.posts.k);
  if (!post && found.body.met < 0.5) return std::nullopt;
  const double k = post ? found.posts.k : found.body.k;
  const Lib::SweepPoint p =
      Lib::sweep_locate(o.x + k * d.x, o.y + k * d.y, o.z + k * d.z, d.x, d.y, d.z, part.piece.path);
  const glm::dvec3 n = post ? Lib::sweep_post_normal(p, part.piece.path, part.piece.posts)
                            : Lib::sweep_normal(p, part.piece.path, part.piece.profile);
  return SweepMeeting{k, {axis.x * n.x - axis.y * n.y, axis.y * n.x + axis.x * n.y, n.z}, post};
}

}  // namespace roadgen
