// Where roads do not lie on the ground: bridges leave it alone, tunnels keep the hill above them.
#include "terrain/support.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "terrain/levelling.h"
#include "terrain/plates.h"
#include "terrain/terrain.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::road_along;
using testing::scratch_folder;
using testing::straight;
using testing::write_ascii_grid;

constexpr double kPi = std::numbers::pi;
constexpr double kLeast_m = 0.02, kMost_m = 0.12;  // TerrainOptions' defaults
constexpr double kHeading = 0.35;                  // of the roads, askew to the mesh

// Metres along the roads' common direction, and to its left, from the origin.
glm::dvec2 place(double along, double aside) {
  return {along * std::cos(kHeading) - aside * std::sin(kHeading),
          along * std::sin(kHeading) + aside * std::cos(kHeading)};
}

// A level straight road of 8 m from along = -150 to 150.
Road level_road(const std::string& id, double z, double aside = 0) {
  return road_along(
      id, 300, 30, 4, [=](double s) { return straight(place(s - 150, aside), kHeading, s * 0); },
      [=](double) { return z; });
}

// Three level roads that meet in a junction at the origin; dress adds to each of them.
Network star(double length_m, double z, const std::function<void(Road&)>& dress) {
  Network network;
  std::vector<JunctionArm> arms;
  for (int i = 0; i < 3; ++i) {
    const double heading = i * 2 * kPi / 3;
    const glm::dvec2 outward(std::cos(heading), std::sin(heading));
    const std::string id = std::to_string(i);
    network.roads.push_back(road_along(
        id, length_m, 20, 3.5, [=](double s) { return straight(12.0 * outward, heading, s); },
        [=](double) { return z; }));
    dress(network.roads.back());
    arms.push_back({.road = id, .position_m = 12.0 * outward, .heading_rad = heading + kPi, .elevation_m = z});
  }
  auto junction = make_junction("j", arms);
  EXPECT_TRUE(junction.ok());
  if (junction.ok()) network.junctions.push_back(*junction);
  return network;
}

using Hills = std::function<double(double along, double aside)>;
Elevation elevation_of(const Hills& hills) {
  const auto height = [&](double x, double y) {
    const double along = x * std::cos(kHeading) + y * std::sin(kHeading);
    return hills(along, y * std::cos(kHeading) - x * std::sin(kHeading));
  };
  auto e = Elevation::open(write_ascii_grid(scratch_folder() + "/hills.asc", {-600, -600}, 5, 241, 241, height));
  EXPECT_TRUE(e);
  return std::move(*e);
}

Terrain build(const Network& network, const Elevation* elevation) {
  TerrainOptions options;
  options.margin_m = 200;
  auto terrain = Terrain::build(network, elevation, options);
  EXPECT_TRUE(terrain) << terrain.error().text();
  return std::move(*terrain);
}

// Least and greatest height of a road over the ground for s in [from, to], by the road's own poses.
testing::Clearance clearance(const Road& road, double from, double to, const Terrain& terrain) {
  testing::Clearance c{1e300, -1e300, 0};
  for (double s = from; s <= to; s += 0.25) {
    for (double t = -4; t <= 4; t += 0.25) {
      const RoadPose pose = pose_at(road, s, t);
      const double over = pose.position_m.z - terrain.height_m(glm::dvec2(pose.position_m));
      c.min_m = std::min(c.min_m, over), c.max_m = std::max(c.max_m, over);
      ++c.samples;
    }
  }
  return c;
}

Supports supports_of(const Network& network) {
  return Supports(
      network, [](glm::dvec2) { return 0.0; }, 0.5, 15);
}

// A valley 12 m deep, between along = -60 and 60; its sides rise by at most 0.3.
double valley_m(double along) {
  const double q = std::clamp(std::abs(along) / 60, 0.0, 1.0);
  return 500 - 12 * (1 - q * q * (3 - 2 * q));
}

