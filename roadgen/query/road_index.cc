#include "roadgen/query/road_index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <compare>
#include <string_view>
#include <type_traits>
#include <unordered_map>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::uint32_t kNoItem = 0xffffffffu;
constexpr std::size_t kMostOverlaps = 64;  // a segment with more has no list
constexpr int kHintSteps = 8;              // segments along the road
constexpr std::size_t kCached = 8u << 20;  // an index of fewer bytes is mostly in a processor's cache

bool is_finite(glm::dvec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

// A road that is drawn, or one in an area. An area alone comes after both.
int kind_of(const Footprint& footprint) { return footprint.area() < 0 ? 0 : 1; }
constexpr int kAreaAlone = 2;

}  // namespace

// The order of to_road.
struct RoadIndex::Order {
  double cost_m = kInfinity;
  int kind = kAreaAlone + 1;
  double distance_m = kInfinity;
  std::uint32_t item = kNoItem;
  auto operator<=>(const Order&) const = default;
};

// One query under way.
struct RoadIndex::Search {
  glm::dvec3 point_m{0, 0, 0};
  double reach_m = 0;
  SearchLimits limits = {};
  Order order = {};
  RoadPoint best = {};

  // The area last asked for: whether it holds the point, and its height there.
  std::int32_t area = -1;
  bool inside = false;
  double area_z_m = 0;

  bool is_inside(const std::vector<Area>& areas, std::int32_t asked) {
    if (asked == area) return inside;
    const Area& a = areas[static_cast<std::size_t>(asked)];
    area = asked;
    inside = a.holds(glm::dvec2(point_m));
    if (inside && limits.heights) area_z_m = a.height_m(glm::dvec2(point_m));
    return inside;
  }
  void take(const Order& other, const RoadPoint& place) {
    if (!(other < order)) return;
    order = other;
    best = place;
    limits.cost_m = order.cost_m;
  }
};

RoadIndex::RoadIndex(const Network& network) : network_(&network) {
  std::vector<Box> boxes;
  std::unordered_map<std::string_view, std::int32_t> area_of;
  for (const Junction& junction : network.junctions) {
    area_of.emplace(junction.id, static_cast<std::int32_t>(areas_.size()));
    areas_.emplace_back(junction);
  }
  through_.resize(areas_.size());
  const std::size_t count = network.segment_count();
  footprints_.reserve(count);
  boxes.reserve(count + areas_.size());
  std::size_t groups = 0;
  for (const Road& road : network.roads) {
    groups += (road.segments.size() + BucketGroup::kBuckets - 1) / BucketGroup::kBuckets;
  }
  groups_.reserve(groups);
  courses_.reserve(network.roads.size());
  for (std::uint32_t r = 0; r < network.roads.size(); ++r) {
    const Road& road = network.roads[r];
    const auto found = road.junction.empty() ? area_of.end() : area_of.find(road.junction);
    const std::int32_t area = found == area_of.end() ? -1 : found->second;
    const std::size_t n = road.segments.size();
    const auto first = static_cast<Item>(footprints_.size());
    add_course(road);
    for (std::uint32_t i = 0; i < n; ++i) {
      footprints_.emplace_back(road, road.segments[i], SegmentRef{r, i}, area);
      boxes.push_back(footprints_.back().bounds(road));
      if (area >= 0) {
        through_[static_cast<std::size_t>(area)].push_back(first + i);
        const JunctionSurface& surface = areas_[static_cast<std::size_t>(area)].surface();
        boxes.back().low_m.z = std::min(boxes.back().low_m.z, surface.center_m.z + surface.low_m.z);
        boxes.back().high_m.z = std::max(boxes.back().high_m.z, surface.center_m.z + surface.high_m.z);
      }
    }
  }
  for (const Area& area : areas_) {
    const JunctionSurface& surface = area.surface();
    boxes.push_back({surface.center_m + surface.low_m, surface.center_m + surface.high_m});
  }
  tree_ = BoxTree(boxes);
  add_overlaps(boxes);
}

