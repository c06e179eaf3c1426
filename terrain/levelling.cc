#include "terrain/levelling.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/road/link.h"
#include "terrain/over_roads.h"

namespace roadgen {
namespace {

constexpr double kSampleStep_m = 5;       // of the road samples that are blended
constexpr double kTunnelSides_m = 30;     // how far beside a tunnel the hill over it is kept
constexpr double kRounding_m = 3;         // of the profile where it leaves the shoulder
constexpr double kBlendWidth_m = 1.5;     // from the nearest road's own height to the blended one
constexpr double kNearestWeight_m = 0.5;  // nearer than this all samples weigh the same
constexpr double kLeastHill = 5;          // length of a hill over a tunnel, in shoulders: two are cut off it
constexpr double kPerpendicular = 1e-7;   // of L: what counts as a perpendicular foot
constexpr double kOtherLeg_m = 1;         // between the feet of two legs of road; less between those of one at a joint
constexpr double kDitchBelow_m = 8;       // bridges and tunnels farther above or below do not end a ditch

// How far the ground may rise or fall at distance d outside the shoulder: parabola, then slope, then without limit.
double allowance_m(double d, double slope, double reach_m) {
  const double q = d / reach_m;
  return slope * d * d / (d + kRounding_m) / (1 - q * q);
}

double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// From a level to the ground that is there without it: that ground where it is within the allowance, else the allowance,
// with a rounded crest and toe: q / (1 + q^4)^(1/4) is q for small q and goes to 1.
double approach_m(double level_m, double ground_m, double allowance_m) {
  const double q = (ground_m - level_m) / allowance_m, q2 = q * q;
  return level_m + (q2 > 1e12 ? std::copysign(allowance_m, q) : allowance_m * q / std::sqrt(std::sqrt(1 + q2 * q2)));
}

// The ditch's depth at distance d outside the shoulder, where it is `deepest` at its bottom.
double ditch_m(double d, double deepest, const LevellingOptions& o) {
  const double down = d * o.ditch_inner_slope, bottom_end = deepest / o.ditch_inner_slope + o.ditch_bottom_m;
  return std::max(std::min({down, deepest, deepest - (d - bottom_end) * o.ditch_outer_slope}), 0.0);
}

// How a part of a segment lies to a point.
struct Passing {
  bool is_beside;     // not beyond an end of the part
  double beyond_m;    // beyond an end, along the road; negative before its start
  double beside_m;    // from the carriageway's edge, across the road; 0 on it
  double z_m;         // of the surface at the nearest place on it, carried on with its grade over at most a shoulder
  glm::dvec2 foot_m;  // on the reference line
  bool at_start;      // the nearest place is the part's start
  double edge_m() const { return is_beside ? beside_m : std::hypot(beyond_m, beside_m); }
};

Passing passing(const SupportedPart& part, const Segment& segment, glm::dvec2 point_m, double shoulder_m) {
  const double a = segment.slope_start, b = segment.slope_end;
  const glm::dvec2 p = to_chord(segment, point_m);
  const double u = std::clamp(nearest(segment, point_m).u, part.u0, part.u1);
  const double df = Lib::road_df(u, a, b), dx = p.x - u, dy = p.y - Lib::road_f(u, a, b);
  const double along = dx + dy * df;
  const double local = arc_at(segment, u);
  const double scale = segment.chord_length_m() / std::sqrt(1 + df * df);
  const double cosine = std::cos(segment.superelevation_rad.value(local));
  const double left = segment.left_m.value(local) * cosine, right = segment.right_m.value(local) * cosine;
  const double n = (dy - dx * df) * scale;
  // Beside the carriageway the ground goes on level from its edge; beyond it with its grade over the shoulder, else the
  // last triangles under the road would bend.
  const Lib::SurfaceSlope surface = surface_at(segment, local, std::clamp(n, right, left));
  Passing at{.is_beside = std::abs(along) <= kPerpendicular,
             .beyond_m = along * scale,
             .beside_m = std::max({n - left, right - n, 0.0}),
             .z_m = surface.height,
             .foot_m = position_m(segment, u),
             .at_start = u <= part.u0};
  if (!at.is_beside) at.z_m += surface.ahead * std::clamp(along * scale, -shoulder_m, shoulder_m);
  return at;
}

// Distance from the carriageway where the part really passes the point, so that the foot is perpendicular or at its
// end; negative where it does not (then a neighbour is nearer).
double passing_edge_m(const SupportedPart& part, const Passing& at) {
  if (!at.is_beside && !(at.at_start ? part.starts_here : part.ends_here)) return -1;
  return at.edge_m();
}

// At least this far is the point from the segment's carriageway: from the chord, less what the curve bulges by.
double least_edge_m(const Segment& segment, glm::dvec2 point_m) {
  constexpr double kBulge = 4.0 / 27;  // max of x (1 - x)^2
  const glm::dvec2 p = to_chord(segment, point_m);
  const double bulge = kBulge * (std::abs(segment.slope_start) + std::abs(segment.slope_end));
  const double beside = std::max(std::abs(p.y) - bulge, 0.0), beyond = std::max({-p.x, p.x - 1, 0.0});
  return segment.chord_length_m() * std::hypot(beside, beyond) - segment.max_half_width_m();
}

}  // namespace

Grid distance_from_roads(const Network& network, const Grid& like) {
  Grid distance = like;
  std::fill(distance.values.begin(), distance.values.end(), 1e30f);
  // The nearest road sample is handed from post to post, in two sweeps (vector distance transform, Danielsson 1980).
  std::vector<glm::dvec2> nearest_sample(like.values.size(), glm::dvec2(1e30, 1e30));
  const auto offer = [&](int column, int row, glm::dvec2 sample) {
    const double d = glm::length(sample - (like.origin_m + like.step_m * glm::dvec2(column, row)));
    float& held = distance.at(column, row);
    if (d < held) {
      held = static_cast<float>(d);
      nearest_sample[static_cast<std::size_t>(row) * like.columns + column] = sample;
    }
  };
  const double step = 0.5 * std::min(like.step_m.x, like.step_m.y);
  const auto offer_along = [&](const Segment& segment) {
    const int pieces = std::max(1, static_cast<int>(std::ceil(segment.arc_m / step)));
    for (int i = 0; i <= pieces; ++i) {
      const glm::dvec2 p = position_m(segment, static_cast<double>(i) / pieces);
      const glm::dvec2 cell = glm::round((p - like.origin_m) / like.step_m);
      offer(std::clamp(static_cast<int>(cell.x), 0, like.columns - 1),
            std::clamp(static_cast<int>(cell.y), 0, like.rows - 1), p);
    }
  };
  for (const Road& road : network.roads) std::ranges::for_each(road.segments, offer_along);
  for (const Junction& junction : network.junctions) {
    for (const std::vector<Segment>& corner : junction.corners) std::ranges::for_each(corner, offer_along);
  }
  const auto take = [&](int column, int row, int dx, int dy) {
    const int x = column + dx, y = row + dy;
    if (x < 0 || x >= like.columns || y < 0 || y >= like.rows) return;
    const glm::dvec2 sample = nearest_sample[static_cast<std::size_t>(y) * like.columns + x];
    if (sample.x < 1e29) offer(column, row, sample);
  };
  for (int row = 0; row < like.rows; ++row) {
    for (int column = 0; column < like.columns; ++column) {
      for (const int dx : {-1, 0, 1}) take(column, row, dx, -1);
      take(column, row, -1, 0);
    }
    for (int column = like.columns - 1; column >= 0; --column) take(column, row, 1, 0);
  }
  for (int row = like.rows - 1; row >= 0; --row) {
    for (int column = like.columns - 1; column >= 0; --column) {
      for (const int dx : {-1, 0, 1}) take(column, row, dx, 1);
      take(column, row, 1, 0);
    }
    for (int column = 0; column < like.columns; ++column) take(column, row, -1, 0);
  }
  return distance;
}

Levelling::Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options)
    : Levelling(index, natural, options, std::make_shared<const Grid>(distance_from_roads(index.network(), natural))) {}

