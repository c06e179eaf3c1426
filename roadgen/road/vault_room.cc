#include "roadgen/road/vault_room.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kStep_m = 2, kCell_m = 32;
constexpr double kApart_m = 30;       // along one road that passes over its own tunnel
constexpr double kOverVault_m = 0.1;  // of the road above over the vault's outside
constexpr double kReach_m = 16;       // beside its axis, beyond which no vault is
constexpr double kBeside_m = 1.2;     // a road that is so little within the outside lies beside it

// A cross section of a tunnel.
struct Station {
  std::uint32_t road = 0, sweep = 0;
  double s_m = 0;
  glm::dvec2 at_m{0, 0}, ahead{1, 0};
  double half_m = 0;  // of the vault's outside
  double road_z = 0, crown_z = 0;
  bool has_room = true;
};

class Trimmer {
 public:
  explicit Trimmer(Network& network) : network_(network) {}
  std::vector<VaultGap> run();

 private:
  static std::uint64_t cell(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y);
  }
  static std::int64_t column(double x) { return static_cast<std::int64_t>(std::floor(x / kCell_m)); }
  void add_stations();
  bool is_near(const Segment& segment) const;
  void pass(glm::dvec3 point_m, std::uint32_t road, double s_m);
  void pass_road(std::uint32_t road);
  void pass_area(const Junction& junction);
  void trim(Road& road, std::uint32_t index, std::vector<VaultGap>& gaps);

  Network& network_;
  std::vector<Station> stations_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;  // by all cells within kReach_m
};

void Trimmer::add_stations() {
  for (std::uint32_t i = 0; i < network_.roads.size(); ++i) {
    const Road& road = network_.roads[i];
    for (std::uint32_t k = 0; k < road.sweeps.size(); ++k) {
      const Sweep& sweep = road.sweeps[k];
      const auto* tunnel = std::get_if<Tunnel>(&sweep.shape);
      const double from = std::max(sweep.s_start_m, 0.0), to = std::min(sweep.s_end_m, road.length_m());
      if (!tunnel || !(to > from)) continue;
      const int count = std::max(1, static_cast<int>(std::ceil((to - from) / kStep_m)));
      for (int n = 0; n <= count; ++n) {
        const double s = from + (to - from) * n / count;
        const RoadPose place = pose_at(road, s, sweep.t_m + sweep.t_slope * (s - sweep.s_start_m));
        Station station;
        station.road = i, station.sweep = k, station.s_m = s;
        station.at_m = glm::dvec2(place.position_m);
        station.ahead = {std::cos(place.heading_rad), std::sin(place.heading_rad)};
        station.half_m = tunnel->half_width_m + tunnel->lining_m;
        station.road_z = place.position_m.z;
        station.crown_z = station.road_z + tunnel->wall_height_m + tunnel->arch_rise_m + tunnel->lining_m;
        for (std::int64_t x = column(station.at_m.x - kReach_m); x <= column(station.at_m.x + kReach_m); ++x) {
          for (std::int64_t y = column(station.at_m.y - kReach_m); y <= column(station.at_m.y + kReach_m); ++y) {
            cells_[cell(x, y)].push_back(static_cast<std::uint32_t>(stations_.size()));
          }
        }
        stations_.push_back(station);
      }
    }
  }
}

// Whether a tunnel may be under the segment.
bool Trimmer::is_near(const Segment& segment) const {
  const Bounds box = bounds(segment);
  for (std::int64_t x = column(box.low_m.x); x <= column(box.high_m.x); ++x) {
    for (std::int64_t y = column(box.low_m.y); y <= column(box.high_m.y); ++y) {
      if (cells_.contains(cell(x, y))) return true;
    }
  }
  return false;
}

// Of the stations whose vault a point of a road's surface lies in.
void Trimmer::pass(glm::dvec3 point_m, std::uint32_t road, double s_m) {
  const auto near = cells_.find(cell(column(point_m.x), column(point_m.y)));
  if (near == cells_.end()) return;
  for (const std::uint32_t i : near->second) {
    Station& station = stations_[i];
    if (point_m.z < station.road_z + kBesideVault_m || point_m.z > station.crown_z + kOverVault_m) continue;
    if (station.road == road && std::abs(station.s_m - s_m) < kApart_m) continue;
    const glm::dvec2 d = glm::dvec2(point_m) - station.at_m;
    const double along = glm::dot(d, station.ahead), across = d.y * station.ahead.x - d.x * station.ahead.y;
    if (std::abs(along) <= kStep_m && std::abs(across) <= station.half_m - kBeside_m) station.has_room = false;
  }
}

