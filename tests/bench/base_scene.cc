#include "tests/bench/base_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/render/flight.h"

namespace roadgen::bench {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kGap_m = 0.1;  // of the ground below the road

// Hills that repeat every side.
double natural_m(glm::dvec2 p, double hills_m) {
  const glm::dvec2 a = p * (kTurn / kSide_m);
  return 20 + hills_m * (std::sin(2 * a.x) * std::cos(a.y) + 0.4 * std::sin(3 * a.x + 1) * std::sin(2 * a.y));
}

// A closed curve whose bends turn it by about 28 degrees a segment, as the paper's triangle counts tell.
glm::dvec2 course(double turn) {
  const double a = kTurn * turn;
  const double radius = 235 + 55 * std::sin(5 * a) + 8 * std::sin(17 * a + 1);
  return glm::dvec2(kSide_m / 2) + radius * glm::dvec2(std::cos(a), std::sin(a));
}

Result<Road> road_of(std::size_t anchors, double hills_m) {
  std::vector<Anchor> along;
  for (std::size_t i = 0; i < anchors; ++i) {
    const glm::dvec2 p = course(static_cast<double>(i) / static_cast<double>(anchors));
    along.push_back({.position_m = p, .elevation_m = natural_m(p, hills_m)});
  }
  return road_from_anchors(along, {.closed = true});
}

// The hills on a grid, each vertex lower than the road is anywhere within a cell's diagonal: so is every triangle below
// the road.
TerrainMesh ground_of(const Road& road, double hills_m) {
  constexpr double kCell_m = kSide_m / kGroundCells;
  std::vector<glm::dvec3> places;
  for (double s = 0; s < road.length_m(); s += 1) {
    for (const double t : {-4.0, 0.0, 4.0}) places.push_back(pose_at(road, s, t).position_m);
  }
  TerrainMesh mesh;
  for (int j = 0; j <= kGroundCells; ++j) {
    for (int i = 0; i <= kGroundCells; ++i) {
      const glm::dvec2 p = kCell_m * glm::dvec2(i, j);
      double z = natural_m(p, hills_m) - kGap_m;
      for (const glm::dvec3& place : places) {
        if (glm::distance(glm::dvec2(place), p) < 1.5 * kCell_m) z = std::min(z, place.z - kGap_m);
      }
      const glm::dvec2 slope(natural_m(p + glm::dvec2(0.5, 0), hills_m) - natural_m(p - glm::dvec2(0.5, 0), hills_m),
                             natural_m(p + glm::dvec2(0, 0.5), hills_m) - natural_m(p - glm::dvec2(0, 0.5), hills_m));
      mesh.positions_m.emplace_back(p.x, p.y, z);
      mesh.normals.emplace_back(glm::normalize(glm::dvec3(-slope, 1)));
      if (i == kGroundCells || j == kGroundCells) continue;
      const auto v = static_cast<std::uint32_t>(j * (kGroundCells + 1) + i);
      const std::uint32_t above = v + kGroundCells + 1;
      mesh.triangles.insert(mesh.triangles.end(), {v, v + 1, above + 1, v, above + 1, above});
    }
  }
  return mesh;
}

}  // namespace

Result<BaseScene> base_scene(double hills_m) {
  // Where a segment between two anchors is split, fewer anchors make the number.
  for (std::size_t anchors = kBaseSegments; anchors >= kBaseSegments / 2; --anchors) {
    auto road = road_of(anchors, hills_m);
    if (!road) return road.error();
    if (road->segments.size() != kBaseSegments) continue;
    TerrainMesh ground = ground_of(*road, hills_m);
    return BaseScene{std::move(*road), std::move(ground)};
  }
  return Error{ErrorCode::kData, "no number of anchors gives the base scene's number of segments"};
}

std::vector<glm::dvec3> copy_origins(int n) {
  std::vector<glm::dvec3> origins;
  for (int j = -n / 2; j <= n / 2; ++j) {
    for (int i = -n / 2; i <= n / 2; ++i) origins.emplace_back(i * kSide_m, j * kSide_m, 0);
  }
  return origins;
}

Network copies_of(const Road& road, std::span<const glm::dvec3> origins) {
  Network network;
  for (const glm::dvec3& origin : origins) {
    Road& copy = network.roads.emplace_back(road);
    copy.id = std::to_string(network.roads.size());
    for (Segment& segment : copy.segments) {
      segment.start_m += glm::dvec2(origin);
      segment.end_m += glm::dvec2(origin);
    }
  }
  return network;
}

std::vector<TerrainMesh> copies_of(const TerrainMesh& ground, std::span<const glm::dvec3> origins) {
  std::vector<TerrainMesh> tiles(origins.size(), ground);
  for (std::size_t i = 0; i < tiles.size(); ++i) tiles[i].origin_m += origins[i];
  return tiles;
}

std::vector<Camera> views(const BaseScene& scene, int count) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double s = scene.road.length_m() * i / count;
    cameras.push_back(i % 2 == 0 ? drive_camera(scene.road, s, -1.75, 1.3) : flight_camera(scene.road, s, {}));
    cameras.back().fov_deg = 45;
    cameras.back().far_m = 1.5 * kSide_m;
  }
  return cameras;
}

}  // namespace roadgen::bench
