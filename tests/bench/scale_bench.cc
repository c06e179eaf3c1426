// Cities of ten thousand to a million segments: load time, memory, and frame time at street level (OSMesa).
//   build/release/bin/scale_bench
// Every city is the middle of the next larger one. Frame times of all cities are taken in turn, one frame each, and
// compared by their medians; render() includes the read-back of the picture.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "roadgen/render/renderer.h"
#include "tests/common/city.h"

namespace roadgen {
namespace {

struct Size {
  const char* name;
  int blocks;
};
constexpr std::array<Size, 3> kSizes{{{"10k", 50}, {"100k", 158}, {"1M", 500}}};

// Positions near the middle of the cities, 1.5 m above the road.
struct Pose {
  double x_m, y_m, yaw_deg, pitch_deg;
};
constexpr Pose kPoses[] = {{3, -1.7, 0, 0},     {3, -1.7, 45, -3},   {52, 4, 90, 0},
                           {-148, 97, 200, -8}, {249, -301, 135, 0}, {-95, -207, 300, 2}};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

template <class Work>
double milliseconds(Work&& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void require(const Status& status) {
  if (status) return;
  std::fprintf(stderr, "%s\n", status.error().text().c_str());
  std::exit(1);
}

Context& context() {
  static const std::unique_ptr<Context> one = [] {
    auto made = Context::create({.kind = ContextKind::kOsmesa});
    if (!made) require(made.error());
    return std::move(*made);
  }();
  return *one;
}

const Network& network(std::size_t size) {
  static std::array<Network, kSizes.size()> all;
  if (all[size].roads.empty()) all[size] = test::city({.blocks = kSizes[size].blocks});
  return all[size];
}

Renderer make_renderer() {
  auto made = Renderer::create(context());
  if (!made) require(made.error());
  return std::move(*made);
}

void Load(benchmark::State& state) {
  const auto size = static_cast<std::size_t>(state.range(0));
  const Network& roads = network(size);
  Renderer renderer = make_renderer();
  for (auto _ : state) require(renderer.load_roads(roads));
  const auto segments = static_cast<double>(roads.segment_count());
  const RoadStatistics statistics = renderer.road_statistics();
  state.counters["segments"] = segments;
  state.counters["segments/s"] = benchmark::Counter(segments, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["gpu_instances_B/segment"] = static_cast<double>(statistics.pool_bytes) / segments;
  state.counters["gpu_tables_B/segment"] = static_cast<double>(statistics.table_bytes) / segments;
  state.counters["cpu_instances_B/segment"] = static_cast<double>(statistics.instance_bytes) / segments;
  state.counters["cpu_network_B/segment"] = sizeof(Segment);
  state.SetLabel(kSizes[size].name);
}
BENCHMARK(Load)->DenseRange(0, kSizes.size() - 1)->Unit(benchmark::kMillisecond)->UseRealTime();

// The frames of a pose in all three cities.
struct Times {
  std::array<double, kSizes.size()> ms;
  std::array<double, kSizes.size()> segments;
};

Times street_level(const Pose& pose, unsigned channels, benchmark::State& state) {
  static std::vector<Renderer> renderers;
  while (renderers.size() < kSizes.size()) {
    renderers.push_back(make_renderer());
    require(renderers.back().load_roads(network(renderers.size() - 1)));
  }
  Camera camera;
  camera.position_m = {pose.x_m, pose.y_m, 1.5};
  camera.yaw_deg = pose.yaw_deg;
  camera.pitch_deg = pose.pitch_deg;
  camera.fov_deg = 60;
  const auto frame = [&](Renderer& renderer) {
    auto drawn = renderer.render(camera, {.width = 1280, .height = 720, .channels = channels});
    if (!drawn) require(drawn.error());
    benchmark::DoNotOptimize(drawn->color.pixels.data());
  };
  for (Renderer& renderer : renderers) frame(renderer);  // uploads
  std::array<std::vector<double>, kSizes.size()> times;
  for (auto _ : state) {
    for (std::size_t i = 0; i < kSizes.size(); ++i) times[i].push_back(milliseconds([&] { frame(renderers[i]); }));
  }
  Times result;
  for (std::size_t i = 0; i < kSizes.size(); ++i) {
    result.ms[i] = median(times[i]);
    result.segments[i] = static_cast<double>(renderers[i].road_statistics().drawn_segments);
  }
  return result;
}

void Frames(benchmark::State& state, unsigned channels) {
  const Times times = street_level(kPoses[state.range(0)], channels, state);
  for (std::size_t i = 0; i < kSizes.size(); ++i) {
    const std::string name = kSizes[i].name;
    state.counters["ms_" + name] = times.ms[i];
    state.counters["drawn_" + name] = times.segments[i];
  }
  state.counters["ratio_1M_10k"] = times.ms.back() / times.ms.front();
}
void Picture(benchmark::State& state) { Frames(state, kColor); }
void DataChannels(benchmark::State& state) { Frames(state, kDepth | kRoad); }
BENCHMARK(Picture)->DenseRange(0, std::size(kPoses) - 1)->Iterations(11)->Unit(benchmark::kMillisecond);
BENCHMARK(DataChannels)->DenseRange(0, 1)->Iterations(11)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace roadgen
