#include "terrain/terrain.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "terrain/bisection.h"

namespace roadgen {
namespace {

constexpr double kLateral_m = 1.0 / 64, kVertical_m = 1.0 / 1024;  // quanta of the mesh's coordinates
constexpr double kTileSide_m = 1024;
constexpr int kMostTiles = 48;           // each way; larger worlds get larger tiles
constexpr int kMostNaturalPosts = 2048;  // each way
constexpr int kMostRetries = 6;
constexpr double kRetryFactor = 1.6;
constexpr double kSaneGrade = 0.3;
constexpr double kMostRaisedSpacing_m = 4;
// Far from the roads no leg is longer than this, lest a sampled error miss a whole mountain.
constexpr double kLegAtRoad_m = 8, kLegPerMetre = 0.12;

double quantised(double x, double quantum) { return std::round(x / quantum) * quantum; }

Error usage(const char* message) { return Error{ErrorCode::kUsage, message}; }

// A point of a carriageway with the height and the slope of its surface there.
struct SurfacePoint {
  glm::dvec2 position_m;
  double z_m;
  glm::dvec2 gradient;
};

// Calls visit(SurfacePoint) over every carriageway, at most step_m apart along the outer edge and across; closer where
// the grade is beyond reason, as in measured roads with faults.
template <class Visit>
void over_carriageways(const Network& network, double step_m, Visit&& visit) {
  for (const Junction& junction : network.junctions) {
    const JunctionSurface surface = junction_surface(junction);
    const glm::dvec2 center(surface.center_m), low(surface.low_m), high(surface.high_m);
    const glm::ivec2 count = glm::max(glm::ivec2(glm::ceil((high - low) / step_m)), 1);
    for (int i = 0; i <= count.x; ++i) {
      for (int j = 0; j <= count.y; ++j) {
        const glm::dvec2 p = center + glm::mix(low, high, glm::dvec2(i, j) / glm::dvec2(count));
        if (signed_distance_m(surface, p) < 0) continue;
        const JunctionPoint at = height_at(surface, p);
        visit(SurfacePoint{p, at.height_m, at.gradient});
      }
    }
  }
  const std::vector<bool> in_area = roads_in_areas(network);
  for (std::size_t r = 0; r < network.roads.size(); ++r) {
    if (in_area[r]) continue;
    for (const Segment& segment : network.roads[r].segments) {
      // The outer edge of a bend is longer than the centre line by 1 + curvature * half width.
      const double widest = segment.max_half_width_m();
      double bend = 0, grade = 0;
      for (int i = 0; i <= 8; ++i) {
        bend = std::max(bend, std::abs(curvature_per_m(segment, i / 8.0)));
        grade = std::max(grade, std::abs(segment.elevation_m.slope(segment.arc_m * i / 8.0)));
      }
      const double stretch = (1 + bend * widest) * std::clamp(grade / kSaneGrade, 1.0, 20.0);
      const int along = std::max(1, static_cast<int>(std::ceil(segment.arc_m * stretch / step_m)));
      const int across = std::max(2, static_cast<int>(std::ceil(2 * widest / step_m)));
      for (int i = 0; i <= along; ++i) {
        const double local = segment.arc_m * i / along, u = u_at_arc(segment, local);
        const double heading = heading_rad(segment, u), curvature = curvature_per_m(segment, u);
        const double cosine = std::cos(segment.superelevation_rad.value(local));
        const double left = segment.left_m.value(local) * cosine, right = segment.right_m.value(local) * cosine;
        const glm::dvec2 centre = position_m(segment, u), ahead(std::cos(heading), std::sin(heading));
        for (int j = 0; j <= across; ++j) {
          const double n = glm::mix(right, left, static_cast<double>(j) / across);
          const Lib::SurfaceSlope slope = surface_at(segment, local, n);
          const glm::dvec2 aside(-ahead.y, ahead.x);
          visit(SurfacePoint{centre + n * aside, slope.height,
                             slope.ahead / std::max(1 - n * curvature, 0.05) * ahead + slope.aside * aside});
        }
      }
    }
  }
}

}  // namespace

struct Terrain::Impl {
  TerrainOptions options;
  TerrainReport report;
  std::vector<TerrainMesh> tiles;
  double unit_m = 1;  // of the lattice
  glm::dvec2 origin_m{0, 0};
  int k = 9;
  glm::ivec2 tile_count{1, 1};
  std::unique_ptr<Bisection> mesh;

  glm::dvec2 to_world(glm::dvec2 lattice) const { return origin_m + unit_m * lattice; }
  glm::dvec2 to_lattice(glm::dvec2 point_m) const { return (point_m - origin_m) / unit_m; }

