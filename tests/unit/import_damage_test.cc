// Files damaged at random: every reader gives a value or an error, and a network that is read can be checked
// and written. Assertions are on in the dev preset; run it under the asan preset too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <random>

#include "roadgen/export/opendrive.h"
#include "roadgen/import/csv.h"
#include "roadgen/import/gpx.h"
#include "roadgen/import/import.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/import/osm_file.h"
#include "roadgen/import/text_file.h"
#include "tests/common/osm_city.h"
#include "tests/osm_text.h"
#include "tests/temporary_folder.h"

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

// One to four digits changed into odd numbers: well-formed files with odd values.
std::string with_odd_numbers(std::string text, std::mt19937& random) {
  static const char* const kOdd[] = {"0", "-1", "9", "1e3", "1e-7", "1e8", "-2e5", ".5"};
  for (unsigned i = 0; i < 1 + random() % 4; ++i) {
    std::size_t at = random() % text.size();
    while (!std::isdigit(static_cast<unsigned char>(text[at]))) at = (at + 1) % text.size();
    text.replace(at, 1, kOdd[random() % std::size(kOdd)]);
  }
  return text;
}

// Every element that the reader knows.
const char* const kForeign = R"(<OpenDRIVE><header revMajor="1" revMinor="7"/>
<road id="1" length="90" junction="5"><planView>
<geometry s="0" x="0" y="0" hdg="0" length="20"><line/></geometry>
<geometry s="20" x="20" y="0" hdg="0" length="20"><spiral curvStart="0" curvEnd="0.02"/></geometry>
<geometry s="40" x="39.9" y="1.3" hdg="0.2" length="20"><arc curvature="0.02"/></geometry>
<geometry s="60" x="57" y="9" hdg="0.6" length="10"><poly3 a="0" b="0" c="0.01" d="-0.0003"/></geometry>
<geometry s="70" x="65" y="15" hdg="0.7" length="20"><paramPoly3 aU="0" bU="20" cU="0" dU="-1" aV="0" bV="0" cV="3"
dV="-1" pRange="normalized"/></geometry></planView>
<elevationProfile><elevation s="0" a="1" b="0.1" c="0" d="0"/><elevation s="33" a="4.3" b="0.1" c="-0.001" d="1e-05"/>
</elevationProfile><lateralProfile><superelevation s="0" a="0" b="0" c="0" d="0"/>
<superelevation s="25" a="0" b="0.002" c="0" d="0"/><crossfall side="left" s="5" a="0.02" b="0" c="0" d="0"/>
<shape s="0" t="-4" a="0.1" b="-0.02" c="0" d="0"/><shape s="50" t="0" a="0" b="0.02" c="0.001" d="0"/></lateralProfile>
<lanes><laneOffset s="0" a="0" b="0" c="0" d="0"/><laneOffset s="45" a="0" b="0.01" c="0" d="0"/>
<laneSection s="0"><left><lane id="1" type="driving"><border sOffset="0" a="3" b="0.01" c="0" d="0"/></lane></left>
<center><lane id="0" type="none"><roadMark sOffset="0" type="solid broken" weight="bold" color="yellow"/></lane></center>
<right><lane id="-1" type="bus"><width sOffset="0" a="3" b="0" c="0" d="0"/><width sOffset="9" a="3" b="0.1" c="0" d="0"/>
<roadMark sOffset="0" type="broken"><type name="x" width="0.1"><line length="3" space="6" tOffset="0" width="0.1"/></type>
</roadMark><material sOffset="0" surface="gravel" friction="1"/></lane>
<lane id="-2" type="sidewalk"><width sOffset="0" a="2" b="0" c="0" d="0"/><height sOffset="1" inner="0.1" outer="0.1"/>
</lane></right></laneSection><laneSection s="60" singleSide="true"><right><lane id="-1" type="driving">
<width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
<objects><object type="crosswalk" s="20" t="0" hdg="1.57" length="7" width="3"/>
<object type="roadMark" subtype="arrowLeft" s="30" t="-1" orientation="-"><outline><cornerLocal u="1" v="1"/>
<cornerRoad s="33" t="2"/></outline></object></objects>
<signals><signal type="294" s="40" t="-3" orientation="+"><validity fromLane="-1" toLane="-1"/></signal></signals>
</road></OpenDRIVE>)";

