// The rules of OpenDRIVE 1.7 that other programs rely on, checked on our files by an XML parser alone: order and kind of
// elements, records, geometry by integration, links in both directions.
// Source: ASAM OpenDRIVE 1.7.0 and its schema.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <pugixml.hpp>

#include "roadgen/export/opendrive.h"
#include "roadgen/import/import.h"
#include "roadgen/import/opendrive.h"
#include "tests/osm_text.h"
#include "tests/temporary_folder.h"

namespace roadgen {
namespace {

using test::OsmText;

constexpr double kGap_m = 1e-9, kTurn_rad = 1e-9, kArc_m = 1e-6;

struct Cubic2 {
  double u[4], v[4];
  double du(double p) const { return u[1] + p * (2 * u[2] + p * 3 * u[3]); }
  double dv(double p) const { return v[1] + p * (2 * v[2] + p * 3 * v[3]); }
  static double at(const double* c, double p) { return c[0] + p * (c[1] + p * (c[2] + p * c[3])); }
  double speed(double p) const { return std::hypot(du(p), dv(p)); }
  // Gauss' rule of five points, halved until it does not change.
  double arc(double a, double b, int depth = 0) const {
    const auto rule = [&](double low, double high) {
      constexpr double x[] = {0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640, -0.9061798459386640};
      constexpr double w[] = {0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                              0.2369268850561891};
      double sum = 0;
      for (int i = 0; i < 5; ++i) sum += w[i] * speed(0.5 * (low + high) + 0.5 * (high - low) * x[i]);
      return 0.5 * (high - low) * sum;
    };
    const double m = 0.5 * (a + b), whole = rule(a, b), halves = rule(a, m) + rule(m, b);
    if (std::abs(whole - halves) < 1e-9 || depth > 12) return halves;
    return arc(a, m, depth + 1) + arc(m, b, depth + 1);
  }
};

class Rules {
 public:
  explicit Rules(const std::string& text) {
    if (!document_.load_string(text.c_str())) fault("not XML");
    const pugi::xml_node root = document_.child("OpenDRIVE");
    expect_order(root, {"header", "road", "controller", "junction", "junctionGroup", "station", "userData"});
    const pugi::xml_node header = root.child("header");
    if (header.attribute("revMajor").as_int() != 1 || header.attribute("revMinor").as_int() != 7) fault("revision");
    expect_order(header, {"geoReference", "offset", "userData"});
    for (const pugi::xml_node road : root.children("road")) {
      if (!roads_.emplace(road.attribute("id").value(), road).second) fault("two roads of one id");
    }
    for (const pugi::xml_node junction : root.children("junction")) {
      if (!junctions_.emplace(junction.attribute("id").value(), junction).second) fault("two junctions of one id");
    }
    if (roads_.empty()) fault("no roads");
    for (const auto& [id, road] : roads_) check_road(road);
    for (const auto& [id, junction] : junctions_) check_junction(junction);
  }

  const std::vector<std::string>& faults() const { return faults_; }
  std::string geo_reference() const {
    return document_.child("OpenDRIVE").child("header").child("geoReference").text().get();
  }

 private:
  void fault(const std::string& what) {
    if (faults_.size() < 20) faults_.push_back(where_ + ": " + what);
  }

  // Elements in the schema's sequence, and no others.
  void expect_order(const pugi::xml_node& node, const std::vector<std::string>& names) {
    std::size_t at = 0;
    for (const pugi::xml_node child : node.children()) {
      if (child.type() != pugi::node_element) continue;
      const auto found = std::find(names.begin() + static_cast<std::ptrdiff_t>(at), names.end(), child.name());
      if (found == names.end()) return fault(std::string("<") + child.name() + "> is out of order");
      at = static_cast<std::size_t>(found - names.begin());
    }
  }

  double number(const pugi::xml_node& node, const char* name) {
    const double x = node.attribute(name).as_double(NAN);
    if (!std::isfinite(x)) fault(std::string(node.name()) + " lacks " + name);
    return x;
  }

