// roadgen terrain: the JSON's claims against the road and the GeoTIFF it wrote, and models that cannot serve.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <tuple>

#include <nlohmann/json.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/road/network.h"
#include "terrain/elevation.h"
#include "tests/cli/run_program.h"

namespace roadgen {
namespace {

using test::Outcome;
using test::TemporaryFolder;

const std::string kData = std::string(ROADGEN_SOURCE_DIR) + "/data/";

class TerrainCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    ASSERT_EQ(test::roadgen({"import", kData + "pass.csv", "-o", net()}).code, 0);
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string net() { return folder_->path("pass.xodr"); }

  // Refused with this exit code and one line that holds the words; nothing is written.
  static void expect_refused(const std::vector<std::string>& models, int code, const std::string& words) {
    const std::string output = folder_->path("refused.tif");
    std::vector<std::string> arguments = {"terrain"};
    arguments.insert(arguments.end(), models.begin(), models.end());
    arguments.insert(arguments.end(), {"-o", output});
    const Outcome run = test::roadgen(arguments);
    EXPECT_EQ(run.code, code) << run.err;
    EXPECT_EQ(run.out, "");
    ASSERT_FALSE(run.error_lines().empty());
    EXPECT_NE(run.error_lines().back().find(words), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(output));
  }
  // An ASCII grid of equal heights about a place in degrees.
  static std::string grid(const std::string& name, double longitude, double latitude, int size,
                          const std::string& value) {
    std::string text = "ncols " + std::to_string(size) + "\nnrows " + std::to_string(size) + "\nxllcorner " +
                       std::to_string(longitude) + "\nyllcorner " + std::to_string(latitude) +
                       "\ncellsize 0.001\nNODATA_value -9999\n";
    for (int i = 0; i < size * size; ++i) text += value + (i % size + 1 == size ? "\n" : " ");
    return folder_->put(name, text);
  }

