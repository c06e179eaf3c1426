// Meshes and lines against the roads that they stand for.
#include "roadgen/export/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/export/geojson.h"
#include "roadgen/export/gltf.h"
#include "roadgen/fit/catmull_rom.h"
#include "roadgen/geodesy/local_frame.h"
#include "roadgen/query/road_index.h"
#include "tests/junction_scenes.h"

namespace roadgen {
namespace {

using Json = nlohmann::json;

constexpr double kFloat_m = 1e-4;  // of positions, as the header says

Lane lane(LaneType type, double width_m, double height_m = 0, Mark mark = {}) {
  return {.type = type,
          .material = default_material(type),
          .width_m = {width_m},
          .inner_height_m = height_m,
          .outer_height_m = height_m,
          .mark = mark};
}

// A winding road over hills, banked, with a crown, kerbs and a ramped verge.
Network winding(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Anchor> anchors;
  double heading = 3 * unit(random);
  glm::dvec2 at(200 * unit(random), 200 * unit(random));
  for (int i = 0; i < 9; ++i) {
    anchors.push_back({.position_m = at, .elevation_m = 4 * unit(random), .half_width_m = 9});
    heading += 0.5 * unit(random);
    at += (60 + 20 * unit(random)) * glm::dvec2(std::cos(heading), std::sin(heading));
  }
  Result<Road> road = road_from_anchors(anchors, {});
  EXPECT_TRUE(road.ok());
  road->id = "w";
  for (Segment& segment : road->segments) {
    segment.superelevation_rad = {0.05 * unit(random), 1e-3 * unit(random), 0, 0};
    segment.crossfall_left = {0.025, 0};
    segment.crossfall_right = {0.02, 1e-4};
  }
  LaneSection section;
  const Mark broken{.kind = MarkKind::kBroken, .phase_m = 1.5}, solid{.kind = MarkKind::kSolid};
  section.center_mark = {.kind = MarkKind::kSolidBroken};
  section.left = {lane(LaneType::kDriving, 3.5, 0, broken), lane(LaneType::kDriving, 3.25, 0, solid),
                  lane(LaneType::kCurb, 0.15, 0.12), lane(LaneType::kSidewalk, 2, 0.12)};
  section.right = {lane(LaneType::kDriving, 3.5, 0, solid), lane(LaneType::kNone, 2)};
  section.right[1].outer_height_m = 0.3;
  section.offset_m = {0.4, 1e-3, 0, 0};
  EXPECT_TRUE(set_sections(*road, {section}).ok());
  Network network;
  network.roads.push_back(std::move(*road));
  return network;
}

bool is_lane(const MeshPart& part) { return part.name != "white" && part.name != "yellow"; }

// How far a point is from the road's surface with its faces, at most.
double off_surface_m(const RoadIndex& index, glm::dvec3 p, double error_m) {
  const auto at = index.to_road(glm::dvec2(p), 0.5);
  EXPECT_TRUE(at.has_value());
  if (!at) return 1e9;
  const Road& road = index.network().roads[0];
  const Segment& segment = index.segment(at->at);
  double low = 1e9, high = -1e9;
  for (const double side : {-error_m, 0.0, error_m}) {
    const double t = std::clamp(at->t_m + side, segment.right_m.value(at->s_m - segment.s_start_m) + 1e-9,
                                segment.left_m.value(at->s_m - segment.s_start_m) - 1e-9);
    const double z = surface_height_m(road, segment, at->s_m - segment.s_start_m, t);
    low = std::min(low, z), high = std::max(high, z);
  }
  // Within the outer faces, down to the road surface.
  if (at->outside_m > 0) low = std::min(low, p.z);
  return std::max({low - p.z, p.z - high, 0.0}) + at->outside_m;
}

double distance_to_triangle(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  const glm::dvec3 n = glm::normalize(glm::cross(b - a, c - a));
  const auto inside = [&](glm::dvec3 u, glm::dvec3 v) { return glm::dot(glm::cross(v - u, p - u), n) >= 0; };
  if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(glm::dot(p - a, n));
  double least = 1e300;
  const glm::dvec3 corners[] = {a, b, c};
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 u = corners[k], v = corners[(k + 1) % 3];
    const double w = std::clamp(glm::dot(p - u, v - u) / glm::dot(v - u, v - u), 0.0, 1.0);
    least = std::min(least, glm::distance(p, u + w * (v - u)));
  }
  return least;
}

template <class Visit>
void for_triangles(const NetworkMesh& mesh, Visit&& visit) {
  for (const MeshItem& item : mesh.items) {
    for (const MeshPart& part : item.parts) {
      const auto corner = [&](std::size_t i) { return item.origin_m + glm::dvec3(part.positions[part.triangles[i]]); };
      for (std::size_t i = 0; i < part.triangles.size(); i += 3) visit(part, corner(i), corner(i + 1), corner(i + 2));
    }
  }
}

TEST(Mesh, TrianglesLieOnTheRoadWithinTheStatedError) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    for (const double allowed_m : {0.002, 0.02, 0.3}) {
      const Network network = winding(seed);
      const RoadIndex index(network);
      const auto mesh = tessellate(network, {.max_error_m = allowed_m});
      ASSERT_TRUE(mesh.ok());
      EXPECT_LE(mesh->error_m, allowed_m);
      double worst = 0;
      for_triangles(*mesh, [&](const MeshPart& part, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        if (!is_lane(part) || normal.z < 1e-2 * glm::length(normal)) return;  // faces have a test of their own
        double u = unit(random), v = unit(random);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        worst = std::max(worst, off_surface_m(index, a + u * (b - a) + v * (c - a), mesh->error_m));
      });
      EXPECT_LE(worst, mesh->error_m + kFloat_m) << seed << ' ' << allowed_m;
      EXPECT_GT(worst, 0.02 * mesh->error_m) << "the bound says little";
    }
  }
}

