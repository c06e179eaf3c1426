// What an OpenDRIVE file says beside roads and lanes is kept: objects, signals, types, speeds, controllers, junctions of
// every type; and comes back from our own file as it was.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <pugixml.hpp>
#include <random>

#include "roadgen/export/opendrive.h"
#include "roadgen/import/opendrive.h"

namespace roadgen {
namespace {

Network parsed(const std::string& text, Diagnostics* diagnostics = nullptr) {
  const Result<Network> network = parse_opendrive(text, "net.xodr", diagnostics);
  EXPECT_TRUE(network.ok()) << network.error().text();
  return network.ok() ? *network : Network{};
}

// Writes the network, reads it, and expects what the roads, the graph and the network keep to be the same.
void expect_comes_back(const Network& network) {
  const Result<std::string> text = opendrive_text(network);
  ASSERT_TRUE(text.ok()) << text.error().text();
  Diagnostics diagnostics;
  const Network back = parsed(*text, &diagnostics);
  ASSERT_EQ(back.roads.size(), network.roads.size());
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road &a = network.roads[i], &b = back.roads[i];
    const RoadRecords &x = *a.records, &y = *b.records;
    EXPECT_EQ(a.bridges, b.bridges) << a.id;
    EXPECT_EQ(x.types, y.types) << a.id;
    EXPECT_EQ(x.lanes, y.lanes) << a.id;
    EXPECT_EQ(x.objects, y.objects) << a.id;
    EXPECT_EQ(x.signals, y.signals) << a.id;
    EXPECT_EQ(x, y) << a.id;
    EXPECT_EQ(a.paint, b.paint) << a.id;
    EXPECT_EQ(a.sweeps, b.sweeps) << a.id;
  }
  EXPECT_EQ(network.junction_links, back.junction_links);
  EXPECT_EQ(network.controllers, back.controllers);
  EXPECT_EQ(network.other_xml, back.other_xml);
  const Result<std::string> again = opendrive_text(back);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(*again, *text);
}

// A road of 100 m along x, with what is put into it.
std::string road_xml(const std::string& id, const std::string& before_plan, const std::string& in_lane,
                     const std::string& after_lanes, double y = 0, const std::string& junction = "-1") {
  return "<road id=\"" + id + "\" junction=\"" + junction + "\" length=\"100\">" + before_plan +
         "<planView><geometry s=\"0\" x=\"0\" y=\"" + std::to_string(y) +
         "\" hdg=\"0\" length=\"100\"><line/></geometry></planView>\n<lanes><laneSection s=\"0\"><center><lane "
         "id=\"0\" "
         "type=\"none\"/></center><right><lane id=\"-1\" type=\"driving\">"
         "<width sOffset=\"0\" a=\"3\" b=\"0\" c=\"0\" d=\"0\"/>" +
         in_lane + "</lane></right></laneSection></lanes>\n" + after_lanes + "</road>\n";
}

std::string file_xml(const std::string& inside) {
  return "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/>\n" + inside + "</OpenDRIVE>";
}

TEST(OpenDriveKept, EverythingOfAForeignRoad) {
  const std::string text = file_xml(
      road_xml("7",
               R"(<type s="0" type="town" country="DE"><speed max="50" unit="km/h"/></type>
<type s="40" type="motorway"><speed max="no limit"/></type>)",
               R"(<speed sOffset="0" max="30" unit="mph"/><speed sOffset="60" max="13.5"/>
<access sOffset="0" rule="allow" restriction="bus"/><access sOffset="0" rule="allow" restriction="taxi"/>
<rule sOffset="10" value="no stopping"/>)",
               R"(<objects>
<object id="t1" name="tree &amp; bush" type="tree" subtype="oak" s="12.5" t="-6" zOffset="0.1" hdg="0.5" pitch="0.01"
 roll="0.02" orientation="none" dynamic="no" radius="2" height="8" validLength="3">
<material surface="leaf" friction="0.1" roughness="0.2"/><validity fromLane="-1" toLane="-1"/>
<parkingSpace access="all"><marking side="left" type="solid" width="0.1" color="white"/></parkingSpace></object>
<object id="p" type="pole" s="1" t="4" zOffset="0" height="6" length="0.2" width="0.3" orientation="+">
<repeat s="1" length="90" distance="10" tStart="4" tEnd="5" heightStart="6" heightEnd="3" zOffsetStart="0"
 zOffsetEnd="1" detachFromReferenceLine="true"/></object>
<object id="b" type="building" s="50" t="20" zOffset="0" hdg="0.1">
<outlines><outline id="0" fillType="concrete" outer="true" closed="true" laneType="none">
<cornerLocal u="0" v="0" z="0" height="9" id="0"/><cornerLocal u="5" v="0" z="0" height="9"/>
<cornerLocal u="5" v="4.5" z="0.5" height="9"/></outline></outlines></object>
<object id="i" type="trafficIsland" s="70" t="0" zOffset="0"><outline><cornerRoad s="65" t="0" dz="0" height="0.1"/>
<cornerRoad s="75" t="1" dz="0" height="0.1"/></outline></object>
<objectReference s="5" t="1" id="t1" zOffset="0" validLength="0" orientation="+"/>
<bridge id="br" name="Old bridge" type="brick" s="20.1" length="30.3"/></objects>
<signals><signal s="30" t="-5" id="s1" name="limit" dynamic="no" orientation="+" zOffset="2" country="DE"
 countryRevision="2017" type="274" subtype="-1" value="60" unit="km/h" height="0.6" width="0.6" text="60" hOffset="0.1">
<validity fromLane="-1" toLane="-1"/><dependency id="s2" type="x"/></signal>
<signal s="90" t="-3" id="s2" dynamic="yes" orientation="-" zOffset="4" type="1000001" subtype="-1"/>
<signal s="80" t="-3" id="s3" dynamic="no" orientation="+" zOffset="0" type="294" subtype="-1"/>
<signalReference s="10" t="2" id="s1" orientation="+"><validity fromLane="-1" toLane="-1"/></signalReference></signals>
<surface><CRG file="a.crg" sStart="0" sEnd="9" orientation="same" mode="attached"/></surface>
<railroad><switch id="1" name="s" position="dynamic"/></railroad>)") +
      R"(<controller id="c1" name="lights" sequence="3"><control signalId="s2" type="0"/><control signalId="s9"/></controller>
<station id="st" name="Stop" type="small"><platform id="1"><segment roadId="7" sStart="1" sEnd="5" side="left"/></platform></station>
)");
  Diagnostics diagnostics;
  const Network network = parsed(text, &diagnostics);
  for (const Diagnostic& d : diagnostics) ADD_FAILURE() << d.text();
  const Road& road = network.roads.at(0);
  const RoadRecords& records = *road.records;
  ASSERT_EQ(records.types.size(), 2u);
  EXPECT_EQ(records.types[0],
            (RoadType{0, "town", "DE", {SpeedLimit::Kind::kMax, SpeedLimit::Unit::kKilometresPerHour, 50}}));
  EXPECT_NEAR(*records.types[0].speed.metres_per_second(), 13.8889, 1e-4);
  EXPECT_EQ(records.types[1].speed.kind, SpeedLimit::Kind::kNoLimit);
  // The lane's records begin at s = 0, 10 and 60, where sections begin.
  ASSERT_EQ(road.sections.size(), 3u);
  ASSERT_EQ(records.lanes.size(), 3u);
  EXPECT_EQ(road.sections[1].s_m, 10);
  EXPECT_EQ(records.lanes[0].speed.unit, SpeedLimit::Unit::kMilesPerHour);
  EXPECT_EQ(records.lanes[1].speed.value, 30);
  EXPECT_EQ(records.lanes[2].speed, (SpeedLimit{SpeedLimit::Kind::kMax, SpeedLimit::Unit::kMetresPerSecond, 13.5}));
  EXPECT_NE(records.lanes[2].access_xml.find("taxi"), std::string::npos);
  EXPECT_TRUE(records.lanes[0].rule_xml.empty());
  EXPECT_NE(records.lanes[1].rule_xml.find("no stopping"), std::string::npos);
  EXPECT_EQ(road.bridges, (std::vector{Bridge{20.1, 20.1 + 30.3, "br", "Old bridge", "brick"}}));

  ASSERT_EQ(records.objects.size(), 4u);
  const RoadObject& tree = records.objects[0];
  EXPECT_EQ(tree.name, "tree & bush");
  EXPECT_EQ(tree.size, (ObjectSize{.length_m = 0, .width_m = 0, .height_m = 8, .radius_m = 2}));
  EXPECT_EQ(tree.validities, (std::vector<LaneValidity>{{-1, -1}}));
  EXPECT_NE(tree.material_xml.find("leaf"), std::string::npos);
  EXPECT_NE(tree.other_xml.find("parkingSpace"), std::string::npos);
  const RoadObject& pole = records.objects[1];
  ASSERT_EQ(place_count(pole), 10u);
  const ObjectPlace last = place_of(pole, 9);
  EXPECT_DOUBLE_EQ(last.s_m, 91);
  EXPECT_DOUBLE_EQ(last.t_m, 5);
  EXPECT_DOUBLE_EQ(last.z_offset_m, 1);
  EXPECT_DOUBLE_EQ(last.size.height_m, 3);
  EXPECT_TRUE(pole.repeats[0].straight);
  const Outline& walls = records.objects[2].outlines.at(0);
  EXPECT_FALSE(walls.on_road);
  EXPECT_EQ(walls.corners.at(2), (OutlineCorner{5, 4.5, 0.5, 9, -1}));
  EXPECT_EQ(walls.corners.at(0).id, 0);
  EXPECT_TRUE(records.objects[3].outlines.at(0).on_road);

  ASSERT_EQ(records.signals.size(), 3u);
  EXPECT_EQ(records.signals[0].value, 60);
  EXPECT_EQ(records.signals[0].orientation, Orientation::kAlong);
  EXPECT_NE(records.signals[0].other_xml.find("dependency"), std::string::npos);
  EXPECT_TRUE(records.signals[1].dynamic);
  EXPECT_TRUE(records.signals[2].is_painted);
  ASSERT_EQ(road.paint.size(), 1u);  // the stop line
  for (const auto& [xml, part] : {std::pair(records.other_xml, "railroad"),
                                  {records.other_xml, "a.crg"},
                                  {records.other_objects_xml, "objectReference"},
                                  {records.other_signals_xml, "signalReference"},
                                  {network.other_xml, "platform"}}) {
    EXPECT_NE(xml.find(part), std::string::npos) << part;
  }
  ASSERT_EQ(network.controllers.size(), 1u);
  EXPECT_EQ(network.controllers[0].sequence, 3);
  EXPECT_EQ(network.controllers[0].controls.at(1).signal, "s9");
  expect_comes_back(network);
}

