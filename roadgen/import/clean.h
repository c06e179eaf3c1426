// Cleaning of tracks: what real measured data needs before a curve can be fitted, with a diagnostic for every
// repair.
#pragma once

#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "roadgen/import/track.h"
#include "roadgen/road/result.h"

namespace roadgen {

// Whether a track is a loop.
enum class Closed {
  kAuto,  // decided by looks_closed
  kYes,
  kNo,
};

// A point closer than this to the one before is a repetition: below the resolution of any survey or GPS.
inline constexpr double kNearDuplicate_m = 0.01;
// A track that turns by more than this at one point goes back on itself.
inline constexpr double kReversal_rad = 2.9670597283903604;  // 170 degrees
// A recorded track (Track::recorded) that turns by more than this at a point nearer to a neighbour than kJitterLeg_m,
// which is twice the error of a GPS receiver, shows the receiver's jitter, as when it stands still, and no direction:
// such a bend would have a radius of less than 3 m.
inline constexpr double kJitterTurn_rad = 1.5707963267948966, kJitterLeg_m = 6;
// Heights outside this range are void values (-32768, -9999, ...): no road is lower than the Dead Sea's shore
// (-430 m) or higher than the Himalayan passes (5900 m), with room for mines and errors of the datum.
inline constexpr double kLeastHeight_m = -1000, kGreatestHeight_m = 9000;
// A height of exactly zero is a void where the valid heights beside it are further from zero than this, and
// the way to them would be steeper than the steepest street there is (Baldwin Street, 35 %).
inline constexpr double kZeroSpike_m = 5, kSteepestRoad = 0.35;
// Any other height is a spike where both ways to its neighbours are steeper than this, one up and one down,
// and it is more than kLeastSpike_m off both: less is the coarseness of heights in whole metres.
inline constexpr double kSpikeGrade = 1.0, kLeastSpike_m = 2;
// Widths (of the whole road) outside this range are nonsense.
inline constexpr double kLeastWidth_m = 0.5, kGreatestWidth_m = 200;

struct CleanOptions {
  Closed closed = Closed::kAuto;
  double width_m = 7;  // of the whole road, where the file has none; in [kLeastWidth_m, kGreatestWidth_m]. Default: 7
};

struct CleanPoint {
  glm::dvec2 position_m{0, 0};
  double height_m = 0;
  double width_m = 7;
  TrackPoint source;
};

// What becomes one road. A closed one does not repeat its first point.
struct CleanTrack {
  std::string name;
  std::string element;
  bool closed = false;
  std::vector<CleanPoint> points;  // at least two, all distinct from their neighbours
};

// Errors: kParse with the line of the first latitude beyond 90 degrees (saying so where latitude and
// longitude look swapped) or longitude beyond 180. Tracks in metres are always good.
Status check_range(const Track& track);

// Whether the points, free of repetitions, are a loop: the last one stands on the first, or near it (at
// most 1.5 times the median spacing, and 2 % of the length) without turning back there; at least four points.
bool looks_closed(const std::vector<CleanPoint>& points);

// Drops repetitions; decides whether the track is closed; drops jitter of recorded tracks; drops points where it only
// runs out and back on itself, and divides it where it turns back for good, since a road cannot turn on the spot; puts
// heights in place of void, zero, spiked and missing ones, by distance between valid neighbours (the end's height
// beyond the last valid one; 0 where there is none at all); puts the default in place of missing and nonsensical widths.
// positions_m: of the track's points, on a plane, in metres. Requires: as many as points.
// Errors: kData where fewer than two distinct points are left (three, where closed). Cost: O(n log n).
Result<std::vector<CleanTrack>> clean_track(const Track& track, const std::vector<glm::dvec2>& positions_m,
                                            const CleanOptions& options, Diagnostics& diagnostics);

}  // namespace roadgen
