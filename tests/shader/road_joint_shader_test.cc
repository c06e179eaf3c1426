// Roads that the GPU paves in single precision: the lines v = const run through the joints without a gap or a kink.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "roadgen/road/segment.h"
#include "tests/shader/harness.h"

namespace roadgen::test {
namespace {

constexpr int kJoints = 10000;
constexpr double kTile_m = 500;  // joints lie within this distance, east and north, of the origin of their tile

// Two admissible segments that share an anchor and the tangent there, and a point of the line across the road at it.
struct Joint {
  Segment before, after;
  glm::dvec2 point_m;
  double v_m;  // of the point
};

Joint random_joint(Random& random) {
  while (true) {
    const double half_width = random.uniform(1, 10), heading = random.uniform(-3.1, 3.1);
    const glm::dvec2 anchor(random.uniform(-kTile_m, kTile_m), random.uniform(-kTile_m, kTile_m));
    const auto neighbour = [&](double side) {
      const double chord = random.uniform(5, 100), direction = heading + random.uniform(-0.5, 0.5);
      return anchor + side * chord * glm::dvec2(std::cos(direction), std::sin(direction));
    };
    Joint joint;
    joint.before = make_segment(neighbour(-1), anchor, heading + random.uniform(-0.7, 0.7), heading, half_width);
    joint.after = make_segment(anchor, neighbour(1), heading, heading + random.uniform(-0.7, 0.7), half_width);
    if (!is_admissible(joint.before) || !is_admissible(joint.after)) continue;
    joint.v_m = random.uniform(-half_width, half_width);
    joint.point_m = anchor + joint.v_m * glm::dvec2(-std::sin(heading), std::cos(heading));
    return joint;
  }
}

// The segment as a vertex shader gets it: everything in float, relative to the tile.
void append_segment(const Segment& segment, std::vector<float>& x) {
  const double length = segment.chord_length_m();
  const glm::dvec2 chord = segment.chord_m() / length;
  for (const double value :
       {segment.start_m.x, segment.start_m.y, chord.x, chord.y, length, segment.slope_start, segment.slope_end}) {
    x.push_back(static_cast<float>(value));
  }
}

// x: the point (2), then per segment its start (2), the direction of its chord (2), its length and slopes.
// y: per segment v in metres and the direction of the line v = const there.
constexpr int kInputs = 16, kOutputs = 6;
const char* const kBody = R"(
  for (int k = 0; k < 2; ++k) {
    int s = 2 + 7 * k;
    vec2 p = vec2(x[0] - x[s], x[1] - x[s + 1]), chord = vec2(x[s + 2], x[s + 3]);
    float a = x[s + 5], b = x[s + 6];
    RoadCoord c = road_project(dot(p, chord) / x[s + 4], (p.y * chord.x - p.x * chord.y) / x[s + 4], a, b);
    float slope = road_df(c.u, a, b);
    y[3 * k] = c.v * x[s + 4];
    y[3 * k + 1] = chord.x - slope * chord.y;
    y[3 * k + 2] = chord.y + slope * chord.x;
  })";

// At 500 m from the tile's origin a float is a multiple of 3.1e-5 m, so each anchor, and each difference of a point and
// an anchor, is off by up to 1.5e-5 m in x and y. Measured 4.6e-5 m.
constexpr double kPositionGapLimit_m = 9e-5;
// The slope is off by |f''| times the rounding of u, 1.5e-5 m over a chord of 5 m at worst, and the chord's direction
// by 6e-8. Measured 5.4e-6 rad.
constexpr double kTangentGapLimit_rad = 1e-5;

class RoadJointShader : public GlTest, public ::testing::WithParamInterface<ContextKind> {};

TEST_P(RoadJointShader, LinesOfConstantVAreContinuousInPositionAndTangent) {
  if (!make_context(GetParam())) return;
  Random random(3);
  std::vector<Joint> joints;
  std::vector<float> x;
  for (int i = 0; i < kJoints; ++i) {
    joints.push_back(random_joint(random));
    x.push_back(static_cast<float>(joints.back().point_m.x));
    x.push_back(static_cast<float>(joints.back().point_m.y));
    append_segment(joints.back().before, x);
    append_segment(joints.back().after, x);
  }
  const auto y = evaluate({"lib/road.glsl"}, kBody, x, kInputs, kOutputs);
  ASSERT_TRUE(y.ok()) << y.error().text();

  double position_gap = 0, offset_error = 0, tangent_gap = 0;
  for (size_t i = 0; i < joints.size(); ++i) {
    const float* row = &(*y)[i * kOutputs];
    position_gap = std::max<double>(position_gap, std::abs(row[0] - row[3]));
    offset_error = std::max(offset_error, std::abs(row[0] - joints[i].v_m));
    const double cross = double{row[1]} * row[5] - double{row[2]} * row[4];
    const double dot = double{row[1]} * row[4] + double{row[2]} * row[5];
    tangent_gap = std::max(tangent_gap, std::abs(std::atan2(cross, dot)));
  }
  std::printf("%d joints: position gap %.2e m (limit %.0e), v off by %.2e m, tangent gap %.2e rad (limit %.0e)\n",
              kJoints, position_gap, kPositionGapLimit_m, offset_error, tangent_gap, kTangentGapLimit_rad);
  EXPECT_LE(position_gap, kPositionGapLimit_m);
  EXPECT_LE(offset_error, kPositionGapLimit_m);
  EXPECT_LE(tangent_gap, kTangentGapLimit_rad);
}

INSTANTIATE_TEST_SUITE_P(, RoadJointShader, ::testing::Values(ContextKind::kOsmesa, ContextKind::kEgl),
                         [](const auto& test) { return context_kind_name(test.param); });

}  // namespace
}  // namespace roadgen::test