  static inline TemporaryFolder* folder_ = nullptr;
};

TEST_F(TerrainCommand, ProvesTheClearanceAndWritesTheGround) {
  const std::string output = folder_->path("terrain.tif");
  const Outcome run = test::roadgen({"terrain", kData + "pass_dem.tif", net(), "-o", output, "--post", "4", "--margin",
                                     "600", "--gap", "0.03", "--depth", "0.2"});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_GE(json["clearance_min_m"].get<double>(), 0.03);
  EXPECT_LE(json["clearance_max_m"].get<double>(), 0.2);
  EXPECT_EQ(json["too_deep_part"], 0);
  EXPECT_GT(json["triangles_under_roads"].get<int>(), 1000);

  // The file lies where the road is: under its middle within what the posts' distance lets the ground bend.
  const auto ground = Elevation::open(output);
  ASSERT_TRUE(ground) << ground.error().text();
  const auto network = read_opendrive(net());
  ASSERT_TRUE(network);
  const LocalFrame frame(*network->georeference);
  const Road& road = network->roads[0];
  double least = 1e9, most = -1e9;
  for (double s = 0; s < road.length_m(); s += 20) {
    const glm::dvec3 p = pose_at(road, s, 0).position_m;
    const Geodetic at = frame.to_geodetic(p);
    const double over = at.height_m - ground->height_m({at.longitude_deg, at.latitude_deg}, Interpolation::kBilinear);
    least = std::min(least, over), most = std::max(most, over);
  }
  EXPECT_GT(least, -0.35);
  EXPECT_LT(most, 0.6);
}

// A straight level road through a hill, in OpenDRIVE: a tunnel of 100 m, the hill 30 m over it.
TEST_F(TerrainCommand, CountsTunnelsAndKeepsTheirHill) {
  const std::string road = folder_->put("tunnel.xodr", R"(<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="7"/>
<road id="1" length="400" junction="-1">
<planView><geometry s="0" x="0" y="0" hdg="0" length="400"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center>
<right><lane id="-1" type="driving"><width sOffset="0" a="3.5" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
<objects><tunnel id="t" name="t" type="standard" s="150" length="100" lighting="0" daylight="0"/></objects>
</road></OpenDRIVE>
)");
  std::string grid = "ncols 121\nnrows 81\nxllcenter -100\nyllcenter -200\ncellsize 5\n";
  for (int row = 0; row < 81; ++row) {
    for (int column = 0; column < 121; ++column) grid += std::abs(-100 + 5 * column - 200) < 50 ? "30 " : "0 ";
    grid += "\n";
  }
  const std::string dem = folder_->put("hill.asc", grid);
  const Outcome run = test::roadgen({"terrain", dem, road});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_EQ(json["tunnel_parts"], 1);
  EXPECT_GT(json["tunnel_m"].get<double>(), 80);
  EXPECT_LE(json["tunnel_m"].get<double>(), 100);
  EXPECT_GT(json["triangles_cut_for_tunnels"].get<int>(), 5);
  EXPECT_EQ(json["bridge_parts"], 0);
  // Of the road outside of it.
  EXPECT_LE(json["clearance_max_m"].get<double>(), 0.12);
  EXPECT_LT(json["deepest_cut_m"].get<double>(), 30);
  const Outcome open = test::roadgen({"terrain", dem, road, "--cover", "40"});
  ASSERT_EQ(open.code, 0) << open.err;
  EXPECT_EQ(nlohmann::json::parse(open.out)["tunnel_parts"], 0);
}

// A straight level road in OpenDRIVE, from a place in a direction.
std::string level_road(const std::string& id, double x, double y, double heading, double z) {
  const auto text = [](double number) { return std::to_string(number); };
  return "<road id=\"" + id + "\" length=\"120\" junction=\"-1\"><planView><geometry s=\"0\" x=\"" + text(x) +
         "\" y=\"" + text(y) + "\" hdg=\"" + text(heading) +
         "\" length=\"120\"><line/></geometry></planView><elevationProfile>" + "<elevation s=\"0\" a=\"" + text(z) +
         "\" b=\"0\" c=\"0\" d=\"0\"/></elevationProfile><lanes><laneSection s=\"0\">" +
         "<left><lane id=\"1\" type=\"driving\"><width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane></left>" +
         "<center><lane id=\"0\" type=\"none\"/></center><right><lane id=\"-1\" type=\"driving\">" +
         "<width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane></right></laneSection></lanes></road>\n";
}

// Two roads above one another and no bridge: the place and the roads are told, and no other ground lies deep.
TEST_F(TerrainCommand, NamesRoadsAboveOneAnother) {
  const std::string roads = folder_->put(
      "over.xodr", "<?xml version=\"1.0\"?>\n<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/>\n" +
                       level_road("low", 0, 0, 0, 5) + level_road("high", 60, -60, 1.570796, 11) + "</OpenDRIVE>\n");
  std::string grid = "ncols 61\nnrows 61\nxllcenter -200\nyllcenter -300\ncellsize 10\n";
  for (int i = 0; i < 61 * 61; ++i) grid += i % 61 == 60 ? "5\n" : "5 ";
  const Outcome run = test::roadgen({"terrain", folder_->put("flat.asc", grid), roads});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = nlohmann::json::parse(run.out);
  EXPECT_GE(json["clearance_min_m"].get<double>(), 0.02);
  ASSERT_EQ(json["overlap_places"], 1);
  const auto& place = json["overlaps"][0];
  EXPECT_NEAR(place["at"][0].get<double>(), 60, 6);
  EXPECT_NEAR(place["at"][1].get<double>(), 0, 6);
  EXPECT_NEAR(place["apart_m"].get<double>(), 6, 1);
  EXPECT_EQ(place["roads"].size(), 2u) << place;
  EXPECT_GT(json["over_other_roads_m2"].get<double>(), 20);
  EXPECT_EQ(json["triangles_too_deep"], json["triangles_too_deep_by_overlap"]);
  EXPECT_LT(json["too_deep_part"].get<double>(), 0.02);
}

// Heights above the geoid, roads above the ellipsoid: the ground is where the roads are, and the file says what it is above.
TEST_F(TerrainCommand, ConvertsHeightsToTheRoadsDatum) {
  std::string geoid = "ncols 21\nnrows 21\nxllcenter 7.5\nyllcenter 45.5\ncellsize 0.1\n";
  for (int i = 0; i < 21 * 21; ++i) geoid += i % 21 == 20 ? "49.5\n" : "49.5 ";
  const std::string path = folder_->put("geoid.asc", geoid), output = folder_->path("ellipsoid.tif");
  const auto ground = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"terrain", kData + "pass_dem.tif", net(), "--margin", "150", "-o", output};
    words.insert(words.end(), more.begin(), more.end());
    return test::roadgen(words);
  };
  const Outcome plain = ground({}),
                made = ground({"--dem-datum", "geoid", "--road-datum", "ellipsoid", "--geoid", path});
  ASSERT_EQ(made.code, 0) << made.err;
  EXPECT_NE(made.err.find("49.50 to 49.50 m more"), std::string::npos) << made.err;
  const auto before = nlohmann::json::parse(plain.out), after = nlohmann::json::parse(made.out);
  EXPECT_EQ(before["heights_above"], "as the roads");
  EXPECT_EQ(after["heights_above"], "ellipsoid");
  EXPECT_NEAR(after["deepest_cut_m"].get<double>() - before["deepest_cut_m"].get<double>(), 49.5, 0.01);
  EXPECT_EQ(Elevation::open(output)->datum(), VerticalDatum::kEllipsoid);
  // The same for a road that is laid on the ground.
  const std::string fitted = folder_->path("datum.xodr");
  const Outcome laid = test::roadgen({"import", kData + "pass.csv", "-o", fitted, "--heights", kData + "pass_dem.tif",
                                      "--dem-datum", "geoid", "--road-datum", "ellipsoid", "--geoid", path});
  ASSERT_EQ(laid.code, 0) << laid.err;
  const Outcome on = test::roadgen({"terrain", kData + "pass_dem.tif", fitted, "--margin", "150"});
  ASSERT_EQ(on.code, 0) << on.err;
  EXPECT_GT(nlohmann::json::parse(on.out)["highest_fill_m"].get<double>(), 45);

  const std::string dem = kData + "pass_dem.tif";
  expect_refused({dem, net(), "--dem-datum", "sea"}, 2, "expected file, geoid, ellipsoid or as-roads");
  expect_refused({dem, net(), "--road-datum", "sea"}, 2, "expected file, geoid or ellipsoid");
  const std::vector<std::string> up = {dem, net(), "--dem-datum", "geoid", "--road-datum", "ellipsoid", "--geoid"};
  for (const auto& [file, words] : {std::pair(folder_->path("none.gtx"), "no such elevation file"),
                                    {grid("far_geoid.asc", -70, 40, 40, "12"), "does not reach longitude"}}) {
    std::vector<std::string> all = up;
    all.push_back(file);
    expect_refused(all, 1, words);
  }
}

