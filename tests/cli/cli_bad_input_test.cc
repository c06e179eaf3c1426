// Bad input: the exit code is right, stderr is one line that names the file, and no output file is left.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/cli/run_program.h"

namespace {

using roadgen::test::Outcome;
using roadgen::test::TemporaryFolder;

void expect_one_line(const Outcome& run, int code, const std::string& names, const std::string& says) {
  SCOPED_TRACE(run.err);
  EXPECT_EQ(run.code, code);
  EXPECT_EQ(run.out, "");
  ASSERT_EQ(run.error_lines().size(), 1u);
  EXPECT_NE(run.err.find(": error: "), std::string::npos);
  EXPECT_NE(run.err.find(names), std::string::npos);
  EXPECT_NE(run.err.find(says), std::string::npos);
}

constexpr const char* kGoodCsv = "lat,lon\n50,11\n50.001,11\n50.002,11.0001\n";

// Imports source; the folder must hold the same files after it as before.
void expect_refused(const TemporaryFolder& folder, const std::string& source, const std::string& says) {
  const std::size_t before = folder.count();
  const Outcome run =
      roadgen::test::roadgen({"import", source, "-o", folder.path("net.xodr"), "--report", folder.path("r.json")});
  expect_one_line(run, 1, source, says);
  EXPECT_EQ(folder.count(), before);
}

TEST(BadInput, MissingFileFolderAndUnknownKind) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("roads.csv"));
  expect_refused(folder, folder.path("none.csv"), "no such file");
  expect_refused(folder, folder.path("none.xyz"), "no such file");
  expect_refused(folder, folder.path("roads.csv"), "folder");
  expect_refused(folder, folder.path("."), "folder");
  expect_refused(folder, folder.put("roads.png", "x"), ".csv");
  expect_refused(folder, folder.put("roads", kGoodCsv), ".csv");
}

TEST(BadInput, EmptyFiles) {
  const TemporaryFolder folder;
  for (const char* name : {"e.csv", "e.geojson", "e.gpx", "e.kml", "e.shp", "e.gpkg"}) {
    expect_refused(folder, folder.put(name, ""), "empty");
  }
  expect_refused(folder, folder.put("b.csv", "\n\n"), "no header");
  expect_refused(folder, folder.put("h.csv", "lat,lon\n"), "no points");
}

TEST(BadInput, TruncatedFiles) {
  const TemporaryFolder folder;
  expect_refused(folder, folder.put("t.csv", "lat,lon,height\n50,11,1\n50.1,11"), ":3: ");
  expect_refused(folder, folder.put("t.gpx", "<gpx><trk><trkseg><trkpt lat=\"1\" lon=\"2\"/>\n<trkpt lat=\"1\""),
                 ":2: ");
  expect_refused(
      folder,
      folder.put("t.geojson", "{\"type\":\"FeatureCollection\",\"features\":[{\"type\":\"Feature\",\"geometry\":{"),
      "truncated");
  expect_refused(
      folder,
      folder.put("t.kml", "<?xml version=\"1.0\"?><kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Placemark>"),
      "t.kml");
}

TEST(BadInput, NotText) {
  const TemporaryFolder folder;
  const std::string binary("lat,lon\n50,11\n\xFF\x00\x01", 17);
  for (const char* name : {"b.csv", "b.geojson", "b.gpx", "b.kml"})
    expect_refused(folder, folder.put(name, binary), ":3: is not UTF-8");
  for (const char* name : {"b.shp", "b.gpkg"}) expect_refused(folder, folder.put(name, binary), "cannot be read");
}

TEST(BadInput, PositionsThatAreNone) {
  const TemporaryFolder folder;
  expect_refused(folder, folder.put("r.csv", "lat,lon\n50,11\n91,11\n"), ":3: ");
  expect_refused(folder, folder.put("w.csv", "lat,lon\n11.0,-105\n-105.1,38.9\n"), "swapped");
  expect_refused(folder, folder.put("l.csv", "lat,lon\n50,11\n50,190\n"), "longitude");
  expect_refused(folder, folder.put("u.csv", "lat,lon\n5000000,500000\n5000100,500000\n"), "not in degrees");
  expect_refused(folder,
                 folder.put("s.geojson", "{\"type\":\"LineString\",\"coordinates\":[[43.7,-107.4],[43.8,-107.5]]}"),
                 "swapped");
  expect_refused(folder, folder.put("n.csv", "lat,lon\nnan,nan\nnan,11\n"), "no points");
  expect_refused(folder, folder.put("t.csv", "lat,lon\n50,11\n50,east\n"), "'east' is not a number");
  expect_refused(folder, folder.put("h.csv", "50,11\n50.1,11\n"), "header");
}

TEST(BadInput, TooFewPoints) {
  const TemporaryFolder folder;
  expect_refused(folder, folder.put("1.csv", "lat,lon\n50,11\n"), "1 distinct points");
  expect_refused(folder, folder.put("2.csv", "lat,lon\n50,11\n50,11\n50,11\n"), "1 distinct points");
  expect_refused(folder, folder.put("1.gpx", "<gpx><trk><trkseg><trkpt lat=\"1\" lon=\"2\"/></trkseg></trk></gpx>"),
                 "1 distinct points");
  expect_refused(folder, folder.put("0.gpx", "<gpx/>"), "no track");
  expect_refused(folder, folder.put("p.geojson", "{\"type\":\"Point\",\"coordinates\":[1,2]}"), "no line");
}

