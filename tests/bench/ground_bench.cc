// What ground costs by its area: squares of 1 to 1,000 km2 about a short road, in invented hills over 32 km. Built, drawn
// on OSMesa and held in memory.
//   build/release/bin/ground_bench
// The frames of all areas are drawn in turn, one each of every view, and compared view by view by the medians of their
// times: of all processors together (cpu_ms), which other work on the machine disturbs less than elapsed time. `ratio` is to
// the smallest area. Pictures, 640 x 360, 4 samples; triangles are those drawn, of those built.
// Second table: the same frames of the ground in its file, within a budget of 1 MiB: the greatest number of bytes on the GPU
// and read from the file at any time, against what the mesh and the file take as a whole; `ratio` is of the frame to the one
// of the first table.
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <vector>

#include "roadgen/render/flight.h"
#include "roadgen/render/renderer.h"
#include "terrain/ground_source.h"
#include "terrain/terrain.h"
#include "terrain/terrain_file.h"

namespace roadgen {
namespace {

constexpr std::array<double, 4> kAreas_km2{1, 10, 100, 1000};
constexpr int kViews = 8, kRounds = 5;
constexpr std::size_t kBudget_bytes = std::size_t{1} << 20;
constexpr double kMiB = 1 << 20;

template <class T>
T require(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "%s\n", result.error().text().c_str());
  std::exit(1);
}

// A road of 600 m in the middle, so that the smallest area holds it.
Network short_road(const Grid& hills) {
  Network network;
  Road road;
  road.id = "1";
  constexpr int kPieces = 30;
  constexpr double kStep_m = 20;
  for (int i = 0; i < kPieces; ++i) {
    const glm::dvec2 a(-300 + kStep_m * i, 0), b(-280 + kStep_m * i, 0);
    Segment segment = make_segment(a, b, 0, 0, 3.5);
    const double z0 = sample_bicubic(hills, a), z1 = sample_bicubic(hills, b);
    const auto grade = [&](glm::dvec2 p) {
      return (sample_bicubic(hills, p + glm::dvec2(5, 0)) - sample_bicubic(hills, p - glm::dvec2(5, 0))) / 10;
    };
    segment.elevation_m = Cubic::hermite(z0, grade(a), z1, grade(b), segment.arc_m);
    road.segments.push_back(segment);
  }
  chain_arc_lengths(road);
  two_lane_sections(road);
  network.roads.push_back(std::move(road));
  return network;
}

// Posts 30 m apart over 32 km, in a file: elevation comes from files.
Grid hills() {
  Grid grid;
  grid.columns = grid.rows = 1071;
  grid.step_m = {30, 30};
  grid.origin_m = {-16050, -16050};
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const glm::dvec2 p = grid.origin_m + grid.step_m * glm::dvec2(column, row);
      double z = 400, size = 180, wave = 5200;
      for (int i = 0; i < 7; ++i, size *= 0.5, wave *= 0.47) {
        z += size * std::sin(p.x / wave * 6.28 + 1.7 * i) * std::cos(p.y / wave * 5.9 + 2.3 * i);
      }
      grid.values.push_back(static_cast<float>(z));
    }
  }
  return grid;
}

std::string write_hills(const Grid& grid) {
  const std::string path = (std::filesystem::temp_directory_path() / "roadgen_ground_bench.asc").string();
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) std::exit(1);
  std::fprintf(file, "ncols %d\nnrows %d\nxllcenter %.1f\nyllcenter %.1f\ncellsize %.1f\n", grid.columns, grid.rows,
               grid.origin_m.x, grid.origin_m.y, grid.step_m.x);
  for (int row = grid.rows - 1; row >= 0; --row) {
    for (int column = 0; column < grid.columns; ++column) {
      std::fprintf(file, "%.3f ", static_cast<double>(grid.at(column, row)));
    }
    std::fputc('\n', file);
  }
  std::fclose(file);
  return path;
}

double cpu_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }
double peak_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}
double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// Of one renderer, per view.
struct Frames {
  std::unique_ptr<Renderer> renderer;
  std::size_t drawn = 0, gpu_bytes = 0, loaded_bytes = 0, batches = 0;  // the greatest, but for drawn: the mean
  std::array<std::vector<double>, kViews> cpu_ms;
};

struct Area {
  double km2 = 0, build_s = 0, peak_mb = 0, tolerance_factor = 1;
  std::size_t triangles = 0, mesh_bytes = 0, file_bytes = 0;
  Frames whole, streamed;
};

Camera view(const Network& network, int i) {
  Camera camera = i % 2 == 0 ? drive_camera(network.roads[0], 60.0 * i + 20, -1.75, 1.5)
                             : flight_camera(network.roads[0], 60.0 * i, {.height_m = 40});
  camera.yaw_deg += 90.0 * (i / 2);
  return camera;
}

