// World to road against a reference that tries every segment by bisection, and back again, at random points of many
// networks; hints and batches; no allocation.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <random>
#include <thread>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/import/import.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/query/road_index.h"
#include "tests/common/city.h"
#include "tests/temporary_folder.h"
#include "tests/unit/allocation_count.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using test::TemporaryFolder;
using testing::hairpin_network;
using testing::road_along;
using testing::Station;
using testing::straight;

constexpr double kRoundTrip_m = 1e-6;
// A point this near to an edge, or a place this near to another, is a tie; far above the rounding, far below all else.
constexpr double kTie_m = 1e-7;

// ---- The reference ----

struct Held {
  std::uint32_t road;
  double s_m, t_m;
  double n_m;       // horizontal distance from the reference line
  bool on_the_rim;  // within kTie_m of an edge or an open end
};

// All places of the network whose cross section holds the point: for every segment that is near, the changes of sign of
// the part of (p - c(u)) along the tangent, refined by bisection. Uses the road's curve and profiles alone.
std::vector<Held> places_of(const Network& network, glm::dvec2 p) {
  constexpr int kPieces = 48;
  std::vector<Held> found;
  for (std::uint32_t r = 0; r < network.roads.size(); ++r) {
    const Road& road = network.roads[r];
    for (const Segment& segment : road.segments) {
      const double reach = 0.5 * segment.arc_m + segment.max_half_width_m() + 1;
      if (glm::distance(p, 0.5 * (segment.start_m + segment.end_m)) > reach) continue;
      const double length = segment.chord_length_m(), a = segment.slope_start, b = segment.slope_end;
      const glm::dvec2 q = to_chord(segment, p);
      const auto along = [&](double u) { return q.x - u + (q.y - Lib::road_f(u, a, b)) * Lib::road_df(u, a, b); };
      const auto add = [&](double u, bool rim) {
        const double df = Lib::road_df(u, a, b), local = arc_at(segment, u);
        const double n = length * (q.y - Lib::road_f(u, a, b) - (q.x - u) * df) / std::sqrt(1 + df * df);
        const double cosine = std::cos(segment.superelevation_rad.value(local));
        const double inside =
            std::min(segment.left_m.value(local) * cosine - n, n - segment.right_m.value(local) * cosine);
        if (inside < -kTie_m) return;
        const Held place{r, segment.s_start_m + local, n / cosine, std::abs(n), rim || inside < kTie_m};
        for (Held& other : found) {  // at a joint both segments find it
          const double gap = std::abs(other.s_m - place.s_m);
          const bool same = std::min(gap, road.closed ? road.length_m() - gap : gap) < 1e-5;
          if (other.road == r && same && std::abs(other.t_m - place.t_m) < 1e-5) {
            other.on_the_rim = other.on_the_rim && place.on_the_rim;
            return;
          }
        }
        found.push_back(place);
      };
      double low = 0, at_low = along(0);
      // Within kTie_m of the end lines the place is the end's: on the rim, unless the neighbour holds it too.
      if (std::abs(at_low) * length < kTie_m) add(0, true);
      if (std::abs(along(1)) * length < kTie_m) add(1, true);
      for (int i = 1; i <= kPieces; ++i) {
        const double end = static_cast<double>(i) / kPieces, at_end = along(end);
        if ((at_low > 0) != (at_end > 0)) {
          double from = low, to = end;
          for (int k = 0; k < 60; ++k) {
            const double middle = 0.5 * (from + to);
            ((along(middle) > 0) == (at_low > 0) ? from : to) = middle;
          }
          add(0.5 * (from + to), false);
        }
        low = end;
        at_low = at_end;
      }
    }
  }
  return found;
}

// ---- Networks ----

