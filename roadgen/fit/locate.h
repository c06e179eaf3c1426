// Where samples stand on a road. Internal to roadgen/fit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "roadgen/fit/fit.h"

namespace roadgen {

struct Located {
  double distance_m = 0;  // to the nearest point of the whole road
  // The nearest point beside the place of the sample before (at first, the road's start), which differs from that where
  // the road crosses or touches itself.
  std::size_t segment = 0;
  double u = 0;    // of the segment
  double s_m = 0;  // of the road
};

// Requires: the road has segments; samples in the order of the road. Cost: O((samples + segments) log segments).
std::vector<Located> locate(const Road& road, std::span<const Sample> samples);

}  // namespace roadgen
