#include "terrain/terrain.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <numbers>
#include <set>
#include <unordered_map>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "roadgen/road/parallel.h"
#include "terrain/bisection.h"
#include "terrain/detail.h"
#include "terrain/plates.h"
#include "terrain/terrain_impl.h"

namespace roadgen {
namespace {

constexpr double kTileSide_m = 1024;
constexpr int kMostTiles = 48;           // each way; larger worlds get larger tiles
constexpr int kMostNaturalPosts = 2048;  // each way
constexpr int kMostRetries = 6;
constexpr double kRetryFactor = 1.6;
constexpr double kMostRaisedSpacing_m = 4;
constexpr int kMostRounds = 8;  // of dividing what would be too deep
constexpr int kMostFiner = 3;   // divisions of posts between roads at different heights
constexpr int kMostFinerAtOverlaps = 2;
constexpr double kFinestPost_m = 0.2;    // unless they are asked for
constexpr double kDitchTolerance = 0.2;  // of a ditch's depth: what the mesh may deviate there
constexpr double kFinestDitch_m = 0.5;   // legs of triangles that are not divided to show a ditch better
constexpr double kNotLevelled_m = 0.25;  // below a road by more than this and the gap, the ground is another road's
// Far from the roads no leg is longer than this, lest a sampled error miss a whole mountain.
constexpr double kLegAtRoad_m = 8, kLegPerMetre = 0.12;

double quantised(double x, double quantum) { return std::round(x / quantum) * quantum; }

Error usage(const char* message) { return Error{ErrorCode::kUsage, message}; }

}  // namespace

namespace {

// Raises the post spacing where the carriageways alone would take more than half of the triangles.
double raised_spacing_m(const Network& network, const TerrainOptions& options) {
  const auto triangles = [&](double spacing_m) {
    double area = 0;
    for (const Road& road : network.roads) {
      for (const Segment& s : road.segments) area += s.arc_m * 2 * (s.max_half_width_m() + spacing_m);
    }
    return 2 * area / (spacing_m * spacing_m);
  };
  double spacing = options.spacing_m;
  while (spacing < kMostRaisedSpacing_m && triangles(spacing) > 0.5 * static_cast<double>(options.max_triangles)) {
    spacing = std::min(1.1 * spacing, kMostRaisedSpacing_m);
  }
  return spacing;
}

}  // namespace

// Chooses area, tiles and lattice: tiles of 0.5 to 1 km, whole in number along the longer side.
void Terrain::Impl::lay_out(const Network& network, const Elevation* elevation) {
  options.spacing_m = raised_spacing_m(network, options);
  const Bounds roads = bounds(network);
  // Never less than the embankments need.
  const double least = options.levelling.reach_m + options.levelling.shoulder_m + 2 * options.spacing_m;
  Rectangle area{glm::dvec2(roads.low_m) - std::max(options.margin_m, least),
                 glm::dvec2(roads.high_m) + std::max(options.margin_m, least)};
  if (elevation != nullptr) {
    const Rectangle covered = covered_rectangle(*elevation, network);
    area.low_m = glm::max(area.low_m, glm::min(covered.low_m, glm::dvec2(roads.low_m) - least));
    area.high_m = glm::min(area.high_m, glm::max(covered.high_m, glm::dvec2(roads.high_m) + least));
  }
  const glm::dvec2 size = area.high_m - area.low_m;
  const double longer = std::max(size.x, size.y), shorter = std::min(size.x, size.y);
  const double wished = shorter > kTileSide_m ? std::max(longer / kMostTiles, kTileSide_m) : kTileSide_m;
  // A few more tiles than needed, where the shorter side then comes out in whole tiles and the posts as far apart as
  // they may be.
  const int fewest = std::max(1, static_cast<int>(std::ceil(longer / wished)));
  const auto levels = [&](int n) {
    return std::clamp(static_cast<int>(std::ceil(std::log2(longer / n / options.spacing_m))), 1, 14);
  };
  const auto waste = [&](int n) {
    const double side = longer / n;
    return (std::ceil(shorter / side) * side - shorter) / longer + 1 - side / (1 << levels(n)) / options.spacing_m;
  };
  int many = fewest;
  for (int n = fewest + 1; n <= 2 * fewest; ++n) {
    if (waste(n) < waste(many)) many = n;
  }
  k = levels(many);
  finer = std::clamp(static_cast<int>(std::log2(options.spacing_m / kFinestPost_m)), 0, std::min(kMostFiner, 14 - k));
  k += finer;
  unit_m = std::max(std::ceil(longer / many / (1 << k) / kQuantum_m) * kQuantum_m, kQuantum_m);
  const double side = unit_m * (1 << k);
  tile_count = glm::ivec2(glm::max(glm::ceil(size / side - 1e-9), glm::dvec2(1)));
  const glm::dvec2 middle = 0.5 * (area.low_m + area.high_m);
  origin_m = glm::dvec2(quantised(middle.x - 0.5 * side * tile_count.x, kQuantum_m),
                        quantised(middle.y - 0.5 * side * tile_count.y, kQuantum_m));
  report.area = {origin_m, origin_m + side * glm::dvec2(tile_count)};
  report.spacing_m = post_m();
  report.finest_spacing_m = unit_m;
  options.levelling.shoulder_m = std::max(options.levelling.shoulder_m, 1.5 * post_m());
}

Grid Terrain::Impl::natural_ground(const Network& network, const Elevation* elevation) const {
  const glm::dvec2 size = report.area.high_m - report.area.low_m;
  const double finest = std::max({size.x / kMostNaturalPosts, size.y / kMostNaturalPosts, post_m()});
  if (elevation == nullptr) return natural_from_roads(network, report.area, std::max(finest, 12.0), options.rolling_m);
  const double spacing = std::max(finest, 0.6 * elevation->post_spacing_m());
  return natural_from_elevation(*elevation, network, report.area, spacing);
}

std::array<glm::dvec3, 3> Terrain::Impl::corners(const Bisection::Triangle& t) const {
  const auto corner = [&](std::uint32_t v) {
    return glm::dvec3(to_world(glm::dvec2(mesh->lattice(v))), mesh->height(v));
  };
  return {corner(t.apex), corner(t.left), corner(t.right)};
}

// Two carriageways above one another so near a triangle that it cannot suit both.
std::optional<Overlap> Terrain::Impl::overlap(const Plates& roads, const Bisection::Triangle& t) const {
  return roads.overlap(corners(t), std::numbers::sqrt2 * std::ldexp(post_m(), -std::min(kMostFinerAtOverlaps, finer)));
}

// Where carriageways overlap, triangles that are too deep are divided until few are, and no further.
bool Terrain::Impl::may_divide(const Bisection::Triangle& t, const std::optional<Overlap>& overlap) const {
  return t.level < mesh->finest() - (overlap ? 2 * (finer - std::min(kMostFinerAtOverlaps, finer)) : 0);
}

// Whether a triangle is too coarse: under a carriageway it could not be low enough everywhere and nowhere too low, or it
// has long legs, or deviates from the ground. Those finer than the posts' spacing only where smaller ones help between roads
// at different heights, or show a ditch.
bool Terrain::Impl::is_wanted(const KnownHeights& ground, const Plates& roads, const Bisection::Triangle& t,
                              double factor) const {
  const LevellingOptions& l = options.levelling;
  const glm::dvec2 left(mesh->lattice(t.left)), right(mesh->lattice(t.right)), apex(mesh->lattice(t.apex));
  const glm::dvec2 middle = 0.5 * (left + right);  // of the circle around a right triangle
  const double radius = 0.5 * glm::length(right - left) * unit_m;
  const double leg = std::numbers::sqrt2 * radius;
  const double edge = ground.ground().edge_distance_m(to_world(middle), radius + 4 * post_m()) - radius;
  const bool finer_one = is_finer(t);
  if (!finer_one && leg > factor * (kLegAtRoad_m + kLegPerMetre * std::max(edge, 0.0))) return true;
  if (edge <= 0) {
    const ClearanceBounds clearance = roads.over(corners(t));
    if (clearance.most_m - clearance.least_m > options.most_clearance_m - options.least_clearance_m) {
      return may_divide(t, !finer_one ? std::nullopt : overlap(roads, t));
    }
  }
  const double ditch =
      l.ditch_depth_m > 0 && edge < l.shoulder_m + l.ditch_width_m() && edge + 2 * radius > l.shoulder_m
          ? kDitchTolerance * l.ditch_depth_m
          : std::numeric_limits<double>::infinity();
  if (finer_one && (std::isinf(ditch) || leg <= factor * kFinestDitch_m)) return false;

  const double tolerance =
      factor * std::min(options.tolerance_m + options.tolerance_per_m * std::max(edge, 0.0), ditch);
  const auto misses = [&](double to_left, double to_right) {
    const double plane = mesh->height(t.apex) + to_left * (mesh->height(t.left) - mesh->height(t.apex)) +
                         to_right * (mesh->height(t.right) - mesh->height(t.apex));
    const glm::dvec2 p = apex + to_left * (left - apex) + to_right * (right - apex);
    return std::abs(height_m(ground, p) - plane) > tolerance;
  };
  return misses(0.5, 0.5) || misses(0.5, 0) || misses(0, 0.5) ||
         (t.level < mesh->finest() - 2 * finer - 3 && misses(0.25, 0.25));
}

void Terrain::Impl::triangulate(const KnownHeights& ground, const Plates& roads) {
  const auto height = [&](glm::ivec2 p) { return quantised(height_m(ground, glm::dvec2(p)), kQuantum_m); };
  double factor = 1;
  for (int attempt = 0;; ++attempt, factor *= kRetryFactor) {
    mesh = std::make_unique<Bisection>(tile_count, k, height);
    const std::size_t most = attempt < kMostRetries ? options.max_triangles : SIZE_MAX;
    if (mesh->refine([&](const Bisection::Triangle& t) { return is_wanted(ground, roads, t, factor); }, most)) break;
  }
  report.tolerance_factor = factor;
}

// Of the leaves at the heights that were aimed at. Those of before are known.
void Terrain::Impl::bound_clearances(const Plates& roads, std::vector<ClearanceBounds>& aimed) const {
  const std::size_t known = aimed.size();
  aimed.resize(mesh->triangle_count());
  for_each_index(aimed.size() - known, [&](std::size_t i) {
    const auto leaf = static_cast<std::int32_t>(known + i);
    if (mesh->child(leaf) < 0) aimed[known + i] = roads.over(corners(mesh->triangle(leaf)));
  });
}

// Lowers every triangle whose proven clearance is too small, and returns the vertices' lowering. That takes clearance away
// nowhere, so one pass is enough.
std::vector<double> Terrain::Impl::lower(const std::vector<ClearanceBounds>& aimed) {
  report.triangles_lowered = 0;
  report.lowered_max_m = 0;
  std::vector<double> by(mesh->vertices(), 0);
  mesh->each_leaf([&](std::int32_t leaf) {
    const double lacking = options.least_clearance_m - aimed[static_cast<std::size_t>(leaf)].least_m;
    if (lacking <= 0) return;
    const double drop = std::ceil(lacking / kQuantum_m) * kQuantum_m;
    const Bisection::Triangle& t = mesh->triangle(leaf);
    for (const std::uint32_t vertex : {t.apex, t.left, t.right}) by[vertex] = std::max(by[vertex], drop);
    ++report.triangles_lowered;
    report.lowered_max_m = std::max(report.lowered_max_m, drop);
  });
  for (std::uint32_t v = 0; v < by.size(); ++v) mesh->set_height(v, mesh->height(v) - by[v]);
  return by;
}

// Reports the bounds of the clearance, and returns the triangles that lie too deep and may be divided.
std::vector<std::int32_t> Terrain::Impl::prove(const Plates& roads, const std::vector<ClearanceBounds>& aimed,
                                               const std::vector<double>& lowered) {
  report.clearance_min_m = std::numeric_limits<double>::infinity();
  report.clearance_max_m = -report.clearance_min_m;
  report.triangles_under_roads = 0;
  double under = 0, deep = 0, by_overlap = 0;  // areas in units of the smallest triangle's
  report.triangles_too_deep = report.triangles_too_deep_by_overlap = 0;
  std::vector<Overlap> overlaps;
  std::vector<std::int32_t> divisible;
  std::vector<std::int32_t> leaves;  // under roads
  mesh->each_leaf([&](std::int32_t leaf) {
    if (aimed[static_cast<std::size_t>(leaf)].touches()) leaves.push_back(leaf);
  });
  std::vector<ClearanceBounds> bounds(leaves.size());
  for_each_index(leaves.size(), [&](std::size_t i) {
    const Bisection::Triangle& t = mesh->triangle(leaves[i]);
    const bool is_aimed = lowered[t.apex] == 0 && lowered[t.left] == 0 && lowered[t.right] == 0;
    bounds[i] = is_aimed ? aimed[static_cast<std::size_t>(leaves[i])] : roads.over(corners(t));
  });
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const ClearanceBounds& clearance = bounds[i];
    const Bisection::Triangle& t = mesh->triangle(leaves[i]);
    const double area = std::exp2(mesh->finest() - t.level);
    ++report.triangles_under_roads;
    under += area;
    report.clearance_min_m = std::min(report.clearance_min_m, clearance.least_m);
    if (clearance.most_m > report.clearance_max_m) {
      report.clearance_max_m = clearance.most_m;
      report.clearance_max_at_m = corners(t)[0];
    }
    if (clearance.most_m <= options.most_clearance_m) continue;
    ++report.triangles_too_deep;
    deep += area;
    const std::optional<Overlap> found = overlap(roads, t);
    if (found) {
      ++report.triangles_too_deep_by_overlap;
      by_overlap += area;
      overlaps.push_back(*found);
    }
    if (may_divide(t, found)) divisible.push_back(leaves[i]);
  }
  report.too_deep = under > 0 ? deep / under : 0;
  report.too_deep_by_overlap = under > 0 ? by_overlap / under : 0;
  tell_overlaps(roads, std::move(overlaps));
  return divisible;
}