// Reads the text in many damaged forms: what is read is finite, is written, and comes back as the same file.
void expect_network_or_error(const std::string& whole, unsigned seed, int rounds) {
  ASSERT_TRUE(parse_opendrive(whole, "f").ok()) << parse_opendrive(whole, "f").error().text();
  std::mt19937 random(seed);
  int good = 0;
  for (int i = 0; i < rounds; ++i) {
    Diagnostics diagnostics;
    const std::string text = i % 2 == 0 ? damaged(whole, random) : with_odd_numbers(whole, random);
    const Result<Network> read = parse_opendrive(text, "f", &diagnostics);
    if (!read) {
      EXPECT_EQ(read.error().file, "f");
      continue;
    }
    ++good;
    (void)check(*read);
    (void)bounds(*read);
    for (const Road& road : read->roads) ASSERT_TRUE(is_finite(road)) << text;
    const Result<std::string> written = opendrive_text(*read);
    ASSERT_TRUE(written.ok()) << written.error().text() << text;
    const Result<Network> again = parse_opendrive(*written, "g");
    ASSERT_TRUE(again.ok()) << again.error().text() << text;
    EXPECT_TRUE(*opendrive_text(*again) == *written) << text;
  }
  EXPECT_GT(good, rounds / 20);
  EXPECT_LT(good, rounds);
}

TEST(Damage, EveryElementOfOpenDriveGivesANetworkThatIsWrittenOrAnError) {
  expect_network_or_error(kForeign, 3, kRounds);
}

// Three roads that meet, the ways between them, structures beside them: another program's file.
std::string foreign_junction() {
  std::string text = "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/>\n", connections;
  const auto road = [&](const std::string& id, const char* junction, const char* links, double x, double y,
                        double heading, double length, const char* shape, const char* objects) {
    char place[200];
    std::snprintf(place, sizeof place, "<geometry s=\"0\" x=\"%.9g\" y=\"%.9g\" hdg=\"%.12g\" length=\"%.12g\">", x, y,
                  heading, length);
    const std::string width = "<width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/></lane>";
    const std::string walk = "<lane id=\"-2\" type=\"sidewalk\"><link/>" + width;
    text += "<road id=\"" + id + "\" junction=\"" + junction + "\"><link>" + links + "</link><planView>" + place +
            shape + "</geometry></planView><lanes><laneSection s=\"0\"><left><lane id=\"1\" type=\"driving\">" + width +
            "</left><right><lane id=\"-1\" type=\"driving\"><link><successor id=\"-1\"/></link>" + width +
            (*junction == '-' ? walk : "") + "</right></laneSection></lanes>" + objects + "</road>\n";
  };
  const std::string rail =
      "<objects><object type=\"barrier\" name=\"guardRail\" s=\"1\" t=\"5\"><repeat s=\"5\" length=\"30\" "
      "tStart=\"5\" tEnd=\"6\" heightStart=\"0.8\"/></object><tunnel s=\"10\" length=\"20\"/></objects>";
  for (int i = 0; i < 3; ++i) {
    const double angle = 2 * M_PI * i / 3, turn = M_PI / 3;
    road(std::to_string(i), "-1", "<successor elementType=\"junction\" elementId=\"9\"/>", 65 * std::cos(angle),
         65 * std::sin(angle), angle + M_PI, 50, "<line/>", i == 0 ? rail.c_str() : "");
    const std::string id = "w" + std::to_string(i), next = std::to_string((i + 1) % 3);
    const std::string links = "<predecessor elementType=\"road\" elementId=\"" + std::to_string(i) +
                              "\" contactPoint=\"end\"/><successor elementType=\"road\" elementId=\"" + next +
                              "\" contactPoint=\"end\"/>";
    const double radius = 15 * std::tan(M_PI / 3);
    const std::string arc = "<arc curvature=\"" + std::to_string(-1 / radius) + "\"/>";
    road(id, "9", links.c_str(), 15 * std::cos(angle), 15 * std::sin(angle), angle + M_PI, radius * turn, arc.c_str(),
         "");
    connections += "<connection id=\"" + next + "\" incomingRoad=\"" + std::to_string(i) + "\" connectingRoad=\"" + id +
                   "\" contactPoint=\"start\"><laneLink from=\"-1\" to=\"-1\"/></connection>";
  }
  return text + "<junction id=\"9\" name=\"n\">" + connections + "</junction></OpenDRIVE>";
}

