// The whole import, from files to a network.
#include <gtest/gtest.h>

#include <cmath>

#include "roadgen/import/import.h"
#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

using test::TemporaryFolder;

std::string row(double a, double b) { return std::to_string(a) + "," + std::to_string(b) + "\n"; }

ImportResult imported(const std::vector<std::string>& paths, const ImportOptions& options = {}) {
  Result<ImportResult> result = import_files(paths, options);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
  return result.ok() ? *result : ImportResult{};
}

bool mentions(const Diagnostics& diagnostics, const std::string& what) {
  for (const Diagnostic& d : diagnostics) {
    if (d.text().find(what) != std::string::npos) return true;
  }
  return false;
}

TEST(Import, FilesShareOneFrameAboutTheirCommonCentre) {
  const TemporaryFolder folder;
  const std::string a = folder.put("a.csv", "lat,lon,height\n50,11,300\n50.0000007,11.003,300\n50,11.006,300\n");
  const std::string b = folder.put("b.csv", "lat,lon\n50.01,11\n50.01,11.005\n");
  const ImportResult result = imported({a, b});
  ASSERT_EQ(result.network.roads.size(), 2u);
  EXPECT_EQ(result.network.roads[1].id, "2");
  EXPECT_EQ(result.network.roads[1].name, "b");
  EXPECT_EQ(result.network.georeference->latitude_deg, 50.005);
  EXPECT_EQ(result.network.georeference->longitude_deg, 11.003);
  EXPECT_EQ(result.network.georeference->height_m, 0);
  const Segment &first = result.network.roads[0].segments.front(), &second = result.network.roads[1].segments.front();
  EXPECT_NEAR(second.start_m.y - first.start_m.y, 0.01 * 111229, 1);
  EXPECT_NEAR(first.elevation_m.c0, 300, 0.1);
}

TEST(Import, TheOriginMovesTheRoadsAndNothingElse) {
  const TemporaryFolder folder;
  std::string text = "lat,lon\n";
  for (int i = 0; i < 40; ++i) text += row(50 + 1e-4 * i, 11 + 3e-4 * std::sin(0.2 * i));
  const std::string path = folder.put("a.csv", text);
  ImportOptions moved;
  moved.origin = Georeference{50.01, 11.02, 0};
  const ImportResult a = imported({path}), b = imported({path}, moved);
  EXPECT_NEAR(a.certificates[0].length_m, b.certificates[0].length_m, 1e-3);
  EXPECT_NEAR(a.greatest_distance_m, 220, 20);
  EXPECT_GT(b.greatest_distance_m, 1000);
}

TEST(Import, TheAntimeridianIsNoSeam) {
  const TemporaryFolder folder;
  const std::string path = folder.put("a.csv", "lat,lon\n0,179.999\n0,-180\n0,-179.998\n");
  const ImportResult result = imported({path});
  EXPECT_NEAR(result.network.georeference->longitude_deg, -179.9995, 1e-9);
  EXPECT_NEAR(result.certificates[0].length_m, 0.003 * 111319.5, 0.01);
}

TEST(Import, RecordedTracksAreAllowedTheErrorOfGps) {
  const TemporaryFolder folder;
  std::string points;
  for (int i = 0; i < 20; ++i) points += "<trkpt lat=\"" + std::to_string(50 + 1e-4 * i) + "\" lon=\"11\"/>";
  const std::string path = folder.put("a.gpx", "<gpx><trk><trkseg>" + points + "</trkseg></trk></gpx>");
  EXPECT_EQ(imported({path}).allowed_error_m[0], kGpsError_m);
  ImportOptions own;
  own.max_error_m = 0.5;
  EXPECT_EQ(imported({path}, own).allowed_error_m[0], 0.5);
}

TEST(Import, TracksTooShortAreLeftOutWhereOthersRemain) {
  const TemporaryFolder folder;
  const std::string path = folder.put("a.gpx", R"(<gpx><trk><trkseg><trkpt lat="50" lon="11"/></trkseg></trk>
<trk><trkseg><trkpt lat="50" lon="11"/><trkpt lat="50.01" lon="11"/></trkseg></trk></gpx>)");
  const ImportResult result = imported({path});
  EXPECT_EQ(result.network.roads.size(), 1u);
  EXPECT_TRUE(mentions(result.diagnostics, "left out"));
}

TEST(Import, DistanceFromTheOriginIsTold) {
  const TemporaryFolder folder;
  const std::string path = folder.put("a.csv", "lat,lon\n50,11\n50.01,11\n");
  ImportOptions far;
  far.origin = Georeference{51, 11, 0};
  EXPECT_TRUE(mentions(imported({path}, far).diagnostics, "km from the origin"));
  EXPECT_FALSE(mentions(imported({path}).diagnostics, "km from the origin"));
}

TEST(Import, WidthsOfTheFileBecomeHalfWidths) {
  const TemporaryFolder folder;
  const std::string path = folder.put("a.csv", "x,y,width\n0,0,4\n100,0,6\n200,0,\n");
  ImportOptions options;
  options.width_m = 9;
  const Road road = imported({path}, options).network.roads[0];
  EXPECT_NEAR(road.segments.front().left_m.value(0), 2, 0.1);
  EXPECT_NEAR(road.segments.back().left_m.value(road.segments.back().arc_m), 4.5, 0.1);
}