// A start of a segment that lies in an earlier bucket than s is before s, and one in a later bucket is beyond: the order of
// buckets is that of s, however they are rounded.
void RoadIndex::add_course(const Road& road) {
  const auto n = static_cast<std::uint32_t>(road.segments.size());
  const double length = road.length_m();
  const Course course{length,
                      n > 0 ? n / length : 0,
                      static_cast<Item>(footprints_.size()),
                      n,
                      static_cast<std::uint32_t>(groups_.size()),
                      road.closed};
  courses_.push_back(course);
  std::uint32_t low = 0;
  for (std::uint32_t bucket = 0; bucket < n; ++bucket) {
    std::uint32_t high = low;
    while (high + 1 < n && course.bucket(road.segments[high + 1].s_start_m) <= bucket) ++high;
    const std::uint32_t place = bucket % BucketGroup::kBuckets;
    if (place == 0) groups_.push_back({.low = low});
    const std::uint32_t more = std::min(low - groups_.back().low, BucketGroup::kMost);
    const bool plain = groups_.back().low + more == low && high - low <= 1;
    groups_.back().code[place] = static_cast<std::uint8_t>(2 * more + (plain ? 0 : 1));
    low = high;
  }
}

void RoadIndex::add_overlaps(const std::vector<Box>& boxes) {
  overlap_first_.reserve(footprints_.size() + 1);
  std::vector<Item> about;
  for (Item item = 0; item < footprints_.size(); ++item) {
    overlap_first_.push_back(static_cast<std::uint32_t>(overlaps_.size()));
    about.clear();
    tree_.search(boxes[item], {.reach_m = 0}, [&](Item other) {
      if (other != item) about.push_back(other);
    });
    if (about.size() > kMostOverlaps) about.assign(1, kNoItem);
    overlaps_.insert(overlaps_.end(), about.begin(), about.end());
  }
  overlap_first_.push_back(static_cast<std::uint32_t>(overlaps_.size()));
}

std::size_t RoadIndex::bytes() const {
  return footprints_.capacity() * sizeof(Footprint) + tree_.bytes() + courses_.capacity() * sizeof(Course) +
         groups_.capacity() * sizeof(BucketGroup) + 4 * (overlap_first_.capacity() + overlaps_.capacity());
}

// ---- World to road ----

void RoadIndex::consider(Item item, Search& search) const {
  const glm::dvec2 flat(search.point_m);
  const bool heights = search.limits.heights;
  if (item >= footprints_.size()) {
    RoadPoint place;
    place.junction = static_cast<std::int32_t>(item - footprints_.size());
    if (!search.is_inside(areas_, place.junction)) return;
    if (heights) place.height_m = search.point_m.z - search.area_z_m;
    search.take({height_cost_m(place.height_m), kAreaAlone, 0, item}, place);
    return;
  }
  const Footprint& footprint = footprints_[item];
  const bool must_hold = search.order.cost_m <= kBeside_m;
  if (must_hold) {
    // In one area all have one height.
    const bool same_height = !heights || (footprint.area() >= 0 && footprint.area() == search.best.junction);
    const bool by_distance = same_height && kind_of(footprint) == search.order.kind;
    if (!footprint.may_hold(flat, by_distance ? search.order.distance_m : kInfinity)) return;
  }
  const RoadPoint place = place_on(footprint, search, must_hold ? 0 : search.reach_m);
  if (place.has_road()) search.take(order_of(place, item), place);
}

// The place on a road, with height; without a road where it is farther than reach_m.
RoadPoint RoadIndex::place_on(const Footprint& footprint, Search& search, double reach_m) const {
  const Road& road = network_->roads[footprint.at().road];
  prefetch(&footprint.section(), sizeof(LaneSection));  // for name_lane
  RoadPoint place = footprint.locate(road, glm::dvec2(search.point_m));
  if (place.outside_m > reach_m) return {};
  if (footprint.area() >= 0 && place.outside_m == 0 && search.is_inside(areas_, footprint.area())) {
    place.junction = footprint.area();
    if (search.limits.heights) place.height_m = search.point_m.z - search.area_z_m;
  } else if (search.limits.heights) {
    place.height_m = search.point_m.z - footprint.ground_m(road, place);
  }
  return place;
}

RoadIndex::Order RoadIndex::order_of(const RoadPoint& place, Item item) const {
  return {height_cost_m(place.height_m) + beside_cost_m(place.outside_m), kind_of(footprints_[item]), place.distance_m,
          item};
}

void RoadIndex::name_lane(RoadPoint& place, Item item) const {
  const LaneSection& section = footprints_[item].section();
  place.lane = lane_at(section, place.s_m - section.s_m, place.t_m);
}

