// Records of OpenDRIVE one kind at a time: small files with answers worked out by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <random>

#include "roadgen/export/opendrive.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/import/plan_curve.h"

namespace roadgen {
namespace {

struct Parts {
  std::string plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>)";
  std::string elevation, lateral;
  std::string offset, left = lane(1, width(3)), center, right = lane(-1, width(4));
  std::string sections;  // instead of left, center and right
  std::string objects, signals;

  static std::string cubic(double a, double b = 0, double c = 0, double d = 0) {
    char text[200];
    std::snprintf(text, sizeof text, R"( a="%.17g" b="%.17g" c="%.17g" d="%.17g"/>)", a, b, c, d);
    return text;
  }
  static std::string at(const char* tag, const char* where, double s, const std::string& rest) {
    char text[200];
    std::snprintf(text, sizeof text, R"(<%s %s="%.17g")", tag, where, s);
    return text + rest;
  }
  static std::string width(double a, double b = 0, double c = 0, double d = 0, double s = 0) {
    return at("width", "sOffset", s, cubic(a, b, c, d));
  }
  static std::string lane(int id, const std::string& inside, const char* type = "driving") {
    return "<lane id=\"" + std::to_string(id) + "\" type=\"" + type + "\">" + inside + "</lane>\n";
  }
  static std::string mark(const std::string& type, double s = 0, const std::string& inside = "") {
    return at("roadMark", "sOffset", s,
              " type=\"" + type + "\" color=\"yellow\" width=\"0.1\">" + inside + "</roadMark>");
  }
  std::string text() const {
    const std::string one = R"(<laneSection s="0"><left>)" + left + R"(</left><center><lane id="0" type="none">)" +
                            center + "</lane></center><right>" + right + "</right></laneSection>";
    return "<OpenDRIVE><header revMajor=\"1\" revMinor=\"6\"/>\n<road id=\"7\" length=\"100\" "
           "junction=\"-1\">\n<planView>\n" +
           plan + "\n</planView>\n<elevationProfile>\n" + elevation + "\n</elevationProfile>\n<lateralProfile>\n" +
           lateral + "\n</lateralProfile>\n<lanes>\n" + offset + (sections.empty() ? one : sections) +
           "\n</lanes>\n<objects>\n" + objects + "\n</objects>\n<signals>\n" + signals +
           "\n</signals>\n</road></OpenDRIVE>";
  }
};

Road road_of(const Parts& parts, Diagnostics* diagnostics = nullptr) {
  const Result<Network> network = parse_opendrive(parts.text(), "n.xodr", diagnostics);
  EXPECT_TRUE(network.ok()) << network.error().text();
  if (!network.ok()) return {};
  // What is read is written and read again as the same bits.
  const Result<std::string> written = opendrive_text(*network);
  EXPECT_TRUE(written.ok());
  const Result<Network> again = parse_opendrive(*written, "again.xodr");
  EXPECT_TRUE(again.ok()) << again.error().text();
  EXPECT_EQ(*opendrive_text(*again), *written);
  EXPECT_EQ(again->roads[0].sections, network->roads[0].sections);
  return network->roads[0];
}

const LaneSection& section_at(const Road& road, double s) {
  return road.sections[road.segments[segment_at(road, s)].section];
}
// t of the outer border of a lane, of lane 0 itself for 0.
double border_at(const Road& road, double s, int id) {
  const LaneSection& section = section_at(road, s);
  return section.borders_m()[static_cast<std::size_t>(static_cast<int>(section.right.size()) + id)].value(s -
                                                                                                          section.s_m);
}
double height_at(const Road& road, double s, double t) { return pose_at(road, s, t).position_m.z; }

TEST(OpenDriveLanes, WidthRecordsDivideTheSection) {
  Parts parts;
  parts.left = Parts::lane(2, Parts::width(0) + Parts::width(0, 0, 0.03, -0.002, 40) + Parts::width(1, 0, 0, 0, 50)) +
               Parts::lane(1, Parts::width(3, 0.01));
  const Road road = road_of(parts);
  ASSERT_EQ(road.sections.size(), 3u);
  EXPECT_EQ(road.sections[1].s_m, 40);
  EXPECT_EQ(road.sections[2].s_m, 50);
  for (double s = 0.5; s < 100; s += 1) {
    const double ds = s - 40, taper = s < 40 ? 0 : s < 50 ? 0.03 * ds * ds - 0.002 * ds * ds * ds : 1;
    EXPECT_NEAR(border_at(road, s, 1), 3 + 0.01 * s, 1e-12) << s;
    EXPECT_NEAR(border_at(road, s, 2), 3 + 0.01 * s + taper, 1e-12) << s;
    EXPECT_NEAR(border_at(road, s, -1), -4, 1e-12) << s;
  }
  EXPECT_NEAR(road.length_m(), 100, 1e-9);
}

TEST(OpenDriveLanes, OffsetsMoveAllLanes) {
  Parts parts;
  parts.offset = Parts::at("laneOffset", "s", 0, Parts::cubic(0)) +
                 Parts::at("laneOffset", "s", 30, Parts::cubic(0, 0.1)) +
                 Parts::at("laneOffset", "s", 60, Parts::cubic(3));
  const Road road = road_of(parts);
  for (double s = 0.5; s < 100; s += 1) {
    const double offset = s < 30 ? 0 : s < 60 ? 0.1 * (s - 30) : 3;
    EXPECT_NEAR(border_at(road, s, 0), offset, 1e-12);
    EXPECT_NEAR(border_at(road, s, 1), offset + 3, 1e-12);
    EXPECT_NEAR(border_at(road, s, -1), offset - 4, 1e-12);
    const Segment& segment = road.segments[segment_at(road, s)];
    EXPECT_NEAR(segment.left_m.value(s - segment.s_start_m), offset + 3, 1e-12);
  }
}

TEST(OpenDriveLanes, BordersGiveWidths) {
  Parts parts;
  parts.right = Parts::lane(-1, Parts::at("border", "sOffset", 0, Parts::cubic(-3, -0.01))) +
                Parts::lane(-2, Parts::at("border", "sOffset", 0, Parts::cubic(-5)) +
                                    Parts::at("border", "sOffset", 20, Parts::cubic(-5, 0, -0.001)));
  const Road road = road_of(parts);
  for (double s = 0.5; s < 100; s += 1) {
    EXPECT_NEAR(border_at(road, s, -1), -3 - 0.01 * s, 1e-12);
    EXPECT_NEAR(border_at(road, s, -2), s < 20 ? -5 : -5 - 0.001 * (s - 20) * (s - 20), 1e-11);
  }
}

TEST(OpenDriveLanes, SectionsHeightsAndMaterialsBeginWhereTheFileSays) {
  Parts parts;
  const std::string height = R"(<height sOffset="10" inner="0.1" outer="0.12"/>)";
  parts.sections =
      R"(<laneSection s="0"><right>)" + Parts::lane(-1, Parts::width(3)) +
      R"(</right></laneSection><laneSection s="55.5"><right>)" + Parts::lane(-1, Parts::width(3)) +
      Parts::lane(-2, Parts::width(2) + R"(<material sOffset="0" surface="Concrete"/>)" + height, "sidewalk") +
      "</right></laneSection>";
  const Road road = road_of(parts);
  ASSERT_EQ(road.sections.size(), 3u);
  EXPECT_NEAR(road.sections[1].s_m, 55.5, 1e-12);
  EXPECT_NEAR(road.sections[2].s_m, 65.5, 1e-12);
  EXPECT_EQ(section_at(road, 50).right.size(), 1u);
  EXPECT_EQ(section_at(road, 60).right[1].material, Material::kConcrete);
  EXPECT_EQ(section_at(road, 60).right[1].type, LaneType::kSidewalk);
  EXPECT_EQ(section_at(road, 60).right[1].outer_height_m, 0);
  EXPECT_EQ(section_at(road, 70).right[1].inner_height_m, 0.1);
  EXPECT_EQ(section_at(road, 70).right[1].outer_height_m, 0.12);
}

TEST(OpenDriveLanes, ASingleSidedSectionLeavesTheOtherSide) {
  Parts parts;
  parts.sections = R"(<laneSection s="0"><left>)" + Parts::lane(1, Parts::width(3, 0.01)) + "</left><right>" +
                   Parts::lane(-1, Parts::width(4)) +
                   R"(</right></laneSection><laneSection s="50" singleSide="true"><right>)" +
                   Parts::lane(-1, Parts::width(5)) + "</right></laneSection>";
  const Road road = road_of(parts);
  for (double s = 0.5; s < 100; s += 1) {
    EXPECT_NEAR(border_at(road, s, 1), 3 + 0.01 * s, 1e-12);
    EXPECT_NEAR(border_at(road, s, -1), s < 50 ? -4 : -5, 1e-12);
  }
}

TEST(OpenDriveLanes, MarksFollowTypeSideAndPlace) {
  struct Row {
    const char* type;
    MarkKind left, other;  // on a left lane; on the centre and on right lanes
  };
  const Row rows[] = {{"none", MarkKind::kNone, MarkKind::kNone},
                      {"solid", MarkKind::kSolid, MarkKind::kSolid},
                      {"broken", MarkKind::kBroken, MarkKind::kBroken},
                      {"solid solid", MarkKind::kSolidSolid, MarkKind::kSolidSolid},
                      {"solid broken", MarkKind::kSolidBroken, MarkKind::kBrokenSolid},
                      {"broken solid", MarkKind::kBrokenSolid, MarkKind::kSolidBroken},
                      {"broken broken", MarkKind::kBrokenBroken, MarkKind::kBrokenBroken}};
  for (const Row& row : rows) {
    Parts parts;
    parts.left = Parts::lane(1, Parts::width(3) + Parts::mark("solid") + Parts::mark(row.type, 25));
    parts.center = Parts::mark(row.type);
    parts.right = Parts::lane(-1, Parts::width(3) + Parts::mark(row.type));
    const Road road = road_of(parts);
    EXPECT_EQ(section_at(road, 10).left[0].mark.kind, MarkKind::kSolid);
    EXPECT_EQ(section_at(road, 30).left[0].mark.kind, row.left) << row.type;
    EXPECT_EQ(section_at(road, 10).center_mark.kind, row.other) << row.type;
    EXPECT_EQ(section_at(road, 10).right[0].mark.kind, row.other) << row.type;
    EXPECT_EQ(section_at(road, 10).center_mark.color, PaintColor::kYellow);
    EXPECT_EQ(section_at(road, 10).center_mark.width_m, 0.1);
  }
}

// A width that changes begins a new section here, not in the file: dashes do not begin again.
TEST(OpenDriveLanes, DashesGoOnWhereOnlyTheLaneChanges) {
  Parts parts;
  parts.right = Parts::lane(-1, Parts::width(3) + "<width sOffset=\"25\" a=\"3\" b=\"0.01\" c=\"0\" d=\"0\"/>" +
                                    Parts::mark("broken", 4, R"(<type name="x"><line length="2" space="3" sOffset="1.5"
                                    width="0.3"/></type>)"));
  const Road road = road_of(parts);
  EXPECT_EQ(section_at(road, 2).right[0].mark.kind, MarkKind::kNone);
  // The first dash begins at 5.5.
  EXPECT_NEAR(section_at(road, 10).right[0].mark.phase_m, 3.5, 1e-12);
  EXPECT_NEAR(section_at(road, 30).right[0].mark.phase_m, 4.5, 1e-12);
}

TEST(OpenDriveLanes, LinesGiveDashesAndSpace) {
  Parts parts;
  parts.center = Parts::mark("solid broken", 0,
                             R"(<type name="x" width="0.1"><line length="4" space="8" tOffset="-0.2" sOffset="0"
                             width="0.15"/><line length="1" space="0" tOffset="0.2" sOffset="0" width="0.15"/></type>)");
  parts.right = Parts::lane(
      -1,
      Parts::width(3) + Parts::mark("custom", 0, R"(<type name="x"><line length="2" space="3" width="0.3"/></type>)"));
  const Road road = road_of(parts);
  const Mark center = road.sections[0].center_mark, right = road.sections[0].right[0].mark;
  EXPECT_EQ(center.kind, MarkKind::kBrokenSolid);
  EXPECT_NEAR(center.space_m, 0.25, 1e-15);
  EXPECT_EQ(center.width_m, 0.15);
  EXPECT_EQ(center.on_m, 4);
  EXPECT_EQ(center.off_m, 8);
  EXPECT_EQ(right.kind, MarkKind::kBroken);
  EXPECT_EQ(right.width_m, 0.3);
  EXPECT_EQ(right.off_m, 3);
}

TEST(OpenDriveLanes, RecordsBesideAJointSnapAndCloserOnesShareOne) {
  Parts parts;
  parts.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="50"><line/></geometry>
<geometry s="50" x="50" y="0" hdg="0" length="50"><line/></geometry>)";
  parts.left = Parts::lane(1, Parts::width(3) + Parts::width(3, 0.1, 0, 0, 50.0000005) + Parts::width(4, 0, 0, 0, 60) +
                                  Parts::width(5, 0, 0, 0, 60.001));
  const Road road = road_of(parts);
  ASSERT_EQ(road.segments.size(), 3u);
  EXPECT_EQ(road.segments[1].s_start_m, 50);
  EXPECT_NEAR(road.segments[2].s_start_m, 60, 1e-12);
  EXPECT_NEAR(border_at(road, 55, 1), 3.5, 1e-9);
  EXPECT_NEAR(border_at(road, 61, 1), 5, 1e-12);
}

// A paramPoly3 that turns by 0.9 rad, with records within it.
TEST(OpenDriveProfiles, RecordsWithinACurveDivideItSmoothly) {
  const ParametricCubic curve{{5, 7}, {60, 0}, {-5, 25}, {-3, -4}};
  const PlanCurve truth(curve);
  const double length = truth.arc_m(0, 1);
  Parts parts;
  char text[300];
  std::snprintf(text, sizeof text,
                R"(<geometry s="0" x="5" y="7" hdg="0" length="%.17g"><paramPoly3 aU="0" bU="60" cU="-5" dU="-3" aV="0"
 bV="0" cV="25" dV="-4" pRange="normalized"/></geometry>)",
                length);
  parts.plan = text;
  parts.elevation = Parts::at("elevation", "s", 0, Parts::cubic(1, 0.02)) +
                    Parts::at("elevation", "s", 17.3, Parts::cubic(1.346, 0.02, 0.001)) +
                    Parts::at("elevation", "s", 40, Parts::cubic(3, 0, 0, 1e-5));
  const Road road = road_of(parts);
  EXPECT_NEAR(road.length_m(), length, 1e-5);
  const CheckReport report = check(Network{.name = {}, .georeference = {}, .roads = {road}, .junctions = {}});
  EXPECT_LT(report.worst.position_m, 1e-12);
  EXPECT_LT(report.worst.heading_rad, 1e-12);
  for (double s = 0.1; s < length; s += 0.7) {
    const double p = truth.p_at_arc(s);
    EXPECT_LT(glm::length(glm::dvec2(pose_at(road, s, 0).position_m) - truth.position_m(p)), kPlanTolerance_m);
    const double z = s < 17.3 ? 1 + 0.02 * s
                     : s < 40 ? 1.346 + 0.02 * (s - 17.3) + 0.001 * (s - 17.3) * (s - 17.3)
                              : 3 + 1e-5 * std::pow(s - 40, 3);
    if (std::abs(s - 40) > 0.01) {
      EXPECT_NEAR(height_at(road, s, 0), z, 1e-5) << s;
    }
  }
}

