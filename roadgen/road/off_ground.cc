#include "roadgen/road/off_ground.h"

#include <algorithm>

namespace roadgen {

bool is_off_ground(const Road& road, double s_m) {
  constexpr double kRounding_m = 1e-6;
  const auto holds = [&](const auto& part) {
    return part.s_start_m - kRounding_m <= s_m && s_m <= part.s_end_m + kRounding_m;
  };
  return std::any_of(road.bridges.begin(), road.bridges.end(), holds) ||
         std::any_of(road.sweeps.begin(), road.sweeps.end(),
                     [&](const Sweep& sweep) { return sweep.kind() == SweepKind::kTunnel && holds(sweep); });
}

}  // namespace roadgen
