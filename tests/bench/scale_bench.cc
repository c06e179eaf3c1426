// Cities of ten thousand to a million segments: load time, memory, and frame time at street level (OSMesa).
//   build/release/bin/scale_bench
// Every city is the middle of the next larger one. Frames of all cities are drawn in turn, one each, and compared pose by
// pose by the medians of their times: elapsed (ms_...), and of all processors together (cpu_ms_...), which other work on
// the machine disturbs less. `ratio` is of the greatest city to the smallest: the median of all poses, and the worst.
// render() includes the read-back of the picture.
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

// Eyes 1.5 m above the ground near the middle of the cities, in any direction, looking up or down by at most 5 degrees.
constexpr int kPoses = 12;
Camera street_level(int pose) {
  const auto noise = [&](int what) { return test::city_noise(99, pose, what); };
  Camera camera;
  camera.position_m = {400 * noise(0), 400 * noise(1), 1.5};
  camera.yaw_deg = 180 * noise(2);
  camera.pitch_deg = 5 * noise(3);
  camera.fov_deg = 60;
  return camera;
}

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

using Milliseconds = std::vector<double>;

void frames(benchmark::State& state, unsigned channels, double far_m) {
  const auto draw = [&](Renderer& renderer, Camera camera) {
    camera.far_m = far_m;
    auto frame = renderer.render(camera, {.width = 1280, .height = 720, .channels = channels});
    if (!frame) require(frame.error());
    benchmark::DoNotOptimize(frame->color.pixels.data());
  };
  std::array<std::array<Milliseconds, kPoses>, kSizes.size()> elapsed, processor;
  std::array<double, kSizes.size()> drawn{};
  for (int pose = 0; pose < kPoses; ++pose) {
    for (std::size_t i = 0; i < kSizes.size(); ++i) {
      draw(renderers()[i], street_level(pose));  // uploads
      drawn[i] += static_cast<double>(renderers()[i].road_statistics().drawn_segments) / kPoses;
    }
  }
  for (auto _ : state) {
    for (int pose = 0; pose < kPoses; ++pose) {
      for (std::size_t i = 0; i < kSizes.size(); ++i) {
        const auto start = std::chrono::steady_clock::now();
        const std::clock_t cpu_start = std::clock();
        draw(renderers()[i], street_level(pose));
        processor[i][pose].push_back(1e3 * static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC);
        const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
        elapsed[i][pose].push_back(took.count());
      }
    }
  }
  const auto report = [&](const std::string& prefix, const auto& times) {
    Milliseconds ratios;
    for (int pose = 0; pose < kPoses; ++pose) {
      ratios.push_back(median(times.back()[pose]) / median(times.front()[pose]));
    }
    for (std::size_t i = 0; i < kSizes.size(); ++i) {
      Milliseconds of_poses;
      for (const Milliseconds& of_pose : times[i]) of_poses.push_back(median(of_pose));
      state.counters[prefix + "ms_" + kSizes[i].name] = median(of_poses);
    }
    state.counters[prefix + "ratio"] = median(ratios);
    state.counters[prefix + "ratio_worst"] = *std::max_element(ratios.begin(), ratios.end());
  };
  report("", elapsed);
  report("cpu_", processor);
  for (std::size_t i = 0; i < kSizes.size(); ++i) state.counters[std::string("drawn_") + kSizes[i].name] = drawn[i];
}
constexpr double kUnlimited = std::numeric_limits<double>::infinity();
BENCHMARK_CAPTURE(frames, picture, kColor, kUnlimited)->Iterations(7);
BENCHMARK_CAPTURE(frames, depth_and_road, kDepth | kRoad, kUnlimited)->Iterations(5);
BENCHMARK_CAPTURE(frames, depth_and_road_to_3_km, kDepth | kRoad, 3000.0)->Iterations(5);

}  // namespace
}  // namespace roadgen
