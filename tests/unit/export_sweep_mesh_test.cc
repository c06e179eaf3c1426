// Meshes of structures along roads against the functions that the picture shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include <glm/geometric.hpp>

#include "roadgen/export/mesh.h"
#include "roadgen/fit/catmull_rom.h"
#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

constexpr double kFloat_m = 1e-4;  // of positions, as the header says

const std::vector<Sweep>& kinds() {
  static const std::vector<Sweep> all = {
      {.s_end_m = 1e9, .t_m = 0.3, .shape = Tunnel{}},
      {.s_end_m = 1e9, .t_m = 0, .shape = Tunnel{.wall_height_m = 0, .head_wall_m = 0, .walkway_m = 2}},
      {.s_end_m = 1e9, .shape = Tunnel{.arch_rise_m = 1.2, .walkway_m = 0}},
      {.s_start_m = 3, .s_end_m = 1e9, .t_m = -5, .t_slope = 0.02, .shape = GuardRail{}},
      {.s_end_m = 1e9, .t_m = 5, .shape = GuardRail{.post_spacing_m = 0}},
      {.s_end_m = 1e9, .t_m = 6, .shape = Pipe{}},
      {.s_end_m = 1e9, .t_m = -7, .t_slope = -0.01, .shape = Cable{.radius_m = 0.05}},
  };
  return all;
}

// A winding road over hills with one sweep.
Network with_sweep(Sweep sweep, std::size_t count) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Anchor> anchors;
  double heading = 0.7;
  glm::dvec2 at(300, -200);
  for (std::size_t i = 0; i < count; ++i) {
    anchors.push_back({.position_m = at, .elevation_m = 2 * unit(random), .half_width_m = 4});
    heading += 0.3 * unit(random);
    at += (45 + 10 * unit(random)) * glm::dvec2(std::cos(heading), std::sin(heading));
  }
  Result<Road> road = road_from_anchors(anchors, {});
  EXPECT_TRUE(road.ok());
  road->id = "w";
  for (Segment& s : road->segments) s.superelevation_rad = {0.02, 0, 0, 0};
  sweep.s_end_m = std::min(sweep.s_end_m, road->length_m());
  EXPECT_TRUE(problems(*road, sweep).empty());
  road->sweeps = {std::move(sweep)};
  Network network;
  network.roads.push_back(std::move(*road));
  return network;
}

struct Triangle {
  glm::dvec3 p[3], normal[3];
};

std::vector<Triangle> triangles_of(const NetworkMesh& mesh) {
  std::vector<Triangle> all;
  for (const MeshItem& item : mesh.items) {
    if (!item.name.starts_with("structure")) continue;
    for (const MeshPart& part : item.parts) {
      for (std::size_t i = 0; i < part.triangles.size(); i += 3) {
        Triangle t;
        for (std::size_t k = 0; k < 3; ++k) {
          t.p[k] = item.origin_m + glm::dvec3(part.positions[part.triangles[i + k]]);
          t.normal[k] = part.normals[part.triangles[i + k]];
        }
        all.push_back(t);
      }
    }
  }
  return all;
}

glm::dvec3 in_chord_axes(const Segment& segment, glm::dvec3 p) {
  const glm::dvec2 axis = glm::normalize(segment.chord_m());
  const glm::dvec3 d = p - glm::dvec3(segment.start_m, segment.elevation_m.c0);
  return {axis.x * d.x + axis.y * d.y, axis.x * d.y - axis.y * d.x, d.z};
}

