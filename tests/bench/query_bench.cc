// Latency and throughput of world to road and road to world, on one core.
//   build/release/bin/query_bench [--points N] [--blocks N] [--only WORDS] [FILE.xodr|FILE.osm[.gz|.pbf]...]
// Rows whose kind of query holds the words of --only, by default all. For every file, and for a street grid of 4 *
// blocks * (blocks + 1) segments, one row of a Markdown table per kind of query. Points are uniform over length and
// width of roads taken by their length, at the surface's height; or uniform in the network's bounds, within a reach of
// 50 m; or along roads in steps of 0.5 m, each the hint of the next. Latencies are of single queries, each the least of
// five passes over all points, so that what the machine does besides drops out while caches stay as cold as the network
// is large; throughput is over a pass by the thread's processor time, of the best pass.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/import/import.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/query/road_index.h"
#include "tests/common/city.h"

namespace roadgen {
namespace {

constexpr int kPasses = 5;
constexpr double kReach_m = 5;
constexpr double kFarReach_m = 50;
constexpr double kStep_m = 0.5;
constexpr std::size_t kBatch = 1000;

double processor_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// What the name of a row must hold.
std::string only;
bool is_left_out(std::string_view query) { return query.find(only) == query.npos; }

// Keeps the answers from being left out by the compiler.
volatile double sink;

// One row: ask(i) for every i in [0, count), alone for latency and in one pass for throughput.
template <class Ask>
void row(const std::string& network, const char* query, std::size_t count, Ask&& ask) {
  if (is_left_out(query)) return;
  using Clock = std::chrono::steady_clock;
  std::vector<float> least(count, 1e30f);
  std::vector<double> rates;
  for (int pass = 0; pass < kPasses; ++pass) {
    double sum = 0;
    const double start = processor_s();
    for (std::size_t i = 0; i < count; ++i) sum += ask(i);
    rates.push_back(static_cast<double>(count) / (processor_s() - start));
    for (std::size_t i = 0; i < count; ++i) {
      const auto before = Clock::now();
      sum += ask(i);
      const std::chrono::duration<float, std::micro> took = Clock::now() - before;
      least[i] = std::min(least[i], took.count());
    }
    sink = sum;
  }
  std::sort(rates.begin(), rates.end());
  std::sort(least.begin(), least.end());
  const auto part = [&](double p) { return least[static_cast<std::size_t>(p * static_cast<double>(count - 1))]; };
  std::printf("| %s | %s | %.2f | %.2f | %.2f | %.1f | %.2f |\n", network.c_str(), query, part(0.5), part(0.99),
              part(0.999), least.back(), 1e-6 * rates.back());
  std::fflush(stdout);
}

// The same for calls of kBatch at once: the rate alone.
template <class Ask>
void batch_row(const std::string& network, const char* query, std::size_t count, Ask&& ask) {
  if (is_left_out(query)) return;
  std::vector<double> rates;
  for (int pass = 0; pass < kPasses; ++pass) {
    double sum = 0;
    const double start = processor_s();
    for (std::size_t i = 0; i < count; i += kBatch) sum += ask(i, std::min(kBatch, count - i));
    rates.push_back(static_cast<double>(count) / (processor_s() - start));
    sink = sum;
  }
  std::sort(rates.begin(), rates.end());
  std::printf("| %s | %s | | | | | %.2f |\n", network.c_str(), query, 1e-6 * rates.back());
  std::fflush(stdout);
}

double answer(const std::optional<RoadPoint>& found) { return found ? found->s_m + found->t_m : 0; }

void measure(const std::string& name, const Network& network, std::size_t points) {
  const auto start = std::chrono::steady_clock::now();
  const RoadIndex index(network);
  const std::chrono::duration<double> built = std::chrono::steady_clock::now() - start;
  const auto segments = static_cast<double>(network.segment_count());
  std::printf("<!-- %s: %zu roads, %.0f segments; index in %.3f s, %.0f bytes a segment -->\n", name.c_str(),
              network.roads.size(), segments, built.count(), static_cast<double>(index.bytes()) / segments);

  // Roads by their length.
  std::vector<double> lengths;
  for (const Road& road : network.roads) lengths.push_back(road.length_m());
  std::mt19937_64 random(1);
  std::discrete_distribution<std::uint32_t> some_road(lengths.begin(), lengths.end());
  std::uniform_real_distribution<double> part(0, 1);
  std::vector<RoadPlace> places(points);
  std::vector<glm::dvec3> on(points), anywhere(points);
  for (std::size_t i = 0; i < points; ++i) {
    RoadPlace& place = places[i];
    place.road = some_road(random);
    const Road& road = network.roads[place.road];
    place.s_m = part(random) * road.length_m();
    const Segment& segment = road.segments[segment_at(road, place.s_m)];
    const double local = place.s_m - segment.s_start_m, left = segment.left_m.value(local);
    place.t_m = left + part(random) * (segment.right_m.value(local) - left);
    on[i] = index.to_world(place).position_m;
  }
  const Bounds box = bounds(network);
  for (glm::dvec3& p : anywhere) {
    p = box.low_m + glm::dvec3(part(random), part(random), part(random)) * (box.high_m - box.low_m);
  }
  // Drives: from a random place along its road, and the wheels of a car there.
  std::vector<glm::dvec3> driven;
  std::vector<std::array<glm::dvec3, 4>> wheels;
  for (std::size_t i = 0; driven.size() < points; ++i) {
    RoadPlace at = places[i];
    for (int step = 0; step < 1000 && driven.size() < points; ++step, at.s_m += kStep_m) {
      if (at.s_m > network.roads[at.road].length_m()) break;
      const RoadPose pose = index.to_world(at);
      const glm::dvec3 ahead(2.7 * std::cos(pose.heading_rad), 2.7 * std::sin(pose.heading_rad), 0);
      const glm::dvec3 left = 0.6 * glm::dvec3(-ahead.y, ahead.x, 0);
      const glm::dvec3 p = pose.position_m;
      driven.push_back(p);
      wheels.push_back({p, p + ahead, p + left, p + ahead + left});
    }
  }

  row(name, "to road, x y z", points, [&](std::size_t i) { return answer(index.to_road(on[i], kReach_m)); });
  row(name, "to road, x y", points, [&](std::size_t i) { return answer(index.to_road(glm::dvec2(on[i]), kReach_m)); });
  row(name, "to road, anywhere", points,
      [&](std::size_t i) { return answer(index.to_road(anywhere[i], kFarReach_m)); });
  std::vector<std::optional<RoadPoint>> many(kBatch);
  const auto batch = [&](const char* query, std::span<const glm::dvec3> of, double reach_m) {
    batch_row(name, query, points, [&](std::size_t begin, std::size_t count) {
      index.to_road(of.subspan(begin, count), reach_m, std::span(many).first(count));
      return answer(many[0]);
    });
  };
  batch("to road, x y z, batch", on, kReach_m);
  batch("to road, anywhere, batch", anywhere, kFarReach_m);
  RoadHint hint;
  row(name, "to road, hint", points, [&](std::size_t i) { return answer(index.to_road(driven[i], kReach_m, &hint)); });
  std::array<std::optional<RoadPoint>, 4> found;
  row(name, "to road, 4 wheels", points, [&](std::size_t i) {
    index.to_road(wheels[i], kReach_m, found, &hint);
    return answer(found[0]) + answer(found[3]);
  });
  row(name, "to world", points, [&](std::size_t i) { return index.to_world(places[i]).position_m.x; });
  std::vector<RoadPose> poses(kBatch);
  batch_row(name, "to world, batch", points, [&](std::size_t begin, std::size_t count) {
    index.to_world(std::span(places).subspan(begin, count), std::span(poses).first(count));
    return poses[0].position_m.x;
  });
}

}  // namespace
}  // namespace roadgen