  // Positions that begin at 0, increase, and stay below the end.
  void expect_increasing(const pugi::xml_node& parent, const char* element, const char* name, double end_m) {
    double last = -1;
    for (const pugi::xml_node node : parent.children(element)) {
      const double s = number(node, name);
      if (last < 0 ? s != 0 : !(s > last)) fault(std::string("<") + element + "> does not increase from 0");
      if (!(s < end_m)) fault(std::string("<") + element + "> begins beyond the end");
      last = s;
    }
  }

  void check_road(const pugi::xml_node& road) {
    where_ = std::string("road ") + road.attribute("id").value();
    expect_order(road, {"link", "type", "planView", "elevationProfile", "lateralProfile", "lanes", "objects", "signals",
                        "surface", "railroad", "userData"});
    const double length = number(road, "length");
    expect_increasing(road.child("planView"), "geometry", "s", length);
    expect_increasing(road.child("elevationProfile"), "elevation", "s", length);
    expect_increasing(road.child("lateralProfile"), "superelevation", "s", length);
    expect_increasing(road.child("lanes"), "laneOffset", "s", length);
    expect_increasing(road.child("lanes"), "laneSection", "s", length);
    check_plan(road.child("planView"), length);
    const std::string junction = road.attribute("junction").value();
    if (junction != "-1" && !junctions_.contains(junction)) fault("lies in a junction that is not there");
    if (!road.child("lanes").child("laneSection")) fault("no lane section");
    for (const pugi::xml_node section : road.child("lanes").children("laneSection")) check_section(section);
    for (const char* element : {"predecessor", "successor"}) check_link(road, element);
  }

  void check_plan(const pugi::xml_node& plan, double length) {
    double end_s = 0, x = NAN, y = NAN, heading = NAN;
    for (const pugi::xml_node geometry : plan.children("geometry")) {
      const pugi::xml_node poly = geometry.child("paramPoly3");
      if (!poly || poly.attribute("pRange").value() != std::string("normalized")) return fault("not a paramPoly3");
      Cubic2 c;
      for (int i = 0; i < 4; ++i) {
        const char letter = static_cast<char>('a' + i);
        c.u[i] = number(poly, std::string({letter, 'U'}).c_str()),
        c.v[i] = number(poly, std::string({letter, 'V'}).c_str());
      }
      if (c.u[0] != 0 || c.v[0] != 0 || c.v[1] != 0) fault("aU, aV or bV is not 0");
      if (!(c.u[1] > 0)) fault("bU is not positive");
      const double s = number(geometry, "s"), own = number(geometry, "length"), h = number(geometry, "hdg");
      const double px = number(geometry, "x"), py = number(geometry, "y");
      if (std::abs(c.arc(0, 1) - own) > kArc_m) fault("length is not the arc length");
      // Coordinates step by 2^-52 of their size.
      const double room = kGap_m + 1e-15 * (std::abs(px) + std::abs(py));
      if (std::abs(s - end_s) > kGap_m) fault("s has a gap");
      if (std::hypot(px - x, py - y) > room)
        fault("a gap of " + std::to_string(1e9 * std::hypot(px - x, py - y)) + " nm between geometries");
      if (std::abs(std::remainder(h - heading, 2 * M_PI)) > kTurn_rad)
        fault("a turn of " + std::to_string(std::remainder(h - heading, 2 * M_PI)) +
              " rad between geometries at s = " + std::to_string(s));
      const double u = Cubic2::at(c.u, 1), v = Cubic2::at(c.v, 1);
      x = px + u * std::cos(h) - v * std::sin(h), y = py + u * std::sin(h) + v * std::cos(h);
      heading = h + std::atan2(c.dv(1), c.du(1));
      end_s = s + own;
    }
    if (std::abs(end_s - length) > kGap_m) fault("length is not that of its geometries");
  }

