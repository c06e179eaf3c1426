#include "roadgen/road/vault_room.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kStep_m = 2, kCell_m = 16;
constexpr double kApart_m = 30;        // along one road that passes over its own tunnel
constexpr double kOverVault_m = 0.1;   // of the road above over the vault's outside
constexpr double kEnd_m = 3;           // of a road, that may just touch the tunnel's
constexpr double kCrossingSine = 0.5;  // of the angle between a tunnel and a road that does not part from it
constexpr double kBeside_m = 1.2;      // a road that is so little within the outside lies beside it

// A cross section of a tunnel.
struct Station {
  std::uint32_t road = 0, sweep = 0;
  double s_m = 0;
  glm::dvec2 at_m{0, 0}, ahead{1, 0};
  double half_m = 0;  // of the vault's outside
  double road_z = 0, crown_z = 0;
  bool has_room = true;
};

// The stations in a square, and what heights their vaults take.
struct Cell {
  std::vector<std::uint32_t> stations;
  double low_z = 1e300, high_z = -1e300;
  // The road of them all, kMany if they have several; and where along it they are.
  static constexpr std::uint32_t kMany = 0xffffffffu;
  std::uint32_t road = kMany;
  double low_s = 1e300, high_s = -1e300;
  // Whether a place of a road is of the same leg as all of them.
  bool is_own(std::uint32_t index, double s_m) const {
    return road == index && s_m - low_s < kApart_m && high_s - s_m < kApart_m;
  }
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
  bool is_near(glm::dvec3 low_m, glm::dvec3 high_m) const;
  bool is_near(const Segment& segment) const;
  bool is_near_arms(const Junction& junction) const;
  template <class Height>
  void pass(glm::dvec2 point_m, std::uint32_t road, double s_m, const Height& height_m);
  void cross(glm::dvec2 at_m, glm::dvec2 aside, const Road& road, const Segment& segment, double local_m,
             std::uint32_t index);
  void pass_road(std::uint32_t road);
  void pass_area(const Junction& junction);
  void trim(Road& road, std::uint32_t index, std::vector<VaultGap>& gaps);

  Network& network_;
  std::vector<Station> stations_;
  std::unordered_map<std::uint64_t, Cell> cells_;  // by all cells that it or what is a step before or behind lies in
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
        const double reach = station.half_m + kStep_m;
        for (std::int64_t x = column(station.at_m.x - reach); x <= column(station.at_m.x + reach); ++x) {
          for (std::int64_t y = column(station.at_m.y - reach); y <= column(station.at_m.y + reach); ++y) {
            Cell& in = cells_[cell(x, y)];
            in.road = in.stations.empty() || in.road == i ? i : Cell::kMany;
            in.low_s = std::min(in.low_s, s), in.high_s = std::max(in.high_s, s);
            in.stations.push_back(static_cast<std::uint32_t>(stations_.size()));
            in.low_z = std::min(in.low_z, station.road_z);
            in.high_z = std::max(in.high_z, station.crown_z + kOverVault_m);
          }
        }
        stations_.push_back(station);
      }
    }
  }
}

// Whether what lies in the box may pass through a vault.
bool Trimmer::is_near(glm::dvec3 low_m, glm::dvec3 high_m) const {
  for (std::int64_t x = column(low_m.x); x <= column(high_m.x); ++x) {
    for (std::int64_t y = column(low_m.y); y <= column(high_m.y); ++y) {
      const auto found = cells_.find(cell(x, y));
      if (found == cells_.end()) continue;
      if (low_m.z <= found->second.high_z && high_m.z >= found->second.low_z + kCrossingVault_m) return true;
    }
  }
  return false;
}

// The curve is at most kBulge of its slopes off the chord; banked and cambered surfaces are as high as they are wide at most.
bool Trimmer::is_near(const Segment& segment) const {
  constexpr double kBulge = 4.0 / 27;
  const double half = segment.max_half_width_m();
  const double bulge = kBulge * (std::abs(segment.slope_start) + std::abs(segment.slope_end));
  const double beside = half + bulge * segment.chord_length_m();
  const bool is_level = segment.superelevation_rad == Cubic{} && segment.crossfall_left == Linear{} &&
                        segment.crossfall_right == Linear{};
  const Cubic::Range z = segment.elevation_m.range(segment.arc_m);
  const glm::dvec3 margin(beside, beside, is_level ? 0 : half);
  return is_near(glm::dvec3(glm::min(segment.start_m, segment.end_m), z.low) - margin,
                 glm::dvec3(glm::max(segment.start_m, segment.end_m), z.high) + margin);
}

// The box around all cuts, which are level across but for what their lanes' slopes make of their widths.
bool Trimmer::is_near_arms(const Junction& junction) const {
  glm::dvec3 low(1e300), high(-1e300);
  for (const JunctionArm& arm : junction.arms) {
    for (const double n : {arm.left_m, arm.right_m}) {
      const glm::dvec3 at(cut_point_m(arm, n), cut_height_m(arm, n));
      low = glm::min(low, at), high = glm::max(high, at);
    }
  }
  return is_near(low, high);
}