// Adds the carriageways over others, and keeps of places near one another the worst.
void Terrain::Impl::tell_overlaps(const Plates& roads, std::vector<Overlap> found) {
  report.over_others_m2 = 0;
  const HeightMesh ground(*mesh, kQuantum_m);
  for (const Plate& plate : roads.all()) {
    if (!plate.on_ground || plate.levelled) continue;
    report.over_others_m2 += 4 * plate.half_m.x * plate.half_m.y;
    if (const auto overlap = roads.overlap(plate, options.levelling.shoulder_m)) found.push_back(*overlap);
  }
  std::sort(found.begin(), found.end(), [](const Overlap& a, const Overlap& b) { return a.apart_m > b.apart_m; });
  std::vector<Overlap> places;
  for (const Overlap& overlap : found) {
    const auto is_near = [&](const Overlap& p) {
      return glm::length(p.at_m - overlap.at_m) <= TerrainReport::kOverlapPlaces_m;
    };
    if (std::none_of(places.begin(), places.end(), is_near)) places.push_back(overlap);
  }
  report.overlap_places = places.size();
  report.overlaps = {};
  std::copy_n(places.begin(), std::min(places.size(), report.overlaps.size()), report.overlaps.begin());
}

// Vertices are shared: what is lowered for one triangle may make another too deep, which is then divided, and all begins
// again from the levelled ground.
void Terrain::Impl::guarantee(const Plates& roads) {
  std::vector<ClearanceBounds> aimed;
  for (int round = 0;; ++round) {
    bound_clearances(roads, aimed);
    const std::vector<double> lowered = lower(aimed);
    const std::vector<std::int32_t> deep = prove(roads, aimed, lowered);
    if (deep.empty() || round == kMostRounds) return;
    std::set<std::array<std::uint32_t, 3>> marked;
    for (const std::int32_t leaf : deep) {
      const Bisection::Triangle& t = mesh->triangle(leaf);
      marked.insert({t.apex, t.left, t.right});
    }
    for (std::uint32_t v = 0; v < lowered.size(); ++v) mesh->set_height(v, mesh->height(v) + lowered[v]);
    mesh->refine([&](const Bisection::Triangle& t) { return marked.contains({t.apex, t.left, t.right}); }, SIZE_MAX);
  }
}

