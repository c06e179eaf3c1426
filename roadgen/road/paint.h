// Paint on the carriageway that belongs to one place: stop lines, zebra crossings, arrows.
#pragma once

#include <cstdint>

#include "roadgen/road/lane.h"

namespace roadgen {

// Numbers as in shaders/lib/marking.glsl.
enum class PaintKind : std::uint8_t {
  kLine = 0,   // a filled rectangle: stop lines
  kZebra = 1,  // stripes along the road, side by side across it, as wide as the gaps between them
  kArrow = 2,  // straight ahead
  kArrowLeft = 3,
  kArrowRight = 4,
  kArrowStraightLeft = 5,
  kArrowStraightRight = 6,
};

struct Paint {
  PaintKind kind = PaintKind::kLine;
  PaintColor color = PaintColor::kWhite;
  double s_m = 0;         // centre, along the road
  double t_m = 0;         // centre, across
  double length_m = 0.5;  // along s, > 0
  double width_m = 3.5;   // across, > 0
  double stripe_m = 0.5;  // zebra: width of a stripe, > 0
  bool against = false;   // arrows: points against s
  bool operator==(const Paint&) const = default;
};

}  // namespace roadgen
