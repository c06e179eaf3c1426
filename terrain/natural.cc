#include "terrain/natural.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>

#include <glm/common.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "roadgen/road/off_ground.h"
#include "terrain/levelling.h"

namespace roadgen {
namespace {

constexpr int kMostIterations = 8;
constexpr double kHeightTolerance_m = 1e-4;
// Rolling hills: the longest wave, the number of halvings, and where the hills have come to full height.
constexpr double kHillWave_m = 900;
constexpr int kHillOctaves = 5;
constexpr double kHillsFrom_m = 30, kHillsTo_m = 700;

Grid empty_grid(const Rectangle& area, double spacing_m) {
  Grid grid;
  const glm::dvec2 size = area.high_m - area.low_m;
  grid.origin_m = area.low_m;
  grid.columns = static_cast<int>(std::ceil(size.x / spacing_m)) + 1;
  grid.rows = static_cast<int>(std::ceil(size.y / spacing_m)) + 1;
  grid.step_m = size / glm::dvec2(grid.columns - 1, grid.rows - 1);
  grid.values.assign(static_cast<std::size_t>(grid.columns) * grid.rows, 0);
  return grid;
}

// Fixed point of: lift the point to z, read the height of the model below it, correct z by the difference. The vertical
// there leans by the distance from the origin / the Earth's radius, so every turn shrinks the error by that factor
// times the slope of the ground. z goes in as the first guess.
double solve_height(const Elevation& elevation, const LocalFrame& frame, glm::dvec2 point_m, double z) {
  for (int i = 0; i < kMostIterations; ++i) {
    const Geodetic g = frame.to_geodetic({point_m.x, point_m.y, z});
    const double miss = elevation.height_m({g.longitude_deg, g.latitude_deg}) - g.height_m;
    z += miss;
    if (std::abs(miss) < kHeightTolerance_m) break;
  }
  return z;
}

double hash01(std::int64_t x, std::int64_t y) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15u;
  h ^= static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fu;
  h ^= h >> 29;
  h *= 0xbf58476d1ce4e5b9u;
  h ^= h >> 32;
  return static_cast<double>(h >> 11) * 0x1p-53;
}

// Value noise in [-1, 1], C1.
double noise(glm::dvec2 p) {
  const glm::dvec2 cell = glm::floor(p), t = p - cell, w = t * t * (3.0 - 2.0 * t);
  const auto x = static_cast<std::int64_t>(cell.x), y = static_cast<std::int64_t>(cell.y);
  const double low = glm::mix(hash01(x, y), hash01(x + 1, y), w.x);
  const double high = glm::mix(hash01(x, y + 1), hash01(x + 1, y + 1), w.x);
  return 2 * glm::mix(low, high, w.y) - 1;
}

double hills(glm::dvec2 p) {
  double sum = 0, amplitude = 1;
  p /= kHillWave_m;
  for (int i = 0; i < kHillOctaves; ++i) {
    sum += amplitude * noise(p);
    amplitude *= 0.45;
    p = glm::dvec2(1.6 * p.x - 1.2 * p.y, 1.2 * p.x + 1.6 * p.y);  // twice as fine, and turned
  }
  return sum;
}

// Calls place(point, z) along the centre lines, at most step_m apart; those off the ground, too, or not.
template <class Place>
void along_roads(const Network& network, double step_m, bool off_ground, Place&& place) {
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      const int pieces = std::max(1, static_cast<int>(std::ceil(segment.arc_m / step_m)));
      for (int i = 0; i <= pieces; ++i) {
        const double u = static_cast<double>(i) / pieces, local = arc_at(segment, u);
        if (!off_ground && is_off_ground(road, segment.s_start_m + local)) continue;
        place(position_m(segment, u), segment.elevation_m.value(local));
      }
    }
  }
}

// Geographic extent of the roads.
Extent road_extent(const Network& network, const LocalFrame* frame) {
  Extent e{{1e300, 1e300}, {-1e300, -1e300}};
  for (const Road& road : network.roads) {
    for (const Segment& segment : road.segments) {
      for (const glm::dvec2 corner : fitted_quad(segment).corner) {
        glm::dvec2 p = from_chord(segment, corner);
        if (frame != nullptr) {
          const Geodetic g = frame->to_geodetic({p.x, p.y, segment.elevation_m.c0});
          p = {g.longitude_deg, g.latitude_deg};
        }
        e.low = glm::min(e.low, p);
        e.high = glm::max(e.high, p);
      }
    }
  }
  return e;
}

std::string described(const Extent& e, bool geographic) {
  char text[200];
  std::snprintf(
      text, sizeof text,
      geographic ? "latitude %.5f to %.5f, longitude %.5f to %.5f degrees" : "y %.2f to %.2f, x %.2f to %.2f m",
      e.low.y, e.high.y, e.low.x, e.high.x);
  return text;
}

}  // namespace