RoadPlace random_place(const Network& network, std::mt19937_64& random) {
  std::uniform_real_distribution<double> part(0, 1);
  double total = 0;
  for (const Road& road : network.roads) total += road.length_m();
  double along = part(random) * total;
  RoadPlace place;
  while (place.road + 1 < network.roads.size() && along > network.roads[place.road].length_m()) {
    along -= network.roads[place.road++].length_m();
  }
  const Road& road = network.roads[place.road];
  place.s_m = std::min(along, road.length_m());
  const Segment& segment = road.segments[segment_at(road, place.s_m)];
  const double local = place.s_m - segment.s_start_m, right = segment.right_m.value(local);
  place.t_m = right + part(random) * (segment.left_m.value(local) - right);
  return place;
}

// An ellipse driven around once.
Network ring() {
  Network network;
  Road road;
  road.id = "ring";
  road.closed = true;
  constexpr int kPieces = 24;
  const auto at = [](int i) {
    const double angle = 2 * std::numbers::pi * (i % kPieces) / kPieces;
    return Station{{120 * std::cos(angle), 60 * std::sin(angle)},
                   std::atan2(60 * std::cos(angle), -120 * std::sin(angle))};
  };
  for (int i = 0; i < kPieces; ++i) {
    const Station a = at(i), b = at(i + 1);
    road.segments.push_back(make_segment(a.position_m, b.position_m, a.heading_rad, b.heading_rad, 5));
  }
  chain_arc_lengths(road);
  two_lane_sections(road);
  network.roads.push_back(std::move(road));
  return network;
}

// A banked bend with changing width and cross slopes, and a bridge over it on which a road turns back over itself.
Network banked_bend_under_a_bridge() {
  Network network;
  network.roads.push_back(road_along(
      "banked", 200, 10, 6,
      [](double s) {
        return Station{{60 * std::sin(s / 60), 60 - 60 * std::cos(s / 60)}, s / 60};
      },
      [](double s) { return 0.03 * s; }));
  for (Segment& segment : network.roads[0].segments) {
    segment.superelevation_rad = {0.05 + 0.0004 * segment.s_start_m, 0.0004, 0, 0};
    segment.crossfall_left = {0.02, 0.0005};
    segment.crossfall_right = {0.015, 0};
    segment.left_m = {5 + 0.005 * segment.s_start_m, 0.005, 0, 0};
    set_bound(segment);
  }
  network.roads.push_back(road_along(
      "bridge", 160, 8, 4,
      [](double s) {
        return straight({40, -30}, 1.7, s);
      },
      [](double) { return 9.0; }));
  network.roads.push_back(road_along(
      "ramp", 400, 5, 4,
      [](double s) {
        return Station{{200 + 30 * std::sin(s / 30), 30 - 30 * std::cos(s / 30)}, s / 30};
      },
      [](double s) { return 0.05 * s; }));
  return network;
}

// A road in which segments of a micrometre and less stand between long ones, and a road beside it.
Network with_tiny_segments() {
  Network network;
  Road road;
  road.id = "tiny";
  glm::dvec2 at(100, 50);
  double heading = 0.3;
  int i = 0;
  for (const double length : {40.0, 1e-6, 30.0, 3e-7, 2e-6, 50.0, 1e-5, 1e-3, 20.0}) {
    const double turn = 0.012 * length * (i++ % 3 == 1 ? -1 : 1);
    const double middle = heading + 0.5 * turn;
    const glm::dvec2 next = at + length * glm::dvec2(std::cos(middle), std::sin(middle));
    road.segments.push_back(make_segment(at, next, heading, heading + turn, 7));
    at = next;
    heading += turn;
  }
  chain_arc_lengths(road);
  two_lane_sections(road);
  network.roads.push_back(std::move(road));
  network.roads.push_back(road_along(
      "beside", 120, 20, 4,
      [](double s) {
        return straight({100, 90}, 0.3, s);
      },
      [](double) { return 0.0; }));
  return network;
}

