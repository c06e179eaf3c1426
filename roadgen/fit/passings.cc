#include "roadgen/fit/passings.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kLeg_m = 4, kCell_m = 16;
constexpr double kApart_m = 30;     // along one road that passes over itself
constexpr double kLeastSine = 0.2;  // of the angle of two lines, for the length over which one is above the other

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

struct Leg {
  std::uint32_t road;
  double s0_m, s1_m;
  glm::dvec2 a, b;
};

std::uint64_t cell_of(glm::dvec2 p) {
  const auto x = static_cast<std::int64_t>(std::floor(p.x / kCell_m));
  const auto y = static_cast<std::int64_t>(std::floor(p.y / kCell_m));
  return static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y);
}

class Finder {
 public:
  Finder(const Network& network, const std::vector<bool>& skip) : network_(network), skip_(skip) {}
  std::vector<Passing> run();

 private:
  double z(const HeightSpot& spot) const {
    if (spot.is_area) return height_m_at(surfaces_[spot.index], spot.at_m);
    const Road& road = network_.roads[spot.index];
    const Segment& segment = road.segments[segment_at(road, spot.s_m)];
    return segment.elevation_m.value(std::clamp(spot.s_m - segment.s_start_m, 0.0, segment.arc_m));
  }
  HeightSpot on_road(std::uint32_t road, double s_m) const {
    const double s = std::clamp(s_m, 0.0, network_.roads[road].length_m());
    return {false, road, s, glm::dvec2(pose_at(network_.roads[road], s, 0).position_m)};
  }
  double half_width_m(std::uint32_t road, double s_m) const {
    return network_.roads[road].segments[segment_at(network_.roads[road], s_m)].max_half_width_m();
  }
  bool is_on_bridge(const HeightSpot& spot) const {
    if (spot.is_area) return false;
    const auto& bridges = network_.roads[spot.index].bridges;
    return std::any_of(bridges.begin(), bridges.end(),
                       [&](const Bridge& b) { return b.s_start_m <= spot.s_m && spot.s_m <= b.s_end_m; });
  }
  bool is_in_tunnel(const HeightSpot& spot) const {
    if (spot.is_area) return false;
    const auto& sweeps = network_.roads[spot.index].sweeps;
    return std::any_of(sweeps.begin(), sweeps.end(), [&](const Sweep& sweep) {
      return sweep.kind() == SweepKind::kTunnel && sweep.s_start_m <= spot.s_m && spot.s_m <= sweep.s_end_m;
    });
  }
  void add_legs();
  void add(const HeightSpot& a, const HeightSpot& b, bool is_middle);
  void test(const Leg& a, const Leg& b);
  void search_area(std::uint32_t junction);

  const Network& network_;
  const std::vector<bool>& skip_;
  std::vector<Leg> legs_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // legs by the cell of their start
  std::vector<JunctionSurface> surfaces_;
  std::vector<Passing> found_;
};

void Finder::add_legs() {
  for (std::uint32_t i = 0; i < network_.roads.size(); ++i) {
    if (skip_[i]) continue;
    for (const Segment& segment : network_.roads[i].segments) {
      const int count = std::max(1, static_cast<int>(std::ceil(segment.arc_m / kLeg_m)));
      for (int k = 0; k < count; ++k) {
        const double u0 = static_cast<double>(k) / count, u1 = static_cast<double>(k + 1) / count;
        const glm::dvec2 a = position_m(segment, u0);
        cells_[cell_of(a)].push_back(static_cast<std::uint32_t>(legs_.size()));
        legs_.push_back({i, segment.s_start_m + arc_at(segment, u0), segment.s_start_m + arc_at(segment, u1), a,
                         position_m(segment, u1)});
      }
    }
  }
}

void Finder::add(const HeightSpot& a, const HeightSpot& b, bool is_middle) {
  const double above = z(a) - z(b);
  const HeightSpot &upper = above > 0 ? a : b, &lower = above > 0 ? b : a;
  const bool is_meant = is_on_bridge(upper) || is_in_tunnel(lower);
  if (std::abs(above) < (is_meant ? kMeantPassing_m : kPassing_m)) return;
  found_.push_back({upper, lower, std::abs(above), is_middle, is_meant});
}

