// Networks in the projections of maps: latitude and longitude against GeographicLib, closed forms and PROJ's own
// operations, which know nothing of coordinate systems; files; and what is no projection.
#include <gtest/gtest.h>
#include <proj.h>

#include <GeographicLib/LambertConformalConic.hpp>
#include <GeographicLib/TransverseMercatorExact.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/export/geojson.h"
#include "roadgen/export/opendrive.h"
#include "roadgen/geodesy/local_frame.h"
#include "roadgen/import/opendrive.h"

namespace roadgen {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
using Forward = std::function<glm::dvec2(glm::dvec2 longitude_latitude_deg)>;

// PROJ's operation of a projection alone.
Forward operation(const std::string& text) {
  const std::shared_ptr<PJ> pj(proj_create(nullptr, text.c_str()), proj_destroy);
  EXPECT_NE(pj, nullptr) << text;
  return [pj](glm::dvec2 p) {
    const PJ_COORD to = proj_trans(pj.get(), PJ_FWD, proj_coord(p.x * kDegree, p.y * kDegree, 0, 0));
    return glm::dvec2(to.xy.x, to.xy.y);
  };
}

Forward transverse_mercator(double longitude_0, double scale, glm::dvec2 false_origin_m) {
  return [=](glm::dvec2 p) {
    static const GeographicLib::TransverseMercatorExact unit(6378137, 1 / 298.257223563, 1);
    glm::dvec2 q;
    unit.Forward(longitude_0, p.y, p.x, q.x, q.y);
    return scale * q + false_origin_m;
  };
}

Forward lambert(double latitude_1, double latitude_2, glm::dvec2 origin_deg) {
  return [=](glm::dvec2 p) {
    const GeographicLib::LambertConformalConic cone(6378137, 1 / 298.257223563, latitude_1, latitude_2, 1);
    glm::dvec2 q, origin;
    cone.Forward(origin_deg.x, origin_deg.y, origin_deg.x, origin.x, origin.y);
    cone.Forward(origin_deg.x, p.y, p.x, q.x, q.y);
    return q - origin;
  };
}

Forward spherical_mercator(double radius_m) {
  return [=](glm::dvec2 p) { return radius_m * glm::dvec2(p.x * kDegree, std::asinh(std::tan(p.y * kDegree))); };
}

std::string wkt_of(const std::string& definition) {
  PJ* const pj = proj_create(nullptr, definition.c_str());
  EXPECT_NE(pj, nullptr) << definition;
  const std::string text = proj_as_wkt(nullptr, pj, PJ_WKT2_2019, nullptr);
  proj_destroy(pj);
  return text;
}

struct System {
  std::string definition;
  glm::dvec2 about_deg;  // longitude and latitude of where it is used
  Forward forward;
  double inverse_deg = 4e-12;  // allowed of latitude and longitude
};
// PROJ 9.1 inverts the authalic latitude of an ellipsoid by three terms of a series: to 0.4 mm.
constexpr double kAuthalic_deg = 5e-9;
std::vector<System> systems() {
  const Forward utm32 = transverse_mercator(9, 0.9996, {500000, 0});
  return {
      {"+proj=tmerc +lat_0=0 +lon_0=9 +k=0.9996 +x_0=500000 +y_0=0 +datum=WGS84 +units=m +no_defs", {11, 48}, utm32},
      {"+proj=utm +zone=32 +ellps=WGS84 +datum=WGS84 +units=m +no_defs", {8, 50}, utm32},
      {"+proj=utm +zone=32 +datum=WGS84 +type=crs", {8, 50}, utm32},
      {"EPSG:32632", {10, 60}, utm32},
      {wkt_of("EPSG:32632"), {10, 60}, utm32},
      {"+proj=utm +zone=56 +south +datum=WGS84", {151.2, -33.9}, transverse_mercator(153, 0.9996, {500000, 1e7})},
      {"+proj=lcc +lat_1=49 +lat_2=44 +lat_0=46.5 +lon_0=3 +ellps=WGS84", {7, 44}, lambert(49, 44, {3, 46.5})},
      {"+proj=merc +R=6370997 +units=m +no_defs", {7, 44}, spherical_mercator(6370997)},
      {"EPSG:3857", {7, 44}, spherical_mercator(6378137)},
      {"+proj=laea +lat_0=52 +lon_0=10 +x_0=4321000 +y_0=3210000 +datum=WGS84",
       {2, 48},
       operation("+proj=laea +lat_0=52 +lon_0=10 +x_0=4321000 +y_0=3210000 +ellps=WGS84"),
       kAuthalic_deg},
      {"+proj=stere +lat_0=90 +lat_ts=70 +lon_0=-45 +datum=WGS84",
       {-51, 64},
       operation("+proj=stere +lat_0=90 +lat_ts=70 +lon_0=-45 +ellps=WGS84")},
      {"+proj=ortho +lat_0=50 +lon_0=8 +x_0=100 +datum=WGS84",
       {8, 50},
       operation("+proj=ortho +lat_0=50 +lon_0=8 +x_0=100 +ellps=WGS84")},
      // Axes of the system in the other order: x is east nevertheless.
      {"EPSG:3035",
       {10, 52},
       operation("+proj=laea +lat_0=52 +lon_0=10 +x_0=4321000 +y_0=3210000 +ellps=GRS80"),
       kAuthalic_deg},
  };
}

// Within 20 km of where the systems are used; GRS80 and WGS84 differ by 0.1 mm.
TEST(Georeference, ProjectionsAreThoseOfIndependentSources) {
  for (const System& system : systems()) {
    Georeference reference;
    reference.projection = system.definition;
    ASSERT_TRUE(check_georeference(reference)) << check_georeference(reference).error().message;
    const LocalFrame frame(reference);
    for (double east = -0.2; east <= 0.2; east += 0.1) {
      const glm::dvec2 at = system.about_deg + glm::dvec2(east, 0.4 * east + 0.03);
      const glm::dvec2 due = system.forward(at);
      const glm::dvec3 p = frame.to_local_m({at.y, at.x, 12});
      EXPECT_LT(glm::length(glm::dvec2(p) - due), 2e-7) << system.definition;
      EXPECT_EQ(p.z, 12);
      const Geodetic back = frame.to_geodetic(glm::dvec3(due, 12));
      EXPECT_NEAR(back.longitude_deg, at.x, system.inverse_deg) << system.definition;
      EXPECT_NEAR(back.latitude_deg, at.y, system.inverse_deg) << system.definition;
      EXPECT_EQ(back.height_m, 12);
    }
  }
}

TEST(Georeference, TheOffsetTurnsTheNetworkAndThenMovesIt) {
  Georeference plain, moved;
  plain.projection = moved.projection = "+proj=utm +zone=32 +datum=WGS84";
  moved.offset_m = {297133.4, 5623440.5};
  moved.offset_heading_rad = 0.3;
  moved.height_m = 100;
  const LocalFrame a(plain), b(moved);
  const glm::dvec3 p(300, -40, 7);
  const double c = std::cos(0.3), s = std::sin(0.3);
  const Geodetic due = a.to_geodetic({297133.4 + c * p.x - s * p.y, 5623440.5 + s * p.x + c * p.y, 107});
  const Geodetic found = b.to_geodetic(p);
  EXPECT_NEAR(found.latitude_deg, due.latitude_deg, 1e-13);
  EXPECT_NEAR(found.longitude_deg, due.longitude_deg, 1e-13);
  EXPECT_EQ(found.height_m, 107);
  EXPECT_LT(glm::length(b.to_local_m(found) - p), 1e-6);
}

std::string file_with(const std::string& header) {
  return R"(<?xml version="1.0"?>
<OpenDRIVE>
<header revMajor="1" revMinor="7">
)" + header +
         R"(
</header>
<road id="1" length="100" junction="-1">
<planView><geometry s="0" x="10" y="20" hdg="0.5" length="100"><line/></geometry></planView>
<lanes><laneSection s="0"><center><lane id="0" type="none"/></center>
<right><lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></right></laneSection></lanes>
</road>
</OpenDRIVE>
)";
}