TEST(Damage, JunctionsAndStructuresGiveANetworkThatIsWrittenOrAnError) {
  const std::string foreign = foreign_junction();
  const Result<Network> network = parse_opendrive(foreign, "f");
  ASSERT_TRUE(network.ok());
  ASSERT_EQ(network->junctions.size(), 1u);
  ASSERT_EQ(network->roads[0].sweeps.size(), 2u);
  expect_network_or_error(foreign, 4, kRounds / 2);
  expect_network_or_error(*opendrive_text(*network), 5, kRounds / 2);
}

TEST(Damage, TablesAndTracksGiveFinitePointsOrAnError) {
  const std::string csv = "lat,lon,height,width\n50,11,300,7\n50.001,11.002,301,7\n50.002,11.003,302.5,8\n";
  const std::string gpx =
      "<gpx><trk><name>a</name><trkseg><trkpt lat=\"50\" lon=\"11\"><ele>3</ele></trkpt><trkpt lat=\"51\" "
      "lon=\"12\"/></trkseg></trk><rte><rtept lat=\"1\" lon=\"2\"/></rte></gpx>";
  std::mt19937 random(2);
  for (int i = 0; i < kRounds; ++i) {
    Diagnostics diagnostics;
    for (const auto& tracks : {parse_csv(damaged(csv, random), "f", {}, diagnostics),
                               parse_gpx(damaged(gpx, random), "f", {}, diagnostics)}) {
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

TEST(Damage, OpenStreetMapGivesANetworkOrAnError) {
  const test::TemporaryFolder folder;
  std::mt19937 random(4);
  for (const char* name : {"city.osm", "city.osm.gz", "city.osm.pbf"}) {
    const std::string path = folder.path(name);
    ASSERT_GT(test::write_osm_city(path, 12), 10u);
    const std::string whole = test::text_of(path);
    ASSERT_TRUE(import_files({path}, {}).ok());
    int good = 0, bad = 0;
    for (int i = 0; i < kRounds / 10; ++i) {
      // Compressed files are hardly ever read at all.
      folder.put(name, i % 2 == 0 && path.ends_with(".osm") ? with_odd_numbers(whole, random) : damaged(whole, random));
      const Result<ImportResult> result = import_files({path}, {});
      ++(result ? good : bad);
      if (!result) {
        EXPECT_EQ(result.error().file, path);
        EXPECT_EQ(result.error().text().find('\n'), std::string::npos);
        continue;
      }
      for (const Road& road : result->network.roads) ASSERT_TRUE(is_finite(road));
      EXPECT_TRUE(check(result->network).ok()) << check(result->network).problems.front();
    }
    EXPECT_GT(bad, 0) << name;
    std::printf("%s: %d read, %d errors\n", name, good, bad);
  }
}

TEST(Damage, FilesOfOpenStreetMapThatAreCutShortAreErrors) {
  const test::TemporaryFolder folder;
  for (const char* name : {"city.osm", "city.osm.gz", "city.osm.pbf"}) {
    const std::string path = folder.path(name);
    ASSERT_GT(test::write_osm_city(path, 12), 10u);
    const std::string whole = test::text_of(path);
    for (std::size_t part = 0; part < 40; ++part) {
      folder.put(name, whole.substr(0, whole.size() * part / 40));
      const Result<ImportResult> result = import_files({path}, {});
      EXPECT_FALSE(result.ok()) << name << " " << part;
      if (result) continue;
      EXPECT_EQ(result.error().file, path);
      EXPECT_EQ(result.error().text().find('\n'), std::string::npos);
    }
  }
}

// Blocks of a PBF file: four bytes of length, most significant first, a header of that length, which names the length
// of the blob that follows.
TEST(Damage, BrokenBlocksOfPbfAreErrors) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("city.osm.pbf");
  ASSERT_GT(test::write_osm_city(path, 12), 10u);
  const std::string whole = test::text_of(path);
  std::mt19937 random(5);
  const auto expect_error = [&](const std::string& bytes, const char* what) {
    folder.put("city.osm.pbf", bytes);
    const Result<ImportResult> result = import_files({path}, {});
    EXPECT_FALSE(result.ok()) << what;
    if (!result) {
      EXPECT_EQ(result.error().text().find('\n'), std::string::npos);
    }
  };
  for (const unsigned char byte : {0x00, 0x01, 0x7F, 0xFF}) {
    for (std::size_t at = 0; at < 4; ++at) {
      std::string broken = whole;
      if (static_cast<unsigned char>(broken[at]) == byte) continue;
      broken[at] = static_cast<char>(byte);
      expect_error(broken, "the first block's length");
    }
  }
  for (int i = 0; i < 200; ++i) {
    std::string broken = whole;
    const std::size_t at = random() % whole.size(), count = std::min<std::size_t>(64, whole.size() - at);
    for (std::size_t k = 0; k < count; ++k) broken[at + k] = static_cast<char>(random());
    expect_error(broken, "a stretch of noise");
    broken = whole;
    broken.erase(at, count);
    expect_error(broken, "a stretch left out");
  }
}

// A well-formed town whose ways lack nodes, touch and repeat themselves, and have odd tags.
test::OsmText odd_town(std::mt19937& random) {
  const auto pick = [&](std::size_t count) { return static_cast<std::size_t>(random() % count); };
  static const char* const kClass[] = {"motorway", "motorway_link", "primary", "residential", "service", "track"};
  static const std::pair<const char*, const char*> kTags[] = {
      {"bridge", "yes"},          {"tunnel", "yes"},    {"layer", "-2"}, {"layer", "1"},
      {"oneway", "yes"},          {"oneway", "-1"},     {"lanes", "0"},  {"lanes", "7"},
      {"lanes", "1e9"},           {"width", "0.1"},     {"width", "80"}, {"width", "nan"},
      {"junction", "roundabout"}, {"sidewalk", "both"}, {"layer", "99"}, {"lanes:backward", "3"},
      {"surface", "gravel"},      {"name", "A &lt; B"}};
  constexpr long kNodes = 30;
  test::OsmText town;
  std::vector<glm::dvec2> places;
  for (long id = 1; id <= kNodes; ++id) {
    glm::dvec2 p(static_cast<double>(pick(400)), static_cast<double>(pick(400)));
    if (!places.empty() && pick(5) == 0) p = places[pick(places.size())] + glm::dvec2(pick(2), 0);
    places.push_back(p);
    if (pick(10) > 0) town.node(id, p.x, p.y);
  }
  for (long id = 100; id < 112; ++id) {
    std::vector<long> nodes;
    for (std::size_t k = 2 + pick(8); k > 0; --k) {
      nodes.push_back(pick(4) > 0 || nodes.empty() ? 1 + static_cast<long>(pick(kNodes)) : nodes[pick(nodes.size())]);
    }
    test::Tags tags = {{"highway", kClass[pick(std::size(kClass))]}};
    for (std::size_t k = pick(4); k > 0; --k) tags.push_back(kTags[pick(std::size(kTags))]);
    town.way(pick(15) == 0 ? 100 : id, nodes, tags);
  }
  return town;
}

TEST(Damage, OddTownsAreSoundNetworksThatComeBackFromTheirFiles) {
  const test::TemporaryFolder folder;
  std::mt19937 random(6);
  std::size_t areas = 0;
  for (int i = 0; i < 300; ++i) {
    SCOPED_TRACE(i);
    const std::string text = odd_town(random).text();
    const Result<ImportResult> result = import_files({folder.put("town.osm", text)}, {});
    ASSERT_TRUE(result.ok()) << result.error().text();
    const Network& network = result->network;
    areas += network.junctions.size();
    for (const Road& road : network.roads) ASSERT_TRUE(is_finite(road));
    EXPECT_TRUE(check(network).ok()) << check(network).problems.front() << text;
    const Result<std::string> written = opendrive_text(network);
    ASSERT_TRUE(written.ok()) << written.error().text() << text;
    const Result<Network> again = parse_opendrive(*written, "g");
    ASSERT_TRUE(again.ok()) << again.error().text() << text;
    EXPECT_EQ(again->junctions.size(), network.junctions.size());
    EXPECT_TRUE(*opendrive_text(*again) == *written) << text;
  }
  EXPECT_GT(areas, 300u);
}

// What broke a reader once, and the like: see tests/fuzz.
TEST(Damage, FilesThatBrokeReadersAreReadOrRefused) {
  const std::filesystem::path corpus = std::string(ROADGEN_SOURCE_DIR) + "/tests/fuzz/corpus";
  const test::TemporaryFolder folder;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const std::string path = entry.path(), kind = entry.path().parent_path().filename();
    if (kind == "opendrive") {
      const auto network = read_opendrive(path);
      if (network) (void)check(*network);
    } else {
      const auto result = import_files({path}, {});
      EXPECT_TRUE(result.ok() || !result.error().message.empty()) << path;
    }
  }
  EXPECT_GT(files, 15u);
}

constexpr const char* kOneRoad =
    R"(<OpenDRIVE><header revMajor="1" revMinor="4"/><road name="&l9;" id="1" length="10" junction="-1"><planView>
<geometry s="0" x="0" y="0" hdg="0" length="10"><line/></geometry></planView><lanes><laneSection s="0"><center>
<lane id="0" type="none"/></center><right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>
</right></laneSection></lanes></road></OpenDRIVE>)";

