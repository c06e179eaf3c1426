#include "terrain/elevation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/geodesy/local_frame.h"
#include "terrain/natural.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using testing::road_along;
using testing::scratch_folder;
using testing::straight;
using testing::write_ascii_grid;

constexpr double kEarth_m = 6.38e6;

Network road_at(Georeference origin, double length_m = 200) {
  Network network;
  network.georeference = origin;
  network.roads.push_back(road_along(
      "r", length_m, 25, 3,
      [](double s) {
        return straight({0, 0}, 0.3, s);
      },
      [](double) { return 0.0; }));
  return network;
}

TEST(Grid, BicubicIsExactForQuadraticGround) {
  Grid grid;
  grid.origin_m = {3, -2};
  grid.step_m = {0.5, 2};
  grid.columns = 12;
  grid.rows = 9;
  const auto truth = [](glm::dvec2 p) {
    return 1 + 2 * p.x - p.y + 0.5 * p.x * p.x - 0.25 * p.x * p.y + 0.125 * p.y * p.y;
  };
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      grid.values.push_back(static_cast<float>(truth(grid.origin_m + grid.step_m * glm::dvec2(column, row))));
    }
  }
  for (double x = 3.6; x < 7.9; x += 0.17) {
    for (double y = 0.1; y < 11.9; y += 0.31) EXPECT_NEAR(sample_bicubic(grid, {x, y}), truth({x, y}), 2e-5);
  }
  // Bilinear is not: that is what the other is for.
  EXPECT_GT(std::abs(sample_bilinear(grid, {5.25, 5}) - truth({5.25, 5})), 0.02);
}

TEST(Grid, HolesBecomeAMembrane) {
  Grid grid;
  grid.columns = 40;
  grid.rows = 30;
  std::vector<std::uint8_t> known;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const bool hole = std::hypot(column - 20, row - 15) < 8;
      known.push_back(!hole);
      grid.values.push_back(hole ? -1e6f : static_cast<float>(10 + 0.5 * column - 0.25 * row));
    }
  }
  const auto holes = static_cast<std::size_t>(std::count(known.begin(), known.end(), std::uint8_t{0}));
  EXPECT_EQ(fill_holes(grid, known), holes);
  // A plane is a membrane.
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      EXPECT_NEAR(grid.at(column, row), 10 + 0.5 * column - 0.25 * row, 0.25);
    }
  }
}

TEST(Elevation, APlaneIsReadBackEverywhere) {
  const auto truth = [](double x, double y) { return 700 + 0.03 * x - 0.07 * y; };
  const auto elevation =
      Elevation::open(write_ascii_grid(scratch_folder() + "/plane.asc", {1000, 2000}, 10, 60, 40, truth));
  ASSERT_TRUE(elevation) << elevation.error().text();
  EXPECT_FALSE(elevation->is_geographic());
  EXPECT_NEAR(elevation->post_spacing_m(), 10, 1e-9);
  const Extent e = elevation->extent();
  EXPECT_NEAR(e.low.x, 1000, 1e-9);
  EXPECT_NEAR(e.high.y, 2390, 1e-9);
  for (double x = 1015; x < 1575; x += 13.7) {
    for (double y = 2015; y < 2375; y += 11.3) {
      EXPECT_NEAR(elevation->height_m({x, y}), truth(x, y), 2e-4);
      EXPECT_NEAR(elevation->height_m({x, y}, Interpolation::kBilinear), truth(x, y), 2e-4);
    }
  }
  EXPECT_TRUE(elevation->covers({1000, 2390}));
  EXPECT_FALSE(elevation->covers({999, 2390}));
}

TEST(Elevation, VoidsAreFilledFromAroundAndCounted) {
  int holes = 0;
  const auto post = [&](double x, double y) -> std::string {
    const int column = static_cast<int>(x / 10), row = static_cast<int>(y / 10);
    if (column >= 10 && column < 14 && row >= 10 && row < 13) return ++holes, "-9999";
    if (column == 20 && row == 20) return ++holes, "-32768";
    if (column == 5 && row == 22) return ++holes, "nan";
    return std::to_string(100 + x + 2 * y);
  };
  Diagnostics diagnostics;
  const auto elevation = Elevation::open(write_ascii_grid(scratch_folder() + "/holes.asc", {1000, 1000}, 10, 30, 25,
                                                          [&](double x, double y) { return post(x - 1000, y - 1000); }),
                                         &diagnostics);
  ASSERT_TRUE(elevation) << elevation.error().text();
  EXPECT_EQ(elevation->voids_filled(), static_cast<std::size_t>(holes));
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("14 voids"), std::string::npos);
  for (const glm::dvec2 p : {glm::dvec2(120, 115), glm::dvec2(200, 200), glm::dvec2(50, 220)}) {
    EXPECT_NEAR(elevation->height_m(p + 1000.0), 100 + p.x + 2 * p.y, 8) << p.x;
  }
}

