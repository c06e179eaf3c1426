#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "roadgen/import/clean.h"

namespace roadgen {
namespace {

struct Made {
  Track track;
  std::vector<glm::dvec2> positions_m;

  Made& add(double x, double y, std::optional<double> height_m = {}, std::optional<double> width_m = {}) {
    const int n = static_cast<int>(positions_m.size()) + 1;
    track.points.push_back({x, y, height_m, width_m, n, n + 1});
    positions_m.push_back({x, y});
    return *this;
  }
};

Made made() {
  Made m;
  m.track.file = "f.csv";
  m.track.geodetic = false;
  return m;
}

std::vector<CleanTrack> cleaned(const Made& m, Diagnostics& diagnostics, CleanOptions options = {}) {
  auto result = clean_track(m.track, m.positions_m, options, diagnostics);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
  return result.ok() ? *result : std::vector<CleanTrack>{};
}

bool mentions(const Diagnostics& diagnostics, const std::string& what) {
  for (const Diagnostic& d : diagnostics) {
    if (d.text().find(what) != std::string::npos) return true;
  }
  return false;
}

Made circle(int n, double radius_m, double part) {
  Made m = made();
  for (int i = 0; i < n; ++i) {
    const double angle = part * 2 * std::numbers::pi * i / n;
    m.add(radius_m * std::cos(angle), radius_m * std::sin(angle), 100.0);
  }
  return m;
}

TEST(Clean, RunsOfRepetitionsAreDroppedWithOneDiagnosticEach) {
  Made m = made();
  m.add(0, 0, 1.0).add(0, 0.005, 1.0).add(0.001, 0, 1.0).add(10, 0, 1.0).add(20, 0, 1.0).add(20, 0, 1.0);
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics);
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_EQ(tracks[0].points.size(), 3u);
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_EQ(diagnostics[0].element, "points 2-3");
  EXPECT_EQ(diagnostics[0].line, 3);
  EXPECT_EQ(diagnostics[1].element, "point 6");
}

TEST(Clean, AGoodTrackPassesUnchangedAndSilently) {
  Made m = made();
  for (int i = 0; i < 50; ++i) m.add(10.0 * i, 3 * std::sin(0.3 * i), 5 * std::sin(0.1 * i), 6.0);
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics);
  EXPECT_TRUE(diagnostics.empty());
  ASSERT_EQ(tracks.size(), 1u);
  ASSERT_EQ(tracks[0].points.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(tracks[0].points[i].position_m, m.positions_m[i]);
    EXPECT_EQ(tracks[0].points[i].height_m, *m.track.points[i].height_m);
    EXPECT_EQ(tracks[0].points[i].width_m, 6);
  }
}

TEST(Clean, ClosedIsDecidedBySpacingLengthAndDirection) {
  Diagnostics diagnostics;
  Made repeated = circle(100, 200, 1);
  repeated.add(repeated.positions_m[0].x, repeated.positions_m[0].y, 100.0);
  for (const Made& loop : {circle(100, 200, 1), repeated}) {
    const auto tracks = cleaned(loop, diagnostics);
    ASSERT_EQ(tracks.size(), 1u);
    EXPECT_TRUE(tracks[0].closed);
    EXPECT_EQ(tracks[0].points.size(), 100u);
  }
  EXPECT_FALSE(cleaned(circle(100, 200, 0.9), diagnostics)[0].closed);  // a wide gap
  EXPECT_FALSE(cleaned(circle(12, 200, 1), diagnostics)[0].closed);     // more than 2 % of the length
  EXPECT_TRUE(cleaned(circle(100, 200, 0.9), diagnostics, {Closed::kYes, 7})[0].closed);
  EXPECT_FALSE(cleaned(repeated, diagnostics, {Closed::kNo, 7})[0].closed);
}

TEST(Clean, AWayOutAndBackIsNoLoopAndIsDivided) {
  Made m = made();
  for (int i = 0; i <= 30; ++i) m.add(10.0 * i, 0, 1.0);
  for (int i = 29; i >= 0; --i) m.add(10.0 * i, 0, 1.0);
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics);
  ASSERT_EQ(tracks.size(), 2u);
  EXPECT_EQ(tracks[0].points.size(), 31u);
  EXPECT_EQ(tracks[1].points.size(), 31u);
  EXPECT_EQ(tracks[0].points.back().position_m, tracks[1].points.front().position_m);
  EXPECT_FALSE(tracks[0].closed);
  EXPECT_TRUE(mentions(diagnostics, "point 31: the track turns back"));
}