TEST(Supports, CutARoadIntoPartsWithoutGaps) {
  Network network;
  network.roads.push_back(level_road("1", 0));
  network.roads.push_back(level_road("2", 0, 50));
  Road& road = network.roads[0];
  // Overlapping, next to a joint, beyond the road, and not a number: ends are cut off, nonsense is left out.
  const double joint = road.segments[2].s_start_m;
  road.bridges = {{.s_start_m = 40, .s_end_m = joint + 1e-4}, {.s_start_m = 20, .s_end_m = 45},
                  {.s_start_m = 250, .s_end_m = 1e9},         {.s_start_m = NAN, .s_end_m = 5},
                  {.s_start_m = 5, .s_end_m = NAN},           {.s_start_m = 9, .s_end_m = 8}};
  const Supports supports = supports_of(network);
  EXPECT_EQ(supports.parts(Support::kBridge), 2u);
  EXPECT_NEAR(supports.length_m(Support::kBridge), joint - 20 + 50, 1e-6);
  double bridge_m = 0;
  for (SegmentRef at{0, 0}; at.segment < road.segments.size(); ++at.segment) {
    double s = 0;
    for (const SupportedPart& part : supports.of(network, at)) {
      EXPECT_EQ(part.s0_m, s);
      EXPECT_GT(part.s1_m, part.s0_m);
      EXPECT_NEAR(arc_at(road.segments[at.segment], part.u1), part.s1_m, 1e-9);
      if (part.support == Support::kBridge) bridge_m += part.s1_m - part.s0_m;
      s = part.s1_m;
    }
    EXPECT_EQ(s, road.segments[at.segment].arc_m);
  }
  EXPECT_NEAR(bridge_m, supports.length_m(Support::kBridge), 1e-9);
  // Where a bridge begins within a segment both sides have an end; at the joint too.
  const auto first = supports.of(network, {0, 0}), second = supports.of(network, {0, 1}),
             third = supports.of(network, {0, 2});
  ASSERT_EQ(first.size(), 2u);
  EXPECT_TRUE(first[0].starts_here && first[0].ends_here && first[1].starts_here && !first[1].ends_here);
  ASSERT_EQ(second.size(), 1u);
  EXPECT_TRUE(!second[0].starts_here && second[0].ends_here && second[0].support == Support::kBridge);
  ASSERT_EQ(third.size(), 1u);
  EXPECT_TRUE(third[0].starts_here && !third[0].ends_here && third[0].support == Support::kGround);
  // A road without bridges.
  EXPECT_EQ(supports.of(network, {1, 4}).size(), 1u);
  EXPECT_EQ(supports.of(network, {1, 4})[0].support, Support::kGround);
}

TEST(Terrain, ABridgeLeavesTheValleyAlone) {
  const Elevation elevation = elevation_of([](double along, double) { return valley_m(along); });
  Network network;
  network.roads.push_back(level_road("1", 501));
  const Terrain filled = build(network, &elevation);
  EXPECT_LE(filled.report().clearance_max_m, kMost_m);
  EXPECT_GT(filled.height_m({0, 0}), 500.8);

  network.roads[0].bridges = {{.s_start_m = 110, .s_end_m = 190}};
  const Terrain terrain = build(network, &elevation);
  const TerrainReport& report = terrain.report();
  EXPECT_EQ(report.bridge_parts, 1u);
  EXPECT_NEAR(report.bridge_m, 80, 1e-6);
  EXPECT_LT(report.highest_fill_m, filled.report().highest_fill_m - 5);
  EXPECT_NEAR(terrain.height_m({0, 0}), 488, 0.25);
  // On the ground as ever, and proven to be.
  for (const auto& [from, to] : {std::pair(0.0, 110.0), std::pair(190.0, 300.0)}) {
    const testing::Clearance c = clearance(network.roads[0], from, to, terrain);
    EXPECT_GE(c.min_m, kLeast_m);
    EXPECT_LE(c.max_m, kMost_m);
  }
  EXPECT_GE(report.clearance_min_m, kLeast_m);
  EXPECT_LE(report.clearance_max_m, kMost_m);
  EXPECT_GE(clearance(network.roads[0], 110, 190, terrain).min_m, kLeast_m);
  // The abutment: level for the shoulder's width, then no steeper than loose fill, but for the mesh's tolerance, until the
  // natural ground.
  const LevellingOptions levelling;
  for (const double end : {-40.0, 40.0}) {
    const double inward = end < 0 ? 1 : -1;
    EXPECT_NEAR(terrain.height_m(place(end + inward * 1, 0)), 501 - levelling.gap_m, 0.1);
    double steepest = 0, met = 0;
    for (double d = 0; d < 38; d += 0.5) {
      const double z = terrain.height_m(place(end + inward * d, 0)),
                   next = terrain.height_m(place(end + inward * (d + 2), 0));
      steepest = std::max(steepest, (z - next) / 2);
      if (met == 0 && z < valley_m(end + inward * d) + 0.3) met = d;
    }
    EXPECT_LT(steepest, levelling.fill_slope + 0.1);
    EXPECT_GT(steepest, 0.4);
    EXPECT_GT(met, levelling.shoulder_m);
    EXPECT_LT(met, 38);
  }
}