void Terrain::Impl::measure(const Network& network, const Supports& supports, const Grid& natural) {
  for (SegmentRef at{0, 0}; at.road < network.roads.size(); ++at.road) {
    for (at.segment = 0; at.segment < network.roads[at.road].segments.size(); ++at.segment) {
      const Segment& segment = network.roads[at.road].segments[at.segment];
      for (const SupportedPart& part : supports.of(network, at)) {
        if (part.support != Support::kGround) continue;
        for (const double u : {part.u0, 0.5 * (part.u0 + part.u1)}) {
          const double above =
              segment.elevation_m.value(arc_at(segment, u)) - sample_bicubic(natural, position_m(segment, u));
          report.highest_fill_m = std::max(report.highest_fill_m, above);
          report.deepest_cut_m = std::max(report.deepest_cut_m, -above);
        }
      }
    }
  }
  report.bridge_parts = supports.parts(Support::kBridge);
  report.bridge_m = supports.length_m(Support::kBridge);
  report.assumed_bridge_parts = supports.assumed_parts();
  report.assumed_bridge_m = supports.assumed_m();
  report.tunnel_parts = supports.parts(Support::kTunnel);
  report.tunnel_areas = supports.halls().size();
  report.tunnel_m = supports.length_m(Support::kTunnel);
}

