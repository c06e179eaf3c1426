// Heights above the geoid and above the ellipsoid: what files say, and the way from one to the other.
#include "terrain/vertical_datum.h"

#include <cmath>
#include <cstdint>
#include <fstream>

#include <gtest/gtest.h>

#include "roadgen/geodesy/local_frame.h"
#include "terrain/elevation.h"
#include "tests/temporary_folder.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::write_ascii_grid;

// An undulation that bilinear interpolation has exactly.
double undulation_m(double longitude, double latitude) {
  return 40 + 2 * (longitude - 7) - 3 * (latitude - 43) + 0.5 * (longitude - 7) * (latitude - 43);
}

class VerticalDatumTest : public ::testing::Test {
 protected:
  std::string geoid() { return write_ascii_grid(folder_.path("geoid.asc"), {6, 42}, 0.5, 7, 7, undulation_m); }
  std::string dem() {
    return write_ascii_grid(folder_.path("dem.asc"), {7, 43}, 0.01, 21, 21,
                            [](double x, double y) { return 100 + 300 * (x - 7) * (y - 43); });
  }
  test::TemporaryFolder folder_;
};

TEST_F(VerticalDatumTest, HeightsBecomeThoseOfTheRoadsByTheGivenGrid) {
  const auto plain = Elevation::open(dem());
  ASSERT_TRUE(plain.ok()) << plain.error().text();
  EXPECT_EQ(plain->datum(), VerticalDatum::kUnknown);
  for (const bool up : {true, false}) {
    const VerticalDatum own = up ? VerticalDatum::kGeoid : VerticalDatum::kEllipsoid;
    const VerticalDatum roads = up ? VerticalDatum::kEllipsoid : VerticalDatum::kGeoid;
    Diagnostics told;
    const auto made = Elevation::open(dem(), &told, HeightEncoding::kHeights, {own, roads, geoid()});
    ASSERT_TRUE(made.ok()) << made.error().text();
    EXPECT_EQ(made->datum(), roads);
    ASSERT_FALSE(told.empty());
    EXPECT_NE(told.back().message.find(up ? "39.40 to 40.40 m more" : "39.40 to 40.40 m less"), std::string::npos)
        << told.back().message;
    const Grid &before = plain->posts(), &after = made->posts();
    for (int row = 0; row < before.rows; ++row) {
      for (int column = 0; column < before.columns; ++column) {
        const glm::dvec2 at = before.origin_m + before.step_m * glm::dvec2(column, row);
        const double n = (up ? 1 : -1) * undulation_m(at.x, at.y);
        EXPECT_NEAR(after.at(column, row), before.at(column, row) + n, 2e-5);  // single precision of 140 m
      }
    }
  }
}

TEST_F(VerticalDatumTest, NothingIsConvertedWhereNothingOrTheSameIsKnown) {
  const auto plain = Elevation::open(dem());
  for (const HeightDatum& datum : {HeightDatum{VerticalDatum::kGeoid, VerticalDatum::kUnknown, geoid()},
                                   HeightDatum{VerticalDatum::kUnknown, VerticalDatum::kEllipsoid, geoid()},
                                   HeightDatum{std::nullopt, VerticalDatum::kEllipsoid, geoid()},
                                   HeightDatum{VerticalDatum::kGeoid, VerticalDatum::kGeoid, geoid()}}) {
    const auto made = Elevation::open(dem(), nullptr, HeightEncoding::kHeights, datum);
    ASSERT_TRUE(made.ok());
    EXPECT_EQ(made->posts().values, plain->posts().values);
    EXPECT_EQ(made->datum(), datum.roads == VerticalDatum::kUnknown ? VerticalDatum::kGeoid : datum.roads);
  }
}

// What is written says what its heights are above, and that is read again.
TEST_F(VerticalDatumTest, FilesSayWhatTheirHeightsAreAbove) {
  Grid grid{{7, 43}, {0.01, 0.01}, 3, 3, std::vector<float>(9, 100.0f)};
  struct Case {
    VerticalDatum datum;
    const char *geoid, *name;
  };
  for (const Case& c : {Case{VerticalDatum::kUnknown, "", ""},
                        {VerticalDatum::kEllipsoid, "", ""},
                        {VerticalDatum::kGeoid, "", "EGM96 height"},
                        {VerticalDatum::kGeoid, "EGM2008 height", "EGM2008 height"},
                        {VerticalDatum::kGeoid, "Height of a test", "Height of a test"}}) {
    const std::string path = folder_.path("heights.tif");
    ASSERT_TRUE(write_geotiff(grid, path, c.datum, c.geoid).ok());
    const auto read = Elevation::open(path);
    ASSERT_TRUE(read.ok()) << read.error().text();
    EXPECT_EQ(read->datum(), c.datum) << c.name;
    EXPECT_EQ(read->vertical_datum(), c.name);
    EXPECT_NEAR(read->height_m({7.01, 43.01}), 100, 1e-6);
  }
  // A geoid that nobody has a grid of: an error that says what to do, never heights that are 50 m off.
  const auto lost = Elevation::open(folder_.path("heights.tif"), nullptr, HeightEncoding::kHeights,
                                    {std::nullopt, VerticalDatum::kEllipsoid, ""});
  ASSERT_FALSE(lost.ok());
  EXPECT_NE(lost.error().message.find("no grid of the geoid 'Height of a test'"), std::string::npos)
      << lost.error().message;
  EXPECT_NE(lost.error().message.find("--geoid FILE"), std::string::npos);
  EXPECT_TRUE(Elevation::open(folder_.path("heights.tif"), nullptr, HeightEncoding::kHeights,
                              {std::nullopt, VerticalDatum::kEllipsoid, geoid()})
                  .ok());
}