TEST(Terrain, GroundThatRisesAboveABridgeIsCut) {
  const Elevation elevation =
      elevation_of([](double along, double) { return 495 + 12 * std::exp(-along * along / 400); });
  Network network;
  network.roads.push_back(level_road("1", 500));
  network.roads[0].bridges = {{.s_start_m = 50, .s_end_m = 250}};
  const Terrain terrain = build(network, &elevation);
  const testing::Clearance c = clearance(network.roads[0], 50, 250, terrain);
  EXPECT_GE(c.min_m, kLeast_m);
  EXPECT_NEAR(c.max_m, 5, 0.3);
  EXPECT_GE(terrain.report().clearance_min_m, kLeast_m);
  // Beside the deck a cutting, as steep as one: 7 m of hill at the road's middle.
  for (const double side : {-1, 1}) {
    EXPECT_LT(terrain.height_m(place(0, side * 6)), 500);
    EXPECT_LT(terrain.height_m(place(0, side * 9)), 500 + 2.5);
    EXPECT_NEAR(terrain.height_m(place(0, side * 25)), 507, 0.5);
  }
}

TEST(Terrain, ABridgeOverACutRoadLeavesTheCutting) {
  // The lower road lies 6 m deep in a plain, the bridge on its height.
  const Elevation elevation = elevation_of([](double, double) { return 500.0; });
  Network network;
  network.roads.push_back(level_road("bridge", 500));
  network.roads[0].bridges = {{.s_start_m = 136, .s_end_m = 164}};
  const glm::dvec2 start = place(0, -100);
  network.roads.push_back(road_along(
      "low", 200, 20, 4, [=](double s) { return straight(start, kHeading + kPi / 2, s); },
      [](double) { return 494.0; }));
  const Terrain terrain = build(network, &elevation);
  const TerrainReport& report = terrain.report();
  EXPECT_GE(report.clearance_min_m, kLeast_m);
  // The cutting under the bridge is the low road's own, and nothing is too deep any more: the proof counts both.
  const testing::Clearance low = clearance(network.roads[1], 0, 200, terrain);
  EXPECT_GE(low.min_m, kLeast_m);
  EXPECT_LE(low.max_m, kMost_m);
  EXPECT_LE(report.clearance_max_m, kMost_m);
  EXPECT_EQ(report.too_deep, 0);
  const testing::Clearance high = clearance(network.roads[0], 136, 164, terrain);
  EXPECT_GE(high.min_m, kLeast_m);
  EXPECT_NEAR(high.max_m, 6, 0.15);
}

TEST(Terrain, AJunctionWhoseArmsAreAllOnBridgesStandsOverTheGround) {
  Network network = star(100, 510, [](Road& road) { road.bridges = {{.s_start_m = 0, .s_end_m = 60}}; });
  ASSERT_EQ(network.junctions.size(), 1u);
  const Elevation elevation = elevation_of([](double, double) { return 500.0; });
  EXPECT_EQ(supports_of(network).of_junction(0), Support::kBridge);
  const Terrain bridge = build(network, &elevation);
  EXPECT_NEAR(bridge.height_m({0, 0}), 500, 0.2);
  EXPECT_LE(bridge.report().clearance_max_m, kMost_m);
  // Cut where a hill rises above it.
  const Elevation hill = elevation_of([](double, double) { return 515.0; });
  EXPECT_LT(build(network, &hill).height_m({0, 0}), 510 - kLeast_m);
  // One arm on the ground, and the area lies on it too.
  network.roads[1].bridges.clear();
  EXPECT_EQ(supports_of(network).of_junction(0), Support::kGround);
  const Terrain ground = build(network, &elevation);
  EXPECT_GT(ground.height_m({0, 0}), 509.8);
  // Its fill falls to the plain on all sides, no steeper than fill stands, also where no road on the ground is about.
  Grid plain;
  plain.origin_m = {-200, -200};
  plain.step_m = {5, 5};
  plain.columns = plain.rows = 81;
  plain.values.assign(81 * 81, 500);
  const RoadIndex index(network);
  const Levelling levelling(index, plain, {});
  for (double x = -80; x <= 80; x += 0.5) {
    for (double y = -80; y <= 80; y += 0.5) ASSERT_TRUE(std::isfinite(levelling.height_m({x, y}))) << x << " " << y;
  }
  for (int i = 0; i < 72; ++i) {
    const double heading = i * kPi / 36;
    double above = ground.height_m({0, 0});
    for (double d = 1; d <= 42; d += 1) {
      const double height = ground.height_m(d * glm::dvec2(std::cos(heading), std::sin(heading)));
      ASSERT_GT(height, 499.8) << i << " " << d;
      ASSERT_LT(std::abs(height - above), 1.2) << i << " " << d;
      above = height;
    }
    EXPECT_TRUE(std::abs(heading - 2 * kPi / 3) < 0.8 || above < 500.5) << i << " " << above;
  }
}