  void check_section(const pugi::xml_node& section) {
    expect_order(section, {"left", "center", "right", "userData"});
    if (!section.child("left") && !section.child("right")) fault("a section without lanes");
    if (section.child("center").child("lane").attribute("id").as_int(-1) != 0) fault("no centre lane");
    for (const char* side : {"left", "right"}) {
      const bool left = !std::strcmp(side, "left");
      const pugi::xml_node lanes = section.child(side);
      int expected =
          left ? static_cast<int>(std::distance(lanes.children("lane").begin(), lanes.children("lane").end())) : -1;
      for (const pugi::xml_node lane : lanes.children("lane")) {
        if (lane.attribute("id").as_int() != expected--) fault("lanes do not descend from left to right");
        expect_order(
            lane, {"link", "border", "width", "roadMark", "material", "speed", "access", "height", "rule", "userData"});
        if (!lane.child("width")) fault("a lane without width");
      }
    }
  }

  static pugi::xml_node section_at(const pugi::xml_node& road, bool at_end) {
    pugi::xml_node found;
    for (const pugi::xml_node section : road.child("lanes").children("laneSection")) {
      if (!found || at_end) found = section;
    }
    return found;
  }

  static pugi::xml_node lane_of(const pugi::xml_node& section, int id) {
    for (const pugi::xml_node lane : section.child(id > 0 ? "left" : "right").children("lane")) {
      if (lane.attribute("id").as_int() == id) return lane;
    }
    return {};
  }

  // Whether a road's or lane's link leads back, and between lanes that are there.
  void check_link(const pugi::xml_node& road, const char* element) {
    const pugi::xml_node link = road.child("link").child(element);
    if (!link) return;
    const bool own_end = !std::strcmp(element, "successor");
    const std::string id = link.attribute("elementId").value(), type = link.attribute("elementType").value();
    if (type == "junction") {
      if (!junctions_.contains(id)) fault("a link to a junction that is not there");
      return;
    }
    const auto other = roads_.find(id);
    if (type != "road" || other == roads_.end()) return fault("a link to a road that is not there");
    const std::string contact = link.attribute("contactPoint").value();
    if (contact != "start" && contact != "end") return fault("a link without contactPoint");
    const bool other_end = contact == "end";
    const pugi::xml_node back = other->second.child("link").child(other_end ? "successor" : "predecessor");
    const std::string own_id = road.attribute("id").value(), own_junction = road.attribute("junction").value();
    const bool to_junction = back.attribute("elementType").value() == std::string("junction");
    // A connecting road's neighbour is linked to the junction.
    const bool returned = to_junction ? back.attribute("elementId").value() == own_junction
                                      : back.attribute("elementId").value() == own_id &&
                                            (back.attribute("contactPoint").value() == std::string("end")) == own_end;
    if (!back || !returned) return fault("road " + id + " does not return the link");
    const pugi::xml_node own_section = section_at(road, own_end), other_section = section_at(other->second, other_end);
    for (const char* side : {"left", "right"}) {
      for (const pugi::xml_node lane : own_section.child(side).children("lane")) {
        for (const pugi::xml_node to : lane.child("link").children(element)) {
          const pugi::xml_node beyond = lane_of(other_section, to.attribute("id").as_int());
          if (!beyond) {
            fault("a lane's link to a lane that is not there");
            continue;
          }
          if (to_junction) continue;  // the junction's connections say it
          bool lane_returned = false;
          for (const pugi::xml_node lane_back :
               beyond.child("link").children(other_end ? "successor" : "predecessor")) {
            lane_returned = lane_returned || lane_back.attribute("id").as_int() == lane.attribute("id").as_int();
          }
          if (!lane_returned) fault("a lane's link is not returned");
        }
      }
    }
  }