void Terrain::Impl::index_hollows() {
  std::vector<Box> boxes;
  for (const Hollow& hollow : hollows) boxes.push_back(hollow.box());
  if (!boxes.empty()) hollow_tree = BoxTree(boxes);
  boxes.clear();
  for (const Hall& hall : halls) boxes.push_back(hall.box());
  if (!boxes.empty()) hall_tree = BoxTree(boxes);
}

std::vector<std::uint32_t> Terrain::Impl::hollows_met(const std::array<glm::dvec3, 3>& triangle) const {
  std::vector<std::uint32_t> met;
  if (hollows.empty()) return met;
  const auto [a, b, c] = triangle;
  const Box about{glm::dvec3(glm::dvec2(glm::min(a, glm::min(b, c))), 0),
                  glm::dvec3(glm::dvec2(glm::max(a, glm::max(b, c))), 0)};
  hollow_tree.search(about, {.reach_m = 0}, [&](std::uint32_t i) {
    if (hollows[i].may_meet(triangle)) met.push_back(i);
  });
  std::sort(met.begin(), met.end());
  return met;
}

// The hollow whose vault the point lies below; of several the one whose floor is nearest to it.
const Hollow* Terrain::Impl::hollow_above(glm::dvec3 point_m) const {
  const Hollow* found = nullptr;
  if (hollows.empty()) return found;
  double nearest = std::numeric_limits<double>::infinity();
  const glm::dvec3 flat(glm::dvec2(point_m), 0);
  hollow_tree.search({flat, flat}, {.reach_m = 0}, [&](std::uint32_t i) {
    if (!hollows[i].is_above(point_m)) return;
    const double off = std::abs(hollows[i].floor_at(glm::dvec2(point_m)).height_m - point_m.z);
    if (off < nearest) nearest = off, found = &hollows[i];
  });
  return found;
}