// How far a point is from the profile, or from the nearest post: |D| where it lies between the ends of a part.
double off_m(const Road& road, const std::vector<SweepPart>& parts, glm::dvec3 p) {
  double least = 1e9;
  for (const SweepPart& part : parts) {
    const Lib::SweepPiece& piece = part.piece;
    const Segment& segment = road.segments[part.segment];
    const glm::dvec3 q = in_chord_axes(segment, p);
    const Lib::SweepPoint c = Lib::sweep_locate(q.x, q.y, q.z, 0.0, 0.0, 1.0, piece.path);
    const double s0 = arc_at(segment, piece.u0), s1 = arc_at(segment, piece.u1);
    const double inside = std::min(c.s - s0, s1 - c.s);
    const double d = Lib::sweep_distance(c.n, c.h, piece.profile);
    if (inside > -1e-3) least = std::min(least, std::abs(d) / lipschitz(part));
    if (std::abs(inside) < 1e-3) least = std::min(least, std::max(d, 0.0));  // a cap
    const Lib::SweepPosts& posts = piece.posts;
    for (int i = 0; i < static_cast<int>(posts.count); ++i) {
      const double s = posts.first + i * posts.spacing, u = u_at_arc(segment, s), heading = heading_rad(segment, u);
      const glm::dvec2 ahead(std::cos(heading), std::sin(heading)), left(-ahead.y, ahead.x);
      const double n = piece.path.n0 + piece.path.n1 * s + posts.n;
      const double z =
          segment.elevation_m.c0 + Lib::road_cubic(s, piece.path.z0, piece.path.z1, piece.path.z2, piece.path.z3);
      const glm::dvec2 d2 = glm::dvec2(p) - position_m(segment, u) - n * left;
      const double x = glm::dot(d2, ahead), y = glm::dot(d2, left);
      const double across = posts.half_s < 0 ? std::hypot(x, y) - posts.half_n
                                             : std::max(std::abs(x) - posts.half_s, std::abs(y) - posts.half_n);
      const double up = std::max(p.z - z - posts.high, z + posts.low - p.z);
      least = std::min(least, std::abs(std::max(across, up)));
    }
  }
  return least;
}

TEST(SweepMesh, LiesOnTheProfilesWithinTheStatedError) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0, 1);
  for (std::size_t kind = 0; kind < kinds().size(); ++kind) {
    const Network network = with_sweep(kinds()[kind], 6);
    const Road& road = network.roads[0];
    const std::vector<SweepPart> parts = sweep_parts(road, 0);
    std::size_t before = 1000000000;
    for (const double allowed_m : {0.001, 0.01, 0.1}) {
      SCOPED_TRACE(std::to_string(kind) + " at " + std::to_string(allowed_m));
      const auto mesh = tessellate(network, {.max_error_m = allowed_m});
      ASSERT_TRUE(mesh.ok()) << mesh.error().text();
      EXPECT_LE(mesh->error_m, allowed_m);
      const std::vector<Triangle> triangles = triangles_of(*mesh);
      ASSERT_GT(triangles.size(), 20u);
      EXPECT_LT(triangles.size(), before);
      before = triangles.size();
      double worst = 0;
      for (std::size_t i = 0; i < 3000; ++i) {
        const Triangle& t = triangles[random() % triangles.size()];
        double a = unit(random), b = unit(random);
        if (a + b > 1) a = 1 - a, b = 1 - b;
        worst = std::max(worst, off_m(road, parts, t.p[0] + a * (t.p[1] - t.p[0]) + b * (t.p[2] - t.p[0])));
      }
      EXPECT_LE(worst, allowed_m + kFloat_m);
    }
  }
}

// Whether a point lies in the solid, where rays begin with what is around them.
bool is_inside(const Road& road, const std::vector<SweepPart>& parts, glm::dvec3 p) {
  return std::any_of(parts.begin(), parts.end(), [&](const SweepPart& part) {
    const glm::dvec3 q = in_chord_axes(road.segments[part.segment], p);
    const Lib::SweepPoint c = Lib::sweep_locate(q.x, q.y, q.z, 0.0, 0.0, 1.0, part.piece.path);
    return Lib::sweep_distance(c.n, c.h, part.piece.profile) < 0.01;
  });
}

double distance_to_triangle(glm::dvec3 p, const Triangle& t) {
  const glm::dvec3 cross = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]), n = glm::normalize(cross);
  bool inside = true;
  double least = 1e300;
  for (int k = 0; k < 3; ++k) {
    const glm::dvec3 u = t.p[k], v = t.p[(k + 1) % 3];
    inside = inside && glm::dot(glm::cross(v - u, p - u), n) >= 0;
    const double w = std::clamp(glm::dot(p - u, v - u) / glm::dot(v - u, v - u), 0.0, 1.0);
    least = std::min(least, glm::distance(p, u + w * (v - u)));
  }
  return inside ? std::abs(glm::dot(p - t.p[0], n)) : least;
}

