// Heights of whole networks fitted to the ground: optima that are known, limits that hold on the cubics, and junctions,
// bridges and noise.
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "roadgen/fit/heights.h"
#include "roadgen/fit/linear_fit.h"
#include "roadgen/import/import.h"
#include "roadgen/road/crossing.h"
#include "terrain/levelling.h"
#include "terrain/natural.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

namespace fs = std::filesystem;
using testing::road_along;
using testing::straight;

constexpr double kPi = std::numbers::pi;

double flat(double) { return 0; }

Network one_road(double length_m, double step_m) {
  Network network;
  network.roads.push_back(road_along(
      "1", length_m, step_m, 3.5,
      [](double s) {
        return straight({0, 0}, 0, s);
      },
      flat));
  return network;
}

GroundHeight ground(const std::function<double(double, double)>& z) {
  return [=](glm::dvec2 p) { return std::optional(z(p.x, p.y)); };
}

// Of all cubics, by their own extremes; not by the code under test.
struct Extremes {
  double grade = 0, bend = 0;
};
Extremes extremes(const Road& road) {
  Extremes e;
  for (const Segment& segment : road.segments) {
    const Cubic& z = segment.elevation_m;
    std::vector<double> places = {0, segment.arc_m};
    if (z.c3 != 0) places.push_back(std::clamp(-z.c2 / (3 * z.c3), 0.0, segment.arc_m));
    for (const double s : places) {
      e.grade = std::max(e.grade, std::abs(z.slope(s)));
      e.bend = std::max(e.bend, std::abs(z.second(s)));
    }
  }
  return e;
}

TEST(LinearFit, KeepsBoundsAndYieldsOnlyWhereTheyContradict) {
  // (x - 3)^2 + (y - 1)^2 with x + y <= 2: at (2, 0).
  LinearFit fit({0, 0});
  fit.wish({{{0, 1.0}}}, 3, 1);
  fit.wish({{{1, 1.0}}}, 1, 1);
  fit.bound({{{0, 1.0}, {1, 1.0}}}, -std::numeric_limits<double>::infinity(), 2, 1e-6, 1e4);
  fit.solve();
  // The interior point ends a little inside.
  EXPECT_NEAR(fit.unknowns()[0], 2, 1e-3);
  EXPECT_NEAR(fit.unknowns()[1], 0, 1e-3);
  EXPECT_LE(fit.unknowns()[0] + fit.unknowns()[1], 2 + 1e-6);
  // x >= 1 by 5, x <= 0 by 50: the stronger holds.
  LinearFit torn({0.5});
  torn.wish({{{0, 1.0}}}, 0.5, 1e-3);
  torn.bound({{{0, 1.0}}}, 1, 2, 1e-6, 5);
  torn.bound({{{0, 1.0}}}, -1, 0, 1e-6, 50);
  torn.solve();
  EXPECT_NEAR(torn.unknowns()[0], 0, 1e-4);
  // Huber: the mean of 0, 0, 100 with a doubt of 1 is that of 0, 0 and a force of 1: 1/2.
  LinearFit doubt({0});
  for (const double target : {0.0, 0.0, 100.0}) doubt.wish({{{0, 1.0}}}, target, 1, 1);
  doubt.bound({{{0, 1.0}}}, -1e3, 1e3, 1e-6, 1e4);
  doubt.solve();
  EXPECT_NEAR(doubt.unknowns()[0], 0.5, 1e-3);
}

// A plane costs nothing: the optimum is the plane.
TEST(FitHeights, APlaneIsFollowedExactly) {
  Network network = one_road(400, 20);
  const auto report = fit_heights(network, ground([](double x, double y) { return 50 + 0.08 * x - 0.1 * y; }));
  ASSERT_TRUE(report.ok()) << report.error().text();
  for (double s = 0; s <= 400; s += 7) {
    EXPECT_NEAR(pose_at(network.roads[0], s, 0).position_m.z, 50 + 0.08 * s, 1e-3) << s;
  }
  EXPECT_LT(report->rms_m, 1e-3);
  EXPECT_NEAR(report->max_grade, 0.08, 1e-4);
}