// The hall that the point lies in; of several that with the highest floor.
const Hall* Terrain::Impl::hall_above(glm::dvec3 point_m) const {
  const Hall* found = nullptr;
  if (halls.empty()) return found;
  const glm::dvec2 at(point_m);
  double highest = 0;
  hall_tree.search({glm::dvec3(at, 0), glm::dvec3(at, 0)}, {.reach_m = 0}, [&](std::uint32_t i) {
    if (!halls[i].is_above(point_m)) return;
    const double floor = height_m_at(halls[i].surface, at);
    if (!found || floor > highest) highest = floor, found = &halls[i];
  });
  return found;
}

void Terrain::Impl::add_cuts(const std::map<std::vector<std::uint32_t>, std::vector<std::uint32_t>>& cut,
                             TerrainMesh& out) {
  std::map<std::uint32_t, std::uint32_t> place;  // of every hollow in the tile's own list
  for (const auto& [met, triangles] : cut) {
    TerrainMesh::Cut& group = out.cuts.emplace_back();
    group.first = static_cast<std::uint32_t>(out.triangles.size());
    group.count = static_cast<std::uint32_t>(triangles.size());
    out.triangles.insert(out.triangles.end(), triangles.begin(), triangles.end());
    for (const std::uint32_t i : met) {
      const auto [at, is_new] = place.emplace(i, static_cast<std::uint32_t>(out.hollows.size()));
      if (is_new) out.hollows.push_back(hollows[i]);
      group.hollows.push_back(at->second);
    }
    report.triangles_cut += triangles.size() / 3;
  }
}