// From a file with geometries and lane sections of a micrometre and less, as some editors write them.
Network with_tiny_records() {
  std::string geometry, sections;
  double s = 0, x = -30, y = 20, heading = 0.2;
  const auto text = [](double value) {
    char digits[32];
    std::snprintf(digits, sizeof digits, "%.17g", value);
    return std::string(digits);
  };
  int i = 0;
  for (const double length : {30.0, 1e-6, 45.0, 4e-7, 2.5e-6, 60.0, 1e-5, 15.0}) {
    const double curvature = length > 1 ? 0.01 : 0.1, turn = curvature * length;
    geometry += "<geometry s='" + text(s) + "' x='" + text(x) + "' y='" + text(y) + "' hdg='" + text(heading) +
                "' length='" + text(length) + "'><arc curvature='" + text(curvature) + "'/></geometry>";
    // Six metres to each side in one to three lanes.
    const int lanes = 1 + i++ % 3;
    const std::string width = "<width sOffset='0' a='" + text(6.0 / lanes) + "' b='0' c='0' d='0'/></lane>";
    std::string left, right;
    for (int k = 1; k <= lanes; ++k) {
      left = "<lane id='" + std::to_string(k) + "' type='driving'>" + width + left;
      right += "<lane id='-" + std::to_string(k) + "' type='driving'>" + width;
    }
    sections += "<laneSection s='" + text(s) + "'><left>" + left +
                "</left><center><lane id='0' type='none'/></center><right>" + right + "</right></laneSection>";
    s += length;
    const double middle = heading + 0.5 * turn, chord = std::sin(0.5 * turn) * 2 / curvature;
    x += chord * std::cos(middle);
    y += chord * std::sin(middle);
    heading += turn;
  }
  const TemporaryFolder folder;
  auto read = read_opendrive(folder.put(
      "tiny.xodr", "<OpenDRIVE><header revMajor='1' revMinor='7'/><road name='' id='tiny' junction='-1' length='" +
                       text(s) + "'><planView>" + geometry + "</planView><lanes>" + sections +
                       "</lanes></road></OpenDRIVE>"));
  EXPECT_TRUE(read.ok()) << read.error().text();
  return std::move(*read);
}

Network shared_map(const std::string& name) {
  const std::filesystem::path file =
      std::filesystem::path(ROADGEN_SOURCE_DIR) / "../shared/data/opendrive" / (name + ".xodr");
  if (!std::filesystem::exists(file)) return {};
  auto read = read_opendrive(file);
  EXPECT_TRUE(read.ok()) << read.error().text();
  return read.ok() ? std::move(*read) : Network{};
}

Network shared_extract(const std::string& name) {
  const std::string path = std::string(ROADGEN_SOURCE_DIR) + "/../shared/data/road-geo/osm-graphhopper/" + name;
  if (!std::filesystem::exists(path)) return {};
  auto imported = import_files({path}, {});
  EXPECT_TRUE(imported.ok()) << (imported.ok() ? "" : imported.error().text());
  return imported.ok() ? std::move(imported->network) : Network{};
}

struct Case {
  const char* name;
  Network (*make)();
  int points;
};
void PrintTo(const Case& c, std::ostream* stream) { *stream << c.name; }

const Case kCases[] = {{"ring", ring, 20000},
                       {"banked", banked_bend_under_a_bridge, 20000},
                       {"tiny", with_tiny_segments, 20000},
                       {"tiny_records", with_tiny_records, 20000},
                       {"hairpins", [] { return hairpin_network(0.08); }, 20000},
                       {"city", [] { return test::city({.blocks = 6, .hill_m = 9}); }, 20000},
                       // An index too large for a processor's cache: batches go another way.
                       {"big_city", [] { return test::city({.blocks = 100, .hill_m = 9}); }, 2000},
                       {"town01", [] { return shared_map("carla/Town01"); }, 100000},
                       {"town03", [] { return shared_map("carla/Town03"); }, 100000},
                       {"roundabout", [] { return shared_map("maliput/Roundabout"); }, 100000},
                       {"crossing8", [] { return shared_map("maliput/Crossing8Course"); }, 100000},
                       {"superelevated", [] { return shared_map("maliput/SShapeSuperelevatedRoad"); }, 100000},
                       {"spiral", [] { return shared_map("maliput/SpiralRoad"); }, 100000},
                       {"elevated", [] { return shared_map("maliput/ArcElevatedRoad"); }, 100000},
                       {"parametric", [] { return shared_map("maliput/ParametricCubicCurveRoad"); }, 100000},
                       {"monaco", [] { return shared_extract("monaco.osm.gz"); }, 100000}};

