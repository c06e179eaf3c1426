// Scene files: what each type becomes, and what each fault is told as; point clouds.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <numbers>
#include <string>
#include <variant>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "roadgen/import/point_cloud.h"
#include "roadgen/import/scene_file.h"
#include "roadgen/render/placement.h"
#include "tests/temporary_folder.h"
#include "tests/unit/terrain_scenes.h"

namespace roadgen {
namespace {

using test::TemporaryFolder;

std::string scene_of(const std::string& objects) { return "{\"version\": 1, \"objects\": [\n" + objects + "\n]}"; }

SceneFile read(const std::string& text) {
  auto scene = parse_scene(text, "props.json");
  EXPECT_TRUE(scene.ok()) << scene.error().text();
  return scene.ok() ? *scene : SceneFile{};
}

// The whole line that a user sees.
std::string fault(const std::string& text, const std::string& file = "props.json") {
  const auto scene = parse_scene(text, file);
  return scene.ok() ? "none" : scene.error().text();
}

TEST(SceneFile, EveryTypeBecomesItsShape) {
  const SceneFile file = read(scene_of(R"(
    {"type": "circle", "center": [1, 2, 3], "normal": [0, 1, 0], "radius": 2},
    {"type": "ellipse", "center": [0, 0, 0], "axis_u": [2, 0, 0], "axis_v": [0, 1, 0]},
    {"type": "conic", "origin": [0, 0, 0], "axis_u": [1, 0, 0], "axis_v": [0, 1, 0], "coefficients": [1, 0, 0, 0, -1, 0],
     "low": [-2, 0], "high": [2, 4]},
    {"type": "triangle", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]},
    {"type": "parallelogram", "corner": [0, 0, 0], "edge_u": [1, 0, 0], "edge_v": [0, 1, 1]},
    {"type": "sphere", "center": [1, 2, 3], "radius": 0.5, "name": "ball"},
    {"type": "ellipsoid", "center": [0, 0, 5], "radii": [1, 2, 3]},
    {"type": "ellipsoid", "center": [0, 0, 5], "axes": [[1, 0, 0], [0, 1, 1], [0, 0, 2]]},
    {"type": "quadric", "coefficients": [1, 1, -1, 0, 0, 0, 0, 0, 0, -1], "box": [[-2, -2, -1], [2, 2, 1]], "solid": true},
    {"type": "quadric", "matrix": [[1, 0.5, 0, 0], [0.5, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]], "box": [[-2, -2, -2], [2, 2, 2]]},
    {"type": "cylinder", "from": [0, 0, 0], "to": [0, 0, 6], "radius": 0.1},
    {"type": "cone", "from": [0, 0, 0], "to": [0, 0, 1], "radius_from": 0.5},
    {"type": "box", "low": [0, 0, 0], "high": [1, 2, 3]},
    {"type": "parallelepiped", "corner": [0, 0, 0], "edges": [[1, 0, 0], [0.5, 1, 0], [0, 0, 1]]},
    {"type": "tetrahedron", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
    {"type": "tetrahedron", "apex": [0, 0, 2], "direction": [0, 0, -1], "side": 2},
    {"type": "torus", "center": [0, 0, 0], "major_radius": 2, "minor_radius": 0.5})"));
  const std::vector<Object>& o = file.scene.objects;
  ASSERT_EQ(o.size(), 17u);
  EXPECT_TRUE(check(file.scene).empty());
  EXPECT_EQ(std::get<Circle>(o[0].shape).normal, glm::dvec3(0, 1, 0));
  EXPECT_EQ(std::get<Ellipse>(o[1].shape).axis_u, glm::dvec3(2, 0, 0));
  EXPECT_EQ(std::get<Conic>(o[2].shape).coefficients[4], -1);
  EXPECT_EQ(std::get<Conic>(o[2].shape).high, glm::dvec2(2, 4));
  EXPECT_EQ(std::get<Triangle>(o[3].shape).c, glm::dvec3(0, 1, 0));
  EXPECT_EQ(std::get<Parallelogram>(o[4].shape).edge_v, glm::dvec3(0, 1, 1));
  EXPECT_EQ(std::get<Sphere>(o[5].shape).center, glm::dvec3(1, 2, 3));
  EXPECT_EQ(o[5].name, "ball");
  EXPECT_EQ(std::get<Ellipsoid>(o[6].shape).axis_z, glm::dvec3(0, 0, 3));
  EXPECT_EQ(std::get<Ellipsoid>(o[7].shape).axis_y, glm::dvec3(0, 1, 1));
  EXPECT_TRUE(std::get<Quadric>(o[8].shape).solid);
  EXPECT_EQ(std::get<Quadric>(o[8].shape).box_low, glm::dvec3(-2, -2, -1));
  EXPECT_EQ(std::get<Quadric>(o[9].shape).coefficients[3], 1);  // xy: both halves of the matrix
  EXPECT_EQ(std::get<Quadric>(o[9].shape).box_high, glm::dvec3(2));
  EXPECT_EQ(std::get<Cylinder>(o[10].shape).radius, 0.1);
  EXPECT_EQ(std::get<Cone>(o[11].shape).radius_to, 0);
  EXPECT_EQ(std::get<Parallelepiped>(o[12].shape).edge_z, glm::dvec3(0, 0, 3));
  EXPECT_EQ(std::get<Parallelepiped>(o[13].shape).edge_y, glm::dvec3(0.5, 1, 0));
  const Tetrahedron& regular = std::get<Tetrahedron>(o[15].shape);
  EXPECT_NEAR(glm::length(regular.b - regular.a), 2, 1e-12);
  EXPECT_NEAR(glm::length(regular.c - regular.d), 2, 1e-12);
  EXPECT_EQ(std::get<Torus>(o[16].shape).axis, glm::dvec3(0, 0, 1));
}

TEST(SceneFile, MaterialsAreFoundByNameWhereverTheyStand) {
  const SceneFile file = read(R"({"objects": [
      {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "glass"},
      {"type": "sphere", "center": [0, 0, 0], "radius": 1},
      {"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "paint"}],
    "materials": {"paint": {"model": "phong", "base_color": "#ff8000", "specular": [0.1, 0.2, 0.3], "shininess": 50},
                  "glass": {"transmission": 1, "ior": 1.33, "reflection": 0.5, "metallic": 0.25, "roughness": 0,
                            "texture": "wood.png"}},
    "version": 1})");
  ASSERT_EQ(file.scene.objects.size(), 3u);
  const auto& materials = file.scene.materials;
  const ObjectMaterial& glass = materials[file.scene.objects[0].material];
  EXPECT_EQ(glass.name, "glass");
  EXPECT_EQ(glass.ior, 1.33f);
  EXPECT_EQ(glass.transmission, 1);
  EXPECT_EQ(glass.texture_file, "wood.png");
  const ObjectMaterial& paint = materials[file.scene.objects[2].material];
  EXPECT_EQ(paint.model, ObjectMaterial::Model::kPhong);
  EXPECT_NEAR(paint.base_color.y, 0.2159, 1e-4);  // of sRGB's 128
  EXPECT_EQ(paint.base_color.x, 1);
  EXPECT_EQ(materials[file.scene.objects[1].material].roughness, ObjectMaterial{}.roughness);
}

TEST(SceneFile, InstancesAndGroupsMultiply) {
  const SceneFile file = read(scene_of(R"(
    {"type": "group", "transform": [1, 0, 0, 100,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1],
     "instances": [{"transform": [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}, {}],
     "objects": [{"type": "sphere", "center": [1, 0, 0], "radius": 1,
                  "transform": [2, 0, 0, 5,  0, 2, 0, 0,  0, 0, 2, 0,  0, 0, 0, 1]},
                 {"type": "group", "objects": [{"type": "sphere", "center": [0, 0, 1], "radius": 1}]}]})"));
  ASSERT_EQ(file.scene.objects.size(), 4u);
  const auto center = [&](std::size_t i) {
    const Object& o = file.scene.objects[i];
    return glm::dvec3(o.transform * glm::dvec4(std::get<Sphere>(o.shape).center, 1));
  };
  EXPECT_EQ(center(0), glm::dvec3(0, 107, 0));  // 2 x 1 + 5, moved by 100, turned to the left
  EXPECT_EQ(center(1), glm::dvec3(107, 0, 0));
  EXPECT_EQ(center(2), glm::dvec3(0, 100, 1));
  EXPECT_EQ(center(3), glm::dvec3(100, 0, 1));
}

TEST(SceneFile, FaultsAreToldWithLineAndPath) {
  const std::string good = R"({"type": "sphere", "center": [0, 0, 0], "radius": 1})";
  const std::pair<std::string, std::string> cases[] = {
      {R"({"type": "blob"})", "props.json:3: objects[1].type: unknown type 'blob'"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 1, "radios": 2})",
       "props.json:3: objects[1].radios: unknown key"},
      {R"({"type": "sphere", "radius": 1})", "props.json:3: objects[1]: the key 'center' is missing"},
      {R"({"type": "sphere", "center": [0, 0], "radius": 1})",
       "props.json:3: objects[1].center: expected 3 numbers, found 2"},
      {"{\"type\": \"sphere\",\n \"center\": [0,\n \"x\", 0], \"radius\": 1}",
       "props.json:5: objects[1].center[1]: expected a number, found a string"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": -1})",
       "props.json:3: objects[1]: the radius must be greater than 0"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 0})", "objects[1]: the radius must be greater than 0"},
      {R"({"type": "sphere", "center": [0, 0, NaN], "radius": 1})", "props.json:3: not JSON: "},
      {R"({"type": "sphere", "center": [0, 0, 1e999], "radius": 1})", "props.json:3: not JSON: number overflow"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 1, "radius": 2})",
       "props.json:3: the key 'radius' stands here twice"},
      {R"({"type": "quadric", "matrix": [[1, 2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, -1]], "box": [[0,0,0],[1,1,1]]})",
       "objects[1].matrix: the quadric's matrix must be symmetric"},
      {R"({"type": "quadric", "coefficients": [0, 0, 0, 0, 0, 0, 0, 0, 0, 1], "box": [[0,0,0],[1,1,1]]})",
       "objects[1]: the quadric is singular"},
      {R"({"type": "quadric", "coefficients": [1, 1, 1, 0, 0, 0, 0, 0, 0], "box": [[0,0,0],[1,1,1]]})",
       "objects[1].coefficients: expected 10 numbers, found 9"},
      {R"({"type": "triangle", "vertices": [[0, 0, 0], [1, 1, 1], [2, 2, 2]]})",
       "objects[1]: the triangle is degenerate"},
      {R"({"type": "triangle", "vertices": [[0, 0, 0], [1, 1, 1]]})",
       "objects[1].vertices: expected 3 points, found 2"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 1, "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]})",
       "objects[1]: an axis or edge must be"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 1, "transform": [1, 0, 0]})",
       "objects[1].transform: expected 16 numbers"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 1, "material": "gold"})",
       "props.json:3: objects[1].material: there is no material 'gold'"},
      {R"({"type": "sphere", "center": [0, 0, 0], "radius": 1, "place": {"road": "1"}})",
       "props.json:3: objects[1].place: the key 's' is missing"},
      {R"({"type": "spheres", "file": "nowhere.xyzr"})", "nowhere.xyzr: no such file"},
      {R"({"type": "spheres", "file": "x.obj"})", "no such file"},
      {R"({"type": "ellipsoid", "center": [0, 0, 0], "radii": [1, 0, 1]})", "objects[1].radii: the radii must be"},
      {R"([1])", "props.json:3: objects[1]: expected an object, found an array"},
      {R"({"type": 3})", "props.json:3: objects[1].type: expected a string, found a number"},
  };
  for (const auto& [object, expected] : cases) {
    const std::string told = fault(scene_of(good + ",\n" + object));
    EXPECT_NE(told.find(expected), std::string::npos)
        << object << "\n  told:     " << told << "\n  expected: " << expected;
    EXPECT_EQ(told.find('\n'), std::string::npos) << told;
  }
}