TEST(Elevation, DegreesWithoutACoordinateSystemAreTakenForWgs84AndSaid) {
  Diagnostics diagnostics;
  const auto elevation = Elevation::open(
      write_ascii_grid(scratch_folder() + "/d.asc", {8, 46}, 0.001, 50, 50, [](double, double) { return 5.0; }),
      &diagnostics);
  ASSERT_TRUE(elevation);
  EXPECT_TRUE(elevation->is_geographic());
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("WGS84"), std::string::npos);
}

TEST(Elevation, BadFilesAreErrorsThatNameThem) {
  const std::string folder = scratch_folder();
  const auto missing = Elevation::open(folder + "/missing.tif");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kIo);
  EXPECT_EQ(missing.error().file, folder + "/missing.tif");
  std::ofstream(folder + "/text.tif") << "this is no raster";
  const auto text = Elevation::open(folder + "/text.tif");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kParse);
  const auto voids =
      Elevation::open(write_ascii_grid(folder + "/void.asc", {0, 0}, 10, 5, 5, [](double, double) { return -9999.0; }));
  ASSERT_FALSE(voids);
  EXPECT_NE(voids.error().message.find("voids"), std::string::npos);
}

TEST(Elevation, AProjectedModelIsSampledByLongitudeAndLatitude) {
  const std::string path = scratch_folder() + "/utm.asc";
  // UTM zone 32: the central meridian 9 degrees east is easting 500 000.
  write_ascii_grid(path, {495000, 5145000}, 50, 200, 200,
                   [](double x, double y) { return 1000 + 0.02 * (x - 500000) + 0.01 * (y - 5150000); });
  std::ofstream(path.substr(0, path.size() - 4) + ".prj")
      << "PROJCS[\"WGS 84 / UTM zone 32N\",GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\","
         "SPHEROID[\"WGS 84\",6378137,298.257223563]],"
         "PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]],PROJECTION[\"Transverse_Mercator\"],"
         "PARAMETER[\"latitude_of_origin\",0],PARAMETER[\"central_meridian\",9],PARAMETER[\"scale_factor\",0.9996],"
         "PARAMETER[\"false_easting\",500000],PARAMETER[\"false_northing\",0],UNIT[\"metre\",1]]";
  const auto elevation = Elevation::open(path);
  ASSERT_TRUE(elevation) << elevation.error().text();
  EXPECT_TRUE(elevation->is_geographic());
  EXPECT_NEAR(elevation->post_spacing_m(), 50, 1e-6);
  // Northing of 46.5 degrees on the central meridian: 0.9996 times the meridian's arc (series in the third flattening).
  const double f = 1 / 298.257223563, n = f / (2 - f), phi = 46.5 * std::numbers::pi / 180;
  const double arc = 6378137 / (1 + n) *
                     ((1 + n * n / 4) * phi - 1.5 * (n - n * n * n / 8) * std::sin(2 * phi) +
                      15.0 / 16 * n * n * std::sin(4 * phi) - 35.0 / 48 * n * n * n * std::sin(6 * phi));
  EXPECT_NEAR(elevation->height_m({9, 46.5}), 1000 + 0.01 * (0.9996 * arc - 5150000), 1e-3);
  EXPECT_TRUE(elevation->covers({9, 46.5}));
  EXPECT_FALSE(elevation->covers({9.2, 46.5}));
}

