// The terrain of the pass road: time to build it, and heights and normals per second on one core.
//   build/release/bin/terrain_bench
// Points lie at random within the area, so that none helps the next, or along the road in steps of 0.5 m.
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "roadgen/import/import.h"
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
void BM_NormalAlongRoad(benchmark::State& state) {
  ask_all(state, along(), [](glm::dvec2 p) { return terrain().normal(p).z; });
}
BENCHMARK(BM_HeightScattered);
BENCHMARK(BM_HeightAlongRoad);
BENCHMARK(BM_NormalAlongRoad);

}  // namespace
}  // namespace roadgen
