// What `roadgen check` names is drawn nevertheless: finite pixels, no hole where the road has width, in bounded time.
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "roadgen/render/flight.h"
#include "roadgen/render/renderer.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen {
namespace {

constexpr int kWidth = 240, kHeight = 160;
// A frame of a good road of this size takes 0.05 s on one core; this is for a machine under load.
constexpr double kMostSeconds = 20;

// A bend of the given radius with two lanes of 3.5 m and a shoulder of 1 m on each side, level, in six segments.
Road bend(double radius_m) {
  Road road;
  road.id = "1";
  for (int i = 0; i < 6; ++i) {
    const double from = 0.25 * i, to = 0.25 * (i + 1);
    road.segments.push_back(make_segment({radius_m * std::sin(from), radius_m * (1 - std::cos(from))},
                                         {radius_m * std::sin(to), radius_m * (1 - std::cos(to))}, from, to, 4.5));
  }
  chain_arc_lengths(road);
  LaneSection section;
  section.center_mark.kind = MarkKind::kSolidBroken;
  const Mark solid{.kind = MarkKind::kSolid};
  section.left =
      section.right = {Lane{.mark = solid}, Lane{.type = LaneType::kShoulder, .width_m = {1, 0, 0, 0}, .mark = solid}};
  EXPECT_TRUE(set_sections(road, {section}).ok());
  return road;
}

void set_lanes(Road& road, const std::function<void(LaneSection&)>& change) {
  std::vector<LaneSection> sections = road.sections;
  for (LaneSection& section : sections) change(section);
  ASSERT_TRUE(set_sections(road, sections).ok());
}

struct Case {
  const char* says;  // what check() says of it
  bool same_shape;   // covers the very pixels of the good road
  std::function<void(Road&)> spoil;
};

std::vector<Case> cases() {
  const auto all = [](const std::function<void(Segment&)>& change) {
    return [change](Road& road) {
      for (Segment& segment : road.segments) change(segment);
    };
  };
  const auto paint = [](Paint p) { return [p](Road& road) { road.paint.push_back(p); }; };
  return {
      {"negative width", true,
       [](Road& road) {
         set_lanes(road, [](LaneSection& s) { s.left[0].width_m.c0 = -2, s.left[1].width_m.c0 = 6.5; });
       }},
      {"negative width", false,
       [](Road& road) {
         set_lanes(road, [](LaneSection& s) {
           // Dips to -2.5 m halfway, where the road's edges cross.
           const double half = 10;
           for (auto* side : {&s.left, &s.right}) (*side)[0].width_m = {3.5, -20 / half, 10 / (half * half), 0};
         });
       }},
      {"no lane has any width", false,
       [](Road& road) {
         set_lanes(road, [](LaneSection& s) {
           for (auto* side : {&s.left, &s.right}) {
             for (Lane& lane : *side) lane.width_m = {0, 0, 0, 0};
           }
         });
       }},
      {"superelevation", false, all([](Segment& s) {
         s.superelevation_rad = {1.2, 0, 0, 0};
       })},
      {"superelevation", false, all([](Segment& s) {
         s.superelevation_rad = {1.5, 0.1, 0, 0};
       })},
      {"superelevation", false, all([](Segment& s) {
         s.superelevation_rad = {100, 0, 0, 0};
       })},
      {"grade", false, all([](Segment& s) {
         s.elevation_m = {5 * s.s_start_m, 5, 0, 0};
       })},
      {"grade", false, all([](Segment& s) {
         s.elevation_m = {0, 1000, -1000 / s.arc_m, 0};
       })},
      {"crossfall", false, all([](Segment& s) {
         s.crossfall_left = s.crossfall_right = {3, 0};
       })},
      {"radius", false, [](Road& road) { road = bend(3); }},
      {"paint outside the road", true, paint({.s_m = 20, .t_m = 40})},
      {"paint outside the road", true, paint({.s_m = -1e6, .t_m = 0})},
      {"not positive", true,
       paint({.kind = PaintKind::kZebra, .s_m = 20, .length_m = 0, .width_m = -1, .stripe_m = 0})},
      {"not positive", true, paint({.kind = PaintKind::kArrowLeft, .s_m = 20, .length_m = -3, .width_m = 0})},
      {"elsewhere than at a joint", true, [](Road& road) { road.sections[0].s_m = 1.5; }},
  };
}

std::vector<Camera> cameras(const Road& road) {
  const glm::dvec3 middle = pose_at(road, 0.5 * road.length_m(), 0).position_m;
  std::vector<Camera> all;
  for (const double s : {1.0, 0.4 * road.length_m()}) {
    all.push_back(drive_camera(road, s, -1.75, 1.3));
    all.push_back(drive_camera(road, s, 0, 1e-3));
  }
  all.push_back({.position_m = middle + glm::dvec3(-5, 0, 60), .pitch_deg = -90});
  all.push_back({.position_m = middle + glm::dvec3(-40, 0, 4), .pitch_deg = -5});
  all.push_back({.position_m = middle + glm::dvec3(-20, 0, -8), .pitch_deg = 20});
  return all;
}

class BadRoadTest : public test::GlTest {
 protected:
  void SetUp() override {
    auto renderer = Renderer::create(*make_context(ContextKind::kOsmesa));
    ASSERT_TRUE(renderer.ok()) << renderer.error().text();
    renderer_.emplace(std::move(*renderer));
  }
  void TearDown() override {
    renderer_.reset();
    GlTest::TearDown();
  }
  Frame frame(const Road& road, const Camera& camera) {
    Network network;
    network.roads.push_back(road);
    EXPECT_TRUE(renderer_->load_roads(network).ok());
    auto frame = renderer_->render(camera, {.width = kWidth, .height = kHeight, .channels = kAllChannels});
    EXPECT_TRUE(frame.ok()) << frame.error().text();
    return std::move(*frame);
  }
  std::optional<Renderer> renderer_;
};

std::size_t bad_pixels(const Frame& frame) {
  std::size_t bad = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const float depth = frame.depth_m.at(x, y, 0);
      const bool on_road = frame.label.at(x, y, 0) >= static_cast<std::uint32_t>(Label::kCarriageway);
      bool good = !std::isnan(depth) && depth > 0 && (!on_road || std::isfinite(depth));
      for (int c = 0; c < 4; ++c) good = good && std::isfinite(frame.road.at(x, y, c));
      for (int c = 0; c < 3; ++c) good = good && std::isfinite(frame.normal.at(x, y, c));
      bad += !good;
    }
  }
  return bad;
}