TEST(NaturalGround, TheEarthIsRound) {
  // Everything 1000 m high: in the plane of the network the ground falls away by d^2 / 2R.
  const auto elevation = Elevation::open(
      write_ascii_grid(scratch_folder() + "/flat.asc", {8, 46}, 0.01, 101, 101, [](double, double) { return 1000.0; }));
  const Network network = road_at({46.5, 8.5, 400});
  ASSERT_TRUE(check_coverage(*elevation, network));
  for (const double d : {0.0, 5000.0, 15000.0, 30000.0}) {
    EXPECT_NEAR(elevation_enu_m(*elevation, network, {d, 0}), 600 - d * d / (2 * kEarth_m), 0.02 + 1e-5 * d);
  }
}

TEST(NaturalGround, ThePlaceOnTheEarthIsTheOneUnderTheLiftedPoint) {
  // Steep ground far from the origin: reading it at the wrong place shows.
  const auto truth = [](double lon, double lat) { return 1500 + 60000 * (lat - 46.5) + 30000 * (lon - 8.5); };
  const auto elevation =
      Elevation::open(write_ascii_grid(scratch_folder() + "/slope.asc", {8.2, 46.2}, 0.005, 121, 121, truth));
  ASSERT_TRUE(elevation);
  const Network network = road_at({46.5, 8.5, 0});
  const LocalFrame frame(*network.georeference);
  const glm::dvec2 p(9000, -12000);
  const double z = elevation_enu_m(*elevation, network, p);
  const Geodetic g = frame.to_geodetic({p.x, p.y, z});
  EXPECT_NEAR(g.height_m, truth(g.longitude_deg, g.latitude_deg), 2e-3);
  // And not the one that a frame without curvature would take.
  const Geodetic foot = frame.to_geodetic({p.x, p.y, 0});
  EXPECT_GT(std::abs(truth(foot.longitude_deg, foot.latitude_deg) - g.height_m), 0.1);
}

TEST(NaturalGround, AnElevationThatMissesTheRoadsIsAnErrorWithBothExtents) {
  const auto elevation = Elevation::open(
      write_ascii_grid(scratch_folder() + "/away.asc", {8, 46}, 0.001, 101, 101, [](double, double) { return 0.0; }));
  const Status missed = check_coverage(*elevation, road_at({46.5, 8.5, 0}));
  ASSERT_FALSE(missed);
  EXPECT_NE(missed.error().message.find("46.00000 to 46.10000"), std::string::npos) << missed.error().text();
  EXPECT_NE(missed.error().message.find("46.50"), std::string::npos) << missed.error().text();
  EXPECT_TRUE(check_coverage(*elevation, road_at({46.05, 8.05, 0})));
  Network plane = road_at({46.05, 8.05, 0});
  plane.georeference.reset();
  EXPECT_FALSE(check_coverage(*elevation, plane));
}

TEST(NaturalGround, WithoutElevationItPassesThroughTheRoadsAndRollsAway) {
  Network network = road_at({}, 1000);
  network.georeference.reset();
  for (Segment& segment : network.roads[0].segments) segment.elevation_m = {50 + 0.05 * segment.s_start_m, 0.05, 0, 0};
  const Grid ground = natural_from_roads(network, {{-1500, -1500}, {2500, 2000}}, 12, 40);
  for (double s = 0; s <= 1000; s += 50) {
    EXPECT_NEAR(sample_bicubic(ground, glm::dvec2(pose_at(network.roads[0], s, 0).position_m)), 50 + 0.05 * s, 1.0);
  }
  double low = 1e9, high = -1e9;
  for (double x = -1400; x < 2400; x += 50) {
    const double z = sample_bicubic(ground, {x, -1300});
    low = std::min(low, z);
    high = std::max(high, z);
  }
  EXPECT_GT(high - low, 15);
  EXPECT_LT(high - low, 200);
}

void expect_srtm(const char* name, glm::dvec2 place, double low_m, double high_m, std::size_t voids) {
  const std::string path = std::string(ROADGEN_SOURCE_DIR) + "/../shared/data/terrain/srtm-hgt/" + name;
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "real elevation is missing, nothing was checked: " << path;
  const auto elevation = Elevation::open(path);
  ASSERT_TRUE(elevation) << elevation.error().text();
  EXPECT_TRUE(elevation->is_geographic());
  EXPECT_EQ(elevation->voids_filled(), voids);
  EXPECT_EQ(elevation->posts().columns, 1201);
  const auto range = std::minmax_element(elevation->posts().values.begin(), elevation->posts().values.end());
  EXPECT_GT(*range.first, -100);
  EXPECT_LT(*range.second, 2100);
  // Posts stand on whole arc seconds.
  EXPECT_NEAR(elevation->extent().low.x, std::floor(place.x), 1e-9);
  EXPECT_NEAR(elevation->extent().high.y, std::ceil(place.y), 1e-9);
  const double z = elevation->height_m(place);
  EXPECT_GT(z, low_m);
  EXPECT_LT(z, high_m);
}