std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  all.reserve(text.size() * count);
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

TEST(Damage, EndlesslyRepeatedElementsAreRefused) {
  const auto refused = [](const std::string& text) {
    const Result<Network> network = parse_opendrive(text, "n.xodr");
    EXPECT_FALSE(network.ok());
    return network.ok() ? Error{} : network.error();
  };
  const std::string head = "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/>\n", tail = "</OpenDRIVE>";
  const Error children = refused(head + repeated("<a/>", 5'000'001) + tail);
  EXPECT_EQ(children.code, ErrorCode::kData);
  EXPECT_NE(children.message.find("more than 5000000"), std::string::npos) << children.text();
  const Error tags = refused(head + "<road id=\"1\">" + repeated("<type/>", 1'000'001) + "</road>" + tail);
  EXPECT_EQ(tags.code, ErrorCode::kData);
  EXPECT_EQ(tags.line, 2);
  EXPECT_NE(tags.message.find("more than 1000000 elements"), std::string::npos) << tags.text();

  const test::TemporaryFolder folder;
  const std::string way = "<nd ref=\"1\"/><nd ref=\"2\"/><tag k=\"highway\" v=\"primary\"/></way>";
  const std::string path =
      folder.put("many.osm", "<osm version=\"0.6\">" + repeated("<node id=\"1\" lat=\"0\" lon=\"0\"/>", 100) +
                                 "<node id=\"2\" lat=\"0\" lon=\"1e-3\"/>" + repeated("<way id=\"1\">" + way, 100) +
                                 "<way id=\"2\">" + way + "</osm>");
  ElementFindings findings(path);
  EXPECT_TRUE(read_osm(path, findings, {.ways = 2, .refs = 4, .one_pass_nodes = 101}).ok());
  const std::pair<OsmLimits, const char*> cases[] = {{{.ways = 1}, "more than 1 ways"},
                                                     {{.refs = 3}, "more than 3 nodes of ways"},
                                                     {{.one_pass_nodes = 100}, "100 nodes;"}};
  for (const auto& [limits, says] : cases) {
    const Result<OsmData> data = read_osm(path, findings, limits);
    ASSERT_FALSE(data.ok());
    EXPECT_EQ(data.error().code, ErrorCode::kData);
    EXPECT_NE(data.error().message.find(says), std::string::npos) << data.error().text();
  }
  EXPECT_EQ(read_file(path, 100).error().code, ErrorCode::kData);
  EXPECT_TRUE(read_file(path).ok());
}