TEST(Clean, AClosedTrackThatTurnsBackIsOpenedThere) {
  Made m = circle(40, 200, 1);
  // A spur of three points from point 10 outward and back.
  Made with_spur = made();
  for (int i = 0; i < 40; ++i) {
    const glm::dvec2 p = m.positions_m[i];
    with_spur.add(p.x, p.y, 1.0);
    if (i != 10) continue;
    for (const double k : {1.2, 1.4, 1.6, 1.4, 1.2, 1.0}) with_spur.add(k * p.x, k * p.y, 1.0);
  }
  Diagnostics diagnostics;
  const auto tracks = cleaned(with_spur, diagnostics, {Closed::kYes, 7});
  ASSERT_EQ(tracks.size(), 1u);
  EXPECT_FALSE(tracks[0].closed);
  EXPECT_EQ(tracks[0].points.size(), 47u);  // 46, and the tip again
  EXPECT_EQ(tracks[0].points.front().position_m, tracks[0].points.back().position_m);
}

TEST(Clean, ASlipOfOnePointIsDropped) {
  for (const bool exact : {false, true}) {
    Made m = made();
    for (int i = 0; i <= 20; ++i) {
      m.add(10.0 * i, 0, 1.0);
      if (i == 7) m.add(95, 0.1, 1.0);         // ahead, and back to the next point
      if (i == 7 && exact) m.add(70, 0, 1.0);  // or back to the very same point
    }
    Diagnostics diagnostics;
    const auto tracks = cleaned(m, diagnostics);
    ASSERT_EQ(tracks.size(), 1u);
    EXPECT_EQ(tracks[0].points.size(), 21u);
    EXPECT_TRUE(mentions(diagnostics, "point 9: the track goes out to this point and straight back"));
  }
}

TEST(Clean, JitterIsDroppedFromRecordedTracksOnly) {
  Made m = made();
  for (int i = 0; i <= 20; ++i) {
    m.add(10.0 * i, 0, 1.0);
    if (i == 7) m.add(68, 2, 1.0).add(71, 1, 1.0).add(69, -1, 1.0);  // standing still
  }
  Diagnostics diagnostics;
  EXPECT_EQ(cleaned(m, diagnostics)[0].points.size(), 24u);
  m.track.recorded = true;
  const auto tracks = cleaned(m, diagnostics);
  for (std::size_t i = 1; i + 1 < tracks[0].points.size(); ++i) {
    const glm::dvec2 a = tracks[0].points[i].position_m - tracks[0].points[i - 1].position_m;
    const glm::dvec2 b = tracks[0].points[i + 1].position_m - tracks[0].points[i].position_m;
    EXPECT_GE(glm::dot(a, b), 0);
  }
  EXPECT_GE(tracks[0].points.size(), 20u);
  EXPECT_TRUE(mentions(diagnostics, "within the error of GPS"));
}

TEST(Clean, ZeroAndVoidHeightsAreInterpolatedOverDistance) {
  Made m = made();
  m.add(0, 0, 0.0).add(10, 0, 500.0).add(20, 0, -32768.0).add(50, 0, 0.0).add(60, 0, 505.0).add(70, 0, -9999.0);
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics);
  const auto& p = tracks[0].points;
  EXPECT_EQ(p[0].height_m, 500);
  EXPECT_EQ(p[1].height_m, 500);
  EXPECT_NEAR(p[2].height_m, 501, 1e-12);
  EXPECT_NEAR(p[3].height_m, 504, 1e-12);
  EXPECT_EQ(p[5].height_m, 505);
  EXPECT_TRUE(mentions(diagnostics, "f.csv:2: point 1: height drops to zero"));
  EXPECT_TRUE(mentions(diagnostics, "f.csv:4: point 3: height is a void value"));
  EXPECT_EQ(diagnostics.size(), 4u);
}

TEST(Clean, HeightsOfALoopAreInterpolatedAroundItsStart) {
  Made m = circle(100, 200, 1);
  m.track.points[0].height_m = 0;
  m.track.points[1].height_m = 120;
  m.track.points[99].height_m = 110;
  Diagnostics diagnostics;
  EXPECT_NEAR(cleaned(m, diagnostics)[0].points[0].height_m, 115, 1e-9);
}