TEST(Terrain, WithoutElevationTheGroundDoesNotRiseToBridges) {
  Network network;
  const auto arched = [](double s) {
    return s > 100 && s < 200 ? 6 * std::pow(std::sin((s - 100) * kPi / 100), 2) : 0;
  };
  network.roads.push_back(road_along(
      "1", 300, 10, 4,
      [](double s) {
        return straight({-150, 0}, 0, s);
      },
      arched));
  // Two bridges in a row, as files have them.
  network.roads[0].bridges = {{.s_start_m = 110, .s_end_m = 150}, {.s_start_m = 150, .s_end_m = 190}};
  const Terrain terrain = build(network, nullptr);
  EXPECT_LT(terrain.height_m({0, 0}), 0.6);
  EXPECT_EQ(terrain.report().bridge_parts, 1u);
  EXPECT_LE(terrain.report().clearance_max_m, kMost_m);
}

// A ridge across the road, 24 m over it at along = 0; its sides are steeper than cuttings stand.
double ridge_m(double along, double) { return 500 + 24 / (1 + std::pow(along / 45, 6)); }

// With a tunnel of that length in the middle.
Network tunnel_network(double length_m, const Tunnel& shape = {.half_width_m = 5}) {
  Network network;
  network.roads.push_back(level_road("1", 500));
  network.roads[0].sweeps = {
      {.s_start_m = 150 - 0.5 * length_m, .s_end_m = 150 + 0.5 * length_m, .t_m = 0, .t_slope = 0, .shape = shape}};
  return network;
}

// Many points of all triangles: what lies in the clear space of a tunnel along the common line, from `from` to `to`, is
// in the hollow of a cut. Returns how many such there are.
std::size_t expect_cut_in_tunnel(const Terrain& terrain, double from, double to) {
  const Tunnel x;
  const double a = x.half_width_m, radius = (a * a + x.arch_rise_m * x.arch_rise_m) / (2 * x.arch_rise_m);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t inside = 0;
  for (const TerrainMesh& tile : terrain.tiles()) {
    for (std::size_t i = 0; i + 2 < tile.triangles.size(); i += 3) {
      const TerrainMesh::Cut* cut = nullptr;
      for (const TerrainMesh::Cut& c : tile.cuts) {
        if (i >= c.first && i < c.first + c.count) cut = &c;
      }
      EXPECT_EQ(cut == nullptr, i < tile.whole());
      std::array<glm::dvec3, 3> p;
      for (std::size_t k = 0; k < 3; ++k) p[k] = tile.origin_m + glm::dvec3(tile.positions_m[tile.triangles[i + k]]);
      if (glm::length(glm::dvec2(p[0])) > 200) continue;
      for (int j = 0; j < 200; ++j) {
        double u = unit(random), v = unit(random);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        const glm::dvec3 at = p[0] + u * (p[1] - p[0]) + v * (p[2] - p[0]);
        const double along = at.x * std::cos(kHeading) + at.y * std::sin(kHeading), h = at.z - 500;
        const double aside = at.y * std::cos(kHeading) - at.x * std::sin(kHeading);
        if (along < from || along > to || h < 0) continue;
        if (Lib::sweep_vault(aside, h, a, x.wall_height_m + x.arch_rise_m - radius, radius) > 0) continue;
        ++inside;
        const bool held = cut && std::any_of(cut->hollows.begin(), cut->hollows.end(),
                                             [&](std::uint32_t hollow) { return tile.hollows[hollow].holds(at); });
        EXPECT_TRUE(held) << along << ", " << aside << ", " << h;
        if (!held) return inside;
      }
    }
  }
  return inside;
}