// Ten entities, each ten of the one before: expanded they would be 3 GB.
std::string entity_bomb(const std::string& root) {
  std::string text = "<?xml version=\"1.0\"?><!DOCTYPE " + root + " [<!ENTITY l0 \"lol\">";
  for (int i = 1; i < 10; ++i) {
    text += "<!ENTITY l" + std::to_string(i) + " \"" + repeated("&l" + std::to_string(i - 1) + ";", 10) + "\">";
  }
  return text + "]>";
}

// They are refused in one line, or stand for themselves.
TEST(Damage, EntitiesAreNotExpanded) {
  const test::TemporaryFolder folder;
  const std::string gpx = entity_bomb("gpx") + "<gpx><trk><name>&l9;</name><trkseg><trkpt lat=\"1\" lon=\"2\"/>" +
                          "<trkpt lat=\"1.01\" lon=\"2\"/></trkseg></trk></gpx>";
  const auto track = import_files({folder.put("a.gpx", gpx)}, {});
  ASSERT_TRUE(track.ok()) << track.error().text();
  EXPECT_EQ(track->network.roads[0].name, "&l9;");
  const std::string osm = entity_bomb("osm") + "<osm version=\"0.6\"><node id=\"1\" lat=\"50\" lon=\"11\"/>" +
                          "<node id=\"2\" lat=\"50.001\" lon=\"11\"/><way id=\"1\"><nd ref=\"1\"/><nd ref=\"2\"/>" +
                          "<tag k=\"highway\" v=\"primary\"/><tag k=\"name\" v=\"&l9;\"/></way></osm>";
  const std::string kml =
      entity_bomb("kml") + "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><Placemark>" +
      "<name>&l9;</name><LineString><coordinates>1,2 1.01,2</coordinates></LineString></Placemark>" +
      "</Document></kml>";
  for (const std::string& path : {folder.put("a.osm", osm), folder.put("a.kml", kml)}) {
    const auto refused = import_files({path}, {});
    ASSERT_FALSE(refused.ok()) << path;
    EXPECT_EQ(refused.error().file, path);
    EXPECT_EQ(refused.error().text().find('\n'), std::string::npos);
  }
  const std::string xodr = entity_bomb("OpenDRIVE") + kOneRoad;
  const Result<Network> network = parse_opendrive(xodr, "n.xodr");
  ASSERT_TRUE(network.ok()) << network.error().text();
  EXPECT_EQ(network->roads[0].name, "&l9;");
}

