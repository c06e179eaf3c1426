// The ground of a picture against the roads, pixel by pixel, by rays in double: what none of its pixels may show.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/query/road_index.h"
#include "roadgen/render/camera.h"
#include "roadgen/render/renderer.h"
#include "roadgen/road/link.h"
#include "terrain/levelling.h"
#include "terrain/terrain.h"

namespace roadgen::test {

struct GroundCounts {
  std::size_t road = 0, ground = 0, structure = 0;
  std::size_t in_tunnels = 0;  // pixels of ground inside a tunnel's clear space
  std::size_t above = 0;       // above a carriageway that no hill covers
  std::size_t through = 0;     // behind a carriageway that the ray meets first, from above
  std::size_t off_mesh = 0;    // elsewhere than the terrain tells
  // Behind a carriageway that the ray meets first, but that is not there without the ground either: no fault of its.
  std::size_t lost = 0;
  glm::dvec3 first_fault_m{0, 0, 0};

  // Of off_mesh: where a triangle is seen edge on, what the rasterizer rounds may take a pixel's place beyond its end.
  static constexpr double kMostOffMesh = 1e-5;
  bool is_on_mesh() const {
    return static_cast<double>(off_mesh) <= std::max(1.0, kMostOffMesh * static_cast<double>(ground));
  }

  std::size_t faults() const { return in_tunnels + above + through; }
  void print(const char* name) const {
    std::printf(
        "%s: %zu pixels of road, %zu of structures, %zu of ground: %zu in tunnels, %zu above roads, %zu through "
        "roads, %zu off the mesh; the first at %.2f, %.2f, %.2f; %zu where the road is not drawn without ground "
        "either\n",
        name, road, structure, ground, in_tunnels, above, through, off_mesh, first_fault_m.x, first_fault_m.y,
        first_fault_m.z, lost);
  }
};

class GroundRays {
 public:
  // Both must outlive this.
  GroundRays(const Network& network, const Terrain& terrain)
      : network_(network), terrain_(terrain), index_(network), in_area_(roads_in_areas(network)) {
    const Rectangle& area = terrain.report().area;
    Grid grid;
    grid.origin_m = area.low_m;
    grid.step_m = {kPost_m, kPost_m};
    grid.columns = static_cast<int>((area.high_m.x - area.low_m.x) / kPost_m) + 2;
    grid.rows = static_cast<int>((area.high_m.y - area.low_m.y) / kPost_m) + 2;
    grid.values.resize(static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows));
    distance_ = distance_from_roads(network, grid);
    for (const Road& road : network.roads) {
      for (const Segment& segment : road.segments) widest_m_ = std::max(widest_m_, segment.max_half_width_m());
    }
    for (const Junction& junction : network.junctions) {
      const Bounds b = bounds(junction);
      widest_m_ = std::max(widest_m_, 0.5 * glm::length(glm::dvec2(b.high_m - b.low_m)));
    }
  }

