#include "tests/gl/reference.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <thread>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One strip of a segment's cross section; strips and borders from right to left.
struct Strip {
  Material material;
  double right_m, left_m;  // heights of its sides
  bool driving;

  bool is_level(double height_m) const { return right_m == height_m && left_m == height_m; }
};

struct SegmentTruth {
  const Segment* segment;
  const Road* road;
  double seed;         // index of the road
  double section_s_m;  // s at the start from the section's start
  Lib::RoadSurface surface;
  std::vector<Cubic> borders;
  std::vector<const Mark*> marks;  // one per border
  std::vector<Strip> strips;       // one less
  double highest_m = 0;            // of the strips
  Bounds box;
  double y_low, y_high;

  SegmentTruth(const Road& r, const Segment& s, std::size_t index)
      : segment(&s),
        road(&r),
        seed(static_cast<double>(index)),
        section_s_m(section_offset_m(r, s)),
        surface(roadgen::surface(s)),
        box(bounds(s)) {
    const LaneSection& section = r.sections[s.section];
    borders = section.borders_m();
    for (auto lane = section.right.rbegin(); lane != section.right.rend(); ++lane) add(*lane, lane->mark);
    marks.push_back(&section.center_mark);
    for (const Lane& lane : section.left) add_left(lane);
    const Quad quad = fitted_quad(s);
    y_low = quad.y_low, y_high = quad.y_high;
    box.high_m.z += highest_m;
  }

 private:
  void add_strip(const Lane& lane, bool on_right) {
    const bool driving = lane.type == LaneType::kDriving || lane.type == LaneType::kBidirectional ||
                         lane.type == LaneType::kBus || lane.type == LaneType::kTaxi || lane.type == LaneType::kHov;
    const double inner = lane.inner_height_m, outer = lane.outer_height_m;
    strips.push_back({lane.material, on_right ? outer : inner, on_right ? inner : outer, driving});
    highest_m = std::max({highest_m, inner, outer});
  }
  void add(const Lane& lane, const Mark& mark) { marks.push_back(&mark), add_strip(lane, true); }
  void add_left(const Lane& lane) { add_strip(lane, false), marks.push_back(&lane.mark); }
};

// Where a point on the ray stands: beside the road or among its lanes, above them, between them and the road surface,
// or below both.
enum class State { kBesideAbove, kBesideBelow, kAbove, kInside, kBelow };

struct Place {
  double k = 0;  // along the ray
  double u = 0, s = 0, n = 0, t = 0;
  double above = 0;  // the road surface, m
  int strip = -1;
  double lane_height = 0, lane_slope = 0;  // and its change with t
  State state = State::kBesideAbove;

  // Between two that are not there is something to look at: a surface, or a strip's edge, whose corner a ray may clip.
  bool is_like(const Place& o) const { return state == o.state && strip == o.strip; }
};

struct Hit {
  double k = kInfinity;
  const SegmentTruth* on = nullptr;
  double s = 0, t = 0;
  int strip = -1;
  glm::dvec3 normal{0, 0, 1};
  glm::dvec3 ahead{1, 0, 0}, left{0, 1, 0};  // unit, horizontal
  double bend = 1;                           // metres of the plane per metre of s, at this n
  double cosine = 1;
  enum class Kind { kStrip, kFace, kUnderside } kind = Kind::kStrip;
};

// A ray over one segment.
class Walk {
 public:
  Walk(const SegmentTruth& on, glm::dvec3 eye, glm::dvec3 ray, double& u_guess)
      : on_(on), eye_(eye), ray_(ray), u_(u_guess) {
    from_ = to_chord(*on.segment, glm::dvec2(eye));
    along_ = to_chord(*on.segment, glm::dvec2(eye) + glm::dvec2(ray)) - from_;
  }

  // The first hit in [near, far].
  std::optional<Hit> first(double near, double far) {
    if (!clip(near, far)) return std::nullopt;
    const double length = glm::length(glm::dvec2(ray_)) * (far - near);
    const int steps = std::clamp(static_cast<int>(std::ceil(length / kStep_m)), 1, 2000);
    const double step_m = length / steps, margin = kGreatestCurvature * step_m * step_m + 1e-6;
    Place before = at(near);
    for (int i = 1; i <= steps; ++i) {
      const Place after = at(near + (far - near) * i / steps);
      const bool clear =
          std::min(before.above, after.above) > on_.highest_m + margin || std::max(before.above, after.above) < -margin;
      if (!clear) {
        if (auto hit = within(before, after)) return hit;
      }
      before = after;
    }
    return std::nullopt;
  }

