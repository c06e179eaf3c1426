// Cities of ten thousand to a million segments: load time, memory, and frame time at street level (OSMesa).
//   build/release/bin/scale_bench
// Every city is the middle of the next larger one. Frames of all cities are drawn in turn, one each, and compared by the
// medians of their times: elapsed (ms_...), and of all processors together (cpu_ms_...), which other work on the machine
// disturbs less. render() includes the read-back of the picture.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <memory>
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

std::vector<Renderer>& renderers() {
  static std::vector<Renderer> all;
  while (all.size() < kSizes.size()) {
    all.push_back(make_renderer());
    require(all.back().load_roads(network(all.size() - 1)));
  }
  return all;
}

void frames(benchmark::State& state, unsigned channels, double far_m) {
  const Pose& pose = kPoses[state.range(0)];
  Camera camera;
  camera.position_m = {pose.x_m, pose.y_m, 1.5};
  camera.yaw_deg = pose.yaw_deg;
  camera.pitch_deg = pose.pitch_deg;
  camera.fov_deg = 60;
  camera.far_m = far_m;
  const auto draw = [&](Renderer& renderer) {
    auto frame = renderer.render(camera, {.width = 1280, .height = 720, .channels = channels});
    if (!frame) require(frame.error());
    benchmark::DoNotOptimize(frame->color.pixels.data());
  };
  for (Renderer& renderer : renderers()) draw(renderer);  // uploads
  std::array<std::vector<double>, kSizes.size()> elapsed, processor;
  for (auto _ : state) {
    for (std::size_t i = 0; i < kSizes.size(); ++i) {
      const auto start = std::chrono::steady_clock::now();
      const std::clock_t cpu_start = std::clock();
      draw(renderers()[i]);
      processor[i].push_back(1e3 * static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC);
      elapsed[i].push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    }
  }
  for (std::size_t i = 0; i < kSizes.size(); ++i) {
    const std::string name = kSizes[i].name;
    state.counters["ms_" + name] = median(elapsed[i]);
    state.counters["cpu_ms_" + name] = median(processor[i]);
    state.counters["drawn_" + name] = static_cast<double>(renderers()[i].road_statistics().drawn_segments);
  }
  state.counters["ratio"] = median(elapsed.back()) / median(elapsed.front());
  state.counters["cpu_ratio"] = median(processor.back()) / median(processor.front());
}
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
BENCHMARK_CAPTURE(frames, picture, kColor, kUnlimited)->DenseRange(0, std::size(kPoses) - 1)->Iterations(11);
BENCHMARK_CAPTURE(frames, depth_and_road, kDepth | kRoad, kUnlimited)->Arg(0)->Arg(1)->Iterations(11);
BENCHMARK_CAPTURE(frames, depth_and_road_to_3_km, kDepth | kRoad, 3000.0)->Arg(0)->Arg(1)->Iterations(11);

}  // namespace
}  // namespace roadgen
