// Small worlds for the tests of queries and terrain: roads along given curves, and elevation files written as text.
#pragma once

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>

#include <gtest/gtest.h>
#include <glm/vec2.hpp>

#include "roadgen/road/network.h"

namespace roadgen::testing {

// A place on a curve that is given by its arc length.
struct Station {
  glm::dvec2 position_m;
  double heading_rad;
};

// The road along a curve: anchors every step_m, elevation by its value and slope there.
inline Road road_along(const std::string& id, double length_m, double step_m, double half_width_m,
                       const std::function<Station(double)>& curve, const std::function<double(double)>& elevation_m) {
  Road road;
  road.id = id;
  const int pieces = static_cast<int>(std::ceil(length_m / step_m));
  const auto slope = [&](double s) { return (elevation_m(s + 1e-4) - elevation_m(s - 1e-4)) / 2e-4; };
  for (int i = 0; i < pieces; ++i) {
    const double s0 = length_m * i / pieces, s1 = length_m * (i + 1) / pieces;
    const Station a = curve(s0), b = curve(s1);
    Segment segment = make_segment(a.position_m, b.position_m, a.heading_rad, b.heading_rad, half_width_m);
    segment.elevation_m = Cubic::hermite(elevation_m(s0), slope(s0), elevation_m(s1), slope(s1), segment.arc_m);
    road.segments.push_back(segment);
  }
  chain_arc_lengths(road);
  two_lane_sections(road);
  return road;
}

inline Station straight(glm::dvec2 from_m, double heading_rad, double s_m) {
  return {from_m + s_m * glm::dvec2(std::cos(heading_rad), std::sin(heading_rad)), heading_rad};
}

// Legs of leg_m joined by half circles of the given radius, climbing north: 0 m along the first leg at the origin.
inline Station hairpins(double leg_m, double radius_m, double s_m) {
  constexpr double kPi = std::numbers::pi;
  const double turn = kPi * radius_m, period = leg_m + turn;
  const int leg = std::max(0, static_cast<int>(std::floor(s_m / period)));
  const double local = s_m - leg * period, y = 2 * radius_m * leg;
  const bool east = leg % 2 == 0;
  if (local <= leg_m) return {{east ? local : leg_m - local, y}, east ? 0 : kPi};
  const double angle = (local - leg_m) / radius_m;
  const double reach = radius_m * std::sin(angle), rise = radius_m * (1 - std::cos(angle));
  return {{east ? leg_m + reach : -reach, y + rise}, east ? angle : kPi - angle};
}

// Seven legs, six hairpins of 12 m radius, at a steady grade.
inline Network hairpin_network(double grade, double leg_m = 90, double radius_m = 12) {
  Network network;
  const double length = 7 * leg_m + 6 * std::numbers::pi * radius_m;
  network.roads.push_back(road_along(
      "hairpins", length, 6, 3.5, [=](double s) { return hairpins(leg_m, radius_m, s); },
      [=](double s) { return 500 + grade * s; }));
  return network;
}

// A folder of this test that is emptied first.
inline std::string scratch_folder() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "roadgen" /
                                       (std::string(info->test_suite_name()) + "." + info->name());
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder.string();
}

// An ESRI ASCII grid whose posts (pixel centres) are at low + step * (column, row), rows going north.
inline std::string write_ascii_grid(const std::string& path, glm::dvec2 low, double step, int columns, int rows,
                                    const std::function<std::string(double, double)>& post) {
  std::ofstream out(path);
  out.precision(15);
  out << "ncols " << columns << "\nnrows " << rows << "\nxllcenter " << low.x << "\nyllcenter " << low.y
      << "\ncellsize " << step << "\nNODATA_value -9999\n";
  for (int row = rows - 1; row >= 0; --row) {
    for (int column = 0; column < columns; ++column) out << post(low.x + step * column, low.y + step * row) << ' ';
    out << '\n';
  }
  return path;
}

inline std::string write_ascii_grid(const std::string& path, glm::dvec2 low, double step, int columns, int rows,
                                    const std::function<double(double, double)>& height_m) {
  return write_ascii_grid(path, low, step, columns, rows, [&](double x, double y) {
    char text[40];
    std::snprintf(text, sizeof text, "%.6f", height_m(x, y));
    return std::string(text);
  });
}

struct Clearance {
  double min_m = 0, max_m = 0;
  std::size_t samples = 0;
};

// Clearance by the road's own pose, not by the code under test: every step_m along and across.
using Ground = std::function<double(glm::dvec2)>;
inline Clearance independent_clearance(const Network& network, double step_m, const Ground& ground) {
  Clearance c{1e300, -1e300, 0};
  for (const Road& road : network.roads) {
    for (double s = 0; s <= road.length_m(); s += step_m) {
      const Segment& segment = road.segments[segment_at(road, s)];
      const double w = segment.left_m.value(s - segment.s_start_m);
      for (double t = -w; t <= w + 1e-9; t += step_m) {
        const RoadPose pose = pose_at(road, s, std::min(t, w));
        const double clearance = pose.position_m.z - ground(glm::dvec2(pose.position_m));
        c.min_m = std::min(c.min_m, clearance);
        c.max_m = std::max(c.max_m, clearance);
        ++c.samples;
      }
    }
  }
  return c;
}

}  // namespace roadgen::testing