TEST(OpenDriveProfiles, SuperelevationLiftsTheLeft) {
  Parts parts;
  parts.lateral = Parts::at("superelevation", "s", 0, Parts::cubic(0)) +
                  Parts::at("superelevation", "s", 20, Parts::cubic(0, 0, 0.0003));
  const Road road = road_of(parts);
  for (double s = 0.5; s < 100; s += 3) {
    const double e = s < 20 ? 0 : 0.0003 * (s - 20) * (s - 20);
    for (const double t : {-4.0, -1.0, 2.0}) {
      EXPECT_NEAR(height_at(road, s, t), t * std::sin(e), 2e-10);  // surface_tan to 5e-11, to 106 degrees
      EXPECT_NEAR(pose_at(road, s, t).position_m.y, t * std::cos(e), 1e-12);
    }
  }
}

TEST(OpenDriveProfiles, CrossfallFallsFromTheReferenceLine) {
  Parts parts;
  parts.lateral = Parts::at("crossfall", "side=\"left\" s", 0, Parts::cubic(0.03)) +
                  Parts::at("crossfall", "side=\"right\" s", 0, Parts::cubic(-0.02)) +
                  Parts::at("crossfall", "side=\"both\" s", 50, Parts::cubic(0.025, 0.0001));
  Diagnostics diagnostics;
  const Road road = road_of(parts, &diagnostics);
  for (double s = 0.5; s < 100; s += 3) {
    const double both = 0.025 + 0.0001 * (s - 50), left = s < 50 ? 0.03 : both, right = s < 50 ? -0.02 : both;
    // tan is linear in these angles to 1e-6.
    EXPECT_NEAR(height_at(road, s, 3), -3 * std::tan(left), 3e-6);
    EXPECT_NEAR(height_at(road, s, -4), -4 * std::tan(right), 4e-6);
    EXPECT_NEAR(height_at(road, s, 0), 0, 1e-12);
  }
}