TEST(Terrain, ATunnelKeepsTheHill) {
  const Elevation elevation = elevation_of(ridge_m);
  Network network = tunnel_network(80);
  const Road& road = network.roads[0];
  const Terrain terrain = build(network, &elevation);
  const TerrainReport& report = terrain.report();
  EXPECT_EQ(report.tunnel_parts, 1u);
  EXPECT_NEAR(report.tunnel_m, 80, 1e-6);
  const LevellingOptions levelling;
  const Tunnel tunnel;
  const double vault = 500 + tunnel.wall_height_m + tunnel.arch_rise_m + tunnel.lining_m;
  // The hill is there, and from the portals on over the vault nothing is dug up; before them the road lies free.
  // Of the ridge's top the rounded crest of the portals' cuttings takes a hundredth, and the mesh has its tolerance.
  for (double along = -4; along <= 4; along += 1) {
    for (double aside = -30; aside <= 30; aside += 1) {
      EXPECT_NEAR(terrain.height_m(place(along, aside)), ridge_m(along, aside), 0.25 + 0.2) << along << ", " << aside;
    }
  }
  const double inside = levelling.shoulder_m + 3;  // and a post's distance
  for (double along = -40 + inside; along <= 40 - inside; along += 0.5) {
    for (double aside = -5; aside <= 5; aside += 0.5) {
      EXPECT_GT(terrain.height_m(place(along, aside)), vault) << along << ", " << aside;
    }
  }
  // Its face over the portals is no steeper than a cutting, which would meet the ridge after 24 m.
  EXPECT_LT(terrain.height_m(place(-40 + 12, 0)), 500 + 12 * levelling.cut_slope);
  // On the ground the guarantee is what it was.
  for (const auto& [from, to] : {std::pair(0.0, 110.0), std::pair(190.0, 300.0)}) {
    const testing::Clearance c = clearance(road, from, to, terrain);
    EXPECT_GE(c.min_m, kLeast_m);
    EXPECT_LE(c.max_m, kMost_m);
  }
  EXPECT_GE(report.clearance_min_m, kLeast_m);
  EXPECT_LE(report.clearance_max_m, kMost_m);
  EXPECT_GT(report.triangles_cut, 10u);
  EXPECT_LT(report.triangles_cut, 400u);
  EXPECT_GT(expect_cut_in_tunnel(terrain, -40, 40), 100u);
}

TEST(Terrain, TellsTheHillFromTheTunnel) {
  const Elevation elevation = elevation_of(ridge_m);
  const Network network = tunnel_network(80);
  const Road& road = network.roads[0];
  const Terrain terrain = build(network, &elevation);
  std::mt19937 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 5000; ++i) {
    const double s = 150 + 39.9 * unit(random), t = 5 * unit(random);
    const glm::dvec3 floor = pose_at(road, s, t).position_m + glm::dvec3(0, 0, std::abs(t) > 3.5 ? 0.12 : 0);
    const glm::dvec2 at(floor);
    // A little above the floor and below it, up to under the vault; the hill from the vault's outside on.
    for (const double up : {-0.5, 0.0, 0.4, 2.5}) {
      ASSERT_NEAR(terrain.height_m(floor + glm::dvec3(0, 0, up)), floor.z, 1e-6);
    }
    ASSERT_EQ(terrain.normal(floor), glm::dvec3(0, 0, 1));
    const double mesh = terrain.height_m(at);
    ASSERT_EQ(terrain.height_m(glm::dvec3(at, 500 + 2.6 + 4 + 0.45)), mesh);
    ASSERT_EQ(terrain.normal(glm::dvec3(at, 520)), terrain.normal(at));
  }
  // Beside the vault and before the portals there is no tunnel.
  for (const glm::dvec2 at : {place(0, 5.5), place(-41, 0), place(41, 4), place(100, 0)}) {
    EXPECT_EQ(terrain.height_m(glm::dvec3(at, 500)), terrain.height_m(at));
  }
}