TEST(SceneFile, FaultsOfTheWholeAreTold) {
  EXPECT_EQ(fault("{\"objects\": []}"), "props.json: the key 'version' is missing");
  EXPECT_EQ(fault("{\"version\": 2}"), "props.json:1: version: this roadgen reads version 1");
  EXPECT_NE(fault("{\"version\": 1,\n\"object\": []}").find("props.json:2: unknown key 'object'"), std::string::npos);
  EXPECT_NE(fault("{\"version\": 1, \"objects\": 7}").find("objects: expected an array, found a number"),
            std::string::npos);
  EXPECT_NE(fault("[]").find("props.json:1: expected an object"), std::string::npos) << fault("[]");
  EXPECT_NE(fault("{\"version\": 1, \"objects\": [\n\n{\"type\"").find("props.json:3: not JSON: "), std::string::npos);
  EXPECT_NE(
      fault("{\"version\": 1, \"materials\": {\"a\": {\"ior\": 9}}}").find("materials.a: the index of refraction"),
      std::string::npos);
  EXPECT_NE(fault("{\"version\": 1, \"materials\": {\"a\": {\"base_color\": \"red\"}}}")
                .find("materials.a.base_color: a colour"),
            std::string::npos);
  EXPECT_EQ(fault("{\"version\": 1}"), "none");
  EXPECT_EQ(fault("{\"version\": 1, \"objects\": []}"), "none");
  EXPECT_NE(fault("").find("not JSON"), std::string::npos);
  // Deeper than a reader should follow.
  EXPECT_NE(fault("{\"version\": 1, \"objects\": " + std::string(100000, '[')).find("nested too deep"),
            std::string::npos);
}

