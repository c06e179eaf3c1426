// Import and preprocessing: segments per second, and bytes per segment on the CPU and the GPU.
//   build/release/bin/preprocess_bench
#include <cmath>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/fit/fit.h"
#include "roadgen/render/road_instance.h"

namespace roadgen {
namespace {

// A winding road: heading is a sum of two waves, so curvature stays below 1 / 25 m.
std::vector<glm::dvec2> winding_points(std::size_t count, double step_m) {
  std::vector<glm::dvec2> points;
  glm::dvec2 p(0, 0);
  for (std::size_t i = 0; i < count; ++i) {
    points.push_back(p);
    const double s = static_cast<double>(i) * step_m;
    const double heading = 1.2 * std::sin(s / 60) + 0.5 * std::sin(s / 23);
    p += step_m * glm::dvec2(std::cos(heading), std::sin(heading));
  }
  return points;
}

std::vector<Anchor> winding_anchors(std::size_t count) {
  std::vector<Anchor> anchors;
  for (const glm::dvec2 p : winding_points(count, 12)) anchors.push_back({.position_m = p, .elevation_m = 0.05 * p.x});
  return anchors;
}

void AnchorsToSegments(benchmark::State& state) {
  const auto anchors = winding_anchors(static_cast<std::size_t>(state.range(0)));
  std::size_t segments = 0;
  for (auto _ : state) {
    auto road = road_from_anchors(anchors, {});
    if (!road) return state.SkipWithError(road.error().text().c_str());
    segments = road->segments.size();
  }
  state.counters["segments/s"] =
      benchmark::Counter(static_cast<double>(segments), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/segment_cpu"] = sizeof(Segment);
  state.counters["segments/anchor"] = static_cast<double>(segments) / static_cast<double>(anchors.size());
}
BENCHMARK(AnchorsToSegments)->Arg(1000)->Arg(100000)->Unit(benchmark::kMillisecond);

void SegmentsToInstances(benchmark::State& state) {
  auto road = road_from_anchors(winding_anchors(10000), {});
  if (!road) return state.SkipWithError(road.error().text().c_str());
  Network network;
  network.roads.push_back(std::move(*road));
  for (auto _ : state) benchmark::DoNotOptimize(road_scene(network));
  state.counters["segments/s"] =
      benchmark::Counter(static_cast<double>(network.segment_count()), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["bytes/segment_gpu"] = sizeof(RoadInstance);
}
BENCHMARK(SegmentsToInstances)->Unit(benchmark::kMillisecond);

void SamplesToFit(benchmark::State& state) {
  std::vector<Sample> samples;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.02);
  for (const glm::dvec2 p : winding_points(static_cast<std::size_t>(state.range(0)), 4)) {
    samples.push_back({.position_m = p + glm::dvec2(noise(random), noise(random)), .elevation_m = 0.05 * p.x});
  }
  std::size_t segments = 0;
  double error = 0;
  for (auto _ : state) {
    auto fitted = fit_road(samples, {});
    if (!fitted) return state.SkipWithError(fitted.error().text().c_str());
    segments = fitted->certificate.segments;
    error = fitted->certificate.max_error_m;
  }
  state.counters["segments/s"] =
      benchmark::Counter(static_cast<double>(segments), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["samples/s"] =
      benchmark::Counter(static_cast<double>(samples.size()), benchmark::Counter::kIsIterationInvariantRate);
  state.counters["max_error_m"] = error;
}
BENCHMARK(SamplesToFit)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace roadgen
