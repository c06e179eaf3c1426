// The cross section of a road: lanes, what they are made of, how high they lie, and the paint between them.
//
// Source of the terms: ASAM OpenDRIVE 1.7, clause 11 (lanes). One section holds one cubic of every width and one mark
// for every border; where OpenDRIVE changes any of these within a lane section, a new section begins here.
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "roadgen/road/cubic.h"

namespace roadgen {

// Lane types of OpenDRIVE 1.7, table 54.
enum class LaneType : std::uint8_t {
  kNone,
  kDriving,
  kShoulder,
  kBorder,
  kStop,
  kRestricted,
  kParking,
  kMedian,
  kBiking,
  kSidewalk,
  kCurb,
  kExit,
  kEntry,
  kOnRamp,
  kOffRamp,
  kConnectingRamp,
  kBidirectional,
  kSlipLane,
  kBus,
  kTaxi,
  kHov,
  kRail,
  kTram,
  kRoadWorks
};
inline constexpr int kLaneTypes = 24;

// The file's word for a type, "driving" and so on; and back, kNone for unknown words.
std::string_view lane_type_name(LaneType type);
LaneType lane_type(std::string_view name);

// What a strip is made of; numbers as in shaders/lib/material.glsl.
enum class Material : std::uint8_t {
  kAsphalt = 0,
  kConcrete = 1,
  kPaving = 2,
  kGrass = 3,
  kGravel = 4,
  kCurbstone = 5
};
Material default_material(LaneType type);

// Road marks; numbers as in shaders/lib/marking.glsl. Of two lines the first named is the right one, seen along the
// road.
enum class MarkKind : std::uint8_t {
  kNone = 0,
  kSolid = 1,
  kBroken = 2,
  kSolidSolid = 3,
  kSolidBroken = 4,
  kBrokenSolid = 5,
  kBrokenBroken = 6
};
enum class PaintColor : std::uint8_t { kWhite = 0, kYellow = 1, kBlue = 2, kGreen = 3, kRed = 4, kOrange = 5 };

struct Mark {
  MarkKind kind = MarkKind::kNone;
  PaintColor color = PaintColor::kWhite;
  double width_m = 0.12;  // of one line, >= 0
  double space_m = 0.12;  // between the two lines of a double mark, >= 0
  double on_m = 3;        // a dash of a broken line, > 0
  double off_m = 6;       // the space after it, >= 0
  double phase_m = 0;     // what of a dash and its space has gone by where the section starts, >= 0
  bool operator==(const Mark&) const = default;
};

struct Lane {
  LaneType type = LaneType::kDriving;
  Material material = Material::kAsphalt;
  Cubic width_m{3.5, 0, 0, 0};  // over s from the section's start; below 0 it counts as 0
  double inner_height_m = 0;    // of the lane's border toward the reference line above the road surface
  double outer_height_m = 0;    // and of its outer one; where neighbours differ a vertical face stands
  Mark mark;                    // on the outer border, centred
  bool operator==(const Lane&) const = default;
};

struct LaneSection {
  double s_m = 0;           // of the road, where it starts: a joint of two segments
  Cubic offset_m;           // t of lane 0, over s from the section's start
  Mark center_mark;         // on lane 0
  std::vector<Lane> left;   // from the centre outward: ids 1, 2, ...
  std::vector<Lane> right;  // ids -1, -2, ...
  bool operator==(const LaneSection&) const = default;

  // t of the borders from right to left, over s from the section's start: right.size() + left.size() + 1 cubics.
  std::vector<Cubic> borders_m() const;
};

// The id of the lane that holds t at ds_m from the section's start; 0 outside all lanes.
int lane_at(const LaneSection& section, double ds_m, double t_m);

// Height of the lanes' surface above the road surface at (ds, t): curbs and raised sidewalks. On a vertical face the
// higher side. 0 outside all lanes. Source: OpenDRIVE 1.7, clause 11.7 (lane height), but vertical.
double lane_height_m(const LaneSection& section, double ds_m, double t_m);

// The same with its slopes, dh/ds and dh/dt.
struct LaneSurface {
  double height_m = 0, along = 0, across = 0;
};
LaneSurface lane_surface(const LaneSection& section, double ds_m, double t_m);

// Least and greatest height of the section's lanes; 0 is in it.
Cubic::Range lane_height_range_m(const LaneSection& section);

}  // namespace roadgen