Levelling::Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options,
                     const std::shared_ptr<const Grid>& distance)
    : Levelling(index, natural, options, distance, find_supports(index, natural, options, distance)) {}

// What covers a tunnel may also be the ground of a road that crosses above it: that of all roads, were every tunnel under a
// hill, tells. Or it is filled up, where no road on the ground is in the way.
Supports Levelling::find_supports(const RoadIndex& index, const Grid& natural, const LevellingOptions& options,
                                  const std::shared_ptr<const Grid>& distance) {
  const double least_m = kLeastHill * options.shoulder_m;
  const auto everywhere = [](glm::dvec2) { return std::numeric_limits<double>::infinity(); };
  Supports closed(index.network(), everywhere, options.cover_m, 0);
  const bool has_tunnels = closed.parts(Support::kTunnel) > 0;
  const Levelling above(index, natural, options, distance, std::move(closed));
  const auto ground_m = [&](glm::dvec2 p) {
    const double beyond = above.edge_distance_m(p, options.shoulder_m + kMostRoof_m) - options.shoulder_m;
    const double natural_m = sample_bicubic(natural, p), roof = std::clamp(beyond, 0.0, kMostRoof_m);
    return std::max(natural_m + roof, above.height_m(p));
  };
  const Supports known = has_tunnels ? Supports(index.network(), ground_m, options.cover_m, least_m) : above.supports();
  const AssumedBridges assumed = bridges_over_roads(index, known, options.shoulder_m, options.cut_slope);
  return Supports(index.network(), ground_m, options.cover_m, least_m, assumed);
}

