// roadgen query: answers on a network whose answers are known, both ways; rows in every shape; bad rows and wrong usage.
#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/cli/run_program.h"

namespace {

using roadgen::test::Outcome;
using roadgen::test::TemporaryFolder;

constexpr const char* kToRoad = "road,s,t,lane,x,y,z,heading,pitch,roll,curvature,distance\n";
constexpr const char* kToWorld = "x,y,z,heading,pitch,roll\n";

std::string straight_road(const std::string& id, double x, double y, double heading, double z, double grade) {
  const auto text = [](double value) { return std::to_string(value); };
  return "<road name='' length='100' id='" + id + "' junction='-1'><planView><geometry s='0' x='" + text(x) + "' y='" +
         text(y) + "' hdg='" + text(heading) + "' length='100'><line/></geometry></planView><elevationProfile>" +
         "<elevation s='0' a='" + text(z) + "' b='" + text(grade) + "' c='0' d='0'/></elevationProfile>" +
         "<lanes><laneSection s='0'><left><lane id='1' type='driving'><width sOffset='0' a='3.5' b='0' c='0' d='0'/>" +
         "</lane></left><center><lane id='0' type='none'/></center><right><lane id='-1' type='driving'>" +
         "<width sOffset='0' a='3.5' b='0' c='0' d='0'/></lane></right></laneSection></lanes></road>";
}

// Eastward along y = 0 from (-50, 0), climbing by 1 in 10; and over its middle a bridge eastward along y = 2 at z = 20.
std::string network(const TemporaryFolder& folder) {
  return folder.put("net.xodr", "<OpenDRIVE><header revMajor='1' revMinor='7'/>" +
                                    straight_road("low, &quot;A&quot;", -50, 0, 0, 0, 0.1) +
                                    straight_road("bridge", -50, 2, 0, 20, 0) + "</OpenDRIVE>");
}

std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    rows.emplace_back(1);
    bool quoted = false;
    for (const char c : text.substr(at, end - at)) {
      if (c == '"') quoted = !quoted;
      if (c == ',' && !quoted) {
        rows.back().emplace_back();
      } else {
        rows.back().back() += c;
      }
    }
    at = end + 1;
  }
  return rows;
}

double number(const std::string& cell) {
  double value = std::nan("");
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  EXPECT_TRUE(error == std::errc{} && end == cell.data() + cell.size()) << cell;
  return value;
}

TEST(QueryCommand, PlacesAndPosesAreTheKnownOnes) {
  const TemporaryFolder folder;
  const std::string net = network(folder);
  // On the low road, on the bridge, without a height nearest to the bridge's line, and beside both.
  const Outcome run = roadgen::test::roadgen({"query", net, "--to-road"}, "-20,1,3.1\n-20,1,20\n-20,1.5\n10,-5,0\n");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_TRUE(run.out.starts_with(kToRoad));
  const auto rows = rows_of(run.out);
  ASSERT_EQ(rows.size(), 5u);
  const double pitch = std::atan(0.1);
  const struct {
    std::string road;
    std::array<double, 11> numbers;
  } expected[] = {{"\"low, \"\"A\"\"\"", {30, 1, 1, -20, 1, 3, 0, pitch, 0, 0, 0}},
                  {"bridge", {30, -1, -1, -20, 1, 20, 0, 0, 0, 0, 0}},
                  {"bridge", {30, -0.5, -1, -20, 1.5, 20, 0, 0, 0, 0, 0}},
                  {"\"low, \"\"A\"\"\"", {60, -5, 0, 10, -5, 6, 0, pitch, 0, 0, 1.5}}};
  for (std::size_t i = 0; i < 4; ++i) {
    SCOPED_TRACE(i);
    ASSERT_EQ(rows[i + 1].size(), 12u);
    EXPECT_EQ(rows[i + 1][0], expected[i].road);
    for (std::size_t k = 0; k < 11; ++k) EXPECT_NEAR(number(rows[i + 1][k + 1]), expected[i].numbers[k], 1e-9) << k;
  }

  const Outcome back = roadgen::test::roadgen({"query", net, "--to-world"}, "\"low, \"\"A\"\"\",30,1\nbridge,100,-3\n");
  ASSERT_EQ(back.code, 0) << back.err;
  EXPECT_TRUE(back.out.starts_with(kToWorld));
  const auto poses = rows_of(back.out);
  ASSERT_EQ(poses.size(), 3u);
  const std::array<double, 6> pose[] = {{-20, 1, 3, 0, pitch, 0}, {50, -1, 20, 0, 0, 0}};
  for (std::size_t i = 0; i < 2; ++i) {
    ASSERT_EQ(poses[i + 1].size(), 6u);
    for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(number(poses[i + 1][k]), pose[i][k], 1e-9) << k;
  }
}

