// Junctions: corner curves against the arms, the area against sampled polygons, the surface against the arms' planes.
#include "roadgen/road/junction.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/road/network.h"
#include "tests/junction_scenes.h"

namespace roadgen {
namespace {

using test::arm_from;
using test::crossing_arms;
using test::random_arms;
using test::skewed_arms;

constexpr double kPi = std::numbers::pi;

glm::dvec2 into(const JunctionArm& a) { return {std::cos(a.heading_rad), std::sin(a.heading_rad)}; }
glm::dvec2 leftward(const JunctionArm& a) { return {-std::sin(a.heading_rad), std::cos(a.heading_rad)}; }

Junction made(std::vector<JunctionArm> arms, double radius_m = 6) {
  auto junction = make_junction("J", std::move(arms), {.corner_radius_m = radius_m});
  EXPECT_TRUE(junction.ok()) << junction.error().text();
  return junction.ok() ? std::move(*junction) : Junction{};
}

// The scenes, and random junctions at the origin and 10,000 km from it.
void for_many(const std::function<void(const Junction&)>& visit, int randoms) {
  visit(made(crossing_arms()));
  visit(made(skewed_arms()));
  std::mt19937 random(11);
  for (int i = 0; i < randoms; ++i) {
    SCOPED_TRACE(i);
    const glm::dvec3 origin = i % 4 == 3 ? glm::dvec3(1e7, -1e7, 2000) : glm::dvec3(0, 0, 0);
    const Junction junction = made(random_arms(random, origin), i % 2 == 0 ? 6.0 : 12.0);
    if (!junction.arms.empty()) visit(junction);
  }
}

TEST(Junction, CornersAreSmoothAndLeaveTheArmsAlongTheirEdges) {
  double worst_position = 0, worst_heading = 0, worst_turn = 0;
  for_many(
      [&](const Junction& junction) {
        const double size = std::abs(junction.arms[0].position_m.x) + 1;
        const double position_limit = 1e-9 + 1e-15 * size;
        for (std::size_t i = 0; i < junction.arms.size(); ++i) {
          const JunctionArm &arm = junction.arms[i], &next = junction.arms[(i + 1) % junction.arms.size()];
          glm::dvec2 p = cut_point_m(arm, arm.right_m);
          double heading = arm.heading_rad, z = cut_height_m(arm, arm.right_m), grade = arm.grade;
          for (const Segment& s : junction.corners[i]) {
            const double heading_gap = std::abs(std::remainder(heading_rad(s, 0) - heading, 2 * kPi));
            worst_position = std::max(worst_position, glm::length(s.start_m - p) / (position_limit * 1e9));
            worst_heading = std::max(worst_heading, heading_gap / (1 + 1e-6 * size / s.chord_length_m()));
            EXPECT_NEAR(s.elevation_m.value(0), z, 1e-9);
            EXPECT_NEAR(s.elevation_m.slope(0), grade, 1e-9);
            worst_turn = std::max(worst_turn, std::abs(std::atan(s.slope_start) - std::atan(s.slope_end)));
            EXPECT_LE(std::max(std::abs(s.slope_start), std::abs(s.slope_end)), std::tan(31.0 / 30 * kPi / 12));
            EXPECT_LE(s.bound.v, kMappingTolerance * s.max_half_width_m() / s.chord_length_m());
            p = s.end_m;
            heading = heading_rad(s, 1);
            z = s.elevation_m.value(s.arc_m);
            grade = s.elevation_m.slope(s.arc_m);
          }
          EXPECT_NEAR(glm::length(p - cut_point_m(next, next.left_m)), 0, position_limit);
          EXPECT_NEAR(std::remainder(heading - next.heading_rad - kPi, 2 * kPi), 0,
                      1e-9 + 1e-15 * size / junction.corners[i].back().chord_length_m());
          EXPECT_NEAR(z, cut_height_m(next, next.left_m), 1e-9);
          EXPECT_NEAR(grade, -next.grade, 1e-9);
        }
        EXPECT_TRUE(problems(junction).empty());
      },
      1000);
  std::printf("worst joint: %.1e m, %.1e rad; greatest turn %.1f degrees\n", worst_position, worst_heading,
              worst_turn * 180 / kPi);
  EXPECT_LE(worst_position, 1e-9);
  EXPECT_LE(worst_heading, 1e-9);
  EXPECT_LE(worst_turn, 31.0 / 30 * kPi / 6);
}

// Right-angled kerbs are quarter circles of the radius that was asked for, between straights.
TEST(Junction, AKerbHasTheRadiusThatWasAskedFor) {
  std::vector<JunctionArm> arms;
  for (int i = 0; i < 4; ++i) arms.push_back(arm_from(std::to_string(i), i * kPi / 2, 20));
  Diagnostics diagnostics;
  auto junction = make_junction("J", arms, {.corner_radius_m = 8}, &diagnostics);
  ASSERT_TRUE(junction.ok());
  EXPECT_TRUE(diagnostics.empty());
  for (const auto& corner : junction->corners) {
    EXPECT_NEAR(corner.front().chord_length_m(), 20 - 3.5 - 8, 1e-9);
    EXPECT_NEAR(corner.back().chord_length_m(), 20 - 3.5 - 8, 1e-9);
    for (std::size_t k = 1; k + 1 < corner.size(); ++k) {
      for (double u = 0; u <= 1; u += 0.1) {
        const glm::dvec2 p = glm::abs(position_m(corner[k], u));
        EXPECT_NEAR(glm::length(p - glm::dvec2(11.5, 11.5)), 8, 7e-4 * 8);
      }
    }
  }
}

TEST(Junction, ARadiusThatDoesNotFitBecomesTheGreatestThatDoesAndIsReported) {
  std::vector<JunctionArm> arms;
  for (int i = 0; i < 4; ++i) arms.push_back(arm_from(std::to_string(i), i * kPi / 2, i == 2 ? 6.5 : 20));
  Diagnostics diagnostics;
  auto junction = make_junction("J", arms, {.corner_radius_m = 8}, &diagnostics);
  ASSERT_TRUE(junction.ok());
  ASSERT_EQ(diagnostics.size(), 2u);  // the corners on both sides of the near arm
  for (const Diagnostic& d : diagnostics) {
    EXPECT_NE(d.message.find("road 2"), std::string::npos) << d.message;
    EXPECT_NE(d.message.find("3.00 m instead of 8.00 m"), std::string::npos) << d.message;
  }
}

// Arms that face one another are joined by straight edges, offset ones by S curves without a kerb.
TEST(Junction, AThroughRoadKeepsItsEdges) {
  const Junction straight = made({arm_from("1", 0, 15), arm_from("2", kPi, 15), arm_from("3", -kPi / 2, 15)});
  for (const Segment& s : straight.corners[1]) {
    EXPECT_NEAR(s.start_m.y, 3.5, 1e-12);
    EXPECT_NEAR(s.end_m.y, 3.5, 1e-12);
    EXPECT_NEAR(s.slope_start, 0, 1e-12);
  }
  std::vector<JunctionArm> arms = {arm_from("1", 0, 15), arm_from("2", kPi, 15), arm_from("3", -kPi / 2, 15)};
  arms[1].left_m = 5;
  arms[1].right_m = -5;
  const Junction offset = made(arms);
  double turn = 0;
  for (const auto& corner : offset.corners) {
    for (const Segment& s : corner) {
      if (s.start_m.y > 0) turn += std::abs(std::atan(s.slope_end) - std::atan(s.slope_start));
    }
  }
  EXPECT_LT(turn, 0.5);
}

TEST(Junction, TheOrderInWhichArmsAreGivenDoesNotMatter) {
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    std::vector<JunctionArm> arms = random_arms(random, {0, 0, 0});
    const Junction a = made(arms);
    std::shuffle(arms.begin(), arms.end(), random);
    const Junction b = made(arms);
    ASSERT_EQ(a.arms.size(), b.arms.size());
    for (std::size_t k = 0; k < a.arms.size(); ++k) EXPECT_EQ(a.arms[k].road, b.arms[k].road);
  }
}

// The sign against the winding number of a fine polygon, the distance against the nearest of its points.
TEST(Junction, SignedDistanceAgreesWithAFinePolygon) {
  std::mt19937 random(3);
  double worst = 0;
  for_many(
      [&](const Junction& junction) {
        std::vector<glm::dvec2> polygon;
        for (std::size_t i = 0; i < junction.arms.size(); ++i) {
          const JunctionArm& arm = junction.arms[i];
          constexpr int kSteps = 400;
          for (int k = 0; k < kSteps; ++k) {
            polygon.push_back(cut_point_m(arm, arm.left_m + (arm.right_m - arm.left_m) * k / kSteps));
          }
          for (const Segment& s : junction.corners[i]) {
            for (int k = 0; k < kSteps; ++k) polygon.push_back(position_m(s, static_cast<double>(k) / kSteps));
          }
        }
        const JunctionSurface surface = junction_surface(junction);
        const auto uniform = [&](double low, double high) {
          return std::uniform_real_distribution<double>(low, high)(random);
        };
        for (int i = 0; i < 60; ++i) {
          // Half of the points lie within a quarter of a metre of the boundary.
          glm::dvec2 p(uniform(surface.low_m.x - 2, surface.high_m.x + 2),
                       uniform(surface.low_m.y - 2, surface.high_m.y + 2));
          p += glm::dvec2(surface.center_m);
          if (i % 2 == 0) {
            p = polygon[static_cast<std::size_t>(uniform(0, static_cast<double>(polygon.size()) - 1e-6))] +
                glm::dvec2(uniform(-0.17, 0.17), uniform(-0.17, 0.17));
          }
          double winding = 0, nearest = 1e300;
          for (std::size_t k = 0; k < polygon.size(); ++k) {
            const glm::dvec2 a = polygon[k] - p, b = polygon[(k + 1) % polygon.size()] - p, ab = b - a;
            winding += std::atan2(a.x * b.y - a.y * b.x, glm::dot(a, b));
            const double along = std::clamp(-glm::dot(a, ab) / glm::dot(ab, ab), 0.0, 1.0);
            nearest = std::min(nearest, glm::length(a + along * ab));
          }
          if (nearest < 1e-4) continue;  // the polygon's own error
          const double found = signed_distance_m(surface, p);
          EXPECT_EQ(found > 0, winding > kPi) << nearest;
          if (nearest < 0.25) worst = std::max(worst, std::abs(std::abs(found) - nearest));
        }
      },
      60);
  std::printf("worst distance near the boundary: %.1e m\n", worst);
  EXPECT_LE(worst, 5e-5);  // the polygon lies within 4e-6 of a long piece, the mapping within 1e-4 of a quarter metre
}

// Across every cut the surface and its slope are those of the arm, from within and by finite differences.
TEST(Junction, TheSurfaceMeetsEveryArmInHeightAndSlope) {
  double worst_height = 0, worst_slope = 0, worst_difference = 0;
  for_many(
      [&](const Junction& junction) {
        const JunctionSurface surface = junction_surface(junction);
        for (const JunctionArm& arm : junction.arms) {
          for (double part = 0.03; part < 1; part += 0.094) {
            const double n = arm.right_m + part * (arm.left_m - arm.right_m);
            if (std::abs(n) < 0.05) continue;  // the crown
            const glm::dvec2 p = cut_point_m(arm, n);
            const JunctionPoint at = height_at(surface, p);
            const double across = arm.tilt - (n > 0 ? arm.crossfall_left : -arm.crossfall_right);
            worst_height = std::max(worst_height, std::abs(at.height_m - cut_height_m(arm, n)));
            worst_slope = std::max(worst_slope, std::abs(glm::dot(at.gradient, into(arm)) - arm.grade));
            worst_slope = std::max(worst_slope, std::abs(glm::dot(at.gradient, leftward(arm)) - across));
            // One-sided, of second order: the surface departs from the arm's plane like distance^2.
            if (std::abs(arm.position_m.x) > 1e6) continue;
            constexpr double kStep = 1e-4;
            const double z1 = height_at(surface, p + kStep * into(arm)).height_m;
            const double z2 = height_at(surface, p + 2 * kStep * into(arm)).height_m;
            const double slope = (4 * (z1 - at.height_m) - (z2 - at.height_m)) / (2 * kStep);
            worst_difference = std::max(worst_difference, std::abs(slope - arm.grade));
          }
        }
      },
      300);
  std::printf("at the cuts: height %.1e m, slope %.1e, slope by differences %.1e\n", worst_height, worst_slope,
              worst_difference);
  EXPECT_LE(worst_height, 1e-6);
  EXPECT_LE(worst_slope, 1e-6);
  EXPECT_LE(worst_difference, 1e-6);
}

TEST(Junction, TheSurfaceMeetsEveryCornerCurveInHeight) {
  double worst = 0;
  for_many(
      [&](const Junction& junction) {
        const JunctionSurface surface = junction_surface(junction);
        for (const auto& corner : junction.corners) {
          for (const Segment& s : corner) {
            for (double u = 0; u <= 1; u += 0.125) {
              const double z = height_at(surface, position_m(s, u)).height_m;
              worst = std::max(worst, std::abs(z - s.elevation_m.value(arc_at(s, u))));
            }
          }
        }
      },
      300);
  std::printf("at the corner curves: height %.1e m\n", worst);
  // Another piece half a metre away takes part by 1e-6 m^2 / (0.5 m)^2 of the heights' difference.
  EXPECT_LE(worst, 1e-5);
}

TEST(Junction, TheGradientIsTheHeightsDerivative) {
  std::mt19937 random(9);
  double worst = 0;
  for_many(
      [&](const Junction& junction) {
        if (std::abs(junction.arms[0].position_m.x) > 1e6) return;
        const JunctionSurface surface = junction_surface(junction);
        for (int i = 0; i < 40; ++i) {
          const auto uniform = [&](double low, double high) {
            return std::uniform_real_distribution<double>(low, high)(random);
          };
          const glm::dvec2 p = glm::dvec2(surface.center_m) + glm::dvec2(uniform(surface.low_m.x, surface.high_m.x),
                                                                         uniform(surface.low_m.y, surface.high_m.y));
          if (std::abs(signed_distance_m(surface, p)) < 0.02) continue;  // steep weights
          constexpr double kStep = 1e-6;
          const JunctionPoint at = height_at(surface, p);
          for (int axis = 0; axis < 2; ++axis) {
            glm::dvec2 step(0, 0);
            step[axis] = kStep;
            const double slope =
                (height_at(surface, p + step).height_m - height_at(surface, p - step).height_m) / (2 * kStep);
            worst = std::max(worst, std::abs(slope - at.gradient[axis]));
          }
        }
      },
      100);
  std::printf("gradient against differences: %.1e\n", worst);
  EXPECT_LE(worst, 1e-5);
}

// Arms cut out of one plane give that plane back, with no dip or bulge, within the cubics' own departure from it.
TEST(Junction, ArmsInOnePlaneGiveThePlane) {
  double worst = 0;
  for (const double turn : {0.0, 0.7, 2.0}) {
    std::vector<JunctionArm> arms = {arm_from("1", turn, 18), arm_from("2", turn + 1.2, 22),
                                     arm_from("3", turn + 3.3, 17)};
    for (JunctionArm& a : arms) {
      a.elevation_m = 0.06 * a.position_m.x - 0.03 * a.position_m.y;
      a.grade = glm::dot(glm::dvec2(0.06, -0.03), into(a));
      a.tilt = glm::dot(glm::dvec2(0.06, -0.03), leftward(a));
    }
    const JunctionSurface surface = junction_surface(made(arms));
    for (double x = -20; x < 20; x += 0.7) {
      for (double y = -20; y < 20; y += 0.7) {
        if (signed_distance_m(surface, {x, y}) < 0) continue;
        const JunctionPoint at = height_at(surface, {x, y});
        worst = std::max(worst, std::abs(at.height_m - (0.06 * x - 0.03 * y)));
      }
    }
  }
  std::printf("off the plane: %.1e m\n", worst);
  // Over 30 degrees of a circle of radius R, a cubic in s departs from slope g by g R (pi / 6)^4 / 384.
  EXPECT_LE(worst, 0.067 * 30 * std::pow(kPi / 6, 4) / 384);
}

TEST(Junction, NothingIsNanOnTheBoundary) {
  for_many(
      [](const Junction& junction) {
        const JunctionSurface surface = junction_surface(junction);
        const auto check = [&](glm::dvec2 p) {
          const JunctionPoint at = height_at(surface, p);
          EXPECT_TRUE(std::isfinite(at.height_m + at.gradient.x + at.gradient.y + signed_distance_m(surface, p)));
          EXPECT_LE(glm::length(at.gradient), 1.0);
        };
        for (const JunctionArm& arm : junction.arms) {
          for (const double n : {arm.right_m, 0.0, arm.left_m}) check(cut_point_m(arm, n));
        }
        for (const auto& corner : junction.corners) {
          for (const Segment& s : corner) check(s.start_m), check(s.end_m), check(position_m(s, 0.5));
        }
        for (const auto& piece : surface.corners) {
          check(glm::dvec2(piece.x0, piece.y0) + glm::dvec2(surface.center_m));
        }
      },
      100);
}

TEST(Junction, TheBoundsHoldTheSurface) {
  for_many(
      [](const Junction& junction) {
        const JunctionSurface surface = junction_surface(junction);
        std::mt19937 random(1);
        std::uniform_real_distribution<double> uniform(0, 1);
        for (int i = 0; i < 300; ++i) {
          const glm::dvec2 p = glm::dvec2(surface.low_m) + glm::dvec2(uniform(random), uniform(random)) *
                                                               glm::dvec2(surface.high_m - surface.low_m);
          const glm::dvec2 world = p + glm::dvec2(surface.center_m);
          if (signed_distance_m(surface, world) < 0) continue;
          const JunctionPoint at = height_at(surface, world);
          EXPECT_GE(at.height_m - surface.center_m.z, surface.low_m.z);
          EXPECT_LE(at.height_m - surface.center_m.z, surface.high_m.z);
        }
        for (const JunctionArm& a : junction.arms) {
          for (const double n : {a.left_m, a.right_m}) {
            const glm::dvec2 p = cut_point_m(a, n) - glm::dvec2(surface.center_m);
            EXPECT_TRUE(p.x >= surface.low_m.x && p.x <= surface.high_m.x && p.y >= surface.low_m.y &&
                        p.y <= surface.high_m.y);
          }
        }
      },
      100);
}

TEST(Junction, BadArmsAreOneClearLine) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  struct Fault {
    const char* words;
    std::function<void(std::vector<JunctionArm>&)> plant;
  };
  const Fault faults[] = {
      {"0 arms", [](auto& a) { a.clear(); }},
      {"1 arm,", [](auto& a) { a.resize(1); }},
      {"road 2 (end): a number is not finite", [](auto& a) { a[1].position_m.x = kNan; }},
      {"road 2 (end): a number is not finite", [](auto& a) { a[1].heading_rad = kNan; }},
      {"road 3 (end): a number is not finite", [](auto& a) { a[2].grade = std::numeric_limits<double>::infinity(); }},
      {"road 1 (end): the carriageway's edges", [](auto& a) { a[0].left_m = -1; }},
      {"road 1 (end): the carriageway's edges", [](auto& a) { a[0].left_m = a[0].right_m = 0; }},
      {"overlap", [](auto& a) { a[1].position_m = a[0].position_m; }},
      {"road 2 (end) overlap",
       [](auto& a) {
         a[0].position_m = {2, 0};
         a[1].position_m = {0, 2};
       }},
      {"road 3 (end) points away from the other arms", [](auto& a) { a[2].heading_rad += kPi; }},
      {"road 1 (end)",
       [](auto& a) {
         a = {arm_from("1", 0, -5), arm_from("2", kPi, -5)};
       }},
      {"the area's edges cross at road", [](auto& a) { a[0].heading_rad -= 2.2; }},
      {"the area's edges cross at road", [](auto& a) { std::swap(a[0].position_m, a[1].position_m); }},
      {"road 1 (end) points away", [](auto& a) { std::swap(a[0].position_m, a[2].position_m); }},
      {"no corner curve fits",
       [](auto& a) {
         a[0] = arm_from("1", 0, 3.6);
         a[1] = arm_from("2", kPi / 2, 3.6);
       }},
  };
  for (const Fault& fault : faults) {
    std::vector<JunctionArm> arms = crossing_arms();
    fault.plant(arms);
    auto junction = make_junction("17", arms);
    if (junction.ok()) {
      ADD_FAILURE() << "accepted: " << fault.words;
      continue;
    }
    const std::string text = junction.error().text();
    EXPECT_EQ(text.find("junction 17: "), 0u) << text;
    EXPECT_NE(text.find(fault.words), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
    EXPECT_EQ(junction.error().code, ErrorCode::kGeometry);
  }
  for (const double radius : {0.0, -1.0, kNan, std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(make_junction("17", crossing_arms(), {.corner_radius_m = radius}).ok());
  }
}

TEST(Junction, ProblemsFindsEveryPlantedFault) {
  struct Fault {
    const char* word;
    std::function<void(Junction&)> plant;
  };
  const Fault faults[] = {
      {"position gap", [](Junction& j) { j.corners[1][0].start_m.x += 1e-6; }},
      {"position gap", [](Junction& j) { j.arms[2].position_m.y += 1e-6; }},
      {"heading gap", [](Junction& j) { j.corners[1][1].slope_start += 1e-6; }},
      {"heading gap", [](Junction& j) { j.corners[3].back().slope_end += 1e-6; }},
      {"elevation gap", [](Junction& j) { j.corners[2][0].elevation_m.c0 += 1e-4; }},
      {"elevation gap", [](Junction& j) { j.arms[1].tilt += 1e-4; }},
      {"grade gap", [](Junction& j) { j.arms[1].grade += 1e-4; }},
      {"not finite", [](Junction& j) { j.corners[0][0].elevation_m.c2 = std::nan(""); }},
      {"no pieces", [](Junction& j) { j.corners[3].clear(); }},
      {"as many corners", [](Junction& j) { j.corners.pop_back(); }},
      {"needs two", [](Junction& j) { j.arms.resize(1); }},
  };
  for (const Fault& fault : faults) {
    Junction junction = made(crossing_arms());
    fault.plant(junction);
    const auto found = problems(junction);
    ASSERT_FALSE(found.empty()) << fault.word;
    bool named = false;
    for (const std::string& line : found) {
      named = named || line.find(fault.word) != std::string::npos;
      EXPECT_EQ(line.find("junction J: "), 0u) << line;
    }
    EXPECT_TRUE(named) << fault.word << ": " << found.front();
  }
}

TEST(Junction, CheckAndBoundsOfTheNetworkCountIt) {
  Network network;
  network.junctions.push_back(made(crossing_arms()));
  EXPECT_TRUE(check(network).ok());
  const Bounds b = bounds(network);
  for (const JunctionArm& arm : network.junctions[0].arms) {
    const glm::dvec2 p = cut_point_m(arm, arm.left_m);
    EXPECT_TRUE(p.x >= b.low_m.x && p.x <= b.high_m.x && p.y >= b.low_m.y && p.y <= b.high_m.y);
    EXPECT_TRUE(arm.elevation_m >= b.low_m.z && arm.elevation_m <= b.high_m.z);
  }
  network.junctions[0].corners[1][0].start_m.x += 1e-3;
  ASSERT_FALSE(check(network).ok());
  EXPECT_EQ(check(network).problems.front().find("junction J: corner from road"), 0u);
}

}  // namespace
}  // namespace roadgen
