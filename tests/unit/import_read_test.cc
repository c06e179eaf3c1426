// Readers of tracks: CSV, GPX, and vector files by GDAL.
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogrsf_frmts.h>

#include "roadgen/import/csv.h"
#include "roadgen/import/gpx.h"
#include "roadgen/import/ogr.h"
#include "roadgen/import/text_file.h"
#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

Track good_csv(const std::string& text, Diagnostics* diagnostics = nullptr) {
  Diagnostics own;
  auto tracks = parse_csv(text, "t.csv", {}, diagnostics ? *diagnostics : own);
  EXPECT_TRUE(tracks.ok()) << text << "\n" << (tracks.ok() ? "" : tracks.error().text());
  return tracks.ok() ? tracks->front() : Track{};
}

Error bad_csv(const std::string& text) {
  Diagnostics diagnostics;
  auto tracks = parse_csv(text, "t.csv", {}, diagnostics);
  EXPECT_FALSE(tracks.ok()) << text;
  return tracks.ok() ? Error{} : tracks.error();
}

TEST(TextFile, NumbersAreReadWhole) {
  EXPECT_EQ(parse_number(" +1.5e3\r"), 1500);
  EXPECT_EQ(parse_number("-0.25"), -0.25);
  for (const char* text : {"", " ", "1,5", "1.5m", "0x10", "+-1", "++1", "1 2"})
    EXPECT_FALSE(parse_number(text)) << text;
}

TEST(TextFile, LinesAreCountedFromOne) {
  const LineIndex lines("a\nb\n\nc");
  EXPECT_EQ(lines.line(0), 1);
  EXPECT_EQ(lines.line(1), 1);
  EXPECT_EQ(lines.line(2), 2);
  EXPECT_EQ(lines.line(5), 4);
  EXPECT_EQ(lines.line(-1), 1);
}

TEST(TextFile, OnlyWellFormedUtf8Passes) {
  EXPECT_TRUE(check_utf8("Z\xC3\xBCrich \xE2\x82\xAC \xF0\x9F\x8F\x81", "f").ok());
  for (const char* bad : {"\xC3", "\xC0\xAF", "\xE0\x80\x80", "\xED\xA0\x80", "\xF4\x90\x80\x80", "\xFF", "a\x80"}) {
    const Status status = check_utf8(std::string("one\ntwo\n") + bad, "f");
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().line, 3);
  }
}

TEST(Csv, ColumnsComeInAnyOrderCaseAndSeparator) {
  for (const char* text :
       {"lat,lon,height,width\n1,2,3,4\n", "Longitude;LATITUDE;ele;W\r\n2;1;3;4\r\n",
        "width\talt\tlng\tlat\n4\t3\t2\t1\n", "\xEF\xBB\xBFlat, lon, z, width_m\n 1, 2, 3, 4",
        "# made by hand\n# lat,lon,h,w\n# comment\n\n1,2,3,4\n", "\"lat\",\"lon\",\"h\",\"w\"\n1,\"2\",3,4\n"}) {
    const Track track = good_csv(text);
    ASSERT_EQ(track.points.size(), 1u) << text;
    EXPECT_TRUE(track.geodetic);
    EXPECT_EQ(track.points[0].x, 2);
    EXPECT_EQ(track.points[0].y, 1);
    EXPECT_EQ(track.points[0].height_m, 3);
    EXPECT_EQ(track.points[0].width_m, 4);
  }
  const Track metres = good_csv("x_m,y_m\n10,20\n30,40");
  EXPECT_FALSE(metres.geodetic);
  EXPECT_EQ(metres.points[1].y, 40);
  EXPECT_EQ(metres.points[1].line, 3);
  EXPECT_FALSE(metres.points[1].height_m.has_value());
}

TEST(Csv, EmptyCellsAndUnknownColumnsAreToldNotGuessed) {
  Diagnostics diagnostics;
  const Track track = good_csv("lat,lon,height,speed\n1,2,,9\n,2,3,9\nnan,2,3,9\n1,inf,3,9\n4,5,6,9\n", &diagnostics);
  ASSERT_EQ(track.points.size(), 2u);
  EXPECT_FALSE(track.points[0].height_m.has_value());
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_NE(diagnostics[0].message.find("speed"), std::string::npos);
  EXPECT_EQ(diagnostics[1].line, 3);
  EXPECT_NE(diagnostics[1].message.find("lines 3-5"), std::string::npos);
}

