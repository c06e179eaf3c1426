// World to road and road to world: which road, and where along and across it, a point belongs to; and back.
//
//   const RoadIndex index(network);
//   RoadHint hint;                                                    // of one vehicle, kept from frame to frame
//   std::array<std::optional<RoadPoint>, 4> wheels;
//   index.to_road(contact_points_m, 5, wheels, &hint);                // road, s, t, lane, height of every wheel
//   RoadPose pose = index.to_world({.road = 3, .s_m = 120, .t_m = -1.75});
//
// Answers are exact: the foot of the perpendicular, in double, so that to_road(to_world(p)) is p. The pixel shader stops
// after two Newton steps; the picture's t and s differ from a query's by at most the segment's v_bound_m() and
// s_bound_m(), proven, 1e-4 of the half width by default.
//
// Roads in a junction's area (Road::junction) are found like all others, but the ground there is the area's: heights,
// slopes and normals are its, and RoadPoint::junction names it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "roadgen/query/area.h"
#include "roadgen/query/box_tree.h"
#include "roadgen/query/footprint.h"
#include "roadgen/query/large_pages.h"
#include "roadgen/road/network.h"

namespace roadgen {

// Where the last query of one series ended: makes the next one nearby faster, never different. Starts without knowledge.
// One per vehicle or wheel; not to be shared between threads. One of another index is harmless.
struct RoadHint {
  SegmentRef at;
};

// A place on network.roads[road].
struct RoadPlace {
  std::uint32_t road = 0;
  double s_m = 0;  // clamped to the road, wrapped where it is closed
  double t_m = 0;  // left positive; beyond the edges the surface goes on as it slopes
};

// Immutable after construction: any number of threads may ask. No query allocates but within(). Memory: size() and
// bytes().
class RoadIndex {
 public:
  // Requires: the network stays where it is and unchanged while the index is used. Cost: O(n log n), n segments.
  explicit RoadIndex(const Network& network);

  // The place of the point on the road that it belongs to: of all roads whose carriageway is within reach_m of it,
  // horizontally, the one
  //   1. that costs least: 0 where its carriageway holds the point, else 1 m and twice the distance from it; and, where a
  //      height is given, the vertical distance from its surface in steps of 1 cm. So a bridge is told from the road
  //      below, and a point on a road, up to 1 m above or below it, is never given to another road beside;
  //   2. that is drawn, before those in a junction's area;
  //   3. whose reference line is nearest, then the first in the network.
  // None where there is none, or the point is not finite. Requires: reach_m >= 0, may be infinite.
  // Accuracy: s and t to 1e-12 of the segment's chord and the rounding of coordinates; a point within kTouch_m of a
  // carriageway is on it. hint: read and set; the answer does not depend on it.
  // Cost: O(log n) for roads that do not all overlap; O(1) with a hint on the same road, not above 8 segments away.
  std::optional<RoadPoint> to_road(glm::dvec2 point_m, double reach_m, RoadHint* hint = nullptr) const;
  std::optional<RoadPoint> to_road(glm::dvec3 point_m, double reach_m, RoadHint* hint = nullptr) const;

  // The same for many points: with a hint each is the hint of the next, as for the wheels of a vehicle; without one the
  // searches run side by side, for points all over. Requires: as many answers as points.
  void to_road(std::span<const glm::dvec2> points_m, double reach_m, std::span<std::optional<RoadPoint>> found,
               RoadHint* hint = nullptr) const;
  void to_road(std::span<const glm::dvec3> points_m, double reach_m, std::span<std::optional<RoadPoint>> found,
               RoadHint* hint = nullptr) const;

  // All roads whose carriageway is within reach_m of the point: the places at which a cross section, or a road's end, is
  // nearest to it, a road that passes twice twice. Best first in the order of to_road, as many as `found` holds. Returns
  // how many there are. Requires: reach_m >= 0. Cost: O(log n + segments in reach), times found.size() at worst.
  std::size_t candidates(glm::dvec2 point_m, double reach_m, std::span<RoadPoint> found) const;
  std::size_t candidates(glm::dvec3 point_m, double reach_m, std::span<RoadPoint> found) const;

  // The pose on what is driven on at a place: the road, or the junction's area through which it leads. Accuracy: as
  // pose_at. Requires: place.road is an index of a road
  // with segments; s and t finite. Cost: O(1), O(log n) where segments of a road differ much in length.
  RoadPose to_world(const RoadPlace& place) const;
  // The same for many. Requires: as many poses as places.
  void to_world(std::span<const RoadPlace> places, std::span<RoadPose> poses) const;

  // The pose of what is driven on at an answer of to_road for the point: in an area at the point itself, else at its s
  // and t. Where the area has no road, heading and curvature are 0. Cost: O(1).
  RoadPose pose(const RoadPoint& place, glm::dvec2 point_m) const;