  // frame: of kLabel and kDepth. without_ground: gives the same of the roads alone, where it is asked for.
  template <class WithoutGround>
  void count(const Frame& frame, const Camera& camera, GroundCounts& counts, WithoutGround&& without_ground) const {
    std::optional<Frame> bare;
    const int width = frame.label.width, height = frame.label.height;
    const double pixel = 2 * std::tan(camera.fov_deg * M_PI / 360) / height;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const auto label = static_cast<Label>(frame.label.at(x, y, 0));
        counts.road += label == Label::kCarriageway || label == Label::kMarking;
        counts.structure += label == Label::kStructure;
        if (label != Label::kGround) continue;
        ++counts.ground;
        const double depth = static_cast<double>(frame.depth_m.at(x, y, 0));
        const glm::dvec3 ray = pixel_ray(camera, width, height, x, y), seen = camera.position_m + depth * ray;
        // The rasterizer snaps vertices to 1/256 of a pixel: as in ground_test.
        const double room = std::max(0.01, 0.01 * pixel * depth);
        const std::size_t before = counts.faults();
        counts.in_tunnels += is_in_tunnel(seen, room);
        counts.above += is_above_road(seen);
        if (meets_road(camera.position_m, seen)) {
          if (!bare) bare.emplace(without_ground());
          const auto there = static_cast<Label>(bare->label.at(x, y, 0));
          const bool is_road = there == Label::kCarriageway || there == Label::kMarking;
          ++(is_road && bare->depth_m.at(x, y, 0) <= frame.depth_m.at(x, y, 0) ? counts.through : counts.lost);
        }
        counts.off_mesh += !is_on_mesh(camera, seen, room);
        if (before == 0 && counts.faults() > 0) counts.first_fault_m = seen;
      }
    }
  }

 private:
  static constexpr double kPost_m = 4, kStep_m = 0.25, kEdge_m = 0.01, kLeg_m = 5;

  // Whether the terrain tells a tunnel's floor there.
  bool is_under_hill(glm::dvec3 p) const { return terrain_.height_m(p) != terrain_.height_m(glm::dvec2(p)); }
  // Inside a tunnel's clear space by more than `room`.
  bool is_in_tunnel(glm::dvec3 p, double room) const {
    if (!is_under_hill(p) || p.z < terrain_.height_m(p) + room + 0.02) return false;
    for (int axis = 0; axis < 3; ++axis) {
      for (const double sign : {-1.0, 1.0}) {
        glm::dvec3 q = p;
        q[axis] += sign * room;
        if (!is_under_hill(q)) return false;
      }
    }
    return true;
  }
  // Whether the mesh is within `room` of the point, up or across the view: where it is seen edge on, what the rasterizer
  // rounds across the view moves a pixel's place a long way along it.
  bool is_on_mesh(const Camera& camera, glm::dvec3 p, double room) const {
    const ViewAxes axes = view_axes(camera);
    double least = 1e300, most = -1e300;
    for (const glm::dvec3& d : {glm::dvec3(0), axes.right, -axes.right, axes.up, -axes.up}) {
      const glm::dvec3 q = p + room * d;
      const double over = q.z - terrain_.height_m(glm::dvec2(q));
      least = std::min(least, over), most = std::max(most, over);
    }
    return least < room && most > -room;
  }

  struct Over {
    std::uint32_t road;
    std::int32_t junction;
    double s_m;
    double height_m;
    // Of one leg: a road that winds down a hill lies beside itself, and between its legs nothing is met.
    bool is_with(const Over& other) const {
      return road == other.road && junction == other.junction && std::abs(s_m - other.s_m) < kLeg_m;
    }
  };
  using Found = std::array<RoadPoint, 12>;
  // Calls visit(road or area, height over it) for every carriageway under or over the point.
  template <class Visit>
  void each_road(glm::dvec3 p, Visit&& visit) const {
    Found found;
    const std::size_t n = std::min(index_.candidates(p, 0, found), found.size());
    for (std::size_t i = 0; i < n; ++i) {
      const RoadPoint& at = found[i];
      if (at.outside_m > 0) continue;
      if (at.junction < 0 && in_area_[at.at.road]) continue;
      visit(Over{at.junction < 0 ? at.at.road : 0, at.junction, at.junction < 0 ? at.s_m : 0, at.height_m});
    }
  }
  bool is_on(const Over& same, glm::dvec3 p) const {
    bool on = false;
    each_road(p, [&](const Over& o) { on = on || o.is_with(same); });
    return on;
  }
  bool is_well_inside(const Over& same, glm::dvec3 p) const {
    for (const glm::dvec2 d : {glm::dvec2(1, 0), glm::dvec2(-1, 0), glm::dvec2(0, 1), glm::dvec2(0, -1)}) {
      if (!is_on(same, p + glm::dvec3(kEdge_m * d, 0))) return false;
    }
    return true;
  }

  bool is_above_road(glm::dvec3 seen) const {
    bool above = false;
    each_road(seen, [&](const Over& o) {
      // Just above the road's surface a place under a hill is in its tunnel.
      const glm::dvec3 on_road = seen - glm::dvec3(0, 0, o.height_m - 0.3);
      above = above || (o.height_m > 0 && !is_under_hill(on_road) && is_well_inside(o, seen));
    });
    return above;
  }

  // Whether the way from the eye to the point comes down through a carriageway.
  bool meets_road(glm::dvec3 eye, glm::dvec3 seen) const {
    const glm::dvec3 way = seen - eye;
    const double length = std::max(glm::length(glm::dvec2(way)), 1e-9);
    if (way.z >= 0) return false;
    std::vector<Over> before, now;
    for (double at = 0, last = 0;;) {
      const glm::dvec3 p = eye + way * (at / length);
      const double free = sample_bilinear(distance_, glm::dvec2(p)) - 3 * kPost_m - widest_m_;
      now.clear();
      if (free <= 0) each_road(p, [&](const Over& o) { now.push_back(o); });
      for (const Over& o : now) {
        for (const Over& b : before) {
          if (!b.is_with(o) || !(b.height_m > 0 && o.height_m < 0)) continue;
          const glm::dvec3 crossing = p - way * ((at - last) / length) * (o.height_m / (o.height_m - b.height_m));
          if (is_well_inside(o, crossing)) return true;
        }
      }
      before.swap(now);
      if (at >= length) return false;
      last = at;
      at = std::min(at + std::max(free, kStep_m), length);
    }
  }

  const Network& network_;
  const Terrain& terrain_;
  RoadIndex index_;
  std::vector<bool> in_area_;
  Grid distance_;
  double widest_m_ = 0;
};

}  // namespace roadgen::test
