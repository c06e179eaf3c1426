// Vaults under other roads: they end where a road passes through them, and nowhere else.
#include <gtest/gtest.h>

#include "roadgen/road/vault_room.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::road_along;
using testing::straight;

// A tunnel of 200 m along x at height 0, and a road of 8 m across it at x = 0.
Network crossing(double above_m, double turn_rad = 1.5707963267948966) {
  Network network;
  network.roads.push_back(road_along(
      "tunnel", 200, 20, 3.5,
      [](double s) {
        return straight({-100, 0}, 0, s);
      },
      [](double) { return 0.0; }));
  network.roads[0].sweeps = {{.s_start_m = 0, .s_end_m = 200, .shape = Tunnel{}}};
  const glm::dvec2 ahead(std::cos(turn_rad), std::sin(turn_rad));
  network.roads.push_back(road_along(
      "across", 100, 20, 4, [=](double s) { return straight(-50.0 * ahead, turn_rad, s); },
      [=](double) { return above_m; }));
  return network;
}

TEST(VaultRoom, RoadsAboveOrBesideOrBelowLeaveTheVaultAlone) {
  for (const double above : {7.3, 20.0, 0.0, -3.0}) {
    Network network = crossing(above);
    EXPECT_TRUE(trim_vaults(network).empty()) << above;
    ASSERT_EQ(network.roads[0].sweeps.size(), 1u);
    EXPECT_EQ(network.roads[0].sweeps[0].s_end_m, 200);
  }
}

// At any angle: no vault at any point under the road, and no more is taken than the road covers of the vault, to the whole
// steps of 2 m, and two to either side.
TEST(VaultRoom, ARoadThroughTheVaultTakesItAwayThere) {
  for (const double turn : {1.5707963267948966, 1.0, 0.6, -1.2}) {
    for (const double above : {0.4, 1.2, 4.0, 7.0}) {
      Network network = crossing(above, turn);
      const std::vector<VaultGap> gaps = trim_vaults(network);
      ASSERT_EQ(gaps.size(), 1u);
      EXPECT_EQ(gaps[0].road, 0u);
      const double half = 4 / std::abs(std::sin(turn));
      EXPECT_LT(gaps[0].s_start_m, 100 - half);
      EXPECT_GT(gaps[0].s_end_m, 100 + half);
      EXPECT_LT(gaps[0].s_end_m - gaps[0].s_start_m, 2 * half + 12 / std::abs(std::tan(turn)) + 12.1);
      ASSERT_EQ(network.roads[0].sweeps.size(), 2u);
      EXPECT_NEAR(network.roads[0].sweeps[0].s_end_m, gaps[0].s_start_m, 1e-9);
      EXPECT_NEAR(network.roads[0].sweeps[1].s_start_m, gaps[0].s_end_m, 1e-9);
      EXPECT_TRUE(trim_vaults(network).empty());
    }
  }
}

}  // namespace
}  // namespace roadgen