TEST(Terrain, WhereTheHillDoesNotCoverATunnelItIsCutOpen) {
  // 5 m of hill over the road, the vault is 7 m high.
  const Elevation low = elevation_of([](double along, double) { return 500 + 5 * std::exp(-along * along / 900); });
  const Network network = tunnel_network(60);
  const Terrain open = build(network, &low);
  EXPECT_EQ(open.report().tunnel_parts, 0u);
  EXPECT_EQ(open.report().triangles_cut, 0u);
  const testing::Clearance c = clearance(network.roads[0], 0, 300, open);
  EXPECT_GE(c.min_m, kLeast_m);
  EXPECT_LE(c.max_m, kMost_m);
  // The hill covers the middle of a long tunnel: its ends stand free, cut open.
  const Elevation ridge = elevation_of(ridge_m);
  const Terrain partly = build(tunnel_network(200), &ridge);
  EXPECT_EQ(partly.report().tunnel_parts, 1u);
  EXPECT_GT(partly.report().tunnel_m, 90);
  EXPECT_LT(partly.report().tunnel_m, 125);
  EXPECT_NEAR(partly.height_m({0, 0}), 524, 0.5);
  EXPECT_LT(partly.height_m(place(-80, 0)), 500);
  EXPECT_LE(partly.report().clearance_max_m, kMost_m);
  EXPECT_GT(expect_cut_in_tunnel(partly, -100, 100), 100u);
  // A road wider than its vault is not kept from the ground by it.
  Network wide = tunnel_network(80, {.half_width_m = 3.5, .arch_rise_m = 3, .walkway_m = 0});
  EXPECT_EQ(build(wide, &ridge).report().tunnel_parts, 0u);
}

TEST(Terrain, ATunnelShorterThanItsCoverIsKeptOrCutOpenAsAWhole) {
  const Elevation elevation = elevation_of(ridge_m);
  // 20 m under 24: a bridge of earth over the cutting, the cuttings' slopes to both sides.
  const Terrain kept = build(tunnel_network(20), &elevation);
  EXPECT_EQ(kept.report().tunnel_parts, 1u);
  EXPECT_GT(kept.height_m({0, 0}), 507.05);
  EXPECT_LT(kept.height_m({0, 0}), 515);
  EXPECT_LT(kept.height_m(place(12, 0)), 500);
  EXPECT_GE(kept.report().clearance_min_m, kLeast_m);
  EXPECT_LE(kept.report().clearance_max_m, kMost_m);
  EXPECT_GT(expect_cut_in_tunnel(kept, -10, 10), 20u);
  // Less than five shoulders: there would be no room for a hill.
  const Terrain open = build(tunnel_network(12), &elevation);
  EXPECT_EQ(open.report().tunnel_parts, 0u);
  EXPECT_LT(open.height_m({0, 0}), 500);
}

TEST(Terrain, TunnelsOnRoadsThatFollowOneAnotherHaveOneHill) {
  // As files have them: a road for every way, the middle one shorter than any hill.
  const Elevation elevation = elevation_of(ridge_m);
  Network network;
  const double ends[] = {-150, -40, -4, 5, 40, 150};
  for (int i = 0; i < 5; ++i) {
    const double from = ends[i], length = ends[i + 1] - from;
    network.roads.push_back(road_along(
        std::to_string(i), length, 20, 4, [=](double s) { return straight(place(from, 0), kHeading, s); },
        [](double) { return 500.0; }));
    if (i > 0 && i < 4) network.roads.back().sweeps = {{.s_start_m = 0, .s_end_m = length, .shape = Tunnel{}}};
  }
  const Terrain terrain = build(network, &elevation);
  EXPECT_EQ(terrain.report().tunnel_parts, 3u);
  for (double along = -30; along <= 30; along += 0.5) {
    EXPECT_GT(terrain.height_m(place(along, 0)), 507.05) << along;
  }
  EXPECT_GE(terrain.report().clearance_min_m, kLeast_m);
  EXPECT_GT(expect_cut_in_tunnel(terrain, -40, 40), 100u);
}