void Trimmer::pass_road(std::uint32_t index) {
  const Road& road = network_.roads[index];
  for (const Segment& segment : road.segments) {
    if (!is_near(segment)) continue;
    const int count = std::max(1, static_cast<int>(std::ceil(segment.arc_m / kStep_m)));
    for (int n = 0; n <= count; ++n) {
      const double local = segment.arc_m * n / count, s = segment.s_start_m + local;
      const double left = segment.left_m.value(local), right = segment.right_m.value(local);
      const int across = std::max(1, static_cast<int>(std::ceil((left - right) / kStep_m)));
      for (int k = 0; k <= across; ++k) {
        pass(pose_at(road, s, right + (left - right) * k / across).position_m, index, s);
      }
    }
  }
}

void Trimmer::pass_area(const Junction& junction) {
  const JunctionSurface surface = junction_pieces(junction);
  const glm::dvec2 low = glm::dvec2(surface.center_m + surface.low_m),
                   high = glm::dvec2(surface.center_m + surface.high_m);
  std::vector<std::uint32_t> near;
  for (std::int64_t x = column(low.x); x <= column(high.x); ++x) {
    for (std::int64_t y = column(low.y); y <= column(high.y); ++y) {
      const auto found = cells_.find(cell(x, y));
      if (found != cells_.end()) near.insert(near.end(), found->second.begin(), found->second.end());
    }
  }
  for (const std::uint32_t i : near) {
    Station& station = stations_[i];
    for (const double side : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      const glm::dvec2 at = station.at_m + side * station.half_m * glm::dvec2(-station.ahead.y, station.ahead.x);
      if (!is_inside(surface, at)) continue;
      const double z = height_m_at(surface, at);
      if (z >= station.road_z + kBesideVault_m && z <= station.crown_z + kOverVault_m) station.has_room = false;
    }
  }
}

void Trimmer::trim(Road& road, std::uint32_t index, std::vector<VaultGap>& gaps) {
  std::vector<Sweep> kept;
  for (std::uint32_t k = 0; k < road.sweeps.size(); ++k) {
    const Sweep whole = road.sweeps[k];
    double from = whole.s_start_m;
    bool is_whole = true;
    const auto keep = [&](double to) {
      const bool is_long = to - from >= kLeastVault_m;
      if (is_long) {
        Sweep part = whole;
        part.t_m += whole.t_slope * (from - whole.s_start_m);
        part.s_start_m = from;
        part.s_end_m = to;
        const std::vector<Sweep> parts = parts_between_tight_bends(road, part, kLeastVault_m);
        kept.insert(kept.end(), parts.begin(), parts.end());
      }
      return is_long ? to : from;
    };
    for (const Station& station : stations_) {
      if (station.road != index || station.sweep != k || station.has_room) continue;
      is_whole = false;
      const double gap = keep(station.s_m - kStep_m);
      from = std::max(from, station.s_m + kStep_m);
      if (!gaps.empty() && gaps.back().road == index && gap <= gaps.back().s_end_m) {
        gaps.back().s_end_m = from;
      } else {
        gaps.push_back({index, gap, from});
      }
    }
    if (is_whole) {
      kept.push_back(whole);
    } else if (const double gap = keep(whole.s_end_m); gap < whole.s_end_m) {
      gaps.back().s_end_m = whole.s_end_m;
    }
  }
  road.sweeps = std::move(kept);
}

std::vector<VaultGap> Trimmer::run() {
  std::vector<VaultGap> gaps;
  add_stations();
  if (stations_.empty()) return gaps;
  for (std::uint32_t i = 0; i < network_.roads.size(); ++i) pass_road(i);
  for (const Junction& junction : network_.junctions) pass_area(junction);
  std::vector<std::uint32_t> roads;
  for (const Station& station : stations_) {
    if (!station.has_room && (roads.empty() || roads.back() != station.road)) roads.push_back(station.road);
  }
  for (const std::uint32_t road : roads) trim(network_.roads[road], road, gaps);
  return gaps;
}

}  // namespace

std::vector<VaultGap> trim_vaults(Network& network) { return Trimmer(network).run(); }

}  // namespace roadgen
