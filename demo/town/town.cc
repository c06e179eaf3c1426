#include "demo/town/town.h"

#include <algorithm>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/road/crossing.h"

namespace roadgen::demo {
namespace {

constexpr double kKerb_m = 0.12;  // height
constexpr double kLane_m = 3.25;
constexpr double kCrown = 0.025;

Lane lane(LaneType type, double width_m, Mark mark = {}) {
  return {.type = type, .material = default_material(type), .width_m = {width_m}, .mark = mark};
}
Lane raised(LaneType type, double width_m) {
  Lane l = lane(type, width_m);
  l.inner_height_m = l.outer_height_m = kKerb_m;
  return l;
}

// One side of a street, from the centre line outward.
std::vector<Lane> street_side(int lanes) {
  std::vector<Lane> side;
  for (int i = 0; i < lanes; ++i) {
    side.push_back(lane(LaneType::kDriving, kLane_m,
                        {.kind = i + 1 < lanes ? MarkKind::kBroken : MarkKind::kSolid, .on_m = 3, .off_m = 3}));
  }
  side.push_back(lane(LaneType::kParking, 2.2));
  side.push_back(raised(LaneType::kCurb, 0.15));
  side.push_back(raised(LaneType::kSidewalk, 2.5));
  Lane verge = raised(LaneType::kNone, 1.2);
  verge.outer_height_m = 0;
  side.push_back(verge);
  return side;
}

LaneSection street(int lanes) {
  LaneSection section;
  section.center_mark = {.kind = MarkKind::kSolidSolid, .color = PaintColor::kYellow};
  section.left = section.right = street_side(lanes);
  return section;
}

double width_m(const LaneSection& section) { return section.borders_m().back().c0; }

// A road through the points with one section all along.
Result<Road> road(std::string id, std::vector<Anchor> anchors, const LaneSection& section) {
  for (Anchor& a : anchors) a.half_width_m = width_m(section);
  Result<Road> made = road_from_anchors(anchors, {});
  if (!made) return made;
  made->id = std::move(id);
  if (Status s = set_sections(*made, {section}); !s) return s.error();
  return made;
}

// A stop line and a zebra crossing before the junction at the road's end or start, over the lanes that lead to it.
void stop_at(Road& road, bool at_end, int lanes) {
  const double way = at_end ? 1 : -1, end = at_end ? road.length_m() : 0;
  const double half = lanes * kLane_m;
  road.paint.push_back({.kind = PaintKind::kZebra, .s_m = end - way * 3, .length_m = 3, .width_m = 2 * half});
  road.paint.push_back({.s_m = end - way * 5.75, .t_m = -way * 0.5 * half, .length_m = 0.5, .width_m = half});
  for (int i = 0; i < lanes; ++i) {
    const PaintKind kind = lanes == 1 ? PaintKind::kArrow
                           : i == 0   ? PaintKind::kArrowStraightLeft
                                      : PaintKind::kArrowRight;
    road.paint.push_back({.kind = kind,
                          .s_m = end - way * 14,
                          .t_m = -way * (i + 0.5) * kLane_m,
                          .length_m = 5,
                          .width_m = 1.6,
                          .against = !at_end});
  }
}

}  // namespace

Result<Network> town() {
  Network network;
  network.name = "town";
  const LaneSection wide = street(2), narrow = street(1);
  auto west = road("west street",
                   {{{-170, -22}, 1.5}, {{-120, -14}, 0.8}, {{-70, -3}, 0.2}, {{-16, 0}, 0, 3.5, 0.0, -0.01}}, wide);
  auto east = road("high street",
                   {{{16, 0}, 0, 3.5, 0.0, 0.01},
                    {{70, 1}, 0.3},
                    {{120, 4}, 0.9},
                    {{180, 14}, 2.0},
                    {{240, 40}, 3.5},
                    {{290, 85}, 4.2},
                    {{320, 140}, 4.0},
                    {{330, 200}, 3.0}},
                   wide);
  auto south = road("mill lane", {{{30, -130}, -3}, {{18, -80}, -2.2}, {{2, -19}, -0.6, 3.5, 1.65, 0.035}}, narrow);
  auto north = road("hill road", {{{-1, 19}, 0.7, 3.5, 1.6, 0.05}, {{-6, 70}, 3.6}, {{-30, 120}, 6.4}}, narrow);
  for (auto* made : {&west, &east, &south, &north}) {
    if (!*made) return made->error();
  }
  // The bend is banked, the straight crowned.
  for (Segment& segment : east->segments) {
    const auto part = [](double s) {
      const double t = std::clamp((s - 130) / 60, 0.0, 1.0);
      return t * t * (3 - 2 * t);
    };
    const double s = segment.s_start_m, end = s + segment.arc_m;
    segment.superelevation_rad = Cubic::hermite(0.05 * part(s), 0, 0.05 * part(end), 0, segment.arc_m);
    const double fall = kCrown * (1 - part(s));
    segment.crossfall_left = segment.crossfall_right = {fall, (kCrown * (1 - part(end)) - fall) / segment.arc_m};
  }
  for (Road* other : {&*west, &*south, &*north}) {
    for (Segment& segment : other->segments) segment.crossfall_left = segment.crossfall_right = {kCrown, 0};
  }
  stop_at(*west, true, 2);
  stop_at(*east, false, 2);
  stop_at(*south, true, 1);
  stop_at(*north, false, 1);
  const double beside = width_m(wide) + 0.4;
  east->sweeps = {{.s_start_m = 150, .s_end_m = 300, .t_m = -beside, .shape = GuardRail{}}};
  north->sweeps = {{.s_start_m = 8, .s_end_m = 98, .t_m = width_m(narrow) + 1, .shape = Cable{.span_m = 30}}};
  south->sweeps = {
      {.s_start_m = 15,
       .s_end_m = 60,
       .shape = Tunnel{.half_width_m = width_m(narrow) + 0.3, .wall_height_m = 3, .arch_rise_m = 4.5, .walkway_m = 0}}};
  for (auto* made : {&west, &east, &south, &north}) network.roads.push_back(std::move(**made));
  const Status crossing = add_crossing(
      network, "market", {{"west street", true}, {"high street", false}, {"mill lane", true}, {"hill road", false}},
      {.corner_radius_m = 7});
  if (!crossing) return crossing.error();
  return network;
}

}  // namespace roadgen::demo