// The line GeoJSON gives for a straight road, whose ends are x, y and x, y of the file.
TEST(Georeference, FilesKeepItAndGeoJsonFollowsIt) {
  for (const System& system : systems()) {
    const glm::dvec2 offset = system.forward(system.about_deg);
    std::string text = "<geoReference>\n<![CDATA[" + system.definition + "]]></geoReference>\n<offset";
    char numbers[120];
    std::snprintf(numbers, sizeof numbers, " x=\"%.17g\" y=\"%.17g\" z=\"5.5\" hdg=\"0.25\"/>", offset.x, offset.y);
    Diagnostics diagnostics;
    const Result<Network> network = parse_opendrive(file_with(text + numbers), "n.xodr", &diagnostics);
    ASSERT_TRUE(network.ok()) << network.error().text();
    EXPECT_TRUE(diagnostics.empty()) << diagnostics.front().text();
    ASSERT_TRUE(network->georeference.has_value());
    const Georeference& g = *network->georeference;
    EXPECT_EQ(g.projection, system.definition);
    EXPECT_EQ(g.offset_m, offset);
    EXPECT_EQ(g.offset_heading_rad, 0.25);
    EXPECT_NEAR(g.longitude_deg, system.about_deg.x, system.inverse_deg);
    EXPECT_NEAR(g.latitude_deg, system.about_deg.y, system.inverse_deg);
    EXPECT_EQ(g.height_m, 5.5);

    const Result<std::string> written = opendrive_text(*network);
    ASSERT_TRUE(written.ok());
    const Result<Network> back = parse_opendrive(*written, "n.xodr");
    ASSERT_TRUE(back.ok()) << back.error().text();
    EXPECT_EQ(back->georeference->projection, g.projection);
    EXPECT_EQ(back->georeference->offset_m, g.offset_m);
    EXPECT_EQ(back->georeference->height_m, g.height_m);
    EXPECT_EQ(*opendrive_text(*back), *written);

    const auto lines = nlohmann::json::parse(*geojson_text(*network));
    const auto& ends = lines["features"][0]["geometry"]["coordinates"];
    const glm::dvec2 ahead(std::cos(0.5), std::sin(0.5));
    for (const bool at_end : {false, true}) {
      const auto& place = at_end ? ends.back() : ends.front();
      const glm::dvec2 p = glm::dvec2(10, 20) + (at_end ? 100.0 : 0.0) * ahead;
      const double c = std::cos(0.25), s = std::sin(0.25);
      const glm::dvec2 due = offset + glm::dvec2(c * p.x - s * p.y, s * p.x + c * p.y);
      EXPECT_LT(glm::length(system.forward({place[0], place[1]}) - due), 1e-4 + 1.2e5 * system.inverse_deg)
          << system.definition;  // GeoJSON has 1e-9 degree
      EXPECT_NEAR(place[2], 5.5, 1e-9);
    }
  }
}