  void check_junction(const pugi::xml_node& junction) {
    where_ = std::string("junction ") + junction.attribute("id").value();
    expect_order(junction, {"connection", "priority", "controller", "surface", "userData"});
    if (!junction.child("connection")) fault("no connection");
    std::set<std::string> ids;
    for (const pugi::xml_node c : junction.children("connection")) {
      if (!ids.insert(c.attribute("id").value()).second) fault("two connections of one id");
      const auto in = roads_.find(c.attribute("incomingRoad").value()),
                 way = roads_.find(c.attribute("connectingRoad").value());
      if (in == roads_.end() || way == roads_.end()) {
        fault("a connection of a road that is not there");
        continue;
      }
      if (way->second.attribute("junction").value() != std::string(junction.attribute("id").value())) {
        fault("a connecting road lies elsewhere");
      }
      const bool at_end = c.attribute("contactPoint").value() == std::string("end");
      const pugi::xml_node link = way->second.child("link").child(at_end ? "successor" : "predecessor");
      if (link.attribute("elementId").value() != in->first)
        fault("a connecting road is not linked to the incoming one");
      const bool in_end = link.attribute("contactPoint").value() == std::string("end");
      for (const pugi::xml_node lane : c.children("laneLink")) {
        if (!lane_of(section_at(in->second, in_end), lane.attribute("from").as_int()) ||
            !lane_of(section_at(way->second, at_end), lane.attribute("to").as_int())) {
          fault("a connection of lanes that are not there");
        }
      }
    }
  }

  pugi::xml_document document_;
  std::map<std::string, pugi::xml_node> roads_, junctions_;
  std::string where_;
  std::vector<std::string> faults_;
};

std::string written(const Network& network) {
  const Result<std::string> text = opendrive_text(network);
  EXPECT_TRUE(text.ok()) << (text.ok() ? "" : text.error().text());
  return text.ok() ? *text : "";
}

// Maps of other programs have kinks and links of their own that are not returned: they are told when read, and stay.
void expect_kept(const Network& network, bool foreign = false) {
  const std::string text = written(network);
  const Rules rules(text);
  for (const std::string& fault : rules.faults()) {
    const bool theirs = fault.find("a turn of") != fault.npos || fault.find("return") != fault.npos;
    if (!foreign || !theirs) ADD_FAILURE() << fault;
  }
  EXPECT_EQ(rules.geo_reference().empty(), !network.georeference.has_value());
  if (network.georeference && !network.georeference->projection.empty()) {
    EXPECT_EQ(rules.geo_reference(), network.georeference->projection);
  }
  // Nothing is lost: what comes back is the same file.
  const Result<Network> back = parse_opendrive(text, "f");
  ASSERT_TRUE(back.ok()) << back.error().text();
  EXPECT_TRUE(written(*back) == text);
}

Network imported(const std::string& path) {
  auto result = import_files({path}, {});
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().text());
  return result.ok() ? std::move(result->network) : Network{};
}

// Streets that meet in an area, go on with other lanes, pass above one another, and meet where no area fits.
std::string town() {
  OsmText osm;
  osm.node(1, -200, 0).node(2, 0, 0).node(3, 200, 0).node(4, 0, -150).node(5, 0, 150).node(6, 400, 0);
  osm.node(7, 300, -200).node(8, 300, -60).node(9, 300, 60).node(10, 300, 200);
  osm.node(20, 1000, 0).node(21, 1100, 0).node(22, 1100, 1).node(23, 1100, 2).node(24, 850, 0);
  osm.way(10, {1, 2, 3}, {{"highway", "primary"}}).way(11, {4, 2, 5}, {{"highway", "residential"}});
  osm.way(12, {3, 6}, {{"highway", "primary"}, {"lanes", "4"}});
  osm.way(13, {7, 8}, {{"highway", "secondary"}}).way(15, {9, 10}, {{"highway", "secondary"}});
  osm.way(14, {8, 9}, {{"highway", "secondary"}, {"bridge", "yes"}, {"layer", "1"}});
  osm.way(20, {20, 21}, {{"highway", "primary"}}).way(21, {20, 22}, {{"highway", "primary"}});
  osm.way(22, {20, 23}, {{"highway", "primary"}}).way(23, {24, 20}, {{"highway", "primary"}});
  return osm.text();
}

TEST(OpenDriveRules, OwnDataAndATownKeepThem) {
  const std::string data = std::string(ROADGEN_SOURCE_DIR) + "/data/";
  for (const char* file : {"circuit.csv", "pass.csv"}) {
    SCOPED_TRACE(file);
    expect_kept(imported(data + file));
  }
  const test::TemporaryFolder folder;
  const Network network = imported(folder.put("town.osm", town()));
  EXPECT_GE(network.junctions.size(), 1u);
  const auto has_area = [&](const JunctionLinks& links) {
    return std::any_of(network.junctions.begin(), network.junctions.end(),
                       [&](const Junction& area) { return area.id == links.id; });
  };
  EXPECT_FALSE(std::all_of(network.junction_links.begin(), network.junction_links.end(), has_area));
  expect_kept(network);
}

TEST(OpenDriveRules, SharedMapsKeepThem) {
  const std::filesystem::path shared = std::filesystem::path(ROADGEN_SOURCE_DIR) / "../shared/data";
  if (!std::filesystem::exists(shared)) GTEST_SKIP() << shared << " is not there";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared / "road-geo")) {
    const std::string path = entry.path();
    if (!path.ends_with(".osm") && !path.ends_with(".osm.gz")) continue;
    SCOPED_TRACE(path);
    expect_kept(imported(path));
  }
  for (const auto& entry : std::filesystem::recursive_directory_iterator(shared / "opendrive")) {
    if (entry.path().extension() != ".xodr") continue;
    SCOPED_TRACE(entry.path());
    const Result<Network> network = read_opendrive(entry.path());
    ASSERT_TRUE(network.ok()) << network.error().text();
    expect_kept(*network, true);
  }
}