TEST(OpenDriveProfiles, ShapeBecomesSlopesToBothSides) {
  // A roof of 2 % and 3 % that becomes one of 4 % and 1 % and rises by 0.2 m.
  Parts parts;
  const auto shape = [](double s, double t, double a, double b, double c = 0) {
    return Parts::at("shape", "s", s, Parts::at("", "t", t, Parts::cubic(a, b, c)).substr(1));
  };
  parts.lateral =
      shape(0, -4, -0.12, 0.03) + shape(0, 0, 0, -0.02) + shape(80, -4, 0.16, 0.01) + shape(80, 0, 0.2, -0.04);
  Diagnostics diagnostics;
  const Road road = road_of(parts, &diagnostics);
  EXPECT_TRUE(diagnostics.empty()) << diagnostics[0].text();
  for (double s = 0.5; s < 100; s += 3) {
    const double part = std::min(s / 80, 1.0);
    EXPECT_NEAR(height_at(road, s, 3), 0.2 * part - 3 * (0.02 + 0.02 * part), 1e-12);
    EXPECT_NEAR(height_at(road, s, -4), 0.2 * part - 4 * (0.03 - 0.02 * part), 1e-12);
  }
  // A parabola -0.01 t^2 is no roof: least squares through 0 give -0.0075 |t| edge, off by up to 0.04 m there.
  parts.lateral = shape(0, -4, -0.16, 0.08, -0.01);
  const Road round = road_of(parts, &diagnostics);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("kept as slopes"), std::string::npos);
  EXPECT_NEAR(height_at(round, 50, -4), -0.0075 * 16, 0.005);
}