// Long waves are followed by the transfer function of the smoothing spline, 1 / (1 + (smoothing k)^4).
TEST(FitHeights, WavesAreDampedAsTheSmoothingSays) {
  for (const double wave_m : {120.0, 250.0, 600.0}) {
    Network network = one_road(2400, 12);
    const double k = 2 * kPi / wave_m;
    HeightFitOptions options;
    options.max_grade = 1, options.max_curvature_per_m = 1;
    const auto report = fit_heights(network, ground([=](double x, double) { return std::cos(k * x); }), options);
    ASSERT_TRUE(report.ok());
    const double due = 1 / (1 + std::pow(options.smoothing_m * k, 4));
    const double middle = wave_m * std::round(1200 / wave_m);
    EXPECT_NEAR(pose_at(network.roads[0], middle, 0).position_m.z, due, 0.02) << wave_m;
    EXPECT_NEAR(pose_at(network.roads[0], middle + 0.5 * wave_m, 0).position_m.z, -due, 0.02) << wave_m;
  }
}

// Over a ridge that is too steep: limits hold everywhere on the cubic, at any limit.
TEST(FitHeights, LimitsHoldOnEveryCubic) {
  for (const double grade : {0.04, 0.1, 0.3}) {
    for (const double curvature : {1.0 / 2000, 1.0 / 300}) {
      Network network = one_road(900, 17);
      HeightFitOptions options;
      options.max_grade = grade;
      options.max_curvature_per_m = curvature;
      const auto report = fit_heights(network, ground([](double x, double) {
                                        return 70 * std::exp(-std::pow((x - 430) / 90, 2)) + 8 * std::sin(x / 23);
                                      }),
                                      options);
      ASSERT_TRUE(report.ok());
      const Extremes e = extremes(network.roads[0]);
      EXPECT_LE(e.grade, (1 + kLimitPart) * grade);
      EXPECT_LE(e.bend, (1 + kLimitPart) * curvature);
      // And one of them is reached: the ridge is steeper.
      EXPECT_TRUE(e.grade > 0.99 * grade || e.bend > 0.99 * curvature);
      EXPECT_NEAR(report->max_grade, e.grade, 1e-12);
      EXPECT_NEAR(report->max_curvature_per_m, e.bend, 1e-12);
      EXPECT_EQ(report->over_grade + report->over_curvature, 0u);
    }
  }
}

// Steps of whole metres, and towers of 40 m on a tenth of the samples: the road keeps to the ground beneath.
TEST(FitHeights, StepsAndTowersDoNotBendTheRoad) {
  Network network = one_road(1500, 15);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto true_z = [](double x) { return 100 + 0.03 * x + 6 * std::sin(x / 120); };
  const GroundHeight noisy = [&](glm::dvec2 p) {
    return std::optional(std::round(true_z(p.x)) + (uniform(random) < 0.1 ? 40 : 0));
  };
  const auto report = fit_heights(network, noisy);
  ASSERT_TRUE(report.ok());
  double squares = 0;
  int count = 0;
  for (double s = 30; s < 1470; s += 5, ++count) {
    squares += std::pow(pose_at(network.roads[0], s, 0).position_m.z - true_z(s), 2);
  }
  EXPECT_LT(std::sqrt(squares / count), 1.0);
  EXPECT_LT(extremes(network.roads[0]).grade, 0.15);
}

// Where the ground is not known the road goes on smoothly; where it is known nowhere, that is an error.
TEST(FitHeights, UnknownGroundIsBridged) {
  Network network = one_road(600, 20);
  const GroundHeight partly = [](glm::dvec2 p) {
    return p.x > 200 && p.x < 300 ? std::nullopt : std::optional(20 + 0.05 * p.x);
  };
  const auto report = fit_heights(network, partly);
  ASSERT_TRUE(report.ok());
  EXPECT_GT(report->samples_missing, 8u);
  EXPECT_NEAR(pose_at(network.roads[0], 250, 0).position_m.z, 32.5, 0.02);
  const auto none = fit_heights(network, [](glm::dvec2) { return std::optional<double>(); });
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kData);
  HeightFitOptions wrong;
  wrong.max_grade = 0;
  EXPECT_EQ(fit_heights(network, partly, wrong).error().code, ErrorCode::kUsage);
}

