// A city of any size, for tests and benchmarks: streets on a jittered grid, the same ones around the middle whatever
// the size.
#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/road/network.h"

namespace roadgen::test {

struct CityOptions {
  int blocks = 50;               // along each side; the city has 4 * blocks * (blocks + 1) segments
  glm::dvec3 center_m{0, 0, 0};  // of the city, ENU
  double hill_m = 0;             // amplitude of its hills; 0: level
  double jitter_m = 8;           // of the crossings
  std::uint64_t seed = 1;
};
inline constexpr double kBlock_m = 100;

// In [-1, 1): a hash of a place of the grid (splitmix64), so that the middle of a large city is a small city.
inline double city_noise(std::uint64_t seed, int x, int y) {
  std::uint64_t z = seed + 0x9e3779b97f4a7c15u * (static_cast<std::uint32_t>(x) + 1u) +
                    0xd1b54a32d192ed03u * (static_cast<std::uint64_t>(static_cast<std::uint32_t>(y)) + 1u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  z ^= z >> 31;
  return static_cast<double>(z >> 11) * 0x1p-52 - 1;
}

inline Network city(const CityOptions& options) {
  const int low = -(options.blocks / 2), high = low + options.blocks;
  const auto anchor = [&](int half_x, int half_y) {  // in half blocks: crossings at even places, bends between them
    const glm::dvec2 jitter(city_noise(options.seed, half_x, half_y), city_noise(options.seed + 1, half_x, half_y));
    const glm::dvec2 p = 0.5 * kBlock_m * glm::dvec2(half_x, half_y) + options.jitter_m * jitter;
    const double z = options.hill_m * (std::sin(p.x / 170) * std::cos(p.y / 210));
    return Anchor{.position_m = p + glm::dvec2(options.center_m), .elevation_m = options.center_m.z + z};
  };
  Network network;
  std::vector<Anchor> anchors;
  for (const bool eastward : {true, false}) {
    for (int line = low; line <= high; ++line) {
      anchors.clear();
      for (int i = 2 * low; i <= 2 * high; ++i) anchors.push_back(eastward ? anchor(i, 2 * line) : anchor(2 * line, i));
      auto road = road_from_anchors(anchors, {});
      road->id = (eastward ? "E" : "N") + std::to_string(line);
      network.roads.push_back(std::move(*road));
    }
  }
  return network;
}

}  // namespace roadgen::test
