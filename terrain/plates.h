// What is proven of the heights of all carriageways: rectangles with a plane each, near which the surface lies.
//
// A plate covers a few metres of a road on one side of its reference line, or a square of a junction's area. Its plane
// and its error come from interval arithmetic over all of it, not from samples: no point of the carriageway in the
// plate's rectangle is farther from the plane than the error. So a triangle of ground can be held against the roads
// above it by comparing linear functions.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "roadgen/query/box_tree.h"
#include "roadgen/road/network.h"
#include "terrain/clipped.h"
#include "terrain/overlap.h"
#include "terrain/support.h"

namespace roadgen {

struct Plate {
  glm::dvec2 center_m{0, 0};
  glm::dvec2 axis{1, 0};    // unit: along the road
  glm::dvec2 half_m{0, 0};  // half the rectangle's size along the axis and across
  double z_m = 0;           // of the plane at the centre
  glm::dvec2 slope{0, 0};   // of the plane, along the axis and across
  double error_m = 0;       // the carriageway's surface, its lowest lane, lies within this of the plane
  bool on_ground = true;    // false on bridges that the network knows of
  bool levelled = true;     // the ground is levelled to it; on_ground, and not over other roads

  void set_support(Support support, bool is_assumed) {
    levelled = support == Support::kGround;
    on_ground = levelled || is_assumed;
  }
  // Height of the plane, and its slope.
  double height_m(glm::dvec2 point_m) const;
  glm::dvec2 gradient() const;
  // The corners of where this rectangle lies over the other one, z being by how much. Empty: nowhere.
  Clipped above(const Plate& low) const;
};

// The lowest height of any lane of the segment's section, at most 0.
double lowest_lane_m(const Road& road, const Segment& segment);

// Bounds of how far carriageways lie above a triangle of ground, over what of it lies under them.
struct ClearanceBounds {
  double least_m = std::numeric_limits<double>::infinity();  // of every carriageway
  double most_m = -std::numeric_limits<double>::infinity();  // of those that the ground is levelled to
  // What of most_m - least_m is not known but for the planes' errors.
  double error_m = 0;
  bool touches() const { return least_m < std::numeric_limits<double>::infinity(); }
};

class Plates {
 public:
  // Of all roads that are drawn and all junction areas, but for those in tunnels under higher ground. Those of bridges are not
  // levelled. wanted_error_m: plates are divided until their error is at most this, or they are 0.2 m long. Cost: about
  // 2 us a plate, of which a road has one per 2 to 8 m and side.
  explicit Plates(const Network& network, const Supports& supports = {}, double wanted_error_m = 0.004);

  // Finds where a carriageway that is on no bridge lies over another one by more than apart_m: no height of the ground
  // suits both. Cost: about 1 us a plate.
  void find_overlaps(double apart_m);
  // Clears `levelled` of roads over others that no bridge is known of: of plates within reach_m of an overlap where the
  // ground, a function of the place, does not come within below_m of the plate's plane at its middle and towards its
  // corners. Requires: find_overlaps.
  void find_levelled(const std::function<double(glm::dvec2)>& ground_m, double below_m, double reach_m);
  // Of the overlaps within about reach_m of the triangle that where they are farthest apart. Any number of threads may ask.
  // Cost: O(log n).
  std::optional<Overlap> overlap(const std::array<glm::dvec3, 3>& triangle, double reach_m) const;
  std::optional<Overlap> overlap(const Plate& plate, double reach_m) const;

  // Proven: the carriageways lie above the plane of the triangle by at least least_m, and those that are levelled by at
  // most most_m, at every point of the triangle that is under them. x, y, z in metres, any orientation.
  // Any number of threads may ask. Cost: O(log n + plates about).
  ClearanceBounds over(const std::array<glm::dvec3, 3>& triangle) const;

  const std::vector<Plate>& all() const { return plates_; }

 private:
  std::optional<Overlap> worst_overlap(const Box& about, double reach_m) const;

  std::vector<Plate> plates_;
  BoxTree tree_;
  std::vector<Overlap> overlaps_;
  BoxTree overlap_tree_;
};

}  // namespace roadgen