TEST(OpenDriveKept, JunctionsOfEveryType) {
  const auto link = [](const char* which, const char* type, const char* id, const char* more) {
    return std::string("<") + which + " elementType=\"" + type + "\" elementId=\"" + id + "\" " + more + "/>";
  };
  const std::string end = "contactPoint=\"end\"";
  const std::string text = file_xml(
      road_xml("1", "<link>" + link("successor", "junction", "d", "") + "</link>", "", "") +
      road_xml("2", "<link>" + link("predecessor", "road", "1", end.c_str()) + "</link>", "", "") +
      road_xml("3", "<link>" + link("predecessor", "road", "2", "elementS=\"40\" elementDir=\"+\"") + "</link>", "", "",
               30, "v") +
      R"(<junction id="d" name="exit" type="direct"><connection id="0" incomingRoad="1" linkedRoad="2"
 contactPoint="start"><laneLink from="-1" to="-1"/></connection></junction>
<junction id="v" name="yard" type="virtual" mainRoad="2" sStart="35" sEnd="45" orientation="-">
<connection id="0" incomingRoad="2" connectingRoad="3" contactPoint="start"/>
<connection id="1" type="virtual"><predecessor elementType="road" elementId="2" elementS="40" elementDir="+"/></connection>
<priority high="2" low="3"/><controller id="9" type="0" sequence="1"/></junction>
<junction id="x" name="level crossing" type="crossing"><roadSection id="0" roadId="1" sStart="5" sEnd="9"/></junction>
<junctionGroup name="g" id="1" type="roundabout"><junctionReference junction="d"/></junctionGroup>
)");
  Diagnostics diagnostics;
  const Network network = parsed(text, &diagnostics);
  ASSERT_EQ(network.junction_links.size(), 3u);
  const JunctionLinks &direct = network.junction_links[0], &side = network.junction_links[1];
  EXPECT_EQ(direct.type, JunctionType::kDirect);
  ASSERT_EQ(direct.connections.size(), 1u);
  EXPECT_EQ(direct.connections[0].connecting, "2");
  EXPECT_EQ(side.type, JunctionType::kVirtual);
  EXPECT_EQ(side.records->main_road, "2");
  EXPECT_EQ(side.records->s_end_m, 45);
  EXPECT_EQ(side.records->orientation, Orientation::kAgainst);
  EXPECT_NE(side.records->other_xml.find("priority"), std::string::npos);
  EXPECT_NE(side.records->other_xml.find("elementS"), std::string::npos);
  EXPECT_EQ(network.junction_links[2].type, JunctionType::kCrossing);
  EXPECT_NE(network.junction_links[2].records->other_xml.find("roadSection"), std::string::npos);
  EXPECT_NE(network.roads[2].records->other_links_xml.find("elementDir"), std::string::npos);
  EXPECT_NE(network.other_xml.find("junctionReference"), std::string::npos);
  // All is well but for the roads on top of one another.
  EXPECT_TRUE(link_problems(network).empty()) << link_problems(network).front();
  for (const Diagnostic& d : diagnostics) {
    EXPECT_NE(d.message.find("another type than default"), std::string::npos) << d.text();
  }
  expect_comes_back(network);
}