TEST(Csv, FaultsAreErrorsWithTheirLine) {
  EXPECT_EQ(bad_csv("1,2\n3,4\n").line, 1);
  EXPECT_NE(bad_csv("1,2\n3,4\n").message.find("header"), std::string::npos);
  EXPECT_EQ(bad_csv("\nlat,height\n1,2\n").line, 2);
  EXPECT_EQ(bad_csv("lat,lon,Latitude\n1,2,3\n").line, 1);
  EXPECT_EQ(bad_csv("lat,lon\n1,2\n3,four\n").line, 3);
  EXPECT_EQ(bad_csv("lat,lon,h\n1,2,3\n1,2\n").line, 3);
  EXPECT_EQ(bad_csv("lat,lon\n1,2\n\xFF\xFE,2\n").line, 3);
  EXPECT_EQ(bad_csv("lat,lon\nnan,nan\n").code, ErrorCode::kData);
  EXPECT_EQ(bad_csv("lat,lon\n").code, ErrorCode::kData);
  EXPECT_EQ(bad_csv("\n\n").code, ErrorCode::kParse);
}

constexpr const char* kGpx = R"(<?xml version="1.0"?>
<gpx xmlns="http://www.topografix.com/GPX/1/1" version="1.1">
 <wpt lat="1" lon="1"/>
 <trk><name>Way</name>
  <trkseg><trkpt lat="1" lon="2"><ele>3</ele></trkpt>
   <trkpt lat="4" lon="5"/></trkseg>
  <trkseg><trkpt lat="nan" lon="2"/><trkpt lat="7" lon="8"/></trkseg>
 </trk>
 <rte><rtept lat="9" lon="10"/></rte>
</gpx>)";

TEST(Gpx, SegmentsAndRoutesBecomeTracks) {
  Diagnostics diagnostics;
  const auto tracks = parse_gpx(kGpx, "t.gpx", {}, diagnostics);
  ASSERT_TRUE(tracks.ok());
  ASSERT_EQ(tracks->size(), 3u);
  const Track& first = (*tracks)[0];
  EXPECT_EQ(first.name, "Way segment 1");
  EXPECT_EQ(first.element, "track 1 segment 1");
  EXPECT_TRUE(first.recorded);
  EXPECT_EQ(first.points[0].x, 2);
  EXPECT_EQ(first.points[0].height_m, 3);
  EXPECT_FALSE(first.points[1].height_m.has_value());
  EXPECT_EQ(first.points[1].line, 6);
  EXPECT_EQ((*tracks)[1].points.size(), 1u);
  EXPECT_EQ((*tracks)[2].element, "route 1");
  EXPECT_FALSE((*tracks)[2].recorded);
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].line, 7);
}

// Of a point, else of the track that it belongs to; in extensions of any namespace.
TEST(Gpx, FieldsThatAreNamedAreElements) {
  const std::string text = R"(<gpx xmlns:r="urn:r"><trk><name>t</name><desc>Ring</desc>
<extensions><r:Road><r:LANES>3</r:LANES><r:Width>9</r:Width></r:Road></extensions>
<trkseg><trkpt lat="1" lon="2"><ele>3</ele><extensions><r:width>10.5</r:width><r:h>310</r:h></extensions></trkpt>
<trkpt lat="4" lon="5"><ele>6</ele></trkpt><trkpt lat="4" lon="6"><extensions><r:h>high</r:h></extensions></trkpt></trkseg>
</trk></gpx>)";
  Diagnostics diagnostics;
  FieldNames fields{.width = "width", .lanes = "lanes", .height = "h", .name = "desc"};
  const auto tracks = parse_gpx(text, "t.gpx", fields, diagnostics);
  ASSERT_TRUE(tracks.ok()) << tracks.error().text();
  const Track& track = tracks->front();
  EXPECT_EQ(track.name, "Ring");
  EXPECT_EQ(track.lanes, 3);
  EXPECT_EQ(track.points[0].width_m, 10.5);
  EXPECT_EQ(track.points[1].width_m, 9);
  EXPECT_EQ(track.points[0].height_m, 310);
  EXPECT_EQ(track.points[1].height_m, 6);
  EXPECT_FALSE(track.points[2].height_m.has_value());
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_EQ(diagnostics[0].line, 4);
  fields.lanes = "spuren";
  const auto none = parse_gpx(text, "t.gpx", fields, diagnostics);
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kData);
  EXPECT_NE(none.error().message.find("'spuren'"), std::string::npos);
}