// Arcs, spirals and poly3 against closed forms or fine integration, at equal arc lengths.
TEST(OpenDriveGeometry, ArcsSpiralsAndPoly3StayWithinAMillimetre) {
  struct Case {
    const char* shape;
    std::function<double(double)> heading;  // over s
  };
  const Case cases[] = {
      {R"(<arc curvature="0.05"/>)", [](double s) { return 0.3 + 0.05 * s; }},
      // 0.88 of its radius wide: certified by halving.
      {R"(<arc curvature="0.22"/>)", [](double s) { return 0.3 + 0.22 * s; }},
      {R"(<arc curvature="-0.001"/>)", [](double s) { return 0.3 - 0.001 * s; }},
      {R"(<spiral curvStart="0" curvEnd="0.04"/>)", [](double s) { return 0.3 + 0.5 * 0.0004 * s * s; }},
      {R"(<spiral curvStart="0.03" curvEnd="-0.02"/>)", [](double s) { return 0.3 + 0.03 * s - 0.5 * 0.0005 * s * s; }},
  };
  for (const Case& c : cases) {
    Parts parts;
    parts.plan = std::string(R"(<geometry s="0" x="10" y="20" hdg="0.3" length="100">)") + c.shape + "</geometry>";
    const Road road = road_of(parts);
    EXPECT_NEAR(road.length_m(), 100, 1e-6 * static_cast<double>(road.segments.size()));
    EXPECT_TRUE(check(Network{.name = {}, .georeference = {}, .roads = {road}, .junctions = {}}).ok());
    glm::dvec2 p(10, 20);
    constexpr double kStep = 0.01;  // the midpoint rule is good to kStep^2 / 24 times the curvature squared per metre
    for (int i = 0; i < 10000; ++i) {
      const double s = i * kStep;
      if (i % 50 == 0) {
        EXPECT_LT(glm::length(glm::dvec2(pose_at(road, s, 0).position_m) - p), kPlanTolerance_m) << c.shape << s;
      }
      const double heading = c.heading(s + 0.5 * kStep);
      p += kStep * glm::dvec2(std::cos(heading), std::sin(heading));
    }
  }
  Parts parts;
  parts.plan =
      R"(<geometry s="0" x="10" y="20" hdg="0" length="100"><poly3 a="0" b="0.1" c="0.004" d="-3e-05"/></geometry>)";
  const Road road = road_of(parts);
  for (double s = 0; s <= 100; s += 5) {
    const glm::dvec2 p = glm::dvec2(pose_at(road, s, 0).position_m) - glm::dvec2(10, 20);
    EXPECT_NEAR(p.y, 0.1 * p.x + 0.004 * p.x * p.x - 3e-5 * p.x * p.x * p.x, kPlanTolerance_m);
  }
  EXPECT_NEAR(road.length_m(), 100, 1e-5);
}