  void lay_out(const Network& network, const Elevation* elevation);
  Grid natural_ground(const Network& network, const Elevation* elevation) const;
  bool is_wanted(const Levelling& ground, const Bisection::Triangle& t, double factor) const;
  void triangulate(const Levelling& ground);
  void correct(const Network& network);
  void measure(const Network& network, const Grid& natural);
  void emit(const Levelling& ground);
  void tell(double fraction) const {
    if (options.progress) options.progress(fraction);
  }
};

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
  unit_m = std::max(std::ceil(longer / many / (1 << k) / kLateral_m) * kLateral_m, kLateral_m);
  const double side = unit_m * (1 << k);
  tile_count = glm::ivec2(glm::max(glm::ceil(size / side - 1e-9), glm::dvec2(1)));
  const glm::dvec2 middle = 0.5 * (area.low_m + area.high_m);
  origin_m = glm::dvec2(quantised(middle.x - 0.5 * side * tile_count.x, kLateral_m),
                        quantised(middle.y - 0.5 * side * tile_count.y, kLateral_m));
  report.area = {origin_m, origin_m + side * glm::dvec2(tile_count)};
  report.spacing_m = unit_m;
  options.levelling.shoulder_m = std::max(options.levelling.shoulder_m, 1.5 * unit_m);
}

Grid Terrain::Impl::natural_ground(const Network& network, const Elevation* elevation) const {
  const glm::dvec2 size = report.area.high_m - report.area.low_m;
  const double finest = std::max({size.x / kMostNaturalPosts, size.y / kMostNaturalPosts, unit_m});
  if (elevation == nullptr) return natural_from_roads(network, report.area, std::max(finest, 12.0), options.rolling_m);
  const double spacing = std::max(finest, 0.6 * elevation->post_spacing_m());
  return natural_from_elevation(*elevation, network, report.area, spacing);
}

// Whether a triangle is too coarse: it may touch a carriageway, or has long legs, or deviates from the ground.
bool Terrain::Impl::is_wanted(const Levelling& ground, const Bisection::Triangle& t, double factor) const {
  const glm::dvec2 left(mesh->lattice(t.left)), right(mesh->lattice(t.right)), apex(mesh->lattice(t.apex));
  const glm::dvec2 middle = 0.5 * (left + right);  // of the circle around a right triangle
  const double radius = 0.5 * glm::length(right - left) * unit_m;
  const double leg = std::numbers::sqrt2 * radius;
  const double edge = ground.edge_distance_m(to_world(middle), radius + 4 * unit_m) - radius;
  if (edge <= 0) return true;
  if (leg > factor * (kLegAtRoad_m + kLegPerMetre * edge)) return true;

  const double tolerance = factor * (options.tolerance_m + options.tolerance_per_m * edge);
  const auto misses = [&](double to_left, double to_right) {
    const double plane = mesh->height(t.apex) + to_left * (mesh->height(t.left) - mesh->height(t.apex)) +
                         to_right * (mesh->height(t.right) - mesh->height(t.apex));
    const glm::dvec2 p = apex + to_left * (left - apex) + to_right * (right - apex);
    return std::abs(ground.height_m(to_world(p)) - plane) > tolerance;
  };
  return misses(0.5, 0.5) || misses(0.5, 0) || misses(0, 0.5) || (t.level < 2 * k - 3 && misses(0.25, 0.25));
}

void Terrain::Impl::triangulate(const Levelling& ground) {
  const auto height = [&](glm::ivec2 p) { return quantised(ground.height_m(to_world(glm::dvec2(p))), kVertical_m); };
  double factor = 1;
  for (int attempt = 0;; ++attempt, factor *= kRetryFactor) {
    mesh = std::make_unique<Bisection>(tile_count, k, height);
    const std::size_t most = attempt < kMostRetries ? options.max_triangles : SIZE_MAX;
    if (mesh->refine([&](const Bisection::Triangle& t) { return is_wanted(ground, t, factor); }, most)) break;
  }
  report.tolerance_factor = factor;
}

// Lowers the triangle under every sample of a carriageway that has too little clearance: less than kCorrectedClearance,
// or so little that the difference of the two slopes could use up what is more than kLeastClearance on half the way to
// the next sample. Lowering never takes clearance away elsewhere, so one pass is enough.
void Terrain::Impl::correct(const Network& network) {
  const double gap = options.levelling.gap_m, half_way = kClearanceStep_m / std::numbers::sqrt2;
  over_carriageways(network, kClearanceStep_m, [&](const SurfacePoint& p) {
    const glm::dvec2 place = to_lattice(p.position_m);
    const std::int32_t leaf = mesh->find(place);
    const double between = half_way * glm::length(p.gradient - mesh->gradient(leaf) / unit_m);
    const double wanted = std::max(kCorrectedClearance * gap, kLeastClearance * gap + between);
    const double lacking = wanted - (p.z_m - mesh->height_on(leaf, place));
    if (lacking <= 0) return;
    const double by = std::ceil(lacking / kVertical_m) * kVertical_m;
    const Bisection::Triangle& t = mesh->triangle(leaf);
    for (const std::uint32_t vertex : {t.apex, t.left, t.right}) mesh->set_height(vertex, mesh->height(vertex) - by);
    ++report.triangles_lowered;
    report.lowered_max_m = std::max(report.lowered_max_m, by);
  });
}