TEST(OpenDriveKept, WhatIsMalformedIsToldWithItsPlaceAndTheRestKept) {
  struct Case {
    std::string inside, says, element;
    std::size_t objects, signals;
  };
  const std::string good = R"(<object id="ok" type="tree" s="1" t="2" zOffset="0"/>)";
  const auto in_objects = [&](const std::string& xml) { return "<objects>" + good + xml + "</objects>"; };
  const Case cases[] = {
      {in_objects(R"(<object id="o" type="tree" t="2"/>)"), "lacks the attribute s", "road 7: object o", 1, 0},
      {in_objects(R"(<object id="o" type="tree" s="nan" t="2"/>)"), "not a number", "road 7: object o", 1, 0},
      {in_objects(R"(<object id="o" type="tree" s="1e300" t="2"/>)"), "within 1e6", "road 7: object o", 1, 0},
      {in_objects(R"(<object id="o" type="tree" s="1" t="2" radius="-1"/>)"), "negative", "road 7: object o", 1, 0},
      {in_objects(R"(<object id="o" s="1" t="2"><repeat s="0" length="-4" distance="1"/></object>)"), "negative",
       "road 7: object o", 1, 0},
      {in_objects(R"(<object id="o" s="1" t="2"><outline><cornerRoad s="0" t="1"/><cornerLocal u="0" v="1"/></outline>
</object>)"),
       "both kinds", "road 7: object o", 1, 0},
      {in_objects(R"(<object id="o" s="1" t="2"><validity fromLane="x" toLane="1"/></object>)"), "not a number",
       "road 7: object o", 1, 0},
      {in_objects(R"(<bridge id="o" s="50" length="-4"/>)"), "no length", "road 7: bridge o", 1, 0},
      {in_objects(R"(<bridge id="o" s="500" length="4"/>)"), "no length", "road 7: bridge o", 1, 0},
      {in_objects("<shed/>"), "<shed> of objects of roads is not kept", "road 7", 1, 0},
      {R"(<signals><signal id="o" s="1"/><signal id="ok" s="1" t="2" type="1" subtype="2"/></signals>)",
       "lacks the attribute t", "road 7: signal o", 0, 1},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.inside);
    Diagnostics diagnostics;
    const Network network = parsed(file_xml(road_xml("7", "", "", c.inside)), &diagnostics);
    ASSERT_EQ(diagnostics.size(), 1u);
    EXPECT_NE(diagnostics[0].message.find(c.says), std::string::npos) << diagnostics[0].text();
    EXPECT_EQ(diagnostics[0].element, c.element);
    EXPECT_GT(diagnostics[0].line, 2);
    EXPECT_EQ(network.roads[0].records->objects.size(), c.objects);
    EXPECT_EQ(network.roads[0].records->signals.size(), c.signals);
    EXPECT_TRUE(network.roads[0].bridges.empty());
    expect_comes_back(network);
  }
  Diagnostics diagnostics;
  const Network slow = parsed(
      file_xml(road_xml("7", R"(<type s="0" type="town"><speed max="-4"/></type><type s="50"/><type s="20" type="x"/>)",
                        R"(<speed sOffset="0" max="9" unit="knots"/>)", "")),
      &diagnostics);
  ASSERT_EQ(diagnostics.size(), 2u);
  EXPECT_EQ(slow.roads[0].records->types.size(), 2u);
  EXPECT_TRUE(slow.roads[0].records->lanes.empty());
}

