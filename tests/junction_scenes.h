// Junctions for the tests: some by hand, and random ones.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "roadgen/road/junction.h"

namespace roadgen::test {

// The end of a road that comes from the given bearing and is cut at that distance from the origin.
inline JunctionArm arm_from(const std::string& road, double bearing_rad, double distance_m) {
  JunctionArm arm;
  arm.road = road;
  arm.at_end = true;
  arm.position_m = distance_m * glm::dvec2(std::cos(bearing_rad), std::sin(bearing_rad));
  arm.heading_rad = bearing_rad + M_PI;
  return arm;
}

// A crossing of four roads with crowns, differing grades and one superelevated arm.
inline std::vector<JunctionArm> crossing_arms() {
  std::vector<JunctionArm> arms;
  const double grade[] = {-0.05, 0.03, 0.06, -0.02};
  for (int i = 0; i < 4; ++i) {
    arms.push_back(arm_from(std::to_string(i + 1), i * M_PI / 2, 14 + i));
    JunctionArm& a = arms.back();
    a.grade = grade[i];
    a.elevation_m = 100 - grade[i] * (14 + i);
    a.crossfall_left = a.crossfall_right = 0.025;
  }
  arms[1].left_m = 5.5;
  arms[3].crossfall_left = -0.04;  // superelevated: falls to the right all across
  arms[3].crossfall_right = 0.04;
  return arms;
}

// A side road that meets a through road at 35 degrees, on a slope.
inline std::vector<JunctionArm> skewed_arms() {
  std::vector<JunctionArm> arms = {arm_from("1", 0, 16), arm_from("2", M_PI, 30), arm_from("3", M_PI + 0.61, 30)};
  arms[2].left_m = 2.5, arms[2].right_m = -2.5;
  for (JunctionArm& a : arms) {
    a.elevation_m = 0.04 * a.position_m.x + 0.02 * a.position_m.y;
    a.grade = 0.04 * std::cos(a.heading_rad) + 0.02 * std::sin(a.heading_rad);
    a.tilt = -0.04 * std::sin(a.heading_rad) + 0.02 * std::cos(a.heading_rad);
  }
  arms[2].grade += 0.05;
  arms[2].elevation_m -= 1.2;
  return arms;
}

// Two to six arms about `origin`, with gaps of 20 degrees or more between them, of all widths and grades; far enough
// apart for kerbs of some radius.
inline std::vector<JunctionArm> random_arms(std::mt19937& random, glm::dvec3 origin) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const int count = 2 + static_cast<int>(uniform(0, 4.999));
  std::vector<double> bearing;
  while (static_cast<int>(bearing.size()) < count) {
    const double next = uniform(-M_PI, M_PI);
    const bool apart = std::all_of(bearing.begin(), bearing.end(), [&](double other) {
      return std::abs(std::remainder(next - other, 2 * M_PI)) > 20 * M_PI / 180;
    });
    if (apart) bearing.push_back(next);
  }
  std::vector<JunctionArm> arms;
  for (int i = 0; i < count; ++i) {
    double nearest = M_PI / 2;
    for (int j = 0; j < count; ++j) {
      if (j != i) nearest = std::min(nearest, std::abs(std::remainder(bearing[i] - bearing[j], 2 * M_PI)));
    }
    JunctionArm arm = arm_from("r" + std::to_string(i), bearing[i], (5 + 5) / std::sin(nearest) + uniform(2, 15));
    arm.at_end = uniform(0, 1) < 0.5;
    arm.heading_rad += uniform(-0.05, 0.05);
    arm.position_m += glm::dvec2(origin);
    arm.left_m = uniform(1.5, 4.5);
    arm.right_m = -uniform(1.5, 4.5);
    arm.grade = uniform(-0.08, 0.08);
    arm.elevation_m = origin.z + uniform(-0.5, 0.5);
    arm.tilt = uniform(-0.05, 0.05);
    arm.crossfall_left = uniform(0, 0.03);
    arm.crossfall_right = uniform(0, 0.03);
    arms.push_back(arm);
  }
  return arms;
}

}  // namespace roadgen::test