// XML wants its declaration first; files of some editors have a comment there.
TEST(Damage, ACommentBeforeTheDeclarationIsRead) {
  const Result<Network> network =
      parse_opendrive("<!-- edited\n by hand -->\n<?xml version=\"1.0\"?>\n" + std::string(kOneRoad), "n.xodr");
  ASSERT_TRUE(network.ok()) << network.error().text();
  EXPECT_EQ(network->roads.size(), 1u);
}

TEST(Damage, RefusedFilesAreClosed) {
  const auto open_files = [] {
    return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator());
  };
  const std::filesystem::path corpus = std::string(ROADGEN_SOURCE_DIR) + "/tests/fuzz/corpus";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(corpus)) {
    if (!entry.is_regular_file()) continue;
    const auto read = [&] { (void)import_files({entry.path()}, {}); };
    read();  // libraries may keep what they open first
    const auto before = open_files();
    for (int i = 0; i < 20; ++i) read();
    EXPECT_EQ(open_files(), before) << entry.path();
  }
}

TEST(Damage, WaysWithZeroBytesInTheirTagsAreLeftOut) {
  ElementFindings findings("null_in_tag.pbf");
  (void)read_osm(std::string(ROADGEN_SOURCE_DIR) + "/tests/fuzz/corpus/osm_pbf/null_in_tag.pbf", findings);
  Diagnostics diagnostics;
  findings.append_to(diagnostics);
  EXPECT_TRUE(std::any_of(diagnostics.begin(), diagnostics.end(), [](const Diagnostic& d) {
    return d.message.find("zero byte in its tags") != std::string::npos;
  }));
}

}  // namespace
}  // namespace roadgen