TEST(Import, FieldsThatAreNamedGiveWidthLanesHeightAndName) {
  const TemporaryFolder folder;
  const std::string csv = folder.put("a.csv", "x,y,width,B,Spuren,H\n0,0,99,12,3,400\n100,0,99,12,3,400\n");
  const std::string json = folder.put("a.geojson", R"({"type":"FeatureCollection",
"crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}},"features":[
{"type":"Feature","properties":{"b":12,"Spuren":"4","h":310.5,"ref":"A 9"},
 "geometry":{"type":"LineString","coordinates":[[500000,5000000],[500000,5001000]]}},
{"type":"Feature","properties":{"b":null,"Spuren":2.5,"h":"low","ref":null},
 "geometry":{"type":"LineString","coordinates":[[500100,5000000],[500100,5001000]]}},
{"type":"Feature","properties":{"Spuren":1},
 "geometry":{"type":"LineString","coordinates":[[500200,5000000],[500200,5001000]]}}]})");
  ImportOptions options;
  options.fields = {.width = "B", .lanes = "Spuren", .height = "H", .name = {}};
  ImportResult result = imported({csv}, options);
  const Road& three = result.network.roads.at(0);
  EXPECT_NEAR(three.segments[0].left_m.c0, 6, 1e-12);
  EXPECT_NEAR(three.segments[0].right_m.c0, -6, 1e-12);
  EXPECT_NEAR(three.segments[0].elevation_m.c0, 400, 1e-9);
  // One lane to the left, two to the right, all 4 m wide, and a strip beyond each edge line.
  ASSERT_EQ(three.sections[0].left.size(), 2u);
  ASSERT_EQ(three.sections[0].right.size(), 3u);
  EXPECT_NEAR(three.sections[0].offset_m.c0, 2, 1e-12);
  EXPECT_NEAR(three.sections[0].right[0].width_m.c0, 4, 1e-12);
  EXPECT_EQ(three.sections[0].right[0].mark.kind, MarkKind::kBroken);
  EXPECT_EQ(three.sections[0].right[1].mark.kind, MarkKind::kSolid);
  EXPECT_TRUE(check(result.network).ok());

  options.fields.name = "ref";
  result = imported({json}, options);
  ASSERT_EQ(result.network.roads.size(), 3u);
  const Road &four = result.network.roads[0], &two = result.network.roads[1], &one = result.network.roads[2];
  EXPECT_EQ(four.name, "A 9");
  EXPECT_EQ(four.sections[0].left.size(), 3u);
  EXPECT_EQ(four.sections[0].center_mark.kind, MarkKind::kSolidSolid);
  EXPECT_NEAR(four.segments[0].left_m.c0, 6, 1e-12);
  EXPECT_NEAR(four.segments[0].elevation_m.c0, 310.5, 0.2);  // less the Earth's curvature
  EXPECT_EQ(two.sections[0].left.size(), 2u);
  EXPECT_NEAR(two.segments[0].left_m.c0, 3.5, 1e-12);
  EXPECT_TRUE(one.sections[0].left.empty());
  EXPECT_NEAR(one.segments[0].left_m.c0, 1.75, 1e-12);
  EXPECT_TRUE(mentions(result.diagnostics, "the number of lanes is not one of 1 to 20"));
  EXPECT_TRUE(mentions(result.diagnostics, "the property H is not a number"));
  EXPECT_TRUE(check(result.network).ok());

  options.fields.lanes = "tracks";
  for (const std::string& path : {csv, json}) {
    const Result<ImportResult> none = import_files({path}, options);
    ASSERT_FALSE(none.ok());
    EXPECT_EQ(none.error().code, ErrorCode::kData);
    EXPECT_NE(none.error().message.find("'tracks'"), std::string::npos) << none.error().text();
  }
}

TEST(Import, ProgressGrowsFromNothingToAll) {
  const TemporaryFolder folder;
  const std::string path = folder.put("a.csv", "x,y\n0,0\n100,0\n");
  double last = 0;
  const auto result = import_files({path, path, path}, {}, [&](double part, const std::string&) {
    EXPECT_GE(part, last);
    last = part;
  });
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(last, 1);
}

TEST(Import, OptionsOutOfRangeAreUsageErrors) {
  const TemporaryFolder folder;
  const std::string path = folder.put("a.csv", "lat,lon\n50,11\n50.01,11\n");
  const auto code = [&](const ImportOptions& options) {
    const auto result = import_files({path}, options);
    EXPECT_FALSE(result.ok());
    return result.ok() ? ErrorCode::kData : result.error().code;
  };
  ImportOptions error, width, origin;
  error.max_error_m = NAN;
  width.width_m = 1000;
  origin.origin = Georeference{0, 181, 0};
  EXPECT_EQ(code(error), ErrorCode::kUsage);
  EXPECT_EQ(code(width), ErrorCode::kUsage);
  EXPECT_EQ(code(origin), ErrorCode::kUsage);
  EXPECT_EQ(import_files({}, {}).error().code, ErrorCode::kUsage);
}

TEST(HeightTolerance, FollowsTheRoughnessOfTheHeights) {
  const auto heights = [](double rough_m) {
    std::vector<roadgen::Sample> samples;
    for (int i = 0; i < 100; ++i) {
      samples.push_back({.position_m = {12.0 * i, 3.0 * i}, .elevation_m = 0.7 * i + (i % 2 == 0 ? rough_m : -rough_m)});
    }
    return samples;
  };
  using roadgen::height_tolerance_m;
  EXPECT_EQ(height_tolerance_m(heights(0)), roadgen::kLeastHeightError_m);  // a plane
  EXPECT_NEAR(height_tolerance_m(heights(0.08)), 3 * 2 * 0.08, 1e-9);       // each is 2 rough_m off its neighbours' line
  EXPECT_EQ(height_tolerance_m(heights(2)), roadgen::kGreatestHeightError_m);
  EXPECT_EQ(height_tolerance_m({}), roadgen::kLeastHeightError_m);
}

}  // namespace
}  // namespace roadgen