// Coarser triangles may lie lower under the roads, where they deviate from the finest ones, but not higher; and what meets a
// tunnel stays as it is.
VertexDetail Terrain::Impl::detail(const Plates& roads) {
  const auto is_sound = [&](std::int32_t i) {
    const std::int32_t child = mesh->child(i);
    for (const std::int32_t part : {child, child + 1}) {
      if (mesh->child(part) < 0 && !hollows_met(corners(mesh->triangle(part))).empty()) return false;
    }
    const std::array<glm::dvec3, 3> t = corners(mesh->triangle(i));
    return hollows_met(t).empty() && roads.over(t).least_m >= options.least_clearance_m;
  };
  VertexDetail detail = vertex_detail(*mesh, unit_m, is_sound);
  report.triangles_coarsest = 2 * static_cast<std::size_t>(tile_count.x) * static_cast<std::size_t>(tile_count.y);
  mesh->each_halved([&](std::int32_t i) {
    report.triangles_coarsest += std::isinf(detail.error_m[mesh->triangle(mesh->child(i)).apex]);
  });
  return detail;
}

void Terrain::Impl::emit(const KnownHeights& ground, const VertexDetail& detail) {
  std::vector<std::uint32_t> local(mesh->vertices());
  std::vector<std::int32_t> seen(mesh->vertices(), -1);
  std::vector<glm::vec3> normals(mesh->vertices());
  std::vector<float> road_m(mesh->vertices());
  const LevellingOptions& l = options.levelling;
  const double ditches_to = l.ditch_depth_m > 0 ? l.shoulder_m + l.ditch_width_m() : 0;
  for_each_index(normals.size(), [&](std::size_t v) {
    const glm::dvec2 at(mesh->lattice(static_cast<std::uint32_t>(v)));
    const double edge = ground.ground().edge_distance_m(to_world(at), TerrainMesh::kVerge_m);
    road_m[v] = static_cast<float>(std::min(edge, TerrainMesh::kVerge_m));
    // As far to each side as the posts are apart there, in units of the lattice.
    const int step = edge < ditches_to ? std::max(1 << finer >> 2, 1) : 1 << finer;
    const glm::dvec2 east(step, 0), north(0, step);
    const glm::dvec2 slope(height_m(ground, at + east) - height_m(ground, at - east),
                           height_m(ground, at + north) - height_m(ground, at - north));
    normals[v] = glm::vec3(glm::normalize(glm::dvec3(-slope, 2 * step * unit_m)));
  });
  tell(0.9);
  const Bounds roads = bounds(ground.ground().index().network());
  const double z0 = quantised(0.5 * (roads.low_m.z + roads.high_m.z), 1.0);
  for (int tile = 0; tile < tile_count.x * tile_count.y; ++tile) {
    const glm::ivec2 place(tile % tile_count.x, tile / tile_count.x);
    const glm::ivec2 centre = place * mesh->cells() + mesh->cells() / 2;
    TerrainMesh out;
    out.origin_m = glm::dvec3(to_world(glm::dvec2(centre)), z0);
    const auto vertex = [&](std::uint32_t v) {
      if (seen[v] != tile) {
        seen[v] = tile;
        local[v] = static_cast<std::uint32_t>(out.positions_m.size());
        const glm::dvec2 flat = unit_m * glm::dvec2(mesh->lattice(v) - centre);
        out.positions_m.emplace_back(flat.x, flat.y, mesh->height(v) - z0);
        out.normals.push_back(normals[v]);
        out.road_m.push_back(road_m[v]);
        out.error_m.push_back(detail.error_m[v]);
        out.radius_m.push_back(detail.radius_m[v]);
      }
      return local[v];
    };
    // Leaves that meet hollows, by which.
    std::map<std::vector<std::uint32_t>, std::vector<std::uint32_t>> cut;
    // From coarse to fine; source[i] is what nodes[i] is in the mesh.
    std::vector<std::int32_t> source{mesh->root(place), mesh->root(place) + 1};
    out.nodes.resize(2);
    for (std::size_t i = 0; i < source.size(); ++i) {
      const Bisection::Triangle& t = mesh->triangle(source[i]);
      const std::array<std::uint32_t, 3> corner{vertex(t.apex), vertex(t.left), vertex(t.right)};
      if (i < 2) out.roots[i] = corner;
      if (const std::int32_t child = mesh->child(source[i]); child >= 0) {
        out.nodes[i] = {static_cast<std::int32_t>(source.size()), vertex(mesh->triangle(child).apex)};
        source.insert(source.end(), {child, child + 1});
        out.nodes.resize(source.size());
        continue;
      }
      const std::vector<std::uint32_t> met = hollows_met(corners(t));
      out.nodes[i] = {met.empty() ? TerrainMesh::Node::kLeaf : TerrainMesh::Node::kCut, 0};
      std::vector<std::uint32_t>& into = met.empty() ? out.triangles : cut[met];
      into.insert(into.end(), corner.begin(), corner.end());
    }
    add_cuts(cut, out);
    order_by_error(out);
    tiles.push_back(std::move(out));
    tell(0.9 + 0.1 * (tile + 1) / (tile_count.x * tile_count.y));
  }
  report.triangles = mesh->leaves();
  report.vertices = mesh->vertices();
  report.tiles = tiles.size();
}