// A crossing on a slope: its area is a plane that all arms lie in, with their grades and their lean.
TEST(FitHeights, ACrossingOnAHillsideIsAPlane) {
  Network network;
  const auto arm = [&](const char* id, double heading) {
    network.roads.push_back(road_along(
        id, 150, 15, 3.5,
        [=](double s) { return straight(12.0 * glm::dvec2(std::cos(heading), std::sin(heading)), heading, s); }, flat));
  };
  arm("e", 0), arm("n", kPi / 2), arm("w", kPi), arm("s", -kPi / 2);
  ASSERT_TRUE(add_crossing(network, "x", {{"e"}, {"n"}, {"w"}, {"s"}}).ok());
  const auto plane = [](double x, double y) { return 200 + 0.1 * x + 0.06 * y; };
  const auto report = fit_heights(network, ground(plane));
  ASSERT_TRUE(report.ok()) << report.error().text();
  ASSERT_EQ(network.junctions.size(), 1u);
  EXPECT_TRUE(problems(network.junctions[0]).empty());
  const JunctionSurface surface = junction_surface(network.junctions[0]);
  for (double x = -11; x <= 11; x += 1) {
    for (double y = -11; y <= 11; y += 1) {
      if (!is_inside(surface, {x, y})) continue;
      EXPECT_NEAR(height_m_at(surface, {x, y}), plane(x, y), 0.01) << x << " " << y;
    }
  }
  const CheckReport checked = check(network);
  EXPECT_TRUE(checked.ok()) << checked.problems.front();
}

// A road that passed 6 m over another still has 5.5 m, with ramps within the limits; one that passed 4 m over it, 4 m, but on a
// bridge 5.5 m too.
TEST(FitHeights, WhatPassesOverARoadStillDoes) {
  for (const auto& [above, is_bridge] : {std::pair(6.0, true), {4.0, true}, {4.0, false}}) {
    const double due = is_bridge ? 5.5 : std::min(above, 5.5);
    Network network = one_road(800, 20);
    network.roads.push_back(road_along(
        "over", 800, 20, 3.5,
        [](double s) {
          return straight({400, -400}, kPi / 2, s);
        },
        [height = above](double s) { return height * std::exp(-std::pow((s - 400) / 80, 2)); }));
    if (is_bridge) network.roads[1].bridges = {{.s_start_m = 385, .s_end_m = 415}};
    HeightFitOptions options;
    options.max_grade = 0.08;
    const auto report = fit_heights(network, ground([](double, double) { return 10.0; }), options);
    ASSERT_TRUE(report.ok());
    EXPECT_EQ(report->passings, 1u);
    EXPECT_EQ(report->passings_short, 0u);
    const double clear =
        pose_at(network.roads[1], 400, 0).position_m.z - pose_at(network.roads[0], 400, 0).position_m.z;
    EXPECT_GE(clear, due - 0.02);
    EXPECT_LE(clear, due + 0.5);
    for (const Road& road : network.roads) EXPECT_LE(extremes(road).grade, 0.08 * (1 + kLimitPart));
    EXPECT_NEAR(pose_at(network.roads[1], 10, 0).position_m.z, 10, 0.05);
  }
}

// A tunnel under level ground goes as deep as its vault and cover need, within the limits; where its road goes on in the next
// one's tunnel there is no portal.
TEST(FitHeights, TunnelsGoUnderTheGround) {
  const Tunnel vault;
  const double needed = vault.wall_height_m + vault.arch_rise_m + vault.lining_m + 0.5;
  Network network = one_road(300, 15);
  network.roads.push_back(road_along(
      "2", 300, 15, 3.5,
      [](double s) {
        return straight({300, 0}, 0, s);
      },
      flat));
  network.roads[0].successor = {RoadLink::To::kRoad, "2", false};
  network.roads[1].predecessor = {RoadLink::To::kRoad, "1", true};
  network.roads[0].sweeps = {{.s_start_m = 180, .s_end_m = 300, .shape = vault}};
  network.roads[1].sweeps = {{.s_start_m = 0, .s_end_m = 120, .shape = vault}};
  HeightFitOptions options;
  options.max_grade = 0.1;
  options.max_curvature_per_m = 1.0 / 200;
  const auto report = fit_heights(network, ground([](double, double) { return 10.0; }), options);
  ASSERT_TRUE(report.ok());
  for (double s = 0; s <= 100; s += 5) {
    EXPECT_LE(pose_at(network.roads[1], s, 0).position_m.z, 10 - needed) << s;
    EXPECT_LE(pose_at(network.roads[0], 300 - s, 0).position_m.z, 10 - needed) << s;
  }
  for (const Road& road : network.roads) {
    EXPECT_LE(extremes(road).grade, 0.1 * (1 + kLimitPart));
    EXPECT_LE(extremes(road).bend, (1 + kLimitPart) / 200);
    EXPECT_EQ(road.sweeps.size(), 1u);
  }
  EXPECT_NEAR(pose_at(network.roads[0], 10, 0).position_m.z, 10, 0.3);
}