TEST(Terrain, ABridgeJustAboveTheGroundIsNotFilledTo) {
  const Elevation elevation = elevation_of([](double, double) { return 500.0; });
  Network network;
  network.roads.push_back(level_road("1", 500.2));
  network.roads[0].bridges = {{.s_start_m = 0, .s_end_m = 300}};
  const Terrain terrain = build(network, &elevation);
  EXPECT_NEAR(terrain.height_m({0, 0}), 500, 0.01);
  EXPECT_EQ(terrain.report().too_deep, 0);
}

// The vault is 7.05 m high and wants 0.5 m of cover: what little lacks is filled up, more is cut open.
TEST(Terrain, AShallowTunnelIsCoveredByFill) {
  const double vault = 500 + 2.6 + 4 + 0.45;
  for (const double hill : {6.0, 5.1, 4.9}) {
    const Elevation plateau =
        elevation_of([&](double along, double) { return 500 + hill / (1 + std::pow(along / 50, 20)); });
    const Terrain terrain = build(tunnel_network(70), &plateau);
    EXPECT_EQ(terrain.report().tunnel_parts, hill > 5 ? 1u : 0u) << hill;
    EXPECT_GE(terrain.report().clearance_min_m, kLeast_m);
    EXPECT_LE(terrain.report().clearance_max_m, kMost_m);
    if (hill < 5) continue;
    for (double along = -25; along <= 25; along += 1) EXPECT_GT(terrain.height_m(place(along, 0)), vault) << along;
    EXPECT_NEAR(terrain.height_m(place(0, 25)), 500 + hill, 0.15);
    EXPECT_GT(expect_cut_in_tunnel(terrain, -35, 35), 50u);
  }
}

// But not where a road on the ground beside it is in the way.
TEST(Terrain, NoFillIsPutOnARoad) {
  const Elevation plateau = elevation_of([](double along, double) { return 500 + 6 / (1 + std::pow(along / 50, 20)); });
  Network network = tunnel_network(70);
  network.roads.push_back(road_along(
      "across", 100, 20, 4, [](double s) { return straight(place(0, s - 50), kHeading + kPi / 2, s); },
      [](double) { return 506.0; }));
  const Terrain terrain = build(network, &plateau);
  EXPECT_GE(terrain.report().clearance_min_m, kLeast_m);
  EXPECT_LE(terrain.report().clearance_max_m, kMost_m);
  EXPECT_LT(terrain.height_m(place(0, 20)), 506);
}

// Three tunnels meet in a junction under a hill, which is kept over it; the area's floor is told below it.
TEST(Terrain, AJunctionInTunnelsIsUnderTheHill) {
  const auto network_of = [](int tunnels) {
    return star(150, 500, [=, left = tunnels](Road& road) mutable {
      if (left-- > 0) road.sweeps = {{.s_end_m = 60, .shape = Tunnel{.half_width_m = 5}}};
      road.joined_start = true;
    });
  };
  const Elevation hill =
      elevation_of([](double x, double y) { return 500 + 20 / (1 + std::pow(std::hypot(x, y) / 75, 8)); });
  const Terrain kept = build(network_of(3), &hill);
  EXPECT_EQ(kept.report().tunnel_parts, 3u);
  EXPECT_EQ(kept.report().tunnel_areas, 1u);
  for (int i = 0; i < 36; ++i) {
    const glm::dvec2 at = (i % 6) * 2.0 * glm::dvec2(std::cos(i * 0.5), std::sin(i * 0.5));
    EXPECT_GT(kept.height_m(at), 515) << i;
  }
  for (const double up : {-0.5, 0.2, 3.0}) EXPECT_NEAR(kept.height_m(glm::dvec3(1, 2, 500 + up)), 500, 1e-6);
  EXPECT_EQ(kept.height_m(glm::dvec3(1, 2, 510)), kept.height_m(glm::dvec2(1, 2)));
  EXPECT_GT(kept.normal(glm::dvec3(1, 2, 500)).z, 1 - 1e-6);
  EXPECT_LE(kept.report().clearance_max_m, kMost_m);
  // One arm in the open: the area is cut open.
  const Terrain open = build(network_of(2), &hill);
  EXPECT_EQ(open.report().tunnel_areas, 0u);
  EXPECT_LT(open.height_m({1, 2}), 500);
}

}  // namespace
}  // namespace roadgen