class RoundTrip : public ::testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    network_ = GetParam().make();
    if (network_.roads.empty()) GTEST_SKIP() << "no map " << GetParam().name << ": the public maps are not here";
    index_.emplace(network_);
  }
  Network network_;
  std::optional<RoadIndex> index_;
};

INSTANTIATE_TEST_SUITE_P(Networks, RoundTrip, ::testing::ValuesIn(kCases),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

// Every point of every road: with and without its height, from the place to the world and back.
TEST_P(RoundTrip, EveryPointIsGivenToARoadThatHoldsIt) {
  std::mt19937_64 random(1);
  std::size_t single = 0, ties = 0, in_areas = 0;
  double worst_s = 0, worst_t = 0, worst_back = 0;
  for (int i = 0; i < GetParam().points; ++i) {
    const RoadPlace place = random_place(network_, random);
    const glm::dvec3 p = index_->to_world(place).position_m;
    const glm::dvec2 flat(p);
    const std::vector<Held> held = places_of(network_, flat);
    ASSERT_FALSE(held.empty());
    for (const bool heights : {false, true}) {
      const auto found = heights ? index_->to_road(p, 0) : index_->to_road(flat, 0);
      SCOPED_TRACE(::testing::Message() << "road " << network_.roads[place.road].id << ", s = " << place.s_m
                                        << ", t = " << place.t_m << (heights ? ", with height" : ""));
      ASSERT_TRUE(found && found->has_road());
      EXPECT_EQ(found->outside_m, 0);
      const Road& road = network_.roads[found->at.road];
      in_areas += found->junction >= 0;
      // The place is the point.
      const glm::dvec2 back(index_->to_world({found->at.road, found->s_m, found->t_m}).position_m);
      worst_back = std::max(worst_back, glm::distance(back, flat));
      // It is one of those that the reference finds, and without heights the one that is told.
      double least_n = 1e300, least_in_area = 1e300;
      bool known = false;
      for (const Held& h : held) {
        const double gap = std::abs(h.s_m - found->s_m);
        known = known || (h.road == found->at.road && std::abs(h.t_m - found->t_m) < kRoundTrip_m &&
                          std::min(gap, road.closed ? road.length_m() - gap : gap) < kRoundTrip_m);
        const bool area = network_.roads[h.road].junction.size() > 0;
        if (!h.on_the_rim) (area ? least_in_area : least_n) = std::min(area ? least_in_area : least_n, h.n_m);
      }
      EXPECT_TRUE(known) << "found road " << road.id << ", s = " << found->s_m << ", t = " << found->t_m;
      if (!heights) {
        EXPECT_LT(found->distance_m, std::max(least_n, least_in_area) + kTie_m);
      }
      if (held.size() > 1) {
        ties += heights;
        continue;
      }
      single += heights;
      EXPECT_EQ(found->at.road, place.road);
      const double gap = std::abs(found->s_m - place.s_m);
      worst_s = std::max(worst_s, std::min(gap, road.closed ? road.length_m() - gap : gap));
      worst_t = std::max(worst_t, std::abs(found->t_m - place.t_m));
      EXPECT_NEAR(found->height_m, 0, kRoundTrip_m);
    }
  }
  std::printf("%s: %zu points on one place, %zu on several, %zu answers in areas; back within %.1e m, s %.1e, t %.1e\n",
              GetParam().name, single, ties, in_areas, worst_back, worst_s, worst_t);
  EXPECT_LT(worst_s, kRoundTrip_m);
  EXPECT_LT(worst_t, kRoundTrip_m);
  EXPECT_LT(worst_back, kRoundTrip_m);
  EXPECT_GT(single, 0.2 * GetParam().points);
}

bool same(const std::optional<RoadPoint>& a, const std::optional<RoadPoint>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (a->at == b->at && a->u == b->u && a->s_m == b->s_m && a->t_m == b->t_m && a->lane == b->lane &&
                a->distance_m == b->distance_m && a->outside_m == b->outside_m && a->height_m == b->height_m &&
                a->junction == b->junction);
}

// Points along drives, beside roads, above them, and anywhere: with a hint and in a batch the answer is the cold one to
// the bit.
TEST_P(RoundTrip, HintsAndBatchesChangeNothing) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> part(0, 1), around(-6, 6);
  std::vector<glm::dvec3> points;
  for (int drive = 0; drive < 60; ++drive) {
    RoadPlace place = random_place(network_, random);
    const double aside = drive % 3 == 0 ? around(random) : 0, above = drive % 4 == 0 ? around(random) : 0;
    for (int step = 0; step < 60; ++step, place.s_m += part(random)) {
      place.t_m = std::clamp(place.t_m + 0.1 * around(random), -12.0, 12.0);
      const glm::dvec3 p = index_->to_world(place).position_m;
      points.push_back(p + glm::dvec3(aside, -aside, above));
    }
  }
  const Bounds box = bounds(network_);
  for (int i = 0; i < 400; ++i) {
    points.push_back(box.low_m + glm::dvec3(part(random), part(random), part(random)) * (box.high_m - box.low_m));
  }
  for (const double reach : {0.0, 4.0, 100.0}) {
    std::vector<std::optional<RoadPoint>> cold, flat;
    for (const glm::dvec3 p : points) cold.push_back(index_->to_road(p, reach));
    for (const glm::dvec3 p : points) flat.push_back(index_->to_road(glm::dvec2(p), reach));
    RoadHint hint, flat_hint;
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_TRUE(same(index_->to_road(points[i], reach, &hint), cold[i])) << i;
      EXPECT_TRUE(same(index_->to_road(glm::dvec2(points[i]), reach, &flat_hint), flat[i])) << i;
      // Any hint at all.
      RoadHint other{{static_cast<std::uint32_t>(random() % network_.roads.size()), static_cast<std::uint32_t>(i % 7)}};
      EXPECT_TRUE(same(index_->to_road(points[i], reach, &other), cold[i])) << i;
    }
    std::vector<std::optional<RoadPoint>> batch(points.size());
    index_->to_road(points, reach, batch);
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_TRUE(same(batch[i], cold[i])) << i;
      // The nearest candidate is the answer, where that is a road.
      RoadPoint best;
      const std::size_t count = index_->candidates(points[i], reach, std::span(&best, 1));
      if (cold[i] && cold[i]->outside_m == 0 && cold[i]->distance_m > 0 && count > 0 && cold[i]->junction < 0) {
        EXPECT_EQ(best.at.road, cold[i]->at.road) << i;
        EXPECT_NEAR(best.s_m, cold[i]->s_m, kRoundTrip_m) << i;
      }
    }
  }
}