Terrain::Terrain(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Terrain::~Terrain() = default;
Terrain::Terrain(Terrain&&) noexcept = default;
Terrain& Terrain::operator=(Terrain&&) noexcept = default;

Result<Terrain> Terrain::build(const Network& network, const Elevation* elevation, const TerrainOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const LevellingOptions& l = options.levelling;
  if (network.segment_count() == 0) return Error{ErrorCode::kData, "the network has no roads to lay terrain under"};
  if (!(options.margin_m > 0)) return usage("the terrain's margin must be positive");
  if (!(options.spacing_m >= 0.25 && options.spacing_m <= 16)) return usage("the post spacing must be 0.25 to 16 m");
  if (!(l.gap_m > 0 && l.shoulder_m >= 0 && l.cut_slope > 0 && l.fill_slope > 0 && l.reach_m > 0 && l.cover_m >= 0)) {
    return usage("gap, slopes and reach of the levelling must be positive, shoulder and cover not negative");
  }
  if (!(l.ditch_depth_m >= 0 && l.ditch_bottom_m >= 0 && l.ditch_inner_slope > 0 && l.ditch_outer_slope > 0 &&
        l.ditch_width_m() < 0.5 * l.reach_m)) {
    return usage(
        "a ditch's slopes must be positive, its depth and bottom not negative, and it must be narrower than 25 m");
  }
  if (!(options.least_clearance_m > 0 && options.most_clearance_m > options.least_clearance_m)) {
    return usage("the least clearance under the roads must be positive, and less than the most");
  }
  if (!(options.tolerance_m > 0 && options.tolerance_per_m > 0)) return usage("the tolerances must be positive");
  if (elevation != nullptr) {
    const Status covered = check_coverage(*elevation, network);
    if (!covered) return covered.error();
  }
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  if (elevation != nullptr) impl->report.voids_filled = elevation->voids_filled();
  impl->lay_out(network, elevation);
  impl->tell(0);
  const Grid natural = impl->natural_ground(network, elevation);
  impl->report.natural_spacing_m = std::max(natural.step_m.x, natural.step_m.y);
  impl->tell(0.15);
  const RoadIndex index(network);
  const Levelling ground(index, natural, impl->options.levelling);
  Plates roads(network, ground.supports());
  const double level_m = impl->options.levelling.gap_m + kNotLevelled_m;
  roads.find_overlaps(options.most_clearance_m - options.least_clearance_m);
  roads.find_levelled([&](glm::dvec2 p) { return ground.height_m(p); }, level_m, impl->options.levelling.shoulder_m);
  impl->tell(0.3);
  const KnownHeights known(ground);
  impl->triangulate(known, roads);
  impl->tell(0.65);
  impl->guarantee(roads);
  impl->hollows = ground.supports().hollows();
  impl->halls = ground.supports().halls();
  impl->index_hollows();
  impl->measure(network, ground.supports(), natural);
  impl->tell(0.75);
  const VertexDetail detail = impl->detail(roads);
  impl->tell(0.8);
  impl->emit(known, detail);
  impl->heights = HeightMesh(*impl->mesh, kQuantum_m);
  impl->mesh.reset();
  impl->keep(std::make_shared<const std::vector<TerrainMesh>>(std::move(impl->tiles)));
  impl->report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return Terrain(std::move(impl));
}

void Terrain::Impl::keep(std::shared_ptr<const std::vector<TerrainMesh>> all) {
  stored = ground_in_memory(all);
  meshes = std::move(all);
}

const std::vector<TerrainMesh>& Terrain::tiles() const {
  std::call_once(impl_->meshes_read, [&] {
    if (!impl_->meshes) impl_->meshes = std::make_shared<const std::vector<TerrainMesh>>(meshes_of(*impl_->stored));
  });
  return *impl_->meshes;
}
std::shared_ptr<const GroundSource> Terrain::ground() const { return impl_->stored; }
const TerrainReport& Terrain::report() const { return impl_->report; }

double Terrain::height_m(glm::dvec2 point_m) const { return impl_->heights.height_m(impl_->to_lattice(point_m)); }

void Terrain::heights_m(std::span<const glm::dvec2> points_m, std::span<double> heights_m) const {
  std::array<glm::dvec2, 256> places;
  for (std::size_t first = 0; first < points_m.size(); first += places.size()) {
    const std::size_t count = std::min(places.size(), points_m.size() - first);
    for (std::size_t i = 0; i < count; ++i) places[i] = impl_->to_lattice(points_m[first + i]);
    impl_->heights.heights_m(std::span(places).first(count), heights_m.subspan(first, count));
  }
}

glm::dvec3 Terrain::normal(glm::dvec2 point_m) const {
  return glm::normalize(glm::dvec3(-impl_->heights.gradient(impl_->to_lattice(point_m)) / impl_->unit_m, 1));
}

double Terrain::height_m(glm::dvec3 point_m) const {
  const Hollow* tunnel = impl_->hollow_above(point_m);
  if (tunnel) return tunnel->floor_at(glm::dvec2(point_m)).height_m;
  const Hall* hall = impl_->hall_above(point_m);
  return hall ? height_m_at(hall->surface, glm::dvec2(point_m)) : height_m(glm::dvec2(point_m));
}

glm::dvec3 Terrain::normal(glm::dvec3 point_m) const {
  const Hollow* tunnel = impl_->hollow_above(point_m);
  if (tunnel) return glm::normalize(glm::dvec3(-tunnel->floor_at(glm::dvec2(point_m)).gradient, 1));
  const Hall* hall = impl_->hall_above(point_m);
  return hall ? glm::normalize(glm::dvec3(-height_at(hall->surface, glm::dvec2(point_m)).gradient, 1))
              : normal(glm::dvec2(point_m));
}

Status write_terrain(const Terrain& terrain, const Network& network, double post_m, const std::string& path,
                     VerticalDatum datum, const std::string& geoid) {
  if (!network.georeference) return Error{ErrorCode::kData, "a network without georeference has no place on the Earth"};
  if (!(post_m > 0)) return usage("the post distance must be positive");
  const LocalFrame frame(*network.georeference);
  const Rectangle& area = terrain.report().area;
  // The geographic rectangle inside the area: its four sides by the middles and corners.
  glm::dvec2 low(-1e300, -1e300), high(1e300, 1e300);
  for (const double f : {0.0, 0.5, 1.0}) {
    const glm::dvec2 p = glm::mix(area.low_m, area.high_m, f);
    const double z = terrain.height_m(p);
    low.x = std::max(low.x, frame.to_geodetic({area.low_m.x, p.y, z}).longitude_deg);
    high.x = std::min(high.x, frame.to_geodetic({area.high_m.x, p.y, z}).longitude_deg);
    low.y = std::max(low.y, frame.to_geodetic({p.x, area.low_m.y, z}).latitude_deg);
    high.y = std::min(high.y, frame.to_geodetic({p.x, area.high_m.y, z}).latitude_deg);
  }
  const glm::dvec2 posts = glm::ceil((area.high_m - area.low_m) / post_m) + 1.0;
  if (posts.x * posts.y > 0x1p28) return usage("so many posts do not fit; take a greater post distance");
  Grid grid;
  grid.origin_m = low;
  grid.columns = static_cast<int>(posts.x);
  grid.rows = static_cast<int>(posts.y);
  grid.step_m = (high - low) / (posts - 1.0);
  grid.values.resize(static_cast<std::size_t>(grid.columns) * grid.rows);
  double h = network.georeference->height_m;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const glm::dvec2 place = grid.origin_m + grid.step_m * glm::dvec2(column, row);
      // Lift the place to its own height: the height moves it in the plane by next to nothing.
      for (int i = 0; i < 3; ++i) {
        const glm::dvec3 p = frame.to_local_m({place.y, place.x, h});
        h += terrain.height_m(glm::dvec2(p)) - p.z;
      }
      grid.at(column, row) = static_cast<float>(h);
    }
  }
  return write_geotiff(grid, path, datum, geoid);
}

}  // namespace roadgen