TEST(Mesh, NoPartOfTheRoadIsFarFromTheMesh) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 1);
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    const Network network = winding(seed);
    const Road& road = network.roads[0];
    const auto mesh = tessellate(network, {.max_error_m = 0.02});
    ASSERT_TRUE(mesh.ok());
    double worst = 0;
    for (int i = 0; i < 500; ++i) {
      const double s = unit(random) * road.length_m();
      const Segment& segment = road.segments[segment_at(road, s)];
      const double right = segment.right_m.value(s - segment.s_start_m);
      const double t = right + unit(random) * (segment.left_m.value(s - segment.s_start_m) - right);
      const glm::dvec3 p = pose_at(road, s, t).position_m;
      double least = 1e300;
      for_triangles(*mesh, [&](const MeshPart& part, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
        if (is_lane(part)) least = std::min(least, distance_to_triangle(p, a, b, c));
      });
      worst = std::max(worst, least);
    }
    EXPECT_LE(worst, mesh->error_m + kFloat_m) << seed;
  }
}

// Seen from above every lane is counter-clockwise; faces stand between the heights of the lanes beside them.
TEST(Mesh, TrianglesFaceOutward) {
  const Network network = winding(3);
  const auto mesh = tessellate(network);
  ASSERT_TRUE(mesh.ok());
  double face_area = 0;
  for (const MeshItem& item : mesh->items) {
    for (const MeshPart& part : item.parts) {
      for (std::size_t i = 0; i < part.triangles.size(); i += 3) {
        const auto p = [&](std::size_t k) { return glm::dvec3(part.positions[part.triangles[i + k]]); };
        const glm::dvec3 area = 0.5 * glm::cross(p(1) - p(0), p(2) - p(0));
        EXPECT_GT(glm::dot(area, glm::dvec3(part.normals[part.triangles[i]])), 0);
        EXPECT_GE(area.z, -1e-6);
        if (area.z < 1e-2 * glm::length(area)) face_area += glm::length(area);
      }
    }
  }
  // The kerb's face, the sidewalk's outer one and the verge's.
  EXPECT_NEAR(face_area / network.roads[0].length_m(), 0.12 + 0.12 + 0.3, 0.01);
}

TEST(Mesh, MarksCoverWhatTheirPatternsSay) {
  Network network;
  Result<Road> road = road_from_anchors(
      std::vector<Anchor>{{.position_m = {0, 0}}, {.position_m = {100, 0}}, {.position_m = {171, 0}}}, {});
  ASSERT_TRUE(road.ok());
  LaneSection section;
  section.center_mark = {
      .kind = MarkKind::kSolidBroken, .width_m = 0.1, .space_m = 0.2, .on_m = 2, .off_m = 3, .phase_m = 1};
  section.left = {lane(LaneType::kDriving, 3.5, 0, {.kind = MarkKind::kBroken, .width_m = 0.2, .on_m = 4, .off_m = 6})};
  ASSERT_TRUE(set_sections(*road, {section}).ok());
  road->paint.push_back({.kind = PaintKind::kZebra,
                         .color = PaintColor::kRed,
                         .s_m = 99,
                         .t_m = 1.5,
                         .length_m = 4,
                         .width_m = 3,
                         .stripe_m = 0.5});
  network.roads.push_back(*road);
  const auto mesh = tessellate(network, {.max_error_m = 0.001});
  ASSERT_TRUE(mesh.ok());
  double white = 0, red = 0;
  for_triangles(*mesh, [&](const MeshPart& part, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
    const double area = 0.5 * glm::length(glm::cross(b - a, c - a));
    if (part.name == "white") white += area;
    if (part.name == "red") red += area;
  });
  // 171 m: dashes of 4 in 10: 17 whole and 1 m; of 2 in 5 from 1 m on: 1 m, then 34 periods to 171 - 1 ... 170 / 5 = 34.
  const double broken = 17 * 4 + 1, second = 1 + 33 * 2 + 2;
  EXPECT_NEAR(white, 0.1 * 171 + 0.2 * broken + 0.1 * second, 1e-3);
  EXPECT_NEAR(red, 4 * 3 * 0.5, 1e-3);
}