// What contradicts itself is told, with the place: a loop of 100 m that passes over itself by 5.5 m needs more than 2 %.
TEST(FitHeights, ContradictionsAreTold) {
  constexpr double kRadius = 15, kStraight = 40, kTurn = 1.5 * kPi * kRadius;
  const auto loop = [](double s) -> testing::Station {
    if (s < kStraight) return straight({-kStraight, 0}, 0, s);
    if (s > kStraight + kTurn) return straight({-kRadius, kRadius}, -kPi / 2, s - kStraight - kTurn);
    const double angle = (s - kStraight) / kRadius;
    return {{kRadius * std::sin(angle), kRadius * (1 - std::cos(angle))}, angle};
  };
  Network network;
  network.roads.push_back(road_along("loop", 2 * kStraight + kTurn, 6, 3.5, loop, [](double s) { return 0.06 * s; }));
  HeightFitOptions options;
  options.max_grade = 0.02;
  Diagnostics told;
  const auto report = fit_heights(network, ground([](double, double) { return 0.0; }), options, &told);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->passings, 1u);
  EXPECT_EQ(report->over_grade, 1u);
  EXPECT_EQ(report->passings_short, 0u);  // what passes over another road comes first
  ASSERT_FALSE(told.empty());
  EXPECT_EQ(told[0].element, "road loop");
  EXPECT_NE(told[0].message.find("s = "), std::string::npos) << told[0].message;
}

// Public data: they stand beside the project, not in it; see data sources in README.
TEST(FitHeights, MonacoLiesOnItsHills) {
  const fs::path data = fs::path(ROADGEN_SOURCE_DIR) / "../shared/data";
  const fs::path roads = data / "road-geo/osm-graphhopper/monaco.osm.gz",
                 dem = data / "terrain/srtm-hgt/N43E007.hgt.zip";
  if (!fs::exists(roads) || !fs::exists(dem))
    GTEST_SKIP() << "no " << roads << " or no " << dem << ": the public data are not here";
  ImportOptions options;
  options.heights_follow = true;
  auto imported = import_files({roads.string()}, options);
  ASSERT_TRUE(imported.ok());
  Network& network = imported->network;
  const auto elevation = Elevation::open(dem.string());
  ASSERT_TRUE(elevation.ok());
  const auto report = fit_heights(network, measured_ground(*elevation, network));
  ASSERT_TRUE(report.ok()) << report.error().text();
  std::printf(
      "%zu samples, %.2f m rms, %.2f m mean, grade %.3f, radius %.0f m, %zu + %zu over, %zu passings, least %.2f m\n",
      report->samples, report->rms_m, report->mean_abs_m, report->max_grade, 1 / report->max_curvature_per_m,
      report->over_grade, report->over_curvature, report->passings, report->least_passing_m);
  EXPECT_LT(report->mean_abs_m, 2);
  EXPECT_EQ(report->over_grade, 0u);
  EXPECT_LE(report->over_curvature, network.roads.size() / 50);
  EXPECT_EQ(report->passings_short, 0u);
  for (const Road& road : network.roads) {
    if (!corner_roads(network)[static_cast<std::size_t>(&road - network.roads.data())]) {
      EXPECT_LE(extremes(road).grade, height_limits(road.road_class).grade * (1 + kLimitPart)) << road.id;
    }
  }
  const CheckReport checked = check(network);
  EXPECT_TRUE(checked.ok()) << checked.problems.front();
  // Of the 61 roads in tunnels, 6,192 m, most lie under their hills.
  const Bounds box = bounds(network);
  const Grid natural =
      natural_from_elevation(*elevation, network, {glm::dvec2(box.low_m) - 100.0, glm::dvec2(box.high_m) + 100.0}, 40);
  const RoadIndex index(network);
  const Levelling levelling(index, natural, {});
  const Supports& supports = levelling.supports();
  std::printf("%zu parts in tunnels, %.0f m, and %zu areas\n", supports.parts(Support::kTunnel),
              supports.length_m(Support::kTunnel), supports.halls().size());
  EXPECT_GE(supports.parts(Support::kTunnel), 54u);
  EXPECT_GE(supports.length_m(Support::kTunnel), 5400);
  EXPECT_GE(supports.halls().size(), 5u);
}

}  // namespace
}  // namespace roadgen
