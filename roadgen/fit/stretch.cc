#include "roadgen/fit/stretch.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"

namespace roadgen {
namespace {

// A piece that is straighter than this gains nothing from halving where the half width exceeds its radius.
constexpr double kStraightSlope = 0.1;
// Tangents further off the chord than this (cosine) make no segment; the piece is halved at once.
constexpr double kLeastCosine = 0.25;
// Bounds are proven in real arithmetic for the width asked for; profiles reproduce that width to a few roundings.
constexpr double kRoundingShare = 1 - 1e-9;

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

bool admissible_at(Segment& segment, double half_width_m, double tolerance) {
  segment.set_half_width_m({half_width_m, 0, 0, 0});
  set_bound(segment);
  return is_admissible(segment, tolerance * kRoundingShare);
}

// Halves a stretch until accept() takes each piece.
template <class Accept>
class Divider {
 public:
  Divider(const Stretch& stretch, Accept accept, Division& division)
      : stretch_(stretch), accept_(accept), division_(division) {}

  // False at a cusp.
  bool run(double t0, double t1, int depth) {
    Piece piece;
    piece.t0 = t0;
    piece.t1 = t1;
    Segment& s = piece.segment;
    s.start_m = stretch_.position_m(t0);
    s.end_m = stretch_.position_m(t1);
    const glm::dvec2 chord = s.chord_m(), d0 = stretch_.derivative_m(t0), d1 = stretch_.derivative_m(t1);
    const double length = glm::length(chord), speed0 = glm::length(d0), speed1 = glm::length(d1);
    if (!(length > 0) || !(std::min(speed0, speed1) > 1e-12 * length)) return cusp(t0, t1);
    const double along0 = glm::dot(chord, d0), along1 = glm::dot(chord, d1);
    if (along0 > kLeastCosine * length * speed0 && along1 > kLeastCosine * length * speed1) {
      s.slope_start = cross(chord, d0) / along0;
      s.slope_end = cross(chord, d1) / along1;
      if (accept_(piece)) {
        division_.pieces.push_back(piece);
        return true;
      }
    }
    if (depth == kMostHalvings) return cusp(t0, t1);
    const double middle = 0.5 * (t0 + t1);
    return run(t0, middle, depth + 1) && run(middle, t1, depth + 1);
  }

 private:
  bool cusp(double t0, double t1) {
    division_.cusps.push_back({0.5 * (t0 + t1)});
    return false;
  }

  const Stretch& stretch_;
  Accept accept_;
  Division& division_;
};

double steepest(const Segment& s) { return std::max(std::abs(s.slope_start), std::abs(s.slope_end)); }

}  // namespace

glm::dvec2 Stretch::position_m(double t) const {
  if (t == 0) return start_m;
  if (t == 1) return end_m;
  const double w = 1 - t;
  return start_m + (end_m - start_m) * (t * t * (3 - 2 * t)) + tangent_start_m * (t * w * w) -
         tangent_end_m * (t * t * w);
}

glm::dvec2 Stretch::derivative_m(double t) const {
  const double w = 1 - t;
  return (end_m - start_m) * (6 * t * w) + tangent_start_m * (w * (w - 2 * t)) + tangent_end_m * (t * (t - 2 * w));
}

double Stretch::curvature_per_m(double t) const {
  const glm::dvec2 d = derivative_m(t);
  const glm::dvec2 dd = (end_m - start_m) * (6 - 12 * t) + tangent_start_m * (6 * t - 4) + tangent_end_m * (6 * t - 2);
  const double speed2 = glm::dot(d, d);
  if (speed2 == 0) return std::numeric_limits<double>::infinity();
  return cross(d, dd) / (speed2 * std::sqrt(speed2));
}

Stretch make_stretch(glm::dvec2 start_m, glm::dvec2 end_m, double heading_start_rad, double heading_end_rad) {
  const glm::dvec2 chord = end_m - start_m;
  const double length = glm::length(chord);
  const auto tangent = [&](double heading_rad) {
    const glm::dvec2 d = direction(heading_rad);
    const double cosine = glm::dot(d, chord) / length;
    return d * (length / std::max(cosine, 0.5));
  };
  return {start_m, end_m, tangent(heading_start_rad), tangent(heading_end_rad)};
}

double least_radius_m(const Segment& segment) {
  constexpr int kProbes = 16;
  double most = 0;
  for (int i = 0; i <= kProbes; ++i) {
    most = std::max(most, std::abs(curvature_per_m(segment, static_cast<double>(i) / kProbes)));
  }
  return 1 / most;
}

std::optional<double> tight_cap_m(Segment segment, double half_width_m, double mapping_tolerance) {
  if (steepest(segment) > kStraightSlope) return std::nullopt;
  set_arc(segment);
  double low = kLeastHalfWidth_m, high = half_width_m;
  if (!(low < high)) return 0;
  if (!admissible_at(segment, low, mapping_tolerance)) {
    // Wide enough, but perhaps too long for what the least width tolerates.
    return std::isfinite(segment.bound.v) ? std::nullopt : std::optional(0.0);
  }
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (admissible_at(segment, middle, mapping_tolerance) ? low : high) = middle;
  }
  return low * kRoundingShare;
}

Division divide(const Stretch& stretch, double t0, double t1, double half_width_m, double mapping_tolerance) {
  Division division;
  const auto accept = [&](Piece& piece) {
    Segment& s = piece.segment;
    s.set_half_width_m({half_width_m, 0, 0, 0});
    set_bound(s);
    if (std::isfinite(s.bound.v)) {
      set_arc(s);
      return is_admissible(s, mapping_tolerance * kRoundingShare);
    }
    const std::optional<double> cap_m = tight_cap_m(s, half_width_m, mapping_tolerance);
    if (!cap_m) return false;
    piece.cap_m = *cap_m;
    set_arc(s);
    return true;
  };
  Divider(stretch, accept, division).run(t0, t1, 0);
  return division;
}

Division divide_into_graphs(const Stretch& stretch, double most_slope) {
  Division division;
  const auto accept = [&](const Piece& piece) { return steepest(piece.segment) <= most_slope; };
  Divider(stretch, accept, division).run(0, 1, 0);
  return division;
}

}  // namespace roadgen