// What --to-road writes --to-world reads, header and all, and gives back the points.
TEST(QueryCommand, ThereAndBackIsThePoint) {
  const TemporaryFolder folder;
  const std::string net = folder.path("ring.xodr");
  std::string track = "x,y\n";
  for (int i = 0; i < 60; ++i) {
    const double angle = i * std::numbers::pi / 30;
    track += std::to_string(90 * std::cos(angle)) + "," + std::to_string(60 * std::sin(angle)) + "\n";
  }
  ASSERT_EQ(roadgen::test::roadgen({"import", folder.put("r.csv", track), "-o", net, "--closed", "yes"}).code, 0);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-100, 100);
  std::string points = "x,y\n";
  for (int i = 0; i < 500; ++i) points += std::to_string(any(random)) + "," + std::to_string(any(random)) + "\n";
  const Outcome there = roadgen::test::roadgen({"query", net, "--to-road"}, points);
  ASSERT_EQ(there.code, 0) << there.err;
  const Outcome back = roadgen::test::roadgen({"query", net, "--to-world"}, there.out);
  ASSERT_EQ(back.code, 0) << back.err;
  const auto asked = rows_of(points), found = rows_of(there.out), given = rows_of(back.out);
  ASSERT_EQ(found.size(), asked.size());
  ASSERT_EQ(given.size(), asked.size());
  for (std::size_t i = 1; i < asked.size(); ++i) {
    for (std::size_t k = 0; k < 2; ++k) {
      EXPECT_NEAR(number(given[i][k]), number(asked[i][k]), 1e-9);
      EXPECT_NEAR(number(found[i][k + 4]), number(asked[i][k]), 1e-9);
    }
    EXPECT_EQ(found[i][4], given[i][0]);
    EXPECT_EQ(found[i][7], given[i][3]);
  }
  // A closed road has an s everywhere.
  const Outcome lap = roadgen::test::roadgen({"query", net, "--to-world"}, found[1][0] + ",-1e3,0\n");
  EXPECT_EQ(lap.code, 0) << lap.err;
}

TEST(QueryCommand, RowsComeInManyShapes) {
  const TemporaryFolder folder;
  const std::string net = network(folder);
  const std::string plain = roadgen::test::roadgen({"query", net, "--to-road"}, "1,1\n2,1,5\n").out;
  for (const char* same : {"x,y,z\n1,1,\n2,1,5\n", "\xEF\xBB\xBFx,y,z\r\n1,1,\r\n\r\n2,1,5", "1,1\n2,1,5",
                           " 1 , 1\n\n\"2\",1.0,+5e0\n", "name,z,\"y\",x\nfirst,,1,1\n\"a, b\",5,1,2\n"}) {
    const Outcome run = roadgen::test::roadgen({"query", net, "--to-road"}, same);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_EQ(run.out, plain) << same;
  }
  const std::string there = roadgen::test::roadgen({"query", net, "--to-world"}, "bridge,3,1\n").out;
  EXPECT_EQ(roadgen::test::roadgen({"query", net, "--to-world"}, "t,s,road,more\n1,3,bridge,9\n").out, there);
  // No rows are no answers.
  for (const char* none : {"", "\n", "x,y\n"}) {
    EXPECT_EQ(roadgen::test::roadgen({"query", net, "--to-road"}, none).out, kToRoad);
  }
  EXPECT_EQ(roadgen::test::roadgen({"query", net, "--to-world"}, "road,s,t\n").out, kToWorld);
}