TEST(OpenDriveKept, RepeatsAreNumbersHoweverManyThereAre) {
  const Network network = parsed(
      file_xml(road_xml("7", "", "",
                        R"(<objects><object id="o" type="pole" s="0" t="2"><repeat s="0" length="100" distance="1e-7"/>
<repeat s="3" length="5" distance="0" widthStart="1"/></object></objects>)")));
  const RoadObject& object = network.roads[0].records->objects.at(0);
  ASSERT_EQ(place_count(object), 1000000002u);
  EXPECT_NEAR(place_of(object, 999999999).s_m, 100, 1e-5);
  EXPECT_EQ(place_of(object, 1000000001).s_m, 3);
  EXPECT_EQ(place_of(object, 1000000001).size.width_m, 1);
}

// Random records with every number and flag set or not.
class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  double some(double high) { return pick(2) ? in(0, high) : 0; }
  int pick(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
  std::string word() { return pick(3) == 0 ? "" : "w<" + std::to_string(pick(1000)) + "&\"'"; }
  std::optional<bool> maybe() { return pick(3) == 0 ? std::nullopt : std::optional(pick(2) == 0); }
  ObjectSize size() { return {some(5), some(5), some(5), some(5)}; }
  Orientation orientation() { return static_cast<Orientation>(pick(3)); }
  SpeedLimit speed() {
    const auto kind = static_cast<SpeedLimit::Kind>(pick(4));
    if (kind != SpeedLimit::Kind::kMax) return {.kind = kind};
    return {kind, static_cast<SpeedLimit::Unit>(pick(3)), in(0, 200)};
  }
  std::vector<LaneValidity> validities() {
    std::vector<LaneValidity> all;
    for (int i = pick(3); i > 0; --i) all.push_back({-pick(4), pick(4)});
    return all;
  }

  RoadObject object() {
    RoadObject o{.id = word(), .name = word(), .type = word(), .subtype = word()};
    o.s_m = in(0, 100), o.t_m = in(-20, 20), o.z_offset_m = in(-2, 2);
    o.heading_rad = in(-4, 4), o.pitch_rad = in(-1, 1), o.roll_rad = in(-1, 1);
    o.orientation = orientation(), o.dynamic = pick(2) != 0, o.perpendicular = pick(2) != 0;
    o.valid_length_m = some(9), o.size = size(), o.validities = validities();
    for (int i = pick(3); i > 0; --i) {
      o.repeats.push_back(
          {in(0, 50), in(0, 50), some(9), in(-5, 5), in(-5, 5), in(-1, 1), in(-1, 1), size(), size(), pick(2) != 0});
    }
    for (int i = pick(3); i > 0; --i) {
      Outline outline{.on_road = pick(2) != 0, .outer = maybe(), .closed = maybe(), .id = word(), .fill = word()};
      for (int k = outline.on_road + pick(4); k > 0; --k) {
        outline.corners.push_back({in(-9, 9), in(-9, 9), in(-9, 9), in(-9, 9), pick(5) - 1});
      }
      o.outlines.push_back(outline);
    }
    if (pick(2)) o.material_xml = "<material surface=\"a&amp;b\"/>", o.other_xml = "<surface/><userData code=\"x\"/>";
    return o;
  }

  RoadSignal signal() {
    RoadSignal s{.id = word(), .name = word(), .type = word(), .subtype = word(), .country = word()};
    s.s_m = in(0, 100), s.t_m = in(-20, 20), s.z_offset_m = in(-2, 8), s.heading_rad = in(-4, 4);
    s.pitch_rad = in(-1, 1), s.roll_rad = in(-1, 1), s.orientation = orientation(), s.dynamic = pick(2) != 0;
    if (pick(2)) s.value = in(-9, 200);
    s.unit = word(), s.text = word(), s.length_m = some(2), s.width_m = some(2), s.height_m = some(2);
    s.validities = validities();
    if (pick(2)) s.other_xml = "<reference elementType=\"object\" elementId=\"1\"/>";
    return s;
  }

 private:
  std::mt19937 random_;
};

TEST(OpenDriveKept, RandomRecordsComeBackBitForBit) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    Dice dice(seed);
    Network network = parsed(file_xml(road_xml("7", "", "<speed sOffset=\"50\" max=\"1\"/>", "")));
    Road& road = network.roads[0];
    ASSERT_EQ(road.sections.size(), 2u);
    RoadRecords& records = road.records.edit();
    records.lanes.clear();
    for (std::uint32_t section = 0; section < 2; ++section) {
      const SpeedLimit speed = dice.speed();
      if (speed.kind != SpeedLimit::Kind::kNone)
        records.lanes.push_back({.section = section, .lane = -1, .speed = speed});
    }
    for (int i = dice.pick(4); i > 0; --i) records.objects.push_back(dice.object());
    for (int i = dice.pick(4); i > 0; --i) records.signals.push_back(dice.signal());
    double s = 0;
    for (int i = dice.pick(4); i > 0; --i, s += dice.in(0, 20)) {
      records.types.push_back({s, dice.word(), dice.word(), dice.speed()});
    }
    for (int i = dice.pick(3); i > 0; --i) {
      const double from = dice.in(0, 60);
      road.bridges.push_back({from, dice.pick(3) ? dice.in(61, 99) : road.length_m(), dice.word(), dice.word()});
    }
    for (int i = dice.pick(3); i > 0; --i) {
      Controller controller{.id = dice.word(), .name = dice.word(), .sequence = std::nullopt};
      if (dice.pick(2)) controller.sequence = dice.pick(9);
      for (int k = dice.pick(3); k > 0; --k) controller.controls.push_back({dice.word(), dice.word()});
      network.controllers.push_back(controller);
    }
    expect_comes_back(network);
  }
}