// What several threads ask of one index at once, each in its own order, is what one alone is told.
TEST_P(RoundTrip, ThreadsGetTheSameAnswers) {
  constexpr std::size_t kThreads = 4, kPlaces = 3000;
  struct Answers {
    std::vector<RoadPose> poses;
    std::vector<std::optional<RoadPoint>> cold, hinted, batch;
    std::vector<std::size_t> candidates;
  };
  std::mt19937_64 random(6);
  std::vector<RoadPlace> places(kPlaces);
  for (RoadPlace& place : places) place = random_place(network_, random);
  const auto ask = [&](std::size_t first) {
    Answers a{std::vector<RoadPose>(kPlaces), {}, {}, {}, std::vector<std::size_t>(kPlaces)};
    a.cold.resize(kPlaces), a.hinted.resize(kPlaces), a.batch.resize(kPlaces);
    std::vector<glm::dvec3> points(kPlaces);
    RoadHint hint;
    std::array<RoadPoint, 8> room;
    for (std::size_t k = 0; k < kPlaces; ++k) {
      const std::size_t i = (first + k) % kPlaces;
      a.poses[i] = index_->to_world(places[i]);
      points[i] = a.poses[i].position_m + glm::dvec3(0.4, 0, 0.1);
      a.cold[i] = index_->to_road(points[i], 5);
      a.hinted[i] = index_->to_road(points[i], 5, &hint);
      a.candidates[i] = index_->candidates(points[i], 5, room);
    }
    index_->to_road(points, 5, a.batch);
    return a;
  };
  const Answers alone = ask(0);
  std::array<Answers, kThreads> answers;
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < kThreads; ++k) threads.emplace_back([&, k] { answers[k] = ask(k * kPlaces / kThreads); });
  for (std::thread& thread : threads) thread.join();
  for (const Answers& a : answers) {
    for (std::size_t i = 0; i < kPlaces; ++i) {
      EXPECT_EQ(a.poses[i].position_m, alone.poses[i].position_m);
      EXPECT_EQ(a.poses[i].normal, alone.poses[i].normal);
      EXPECT_TRUE(same(a.cold[i], alone.cold[i]) && same(a.hinted[i], alone.cold[i]) &&
                  same(a.batch[i], alone.cold[i]));
      EXPECT_EQ(a.candidates[i], alone.candidates[i]);
    }
  }
}