Levelling::Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options,
                     std::shared_ptr<const Grid> distance, Supports supports)
    : index_(index),
      natural_(natural),
      options_(options),
      distance_(std::move(distance)),
      supports_(std::move(supports)) {
  std::vector<Sample> all;
  // The middle of each piece of at most kSampleStep_m between two parameters.
  const auto add_samples = [&](const Segment& segment, double u0, double u1, bool is_edge) {
    const double size = u1 - u0;
    const int pieces = std::max(1, static_cast<int>(std::ceil(size * segment.arc_m / kSampleStep_m)));
    for (int i = 0; i < pieces; ++i) {
      const double u = u0 + size * (i + 0.5) / pieces, local = arc_at(segment, u);
      const double half_width = is_edge ? 0 : std::max(segment.left_m.value(local), -segment.right_m.value(local));
      all.push_back({position_m(segment, u), segment.elevation_m.value(local) - options.gap_m, half_width});
    }
  };
  const std::vector<Road>& roads = index.network().roads;
  for (SegmentRef at{0, 0}; at.road < roads.size(); ++at.road) {
    for (at.segment = 0; at.segment < roads[at.road].segments.size(); ++at.segment) {
      const Segment& segment = index.segment(at);
      widest_m_ = std::max(widest_m_, segment.max_half_width_m());
      for (const SupportedPart& part : supports_.of(index.network(), at)) {
        if (part.support == Support::kGround) add_samples(segment, part.u0, part.u1, false);
      }
    }
  }
  // Areas by their boundary: their arms may all be bridges but one.
  const std::vector<Junction>& junctions = index.network().junctions;
  for (std::size_t i = 0; i < junctions.size(); ++i) {
    if (supports_.of_junction(i) != Support::kGround) continue;
    for (const JunctionArm& arm : junctions[i].arms) {
      widest_m_ = std::max({widest_m_, arm.left_m, -arm.right_m});
      all.push_back({arm.position_m, arm.elevation_m - options.gap_m, std::max(arm.left_m, -arm.right_m)});
    }
    for (const std::vector<Segment>& corner : junctions[i].corners) {
      for (const Segment& segment : corner) add_samples(segment, 0, 1, true);
    }
  }
  find_raised();
  slack_m_ = 2 * glm::length(natural.step_m);
  // Buckets as wide as the blending reaches, so that the nine around a point hold every sample of weight.
  bucket_m_ = options_.reach_m + options_.shoulder_m + widest_m_ + 2 * kSampleStep_m;
  Bounds box;
  for (const Sample& s : all) box.add(glm::dvec3(s.position_m, 0));
  if (all.empty()) box.add({natural.origin_m, 0});  // no road lies on the ground
  bucket_origin_m_ = glm::dvec2(box.low_m) - 1.5 * bucket_m_;
  const glm::dvec2 size = glm::dvec2(box.high_m) - bucket_origin_m_;
  bucket_columns_ = static_cast<int>(size.x / bucket_m_) + 3;
  bucket_rows_ = static_cast<int>(size.y / bucket_m_) + 3;
  first_.assign(static_cast<std::size_t>(bucket_columns_) * bucket_rows_ + 1, 0);
  for (const Sample& s : all) ++first_[bucket(s.position_m, 0, 0) + 1];
  for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
  samples_.resize(all.size());
  std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
  for (const Sample& s : all) samples_[next[bucket(s.position_m, 0, 0)]++] = s;
}