void Terrain::Impl::measure(const Network& network, const Grid& natural) {
  const Clearance c =
      measure_clearance(network, kClearanceStep_m, [&](glm::dvec2 p) { return mesh->height_at(to_lattice(p)); });
  report.clearance_min_m = c.min_m;
  report.clearance_max_m = c.max_m;
  report.clearance_samples = c.samples;
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      for (const double u : {0.0, 0.5}) {
        const double above =
            segment.elevation_m.value(arc_at(segment, u)) - sample_bicubic(natural, position_m(segment, u));
        report.highest_fill_m = std::max(report.highest_fill_m, above);
        report.deepest_cut_m = std::max(report.deepest_cut_m, -above);
      }
    }
  }
}

void Terrain::Impl::emit(const Levelling& ground) {
  std::vector<std::uint32_t> local(mesh->vertices());
  std::vector<std::int32_t> seen(mesh->vertices(), -1);
  std::vector<glm::vec3> normals(mesh->vertices(), glm::vec3(0));
  const Bounds roads = bounds(ground.index().network());
  const double z0 = quantised(0.5 * (roads.low_m.z + roads.high_m.z), 1.0);
  for (int tile = 0; tile < tile_count.x * tile_count.y; ++tile) {
    const glm::ivec2 place(tile % tile_count.x, tile / tile_count.x);
    const glm::ivec2 centre = place * mesh->cells() + mesh->cells() / 2;
    TerrainMesh out;
    out.origin_m = glm::dvec3(to_world(glm::dvec2(centre)), z0);
    for (const std::int32_t leaf : mesh->leaves_of(place)) {
      const Bisection::Triangle& t = mesh->triangle(leaf);
      for (const std::uint32_t v : {t.apex, t.left, t.right}) {
        if (seen[v] != tile) {
          seen[v] = tile;
          local[v] = static_cast<std::uint32_t>(out.positions_m.size());
          const glm::ivec2 p = mesh->lattice(v);
          const glm::dvec2 flat = unit_m * glm::dvec2(p - centre);
          out.positions_m.emplace_back(flat.x, flat.y, mesh->height(v) - z0);
          glm::vec3& normal = normals[v];
          if (normal.z == 0) {
            const glm::dvec2 w = to_world(glm::dvec2(p)), east(unit_m, 0), north(0, unit_m);
            const glm::dvec2 slope(ground.height_m(w + east) - ground.height_m(w - east),
                                   ground.height_m(w + north) - ground.height_m(w - north));
            normal = glm::vec3(glm::normalize(glm::dvec3(-slope, 2 * unit_m)));
          }
          out.normals.push_back(normal);
        }
        out.triangles.push_back(local[v]);
      }
    }
    tiles.push_back(std::move(out));
    tell(0.8 + 0.2 * (tile + 1) / (tile_count.x * tile_count.y));
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
  if (!(l.gap_m > 0 && l.shoulder_m >= 0 && l.cut_slope > 0 && l.fill_slope > 0 && l.reach_m > 0)) {
    return usage("gap, slopes and reach of the levelling must be positive");
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
  impl->triangulate(ground);
  impl->tell(0.65);
  impl->correct(network);
  impl->measure(network, natural);
  impl->tell(0.8);
  impl->emit(ground);
  impl->report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return Terrain(std::move(impl));
}

const std::vector<TerrainMesh>& Terrain::tiles() const { return impl_->tiles; }
const TerrainReport& Terrain::report() const { return impl_->report; }

double Terrain::height_m(glm::dvec2 point_m) const { return impl_->mesh->height_at(impl_->to_lattice(point_m)); }

glm::dvec3 Terrain::normal(glm::dvec2 point_m) const {
  const Bisection& mesh = *impl_->mesh;
  return glm::normalize(glm::dvec3(-mesh.gradient(mesh.find(impl_->to_lattice(point_m))) / impl_->unit_m, 1));
}

Clearance measure_clearance(const Network& network, double step_m,
                            const std::function<double(glm::dvec2)>& ground_height_m) {
  Clearance c{1e300, -1e300, 0};
  over_carriageways(network, step_m, [&](const SurfacePoint& p) {
    const double clearance = p.z_m - ground_height_m(p.position_m);
    c.min_m = std::min(c.min_m, clearance);
    c.max_m = std::max(c.max_m, clearance);
    ++c.samples;
  });
  return c.samples > 0 ? c : Clearance{};
}

Status write_terrain(const Terrain& terrain, const Network& network, double post_m, const std::string& path) {
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
  return write_geotiff(grid, path);
}

}  // namespace roadgen