// A curve whose heading is a quadratic of s, from (0, 0): positions in long double. Lines and arcs by their closed forms,
// spirals by the Fresnel integrals, each panel of at most 0.2 rad by the 8-point Gauss-Legendre rule (error below 1e-18).
struct Spiral {
  long double heading, start, end, length;  // rad, 1/m, m

  long double heading_at(long double s) const { return heading + s * (start + 0.5L * s * (end - start) / length); }
  std::pair<long double, long double> at(long double s) const {
    if (start == end && start == 0) return {s * std::cos(heading), s * std::sin(heading)};
    if (start == end) {
      return {(std::sin(heading + start * s) - std::sin(heading)) / start,
              (std::cos(heading) - std::cos(heading + start * s)) / start};
    }
    constexpr long double kPlace[4] = {0.18343464249564980493947614236018L, 0.52553240991632898581773904918925L,
                                       0.79666647741362673959155393647583L, 0.96028985649753623168356086856947L};
    constexpr long double kWeight[4] = {0.36268378337836198296515044927720L, 0.31370664587788728733796220198660L,
                                        0.22238103445337447054435599442624L, 0.10122853629037625915253135430996L};
    const long double most = std::max(std::abs(start), std::abs(end));
    const int panels = 1 + static_cast<int>(most * s / 0.2L);
    long double x = 0, y = 0;
    for (int i = 0; i < panels; ++i) {
      const long double half = 0.5L * s / panels, middle = (2 * i + 1) * half;
      for (int k = 0; k < 4; ++k) {
        for (const long double side : {-1.0L, 1.0L}) {
          const long double angle = heading_at(middle + side * half * kPlace[k]);
          x += half * kWeight[k] * std::cos(angle);
          y += half * kWeight[k] * std::sin(angle);
        }
      }
    }
    return {x, y};
  }
};

