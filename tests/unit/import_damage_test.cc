// Files damaged at random: every reader gives a value or an error, and a network that is read can be checked
// and written. Assertions are on in the dev preset; run it under the asan preset too.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "roadgen/export/opendrive.h"
#include "roadgen/import/csv.h"
#include "roadgen/import/gpx.h"
#include "roadgen/import/opendrive.h"

namespace roadgen {
namespace {

constexpr int kRounds = 3000;

// A few bytes changed, copied, or cut out; numbers are likelier to become odd numbers than letters.
std::string damaged(std::string text, std::mt19937& random) {
  static const char* const kOdd[] = {"0", "-",  "1e308", "nan", "inf", "1e-300", "<",
                                     ">", "\"", "/",     ",",   "\n",  "\xFF",   "9"};
  const auto at = [&] { return random() % text.size(); };
  for (unsigned i = 0; i < 1 + random() % 4 && !text.empty(); ++i) {
    switch (random() % 4) {
      case 0: text[at()] = static_cast<char>(random()); break;
      case 1: text.insert(at(), kOdd[random() % std::size(kOdd)]); break;
      case 2: text.erase(at(), random() % 12); break;
      default: text.replace(at(), 1, kOdd[random() % std::size(kOdd)]); break;
    }
  }
  return text;
}

TEST(Damage, OpenDriveGivesANetworkOrAnError) {
  Network network;
  network.georeference = Georeference{50, 11, 0};
  Road road;
  road.id = "1";
  road.segments = {make_segment({0, 0}, {100, 0}, 0.1, -0.1, 3.5), make_segment({100, 0}, {180, -20}, -0.1, -0.3, 3.5)};
  chain_arc_lengths(road);
  two_lane_sections(road);
  Road loop;
  loop.id = "2";
  loop.closed = true;
  for (int i = 0; i < 4; ++i) {
    const auto corner = [](int k) { return glm::dvec2(100 * std::cos(M_PI_2 * k), 100 * std::sin(M_PI_2 * k)); };
    loop.segments.push_back(make_segment(corner(i), corner(i + 1), M_PI_2 * (i + 1), M_PI_2 * (i + 2), 3.5));
  }
  loop.segments.back().end_m = loop.segments.front().start_m;
  chain_arc_lengths(loop);
  two_lane_sections(loop);
  network.roads = {road, loop};
  const std::string text = *opendrive_text(network);

  std::mt19937 random(1);
  int good = 0;
  for (int i = 0; i < kRounds; ++i) {
    Diagnostics diagnostics;
    const Result<Network> read = parse_opendrive(damaged(text, random), "f", &diagnostics);
    if (!read) {
      EXPECT_EQ(read.error().file, "f");
      continue;
    }
    ++good;
    (void)check(*read);
    (void)bounds(*read);
    (void)opendrive_text(*read);
  }
  EXPECT_GT(good, kRounds / 20);
  EXPECT_LT(good, kRounds);
}

TEST(Damage, TablesAndTracksGiveFinitePointsOrAnError) {
  const std::string csv = "lat,lon,height,width\n50,11,300,7\n50.001,11.002,301,7\n50.002,11.003,302.5,8\n";
  const std::string gpx =
      "<gpx><trk><name>a</name><trkseg><trkpt lat=\"50\" lon=\"11\"><ele>3</ele></trkpt><trkpt lat=\"51\" "
      "lon=\"12\"/></trkseg></trk><rte><rtept lat=\"1\" lon=\"2\"/></rte></gpx>";
  std::mt19937 random(2);
  for (int i = 0; i < kRounds; ++i) {
    Diagnostics diagnostics;
    for (const auto& tracks :
         {parse_csv(damaged(csv, random), "f", diagnostics), parse_gpx(damaged(gpx, random), "f", diagnostics)}) {
      if (!tracks) {
        EXPECT_EQ(tracks.error().file, "f");
        continue;
      }
      for (const Track& track : *tracks) {
        EXPECT_FALSE(track.points.empty());
        for (const TrackPoint& p : track.points) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(p.y));
      }
    }
  }
}

}  // namespace
}  // namespace roadgen
