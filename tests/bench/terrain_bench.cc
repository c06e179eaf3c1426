// The terrain of the pass road: time to build it, and heights and normals per second on one core. And 10 km x 10 km about
// Monaco's roads, their heights fitted to the ground, with posts down to 5 m: time on all cores, and the peak of memory.
//   build/release/bin/terrain_bench
// Points lie at random within the area, so that none helps the next, or along the road in steps of 0.5 m.
#include <sys/resource.h>

#include <algorithm>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "roadgen/import/import.h"
#include "terrain/natural.h"
#include "terrain/terrain.h"

namespace roadgen {
namespace {

const std::string kData = std::string(ROADGEN_SOURCE_DIR) + "/data/";

const Network& pass() {
  static const Network network = [] {
    auto imported = import_files({kData + "pass.csv"}, {});
    if (!imported) std::abort();
    return std::move(imported->network);
  }();
  return network;
}

const Terrain& terrain() {
  static const Terrain built = [] {
    const auto elevation = Elevation::open(kData + "pass_dem.tif");
    auto made = Terrain::build(pass(), &*elevation);
    if (!made) std::abort();
    return std::move(*made);
  }();
  return built;
}

std::vector<glm::dvec2> scattered() {
  std::mt19937 random(3);
  const Rectangle& area = terrain().report().area;
  std::uniform_real_distribution<double> x(area.low_m.x, area.high_m.x), y(area.low_m.y, area.high_m.y);
  std::vector<glm::dvec2> points(1 << 18);
  for (glm::dvec2& p : points) p = {x(random), y(random)};
  return points;
}

std::vector<glm::dvec2> along() {
  std::vector<glm::dvec2> points;
  for (double s = 0; s < pass().roads[0].length_m(); s += 0.5) {
    points.emplace_back(pose_at(pass().roads[0], s, 6).position_m);
  }
  return points;
}

void BM_Build(benchmark::State& state) {
  const auto elevation = Elevation::open(kData + "pass_dem.tif");
  for (auto _ : state) {
    const auto made = Terrain::build(pass(), &*elevation);
    state.counters["triangles"] = static_cast<double>(made->report().triangles);
  }
}
BENCHMARK(BM_Build)->Unit(benchmark::kMillisecond)->UseRealTime();

// Public data: they stand beside the project, not in it; see data sources in README.
void BM_BuildMonaco(benchmark::State& state) {
  const std::string data = std::string(ROADGEN_SOURCE_DIR) + "/../shared/data/";
  const auto elevation = Elevation::open(data + "terrain/srtm-hgt/N43E007.hgt.zip");
  auto imported = import_files({data + "road-geo/osm-graphhopper/monaco.osm.gz"}, {});
  if (!elevation || !imported || !fit_heights(imported->network, measured_ground(*elevation, imported->network))) {
    state.SkipWithError("the public data are not here");
    return;
  }
  const Bounds roads = bounds(imported->network);
  TerrainOptions options;
  options.spacing_m = 5;
  options.margin_m = 0.5 * (10000 - std::min(roads.high_m.x - roads.low_m.x, roads.high_m.y - roads.low_m.y));
  for (auto _ : state) {
    const auto made = Terrain::build(imported->network, &*elevation, options);
    const Rectangle& area = made->report().area;
    state.counters["triangles"] = static_cast<double>(made->report().triangles);
    state.counters["km2"] = 1e-6 * (area.high_m.x - area.low_m.x) * (area.high_m.y - area.low_m.y);
    state.counters["least_mm"] = 1000 * made->report().clearance_min_m;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.counters["peak_MB"] = static_cast<double>(usage.ru_maxrss) / 1024;
}
BENCHMARK(BM_BuildMonaco)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime()->Iterations(1);

template <class Ask>
void ask_all(benchmark::State& state, const std::vector<glm::dvec2>& points, Ask&& ask) {
  terrain();
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(ask(points[i]));
    if (++i == points.size()) i = 0;
  }
  state.SetItemsProcessed(state.iterations());
}

void BM_HeightScattered(benchmark::State& state) {
  ask_all(state, scattered(), [](glm::dvec2 p) { return terrain().height_m(p); });
}
void BM_HeightAlongRoad(benchmark::State& state) {
  ask_all(state, along(), [](glm::dvec2 p) { return terrain().height_m(p); });
}
void ask_at_once(benchmark::State& state, const std::vector<glm::dvec2>& points) {
  constexpr std::size_t kBatch = 4096;
  std::vector<double> heights_m(kBatch);
  const std::span<const glm::dvec2> all(points);
  std::size_t first = 0;
  terrain();
  for (auto _ : state) {
    terrain().heights_m(all.subspan(first, kBatch), heights_m);
    benchmark::DoNotOptimize(heights_m.data());
    first = first + 2 * kBatch <= points.size() ? first + kBatch : 0;
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kBatch));
}
void BM_HeightsScattered(benchmark::State& state) { ask_at_once(state, scattered()); }
void BM_HeightsAlongRoad(benchmark::State& state) { ask_at_once(state, along()); }
void BM_NormalAlongRoad(benchmark::State& state) {
  ask_all(state, along(), [](glm::dvec2 p) { return terrain().normal(p).z; });
}
BENCHMARK(BM_HeightScattered);
BENCHMARK(BM_HeightAlongRoad);
BENCHMARK(BM_HeightsScattered);
BENCHMARK(BM_HeightsAlongRoad);
BENCHMARK(BM_NormalAlongRoad);

}  // namespace
}  // namespace roadgen