TEST(Elevation, ReadsSrtmOfMonacoFromItsZip) {
  // Mont Agel, 1148 m, and its surroundings.
  expect_srtm("N43E007.hgt.zip", {7.4233, 43.7769}, 900, 1160, 1595);
}

TEST(Elevation, ReadsSrtmOfSchleizFromItsZip) {
  // The market place, about 440 m.
  expect_srtm("N50E011.hgt.zip", {11.8111, 50.5789}, 400, 480, 8);
}

// An image of bytes, bands side by side, through GDAL.
std::string write_image(const std::string& path, const char* driver, int size, int bands,
                        const std::function<std::array<int, 4>(int column, int row)>& pixel) {
  GDALAllRegister();
  GDALDriver* memory = GetGDALDriverManager()->GetDriverByName("MEM");
  GDALDataset* image = memory->Create("", size, size, bands, GDT_Byte, nullptr);
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const std::array<int, 4> value = pixel(column, row);
      for (int band = 0; band < bands; ++band) {
        auto byte = static_cast<std::uint8_t>(value[static_cast<std::size_t>(band)]);
        EXPECT_EQ(
            image->GetRasterBand(band + 1)->RasterIO(GF_Write, column, row, 1, 1, &byte, 1, 1, GDT_Byte, 0, 0, nullptr),
            CE_None);
      }
    }
  }
  GDALClose(GetGDALDriverManager()->GetDriverByName(driver)->CreateCopy(path.c_str(), image, FALSE, nullptr, nullptr,
                                                                        nullptr));
  GDALClose(image);
  return path;
}

TEST(Elevation, ColoursOfMapTilesAreHeights) {
  // The tile of zoom 12 that holds Monaco; west, south, east, north in degrees by the Mercator formulas.
  const int z = 12, x = 2132, y = 1494, size = 64;
  const std::string top = scratch_folder(), folder = top + "/tiles/12/2132";
  std::filesystem::create_directories(folder);
  const double n = std::exp2(z), west = x / n * 360 - 180, east = (x + 1) / n * 360 - 180;
  const auto latitude = [&](double row) {
    return std::atan(std::sinh(std::numbers::pi * (1 - 2 * row / n))) * 180 / std::numbers::pi;
  };
  const auto truth = [](int column, int row) { return -12.5 + 3.25 * column + 7.75 * row; };
  const std::string path = folder + "/1494.png";
  for (const HeightEncoding encoding : {HeightEncoding::kTerrainRgb, HeightEncoding::kTerrarium}) {
    const bool rgb = encoding == HeightEncoding::kTerrainRgb;
    write_image(path, "PNG", size, 4, [&](int column, int row) {
      const double h = truth(column, row);
      const int code = static_cast<int>(std::lround(rgb ? (h + 10000) * 10 : (h + 32768) * 256));
      return std::array<int, 4>{code >> 16, (code >> 8) & 255, code & 255, column == 5 && row == 9 ? 0 : 255};
    });
    Diagnostics diagnostics;
    const auto elevation = Elevation::open(path, &diagnostics, encoding);
    ASSERT_TRUE(elevation) << elevation.error().text();
    EXPECT_TRUE(elevation->is_geographic());
    EXPECT_EQ(elevation->voids_filled(), 1u);
    for (int row = 3; row < size; row += 12) {
      for (int column = 2; column < size; column += 11) {
        const double longitude = west + (east - west) * (column + 0.5) / size;
        const double z_m = elevation->height_m({longitude, latitude(y + (row + 0.5) / size)});
        EXPECT_NEAR(z_m, truth(column, row), rgb ? 0.051 : 0.003) << column << ", " << row;
      }
    }
    const auto as_heights = Elevation::open(path);
    ASSERT_FALSE(as_heights);
    EXPECT_NE(as_heights.error().message.find("terrain-rgb"), std::string::npos);
    const auto nowhere = Elevation::open(write_image(top + "/nowhere.png", "PNG", 4, 3,
                                                     [](int, int) {
                                                       return std::array<int, 4>{1, 2, 3, 0};
                                                     }),
                                         nullptr, encoding);
    ASSERT_FALSE(nowhere);
    EXPECT_NE(nowhere.error().message.find("where it lies"), std::string::npos);
  }
  const auto gray =
      Elevation::open(write_ascii_grid(top + "/gray.asc", {0, 0}, 10, 5, 5, [](double, double) { return 1.0; }),
                      nullptr, HeightEncoding::kTerrarium);
  ASSERT_FALSE(gray);
  EXPECT_FALSE(height_encoding_from_name("rgb"));
}