TEST(Gpx, FaultsAreErrorsWithTheirLine) {
  const auto line_of = [](const std::string& text) {
    Diagnostics diagnostics;
    const auto tracks = parse_gpx(text, "t.gpx", {}, diagnostics);
    EXPECT_FALSE(tracks.ok()) << text;
    return tracks.ok() ? -1 : tracks.error().line;
  };
  const std::string good = kGpx;
  EXPECT_EQ(line_of(good.substr(0, good.find("</trkseg>\n  <trkseg>"))), 6);
  EXPECT_EQ(line_of("<gpx><trk><trkseg>\n<trkpt lat=\"1\"/></trkseg></trk></gpx>"), 2);
  EXPECT_EQ(line_of("<gpx><trk><trkseg>\n<trkpt lat=\"1\" lon=\"2,5\"/></trkseg></trk></gpx>"), 2);
  EXPECT_EQ(line_of("<kml/>"), 1);
  EXPECT_EQ(line_of("<gpx/>"), 0);
}

TEST(Vector, GeoJsonLinesKeepIdNameAndHeights) {
  const test::TemporaryFolder folder;
  const std::string path = folder.put("a.geojson", R"({"type":"FeatureCollection","features":[
    {"type":"Feature","properties":{"ID":"x-1","Name":"Ring"},"geometry":{"type":"LineString","coordinates":[[1,2,3],[4,5,6]]}},
    {"type":"Feature","properties":{},"geometry":{"type":"MultiLineString","coordinates":[[[1,2],[4,5]],[[7,8],[9,10]]]}},
    {"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[1,2]}}]})");
  Diagnostics diagnostics;
  const auto tracks = read_vector(path, {}, diagnostics);
  ASSERT_TRUE(tracks.ok()) << tracks.error().text();
  ASSERT_EQ(tracks->size(), 3u);
  EXPECT_EQ((*tracks)[0].element, "x-1");
  EXPECT_EQ((*tracks)[0].name, "Ring");
  EXPECT_EQ((*tracks)[0].points[1].x, 4);
  EXPECT_EQ((*tracks)[0].points[1].y, 5);
  EXPECT_EQ((*tracks)[0].points[1].height_m, 6);
  EXPECT_NE((*tracks)[2].element.find("part 2"), std::string::npos);
  EXPECT_FALSE((*tracks)[2].points[0].height_m.has_value());
  ASSERT_EQ(diagnostics.size(), 1u);
  EXPECT_NE(diagnostics[0].message.find("1 features"), std::string::npos);
}

TEST(Vector, OtherCoordinateSystemsBecomeWgs84) {
  const test::TemporaryFolder folder;
  // UTM zone 32 north, on its central meridian.
  const std::string path = folder.put("utm.geojson", R"({"type":"FeatureCollection",
    "crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::32632"}},
    "features":[{"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[500000,5000000],[500000,5001000]]}}]})");
  Diagnostics diagnostics;
  const auto tracks = read_vector(path, {}, diagnostics);
  ASSERT_TRUE(tracks.ok()) << tracks.error().text();
  EXPECT_TRUE((*tracks)[0].geodetic);
  EXPECT_NEAR((*tracks)[0].points[0].x, 9, 1e-9);
  EXPECT_NEAR((*tracks)[0].points[0].y, 45.15, 0.01);
}

TEST(Vector, KmlIsRead) {
  const test::TemporaryFolder folder;
  const std::string path = folder.put("a.kml", R"(<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>Pass</name>
<LineString><coordinates>1,2,3 4,5,6</coordinates></LineString></Placemark></Document></kml>)");
  Diagnostics diagnostics;
  const auto tracks = read_vector(path, {}, diagnostics);
  ASSERT_TRUE(tracks.ok()) << tracks.error().text();
  EXPECT_EQ((*tracks)[0].name, "Pass");
  EXPECT_EQ((*tracks)[0].points[1].y, 5);

  // Its fields stand in a schema.
  const std::string with_fields = folder.put("b.kml", R"(<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Schema name="roads" id="roads"><SimpleField name="LANES" type="int"/>
<SimpleField name="WIDTH_M" type="float"/><SimpleField name="H" type="float"/><SimpleField name="STREET" type="string"/></Schema>
<Folder><name>roads</name><Placemark><name>x</name><ExtendedData><SchemaData schemaUrl="#roads">
<SimpleData name="LANES">3</SimpleData><SimpleData name="WIDTH_M">10.5</SimpleData><SimpleData name="H">310</SimpleData>
<SimpleData name="STREET">Ring</SimpleData></SchemaData></ExtendedData>
<LineString><coordinates>9,45 9,45.01</coordinates></LineString></Placemark></Folder></Document></kml>)");
  const FieldNames fields{.width = "width_m", .lanes = "lanes", .height = "h", .name = "street"};
  const auto roads = read_vector(with_fields, fields, diagnostics);
  ASSERT_TRUE(roads.ok()) << roads.error().text();
  EXPECT_EQ(roads->front().name, "Ring");
  EXPECT_EQ(roads->front().lanes, 3);
  EXPECT_EQ(roads->front().points[0].width_m, 10.5);
  EXPECT_EQ(roads->front().points[0].height_m, 310);
}

TEST(Vector, ShapefilesAndGeoPackagesAreReadWithTheirFields) {
  GDALAllRegister();
  const test::TemporaryFolder folder;
  const std::pair<const char*, const char*> kinds[] = {{"ESRI Shapefile", "a.shp"}, {"GPKG", "a.gpkg"}};
  for (const auto& [driver, file] : kinds) {
    SCOPED_TRACE(driver);
    const std::string path = folder.path(file);
    GDALDataset* const dataset =
        GetGDALDriverManager()->GetDriverByName(driver)->Create(path.c_str(), 0, 0, 0, GDT_Unknown, nullptr);
    ASSERT_NE(dataset, nullptr);
    OGRSpatialReference utm;
    utm.SetWellKnownGeogCS("WGS84");
    utm.SetUTM(32);
    OGRLayer* const layer = dataset->CreateLayer("roads", &utm, wkbLineString25D);
    OGRFieldDefn lanes("LANES", OFTInteger), width("WIDTH_M", OFTReal), name("STREET", OFTString);
    for (OGRFieldDefn* field : {&lanes, &width, &name}) ASSERT_EQ(layer->CreateField(field), OGRERR_NONE);
    OGRFeature feature(layer->GetLayerDefn());
    feature.SetField("LANES", 3);
    feature.SetField("WIDTH_M", 10.5);
    feature.SetField("STREET", "Ring");
    OGRLineString line;
    line.addPoint(500000, 5000000, 310);
    line.addPoint(500000, 5001000, 320);
    feature.SetGeometry(&line);
    ASSERT_EQ(layer->CreateFeature(&feature), OGRERR_NONE);
    GDALClose(dataset);

    Diagnostics diagnostics;
    const FieldNames fields{.width = "width_m", .lanes = "lanes", .height = {}, .name = "street"};
    const auto tracks = read_tracks(path, fields, diagnostics);
    ASSERT_TRUE(tracks.ok()) << tracks.error().text();
    for (const Diagnostic& d : diagnostics) ADD_FAILURE() << d.text();
    ASSERT_EQ(tracks->size(), 1u);
    const Track& track = tracks->front();
    EXPECT_TRUE(track.geodetic);
    EXPECT_EQ(track.name, "Ring");
    EXPECT_EQ(track.lanes, 3);
    ASSERT_EQ(track.points.size(), 2u);
    EXPECT_NEAR(track.points[0].x, 9, 1e-9);
    EXPECT_EQ(track.points[1].height_m, 320);
    EXPECT_EQ(track.points[1].width_m, 10.5);
  }
}

TEST(Vector, WhatGdalCannotReadIsAnError) {
  const test::TemporaryFolder folder;
  Diagnostics diagnostics;
  const std::string cut =
      R"({"type":"FeatureCollection","features":[{"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[1,2],[3)";
  for (const std::string& text : {cut, std::string("not json"), std::string("{}"),
                                  std::string(R"({"type":"FeatureCollection","features":[]})")}) {
    const auto tracks = read_vector(folder.put("bad.geojson", text), {}, diagnostics);
    ASSERT_FALSE(tracks.ok()) << text;
    EXPECT_EQ(tracks.error().file, folder.path("bad.geojson"));
  }
}

}  // namespace
}  // namespace roadgen