TEST(Mesh, OutlinesOfPaintAreThoseOfThePicture) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const PaintKind kind : {PaintKind::kArrow, PaintKind::kArrowLeft, PaintKind::kArrowRight,
                               PaintKind::kArrowStraightLeft, PaintKind::kArrowStraightRight}) {
    for (const bool against : {false, true}) {
      const Paint paint{.kind = kind, .length_m = 5, .width_m = 1.8, .against = against};
      const bool left = kind == PaintKind::kArrowLeft || kind == PaintKind::kArrowStraightLeft;
      const bool right = kind == PaintKind::kArrowRight || kind == PaintKind::kArrowStraightRight;
      const bool both = kind == PaintKind::kArrowStraightLeft || kind == PaintKind::kArrowStraightRight;
      int covered = 0;
      for (int i = 0; i < 5000; ++i) {
        const glm::dvec2 p(3 * unit(random), 1.2 * unit(random));
        const double way = against ? -1 : 1;
        const double d = Lib::marking_arrow(way * p.x, way * p.y, 5.0, 1.8, left ? 1.0 : right ? -1.0 : 0.0, both);
        if (std::abs(d) < 1e-6) continue;
        bool inside = false;
        for (const auto& polygon : outlines(paint)) {
          bool all = true;
          for (std::size_t k = 0; k < polygon.size(); ++k) {
            const glm::dvec2 e = polygon[(k + 1) % polygon.size()] - polygon[k], q = p - polygon[k];
            all = all && e.x * q.y - e.y * q.x >= 0;
          }
          inside = inside || all;
        }
        EXPECT_EQ(inside, d < 0) << p.x << ' ' << p.y;
        covered += inside;
      }
      EXPECT_GT(covered, 200);
    }
  }
}

TEST(Mesh, JunctionAreasAreWhole) {
  std::mt19937 any(7);
  std::vector<std::vector<JunctionArm>> scenes = {test::crossing_arms(), test::skewed_arms()};
  for (int i = 0; i < 10; ++i) scenes.push_back(test::random_arms(any, {500, -300, 40}));
  int made = 0;
  for (const auto& arms : scenes) {
    const Result<Junction> junction = make_junction("j", arms);
    if (!junction) continue;  // random arms may lie too close
    ++made;
    Network network;
    network.junctions.push_back(*junction);
    const auto mesh = tessellate(network, {.max_error_m = 0.01});
    ASSERT_TRUE(mesh.ok()) << mesh.error().text();
    const JunctionSurface surface = junction_surface(*junction);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    double area = 0, worst = 0;
    for_triangles(*mesh, [&](const MeshPart&, glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
      area += 0.5 * glm::cross(b - a, c - a).z;
      double u = unit(random), v = unit(random);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const glm::dvec3 p = a + u * (b - a) + v * (c - a);
      worst = std::max(worst, std::abs(p.z - height_at(surface, glm::dvec2(p)).height_m));
    });
    EXPECT_LE(worst, mesh->error_m + kFloat_m);
    // By counting points.
    int inside = 0;
    const int count = 40000;
    const glm::dvec3 size = surface.high_m - surface.low_m;
    for (int i = 0; i < count; ++i) {
      const glm::dvec2 p =
          glm::dvec2(surface.center_m + surface.low_m) + glm::dvec2(size) * glm::dvec2(unit(random), unit(random));
      inside += signed_distance_m(surface, p) > 0;
    }
    const double counted = size.x * size.y * inside / count;
    EXPECT_NEAR(area, counted, 3 * size.x * size.y / std::sqrt(count));
  }
  EXPECT_GE(made, 6);
}

TEST(Mesh, RefusesWhatItCannotMake) {
  EXPECT_EQ(tessellate({}, {.max_error_m = 0}).error().code, ErrorCode::kUsage);
  EXPECT_EQ(tessellate({}, {.max_error_m = NAN}).error().code, ErrorCode::kUsage);
  EXPECT_TRUE(tessellate({}).ok());
}