void Levelling::find_raised() {
  const Network& network = index_.network();
  const std::vector<bool> in_area = roads_in_areas(network);
  std::vector<Box> boxes;
  const auto add = [&](const Raised& raised, const Bounds& bounds) {
    raised_.push_back(raised);
    boxes.push_back({glm::dvec3(glm::dvec2(bounds.low_m), 0), glm::dvec3(glm::dvec2(bounds.high_m), 0)});
  };
  for (SegmentRef at{0, 0}; at.road < network.roads.size(); ++at.road) {
    if (in_area[at.road]) continue;
    for (at.segment = 0; at.segment < network.roads[at.road].segments.size(); ++at.segment) {
      for (const SupportedPart& part : supports_.of(network, at)) {
        if (part.support == Support::kBridge) add({at, part}, bounds(index_.segment(at)));
      }
    }
  }
  for (std::size_t i = 0; i < network.junctions.size(); ++i) {
    if (supports_.of_junction(i) != Support::kBridge) continue;
    add({{}, {}, static_cast<std::int32_t>(surfaces_.size())}, bounds(network.junctions[i]));
    surfaces_.push_back(junction_surface(network.junctions[i]));
  }
  if (!boxes.empty()) raised_tree_ = BoxTree(boxes);
  boxes.clear();
  for (const Hollow& hollow : supports_.hollows()) boxes.push_back(hollow.box());
  if (!boxes.empty()) hollow_tree_ = BoxTree(boxes);
}

std::size_t Levelling::bucket(glm::dvec2 point_m, int dx, int dy) const {
  const glm::dvec2 cell = glm::floor((point_m - bucket_origin_m_) / bucket_m_);
  const int column = std::clamp(static_cast<int>(cell.x) + dx, 0, bucket_columns_ - 1);
  const int row = std::clamp(static_cast<int>(cell.y) + dy, 0, bucket_rows_ - 1);
  return static_cast<std::size_t>(row) * bucket_columns_ + column;
}

double Levelling::far_distance_m(glm::dvec2 point_m) const {
  return std::max(sample_bilinear(*distance_, point_m) - slack_m_ - widest_m_, 0.0);
}

// Where shoulders meet, each leg counts by the eighth power of its distance against what is left of a shoulder's width: so
// the ground stays a leg's own over the first third of the way between two, and is a wall in the middle.
Levelling::Wish Levelling::nearest_roads(glm::dvec2 point_m, double limit_m) const {
  const double strip = options_.shoulder_m + kBlendWidth_m;
  Wish wish{limit_m, 0, point_m};
  double nearest_z = 0, lowest = std::numeric_limits<double>::infinity(), weights = 0, sum = 0;
  const auto add = [&](double edge, double z, glm::dvec2 foot_m) {
    if (edge <= 0) lowest = std::min(lowest, z);
    if (edge > 0 && edge < strip) {
      const double odds = (strip - edge) / edge, squared = odds * odds, weight = squared * squared * squared * squared;
      weights += weight;
      sum += weight * z;
    }
    if (edge < wish.edge_m) wish.edge_m = edge, wish.foot_m = foot_m, nearest_z = z;
  };
  index_.visit_within(point_m, limit_m, [&](SegmentRef ref, const Segment& segment) {
    if (least_edge_m(segment, point_m) >= std::max(wish.edge_m, strip)) return;
    for (const SupportedPart& part : supports_.of(index_.network(), ref)) {
      if (part.support != Support::kGround) continue;
      const Passing at = passing(part, segment, point_m, options_.shoulder_m);
      const double edge = passing_edge_m(part, at);
      if (edge >= 0 && edge < limit_m) add(edge, at.z_m, at.foot_m);
    }
  });
  index_.visit_junctions(point_m, limit_m, [&](std::uint32_t i, const JunctionSurface& surface) {
    if (supports_.of_junction(i) != Support::kGround) return;
    const double edge = std::max(-signed_distance_m(surface, point_m), 0.0);
    if (edge >= limit_m || (edge >= wish.edge_m && edge >= strip)) return;
    add(edge, height_m_at(surface, point_m), point_m);
  });
  wish.level_m = wish.edge_m <= 0 ? lowest : weights > 0 ? sum / weights : nearest_z;
  return wish;
}