TEST(QueryCommand, ReachAndAllCandidates) {
  const TemporaryFolder folder;
  const std::string net = network(folder);
  const Outcome none = roadgen::test::roadgen({"query", net, "--to-road", "--reach", "2"}, "0,-9\n0,-5\n0,-5.6\n");
  ASSERT_EQ(none.code, 0) << none.err;
  const auto rows = rows_of(none.out);
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[1], std::vector<std::string>(12));
  EXPECT_NEAR(number(rows[2][11]), 1.5, 1e-9);
  EXPECT_EQ(rows[3], std::vector<std::string>(12));

  const Outcome all =
      roadgen::test::roadgen({"query", net, "--to-road", "--all", "--reach", "3"}, "0,1,19\n0,90\n0,-4,0\n");
  ASSERT_EQ(all.code, 0) << all.err;
  EXPECT_TRUE(all.out.starts_with(std::string("point,") + kToRoad));
  const auto found = rows_of(all.out);
  ASSERT_EQ(found.size(), 5u);
  const std::array<const char*, 2> expected[] = {{"1", "bridge"}, {"1", "low"}, {"3", "low"}, {"3", "bridge"}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(found[i + 1].size(), 13u);
    EXPECT_EQ(found[i + 1][0], expected[i][0]);
    EXPECT_NE(found[i + 1][1].find(expected[i][1]), std::string::npos);
  }
}

void expect_refused(const std::string& net, const std::vector<std::string>& options, const std::string& input, int code,
                    const std::string& says) {
  std::vector<std::string> arguments = {"query", net};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const Outcome run = roadgen::test::roadgen(arguments, input);
  SCOPED_TRACE(input + " -> " + run.err);
  EXPECT_EQ(run.code, code);
  EXPECT_EQ(run.out, "");
  ASSERT_EQ(run.error_lines().size(), 1u);
  EXPECT_TRUE(run.err.starts_with("roadgen query: error: "));
  EXPECT_NE(run.err.find(says), std::string::npos);
}

TEST(QueryCommand, BadRowsAreNamedByTheirLine) {
  const TemporaryFolder folder;
  const std::string net = network(folder);
  const struct {
    const char *way, *input, *says;
  } cases[] = {{"--to-road", "1,2\n1,x\n", ":2: y is 'x'"},
               {"--to-road", "lat,lon\n1,2\n", ":1: x is 'lat'"},
               {"--to-road", "x,y\n\n1,2\n3\n", ":4: the row has 1 cell where the header has 2"},
               {"--to-road", "1\n", ":1: the row has 1 cell where x,y make a row, or with z"},
               {"--to-road", "1,2,3,4\n", ":1: the row has 4 cells"},
               {"--to-road", "1,2\n1,\n", ":2: y is missing"},
               {"--to-road", "1,nan\n", ":1: y is 'nan'"},
               {"--to-road", "1,2,inf\n", ":1: z is 'inf'"},
               {"--to-road", "1,1e999\n", ":1: y is '1e999'"},
               {"--to-road", "1,2\n1,\xFF\n", ":2: is not UTF-8"},
               {"--to-world", "road,s,t\nbridge,1,0\nridge,1,0\n", ":3: there is no road 'ridge'"},
               {"--to-world", "bridge,1\n", ":1: the row has 2 cells where road,s,t make a row"},
               {"--to-world", ",1,0\n", ":1: there is no road ''"},
               {"--to-world", "bridge,,0\n", ":1: s is missing"},
               {"--to-world", "bridge,1,left\n", ":1: t is 'left'"},
               {"--to-world", "bridge,-0.1,0\n", ":1: s is -0.1, and road 'bridge' is 100 m long"},
               {"--to-world", "bridge,100.1,0\n", ":1: s is 100.1"}};
  for (const auto& c : cases) expect_refused(net, {c.way}, c.input, 1, std::string("standard input") + c.says);
}

TEST(QueryCommand, WrongUsageAndNetworksThatAreNone) {
  const TemporaryFolder folder;
  const std::string net = network(folder);
  const std::vector<std::string> lines[] = {{},
                                            {"--to-road", "--to-world"},
                                            {"--to-road", "--all"},
                                            {"--to-world", "--reach", "3"},
                                            {"--to-road", "--reach", "-1"},
                                            {"--to-road", "--reach", "nan"},
                                            {"--to-road", "--reach"},
                                            {"--to-road", "more"}};
  for (const auto& line : lines) expect_refused(net, line, "1,2\n", 2, "");
  expect_refused(folder.path("none.xodr"), {"--to-road"}, "1,2\n", 1, "none.xodr: no such file");
  expect_refused(folder.put("e.xodr", ""), {"--to-world"}, "1,2,3\n", 1, "e.xodr: is empty");
}

}  // namespace