TEST(Clean, ARoadAtSeaLevelKeepsItsZeros) {
  Made m = made();
  for (int i = 0; i < 20; ++i) m.add(10.0 * i, 0, i % 3 == 0 ? 0.0 : 2.0);
  for (int i = 0; i < 20; ++i) m.add(200 + 100.0 * i, 0, i == 10 ? 0.0 : 6.0);  // and slopes that roads have
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics);
  EXPECT_TRUE(diagnostics.empty());
  EXPECT_EQ(tracks[0].points[30].height_m, 0);
}

TEST(Clean, SpikesOfHeightAreRepairedAndStepsAreKept) {
  Made m = made();
  const double heights[] = {100, 101, 130, 102, 103, 60, 104, 140, 141, 142};
  for (int i = 0; i < 10; ++i) m.add(10.0 * i, 0, heights[i]);
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics);
  EXPECT_NEAR(tracks[0].points[2].height_m, 101.5, 1e-12);
  EXPECT_NEAR(tracks[0].points[5].height_m, 103.5, 1e-12);
  EXPECT_EQ(tracks[0].points[7].height_m, 140);
  EXPECT_EQ(diagnostics.size(), 2u);
}

TEST(Clean, MissingHeightsAreZeroWhereNoneIsKnown) {
  Made none = made();
  none.add(0, 0).add(10, 0).add(20, 0);
  Diagnostics diagnostics;
  EXPECT_EQ(cleaned(none, diagnostics)[0].points[1].height_m, 0);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].severity, Severity::kInfo);

  Made some = made();
  some.add(0, 0).add(10, 0, 7.0).add(20, 0).add(30, 0, 9.0);
  const auto tracks = cleaned(some, diagnostics);
  EXPECT_EQ(tracks[0].points[0].height_m, 7);
  EXPECT_EQ(tracks[0].points[2].height_m, 8);

  Made voids = made();
  voids.add(0, 0, -32768.0).add(10, 0, std::nan("")).add(20, 0, 1e30);
  EXPECT_EQ(cleaned(voids, diagnostics)[0].points[2].height_m, 0);
}

TEST(Clean, WidthsOutOfRangeBecomeTheDefault) {
  Made m = made();
  m.add(0, 0, 1.0, 5.0).add(10, 0, 1.0, 0.0).add(20, 0, 1.0, -3.0).add(30, 0, 1.0).add(40, 0, 1.0, 1e9);
  Diagnostics diagnostics;
  const auto tracks = cleaned(m, diagnostics, {Closed::kAuto, 8});
  const double expected[] = {5, 8, 8, 8, 8};
  for (int i = 0; i < 5; ++i) EXPECT_EQ(tracks[0].points[i].width_m, expected[i]);
  EXPECT_EQ(diagnostics.size(), 2u);
}

TEST(Clean, RangeErrorsNameTheLineAndASwap) {
  const auto check = [](double longitude, double latitude) {
    Made m = made();
    m.track.geodetic = true;
    m.add(0, 0).add(longitude, latitude);
    return check_range(m.track);
  };
  EXPECT_TRUE(check(180, -90).ok());
  const Status swapped = check(-38.9, -105.0), wild = check(500000, 4500000), east = check(181, 0);
  ASSERT_FALSE(swapped.ok());
  EXPECT_EQ(swapped.error().line, 3);
  EXPECT_NE(swapped.error().message.find("swapped"), std::string::npos);
  ASSERT_FALSE(wild.ok());
  EXPECT_EQ(wild.error().message.find("swapped"), std::string::npos);
  EXPECT_FALSE(east.ok());
}

TEST(Clean, TooFewPointsAreAnError) {
  for (const auto closed : {Closed::kAuto, Closed::kYes}) {
    Made m = made();
    m.add(1, 1).add(1, 1);
    if (closed == Closed::kYes) m.add(5, 5).add(1, 1);
    Diagnostics diagnostics;
    const auto result = clean_track(m.track, m.positions_m, {closed, 7}, diagnostics);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().file, "f.csv");
  }
}

}  // namespace
}  // namespace roadgen