// Every place is among the candidates at its point, whatever else lies there; and the candidates are the reference's.
TEST_P(RoundTrip, EveryPlaceIsACandidateAtItsPoint) {
  std::mt19937_64 random(7);
  std::array<RoadPoint, 64> room;
  double worst = 0;
  for (int i = 0; i < GetParam().points; ++i) {
    const RoadPlace place = random_place(network_, random);
    const Road& road = network_.roads[place.road];
    const glm::dvec2 p(index_->to_world(place).position_m);
    const std::size_t count = index_->candidates(p, 0, room);
    ASSERT_LE(count, room.size());
    double least = 1e300;
    for (const RoadPoint& found : std::span(room).first(count)) {
      if (found.at.road != place.road) continue;
      const double gap = std::abs(found.s_m - place.s_m);
      least = std::min(
          least, std::max(std::min(gap, road.closed ? road.length_m() - gap : gap), std::abs(found.t_m - place.t_m)));
    }
    EXPECT_LT(least, kRoundTrip_m) << "road " << road.id << ", s = " << place.s_m << ", t = " << place.t_m;
    worst = std::max(worst, least);
    if (i % 50 != 0) continue;
    std::size_t inside = 0;
    const std::vector<Held> held = places_of(network_, p);
    for (const Held& h : held) inside += !h.on_the_rim;
    EXPECT_GE(count, inside);
    EXPECT_LE(count, held.size());
  }
  std::printf("%s: every place within %.1e m\n", GetParam().name, worst);
}

// Where no area lies, poses are those of pose_at.
TEST_P(RoundTrip, PosesAreTheRoadsOwn) {
  std::mt19937_64 random(8);
  for (int i = 0; i < 5000; ++i) {
    const RoadPlace place = random_place(network_, random);
    const Road& road = network_.roads[place.road];
    if (!road.junction.empty()) continue;
    const RoadPose a = index_->to_world(place), b = pose_at(road, place.s_m, place.t_m);
    EXPECT_LT(glm::distance(a.position_m, b.position_m), 1e-11);
    EXPECT_LT(glm::distance(a.normal, b.normal), 1e-12);
    EXPECT_NEAR(std::remainder(a.heading_rad - b.heading_rad, 2 * std::numbers::pi), 0, 1e-12);
    EXPECT_NEAR(a.pitch_rad, b.pitch_rad, 1e-12);
    EXPECT_NEAR(a.roll_rad, b.roll_rad, 1e-12);
    EXPECT_NEAR(a.curvature_per_m, b.curvature_per_m, 1e-12);
    EXPECT_NEAR(a.grade, b.grade, 1e-12);
  }
}