// True where the answer is found: the segment about the hint holds the point, and is so near in height that only others
// that hold it too can be better. These overlap it.
bool RoadIndex::find_from(const RoadHint& hint, Search& search) const {
  if (hint.at.road >= courses_.size() || hint.at.segment >= courses_[hint.at.road].count) return false;
  const Course& course = courses_[hint.at.road];
  const Item first = course.first, count = course.count;
  Item segment = hint.at.segment;
  const int way = footprints_[first + segment].beyond(glm::dvec2(search.point_m));
  for (int step = 0, now = way; now != 0 && now == way; ++step) {
    if (step == kHintSteps || (!course.closed && segment == (way < 0 ? 0 : count - 1))) return false;
    segment = way < 0 ? (segment == 0 ? count : segment) - 1 : (segment + 1 == count ? 0 : segment + 1);
    now = footprints_[first + segment].beyond(glm::dvec2(search.point_m));
  }
  const Item item = first + segment;
  consider(item, search);
  if (search.order.item != item || search.best.outside_m > 0 || !(search.order.cost_m < kBeside_m)) return false;
  const std::uint32_t begin = overlap_first_[item], end = overlap_first_[item + 1];
  if (end - begin == 1 && overlaps_[begin] == kNoItem) return false;
  for (std::uint32_t i = begin; i < end; ++i) consider(overlaps_[i], search);
  return true;
}

std::optional<RoadPoint> RoadIndex::answer(Search& search) const {
  if (search.order.kind > kAreaAlone) return {};
  if (search.order.kind == kAreaAlone) {
    name_road_of_area(search);
  } else {
    name_lane(search.best, search.order.item);
  }
  return search.best;
}

std::optional<RoadPoint> RoadIndex::find(glm::dvec3 point_m, bool heights, double reach_m, RoadHint* hint) const {
  if (!is_finite(point_m)) return {};
  Search search{point_m, reach_m, {.reach_m = reach_m, .heights = heights}};
  if (!hint || !find_from(*hint, search)) {
    BoxTree::Walk walk;
    begin(walk, search);
    for (Item item = walk.next(); item != BoxTree::Walk::kDone; item = walk.next()) {
      consider(item, search);
      walk.limit(search.limits.cost_m);
    }
  }
  const std::optional<RoadPoint> found = answer(search);
  if (hint && found && found->has_road()) hint->at = found->at;
  return found;
}

void RoadIndex::begin(BoxTree::Walk& walk, const Search& search) const {
  walk.begin(tree_, box_about(search.point_m), search.limits,
             {footprints_.data(), sizeof(Footprint), footprints_.size()});
}

// Several walks in turn, each a step at a time: while one waits for memory the others go on.
template <class Point>
void RoadIndex::find_all(std::span<const Point> points_m, double reach_m,
                         std::span<std::optional<RoadPoint>> found) const {
  assert(points_m.size() == found.size());
  constexpr std::size_t kAtOnce = 8;
  constexpr bool heights = std::is_same_v<Point, glm::dvec3>;
  if (bytes() < kCached) {
    for (std::size_t i = 0; i < points_m.size(); ++i) found[i] = to_road(points_m[i], reach_m);
    return;
  }
  struct Slot {
    std::size_t place;
    Search search;
    BoxTree::Walk walk;
  };
  std::array<Slot, kAtOnce> slots;
  std::size_t next = 0, active = 0;
  const auto start = [&](Slot& slot) {
    for (; next < points_m.size(); ++next) {
      const glm::dvec3 point(points_m[next].x, points_m[next].y, heights ? points_m[next][heights ? 2 : 0] : 0);
      if (is_finite(point)) {
        slot.place = next++;
        slot.search = {point, reach_m, {.reach_m = reach_m, .heights = heights}};
        begin(slot.walk, slot.search);
        return true;
      }
      found[next].reset();
    }
    return false;
  };
  while (active < kAtOnce && start(slots[active])) ++active;
  while (active > 0) {
    for (std::size_t i = 0; i < active; ++i) {
      Slot& slot = slots[i];
      const Item item = slot.walk.step();
      if (item == BoxTree::Walk::kNode) continue;
      if (item != BoxTree::Walk::kDone) {
        consider(item, slot.search);
        slot.walk.limit(slot.search.limits.cost_m);
        continue;
      }
      found[slot.place] = answer(slot.search);
      if (!start(slot) && i != --active) slot = slots[active];
    }
  }
}

