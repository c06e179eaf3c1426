// Roads as a whole: poses along them, and what check() finds.
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/road/network.h"

namespace roadgen {
namespace {

// Four segments around a circle of this radius, closed or with one left out, rising and widening.
Road ring(double radius_m, bool closed) {
  Road road;
  road.id = "ring";
  road.closed = closed;
  constexpr int kSegments = 12;
  for (int i = 0; i < (closed ? kSegments : kSegments - 1); ++i) {
    const double from = 2 * M_PI * i / kSegments, to = 2 * M_PI * ((i + 1) % kSegments) / kSegments;
    road.segments.push_back(make_segment({radius_m * std::cos(from), radius_m * std::sin(from)},
                                         {radius_m * std::cos(to), radius_m * std::sin(to)}, from + M_PI / 2,
                                         to + M_PI / 2, 3));
  }
  chain_arc_lengths(road);
  two_lane_sections(road);
  for (Segment& s : road.segments) {
    const double omega = 2 * M_PI / (road.segments[0].arc_m * kSegments), s1 = s.s_start_m + s.arc_m;
    s.elevation_m = Cubic::hermite(std::sin(omega * s.s_start_m), omega * std::cos(omega * s.s_start_m),
                                   std::sin(omega * s1), omega * std::cos(omega * s1), s.arc_m);
  }
  return road;
}

TEST(PoseAt, MovesByArcLengthAlongTheHeading) {
  const Road road = ring(50, true);
  const double h = 1e-4;
  for (double s = 0.3; s < road.length_m(); s += 1.7) {
    const RoadPose before = pose_at(road, s - h, 0), here = pose_at(road, s, 0), after = pose_at(road, s + h, 0);
    const glm::dvec3 step = (after.position_m - before.position_m) / (2 * h);
    EXPECT_NEAR(step.x, std::cos(here.heading_rad), 1e-5);
    EXPECT_NEAR(step.y, std::sin(here.heading_rad), 1e-5);
    EXPECT_NEAR(step.z, std::tan(here.pitch_rad), 1e-7);
    // A cubic over 30 degrees of a circle keeps its curvature to 7 %.
    EXPECT_NEAR(here.curvature_per_m, 1.0 / 50, 0.07 / 50);
  }
}

TEST(PoseAt, OffsetsToTheLeft) {
  const Road road = ring(50, true);
  for (double s = 0; s < road.length_m(); s += 3.1) {
    const RoadPose center = pose_at(road, s, 0), left = pose_at(road, s, 2);
    const glm::dvec3 d = left.position_m - center.position_m;
    EXPECT_NEAR(d.x, -2 * std::sin(center.heading_rad), 1e-12);
    EXPECT_NEAR(d.y, 2 * std::cos(center.heading_rad), 1e-12);
    // The circle turns left, so its left side lies inside.
    EXPECT_LT(glm::length(glm::dvec2(left.position_m)), 50);
  }
}

TEST(PoseAt, WrapsOnClosedRoadsAndStopsOnOpenOnes) {
  const Road closed = ring(50, true), open = ring(50, false);
  const RoadPose here = pose_at(closed, 12.5, 1), around = pose_at(closed, 12.5 - 3 * closed.length_m(), 1);
  EXPECT_NEAR(glm::length(here.position_m - around.position_m), 0, 1e-9);
  const RoadPose end = pose_at(open, open.length_m(), 0), beyond = pose_at(open, open.length_m() + 99, 0);
  EXPECT_NEAR(glm::length(end.position_m - beyond.position_m), 0, 1e-12);
  EXPECT_EQ(pose_at(open, -5, 0).position_m, pose_at(open, 0, 0).position_m);
}

TEST(SegmentAt, HoldsTheArcLength) {
  const Road road = ring(80, false);
  for (double s = 0; s < road.length_m(); s += 0.37) {
    const Segment& segment = road.segments[segment_at(road, s)];
    EXPECT_LE(segment.s_start_m, s);
    EXPECT_LE(s, segment.s_start_m + segment.arc_m);
  }
}

TEST(Bounds, HoldTheWholeSurface) {
  Network network;
  network.roads.push_back(ring(50, true));
  const Bounds b = bounds(network);
  for (double s = 0; s < network.roads[0].length_m(); s += 1) {
    for (const double t : {-3.0, 0.0, 3.0}) {
      const glm::dvec3 p = pose_at(network.roads[0], s, t).position_m;
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_GE(p[axis], b.low_m[axis] - 1e-9);
        EXPECT_LE(p[axis], b.high_m[axis] + 1e-9);
      }
    }
  }
  EXPECT_TRUE(bounds(Network{}).empty());
}

CheckReport checked(Road road) {
  Network network;
  network.roads.push_back(std::move(road));
  return check(network);
}

TEST(Check, AcceptsAGoodRoad) {
  for (const bool closed : {false, true}) {
    const CheckReport report = checked(ring(50, closed));
    EXPECT_TRUE(report.ok()) << report.problems.front();
    EXPECT_EQ(report.joints, closed ? 12u : 10u);
    EXPECT_LT(report.worst.heading_rad, 1e-12);
    EXPECT_LT(report.max_mapping_bound_m, 3 * kMappingTolerance);
  }
}

TEST(Check, FindsEveryPlantedFault) {
  struct Fault {
    const char* word;  // of the problem's text
    std::function<void(Road&)> plant;
  };
  const Fault faults[] = {
      {"position gap", [](Road& r) { r.segments[4].start_m.x += 1e-6; }},
      {"heading gap", [](Road& r) { r.segments[4].slope_start += 1e-6; }},
      {"elevation gap", [](Road& r) { r.segments[4].elevation_m.c0 += 1e-3; }},
      {"width gap", [](Road& r) { r.segments[4].left_m.c0 += 1e-3; }},
      {"width is not positive",
       [](Road& r) {
         r.segments[4].set_half_width_m({0.5, -1, 0, 0});
       }},
      {"not finite", [](Road& r) { r.segments[4].elevation_m.c2 = std::numeric_limits<double>::quiet_NaN(); }},
      {"no length", [](Road& r) { r.segments[4].end_m = r.segments[4].start_m; }},
      {"no segments", [](Road& r) { r.segments.clear(); }},
      {"not certified",
       [](Road& r) {
         for (Segment& s : r.segments) {
           s.left_m.c0 = 49;
           set_bound(s);
         }
       }},
      {"m along",
       [](Road& r) {
         for (Segment& s : r.segments) s.arc_error_m = 2 * kMappingTolerance * s.max_half_width_m();
       }},
      {"arc length", [](Road& r) { r.segments[4].s_start_m += 0.01; }},
      {"lane -1 has a negative width of -0.5 m",
       [](Road& r) {
         r.sections[0].right[0].width_m = {0, -1, 0.5, 0};
       }},
      {"negative width", [](Road& r) { r.sections[0].left[1].width_m.c0 = -1; }},
      {"no lane has any width",
       [](Road& r) {
         for (auto* side : {&r.sections[0].left, &r.sections[0].right}) {
           for (Lane& lane : *side) lane.width_m = {0, 0, 0, 0};
         }
       }},
      {"superelevation of 51.6 degrees",
       [](Road& r) {
         r.segments[4].superelevation_rad = {0, 0.9 / 26.18, 0, 0};
       }},
      {"grade of", [](Road& r) { r.segments[4].elevation_m.c1 = -2; }},
      {"crossfall of 110 %", [](Road& r) { r.segments[4].crossfall_right.c0 = 1.1; }},
      {"radius of", [](Road& r) { r.segments[4].left_m.c0 = 55; }},
      {"paint outside the road", [](Road& r) { r.paint.push_back({.s_m = 10, .t_m = 2, .width_m = 3}); }},
      {"paint outside the road", [](Road& r) { r.paint.push_back({.s_m = 1e4, .width_m = 1}); }},
      {"not positive", [](Road& r) { r.paint.push_back({.s_m = 10, .length_m = 0}); }},
      {"not finite", [](Road& r) { r.paint.push_back({.t_m = std::numeric_limits<double>::infinity()}); }},
      {"not finite", [](Road& r) { r.sections[0].offset_m.c3 = std::numeric_limits<double>::quiet_NaN(); }},
      {"elsewhere than at a joint", [](Road& r) { r.sections[0].s_m = 1; }},
      {"does not have the lane section", [](Road& r) { r.segments[2].section = 1; }},
      {"no lane sections", [](Road& r) { r.sections.clear(); }},
  };
  for (const bool closed : {false, true}) {
    for (const Fault& fault : faults) {
      Road road = ring(50, closed);
      fault.plant(road);
      const CheckReport report = checked(road);
      bool found = false;
      std::vector<std::string> told = report.problems;
      told.insert(told.end(), report.warnings.begin(), report.warnings.end());
      for (const std::string& problem : told) {
        found = found || problem.find(fault.word) != std::string::npos;
        EXPECT_NE(problem.find("road ring"), std::string::npos) << problem;
      }
      EXPECT_TRUE(found) << fault.word;
    }
  }
}

// The joint that closes a loop counts like the others.
TEST(Check, FindsAGapWhereALoopCloses) {
  Road road = ring(50, true);
  road.segments.front().start_m.y += 1e-3;
  EXPECT_FALSE(checked(road).ok());
  road.closed = false;
  road.segments.front() = ring(50, true).segments.front();
  EXPECT_TRUE(checked(road).ok());
}

}  // namespace
}  // namespace roadgen
