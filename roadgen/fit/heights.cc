#include "roadgen/fit/heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>

#include <glm/geometric.hpp>

#include "roadgen/fit/divide.h"
#include "roadgen/fit/height_span.h"
#include "roadgen/fit/linear_fit.h"
#include "roadgen/fit/passings.h"
#include "roadgen/road/crossing.h"
#include "roadgen/road/off_ground.h"
#include "roadgen/road/vault_room.h"

namespace roadgen {
namespace {

constexpr double kLongest_m = 32;       // of a segment, for its profile
constexpr double kSample_m = 8;         // between samples of the ground
constexpr double kAreaReach_m = 12;     // of samples about an area's middle, for its slopes
constexpr double kTaper_m = 30;         // over which a road leans into an area
constexpr double kLevelling_m = 0.02;   // weight of grade^2, m: what nothing else decides is level
constexpr double kSameSpot_m = 0.05;    // ends of roads at one node
constexpr double kGreatestSlope = 0.2;  // of an area along x and y
constexpr double kOwnHeight = 1e-7;     // weight of the heights that roads had, lest anything be undecided
constexpr double kInside =
    1 - 0.8 * kLimitPart;  // limits for the fit, so that what is left of them is within kLimitPart
// Forces that bounds withstand, in metres of difference from the ground times metres of road: what passes over another road
// comes first, what a hill wants over a tunnel last.
constexpr double kPassingStrength = 1e6, kGradeStrength = 1e5, kCurvatureStrength = 1e5, kMeantStrength = 3e3,
                 kTunnelStrength = 100;
constexpr double kPortal_m = 5;   // within a tunnel, to where no hill is wanted over it
constexpr double kCover_m = 1.5;  // that is wanted from there on over the vault
constexpr double kNoBound = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNone = 0xffffffffu;

// Where roads' ends meet: a plane through it, whose height and slopes are unknowns.
struct Node {
  glm::dvec2 at_m{0, 0};
  std::uint32_t junction = kNone;  // whose area it is, if any
  std::uint32_t first = 0;         // of three unknowns
};

// A joint of a road.
struct Knot {
  std::uint32_t node = kNone;  // of an end that meets others; else
  std::uint32_t unknown = 0;   // of two: height and grade
  glm::dvec2 offset_m{0, 0};   // from the node
  glm::dvec2 tangent{1, 0};    // along the road
};

glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

// Of the outside of a tunnel's vault, above the road.
double vault_height_m(const Sweep& sweep) {
  const auto& tunnel = std::get<Tunnel>(sweep.shape);
  return tunnel.wall_height_m + tunnel.arch_rise_m + tunnel.lining_m;
}

// The tunnel that a road is in at s, if any.
const Sweep* tunnel_at(const Road& road, double s_m) {
  constexpr double kRounding_m = 1e-6;
  const auto found = std::find_if(road.sweeps.begin(), road.sweeps.end(), [&](const Sweep& sweep) {
    return sweep.kind() == SweepKind::kTunnel && sweep.s_start_m - kRounding_m <= s_m &&
           s_m <= sweep.s_end_m + kRounding_m;
  });
  return found == road.sweeps.end() ? nullptr : &*found;
}

bool is_level_across(const Road& road) {
  return std::all_of(road.segments.begin(), road.segments.end(), [](const Segment& s) {
    return s.superelevation_rad == Cubic{} && s.crossfall_left == Linear{} && s.crossfall_right == Linear{};
  });
}

class HeightFitter {
 public:
  HeightFitter(Network& network, const GroundHeight& ground, const HeightFitOptions& options, Diagnostics* diagnostics)
      : network_(network), ground_(ground), options_(options), diagnostics_(diagnostics) {}
  Result<HeightFitReport> run();