  // Calls visit(SegmentRef, const Segment&) for the segments that are drawn whose footprint's box is within reach_m of the
  // point, in no order; and for some that are a little farther. Requires: finite point.
  template <class Visit>
  void visit_within(glm::dvec2 point_m, double reach_m, Visit&& visit) const;
  std::vector<SegmentRef> within(glm::dvec2 point_m, double reach_m) const;

  // Likewise visit(index of the junction, const JunctionSurface&) for every junction area.
  template <class Visit>
  void visit_junctions(glm::dvec2 point_m, double reach_m, Visit&& visit) const;

  const Segment& segment(SegmentRef ref) const { return network_->roads[ref.road].segments[ref.segment]; }
  const Network& network() const { return *network_; }
  std::size_t size() const { return footprints_.size(); }  // segments
  std::size_t bytes() const;

 private:
  // The tree's items are the segments, in the network's order, and after them the areas.
  using Item = std::uint32_t;

  struct Order;
  struct Search;

  static Box box_about(glm::dvec3 p) { return {p, p}; }
  // What a query reads of a road.
  struct Course {
    double length_m;
    double buckets_per_m;  // as many buckets as segments, of equal length
    Item first;            // of its segments
    std::uint32_t count;
    std::uint32_t first_group;
    bool closed;
    std::uint32_t bucket(double s_m) const;
    double wrapped(double s_m) const;
  };
  // For a dozen buckets the last segment that starts in a bucket before (or the first), in so few bytes that those of a
  // million segments stay in a processor's cache.
  struct BucketGroup {
    static constexpr std::uint32_t kBuckets = 12;
    static constexpr std::uint32_t kMost = 127;
    std::uint32_t low;                 // of the first of them, on the road
    std::uint8_t code[kBuckets] = {};  // 2 min(segment - low, kMost), and 1 where that is less or several start in it
  };

  void add_course(const Road& road);
  Item item_of(SegmentRef ref) const { return courses_[ref.road].first + ref.segment; }
  // Items of one road, of which one is asked for.
  struct Stretch {
    Item low, high;
  };
  Stretch stretch_at(const Course& course, double s_m) const;
  Item item_in(Stretch stretch, double s_m) const;
  RoadPose pose_on(const RoadPlace& place, double s_m, Item item) const;
  void stand_on_area(const Area& area, glm::dvec2 point_m, glm::dvec2 tangent, RoadPose& pose) const;
  void add_overlaps(const std::vector<Box>& boxes);

  std::optional<RoadPoint> find(glm::dvec3 point_m, bool heights, double reach_m, RoadHint* hint) const;
  template <class Point>
  void find_all(std::span<const Point> points_m, double reach_m, std::span<std::optional<RoadPoint>> found) const;
  void begin(BoxTree::Walk& walk, const Search& search) const;
  std::optional<RoadPoint> answer(Search& search) const;
  bool find_from(const RoadHint& hint, Search& search) const;
  void consider(Item item, Search& search) const;
  RoadPoint place_on(const Footprint& footprint, Search& search, double reach_m) const;
  Order order_of(const RoadPoint& place, Item item) const;
  void name_lane(RoadPoint& place, Item item) const;
  void name_road_of_area(Search& search) const;
  bool is_nearest_place(const RoadPoint& place, glm::dvec2 point_m) const;
  std::size_t list(glm::dvec3 point_m, bool heights, double reach_m, std::span<RoadPoint> found) const;

  const Network* network_;
  LargeVector<Footprint> footprints_;
  std::vector<Course> courses_;  // of each road
  LargeVector<BucketGroup> groups_;
  std::vector<Area> areas_;
  std::vector<std::vector<Item>> through_;  // each area: segments of the roads that lead through
  BoxTree tree_;
  // The items whose boxes overlap a segment's: overlaps_[overlap_first_[i]] to [overlap_first_[i + 1]].
  LargeVector<std::uint32_t> overlap_first_;
  LargeVector<Item> overlaps_;
};

template <class Visit>
void RoadIndex::visit_within(glm::dvec2 point_m, double reach_m, Visit&& visit) const {
  tree_.search(box_about(glm::dvec3(point_m, 0)), {.reach_m = reach_m}, [&](Item item) {
    if (item < footprints_.size() && footprints_[item].area() < 0) {
      visit(footprints_[item].at(), segment(footprints_[item].at()));
    }
  });
}

template <class Visit>
void RoadIndex::visit_junctions(glm::dvec2 point_m, double reach_m, Visit&& visit) const {
  tree_.search(box_about(glm::dvec3(point_m, 0)), {.reach_m = reach_m}, [&](Item item) {
    if (item < footprints_.size()) return;
    const Item i = item - static_cast<Item>(footprints_.size());
    visit(i, areas_[i].surface());
  });
}

}  // namespace roadgen