TEST(SweepMesh, WhatThePictureShowsIsInTheMesh) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(-1, 1);
  constexpr double kAllowed_m = 0.02, kMarch_m = 5e-4;  // where the ray search stops short of the surface
  for (std::size_t kind = 0; kind < kinds().size(); ++kind) {
    SCOPED_TRACE(kind);
    const Network network = with_sweep(kinds()[kind], 5);
    const Road& road = network.roads[0];
    const std::vector<SweepPart> parts = sweep_parts(road, 0);
    const auto mesh = tessellate(network, {.max_error_m = kAllowed_m});
    ASSERT_TRUE(mesh.ok());
    const std::vector<Triangle> triangles = triangles_of(*mesh);
    int met = 0;
    for (int i = 0; i < 4000 && met < 250; ++i) {
      // Toward a place on the structure from around it.
      const RoadPose pose = pose_at(road, 0.5 * (1 + unit(random)) * road.length_m(), road.sweeps[0].t_m);
      const glm::dvec3 to = pose.position_m + glm::dvec3(unit(random), unit(random), 4 * (1 + unit(random)));
      const glm::dvec3 from = to + 9.0 * glm::dvec3(unit(random), unit(random), unit(random));
      if (is_inside(road, parts, from)) continue;
      const glm::dvec3 direction = glm::normalize(to - from);
      double nearest = 1e9;
      for (const SweepPart& part : parts) {
        const auto found = cast(road, part, from, direction, 0);
        if (found) nearest = std::min(nearest, found->distance_m);
      }
      if (nearest > 30 || nearest < 0.01) continue;
      ++met;
      double off = 1e9;
      for (const Triangle& t : triangles) off = std::min(off, distance_to_triangle(from + nearest * direction, t));
      EXPECT_LE(off, kAllowed_m + kMarch_m + kFloat_m) << glm::distance(from, to);
    }
    EXPECT_GE(met, 50);
  }
}

TEST(SweepMesh, IsClosedAndFacesOutward) {
  for (std::size_t kind = 0; kind < kinds().size(); ++kind) {
    const Network network = with_sweep(kinds()[kind], 2);
    ASSERT_EQ(network.roads[0].segments.size(), 1u);
    const auto mesh = tessellate(network, {.max_error_m = 0.02});
    ASSERT_TRUE(mesh.ok());
    const std::vector<Triangle> triangles = triangles_of(*mesh);
    using Point = std::tuple<double, double, double>;
    std::map<std::pair<Point, Point>, int> edges;
    double volume = 0;
    for (const Triangle& t : triangles) {
      const glm::dvec3 face = glm::cross(t.p[1] - t.p[0], t.p[2] - t.p[0]);
      for (int k = 0; k < 3; ++k) {
        EXPECT_NEAR(glm::length(t.normal[k]), 1, 1e-6) << kind;
        EXPECT_GT(glm::dot(face, t.normal[k]), 0.2 * glm::length(face)) << kind;
        const glm::dvec3 a = t.p[k], b = t.p[(k + 1) % 3];
        ++edges[{{a.x, a.y, a.z}, {b.x, b.y, b.z}}];
      }
      const glm::dvec3 o = network.roads[0].segments[0].start_m.x * glm::dvec3(1, 0, 0);
      volume += glm::dot(t.p[0] - o, glm::cross(t.p[1] - o, t.p[2] - o)) / 6;
    }
    EXPECT_GT(volume, 0) << kind;
    for (const auto& [edge, count] : edges) {
      const auto back = edges.find({edge.second, edge.first});
      ASSERT_TRUE(back != edges.end() && back->second == count) << kind;
    }
  }
}

TEST(SweepMesh, ColoursArePartsOfTheirOwn) {
  Network network = with_sweep(kinds()[5], 3);
  Road& road = network.roads[0];
  road.sweeps.push_back(road.sweeps[0]);
  road.sweeps[1].albedo = glm::dvec3(0.5, 0.25, 0.125);
  const auto mesh = tessellate(network);
  ASSERT_TRUE(mesh.ok());
  std::map<std::string, glm::dvec3> found;
  for (const MeshItem& item : mesh->items) {
    for (const MeshPart& part : item.parts) found.emplace(part.name, part.albedo);
  }
  ASSERT_TRUE(found.contains("pipe"));
  EXPECT_EQ(found.at("pipe 0.5 0.25 0.125"), glm::dvec3(0.5, 0.25, 0.125));
}

}  // namespace
}  // namespace roadgen