// The road's heights are fitted to the elevation: those of the source do not matter, and the limits hold.
TEST_F(TerrainCommand, ImportFitsHeightsToTheElevation) {
  const std::string fitted = folder_->path("fitted.xodr"), report = folder_->path("fitted.json");
  const Outcome run = test::roadgen({"import", kData + "pass.csv", "-o", fitted, "--heights", kData + "pass_dem.tif",
                                     "--max-grade", "0.11", "--max-vertical-curvature", "0.004", "--report", report});
  ASSERT_EQ(run.code, 0) << run.err;
  const auto heights = nlohmann::json::parse(test::text_of(report))["heights"];
  EXPECT_GT(heights["samples"].get<int>(), 1000);
  EXPECT_LE(heights["max_grade"].get<double>(), 0.11 * 1.001);
  EXPECT_LE(heights["max_curvature_per_m"].get<double>(), 0.004 * 1.001);
  EXPECT_EQ(heights["roads_over_grade"], 0);
  EXPECT_EQ(test::roadgen({"check", fitted}).code, 0);
  const auto network = read_opendrive(fitted);
  ASSERT_TRUE(network);
  for (const Segment& segment : network->roads[0].segments) {
    EXPECT_LE(std::abs(segment.elevation_m.slope(0)), 0.11 * 1.001);
  }
  const Outcome ground = test::roadgen({"terrain", kData + "pass_dem.tif", fitted, "--margin", "200"});
  ASSERT_EQ(ground.code, 0) << ground.err;
  EXPECT_GE(nlohmann::json::parse(ground.out)["clearance_min_m"].get<double>(), 0.02);

  const std::string none = folder_->path("none.xodr");
  for (const auto& [dem, code] : {std::pair(folder_->path("none.tif"), 1), {grid("far.asc", -70, 40, 40, "12"), 1}}) {
    const Outcome bad = test::roadgen({"import", kData + "pass.csv", "-o", none, "--heights", dem});
    EXPECT_EQ(bad.code, code) << bad.err;
    EXPECT_FALSE(std::filesystem::exists(none));
  }
  EXPECT_EQ(test::roadgen(
                {"import", kData + "pass.csv", "-o", none, "--heights=" + kData + "pass_dem.tif", "--max-grade", "-1"})
                .code,
            2);
}