// Of the stations whose vault a point of a road's surface lies in. height_m: gives its height, where it is asked for.
template <class Height>
void Trimmer::pass(glm::dvec2 point_m, std::uint32_t road, double s_m, const Height& height_m) {
  const auto near = cells_.find(cell(column(point_m.x), column(point_m.y)));
  if (near == cells_.end() || near->second.is_own(road, s_m)) return;
  for (const std::uint32_t i : near->second.stations) {
    Station& station = stations_[i];
    if (!station.has_room || (station.road == road && std::abs(station.s_m - s_m) < kApart_m)) continue;
    const glm::dvec2 d = point_m - station.at_m;
    const double along = glm::dot(d, station.ahead), across = d.y * station.ahead.x - d.x * station.ahead.y;
    if (std::abs(along) > kStep_m || std::abs(across) > station.half_m - kBeside_m) continue;
    const double z = height_m();
    station.has_room = z < station.road_z + kBesideVault_m || z > station.crown_z + kOverVault_m;
  }
}

// Of the stations under a road whose middle crosses the tunnel, however low above its road.
void Trimmer::cross(glm::dvec2 at_m, glm::dvec2 aside, const Road& road, const Segment& segment, double local_m,
                    std::uint32_t index) {
  const double left = segment.left_m.value(local_m), right = segment.right_m.value(local_m);
  const glm::dvec2 at = at_m + 0.5 * (left + right) * aside;
  const auto near = cells_.find(cell(column(at.x), column(at.y)));
  if (near == cells_.end()) return;
  for (const std::uint32_t i : near->second.stations) {
    const Station& here = stations_[i];
    if (here.road == index || glm::length(at - here.at_m) > kStep_m) continue;
    const double over = pose_in(road, segment, local_m, 0.5 * (left + right)).position_m.z - here.road_z;
    const double sine = std::abs(glm::dot(aside, here.ahead));
    if (over < kCrossingVault_m || over >= kBesideVault_m || sine < kCrossingSine) continue;
    for (const std::uint32_t k : near->second.stations) {
      Station& station = stations_[k];
      const bool is_same = station.road == here.road && station.sweep == here.sweep;
      const double reach = 0.5 * (left - right) / sine + kStep_m;
      if (is_same && std::abs(station.s_m - here.s_m) <= reach) station.has_room = false;
    }
  }
}

void Trimmer::pass_road(std::uint32_t index) {
  const Road& road = network_.roads[index];
  for (const Segment& segment : road.segments) {
    if (!is_near(segment)) continue;
    const int count = std::max(1, static_cast<int>(std::ceil(segment.arc_m / kStep_m)));
    for (int n = 0; n <= count; ++n) {
      const double local = segment.arc_m * n / count, s = segment.s_start_m + local;
      const double u = segment.arc_m > 0 ? u_at_arc(segment, local) : 0, heading = heading_rad(segment, u);
      const glm::dvec2 at = position_m(segment, u), aside(-std::sin(heading), std::cos(heading));
      const double left = segment.left_m.value(local), right = segment.right_m.value(local);
      if (s > kEnd_m && s < road.length_m() - kEnd_m) cross(at, aside, road, segment, local, index);
      const int across = std::max(1, static_cast<int>(std::ceil((left - right) / kStep_m)));
      for (int k = 0; k <= across; ++k) {
        const double t = right + (left - right) * k / across;
        pass(at + t * aside, index, s, [&] { return pose_in(road, segment, local, t).position_m.z; });
      }
    }
  }
}

void Trimmer::pass_area(const Junction& junction) {
  const bool may_meet = std::any_of(junction.corners.begin(), junction.corners.end(), [&](const auto& corner) {
    return std::any_of(corner.begin(), corner.end(), [&](const Segment& segment) { return is_near(segment); });
  });
  if (!may_meet && !is_near_arms(junction)) return;
  const JunctionSurface surface = junction_pieces(junction);
  const glm::dvec2 low = glm::dvec2(surface.center_m + surface.low_m),
                   high = glm::dvec2(surface.center_m + surface.high_m);
  std::vector<std::uint32_t> near;
  for (std::int64_t x = column(low.x); x <= column(high.x); ++x) {
    for (std::int64_t y = column(low.y); y <= column(high.y); ++y) {
      const auto found = cells_.find(cell(x, y));
      if (found != cells_.end()) near.insert(near.end(), found->second.stations.begin(), found->second.stations.end());
    }
  }
  for (const std::uint32_t i : near) {
    Station& station = stations_[i];
    const bool is_own = std::any_of(junction.arms.begin(), junction.arms.end(), [&](const JunctionArm& arm) {
      return arm.road == network_.roads[station.road].id;
    });
    const double least = is_own ? kBesideVault_m : kCrossingVault_m;
    for (const double side : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
      const double across = side * (station.half_m - kBeside_m);
      const glm::dvec2 at = station.at_m + across * glm::dvec2(-station.ahead.y, station.ahead.x);
      if (!station.has_room || !is_inside(surface, at)) continue;
      const double z = height_m_at(surface, at);
      station.has_room = z < station.road_z + least || z > station.crown_z + kOverVault_m;
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