// On a part of an area that no road through it holds: the nearest of them.
void RoadIndex::name_road_of_area(Search& search) const {
  RoadPoint& best = search.best;
  double outside = kInfinity, distance = kInfinity;
  for (const Item item : through_[static_cast<std::size_t>(best.junction)]) {
    const Footprint& footprint = footprints_[item];
    const RoadPoint place = footprint.locate(network_->roads[footprint.at().road], glm::dvec2(search.point_m));
    if (place.outside_m > outside || (place.outside_m == outside && place.distance_m >= distance)) continue;
    outside = place.outside_m;
    distance = place.distance_m;
    best.at = place.at;
    best.u = place.u;
    best.s_m = place.s_m;
    best.t_m = place.t_m;
    best.distance_m = place.distance_m;
  }
}

std::optional<RoadPoint> RoadIndex::to_road(glm::dvec2 point_m, double reach_m, RoadHint* hint) const {
  return find(glm::dvec3(point_m, 0), false, reach_m, hint);
}

std::optional<RoadPoint> RoadIndex::to_road(glm::dvec3 point_m, double reach_m, RoadHint* hint) const {
  return find(point_m, true, reach_m, hint);
}

void RoadIndex::to_road(std::span<const glm::dvec2> points_m, double reach_m, std::span<std::optional<RoadPoint>> found,
                        RoadHint* hint) const {
  if (!hint) return find_all(points_m, reach_m, found);
  for (std::size_t i = 0; i < points_m.size(); ++i) found[i] = to_road(points_m[i], reach_m, hint);
}

void RoadIndex::to_road(std::span<const glm::dvec3> points_m, double reach_m, std::span<std::optional<RoadPoint>> found,
                        RoadHint* hint) const {
  if (!hint) return find_all(points_m, reach_m, found);
  for (std::size_t i = 0; i < points_m.size(); ++i) found[i] = to_road(points_m[i], reach_m, hint);
}

// ---- All roads in reach ----

// False where a neighbour along the road is nearer to the point, and at a joint for one of the two.
bool RoadIndex::is_nearest_place(const RoadPoint& place, glm::dvec2 point_m) const {
  const Course& course = courses_[place.at.road];
  const Item first = course.first, count = course.count;
  const bool closed = course.closed;
  const Footprint& footprint = footprints_[first + place.at.segment];
  const double from_end_m = (1 - place.u) * segment(place.at).arc_m;
  if (place.u == 0 && footprint.beyond(point_m) < 0) return place.at.segment == 0 && !closed;
  if (from_end_m > 2 * kTouch_m) return true;
  // At the end: it is the next segment's place, but where the point lies between the two, outside a bent joint.
  if (place.at.segment + 1 == count) return !closed || footprints_[first].beyond(point_m) < 0;
  return footprints_[first + place.at.segment + 1].beyond(point_m) < 0;
}

std::size_t RoadIndex::list(glm::dvec3 point_m, bool heights, double reach_m, std::span<RoadPoint> found) const {
  if (!is_finite(point_m)) return 0;
  Search search{point_m, reach_m, {.reach_m = reach_m, .heights = heights}};
  std::size_t count = 0;
  tree_.search(box_about(point_m), search.limits, [&](Item item) {
    if (item >= footprints_.size()) return;
    const RoadPoint place = place_on(footprints_[item], search, reach_m);
    if (!place.has_road() || !is_nearest_place(place, glm::dvec2(point_m))) return;
    // Sorted in; what does not fit falls out at the end.
    std::size_t held = std::min(count++, found.size());
    const Order order = order_of(place, item);
    std::size_t i = held;
    while (i > 0 && order < order_of(found[i - 1], item_of(found[i - 1].at))) --i;
    if (i == found.size()) return;
    held = std::min(held, found.size() - 1);
    std::move_backward(found.begin() + i, found.begin() + held, found.begin() + held + 1);
    found[i] = place;
  });
  for (RoadPoint& place : found.first(std::min(count, found.size()))) name_lane(place, item_of(place.at));
  return count;
}

std::size_t RoadIndex::candidates(glm::dvec2 point_m, double reach_m, std::span<RoadPoint> found) const {
  return list(glm::dvec3(point_m, 0), false, reach_m, found);
}

std::size_t RoadIndex::candidates(glm::dvec3 point_m, double reach_m, std::span<RoadPoint> found) const {
  return list(point_m, true, reach_m, found);
}

std::vector<SegmentRef> RoadIndex::within(glm::dvec2 point_m, double reach_m) const {
  std::vector<SegmentRef> found;
  visit_within(point_m, reach_m, [&](SegmentRef ref, const Segment&) { found.push_back(ref); });
  return found;
}