 private:
  HeightLimits limits_of(const Road& road) const {
    const HeightLimits of_class = height_limits(road.road_class);
    return {options_.max_grade.value_or(of_class.grade),
            options_.max_curvature_per_m.value_or(of_class.curvature_per_m)};
  }
  glm::dvec2 end_m(std::uint32_t road, bool at_end) const {
    const Road& r = network_.roads[road];
    return at_end ? r.segments.back().end_m : r.segments.front().start_m;
  }
  template <class HasArea, class Join>
  void join_linked(const HasArea& has_area, const Join& join) const;
  void find_nodes();
  void find_halls();
  double cover_m(std::uint32_t road, double s_m) const;
  void lay_knots();
  LinearSum sum_of(const Knot& knot, bool grade) const;
  HeightSpan span(std::uint32_t road, std::size_t segment) const;
  void add_roads(LinearFit& fit);
  void add_ground(LinearFit& fit, std::uint32_t road, const Segment& segment, const HeightSpan& span);
  void add_limits(LinearFit& fit, const Road& road, const HeightSpan& span) const;
  void add_areas(LinearFit& fit) const;
  LinearSum height_of(const HeightSpot& spot) const;
  void add_passings(LinearFit& fit) const;
  void take(const LinearFit& fit);
  void lean(const LinearFit& fit);
  void remake_areas();
  void make_room();
  void measure(const LinearFit& fit);
  void measure_limits();
  void tell(std::string message, std::string element) const {
    if (diagnostics_) diagnostics_->push_back({Severity::kWarning, std::move(message), {}, 0, std::move(element)});
  }