TEST(BadInput, OneBadFileAmongGoodOnesStopsTheImport) {
  const TemporaryFolder folder;
  const std::string good = folder.put("good.csv", kGoodCsv), bad = folder.put("bad.csv", "lat,lon\n50,x\n");
  const std::string metres = folder.put("metres.csv", "x,y\n0,0\n100,0\n");
  expect_one_line(roadgen::test::roadgen({"import", good, bad, "-o", folder.path("net.xodr")}), 1, bad, ":2: ");
  expect_one_line(roadgen::test::roadgen({"import", good, metres, "-o", folder.path("net.xodr")}), 1, metres, "metres");
  EXPECT_EQ(folder.count(), 3u);
}

TEST(BadInput, OutputThatCannotBeWritten) {
  const TemporaryFolder folder;
  const std::string source = folder.put("good.csv", kGoodCsv);
  std::filesystem::create_directory(folder.path("sub"));
  for (const std::string& output :
       {folder.path("none/net.xodr"), source + "/net.xodr", folder.path("sub"), std::string("/dev/full")}) {
    expect_one_line(roadgen::test::roadgen({"import", source, "-o", output}), 1, output, "cannot be written");
    const std::string net = folder.path("net.xodr");
    expect_one_line(roadgen::test::roadgen({"import", source, "-o", net, "--report", output}), 1, output,
                    "cannot be written");
    EXPECT_FALSE(std::filesystem::exists(net));
  }
  expect_one_line(roadgen::test::roadgen({"import", source, "-o", source}), 2, source, "another output");
  EXPECT_EQ(roadgen::test::text_of(source), kGoodCsv);
  const std::string both = folder.path("both");
  expect_one_line(roadgen::test::roadgen({"import", source, "-o", both, "--report", both}), 2, both, "two files");
  EXPECT_EQ(folder.count(), 2u);
}

TEST(BadInput, AFailureLeavesTheOldOutputAlone) {
  const TemporaryFolder folder;
  const std::string net = folder.put("net.xodr", "old"), bad = folder.put("bad.csv", "lat,lon\n50,x\n");
  EXPECT_EQ(roadgen::test::roadgen({"import", bad, "-o", net}).code, 1);
  EXPECT_EQ(roadgen::test::text_of(net), "old");
}

TEST(BadInput, WrongUsageExitsWithTwo) {
  const TemporaryFolder folder;
  const std::string source = folder.put("good.csv", kGoodCsv), metres = folder.put("m.csv", "x,y\n0,0\n100,0\n");
  const std::string net = folder.path("net.xodr");
  const std::vector<std::vector<std::string>> lines = {{},
                                                       {"paint"},
                                                       {"import"},
                                                       {"import", source},
                                                       {"import", "-o", net},
                                                       {"import", source, "-o", net, "--colour"},
                                                       {"import", source, "-o", net, "--max-error", "0"},
                                                       {"import", source, "-o", net, "--max-error", "nan"},
                                                       {"import", source, "-o", net, "--max-error", "much"},
                                                       {"import", source, "-o", net, "--width", "-3"},
                                                       {"import", source, "-o", net, "--tangents", "straight"},
                                                       {"import", source, "-o", net, "--closed", "maybe"},
                                                       {"import", source, "-o", net, "--origin", "50"},
                                                       {"import", source, "-o", net, "--origin", "91,11"},
                                                       {"import", source, "-o", net, "--origin", "50,11,nan"},
                                                       {"import", source, "-o", net, "--origin", "50;11"},
                                                       {"import", metres, "-o", net, "--origin", "50,11"},
                                                       {"info"},
                                                       {"check"},
                                                       {"info", source, source}};
  for (const std::vector<std::string>& line : lines) {
    expect_one_line(roadgen::test::roadgen(line), 2, "roadgen", "");
  }
  EXPECT_FALSE(std::filesystem::exists(net));
}

TEST(BadInput, NetworksThatAreNone) {
  const TemporaryFolder folder;
  for (const char* command : {"info", "check"}) {
    expect_one_line(roadgen::test::roadgen({command, folder.path("none.xodr")}), 1, "none.xodr", "no such file");
    expect_one_line(roadgen::test::roadgen({command, folder.path(".")}), 1, "folder", "name a file");
    expect_one_line(roadgen::test::roadgen({command, folder.put("e.xodr", "")}), 1, "e.xodr", "empty");
    expect_one_line(roadgen::test::roadgen({command, folder.put("t.xodr", "<OpenDRIVE>\n<header")}), 1, "t.xodr:2",
                    "XML");
    expect_one_line(roadgen::test::roadgen({command, folder.put("b.xodr", "\xFF\xFE")}), 1, "b.xodr:1", "UTF-8");
    expect_one_line(roadgen::test::roadgen({command, folder.put("x.xodr", "<html/>")}), 1, "x.xodr", "OpenDRIVE");
  }
}

}  // namespace
