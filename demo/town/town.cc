#include "demo/town/town.h"

#include <algorithm>

#include "roadgen/fit/catmull_rom.h"

namespace roadgen::demo {
namespace {

constexpr double kKerb_m = 0.12;  // height

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
    side.push_back(lane(LaneType::kDriving, 3.25,
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

}  // namespace

Result<Network> town() {
  Network network;
  network.name = "town";
  const std::vector<Anchor> main_street = {{{0, 0}, 0},     {{60, 0}, 0},    {{120, 4}, 0.6}, {{180, 14}, 2.0},
                                           {{240, 40}, 3.5}, {{290, 85}, 4.2}, {{320, 140}, 4.0}, {{330, 200}, 3.0}};
  Result<Road> high_street = road("high street", main_street, street(2));
  if (!high_street) return high_street.error();
  // The bend is banked, the straight crowned.
  for (Segment& segment : high_street->segments) {
    const auto bank = [](double s) {
      const double t = std::clamp((s - 150) / 60, 0.0, 1.0);
      return 0.05 * t * t * (3 - 2 * t);
    };
    const double s = segment.s_start_m, crown = 0.025;
    segment.superelevation_rad = Cubic::hermite(bank(s), 0, bank(s + segment.arc_m), 0, segment.arc_m);
    const auto fall = [&](double at) { return crown * (1 - bank(at) / 0.05); };
    segment.crossfall_left = segment.crossfall_right = {fall(s), (fall(s + segment.arc_m) - fall(s)) / segment.arc_m};
  }
  const double lane_m = 3.25;
  high_street->paint = {
      {.kind = PaintKind::kLine, .s_m = 100, .t_m = -lane_m, .length_m = 0.5, .width_m = 2 * lane_m},
      {.kind = PaintKind::kZebra, .s_m = 103.5, .t_m = 0, .length_m = 4, .width_m = 4 * lane_m, .stripe_m = 0.5},
      {.kind = PaintKind::kArrowStraightLeft, .s_m = 85, .t_m = -0.5 * lane_m, .length_m = 5, .width_m = 1.6},
      {.kind = PaintKind::kArrowRight, .s_m = 85, .t_m = -1.5 * lane_m, .length_m = 5, .width_m = 1.6},
      {.kind = PaintKind::kArrow, .s_m = 60, .t_m = -0.5 * lane_m, .length_m = 5, .width_m = 1.6},
      {.kind = PaintKind::kArrow, .s_m = 120, .t_m = 0.5 * lane_m, .length_m = 5, .width_m = 1.6, .against = true},
  };
  network.roads.push_back(std::move(*high_street));
  return network;
}

}  // namespace roadgen::demo