namespace {

roadgen::Result<roadgen::Network> read(const std::string& file) {
  if (file.ends_with(".xodr")) return roadgen::read_opendrive(file);
  auto imported = roadgen::import_files({file}, {});
  if (!imported) return imported.error();
  return std::move(imported->network);
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t points = 1000000;
  int blocks = 500;
  std::vector<std::string> files;
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    if (argument == "--points" && i + 1 < argc) {
      points = std::strtoull(argv[++i], nullptr, 10);
    } else if (argument == "--blocks" && i + 1 < argc) {
      blocks = std::atoi(argv[++i]);
    } else if (argument == "--only" && i + 1 < argc) {
      roadgen::only = argv[++i];
    } else {
      files.push_back(argument);
    }
  }
  std::puts("| network | query | p50 us | p99 us | p99.9 us | worst us | million per s |");
  std::puts("|---|---|---|---|---|---|---|");
  for (const std::string& file : files) {
    const auto network = read(file);
    if (!network) {
      std::fprintf(stderr, "query_bench: error: %s\n", network.error().text().c_str());
      return 1;
    }
    roadgen::measure(file.substr(file.rfind('/') + 1), *network, points);
  }
  if (blocks > 0) roadgen::measure("grid", roadgen::test::city({.blocks = blocks}), points);
}