  Network& network_;
  const GroundHeight& ground_;
  const HeightFitOptions& options_;
  Diagnostics* diagnostics_;
  HeightFitReport report_;
  std::vector<bool> skip_;                             // roads along corners: they follow their areas
  std::vector<std::array<std::uint32_t, 2>> node_of_;  // [road]: of its start and its end
  std::vector<Node> nodes_;
  std::vector<double> vault_m_;  // [node]: height of its vaults where all that meets there is in tunnels, else 0
  std::vector<std::uint32_t> area_node_;  // [junction]
  std::vector<std::vector<Knot>> knots_;  // [road]
  std::vector<double> start_;             // of the unknowns
  std::vector<Passing> passings_;
  struct Sample {
    std::uint32_t road;
    double s_m, z_m;
    LinearSum sum;
  };
  std::vector<Sample> samples_;
};

// Calls join for ends (2 road + at_end) that are linked to one another, or to a node without an area and lie in the same
// place.
template <class HasArea, class Join>
void HeightFitter::join_linked(const HasArea& has_area, const Join& join) const {
  const RoadsById by_id = roads_by_id(network_);
  std::unordered_map<std::string_view, std::vector<std::uint32_t>> at_bare_node;
  for (std::uint32_t i = 0; i < network_.roads.size(); ++i) {
    const Road& road = network_.roads[i];
    if (skip_[i] || road.segments.empty() || road.closed) continue;
    for (const std::uint32_t end : {2 * i, 2 * i + 1}) {
      const RoadLink& link = end % 2 == 0 ? road.predecessor : road.successor;
      if (link.to == RoadLink::To::kRoad) {
        const auto found = by_id.find(link.id);
        if (found != by_id.end()) join(end, 2 * static_cast<std::uint32_t>(found->second) + link.at_end);
      } else if (link.to == RoadLink::To::kJunction && !has_area(link.id)) {
        std::vector<std::uint32_t>& others = at_bare_node[link.id];
        for (const std::uint32_t other : others) {
          if (glm::distance(end_m(i, end % 2), end_m(other / 2, other % 2)) < kSameSpot_m) join(end, other);
        }
        others.push_back(end);
      }
    }
  }
}

// Ends of roads that meet, by union and find over ends 2 road + at_end and, after those, junctions.
void HeightFitter::find_nodes() {
  const auto roads = static_cast<std::uint32_t>(network_.roads.size());
  std::vector<std::uint32_t> parent(2 * roads + network_.junctions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto join = [&](std::uint32_t a, std::uint32_t b) { parent[root(a)] = root(b); };
  const RoadsById by_id = roads_by_id(network_);
  std::unordered_map<std::string_view, std::uint32_t> area_of;
  for (std::uint32_t j = 0; j < network_.junctions.size(); ++j) {
    area_of.emplace(network_.junctions[j].id, j);
    for (const JunctionArm& arm : network_.junctions[j].arms) {
      const auto found = by_id.find(arm.road);
      if (found == by_id.end()) continue;
      join(2 * static_cast<std::uint32_t>(found->second) + arm.at_end, 2 * roads + j);
    }
  }
  join_linked([&](const std::string& id) { return area_of.contains(id); }, join);
  std::vector<std::uint32_t> members(parent.size(), 0), node_at(parent.size(), kNone);
  for (std::uint32_t i = 0; i < parent.size(); ++i) ++members[root(i)];
  const auto node = [&](std::uint32_t i) {
    std::uint32_t& at = node_at[root(i)];
    if (at == kNone && members[root(i)] > 1) {
      at = static_cast<std::uint32_t>(nodes_.size());
      nodes_.emplace_back();
    }
    return at;
  };
  node_of_.assign(roads, {kNone, kNone});
  for (std::uint32_t i = 0; i < roads; ++i) {
    if (skip_[i] || network_.roads[i].segments.empty()) continue;
    for (const bool at_end : {false, true}) {
      const std::uint32_t n = node_of_[i][at_end] = node(2 * i + at_end);
      if (n != kNone) nodes_[n].at_m = end_m(i, at_end);
    }
  }
  area_node_.assign(network_.junctions.size(), kNone);
  for (std::uint32_t j = 0; j < network_.junctions.size(); ++j) {
    const std::uint32_t n = area_node_[j] = node(2 * roads + j);
    if (n == kNone) continue;
    nodes_[n].junction = j;
    nodes_[n].at_m = glm::dvec2(junction_pieces(network_.junctions[j]).center_m);
  }
}

// Where tunnels go on as tunnels there is no portal.
void HeightFitter::find_halls() {
  constexpr double kOpen = -1;
  vault_m_.assign(nodes_.size(), 0);
  for (std::uint32_t i = 0; i < network_.roads.size(); ++i) {
    for (const bool at_end : {false, true}) {
      const std::uint32_t n = node_of_[i][at_end];
      if (n == kNone) continue;
      const Sweep* tunnel = tunnel_at(network_.roads[i], at_end ? network_.roads[i].length_m() : 0);
      if (!tunnel) vault_m_[n] = kOpen;
      if (vault_m_[n] != kOpen) vault_m_[n] = std::max(vault_m_[n], vault_height_m(*tunnel));
    }
  }
  for (double& vault : vault_m_) vault = std::max(vault, 0.0);
}

// What a tunnel at s wants above its road, vault and cover, if it is well inside one; else 0.
double HeightFitter::cover_m(std::uint32_t i, double s_m) const {
  const Road& road = network_.roads[i];
  const Sweep* sweep = tunnel_at(road, s_m);
  if (!sweep) return 0;
  const auto goes_on = [&](bool at_end) {
    const std::uint32_t n = node_of_[i][at_end];
    const double s = at_end ? road.length_m() : 0;
    return n != kNone && vault_m_[n] > 0 && tunnel_at(road, s) == sweep;
  };
  if (s_m < sweep->s_start_m + kPortal_m && !goes_on(false)) return 0;
  if (s_m > sweep->s_end_m - kPortal_m && !goes_on(true)) return 0;
  return vault_height_m(*sweep) + kCover_m;
}

void HeightFitter::lay_knots() {
  knots_.resize(network_.roads.size());
  for (Node& node : nodes_) {
    node.first = static_cast<std::uint32_t>(start_.size());
    start_.insert(start_.end(), 3, 0.0);
  }
  for (std::uint32_t i = 0; i < knots_.size(); ++i) {
    const Road& road = network_.roads[i];
    if (skip_[i] || road.segments.empty()) continue;
    const std::size_t n = road.segments.size();
    for (std::size_t k = 0; k <= n; ++k) {
      if (k == n && road.closed) {
        knots_[i].push_back(knots_[i].front());
        break;
      }
      const Segment& segment = road.segments[std::min(k, n - 1)];
      const double u = k < n ? 0 : 1;
      const double z = segment.elevation_m.value(k < n ? 0 : segment.arc_m);
      Knot knot;
      knot.tangent = direction(heading_rad(segment, u));
      knot.node = k == 0 ? node_of_[i][0] : k == n ? node_of_[i][1] : kNone;
      if (knot.node != kNone) {
        knot.offset_m = position_m(segment, u) - nodes_[knot.node].at_m;
        start_[nodes_[knot.node].first] = z;
      } else {
        knot.unknown = static_cast<std::uint32_t>(start_.size());
        start_.insert(start_.end(), {z, 0.0});
      }
      knots_[i].push_back(knot);
    }
  }
}

LinearSum HeightFitter::sum_of(const Knot& knot, bool grade) const {
  LinearSum sum;
  if (knot.node == kNone) {
    sum.add(knot.unknown + grade, 1);
    return sum;
  }
  const std::uint32_t first = nodes_[knot.node].first;
  const glm::dvec2 by = grade ? knot.tangent : knot.offset_m;
  if (!grade) sum.add(first, 1);
  sum.add(first + 1, by.x);
  sum.add(first + 2, by.y);
  return sum;
}

HeightSpan HeightFitter::span(std::uint32_t road, std::size_t segment) const {
  const Knot &a = knots_[road][segment], &b = knots_[road][segment + 1];
  return {sum_of(a, false), sum_of(a, true), sum_of(b, false), sum_of(b, true),
          network_.roads[road].segments[segment].arc_m};
}

void HeightFitter::add_ground(LinearFit& fit, std::uint32_t road, const Segment& segment, const HeightSpan& span) {
  const int count = std::max(1, static_cast<int>(std::ceil(segment.arc_m / kSample_m)));
  for (int k = 0; k < count; ++k) {
    const double s = segment.arc_m * (k + 0.5) / count;
    const double cover = cover_m(road, segment.s_start_m + s);
    if (cover == 0 && is_off_ground(network_.roads[road], segment.s_start_m + s)) continue;
    const std::optional<double> z = ground_(position_m(segment, u_at_arc(segment, s)));
    if (cover > 0) {
      if (z) fit.bound(span.z_at(s), -kNoBound, *z - cover, 0.01, kTunnelStrength);
      continue;
    }
    if (!z) {
      ++report_.samples_missing;
      continue;
    }
    samples_.push_back({road, segment.s_start_m + s, *z, span.z_at(s)});
    fit.wish(samples_.back().sum, *z, segment.arc_m / count, options_.doubt_m);
  }
}

void HeightFitter::add_limits(LinearFit& fit, const Road& road, const HeightSpan& span) const {
  const HeightLimits limits = limits_of(road);
  for (const LinearSum& grade : {span.g0, span.middle_grade(), span.g1}) {
    const double most = kInside * limits.grade;
    fit.bound(grade, -most, most, 0.2 * kLimitPart * most, kGradeStrength);
  }
  for (const int end : {0, 1}) {
    const double most = kInside * limits.curvature_per_m;
    fit.bound(span.bend_at(end), -most, most, 0.2 * kLimitPart * most, kCurvatureStrength);
  }
}

void HeightFitter::add_roads(LinearFit& fit) {
  const double stiffness = std::pow(options_.smoothing_m, 4);
  for (std::uint32_t i = 0; i < knots_.size(); ++i) {
    const Road& road = network_.roads[i];
    for (std::size_t k = 0; k + 1 < knots_[i].size(); ++k) {
      const Segment& segment = road.segments[k];
      const HeightSpan s = span(i, k);
      add_ground(fit, i, segment, s);
      // The integral of z''^2, which is linear: h (mean^2 + difference^2 / 12).
      LinearSum mean = s.bend_at(0), difference = s.bend_at(0);
      mean.add(s.bend_at(1), 1);
      difference.add(s.bend_at(1), -1);
      fit.wish(mean, 0, 0.25 * stiffness * segment.arc_m);
      fit.wish(difference, 0, stiffness * segment.arc_m / 12);
      LinearSum rise = s.z1;
      rise.add(s.z0, -1);
      fit.wish(rise, 0, kLevelling_m / segment.arc_m);
      fit.wish(s.z0, segment.elevation_m.c0, kOwnHeight);
      add_limits(fit, road, s);
    }
    if (!knots_[i].empty()) fit.wish(sum_of(knots_[i].back(), false), 0, kOwnHeight);
  }
}

// An area lies on the ground like its arms, or under it like those.
void HeightFitter::add_areas(LinearFit& fit) const {
  std::vector<char> on_ground(nodes_.size(), 0);
  for (std::uint32_t i = 0; i < knots_.size(); ++i) {
    if (knots_[i].empty()) continue;
    const Road& road = network_.roads[i];
    for (const bool at_end : {false, true}) {
      const std::uint32_t n = node_of_[i][at_end];
      if (n != kNone && !is_off_ground(road, at_end ? road.length_m() : 0)) on_ground[n] = 1;
    }
  }
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Node& node = nodes_[n];
    for (const std::uint32_t slope : {node.first + 1, node.first + 2}) {
      LinearSum sum;
      sum.add(slope, 1);
      fit.wish(sum, 0, 1e-2);
      fit.bound(sum, -kGreatestSlope, kGreatestSlope, 1e-4, kGradeStrength);
    }
    if (node.junction == kNone || (!on_ground[n] && vault_m_[n] == 0)) continue;
    for (const glm::dvec2 d :
         {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(-1, 0), glm::dvec2(0, 1), glm::dvec2(0, -1)}) {
      const glm::dvec2 offset = kAreaReach_m * d;
      const std::optional<double> z = ground_(node.at_m + offset);
      if (!z) continue;
      LinearSum sum;
      sum.add(node.first, 1);
      sum.add(node.first + 1, offset.x);
      sum.add(node.first + 2, offset.y);
      if (on_ground[n]) {
        fit.wish(sum, *z, 0.4 * kAreaReach_m, options_.doubt_m);
      } else {
        fit.bound(sum, -kNoBound, *z - vault_m_[n] - kCover_m, 0.01, kTunnelStrength);
      }
    }
  }
}

LinearSum HeightFitter::height_of(const HeightSpot& spot) const {
  if (!spot.is_area) {
    const Road& road = network_.roads[spot.index];
    const std::size_t k = segment_at(road, spot.s_m);
    const Segment& segment = road.segments[k];
    return span(spot.index, k).z_at(std::clamp(spot.s_m - segment.s_start_m, 0.0, segment.arc_m));
  }
  LinearSum sum;
  const std::uint32_t n = area_node_[spot.index];
  if (n == kNone) return sum;
  const glm::dvec2 offset = spot.at_m - nodes_[n].at_m;
  sum.add(nodes_[n].first, 1);
  sum.add(nodes_[n].first + 1, offset.x);
  sum.add(nodes_[n].first + 2, offset.y);
  return sum;
}

void HeightFitter::add_passings(LinearFit& fit) const {
  for (const Passing& passing : passings_) {
    LinearSum above = height_of(passing.upper);
    above.add(height_of(passing.lower), -1);
    fit.bound(above, std::min(passing.above_m, options_.clearance_m), kNoBound, 0.01, kPassingStrength);
    if (passing.is_meant && passing.above_m < options_.clearance_m) {
      fit.bound(above, options_.clearance_m, kNoBound, 0.01, kMeantStrength);
    }
  }
}

void HeightFitter::take(const LinearFit& fit) {
  for (std::uint32_t i = 0; i < knots_.size(); ++i) {
    for (std::size_t k = 0; k + 1 < knots_[i].size(); ++k) {
      Segment& segment = network_.roads[i].segments[k];
      const HeightSpan s = span(i, k);
      segment.elevation_m =
          Cubic::hermite(fit.value(s.z0), fit.value(s.g0), fit.value(s.z1), fit.value(s.g1), segment.arc_m);
    }
  }
}

// Superelevation at the ends that meet areas, so that the road lies in their planes.
void HeightFitter::lean(const LinearFit& fit) {
  for (std::uint32_t i = 0; i < knots_.size(); ++i) {
    Road& road = network_.roads[i];
    if (knots_[i].empty() || road.closed || !is_level_across(road)) continue;
    std::array<double, 2> tilt_rad{0, 0};
    for (const bool at_end : {false, true}) {
      const Knot& knot = at_end ? knots_[i].back() : knots_[i].front();
      if (knot.node == kNone || nodes_[knot.node].junction == kNone) continue;
      const std::uint32_t first = nodes_[knot.node].first;
      tilt_rad[at_end] =
          std::atan(-knot.tangent.y * fit.unknowns()[first + 1] + knot.tangent.x * fit.unknowns()[first + 2]);
    }
    if (tilt_rad[0] == 0 && tilt_rad[1] == 0) continue;
    const double length = road.length_m(), taper = std::min(kTaper_m, length);
    // Value and slope at s; smoothstep from either end.
    const auto at = [&](double s) {
      std::array<double, 2> found{0, 0};
      for (const int end : {0, 1}) {
        const double x = std::clamp(1 - (end == 0 ? s : length - s) / taper, 0.0, 1.0);
        found[0] += tilt_rad[end] * x * x * (3 - 2 * x);
        found[1] += tilt_rad[end] * 6 * x * (1 - x) * (end == 0 ? -1 : 1) / taper;
      }
      return found;
    };
    for (Segment& segment : road.segments) {
      const auto a = at(segment.s_start_m), b = at(segment.s_start_m + segment.arc_m);
      segment.superelevation_rad = Cubic::hermite(a[0], a[1], b[0], b[1], segment.arc_m);
    }
  }
}

// The same areas at their arms' new heights, and the roads along their corners.
void HeightFitter::remake_areas() {
  const RoadsById by_id = roads_by_id(network_);
  std::vector<Road> corners;
  std::vector<std::string> gone;
  for (std::uint32_t j = 0; j < network_.junctions.size(); ++j) {
    Junction& junction = network_.junctions[j];
    std::vector<EndOfRoad> ends;
    for (const JunctionArm& arm : junction.arms) {
      const auto found = by_id.find(arm.road);
      if (found != by_id.end()) ends.push_back({&network_.roads[found->second], arm.at_end});
    }
    if (ends.size() != junction.arms.size()) continue;
    Result<Crossing> made = make_crossing(junction.id, ends, {.corner_radius_m = junction.corner_radius_m});
    if (!made) {
      tell("its area cannot be made at the new heights and keeps its old ones: " + made.error().message,
           "junction " + junction.id);
      continue;
    }
    junction = std::move(made->junction);
    gone.push_back(junction.id);
    std::move(made->corners.begin(), made->corners.end(), std::back_inserter(corners));
  }
  std::sort(gone.begin(), gone.end());
  std::vector<bool> of_corners = corner_roads(network_);
  std::size_t at = 0;
  std::erase_if(network_.roads, [&](const Road& road) {
    if (!of_corners[at++]) return false;
    return std::binary_search(gone.begin(), gone.end(), road.id.substr(0, road.id.rfind(".corner.")));
  });
  std::move(corners.begin(), corners.end(), std::back_inserter(network_.roads));
}

// Vaults end where roads pass through them at the new heights.
void HeightFitter::make_room() {
  for (const VaultGap& gap : trim_vaults(network_)) {
    char text[96];
    std::snprintf(text, sizeof text, "no room for its vault from s = %.1f m to %.1f m, where a road passes above",
                  gap.s_start_m, gap.s_end_m);
    tell(text, "road " + network_.roads[gap.road].id);
  }
}

void HeightFitter::measure(const LinearFit& fit) {
  double squares = 0, sum = 0;
  report_.samples = samples_.size();
  for (const Sample& sample : samples_) {
    const double above = fit.value(sample.sum) - sample.z_m;
    squares += above * above;
    sum += std::abs(above);
    const AtRoad at{network_.roads[sample.road].id, sample.s_m};
    if (above > report_.highest_fill_m) report_.highest_fill_m = above, report_.highest_fill_at = at;
    if (-above > report_.deepest_cut_m) report_.deepest_cut_m = -above, report_.deepest_cut_at = at;
  }
  const double count = static_cast<double>(std::max<std::size_t>(samples_.size(), 1));
  report_.rms_m = std::sqrt(squares / count);
  report_.mean_abs_m = sum / count;
  double least = std::numeric_limits<double>::infinity();
  for (const Passing& passing : passings_) {
    if (!passing.is_middle) continue;
    ++report_.passings;
    const double above = fit.value(height_of(passing.upper)) - fit.value(height_of(passing.lower));
    const double due = std::min(passing.above_m, options_.clearance_m);
    least = std::min(least, above);
    if (above >= due - kShortPassing_m) continue;
    ++report_.passings_short;
    const auto name = [&](const HeightSpot& spot) {
      return spot.is_area ? "junction " + network_.junctions[spot.index].id : "road " + network_.roads[spot.index].id;
    };
    char text[160];
    std::snprintf(text, sizeof text, " by %.2f m, not %.2f m, at (%.1f, %.1f) m", above, due, passing.upper.at_m.x,
                  passing.upper.at_m.y);
    tell("passes over " + name(passing.lower) + text, name(passing.upper));
  }
  report_.least_passing_m = report_.passings > 0 ? least : 0;
}

void HeightFitter::measure_limits() {
  for (std::uint32_t i = 0; i < knots_.size(); ++i) {
    const Road& road = network_.roads[i];
    if (knots_[i].empty()) continue;
    ++report_.roads;
    double grade = 0, bend = 0, grade_at = 0, bend_at = 0;
    for (const Segment& segment : road.segments) {
      const Cubic& z = segment.elevation_m;
      const auto look = [&](double s) {
        if (std::abs(z.slope(s)) > grade) grade = std::abs(z.slope(s)), grade_at = segment.s_start_m + s;
      };
      look(0);
      look(segment.arc_m);
      if (z.c3 != 0) look(std::clamp(-z.c2 / (3 * z.c3), 0.0, segment.arc_m));  // where the grade is extreme
      for (const double s : {0.0, segment.arc_m}) {
        if (std::abs(z.second(s)) > bend) bend = std::abs(z.second(s)), bend_at = segment.s_start_m + s;
      }
    }
    if (grade > report_.max_grade) report_.max_grade = grade, report_.max_grade_at = {road.id, grade_at};
    if (bend > report_.max_curvature_per_m) {
      report_.max_curvature_per_m = bend;
      report_.max_curvature_at = {road.id, bend_at};
    }
    const HeightLimits limits = limits_of(road);
    char text[200];
    if (grade > (1 + kLimitPart) * limits.grade) {
      ++report_.over_grade;
      std::snprintf(text, sizeof text,
                    "grade of %.1f %% at s = %.1f m: no profile of at most %.1f %% meets its junctions", 100 * grade,
                    grade_at, 100 * limits.grade);
      tell(text, "road " + road.id);
    }
    if (bend > (1 + kLimitPart) * limits.curvature_per_m) {
      ++report_.over_curvature;
      std::snprintf(text, sizeof text,
                    "vertical radius of %.0f m at s = %.1f m: no profile of at least %.0f m meets its junctions",
                    1 / bend, bend_at, 1 / limits.curvature_per_m);
      tell(text, "road " + road.id);
    }
  }
}

Result<HeightFitReport> HeightFitter::run() {
  skip_ = corner_roads(network_);
  for (std::size_t i = 0; i < network_.roads.size(); ++i) {
    if (!skip_[i]) divide_segments(network_.roads[i], kLongest_m);
  }
  passings_ = find_passings(network_, skip_);
  find_nodes();
  find_halls();
  lay_knots();
  LinearFit fit(start_);
  add_roads(fit);
  if (samples_.empty()) return Error{ErrorCode::kData, "the ground's height is known under no road"};
  add_areas(fit);
  add_passings(fit);
  fit.solve();
  take(fit);
  measure(fit);
  measure_limits();
  lean(fit);
  remake_areas();
  make_room();
  return report_;
}

}  // namespace

Result<HeightFitReport> fit_heights(Network& network, const GroundHeight& ground, const HeightFitOptions& options,
                                    Diagnostics* diagnostics) {
  const auto usage = [](const char* message) { return Error{ErrorCode::kUsage, message}; };
  if (network.segment_count() == 0) return Error{ErrorCode::kData, "the network has no roads to give heights to"};
  if (!(options.max_grade.value_or(1) > 0)) return usage("the greatest grade must be positive");
  if (!(options.max_curvature_per_m.value_or(1) > 0)) return usage("the greatest vertical curvature must be positive");
  if (!(options.smoothing_m > 0 && options.doubt_m > 0 && options.clearance_m >= 0)) {
    return usage("smoothing and doubt of the heights must be positive, the clearance not negative");
  }
  return HeightFitter(network, ground, options, diagnostics).run();
}

}  // namespace roadgen