TEST(SceneFile, AMillionInstancesOfAMillionAreRefusedBeforeTheyAreMade) {
  std::string instances;
  for (int i = 0; i < 4000; ++i) instances += i ? ",{}" : "{}";
  const std::string object = "{\"type\": \"group\", \"instances\": [" + instances +
                             "], \"objects\": [{\"type\": \"sphere\", \"center\": [0,0,0], " +
                             "\"radius\": 1, \"instances\": [" + instances + "]}]}";
  EXPECT_NE(fault(scene_of(object)).find("more than 10 million objects"), std::string::npos);
}

// A road that turns and climbs: an object on it is upright, at its height, turned with it; twice the same place is the
// same place.
TEST(SceneFile, ObjectsStandOnTheirRoads) {
  Network network;
  network.roads.push_back(testing::road_along(
      "hill", 400, 20, 4,
      [](double s) {
        const double angle = s / 200;
        return testing::Station{200.0 * glm::dvec2(std::cos(angle), std::sin(angle)), angle + std::numbers::pi / 2};
      },
      [](double s) { return 10 + 0.08 * s; }));
  const RoadIndex index(network);
  TemporaryFolder folder;
  folder.put("two.xyzr", "0 0 0 1\n2 0 0 1\n");
  const std::string path = folder.put("props.json", scene_of(R"(
    {"type": "cylinder", "from": [1, 2, 0], "to": [1, 2, 5], "radius": 0.1,
     "place": {"road": "hill", "s": 100, "t": 6, "h": 0.5, "heading": 1.5707963267948966}},
    {"type": "spheres", "file": "two.xyzr", "place": {"road": "hill", "s": 200}},
    {"type": "sphere", "center": [0, 0, 0], "radius": 1})"));
  auto read = read_scene(path);
  ASSERT_TRUE(read.ok()) << read.error().text();
  ASSERT_EQ(read->placements.size(), 2u);
  const Status placed = place_on_roads(read->placements, index, read->scene);
  ASSERT_TRUE(placed.ok()) << placed.error().text();

  const RoadPose pose = index.to_world({0, 100, 6});
  const Object& pole = read->scene.objects[0];
  const glm::dvec3 foot(pole.transform * glm::dvec4(1, 2, 0, 1)), top(pole.transform * glm::dvec4(1, 2, 5, 1));
  EXPECT_NEAR(glm::length(top - foot - glm::dvec3(0, 0, 5)), 0, 1e-12);
  // Turned by a right angle: its x points to the road's left, its y back.
  const glm::dvec3 ahead(std::cos(pose.heading_rad), std::sin(pose.heading_rad), 0), left(-ahead.y, ahead.x, 0);
  const glm::dvec3 expected = pose.position_m + glm::dvec3(0, 0, 0.5) + left - 2.0 * ahead;
  EXPECT_NEAR(glm::length(foot - expected), 0, 1e-9);
  EXPECT_NEAR(foot.z, 10 + 0.08 * 100 + 0.5, 0.05);

  const SphereSet& set = read->scene.sphere_sets[0];
  const RoadPose at = index.to_world({0, 200, 0});
  EXPECT_NEAR(glm::length(set.origin_m + glm::dvec3(set.items[0].center) - at.position_m), 0, 1e-6);
  EXPECT_EQ(read->scene.objects[1].transform, glm::dmat4(1.0));

  // Faults name the file, the line and the path, and leave the scene as it was.
  for (const auto& [place, told] : {std::pair{"{\"road\": \"dale\", \"s\": 1}", "there is no road 'dale'"},
                                    std::pair{"{\"road\": \"hill\", \"s\": 401}", "s must lie on the road: 0 to "},
                                    std::pair{"{\"road\": \"hill\", \"s\": -1}", "s must lie on the road: 0 to "}}) {
    auto bad =
        parse_scene(scene_of(std::string("{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1,\n \"place\": ") +
                             place + "}"),
                    "props.json");
    ASSERT_TRUE(bad.ok());
    const Status status = place_on_roads(bad->placements, index, bad->scene);
    ASSERT_FALSE(status.ok());
    EXPECT_NE(status.error().text().find(std::string("props.json:3: objects[0].place: ") + told), std::string::npos)
        << status.error().text();
    EXPECT_EQ(bad->scene.objects[0].transform, glm::dmat4(1.0));
  }
}

// Beside the road the ground counts, on it and beside its bridge the road.
TEST(SceneFile, ObjectsBesideRoadsStandOnTheGround) {
  Network network;
  network.roads.push_back(testing::road_along(
      "level", 400, 20, 4,
      [](double s) {
        return testing::straight({0, 0}, 0, s);
      },
      [](double) { return 30.0; }));
  network.roads[0].bridges.push_back({.s_start_m = 300, .s_end_m = 350});
  const auto terrain = Terrain::build(network, nullptr);
  ASSERT_TRUE(terrain.ok()) << terrain.error().text();
  const RoadIndex index(network);
  SceneFile file = read(scene_of(R"(
    {"type": "sphere", "center": [0, 0, 0], "radius": 1, "place": {"road": "level", "s": 100, "t": 3}},
    {"type": "sphere", "center": [0, 0, 0], "radius": 1, "place": {"road": "level", "s": 100, "t": 90, "h": 0.5}},
    {"type": "sphere", "center": [0, 0, 0], "radius": 1, "place": {"road": "level", "s": 320, "t": 90}})"));
  ASSERT_TRUE(place_on_roads(file.placements, index, file.scene).ok());
  stand_on_ground(file.placements, index, *terrain, file.scene);
  const auto& objects = file.scene.objects;
  EXPECT_NEAR(objects[0].transform[3].z, 30, 1e-9);
  const double ground_m = terrain->height_m({100, 90});
  EXPECT_GT(std::abs(ground_m - 30), 0.05);  // else this says nothing
  EXPECT_NEAR(objects[1].transform[3].z, ground_m + 0.5, 1e-9);
  EXPECT_NEAR(objects[2].transform[3].z, 30, 1e-9);
}

TEST(PointCloud, XyzrHasPositionsRadiiAndColoursByElement) {
  const auto set = parse_point_cloud("# a comment\n1 2 3 1.5 C\r\n\n5 2 3 0.5 Xx\n3 8 3 1\n", "a.xyzr");
  ASSERT_TRUE(set.ok()) << set.error().text();
  ASSERT_EQ(set->items.size(), 3u);
  EXPECT_EQ(set->name, "a.xyzr");
  EXPECT_EQ(set->origin_m, glm::dvec3(3, 5, 3));
  EXPECT_EQ(glm::dvec3(set->items[0].center) + set->origin_m, glm::dvec3(1, 2, 3));
  EXPECT_EQ(set->items[0].radius, 1.5f);
  EXPECT_EQ(set->items[0].color[0], 0x90);
  EXPECT_EQ(set->items[1].color[0], 255);  // unknown: pink
  EXPECT_EQ(set->items[1].color[1], 20);
  EXPECT_EQ(set->items[2].color[1], 255);  // none: white
}

TEST(PointCloud, PdbHasElementsByColumnAndOneOfAlternatePlaces) {
  const std::string pdb =
      "HEADER\n"
      "ATOM      1  N   THR A   1      17.047  14.099   3.625  1.00 13.79           N  \n"
      "ATOM      2  CA ATHR A   1      16.967  12.784   4.338  0.50 10.80           C  \n"
      "ATOM      3  CA BTHR A   1      16.900  12.700   4.300  0.50 10.80           C  \n"
      "HETATM    4 CA    CA A 101      10.000  10.000   1.000  1.00 10.80          CA  \n"
      "ENDMDL\n"
      "ATOM      1  N   THR A   1      99.047  14.099   3.625  1.00 13.79           N  \n";
  const auto set = parse_point_cloud(pdb, "a.pdb");
  ASSERT_TRUE(set.ok()) << set.error().text();
  ASSERT_EQ(set->items.size(), 3u);
  EXPECT_EQ(set->items[0].radius, 1.55f);
  EXPECT_EQ(set->items[1].radius, 1.70f);  // an alpha carbon
  EXPECT_EQ(set->items[2].radius, 2.31f);  // calcium
  EXPECT_NEAR(set->items[0].center.x + set->origin_m.x, 17.047, 1e-5);
  EXPECT_EQ(set->items[0].color[2], 0xF8);
}

std::string ply_bytes() {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\ncomment made by hand\nelement camera 1\nproperty list uchar float a\n"
      "element vertex 2\nproperty double x\nproperty float y\nproperty short z\nproperty uchar red\nproperty uchar "
      "green\n"
      "property uchar blue\nproperty float radius\nelement face 1\nproperty list uchar int "
      "vertex_indices\nend_header\n";
  const auto put = [&](auto x) { bytes.append(reinterpret_cast<const char*>(&x), sizeof x); };
  put(std::uint8_t{2}), put(1.0f), put(2.0f);
  for (int i = 0; i < 2; ++i) {
    put(1.5 + i), put(2.5f), put(std::int16_t{-3});
    put(std::uint8_t{10}), put(std::uint8_t{20}), put(std::uint8_t{30}), put(0.25f);
  }
  put(std::uint8_t{3}), put(0), put(1), put(1);
  return bytes;
}

TEST(PointCloud, PlyIsReadInBothForms) {
  const auto binary = parse_point_cloud(ply_bytes(), "a.ply");
  ASSERT_TRUE(binary.ok()) << binary.error().text();
  const auto ascii = parse_point_cloud(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nproperty float "
      "red\n"
      "property float green\nproperty float blue\nend_header\n1.5 2.5 -3 0.0392157 0.0784314 0.1176471\n2.5 2.5 -3 1 0 "
      "0\n",
      "a.ply", {.radius = 0.25});
  ASSERT_TRUE(ascii.ok()) << ascii.error().text();
  for (const SphereSet& set : {*binary, *ascii}) {
    ASSERT_EQ(set.items.size(), 2u);
    EXPECT_EQ(set.origin_m, glm::dvec3(2, 2.5, -3));
    EXPECT_EQ(set.items[0].center, glm::vec3(-0.5f, 0, 0));
    EXPECT_EQ(set.items[0].radius, 0.25f);
    EXPECT_EQ(set.items[0].color[0], 10);
    EXPECT_EQ(set.items[0].color[2], 30);
  }
}

TEST(PointCloud, FaultsAreToldWithTheLine) {
  const auto told = [](const std::string& text, const char* file) {
    const auto set = parse_point_cloud(text, file);
    return set.ok() ? std::string("none") : set.error().text();
  };
  EXPECT_EQ(told("1 2 3 1\n1 2 x 1\n", "a.xyzr"), "a.xyzr:2: 'x' is not a number");
  EXPECT_NE(told("1 2 3\n", "a.xyzr").find("a.xyzr:1: expected x y z radius"), std::string::npos);
  EXPECT_EQ(told("1 2 3 -1\n", "a.xyzr"), "a.xyzr:1: the radius must be greater than 0");
  EXPECT_EQ(told("1 2 nan 1\n", "a.xyzr"), "a.xyzr:1: a coordinate is not finite, or beyond 1e9");
  EXPECT_EQ(told("# nothing\n", "a.xyzr"), "a.xyzr: has no points");
  EXPECT_NE(told("ATOM      1  N   THR A   1      17.047\n", "a.pdb").find("a.pdb:1: columns 31 to 54"),
            std::string::npos);
  EXPECT_NE(told("x", "a.obj").find("point clouds are .pdb, .xyzr or .ply"), std::string::npos);
  EXPECT_NE(told("ply\nformat binary_big_endian 1.0\n", "a.ply").find("a.ply:2: expected 'format"), std::string::npos);
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  EXPECT_NE(told(head + "end_header\n1 2 3\n", "a.ply").find("give a radius for all"), std::string::npos);
  EXPECT_NE(told(head, "a.ply").find("end_header"), std::string::npos);
  // Every cut of a binary file is told, none is read as whole before the last vertex.
  const std::string bytes = ply_bytes();
  for (std::size_t size = 0; size + 13 < bytes.size(); ++size) {
    EXPECT_NE(told(bytes.substr(0, size), "a.ply"), "none") << size;
  }
  // A count that no memory holds, and lists of a length that no file has.
  std::string huge = bytes;
  huge.replace(huge.find("element vertex 2"), 16, "element vertex 999999999999");
  EXPECT_NE(told(huge, "a.ply").find("the data end early"), std::string::npos);
}

TEST(PointCloud, TheSharedMoleculesAreRead) {
  const std::filesystem::path folder = std::filesystem::path(ROADGEN_SOURCE_DIR) / "../shared/data/geometry/pdb";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no ../shared/data";
  const auto crambin = read_point_cloud((folder / "1crn.pdb").string());
  ASSERT_TRUE(crambin.ok()) << crambin.error().text();
  EXPECT_EQ(crambin->items.size(), 327u);
  const auto ribosome = read_point_cloud((folder / "ribosome_4V5A_first99130.xyzr").string());
  ASSERT_TRUE(ribosome.ok()) << ribosome.error().text();
  EXPECT_EQ(ribosome->items.size(), 99130u);
}

}  // namespace
}  // namespace roadgen