TEST_F(VerticalDatumTest, ShuttleRadarHeightsAreAboveTheGeoid) {
  const std::string path = folder_.put("N43E007.hgt", std::string(std::size_t{2} * 1201 * 1201, '\0'));
  const auto elevation = Elevation::open(path);
  ASSERT_TRUE(elevation.ok()) << elevation.error().text();
  EXPECT_EQ(elevation->datum(), VerticalDatum::kGeoid);
  EXPECT_EQ(elevation->vertical_datum(), "EGM96 height");
}

// Values of the geoid's makers: NGA, EGM96, test points of its interpolation program. The grid of 15 minutes that PROJ has
// does not come nearer than this.
TEST_F(VerticalDatumTest, TheInstalledGeoidIsThatOfItsMakers) {
  const auto geoid = Undulation::open("", "EPSG:5773");
  if (!geoid) GTEST_SKIP() << geoid.error().text();
  struct Point {
    double latitude, longitude, n_m;
  };
  for (const Point& p : {Point{38.6281550, 269.7791550 - 360, -31.628},
                         {-14.6212170, 305.0211140 - 360, -2.969},
                         {46.8743190, 102.4487290, -43.575},
                         {-23.6174460, 133.8747120, 15.871},
                         {38.6254730, 359.9995 - 360, 50.066},
                         {-0.4667440, 0.0023000, 17.329}}) {
    const auto n = geoid->at(p.longitude, p.latitude);
    ASSERT_TRUE(n);
    EXPECT_NEAR(*n, p.n_m, 0.3) << p.latitude;
  }
}

TEST_F(VerticalDatumTest, GridsOfOtherMakersAreRead) {
  // GeographicLib's: 1 degree, everywhere -108 m + 0.003 m x 40123.
  std::string text =
      "P5\n# Description a test\n# Offset -108\n# Scale 0.003\n# Origin 90N 0E\n# AREA_OR_POINT Point\n360 "
      "181\n65535\n";
  for (int i = 0; i < 360 * 181; ++i) text += {static_cast<char>(40123 / 256), static_cast<char>(40123 % 256)};
  const auto pgm = Undulation::open(folder_.put("level.pgm", text), "");
  ASSERT_TRUE(pgm.ok()) << pgm.error().text();
  EXPECT_NEAR(pgm->at(7.5, 43.7).value(), 12.369, 1e-6);
  // From 0 to 360 degrees east.
  const auto east = Undulation::open(
      write_ascii_grid(folder_.path("east.asc"), {300, -10}, 1, 21, 21, [](double x, double y) { return x + y; }), "");
  ASSERT_TRUE(east.ok()) << east.error().text();
  EXPECT_NEAR(east->at(-50.25, 2.5).value(), 309.75 + 2.5, 1e-4);
  EXPECT_FALSE(east->at(7, 43).has_value());
  for (const std::string& bad : {folder_.path("none.gtx"), folder_.put("bad.pgm", "P5"), folder_.put("bad.gtx", "x")}) {
    const auto read = Undulation::open(bad, "");
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().file, bad);
  }
}

TEST(RoadDatum, IsWhatTheGeoreferenceSays) {
  Network network;
  const auto of = [&](const char* projection) {
    network.georeference = Georeference{43, 7, 0, projection};
    return road_datum_from_name("file", network).value();
  };
  EXPECT_EQ(of(""), VerticalDatum::kUnknown);
  EXPECT_EQ(of("+proj=utm +zone=32 +datum=WGS84"), VerticalDatum::kUnknown);
  EXPECT_EQ(of("+proj=utm +zone=32 +datum=WGS84 +geoidgrids=egm96_15.gtx +units=m +vunits=m"), VerticalDatum::kGeoid);
  EXPECT_EQ(of("EPSG:32632+5773"), VerticalDatum::kGeoid);
  EXPECT_EQ(road_datum_from_name("ellipsoid", network).value(), VerticalDatum::kEllipsoid);
  EXPECT_EQ(road_datum_from_name("sea", network).error().code, ErrorCode::kUsage);
  EXPECT_EQ(elevation_datum_from_name("sea").error().code, ErrorCode::kUsage);
}

}  // namespace
}  // namespace roadgen