std::size_t road_pixels(const Frame& frame) {
  std::size_t count = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) count += frame.instance.at(x, y, 0) != 0;
  }
  return count;
}

// Pixels that differ though all about them are road (or not) in the whole picture: other programs may round the edge's
// own pixels the other way.
int holes(const Frame& picture, const Frame& whole) {
  int count = 0;
  for (int y = 1; y + 1 < kHeight; ++y) {
    for (int x = 1; x + 1 < kWidth; ++x) {
      if (picture.instance.at(x, y, 0) == whole.instance.at(x, y, 0)) continue;
      bool inside = true;
      for (int j = -1; j <= 1; ++j) {
        for (int i = -1; i <= 1; ++i) {
          inside = inside && whole.instance.at(x + i, y + j, 0) == whole.instance.at(x, y, 0);
        }
      }
      count += inside;
    }
  }
  return count;
}

TEST_F(BadRoadTest, EveryBadRoadIsNamedAndDrawnSanely) {
  const Road good = bend(30);
  for (const Case& c : cases()) {
    Road road = bend(30);
    c.spoil(road);
    for (Segment& segment : road.segments) set_bound(segment);
    OddValues odd = odd_values(road);
    std::vector<std::string> problems = std::move(odd.problems);
    problems.insert(problems.end(), odd.warnings.begin(), odd.warnings.end());
    EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const std::string& problem) {
      return problem.starts_with("road 1, s = ") && problem.find(c.says) != problem.npos;
    })) << c.says;
    std::size_t seen = 0;
    for (const Camera& camera : cameras(road)) {
      const auto start = std::chrono::steady_clock::now();
      const Frame picture = frame(road, camera);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      EXPECT_LT(took.count(), kMostSeconds) << c.says;
      EXPECT_EQ(bad_pixels(picture), 0u) << c.says;
      seen += road_pixels(picture);
      if (!c.same_shape) continue;
      const Frame whole = frame(good, camera);
      EXPECT_EQ(holes(picture, whole), 0) << c.says << ": the road has a hole";
    }
    if (std::string_view(c.says) != "no lane has any width") {
      EXPECT_GT(seen, 1000u) << c.says;
    }
  }
}

TEST_F(BadRoadTest, NumbersThatAreNotFiniteAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::function<void(Road&)> spoils[] = {
      [&](Road& r) { r.segments[1].elevation_m.c1 = nan; },
      [&](Road& r) { r.sections[0].left[0].width_m.c2 = nan; },
      [&](Road& r) { r.sections[0].right[1].mark.width_m = nan; },
      [&](Road& r) { r.paint.push_back({.t_m = nan}); },
      [&](Road& r) { r.segments[1].end_m = r.segments[1].start_m; },
      [&](Road& r) { r.segments[1].section = 9; },
  };
  for (const auto& spoil : spoils) {
    Network network;
    network.roads.push_back(bend(30));
    spoil(network.roads[0]);
    const Status status = renderer_->load_roads(network);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().element, "road 1");
    EXPECT_FALSE(check(network).ok());
  }
}

}  // namespace
}  // namespace roadgen