void Finder::test(const Leg& a, const Leg& b) {
  if (a.road == b.road && std::abs(a.s0_m - b.s0_m) < kApart_m) return;
  const glm::dvec2 d = a.b - a.a, e = b.b - b.a, v = b.a - a.a;
  const double sine = cross(d, e), size = glm::length(d) * glm::length(e);
  if (!(std::abs(sine) > 1e-3 * size)) return;
  const double s = cross(v, e) / sine, t = cross(v, d) / sine;
  if (!(s >= 0 && s < 1 && t >= 0 && t < 1)) return;
  const double at_a = glm::mix(a.s0_m, a.s1_m, s), at_b = glm::mix(b.s0_m, b.s1_m, t);
  const HeightSpot on_a = on_road(a.road, at_a), on_b = on_road(b.road, at_b);
  const std::size_t before = found_.size();
  add(on_a, on_b, true);
  if (found_.size() == before) return;
  const double oblique = std::max(std::abs(sine) / size, kLeastSine);
  for (const double side : {-1.0, 1.0}) {
    add(on_road(a.road, at_a + side * half_width_m(b.road, at_b) / oblique), on_b, false);
    add(on_a, on_road(b.road, at_b + side * half_width_m(a.road, at_a) / oblique), false);
  }
}

// Roads in the area, and other areas' arms.
void Finder::search_area(std::uint32_t junction) {
  const JunctionSurface& surface = surfaces_[junction];
  const auto& arms = network_.junctions[junction].arms;
  const glm::dvec2 low = glm::dvec2(surface.center_m + surface.low_m),
                   high = glm::dvec2(surface.center_m + surface.high_m);
  const auto is_arm = [&](std::uint32_t road) {
    return std::any_of(arms.begin(), arms.end(),
                       [&](const JunctionArm& arm) { return arm.road == network_.roads[road].id; });
  };
  for (double x = low.x - kCell_m; x <= high.x + kCell_m; x += kCell_m) {
    for (double y = low.y - kCell_m; y <= high.y + kCell_m; y += kCell_m) {
      const auto cell = cells_.find(cell_of({x, y}));
      if (cell == cells_.end()) continue;
      for (const std::uint32_t i : cell->second) {
        const Leg& leg = legs_[i];
        if (!is_arm(leg.road) && is_inside(surface, leg.a)) {
          add({true, junction, 0, leg.a}, {false, leg.road, leg.s0_m, leg.a}, true);
        }
      }
    }
  }
  for (std::uint32_t other = 0; other < surfaces_.size(); ++other) {
    if (other == junction) continue;
    const glm::dvec2 apart = glm::dvec2(surfaces_[other].center_m - surface.center_m);
    if (glm::length(apart) > glm::length(high - low) + 100) continue;
    for (const JunctionArm& arm : network_.junctions[other].arms) {
      if (!is_inside(surface, arm.position_m)) continue;
      add({true, junction, 0, arm.position_m}, {true, other, 0, arm.position_m}, true);
    }
  }
}

std::vector<Passing> Finder::run() {
  add_legs();
  for (const Junction& junction : network_.junctions) {
    surfaces_.push_back(junction_pieces(junction));
  }
  for (std::uint32_t i = 0; i < legs_.size(); ++i) {
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto cell = cells_.find(cell_of(legs_[i].a + kCell_m * glm::dvec2(dx, dy)));
        if (cell == cells_.end()) continue;
        for (const std::uint32_t k : cell->second) {
          if (k > i) test(legs_[i], legs_[k]);
        }
      }
    }
  }
  for (std::uint32_t j = 0; j < surfaces_.size(); ++j) search_area(j);
  return std::move(found_);
}

}  // namespace

std::vector<Passing> find_passings(const Network& network, const std::vector<bool>& skip) {
  return Finder(network, skip).run();
}

}  // namespace roadgen