// Lines, arcs and spirals with radii from 5 m to 10 km, in both directions, and through straight.
TEST(OpenDriveGeometry, AThousandPrimitivesStayWithinTheStatedErrors) {
  std::mt19937_64 random(20);
  std::uniform_real_distribution<double> uniform(0, 1);
  double worst_m = 0, worst_rad = 0, worst_joint_m = 0, worst_joint_rad = 0, worst_length_m = 0;
  std::size_t segments = 0, most = 1;
  for (int i = 0; i < 1000; ++i) {
    const auto curvature = [&] {
      const double radius = 5 * std::pow(2000, uniform(random));
      return (uniform(random) < 0.5 ? -1 : 1) / radius;
    };
    const int kind = i % 10;  // one line, three arcs, six spirals
    const double start = kind == 0 || kind == 9 ? 0 : curvature();
    const double end = kind <= 3 ? start : kind == 8 ? 0 : curvature();
    // As long as makes half a turn at the sharper end, up to 300 m.
    const double sharpest = std::max({std::abs(start), std::abs(end), 1e-9});
    const double length = std::min(300.0, (0.1 + 0.9 * uniform(random)) * M_PI / sharpest);
    const double heading = 2 * M_PI * uniform(random) - M_PI;
    const Spiral truth{heading, start, end, length};
    char plan[400];
    const int at =
        std::snprintf(plan, sizeof plan, R"(<geometry s="0" x="0" y="0" hdg="%.17g" length="%.17g">)", heading, length);
    if (kind == 0) std::snprintf(plan + at, sizeof plan - at, "<line/></geometry>");
    if (kind >= 1 && kind <= 3)
      std::snprintf(plan + at, sizeof plan - at, R"(<arc curvature="%.17g"/></geometry>)", start);
    if (kind >= 4)
      std::snprintf(plan + at, sizeof plan - at, R"(<spiral curvStart="%.17g" curvEnd="%.17g"/></geometry>)", start,
                    end);
    Parts parts;
    parts.plan = plan;
    parts.left = Parts::lane(1, Parts::width(2));
    parts.right = Parts::lane(-1, Parts::width(2));
    std::string text = parts.text();
    const std::size_t where = text.find("length=\"100\"");
    char whole[40];
    std::snprintf(whole, sizeof whole, "length=\"%.17g\"", length);
    text.replace(where, 12, whole);
    const auto network = parse_opendrive(text, "n.xodr");
    ASSERT_TRUE(network.ok()) << network.error().text() << plan;
    const Road& road = network->roads[0];
    segments += road.segments.size();
    worst_length_m =
        std::max(worst_length_m, std::abs(road.length_m() - length) / static_cast<double>(road.segments.size()));
    const auto off = [&](double s, glm::dvec2 p) {
      const auto [x, y] = truth.at(s);
      return static_cast<double>(std::hypot(p.x - x, p.y - y));
    };
    const auto turned = [&](double s, double by) {
      return std::abs(std::remainder(by - static_cast<double>(truth.heading_at(s)), 2 * M_PI));
    };
    for (int k = 0; k <= 40; ++k) {
      const double s = road.length_m() * k / 40;
      const RoadPose pose = pose_at(road, s, 0);
      worst_m = std::max(worst_m, off(s, glm::dvec2(pose.position_m)));
      worst_rad = std::max(worst_rad, turned(s, pose.heading_rad));
      ASSERT_LE(worst_m, kPlanTolerance_m) << plan << " at " << s;
    }
    for (const Segment& segment : road.segments) {
      worst_joint_m = std::max(worst_joint_m, off(segment.s_start_m, segment.start_m));
      worst_joint_rad = std::max(worst_joint_rad, turned(segment.s_start_m, heading_rad(segment, 0)));
    }
    // Joints lie on the curve, at an s that may be off by what every segment before may be off by.
    ASSERT_LE(worst_joint_m, kPlanArcTolerance_m * static_cast<double>(std::max(road.segments.size(), most)));
    most = std::max(most, road.segments.size());
  }
  std::printf("%zu segments: %.2e m, %.2e rad; at joints %.2e m, %.2e rad; length of a segment %.2e m\n", segments,
              worst_m, worst_rad, worst_joint_m, worst_joint_rad, worst_length_m);
  EXPECT_LE(worst_length_m, kPlanArcTolerance_m);
  EXPECT_LE(worst_rad, 1e-4);
  EXPECT_LE(worst_joint_rad, 1e-5);
}