// ---- Road to world ----

std::uint32_t RoadIndex::Course::bucket(double s_m) const {
  const double part = s_m * buckets_per_m;
  return part > 0 ? static_cast<std::uint32_t>(std::min(part, count - 1.0)) : 0;
}

double RoadIndex::Course::wrapped(double s_m) const {
  return closed ? s_m - std::floor(s_m / length_m) * length_m : s_m;
}

// Where the segment of s is, which is wrapped: one or two in most roads, whose memory is asked for.
RoadIndex::Stretch RoadIndex::stretch_at(const Course& course, double s_m) const {
  const std::uint32_t bucket = course.bucket(s_m);
  const BucketGroup& group = groups_[course.first_group + bucket / BucketGroup::kBuckets];
  const std::uint32_t code = group.code[bucket % BucketGroup::kBuckets];
  const Item low = course.first + group.low + code / 2, last = course.first + course.count - 1;
  prefetch(&footprints_[low], Footprint::kPoseBytes);
  prefetch(&footprints_[low] + 1, Footprint::kPoseBytes);
  return {low, code % 2 == 0 ? std::min(low + 1, last) : last};
}

// As segment_at.
RoadIndex::Item RoadIndex::item_in(Stretch stretch, double s_m) const {
  const auto [low, high] = stretch;
  if (high - low <= 1) return low + (high - low) * (footprints_[high].s_start_m() <= s_m ? 1 : 0);
  const auto after = std::upper_bound(footprints_.begin() + low + 1, footprints_.begin() + high + 1, s_m,
                                      [](double s, const Footprint& f) { return s < f.s_start_m(); });
  return static_cast<Item>(after - footprints_.begin()) - 1;
}

void RoadIndex::stand_on_area(const Area& area, glm::dvec2 point_m, glm::dvec2 tangent, RoadPose& pose) const {
  const JunctionPoint ground = area.ground_at(point_m);
  pose.position_m = glm::dvec3(point_m, ground.height_m);
  lean(pose, tangent, ground.gradient);
}

RoadPose RoadIndex::pose_on(const RoadPlace& place, double s_m, Item item) const {
  const Footprint& footprint = footprints_[item];
  RoadPose pose = footprint.pose(network_->roads[place.road], s_m - footprint.s_start_m(), place.t_m);
  if (footprint.area() < 0) return pose;
  const Area& ground = areas_[static_cast<std::size_t>(footprint.area())];
  const glm::dvec2 flat(pose.position_m);
  if (ground.holds(flat)) {
    stand_on_area(ground, flat, {std::cos(pose.heading_rad), std::sin(pose.heading_rad)}, pose);
  }
  return pose;
}

RoadPose RoadIndex::to_world(const RoadPlace& place) const {
  const Course& course = courses_[place.road];
  const double s = course.wrapped(place.s_m);
  return pose_on(place, s, item_in(stretch_at(course, s), s));
}

// A block at a time: memory is asked for long before it is read.
void RoadIndex::to_world(std::span<const RoadPlace> places, std::span<RoadPose> poses) const {
  assert(places.size() == poses.size());
  constexpr std::size_t kBlock = 32;
  std::array<double, kBlock> s;
  std::array<Stretch, kBlock> stretch;
  for (std::size_t begin = 0; begin < places.size(); begin += kBlock) {
    const std::size_t count = std::min(kBlock, places.size() - begin);
    for (std::size_t i = 0; i < count; ++i) {
      const Course& course = courses_[places[begin + i].road];
      s[i] = course.wrapped(places[begin + i].s_m);
      stretch[i] = stretch_at(course, s[i]);
    }
    for (std::size_t i = 0; i < count; ++i)
      poses[begin + i] = pose_on(places[begin + i], s[i], item_in(stretch[i], s[i]));
  }
}

RoadPose RoadIndex::pose(const RoadPoint& place, glm::dvec2 point_m) const {
  RoadPose pose;
  if (place.has_road()) {
    const Footprint& footprint = footprints_[item_of(place.at)];
    pose = footprint.pose(network_->roads[place.at.road], place.s_m - footprint.s_start_m(), place.t_m);
  }
  if (place.junction >= 0) {
    stand_on_area(areas_[static_cast<std::size_t>(place.junction)], point_m,
                  {std::cos(pose.heading_rad), std::sin(pose.heading_rad)}, pose);
  }
  return pose;
}

}  // namespace roadgen