TEST(OpenDriveRules, TheCheckCanFail) {
  const test::TemporaryFolder folder;
  const std::string text = written(imported(folder.put("town.osm", town())));
  ASSERT_TRUE(Rules(text).faults().empty()) << Rules(text).faults().front();
  const auto changed = [&](const std::string& after, const std::string& from, const std::string& to) {
    const std::size_t start = text.find(after), at = start == text.npos ? start : text.find(from, start);
    EXPECT_NE(at, text.npos) << after << " " << from;
    return at == text.npos ? text : std::string(text).replace(at, from.size(), to);
  };
  const std::string bad[] = {
      changed("<header", "revMinor=\"7\"", "revMinor=\"8\""),
      changed("<paramPoly3", "aU=\"0\"", "aU=\"1e-9\""),
      changed("<paramPoly3", "bU=\"", "bU=\"-"),
      changed("<paramPoly3", "cV=\"", "cV=\"9\" was=\""),
      changed("<geometry", "length=\"", "length=\"1"),
      changed("<geometry", "<geometry s=\"0\"", "<geometry s=\"1\""),
      changed("<laneSection", "s=\"0\"", "s=\"1\""),
      changed("</geometry>\n      <geometry", "hdg=\"", "hdg=\"1"),
      changed("<right>", "id=\"-1\"", "id=\"-2\""),
      changed("elementType=\"junction\"", "elementId=\"", "elementId=\"no"),
      changed("elementType=\"road\"", "contactPoint=\"", "contactPoint=\"no"),
      changed("elementType=\"road\"", "elementId=\"", "elementId=\"no"),
      changed("<connection", "incomingRoad=\"", "incomingRoad=\"no"),
      changed("<connection", "connectingRoad=\"", "connectingRoad=\"no"),
      changed("<connection", "laneLink from=\"", "laneLink from=\"9"),
      changed("<road", "<planView>", "<objects/><planView>"),
      changed("<road", " length=\"", " length=\"1"),
  };
  for (std::size_t i = 0; i < std::size(bad); ++i) EXPECT_FALSE(Rules(bad[i]).faults().empty()) << i;
}

}  // namespace
}  // namespace roadgen