 private:
  static constexpr double kStep_m = 2;
  static constexpr double kGreatestCurvature = 0.03;  // 1/8 of the surface's greatest along any line, with room
  static constexpr double kFine_m = 0.25;             // finer steps near the surface
  static constexpr double kFineAcross_m = 0.1;        // and across, where lanes are raised: below any strip's width

  // The part of the ray over the segment: all bounds are planes.
  bool clip(double& near, double& far) const {
    const auto keep = [&](double value, double slope) {  // where value + k slope >= 0
      if (std::abs(slope) < 1e-15) return value >= 0;
      const double k = -value / slope;
      slope > 0 ? near = std::max(near, k) : far = std::min(far, k);
      return near < far;
    };
    const double a = on_.segment->slope_start, b = on_.segment->slope_end, hair = 1e-9;
    return keep(from_.x + a * from_.y + hair, along_.x + a * along_.y) &&
           keep(1 - from_.x - b * from_.y + hair, -along_.x - b * along_.y) &&
           keep(from_.y - on_.y_low + hair, along_.y) && keep(on_.y_high + hair - from_.y, -along_.y) &&
           keep(eye_.z - on_.box.low_m.z + 1e-4, ray_.z) && keep(on_.box.high_m.z + 1e-4 - eye_.z, -ray_.z);
  }

  // The exact projection: Newton from the place before, or where that fails the search that needs no start.
  double project(double x, double y) {
    const double a = on_.segment->slope_start, b = on_.segment->slope_end;
    double u = u_;
    for (int i = 0; i < 12; ++i) {
      const double d = y - Lib::road_f(u, a, b), df = Lib::road_df(u, a, b);
      const double slope = d * Lib::road_ddf(u, a, b) - df * df - 1;
      if (!(slope < -0.05)) break;
      const double step = (x - u + d * df) / slope;
      u -= step;
      if (std::abs(step) < 1e-13) return u_ = std::clamp(u, 0.0, 1.0);
      if (!(u > -0.5 && u < 1.5)) break;
    }
    return u_ = nearest(*on_.segment, from_chord(*on_.segment, {x, y})).u;
  }

  Place at(double k) {
    const Segment& segment = *on_.segment;
    Place p;
    p.k = k;
    const double x = from_.x + k * along_.x, y = from_.y + k * along_.y;
    p.u = project(x, y);
    p.s = Lib::surface_arc(p.u, on_.surface);
    p.n = Lib::road_v(p.u, x, y, segment.slope_start, segment.slope_end) * on_.surface.chord;
    const Lib::SurfaceSlope slope = Lib::surface_at(p.s, p.n, on_.surface);
    p.t = p.n / slope.cosine;
    p.above = eye_.z + k * ray_.z - segment.elevation_m.c0 - slope.height;
    const double ds = on_.section_s_m + p.s;
    int border = 0;
    while (border < static_cast<int>(on_.borders.size()) && p.t >= on_.borders[border].value(ds)) ++border;
    if (border > 0 && border < static_cast<int>(on_.borders.size())) {
      p.strip = border - 1;
      const Strip& strip = on_.strips[p.strip];
      const double right = on_.borders[p.strip].value(ds), width = on_.borders[border].value(ds) - right;
      p.lane_slope = strip.right_m == strip.left_m ? 0 : (strip.left_m - strip.right_m) / width;
      p.lane_height = strip.right_m + p.lane_slope * (p.t - right);
      p.state = p.above >= p.lane_height ? State::kAbove : (p.above >= 0 ? State::kInside : State::kBelow);
    } else {
      p.state = p.above >= 0 ? State::kBesideAbove : State::kBesideBelow;
    }
    return p;
  }