// The ground is kept, read where it fits and built again where it is damaged: the same picture each time.
TEST_F(TerrainCommand, GroundIsKeptInAFile) {
  const std::string cache = folder_->path("pass.ground");
  const auto draw = [&](const std::string& name) {
    const Outcome run = test::roadgen({"render", net(), "--dem", kData + "pass_dem.tif", "--follow", "1,400,0,2",
                                       "--size", "160x90", "--ground-cache", cache, "-o", folder_->path(name)});
    EXPECT_EQ(run.code, 0) << run.err;
    return run.err;
  };
  EXPECT_EQ(draw("built").find("built again"), std::string::npos);
  ASSERT_TRUE(std::filesystem::exists(cache));
  const std::string kept = test::text_of(cache);
  EXPECT_EQ(draw("read").find("built again"), std::string::npos);
  EXPECT_EQ(test::text_of(cache), kept);
  std::string damaged = kept;
  damaged[damaged.size() / 2] ^= 1;
  folder_->put("pass.ground", damaged);
  EXPECT_NE(draw("again").find("damaged; built again"), std::string::npos);
  for (const char* name : {"read", "again"}) {
    EXPECT_EQ(test::text_of(folder_->path(std::string(name) + ".color.png")),
              test::text_of(folder_->path("built.color.png")));
  }
}

TEST_F(TerrainCommand, TexturesThatCannotServeAreRefused) {
  for (const auto& [texture, code, words] : {std::tuple("moss=a.jpg", 2, "expected grass=FILE"),
                                             {"grass", 2, "expected"},
                                             {"grass=/none.jpg", 1, "/none.jpg"}}) {
    const Outcome run = test::roadgen({"render", net(), "--follow", "1,400,0,2", "--size", "32x20", "--ground-texture",
                                       texture, "-o", folder_->path("textured")});
    EXPECT_EQ(run.code, code) << run.err;
    ASSERT_FALSE(run.error_lines().empty());
    EXPECT_NE(run.error_lines().back().find(words), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(folder_->path("textured.color.png")));
  }
}

TEST_F(TerrainCommand, RefusesModelsThatCannotServe) {
  expect_refused({folder_->path("none.tif"), net()}, 1, "no such elevation file");
  expect_refused({folder_->put("text.tif", "heights"), net()}, 1, "not an elevation raster");
  expect_refused({grid("elsewhere.asc", -70, 40, 40, "12"), net()}, 1, "but the roads need");
  expect_refused({grid("void.asc", 10, 46, 40, "-9999"), net()}, 1, "only voids");
  expect_refused({grid("nan.asc", 10, 46, 40, "nan"), net()}, 1, "");
  expect_refused({grid("pixel.asc", 10, 46, 1, "5"), net()}, 1, "1 x 1 posts");
  expect_refused({kData + "pass_dem.tif", net(), "--gap", "0.3", "--depth", "0.2"}, 2, "least clearance");
  expect_refused({kData + "pass_dem.tif", net(), "--cover", "-1"}, 2, "cover not negative");
  expect_refused({kData + "pass_dem.tif", net(), "--post", "0"}, 2, "post distance");
  expect_refused({kData + "pass_dem.tif", net(), "--ditch-depth", "-0.5"}, 2, "a ditch's slopes");
  expect_refused({kData + "pass_dem.tif", net(), "--ditch-depth", "0.5", "--ditch-inner-slope", "0"}, 2, "a ditch's");
  // Half of the roads, metres without a system, and heights that overflowed.
  expect_refused({grid("half.asc", 8.45, 46.48, 40, "12"), net()}, 1, "but the roads need");
  expect_refused({folder_->put("metres.asc",
                               "ncols 2\nnrows 2\nxllcorner 400000\nyllcorner 5000000\ncellsize 90000\n"
                               "1 1\n1 1\n"),
                  net()},
                 1, "no coordinate system");
  expect_refused({grid("overflow.asc", 10, 46, 40, "65525"), net()}, 1, "a number that overflowed");
}

}  // namespace
}  // namespace roadgen