void render(Frames& frames, const Camera& camera, int i, bool is_first) {
  const double before = cpu_s();
  require(frames.renderer->render(camera, {.width = 640, .height = 360}));
  frames.cpu_ms[static_cast<std::size_t>(i)].push_back(1000 * (cpu_s() - before));
  const GroundStatistics used = frames.renderer->ground_statistics();
  if (is_first) frames.drawn += used.drawn_triangles / kViews;
  frames.gpu_bytes = std::max(frames.gpu_bytes, used.gpu_bytes);
  frames.loaded_bytes = std::max(frames.loaded_bytes, used.loaded_bytes);
  frames.batches = std::max(frames.batches, used.batches);
}

// The median of the views' medians, and of their ratios to the others'.
std::array<double, 2> times(const Frames& frames, const Frames& others) {
  std::vector<double> own, ratios;
  for (std::size_t i = 0; i < kViews; ++i) {
    own.push_back(median(frames.cpu_ms[i]));
    ratios.push_back(own.back() / median(others.cpu_ms[i]));
  }
  return {median(own), median(ratios)};
}

Area made(double km2, const Network& network, const Elevation& elevation, Context& context, const std::string& path) {
  TerrainOptions options;
  options.margin_m = 500 * std::sqrt(km2) - 150;  // the road takes 0.6 km of one side
  const double before = cpu_s();
  const Terrain terrain = require(Terrain::build(network, &elevation, options));
  Area area;
  area.km2 = km2;
  area.build_s = cpu_s() - before;
  area.peak_mb = peak_mb();
  area.tolerance_factor = terrain.report().tolerance_factor;
  area.triangles = terrain.report().triangles;
  for (const GroundTile& tile : terrain.ground()->tiles()) {
    area.mesh_bytes += 28 * tile.positions_m.size() + 12 * tile.triangle_count();
  }
  require(write_terrain_file(terrain, 1, path));
  area.file_bytes = std::filesystem::file_size(path);
  RendererOptions bounded;
  bounded.ground_budget_bytes = kBudget_bytes;
  area.whole.renderer = std::make_unique<Renderer>(require(Renderer::create(context)));
  area.streamed.renderer = std::make_unique<Renderer>(require(Renderer::create(context, bounded)));
  require(area.whole.renderer->load_roads(network));
  require(area.streamed.renderer->load_roads(network));
  require(area.whole.renderer->load_ground(terrain.ground()));
  require(area.streamed.renderer->load_ground(require(read_terrain_file(path, 1)).ground()));
  return area;
}

int run() {
  const Grid grid = hills();
  const std::string path = write_hills(grid);
  const Elevation elevation = require(Elevation::open(path));
  const Network network = short_road(grid);
  const std::unique_ptr<Context> context = require(Context::create({.kind = ContextKind::kOsmesa}));
  std::vector<Area> areas;
  for (const double km2 : kAreas_km2) areas.push_back(made(km2, network, elevation, *context, path + ".ground"));
  for (int round = 0; round < kRounds; ++round) {
    for (int i = 0; i < kViews; ++i) {
      for (Area& area : areas) {
        for (Frames* frames : {&area.whole, &area.streamed}) render(*frames, view(network, i), i, round == 0);
      }
    }
  }
  std::printf("%8s %9s %9s %10s %12s %10s %8s %8s\n", "km2", "build s", "peak MB", "triangles", "tolerances x", "drawn",
              "cpu ms", "ratio");
  for (const Area& area : areas) {
    const auto [cpu_ms, ratio] = times(area.whole, areas[0].whole);
    std::printf("%8.0f %9.2f %9.0f %10zu %12.2f %10zu %8.1f %8.2f\n", area.km2, area.build_s, area.peak_mb,
                area.triangles, area.tolerance_factor, area.whole.drawn, cpu_ms, ratio);
  }
  std::printf("\n%8s %9s %9s %11s %9s %9s %8s %8s\n", "km2", "mesh MiB", "GPU MiB", "of 1 GPU MiB", "file MiB",
              "read MiB", "batches", "ratio");
  for (const Area& area : areas) {
    std::printf("%8.0f %9.2f %9.2f %11.2f %9.2f %9.2f %8zu %8.2f\n", area.km2,
                static_cast<double>(area.mesh_bytes) / kMiB, static_cast<double>(area.whole.gpu_bytes) / kMiB,
                static_cast<double>(area.streamed.gpu_bytes) / kMiB, static_cast<double>(area.file_bytes) / kMiB,
                static_cast<double>(area.streamed.loaded_bytes) / kMiB, area.streamed.batches,
                times(area.streamed, area.whole)[1]);
  }
  std::filesystem::remove(path);
  std::filesystem::remove(path + ".ground");
  return 0;
}

}  // namespace
}  // namespace roadgen

int main() { return roadgen::run(); }