TEST(Gltf, HoldsTheMeshAsItIs) {
  const Network network = winding(1);
  const auto mesh = tessellate(network);
  ASSERT_TRUE(mesh.ok());
  const auto file = gltf_binary(*mesh, Georeference{48, 11, 500});
  ASSERT_TRUE(file.ok());
  const auto word = [&](std::size_t at) {
    std::uint32_t w;
    std::memcpy(&w, file->data() + at, sizeof w);
    return w;
  };
  ASSERT_EQ(file->substr(0, 4), "glTF");
  EXPECT_EQ(word(4), 2u);
  EXPECT_EQ(word(8), file->size());
  const std::size_t json_size = word(12), binary = 12 + 8 + json_size + 8;
  EXPECT_EQ(json_size % 4, 0u);
  EXPECT_EQ(file->substr(16, 4), "JSON");
  EXPECT_EQ(file->substr(binary - 4, 4), std::string("BIN\0", 4));
  const Json json = Json::parse(file->substr(20, json_size));
  EXPECT_EQ(json["buffers"][0]["byteLength"], file->size() - binary);
  EXPECT_EQ(json["asset"]["extras"]["origin"], Json({48.0, 11.0, 500.0}));
  std::size_t triangles = 0;
  for (std::size_t i = 0; i < mesh->items.size(); ++i) {
    const Json& node = json["nodes"][i + 1];
    EXPECT_EQ(node["translation"][0], mesh->items[i].origin_m.x);
    const Json& primitives = json["meshes"][node["mesh"].get<std::size_t>()]["primitives"];
    ASSERT_EQ(primitives.size(), mesh->items[i].parts.size());
    for (std::size_t k = 0; k < primitives.size(); ++k) {
      const MeshPart& part = mesh->items[i].parts[k];
      const Json& accessor = json["accessors"][primitives[k]["attributes"]["POSITION"].get<std::size_t>()];
      const Json& view = json["bufferViews"][accessor["bufferView"].get<std::size_t>()];
      ASSERT_EQ(accessor["count"], part.positions.size());
      ASSERT_EQ(view["byteLength"], part.positions.size() * sizeof(glm::vec3));
      EXPECT_EQ(std::memcmp(file->data() + binary + view["byteOffset"].get<std::size_t>(), part.positions.data(),
                            view["byteLength"]),
                0);
      for (const glm::vec3& p : part.positions) {
        EXPECT_GE(p.x, accessor["min"][0]);
        EXPECT_LE(p.y, accessor["max"][1]);
      }
      EXPECT_EQ(json["materials"][primitives[k]["material"].get<std::size_t>()]["name"], part.name);
      triangles += json["accessors"][primitives[k]["indices"].get<std::size_t>()]["count"].get<std::size_t>() / 3;
    }
  }
  EXPECT_EQ(triangles, mesh->triangles);
}

TEST(GeoJson, LinesComeBackWithinTheStatedError) {
  Network network = winding(2);
  EXPECT_EQ(geojson_text(network).error().code, ErrorCode::kData);
  network.georeference = Georeference{43.7, 7.4, 20};
  EXPECT_EQ(geojson_text(network, 0).error().code, ErrorCode::kUsage);
  network.roads[0].name = "Rue \"du\" Port";
  const auto text = geojson_text(network, 0.02);
  ASSERT_TRUE(text.ok());
  const Json json = Json::parse(*text);
  const Road& road = network.roads[0];
  const LocalFrame frame(*network.georeference);
  // The reference line and the borders of six lanes.
  ASSERT_EQ(json["features"].size(), 8u);
  for (const Json& feature : json["features"]) {
    EXPECT_EQ(feature["properties"]["name"], "Rue \"du\" Port");
    const bool is_reference = feature["properties"]["kind"] == "reference line";
    std::vector<glm::dvec3> line;
    for (const Json& c : feature["geometry"]["coordinates"]) line.push_back(frame.to_local_m({c[1], c[0], c[2]}));
    ASSERT_GT(line.size(), 8u);
    for (double s = 0; s <= road.length_m(); s += 0.37) {
      double t = 0;
      if (!is_reference) {
        const int border = feature["properties"]["lane"].get<int>() + 2;
        t = road.sections[0].borders_m()[static_cast<std::size_t>(border)].value(s);
      }
      const glm::dvec2 p(pose_at(road, s, t).position_m);
      double least = 1e300;
      for (std::size_t i = 1; i < line.size(); ++i) {
        const glm::dvec2 a(line[i - 1]), e = glm::dvec2(line[i]) - a;
        const double w = std::clamp(glm::dot(p - a, e) / glm::dot(e, e), 0.0, 1.0);
        least = std::min(least, glm::distance(p, a + w * e));
      }
      EXPECT_LE(least, 0.02 + 2e-4);
    }
  }
}

}  // namespace
}  // namespace roadgen