// A ditch is there where nothing but its own road is: it fades out over its own width before the shoulders of other legs
// and areas, and before the ends of bridges and tunnels and another width beside them.
double Levelling::ditch_part(glm::dvec2 point_m, const Wish& wish) const {
  const double width = options_.ditch_width_m(), shoulder = options_.shoulder_m;
  double room = width;
  index_.visit_within(point_m, shoulder + 2 * width, [&](SegmentRef ref, const Segment& segment) {
    for (const SupportedPart& part : supports_.of(index_.network(), ref)) {
      const Passing at = passing(part, segment, point_m, shoulder);
      const double beside = at.beside_m - shoulder;
      if (part.support == Support::kGround) {
        if (at.is_beside && glm::length(at.foot_m - wish.foot_m) > kOtherLeg_m) room = std::min(room, beside);
      } else if (std::abs(at.z_m - wish.level_m) < kDitchBelow_m) {
        room = std::min(room, std::max(at.is_beside ? 0.0 : std::abs(at.beyond_m), beside - width));
      }
    }
  });
  index_.visit_junctions(point_m, shoulder + width, [&](std::uint32_t, const JunctionSurface& surface) {
    room = std::min(room, -signed_distance_m(surface, point_m) - shoulder);
  });
  return smooth(room / width);
}

double Levelling::edge_distance_m(glm::dvec2 point_m, double limit_m) const {
  const double far = far_distance_m(point_m);
  return far >= limit_m ? far : nearest_roads(point_m, limit_m).edge_m;
}

// Weights ((R - d) / (R d))^2: the samples of one leg add up to a weight of 1/d, so between two legs the ground is a
// ramp.
Levelling::Blend Levelling::blend(glm::dvec2 point_m) const {
  const double reach = options_.reach_m + 2 * kSampleStep_m;
  double weight = 0, sum = 0, squares = 0, reference = 0;
  for (int dy = -1; dy <= 1; ++dy) {
    const std::size_t row = bucket(point_m, -1, dy), end = bucket(point_m, 1, dy);
    for (std::uint32_t i = first_[row]; i < first_[end + 1]; ++i) {
      const Sample& s = samples_[i];
      const double d =
          std::max(glm::length(s.position_m - point_m) - s.half_width_m - options_.shoulder_m, kNearestWeight_m);
      if (d >= reach) continue;
      const double root = (reach - d) / (reach * d), w = root * root;
      if (weight == 0) reference = s.z_m;
      const double z = s.z_m - reference;
      weight += w;
      sum += w * z;
      squares += w * z * z;
    }
  }
  assert(weight > 0);  // samples of the nearest road or area are within reach
  const double mean = sum / weight;
  return {reference + mean, std::sqrt(std::max(squares / weight - mean * mean, 0.0))};
}

bool Levelling::is_natural(glm::dvec2 point_m) const {
  return far_distance_m(point_m) >= options_.reach_m + options_.shoulder_m;
}

double Levelling::height_m(glm::dvec2 point_m) const {
  if (is_natural(point_m)) return sample_bicubic(natural_, point_m);
  double edge_m = 0;
  const double ground_m = levelled_m(point_m, edge_m);
  return below_bridges_m(point_m, ground_m, edge_m);
}

// The ground where it is not above any bridge about, else cut like that of a road on the ground; but not out of the level
// strip of a road on the ground beside the bridge, that is road_m away: between the two stands a wall.
double Levelling::below_bridges_m(glm::dvec2 point_m, double ground_m, double road_m) const {
  if (raised_.empty()) return ground_m;
  const double limit = options_.reach_m + options_.shoulder_m;
  double least = ground_m;
  const glm::dvec3 flat(point_m, 0);
  const double strip = options_.shoulder_m + kBlendWidth_m;
  const auto beyond_road = [&](double bridge_m) {
    return std::max(smooth(3 * road_m / (road_m + bridge_m) - 1), smooth(3 * road_m / strip - 2));
  };
  raised_tree_.search({flat, flat}, {.reach_m = limit}, [&](std::uint32_t item) {
    const Raised& raised = raised_[item];
    double z = 0, edge = 0;
    if (raised.junction >= 0) {
      const JunctionSurface& surface = surfaces_[static_cast<std::size_t>(raised.junction)];
      edge = std::max(-signed_distance_m(surface, point_m), 0.0);
      if (edge < limit) z = height_m_at(surface, point_m);
    } else {
      const Passing at = passing(raised.part, index_.segment(raised.at), point_m, options_.shoulder_m);
      edge = passing_edge_m(raised.part, at);
      z = at.z_m;
    }
    if (edge < 0 || edge >= limit) return;
    const double level = z - options_.gap_m, d = edge - options_.shoulder_m;
    if (ground_m <= level) return;
    const double cut =
        d > 0 ? approach_m(level, ground_m, allowance_m(d, options_.cut_slope, options_.reach_m)) : level;
    least = std::min(least, edge > 0 ? glm::mix(ground_m, cut, beyond_road(edge)) : cut);
  });
  return least;
}