TEST_P(RoundTrip, NoQueryAllocates) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "allocations are not counted under AddressSanitizer";
#endif
  std::mt19937_64 random(3);
  std::vector<RoadPlace> places(2000);
  std::vector<RoadPose> poses(places.size());
  std::vector<glm::dvec3> points(places.size());
  std::vector<std::optional<RoadPoint>> found(places.size());
  std::array<RoadPoint, 4> candidates;
  for (RoadPlace& place : places) place = random_place(network_, random);
  const std::size_t before = test::allocation_count();
  index_->to_world(places, poses);
  for (std::size_t i = 0; i < places.size(); ++i) points[i] = poses[i].position_m + glm::dvec3(0.1 * (i % 50), 0, 0.2);
  index_->to_road(points, 10, found);
  RoadHint hint;
  for (const glm::dvec3 p : points) {
    (void)index_->to_road(p, 30, &hint);
    (void)index_->to_road(glm::dvec2(p), 30);
    (void)index_->candidates(p, 30, candidates);
  }
  EXPECT_EQ(test::allocation_count(), before);
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_EQ(poses[i].position_m, index_->to_world(places[i]).position_m);
}

// Heading, pitch, roll, grade, curvature and normal against differences of positions.
TEST_P(RoundTrip, PosesAreTheSurfacesSlopes) {
  std::mt19937_64 random(4);
  std::size_t compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const RoadPlace place = random_place(network_, random);
    const RoadPose pose = index_->to_world(place);
    EXPECT_NEAR(glm::length(pose.normal), 1, 1e-12);
    EXPECT_NEAR(std::atan(pose.grade), pose.pitch_rad, 1e-15);
    // Within one segment, one lane and one side of the reference line; not where the inside of a bend has no room.
    const Road& road = network_.roads[place.road];
    const Segment& segment = road.segments[segment_at(road, place.s_m)];
    const double local = place.s_m - segment.s_start_m;
    constexpr double kStep_m = 1e-4;
    if (local < kStep_m || local > segment.arc_m - kStep_m || std::abs(place.t_m) < kStep_m) continue;
    if (1 - place.t_m * pose.curvature_per_m < 0.2) continue;
    const auto at = [&](double ds, double dt) {
      return index_->to_world({place.road, place.s_m + ds, place.t_m + dt});
    };
    const auto lane = [&](double ds, double dt) {
      const LaneSection& section = section_of(road, segment);
      return lane_at(section, place.s_m + ds - section.s_m, place.t_m + dt);
    };
    if (lane(kStep_m, 0) != lane(0, 0) || lane(-kStep_m, 0) != lane(0, 0)) continue;
    if (lane(0, kStep_m) != lane(0, 0) || lane(0, -kStep_m) != lane(0, 0)) continue;
    const bool area = !road.junction.empty();
    const glm::dvec3 along = at(kStep_m, 0).position_m - at(-kStep_m, 0).position_m;
    const glm::dvec3 across = at(0, kStep_m).position_m - at(0, -kStep_m).position_m;
    // An area's rim may lie between.
    if (area && (std::abs(along.z) > 1e-4 || std::abs(across.z) > 1e-4)) continue;
    const glm::dvec3 normal = glm::normalize(glm::cross(along, across));
    EXPECT_LT(glm::length(normal - pose.normal), 1e-4)
        << "road " << road.id << ", s = " << place.s_m << ", t = " << place.t_m;
    const glm::dvec2 reference(at(kStep_m, -place.t_m).position_m - at(-kStep_m, -place.t_m).position_m);
    EXPECT_NEAR(std::remainder(std::atan2(reference.y, reference.x) - pose.heading_rad, 2 * std::numbers::pi), 0, 1e-6);
    const double turn = std::remainder(at(kStep_m, 0).heading_rad - at(-kStep_m, 0).heading_rad, 2 * std::numbers::pi);
    EXPECT_NEAR(turn / (2 * kStep_m), pose.curvature_per_m, 1e-3);
    // Pitch along the heading, roll along its left.
    const glm::dvec2 ahead(std::cos(pose.heading_rad), std::sin(pose.heading_rad));
    EXPECT_NEAR(std::tan(pose.pitch_rad), -glm::dot(glm::dvec2(pose.normal), ahead) / pose.normal.z, 1e-9);
    EXPECT_NEAR(std::tan(pose.roll_rad),
                -glm::dot(glm::dvec2(pose.normal), glm::dvec2(-ahead.y, ahead.x)) / pose.normal.z, 1e-9);
    ++compared;
  }
  EXPECT_GT(compared, 1500u);
}