TEST(Elevation, AMosaicOfTilesIsOneModel) {
  const std::string folder = scratch_folder();
  const auto truth = [](double x, double y) { return 0.1 * x - 0.2 * y; };
  const std::string left = write_ascii_grid(folder + "/left.asc", {0, 0}, 10, 20, 30, truth);
  const std::string right = write_ascii_grid(folder + "/right.asc", {200, 0}, 10, 20, 30, truth);
  const auto source = [](const std::string& file, int at) {
    return "<SimpleSource><SourceFilename relativeToVRT='0'>" + file + "</SourceFilename><SourceBand>1</SourceBand>" +
           "<SrcRect xOff='0' yOff='0' xSize='20' ySize='30'/><DstRect xOff='" + std::to_string(at) +
           "' yOff='0' xSize='20' ySize='30'/></SimpleSource>";
  };
  std::ofstream(folder + "/both.vrt")
      << "<VRTDataset rasterXSize='40' rasterYSize='30'><GeoTransform>-5, 10, 0, 295, 0, -10"
         "</GeoTransform><VRTRasterBand dataType='Float32' band='1'>"
      << source(left, 0) << source(right, 20) << "</VRTRasterBand></VRTDataset>";
  const auto both = Elevation::open(folder + "/both.vrt");
  ASSERT_TRUE(both) << both.error().text();
  EXPECT_EQ(both->posts().columns, 40);
  for (double x = 20; x < 380; x += 17) EXPECT_NEAR(both->height_m({x, 140}), truth(x, 140), 1e-3) << x;
}

TEST(Elevation, AGeotiffIsReadBackAsWritten) {
  const std::string path = scratch_folder() + "/out.tif";
  Grid grid;
  grid.origin_m = {8.25, 46.5};
  grid.step_m = {0.001, 0.0005};
  grid.columns = 7;
  grid.rows = 5;
  for (int i = 0; i < 35; ++i) grid.values.push_back(static_cast<float>(i * i));
  ASSERT_TRUE(write_geotiff(grid, path));
  const auto elevation = Elevation::open(path);
  ASSERT_TRUE(elevation) << elevation.error().text();
  EXPECT_EQ(elevation->posts().values, grid.values);
  EXPECT_NEAR(glm::length(elevation->posts().origin_m - grid.origin_m), 0, 1e-12);
  EXPECT_FALSE(std::filesystem::exists(path + ".part"));
  // As GDAL has it: corners of pixels whose centres are the posts, the first row northernmost, on WGS84.
  const std::unique_ptr<GDALDataset> raw(GDALDataset::Open(path.c_str()));
  ASSERT_TRUE(raw);
  double t[6];
  ASSERT_EQ(raw->GetGeoTransform(t), CE_None);
  const double wanted[6] = {8.25 - 0.0005, 0.001, 0, 46.5 + 4.5 * 0.0005, 0, -0.0005};
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(t[i], wanted[i], 1e-12) << i;
  EXPECT_STREQ(raw->GetSpatialRef()->GetAuthorityCode(nullptr), "4326");
  float corner = -1;
  ASSERT_EQ(raw->GetRasterBand(1)->RasterIO(GF_Read, 0, 0, 1, 1, &corner, 1, 1, GDT_Float32, 0, 0), CE_None);
  EXPECT_EQ(corner, 28.0f * 28.0f);  // of the north-western post
  EXPECT_FALSE(write_geotiff(grid, "/nowhere/at/all.tif"));
}

}  // namespace
}  // namespace roadgen