// What the hill over a tunnel keeps: the vault with its cover, and slopes of fill to its sides.
double Levelling::over_tunnels_m(glm::dvec2 point_m) const {
  double highest = -std::numeric_limits<double>::infinity();
  if (supports_.hollows().empty()) return highest;
  const glm::dvec3 flat(point_m, 0);
  for (const Hall& hall : supports_.halls()) {
    const Box box = hall.box();
    const glm::dvec2 off = glm::max(glm::dvec2(box.low_m) - point_m, point_m - glm::dvec2(box.high_m));
    if (std::max(off.x, off.y) > kTunnelSides_m) continue;
    const double beside = std::max(-signed_distance_m(hall.surface, point_m, 2 * kTunnelSides_m), 0.0);
    if (beside > kTunnelSides_m) continue;
    const double roof = height_m_at(hall.surface, point_m) + hall.height_m + options_.cover_m;
    highest = std::max(highest, roof - options_.fill_slope * beside);
  }
  hollow_tree_.search({flat, flat}, {.reach_m = kTunnelSides_m}, [&](std::uint32_t item) {
    const Hollow& h = supports_.hollows()[item];
    const glm::dvec2 p = to_chord(h.segment, point_m);
    const double u = nearest(h.segment, point_m).u;
    if (u < h.piece.u0 || u > h.piece.u1) return;
    const double df = Lib::road_df(u, h.segment.slope_start, h.segment.slope_end);
    const double dx = p.x - u, dy = p.y - Lib::road_f(u, h.segment.slope_start, h.segment.slope_end);
    if (std::abs(dx + dy * df) > kPerpendicular) return;
    const double s = arc_at(h.segment, u);
    if (h.from_start_m + s - h.s0_m < options_.shoulder_m || h.to_end_m + h.s1_m - s < options_.shoulder_m) return;
    const Lib::SweepPath& path = h.piece.path;
    const double n = (dy - dx * df) * h.segment.chord_length_m() / std::sqrt(1 + df * df) - path.n0 - path.n1 * s;
    const double vault = h.start_m.z + Lib::road_cubic(s, path.z0, path.z1, path.z2, path.z3) + h.height_m;
    const double beside = std::max(std::abs(n) - h.half_width_m, 0.0);
    highest = std::max(highest, vault + options_.cover_m - options_.fill_slope * beside);
  });
  return highest;
}

// The natural ground levelled to the roads on it, and the distance from the nearest.
double Levelling::levelled_m(glm::dvec2 point_m, double& edge_m) const {
  const double over_tunnels = over_tunnels_m(point_m), bare = sample_bicubic(natural_, point_m);
  const double natural = std::max(bare, std::min(over_tunnels, bare + kMostRoof_m));
  const double reach = options_.reach_m, limit = reach + options_.shoulder_m;
  const Wish wish = nearest_roads(point_m, limit);
  edge_m = wish.edge_m;
  if (wish.edge_m >= limit) return natural;
  const double own = wish.level_m - options_.gap_m, d = wish.edge_m - options_.shoulder_m;
  if (d <= 0) return own;
  const Blend legs = blend(point_m);
  const double level = glm::mix(own, legs.mean_m, smooth(d / kBlendWidth_m));
  const double width = options_.ditch_width_m(), part = d < width ? ditch_part(point_m, wish) : 1;
  // A cutting begins beyond the ditch, an embankment falls away through it.
  const bool is_cut = natural > level;
  const double before = is_cut ? part * width : 0, from = d - before;
  // A ramp between legs that is steep already gets less of the allowance.
  const double ramp = legs.deviation_m / (d + 2);
  double ground = level;
  if (from > 0) {
    const double slope = is_cut ? options_.cut_slope : options_.fill_slope;
    ground = approach_m(level, natural, allowance_m(from, slope, reach - before) / (1 + ramp * ramp));
  }
  if (d < width) ground = std::min(ground, own - ditch_m(d, part * options_.ditch_depth_m, options_));
  return std::max(ground, std::min(natural, over_tunnels));
}

}  // namespace roadgen