TEST(OpenDriveObjects, StopLinesCrosswalksAndArrowsBecomePaint) {
  Parts parts;
  parts.objects = R"(<object id="1" type="roadMark" subtype="signalLines" s="10" t="-2" length="0.4" width="3"/>
<object id="2" type="crosswalk" s="20" t="0" hdg="1.5707963" length="7" width="3"/>
<object id="3" type="crosswalk" s="30" t="1" hdg="0"><outline><cornerLocal u="-1" v="-3" z="0"/>
<cornerLocal u="3" v="-3" z="0"/><cornerLocal u="3" v="4" z="0"/></outline></object>
<object id="4" type="roadMark" subtype="arrowStraightLeft" s="40" t="1.5" hdg="3.1415926" length="5" width="1"/>
<object id="5" type="crosswalk" s="50" t="0"><outlines><outline><cornerRoad s="48" t="-4" dz="0"/>
<cornerRoad s="52" t="3" dz="0"/></outline></outlines></object>
<object id="6" type="tree" s="1" t="9"/><object id="7" type="crosswalk" s="50" t="0" hdg="0.5" length="3" width="3"/>)";
  parts.signals = R"(<signal id="9" type="294" s="60" t="-6" orientation="+"/><signal id="8" type="274" s="1" t="5"/>)";
  Diagnostics diagnostics;
  const Road road = road_of(parts, &diagnostics);
  ASSERT_EQ(road.paint.size(), 6u);
  const auto expect = [&](std::size_t i, PaintKind kind, double s, double t, double length, double width,
                          bool against) {
    const Paint& p = road.paint[i];
    EXPECT_EQ(p.kind, kind) << i;
    EXPECT_NEAR(p.s_m, s, 1e-9) << i;
    EXPECT_NEAR(p.t_m, t, 1e-9) << i;
    EXPECT_NEAR(p.length_m, length, 1e-9) << i;
    EXPECT_NEAR(p.width_m, width, 1e-9) << i;
    EXPECT_EQ(p.against, against) << i;
  };
  expect(0, PaintKind::kLine, 10, -2, 0.4, 3, false);
  expect(1, PaintKind::kZebra, 20, 0, 3, 7, false);
  expect(2, PaintKind::kZebra, 31, 1.5, 4, 7, false);
  expect(3, PaintKind::kArrowStraightLeft, 40, 1.5, 5, 1, true);
  expect(4, PaintKind::kZebra, 50, -0.5, 4, 7, false);
  expect(5, PaintKind::kLine, 60, -2, 0.5, 4, false);
  int notes = 0;
  for (const Diagnostic& d : diagnostics) notes += d.message.find("not painted") != d.message.npos;
  EXPECT_EQ(notes, 1);  // the crosswalk askew
  EXPECT_EQ(road.records->objects.size(), 2u);  // with the tree
  EXPECT_EQ(road.records->signals.size(), 2u);
}

TEST(OpenDriveRecords, MalformedOnesAreErrorsWithTheLine) {
  struct Case {
    std::function<void(Parts&)> spoil;
    const char* says;
  };
  const Case cases[] = {
      {[](Parts& p) { p.left = Parts::lane(1, R"(<width sOffset="0" a="x" b="0" c="0" d="0"/>)"); }, "a=\"x\""},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<width a="3" b="0" c="0" d="0"/>)"); }, "sOffset"},
      {[](Parts& p) { p.left = Parts::lane(1, Parts::width(3, 0, 0, 0, 9) + Parts::width(3)); }, "in order"},
      {[](Parts& p) { p.left = Parts::lane(2, Parts::width(3)); }, "lane ids on the left"},
      {[](Parts& p) { p.right += Parts::lane(-1, Parts::width(3)); }, "lane ids on the right"},
      {[](Parts& p) { p.left = "<lane type=\"driving\"/>"; }, "lacks the attribute id"},
      {[](Parts& p) { p.left = "<lane id=\"1.5\" type=\"driving\"/>"; }, "integer"},
      {[](Parts& p) { p.left = "<lane id=\"1\"/>"; }, "lacks the attribute type"},
      {[](Parts& p) { p.left = Parts::lane(1, Parts::width(2e6)); }, "1e6"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<border sOffset="0" a="1" b="nan" c="0" d="0"/>)"); }, "finite"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<height sOffset="0" inner="inf" outer="0"/>)"); }, "finite"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<height sOffset="0" inner="1e7" outer="0"/>)"); }, "1e6"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<roadMark type="solid"/>)"); }, "sOffset"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<roadMark sOffset="0"/>)"); }, "lacks the attribute type"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<roadMark sOffset="0" type="solid" width="-1"/>)"); }, "negative"},
      {[](Parts& p) { p.center = Parts::mark("broken", 0, R"(<type><line length="-1" space="1"/></type>)"); },
       "negative"},
      {[](Parts& p) { p.left = Parts::lane(1, R"(<material surface="asphalt"/>)"); }, "sOffset"},
      {[](Parts& p) { p.offset = R"(<laneOffset s="0" a="1" b="0" c="0"/>)"; }, "lacks the attribute d"},
      {[](Parts& p) { p.offset = Parts::at("laneOffset", "s", 0, Parts::cubic(1e7)); }, "1e6"},
      {[](Parts& p) { p.sections = "<laneSection/>"; }, "lacks the attribute s"},
      {[](Parts& p) { p.sections = "<laneSection s=\"5\"/>"; }, "no <laneSection> starts at s = 0"},
      {[](Parts& p) { p.sections = " "; }, "no <laneSection>"},
      {[](Parts& p) { p.lateral = R"(<superelevation s="0" a="1" b="0" c="0"/>)"; }, "lacks the attribute d"},
      {[](Parts& p) { p.lateral = Parts::at("superelevation", "s", 0, Parts::cubic(1e7)); }, "1e6"},
      {[](Parts& p) { p.lateral = R"(<crossfall side="up" s="0" a="1" b="0" c="0" d="0"/>)"; }, "side=\"up\""},
      {[](Parts& p) { p.lateral = R"(<shape s="0" a="1" b="0" c="0" d="0"/>)"; }, "lacks the attribute t"},
      {[](Parts& p) { p.lateral = R"(<shape s="0" t="0" a="1e300" b="0" c="0" d="0"/>)"; }, "1e6"},
      {[](Parts& p) {
         p.lateral = R"(<shape s="9" t="0" a="1" b="0" c="0" d="1"/><shape s="0" t="0" a="1" b="0" c="0" d="1"/>)";
       },
       "in order"},
      {[](Parts& p) { p.objects = R"(<object type="crosswalk" t="0" length="1" width="1"/>)"; },
       "lacks the attribute s"},
      {[](Parts& p) { p.objects = R"(<object type="crosswalk" s="0" t="0" length="1" width="nan"/>)"; }, "finite"},
      {[](Parts& p) { p.objects = R"(<object type="crosswalk" s="0" t="1e9" length="1" width="1"/>)"; }, "1e6"},
      {[](Parts& p) {
         p.objects = R"(<object type="crosswalk" s="0" t="0"><outline><cornerLocal u="1"/></outline></object>)";
       },
       "lacks the attribute v"},
      {[](Parts& p) { p.signals = R"(<signal type="294"/>)"; }, "lacks the attribute s"},
      {[](Parts& p) { p.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="100"><arc/></geometry>)"; }, "curvature"},
      {[](Parts& p) { p.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="100"><arc curvature="9"/></geometry>)"; },
       "100 rad"},
      {[](Parts& p) {
         p.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="100"><spiral curvStart="0"/></geometry>)";
       },
       "lacks the attribute curvEnd"},
      {[](Parts& p) {
         p.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="100"><poly3 a="0" b="0" c="0" d="1e300"/></geometry>)";
       },
       "1e9"},
      {[](Parts& p) {
         p.plan =
             R"(<geometry s="0" x="0" y="0" hdg="0" length="9"><paramPoly3 aU="0" bU="1" cU="-1" dU="0" aV="0" bV="0" cV="0" dV="0" pRange="normalized"/></geometry>)";
       },
       "stops or reverses"},
      {[](Parts& p) { p.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="9"><nurbs/></geometry>)"; }, "<nurbs>"},
      {[](Parts& p) { p.plan.clear(); }, "<geometry>"},
  };
  for (const Case& c : cases) {
    Parts parts;
    c.spoil(parts);
    const Result<Network> network = parse_opendrive(parts.text(), "n.xodr");
    EXPECT_FALSE(network.ok()) << parts.text();
    if (network.ok()) continue;
    EXPECT_EQ(network.error().file, "n.xodr");
    EXPECT_GT(network.error().line, 0) << network.error().text();
    EXPECT_EQ(network.error().element, "road 7");
    EXPECT_NE(network.error().text().find(c.says), std::string::npos) << network.error().text() << " / " << c.says;
  }
}

