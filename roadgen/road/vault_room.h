// Tunnels under other roads: where there is room for their vaults.
#pragma once

#include <cstdint>
#include <vector>

#include "roadgen/road/network.h"

namespace roadgen {

// A part of a road whose vault was taken away.
struct VaultGap {
  std::uint32_t road = 0;  // of the network's
  double s_start_m = 0, s_end_m = 0;
};

// Takes vaults of tunnels away where a road or an area passes through them: where its surface lies below the vault's
// outside and above the tunnel's road by kBesideVault_m or more, or kCrossingVault_m where its middle crosses the tunnel
// at 30 degrees or more or the area is another one than the tunnel's; seen about every 2 m. What is left of a tunnel
// stays, but for pieces shorter than kLeastVault_m. Cost: O(metres of tunnels + segments).
std::vector<VaultGap> trim_vaults(Network& network);
inline constexpr double kBesideVault_m = 1;  // what lies lower is a road that parts from the tunnel's
inline constexpr double kCrossingVault_m = 0.05;
inline constexpr double kLeastVault_m = 2;

}  // namespace roadgen