Status check_coverage(const Elevation& elevation, const Network& network) {
  const bool geographic = elevation.is_geographic();
  const auto error = [&](std::string message) { return Error{ErrorCode::kData, std::move(message), elevation.path()}; };
  if (geographic && !network.georeference) {
    return error("the elevation lies on the Earth but the network has no georeference; import it with --origin");
  }
  if (!geographic && network.georeference) {
    return error("the elevation has no coordinate system but the network is georeferenced; assign one to the file");
  }
  if (network.segment_count() == 0) return error("the network has no roads");
  std::optional<LocalFrame> frame;
  if (geographic) frame.emplace(*network.georeference);
  const Extent roads = road_extent(network, frame ? &*frame : nullptr);
  bool covered = true;
  for (const glm::dvec2 corner :
       {roads.low, roads.high, glm::dvec2(roads.low.x, roads.high.y), glm::dvec2(roads.high.x, roads.low.y)}) {
    covered = covered && elevation.covers(corner);
  }
  if (covered) return Done{};
  return error("the elevation covers " + described(elevation.extent(), geographic) + ", but the roads need " +
               described(roads, geographic));
}

Rectangle covered_rectangle(const Elevation& elevation, const Network& network) {
  const Extent e = elevation.extent();
  if (!elevation.is_geographic()) return {e.low, e.high};
  const LocalFrame frame(*network.georeference);
  Rectangle r{{-1e300, -1e300}, {1e300, 1e300}};
  constexpr int kPlaces = 16;
  for (int i = 0; i <= kPlaces; ++i) {
    const glm::dvec2 p = glm::mix(e.low, e.high, static_cast<double>(i) / kPlaces);
    const double h = network.georeference->height_m;
    r.low_m.x = std::max(r.low_m.x, frame.to_local_m({p.y, e.low.x, h}).x);
    r.high_m.x = std::min(r.high_m.x, frame.to_local_m({p.y, e.high.x, h}).x);
    r.low_m.y = std::max(r.low_m.y, frame.to_local_m({e.low.y, p.x, h}).y);
    r.high_m.y = std::min(r.high_m.y, frame.to_local_m({e.high.y, p.x, h}).y);
  }
  return r;
}

double elevation_enu_m(const Elevation& elevation, const Network& network, glm::dvec2 point_m) {
  if (!elevation.is_geographic()) return elevation.height_m(point_m);
  return solve_height(elevation, LocalFrame(*network.georeference), point_m, 0);
}

std::function<std::optional<double>(glm::dvec2)> measured_ground(const Elevation& elevation, const Network& network) {
  if (!elevation.is_geographic()) {
    return [&elevation](glm::dvec2 p) {
      return elevation.is_measured(p) ? std::optional(elevation.height_m(p)) : std::nullopt;
    };
  }
  return
      [&elevation, frame = std::make_shared<LocalFrame>(*network.georeference)](glm::dvec2 p) -> std::optional<double> {
        const double z = solve_height(elevation, *frame, p, 0);
        const Geodetic g = frame->to_geodetic({p.x, p.y, z});
        return elevation.is_measured({g.longitude_deg, g.latitude_deg}) ? std::optional(z) : std::nullopt;
      };
}

Grid natural_from_elevation(const Elevation& elevation, const Network& network, const Rectangle& area,
                            double spacing_m) {
  Grid grid = empty_grid(area, spacing_m);
  std::optional<LocalFrame> frame;
  if (elevation.is_geographic()) frame.emplace(*network.georeference);
  double z = 0;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const glm::dvec2 p = grid.origin_m + grid.step_m * glm::dvec2(column, row);
      z = frame ? solve_height(elevation, *frame, p, z) : elevation.height_m(p);
      grid.at(column, row) = static_cast<float>(z);
    }
  }
  return grid;
}

Grid natural_from_roads(const Network& network, const Rectangle& area, double spacing_m, double rolling_m) {
  Grid grid = empty_grid(area, spacing_m);
  std::vector<double> sum(grid.values.size(), 0);
  std::vector<std::uint8_t> known(grid.values.size(), 0);
  std::vector<int> count(grid.values.size(), 0);
  const double step = std::min(grid.step_m.x, grid.step_m.y);
  bool any = false;
  const auto take = [&](glm::dvec2 p, double z) {
    const glm::dvec2 cell = glm::round((p - grid.origin_m) / grid.step_m);
    const int column = std::clamp(static_cast<int>(cell.x), 0, grid.columns - 1);
    const int row = std::clamp(static_cast<int>(cell.y), 0, grid.rows - 1);
    const std::size_t i = static_cast<std::size_t>(row) * grid.columns + column;
    sum[i] += z;
    ++count[i];
    known[i] = any = true;
  };
  along_roads(network, 0.5 * step, false, take);
  if (!any) along_roads(network, 0.5 * step, true, take);
  for (std::size_t i = 0; i < known.size(); ++i) {
    if (known[i]) grid.values[i] = static_cast<float>(sum[i] / count[i]);
  }
  fill_holes(grid, known);

  const Grid distance = distance_from_roads(network, grid);
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const glm::dvec2 p = grid.origin_m + grid.step_m * glm::dvec2(column, row);
      const double t = std::clamp((distance.at(column, row) - kHillsFrom_m) / (kHillsTo_m - kHillsFrom_m), 0.0, 1.0);
      grid.at(column, row) += static_cast<float>(rolling_m * t * t * (3 - 2 * t) * hills(p));
    }
  }
  return grid;
}

}  // namespace roadgen