// What has a sane reading is read, with a warning.
TEST(OpenDriveRecords, OddRoadsAreReadWithAWarning) {
  struct Case {
    std::function<void(Parts&)> spoil;
    const char* says;
  };
  const Case cases[] = {
      {[](Parts& p) { p.left = Parts::lane(1, Parts::width(-1)); }, "negative width"},
      {[](Parts& p) { p.left = Parts::lane(1, Parts::width(3, -0.1)); }, "negative width"},
      {[](Parts& p) { p.left = Parts::lane(1, ""), p.right.clear(); }, "no lane has any width"},
      {[](Parts& p) { p.left = Parts::lane(1, ""); }, "no <width> at its start"},
      {[](Parts& p) { p.left = Parts::lane(1, Parts::width(3), "moat"); }, "moat"},
      {[](Parts& p) { p.lateral = Parts::at("superelevation", "s", 0, Parts::cubic(1)); }, "superelevation of 57.3"},
      {[](Parts& p) { p.elevation = Parts::at("elevation", "s", 0, Parts::cubic(0, 1.5)); }, "grade of 150 %"},
      {[](Parts& p) { p.lateral = Parts::at("crossfall", "side=\"both\" s", 0, Parts::cubic(1)); },
       "crossfall of 156 %"},
      {[](Parts& p) { p.plan = R"(<geometry s="0" x="0" y="0" hdg="0" length="9"><arc curvature="0.4"/></geometry>)"; },
       "radius of 2.5"},
      {[](Parts& p) { p.objects = R"(<object type="crosswalk" s="9" t="30" length="1" width="1"/>)"; },
       "paint outside"},
      {[](Parts& p) { p.objects = R"(<object type="crosswalk" s="9" t="0" length="0" width="1"/>)"; }, "not positive"},
      {[](Parts& p) { p.center = Parts::mark("botts dots"); }, "botts dots"},
  };
  for (const Case& c : cases) {
    Parts parts;
    c.spoil(parts);
    Diagnostics diagnostics;
    const Road road = road_of(parts, &diagnostics);
    EXPECT_FALSE(road.segments.empty());
    bool told = false;
    for (const Diagnostic& d : diagnostics) told = told || d.text().find(c.says) != std::string::npos;
    EXPECT_TRUE(told) << c.says;
  }
}

}  // namespace
}  // namespace roadgen