  std::optional<Hit> within(const Place& start, const Place& end) {
    const double length = glm::length(glm::dvec2(ray_)) * (end.k - start.k);
    int steps = static_cast<int>(std::ceil(length / kFine_m));
    if (on_.highest_m > 0) steps = std::max(steps, static_cast<int>(std::abs(end.n - start.n) / kFineAcross_m));
    steps = std::clamp(steps, 1, 1000);
    Place before = start;
    for (int i = 1; i <= steps; ++i) {
      const Place after = i == steps ? end : at(start.k + (end.k - start.k) * i / steps);
      while (!before.is_like(after)) {
        Place low = before, high = after;
        for (int j = 0; j < 48 && high.k - low.k > 1e-12 * high.k; ++j) {
          const Place middle = at(0.5 * (low.k + high.k));
          (middle.is_like(before) ? low : high) = middle;
        }
        if (auto hit = crossing(low, high)) return hit;
        before = high;
      }
      before = after;
    }
    return std::nullopt;
  }

  // What lies between two places that are next to each other but not alike.
  std::optional<Hit> crossing(const Place& low, const Place& high) const {
    const bool enters = high.state == State::kInside || (low.state == State::kAbove && high.state == State::kBelow);
    const bool rises = low.state == State::kBelow && (high.state == State::kAbove || high.state == State::kInside);
    if (rises) return hit(low, Hit::Kind::kUnderside);
    if (!enters || low.state == State::kBesideBelow) return std::nullopt;
    const double jump = low.state == State::kBesideAbove ? kInfinity : high.lane_height - low.lane_height;
    return jump > 1e-7 ? hit(high, Hit::Kind::kFace) : hit(low, Hit::Kind::kStrip);
  }

  Hit hit(const Place& p, Hit::Kind kind) const {
    const Segment& segment = *on_.segment;
    Hit h;
    h.k = p.k, h.on = &on_, h.s = p.s, h.t = p.t, h.strip = p.strip, h.kind = kind;
    const double heading = heading_rad(segment, p.u);
    h.ahead = {std::cos(heading), std::sin(heading), 0};
    h.left = {-h.ahead.y, h.ahead.x, 0};
    h.bend = 1 - p.n * curvature_per_m(segment, p.u);
    const Lib::SurfaceSlope slope = Lib::surface_at(p.s, p.n, on_.surface);
    h.cosine = slope.cosine;
    h.normal = glm::normalize(-slope.ahead / h.bend * h.ahead - slope.aside * h.left + glm::dvec3(0, 0, 1));
    if (kind == Hit::Kind::kStrip) {
      h.normal = glm::normalize(h.normal / h.normal.z - p.lane_slope / slope.cosine * h.left);
    }
    if (kind == Hit::Kind::kUnderside) h.normal = -h.normal;
    if (kind == Hit::Kind::kFace) h.normal = glm::dot(h.left, ray_) > 0 ? -h.left : h.left;
    return h;
  }

  const SegmentTruth& on_;
  glm::dvec3 eye_, ray_;
  glm::dvec2 from_, along_;
  double& u_;
};

bool on_dash(double s, const Mark& mark) {
  const double period = std::max(mark.on_m + mark.off_m, 1e-3);
  const double gone = s + mark.phase_m;
  return gone - std::floor(gone / period) * period < mark.on_m;
}

bool on_mark(const Mark& mark, double from_border, double s) {
  if (mark.kind == MarkKind::kNone) return false;
  if (mark.kind == MarkKind::kSolid || mark.kind == MarkKind::kBroken) {
    return std::abs(from_border) < 0.5 * mark.width_m && (mark.kind == MarkKind::kSolid || on_dash(s, mark));
  }
  const double across = std::abs(from_border) - 0.5 * mark.space_m;
  if (across < 0 || across > mark.width_m) return false;
  const bool right = from_border < 0;
  const bool broken = mark.kind == MarkKind::kBrokenBroken || (mark.kind == MarkKind::kBrokenSolid && right) ||
                      (mark.kind == MarkKind::kSolidBroken && !right);
  return !broken || on_dash(s, mark);
}