TEST(Georeference, OrthographicOnWgs84IsTheTopocentricFrame) {
  const auto read = [](const std::string& header) {
    const Result<Network> network = parse_opendrive(file_with(header), "n.xodr");
    EXPECT_TRUE(network.ok());
    return network->georeference.value_or(Georeference{});
  };
  const std::string ortho =
      "<geoReference>+proj=ortho +lat_0=48.5 +lon_0=9 +x_0=0 +y_0=0 +ellps=WGS84 +units=m +no_defs";
  EXPECT_EQ(read(ortho + "</geoReference>").projection, "");
  EXPECT_EQ(read(ortho + "</geoReference>").latitude_deg, 48.5);
  EXPECT_NE(read(ortho + " +k=2</geoReference>").projection, "");
  EXPECT_NE(read(ortho + "</geoReference><offset x=\"1\"/>").projection, "");
}

TEST(Georeference, WhatIsNoProjectionInMetresIsToldOnce) {
  for (const char* definition :
       {"+lat_0=4.9e+1 +lon_0=8", "nowhere", "+proj=unheardof", "+proj=tmerc +lat_0=x", "+proj=utm +zone=99",
        "PROJCRS[\"cut", "EPSG:0", "EPSG:4326", "+proj=longlat +datum=WGS84", "+proj=utm +zone=10 +units=us-ft",
        "EPSG:2263", "+proj=geocent", "[[[", "+proj=lcc +lat_1=10 +lat_2=-10"}) {
    Diagnostics diagnostics;
    const Result<Network> network = parse_opendrive(
        file_with("<geoReference><![CDATA[" + std::string(definition) + "]]></geoReference>"), "n.xodr", &diagnostics);
    ASSERT_TRUE(network.ok()) << network.error().text();
    EXPECT_FALSE(network->georeference) << definition;
    ASSERT_EQ(diagnostics.size(), 1u) << definition;
    EXPECT_EQ(diagnostics[0].line, 4);
    EXPECT_NE(diagnostics[0].message.find("geoReference is not kept"), std::string::npos);
    EXPECT_EQ(diagnostics[0].message.find('\n'), std::string::npos);
  }
  EXPECT_FALSE(parse_opendrive(file_with("<offset x=\"a\"/>"), "n.xodr").ok());
}

}  // namespace
}  // namespace roadgen