TEST(OpenDriveKept, BadRecordsCannotBeWritten) {
  const Network good = parsed(file_xml(road_xml("7", "", "", "")));
  const auto refused = [&](const auto& spoil) {
    Network network = good;
    spoil(network.roads[0]);
    const Result<std::string> text = opendrive_text(network);
    EXPECT_FALSE(text.ok());
    return !text.ok() && text.error().element == "road 7" && !check(network).ok();
  };
  EXPECT_TRUE(refused([](Road& road) { road.records.edit().objects = {{.id = "o", .s_m = NAN}}; }));
  EXPECT_TRUE(refused([](Road& road) { road.records.edit().signals = {{.id = "o", .height_m = -1}}; }));
  EXPECT_TRUE(refused([](Road& road) { road.bridges = {{.s_start_m = 5, .s_end_m = 5}}; }));
  EXPECT_TRUE(refused([](Road& road) { road.bridges = {{.s_start_m = 5, .s_end_m = 500}}; }));
}

TEST(OpenDriveKept, AllOfTheSharedMaps) {
  const std::filesystem::path folder = std::filesystem::path(ROADGEN_SOURCE_DIR) / "../shared/data/opendrive";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::size_t files = 0, objects = 0, signals = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".xodr") continue;
    SCOPED_TRACE(entry.path());
    ++files;
    pugi::xml_document document;
    ASSERT_TRUE(document.load_file(entry.path().c_str()));
    const Result<Network> network = read_opendrive(entry.path());
    ASSERT_TRUE(network.ok()) << network.error().text();
    for (const pugi::xml_node node : document.child("OpenDRIVE").children("road")) {
      const Road* road = network->find_road(node.attribute("id").value());
      ASSERT_NE(road, nullptr);
      const auto count = [&](const char* parent, const char* name) {
        const auto all = node.child(parent).children(name);
        return static_cast<std::size_t>(std::distance(all.begin(), all.end()));
      };
      // An object is paint, a structure, or kept as it is.
      EXPECT_EQ(road->records->signals.size(), count("signals", "signal")) << road->id;
      EXPECT_LE(road->records->objects.size(), count("objects", "object")) << road->id;
      if (road->paint.empty() && road->sweeps.empty()) {
        EXPECT_EQ(road->records->objects.size(), count("objects", "object")) << road->id;
      }
      objects += road->records->objects.size(), signals += road->records->signals.size();
    }
    expect_comes_back(*network);
  }
  EXPECT_EQ(files, 8u);
  std::printf("%zu objects, %zu signals\n", objects, signals);
}

}  // namespace
}  // namespace roadgen