bool on_paint(const Paint& paint, double s, double t) {
  const double ds = s - paint.s_m, dt = t - paint.t_m;
  if (std::abs(ds) > 0.5 * paint.length_m || std::abs(dt) > 0.5 * paint.width_m) return false;
  switch (paint.kind) {
    case PaintKind::kLine: return true;
    case PaintKind::kZebra: {
      const double x = (dt + 0.5 * paint.stripe_m) / (2 * paint.stripe_m);
      return x - std::floor(x) < 0.5;
    }
    default: break;
  }
  const double way = paint.against ? -1 : 1;
  const bool left = paint.kind == PaintKind::kArrowLeft || paint.kind == PaintKind::kArrowStraightLeft;
  const bool right = paint.kind == PaintKind::kArrowRight || paint.kind == PaintKind::kArrowStraightRight;
  const bool both = paint.kind == PaintKind::kArrowStraightLeft || paint.kind == PaintKind::kArrowStraightRight;
  return Lib::marking_arrow(way * ds, way * dt, paint.length_m, paint.width_m, left ? 1.0 : (right ? -1.0 : 0.0),
                            both) < 0;
}

class Painter {
 public:
  Painter(const Network& network, const Camera& camera, const ReferenceOptions& options)
      : camera_(camera), options_(options), axes_(view_axes(camera)) {
    for (std::size_t i = 0; i < network.roads.size(); ++i) {
      for (const Segment& segment : network.roads[i].segments) truths_.emplace_back(network.roads[i], segment, i);
    }
    pixel_ = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / options.height;
    const double azimuth = options.lighting.sun_azimuth_deg * std::numbers::pi / 180;
    const double elevation = options.lighting.sun_elevation_deg * std::numbers::pi / 180;
    sun_ = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)};
  }

  ReferencePixel pixel(int x, int y) {
    const std::vector<const SegmentTruth*> candidates = candidates_of(x, y);
    const ReferencePixel coarse = pixel(x, y, candidates, options_.grid);
    return coarse.mixed ? pixel(x, y, candidates, options_.edge_grid) : coarse;
  }

 private:
  static constexpr double kFar_m = 1e5;

  ReferencePixel pixel(int x, int y, const std::vector<const SegmentTruth*>& candidates, int grid) const {
    ReferencePixel pixel;
    pixel.traced = true;
    std::vector<double> guesses(candidates.size(), 0.5);
    std::optional<glm::dvec3> first;
    const int samples = grid * grid;
    for (int i = 0; i < samples; ++i) {
      // A golden lattice: no two samples share a row or column, so edges along the picture's axes come out as exact as
      // others. A square grid would have them in steps of 1 / grid.
      const double across = std::numbers::phi * i - std::floor(std::numbers::phi * i), down = (i + 0.5) / samples;
      const glm::dvec3 ray = pixel_ray(camera_, options_.width, options_.height, x - 0.5 + across, y - 0.5 + down);
      std::optional<Hit> hit;
      for (std::size_t j = 0; j < candidates.size(); ++j) {
        Walk walk(*candidates[j], camera_.position_m, ray, guesses[j]);
        if (auto found = walk.first(camera_.near_m, hit ? hit->k : kFar_m)) hit = found;
      }
      glm::dvec3 flat = kFlatBackground;
      pixel.color += hit ? shade(*hit, ray, flat) : sky(ray);
      pixel.background += hit ? 0 : 1;
      pixel.flat += flat;
      if (!first) first = flat;
      pixel.mixed = pixel.mixed || flat != *first;
    }
    const double part = 1.0 / samples;
    pixel.color *= part, pixel.flat *= part, pixel.background *= part;
    return pixel;
  }

  // The segments whose box the pixel's rays may meet.
  std::vector<const SegmentTruth*> candidates_of(int x, int y) const {
    const glm::dvec3 ray = pixel_ray(camera_, options_.width, options_.height, x, y);
    std::vector<const SegmentTruth*> found;
    for (const SegmentTruth& truth : truths_) {
      const glm::dvec3 low = truth.box.low_m - camera_.position_m, high = truth.box.high_m - camera_.position_m;
      const double reach = glm::length(glm::max(glm::abs(low), glm::abs(high)));
      const double room = pixel_ * reach + 0.01;
      double near = 0, far = kFar_m;
      for (int axis = 0; axis < 3; ++axis) {
        const double d = std::abs(ray[axis]) < 1e-12 ? 1e-12 : ray[axis];
        const double k0 = (low[axis] - room) / d, k1 = (high[axis] + room) / d;
        near = std::max(near, std::min(k0, k1)), far = std::min(far, std::max(k0, k1));
      }
      if (near <= far) found.push_back(&truth);
    }
    return found;
  }

  glm::dvec3 tone(glm::dvec3 light) const {
    return {Lib::sky_tone(light.x), Lib::sky_tone(light.y), Lib::sky_tone(light.z)};
  }

  // shaders/sky.frag; the clouds are smoothed as the picture's are, by the size of the pixel.
  glm::dvec3 sky(glm::dvec3 ray) const {
    const glm::dvec3 d = glm::normalize(ray);
    const double toward = glm::dot(d, sun_);
    glm::dvec3 color = Lib::sky_gradient(d.z, toward);
    if (d.z > 0.02) {
      const double x = d.x / d.z * 6000, y = d.y / d.z * 6000;
      const double footprint = pixel_ * 6000 / (d.z * d.z);
      const double shape = Lib::noise_fractal(x * 0.06, y * 0.11, 512.0, 5, 0.55, footprint * 0.1);
      const double cover = glsl::smoothstep(0.15, 1.1, shape) * glsl::smoothstep(0.02, 0.22, d.z) * 0.75;
      color = glm::mix(color, glm::dvec3(1, 0.98, 0.96) * (0.85 + 0.4 * std::max(toward, 0.0)), cover);
    }
    return tone(color + glm::dvec3(12, 11, 9) * Lib::sky_sun_disc(toward));
  }

  // How the hit point moves in the plane of its surface when the ray moves by one sample along an axis of the view.
  glm::dvec3 step(const Hit& hit, glm::dvec3 ray, glm::dvec3 axis) const {
    const glm::dvec3 turn = axis * (pixel_ / options_.grid);
    return hit.k * (turn - ray * (glm::dot(hit.normal, turn) / glm::dot(hit.normal, ray)));
  }

  // shaders/frame.glsl: frame_light, frame_shade.
  glm::dvec3 lit(glm::dvec3 albedo, glm::dvec3 normal, glm::dvec3 position) const {
    const glm::dvec3 light = Lib::sky_sun_color() * std::max(glm::dot(normal, sun_), 0.0) + Lib::sky_ambient(normal.z);
    const double distance = glm::length(position);
    const glm::dvec3 direction = position / distance;
    const double clear = Lib::sky_transmittance(distance, options_.lighting.haze_range_m);
    const glm::dvec3 air = Lib::sky_gradient(std::max(direction.z, 0.0) * 0.5, glm::dot(direction, sun_));
    return tone(glm::mix(air, albedo * light, clear));
  }

  std::optional<PaintColor> paint_at(const Hit& hit) const {
    const SegmentTruth& on = *hit.on;
    std::optional<PaintColor> color;
    const double ds = on.section_s_m + hit.s;
    for (const int border : {hit.strip, hit.strip + 1}) {
      const Mark& mark = *on.marks[static_cast<std::size_t>(border)];
      if (on_mark(mark, hit.t - on.borders[static_cast<std::size_t>(border)].value(ds), ds)) color = mark.color;
    }
    if (!on.strips[static_cast<std::size_t>(hit.strip)].is_level(0)) return color;
    for (const Paint& paint : on.road->paint) {
      if (on_paint(paint, on.segment->s_start_m + hit.s, hit.t)) color = paint.color;
    }
    return color;
  }

  glm::dvec3 shade(const Hit& hit, glm::dvec3 ray, glm::dvec3& flat) const {
    const SegmentTruth& on = *hit.on;
    const glm::dvec3 position = hit.k * ray;
    if (hit.kind == Hit::Kind::kStrip) {
      if (const auto paint = paint_at(hit)) {
        flat = kFlatPaint;
        return lit(Lib::marking_color(static_cast<int>(*paint)), hit.normal, position);
      }
    }
    const Strip& strip = on.strips[static_cast<std::size_t>(hit.strip)];
    Material material = strip.material;
    if (hit.kind == Hit::Kind::kFace) material = Material::kCurbstone;
    if (hit.kind == Hit::Kind::kUnderside) material = Material::kConcrete;
    flat = flat_color(material);
    double wheel = 0;
    if (hit.kind == Hit::Kind::kStrip && strip.driving) {
      const double ds = on.section_s_m + hit.s;
      const auto i = static_cast<std::size_t>(hit.strip);
      const double from_middle = hit.t - 0.5 * (on.borders[i].value(ds) + on.borders[i + 1].value(ds));
      const double from_track = std::abs(from_middle) - 0.8;
      wheel = std::exp(-from_track * from_track * 6);
    }
    const glm::dvec3 across = step(hit, ray, axes_.right), up = step(hit, ray, axes_.up);
    const double width_s = (std::abs(glm::dot(across, hit.ahead)) + std::abs(glm::dot(up, hit.ahead))) / hit.bend;
    const double width_t = (std::abs(glm::dot(across, hit.left)) + std::abs(glm::dot(up, hit.left))) / hit.cosine;
    const double s = on.segment->s_start_m + hit.s;
    return lit(Lib::material_albedo(static_cast<int>(material), s, hit.t, wheel, on.seed, width_s, width_t), hit.normal,
               position);
  }

  Camera camera_;
  const ReferenceOptions& options_;
  ViewAxes axes_;
  std::vector<SegmentTruth> truths_;
  double pixel_;  // size at distance 1
  glm::dvec3 sun_;
};

}  // namespace