// ---- Single cases ----

void expect_no_capture(const Network& network) {
  const RoadIndex index(network);
  std::mt19937_64 random(5);
  const Bounds box = bounds(network);
  std::uniform_real_distribution<double> x(box.low_m.x - 40, box.high_m.x + 40);
  std::uniform_real_distribution<double> y(box.low_m.y - 40, box.high_m.y + 40);
  int compared = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::dvec2 p(x(random), y(random));
    const auto found = index.to_road(p, 1000);
    ASSERT_TRUE(found);
    // The nearest edge; of open ends the distance to their corners is another.
    double least = 1e300;
    bool at_end = found->s_m == 0 || found->s_m == network.roads[found->at.road].length_m();
    for (const Road& road : network.roads) {
      for (const Segment& segment : road.segments) {
        const Nearest foot = nearest(segment, p);
        const double edge = foot.distance_m - segment.max_half_width_m();
        if (edge > least) continue;
        least = edge;
        at_end =
            (foot.u == 0 && &segment == &road.segments.front()) || (foot.u == 1 && &segment == &road.segments.back());
      }
    }
    if (at_end) continue;
    EXPECT_NEAR(found->outside_m, std::max(least, 0.0), 1e-6) << p.x << ", " << p.y;
    ++compared;
    // What a tiny segment holds lies between its joint lines.
    if (found->outside_m == 0 && index.segment(found->at).arc_m < 1e-4) {
      EXPECT_LT(glm::distance(glm::dvec2(index.pose(*found, p).position_m), p), 1e-6);
    }
  }
  EXPECT_GT(compared, 10000);
}

TEST(Query, TinySegmentsDoNotCaptureFarPoints) {
  expect_no_capture(with_tiny_segments());
  expect_no_capture(with_tiny_records());
}

TEST(Query, PlacesBeyondARoadAreItsEndsAndClosedRoadsWrap) {
  const Network open = with_tiny_segments(), closed = ring();
  const RoadIndex index(open), around(closed);
  const double length = open.roads[0].length_m(), lap = closed.roads[0].length_m();
  EXPECT_EQ(index.to_world({0, -5, 1}).position_m, index.to_world({0, 0, 1}).position_m);
  EXPECT_EQ(index.to_world({0, length + 5, 1}).position_m, index.to_world({0, length, 1}).position_m);
  for (const double s : {0.0, 1.0, 0.3 * lap, lap - 1e-9}) {
    for (const double laps : {-2.0, 1.0, 3.0}) {
      EXPECT_LT(
          glm::distance(around.to_world({0, s + laps * lap, 2}).position_m, around.to_world({0, s, 2}).position_m),
          1e-9);
    }
  }
  // Beside the lanes the surface goes on.
  const RoadPose far = index.to_world({1, 50, 500});
  EXPECT_NEAR(glm::distance(glm::dvec2(far.position_m), glm::dvec2(index.to_world({1, 50, 0}).position_m)), 500, 1e-9);
}

}  // namespace
}  // namespace roadgen
