#include "terrain/levelling.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kSampleStep_m = 5;       // of the road samples that are blended
constexpr double kRounding_m = 3;         // of the profile where it leaves the shoulder
constexpr double kBlendWidth_m = 1.5;     // from the nearest road's own height to the blended one
constexpr double kNearestWeight_m = 0.5;  // nearer than this all samples weigh the same
constexpr double kPerpendicular = 1e-7;   // of L: what counts as a perpendicular foot

// How far the ground may rise or fall at distance d outside the shoulder: parabola, then slope, then without limit.
double allowance_m(double d, double slope, double reach_m) {
  const double q = d / reach_m;
  return slope * d * d / (d + kRounding_m) / (1 - q * q);
}

double smooth(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

// Distance from the carriageway where the road really passes the point, so that the foot is perpendicular or at an
// open end; negative where it does not (then a neighbouring segment is nearer).
double passing_edge_m(const Road& road, SegmentRef at, const Segment& segment, glm::dvec2 point_m, double shoulder_m,
                      double& z_m) {
  const Nearest foot = nearest(segment, point_m);
  const double a = segment.slope_start, b = segment.slope_end;
  const glm::dvec2 p = to_chord(segment, point_m);
  const double df = Lib::road_df(foot.u, a, b), dx = p.x - foot.u, dy = p.y - Lib::road_f(foot.u, a, b);
  const double along = dx + dy * df;
  const double local = arc_at(segment, foot.u);
  const double scale = segment.chord_length_m() / std::sqrt(1 + df * df);
  const double cosine = std::cos(segment.superelevation_rad.value(local));
  const double left = segment.left_m.value(local) * cosine, right = segment.right_m.value(local) * cosine;
  const double n = (dy - dx * df) * scale, beside = std::max({n - left, right - n, 0.0});
  // Beside the carriageway the ground goes on level from its edge.
  const Lib::SurfaceSlope surface = surface_at(segment, local, std::clamp(n, right, left));
  z_m = surface.height;
  if (std::abs(along) <= kPerpendicular) return beside;
  const bool end =
      !road.closed && ((foot.u <= 0 && at.segment == 0) || (foot.u >= 1 && at.segment + 1 == road.segments.size()));
  if (!end) return -1;
  // The grade goes on over the shoulder, else the last triangles under the road would bend.
  z_m += surface.ahead * std::clamp(along * scale, -shoulder_m, shoulder_m);
  return std::hypot(along * scale, beside);
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
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      const int pieces = std::max(1, static_cast<int>(std::ceil(segment.arc_m / step)));
      for (int i = 0; i <= pieces; ++i) {
        const glm::dvec2 p = position_m(segment, static_cast<double>(i) / pieces);
        const glm::dvec2 cell = glm::round((p - like.origin_m) / like.step_m);
        offer(std::clamp(static_cast<int>(cell.x), 0, like.columns - 1),
              std::clamp(static_cast<int>(cell.y), 0, like.rows - 1), p);
      }
    }
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
    : index_(index), natural_(natural), options_(options), distance_(distance_from_roads(index.network(), natural)) {
  std::vector<Sample> all;
  for (const Road& road : index.network().roads) {
    for (const Segment& segment : road.segments) {
      widest_m_ = std::max(widest_m_, segment.max_half_width_m());
      const int pieces = std::max(1, static_cast<int>(std::ceil(segment.arc_m / kSampleStep_m)));
      for (int i = 0; i < pieces; ++i) {
        const double u = (i + 0.5) / pieces, local = arc_at(segment, u);
        all.push_back({position_m(segment, u), segment.elevation_m.value(local) - options.gap_m,
                       std::max(segment.left_m.value(local), -segment.right_m.value(local))});
      }
    }
  }
  slack_m_ = 2 * glm::length(natural.step_m);
  // Buckets as wide as the blending reaches, so that the nine around a point hold every sample of weight.
  bucket_m_ = options_.reach_m + options_.shoulder_m + widest_m_ + 2 * kSampleStep_m;
  Bounds box;
  for (const Sample& s : all) box.add(glm::dvec3(s.position_m, 0));
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

std::size_t Levelling::bucket(glm::dvec2 point_m, int dx, int dy) const {
  const glm::dvec2 cell = glm::floor((point_m - bucket_origin_m_) / bucket_m_);
  const int column = std::clamp(static_cast<int>(cell.x) + dx, 0, bucket_columns_ - 1);
  const int row = std::clamp(static_cast<int>(cell.y) + dy, 0, bucket_rows_ - 1);
  return static_cast<std::size_t>(row) * bucket_columns_ + column;
}

double Levelling::far_distance_m(glm::dvec2 point_m) const {
  return std::max(sample_bilinear(distance_, point_m) - slack_m_ - widest_m_, 0.0);
}

Levelling::Wish Levelling::nearest_roads(glm::dvec2 point_m, double limit_m) const {
  Wish wish{limit_m, 0};
  double nearest_z = 0, lowest = 1e300;
  index_.visit_within(point_m, limit_m, [&](SegmentRef ref, const Segment& segment) {
    double z = 0;
    const double edge = passing_edge_m(index_.network().roads[ref.road], ref, segment, point_m, options_.shoulder_m, z);
    if (edge < 0 || edge >= limit_m) return;
    if (edge <= options_.shoulder_m) lowest = std::min(lowest, z);
    if (edge < wish.edge_m) {
      wish.edge_m = edge;
      nearest_z = z;
    }
  });
  index_.visit_junctions(point_m, limit_m, [&](std::uint32_t, const JunctionSurface& surface) {
    const double edge = std::max(-signed_distance_m(surface, point_m), 0.0);
    if (edge >= limit_m) return;
    const double z = height_at(surface, point_m).height_m;
    if (edge <= options_.shoulder_m) lowest = std::min(lowest, z);
    if (edge < wish.edge_m) {
      wish.edge_m = edge;
      nearest_z = z;
    }
  });
  wish.lowest_m = lowest < 1e300 ? lowest : nearest_z;
  return wish;
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
  assert(weight > 0);  // the nearest road's own samples are within reach
  const double mean = sum / weight;
  return {reference + mean, std::sqrt(std::max(squares / weight - mean * mean, 0.0))};
}

double Levelling::height_m(glm::dvec2 point_m) const {
  const double natural = sample_bicubic(natural_, point_m);
  const double reach = options_.reach_m, limit = reach + options_.shoulder_m;
  if (far_distance_m(point_m) >= limit) return natural;
  const Wish wish = nearest_roads(point_m, limit);
  if (wish.edge_m >= limit) return natural;
  const double own = wish.lowest_m - options_.gap_m, d = wish.edge_m - options_.shoulder_m;
  if (d <= 0) return own;
  const Blend legs = blend(point_m);
  const double level = glm::mix(own, legs.mean_m, smooth(d / kBlendWidth_m));
  // The natural ground where it is within the allowance, else the allowance, with a rounded crest and toe:
  // q / (1 + q^4)^(1/4) is q for small q and goes to 1. A ramp between legs that is steep already gets less of it.
  const double ramp = legs.deviation_m / (d + 2);
  const double allowance =
      allowance_m(d, natural > level ? options_.cut_slope : options_.fill_slope, reach) / (1 + ramp * ramp);
  const double q = (natural - level) / allowance, q2 = q * q;
  return q2 > 1e12 ? level + std::copysign(allowance, q) : level + allowance * q / std::sqrt(std::sqrt(1 + q2 * q2));
}

}  // namespace roadgen