glm::dvec3 flat_color(Material material) {
  constexpr std::array<glm::dvec3, 6> kColors = {{{1, 0, 0}, {0, 1, 1}, {0, 1, 0}, {1, 1, 0}, {1, 0, 1}, {0, 0, 1}}};
  return kColors[static_cast<std::size_t>(material)];
}

std::vector<ReferencePixel> reference_picture(const Network& network, const Camera& camera,
                                              const ReferenceOptions& options) {
  Painter painter(network, camera, options);
  std::vector<ReferencePixel> pixels(static_cast<std::size_t>(options.width) *
                                     static_cast<std::size_t>(options.height));
  std::atomic<int> next_row = 0;
  const auto work = [&] {
    for (int y = next_row++; y < options.height; y = next_row++) {
      for (int x = 0; x < options.width; ++x) {
        if (options.wanted(x, y)) {
          pixels[static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width) + static_cast<std::size_t>(x)] =
              painter.pixel(x, y);
        }
      }
    }
  };
  std::thread other(work);
  work();
  other.join();
  return pixels;
}

double distance_from_lanes(const Network& network, glm::dvec3 point_m) {
  double least = kInfinity;
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      const glm::dvec2 p = to_chord(segment, glm::dvec2(point_m));
      const double hair = 1e-2 / segment.chord_length_m();
      if (p.x + segment.slope_start * p.y < -hair || 1 - p.x - segment.slope_end * p.y < -hair) continue;
      const double u = nearest(segment, glm::dvec2(point_m)).u, s = arc_at(segment, u);
      const double n = Lib::road_v(u, p.x, p.y, segment.slope_start, segment.slope_end) * segment.chord_length_m();
      const Lib::SurfaceSlope slope = surface_at(segment, s, n);
      const double above = point_m.z - slope.height, t = n / slope.cosine;
      const LaneSection& section = road.sections[segment.section];
      const double ds = section_offset_m(road, segment) + s;
      constexpr double kBeside_m = 0.01;
      for (const Cubic& border : section.borders_m()) {
        // From the border's both sides: a face may stand between their heights.
        const double at = border.value(ds), right = lane_height_m(section, ds, at - 1e-6);
        const double left = lane_height_m(section, ds, at + 1e-6);
        const double over = std::max(std::min(right, left) - above, above - std::max(right, left));
        if (right != left) least = std::min(least, std::max(std::abs(t - at), over));
      }
      if (t < section.borders_m().front().value(ds) - kBeside_m) continue;
      if (t > section.borders_m().back().value(ds) + kBeside_m) continue;
      least = std::min(least, std::abs(above - lane_height_m(section, ds, t)));
    }
  }
  return least;
}

std::uint8_t srgb_from_linear(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double encoded = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * encoded));
}

double linear_from_srgb(std::uint8_t srgb) {
  const double x = srgb / 255.0;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

}  // namespace roadgen::test
