// Anchors to a road: Catmull-Rom tangents or those of equal curvature, one cubic segment per pair of anchors, and the
// splitting of segments that the mapping could not represent within its certified tolerance.
//
// Source: Loviscach 2005, section 4 (uniform Catmull-Rom); Yuksel, Schaefer, Keyser 2011 (centripetal).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/road/network.h"
#include "roadgen/road/result.h"

namespace roadgen {

// A point that the centre line passes through.
struct Anchor {
  glm::dvec2 position_m{0, 0};  // ENU
  double elevation_m = 0;
  double half_width_m = 3.5;               // > 0
  std::optional<double> heading_rad = {};  // tangent given by the caller; else by Tangents
  std::optional<double> grade = {};        // dz/ds given by the caller; else Catmull-Rom over s
};

// Coordinates, heights and widths are less than this, about 150 Earth radii; beyond it doubles lose micrometres.
inline constexpr double kGreatestCoordinate_m = 1e9;

enum class Tangents {
  kUniform,      // Catmull-Rom: parallel to the chord of the two neighbours
  kCentripetal,  // Catmull-Rom with parameter steps of the square roots of the distances
  // Curvature is equal on both sides of every joint, to 1e-12 over the length of a segment, and 0 at the ends of an open
  // road (a natural spline). An anchor with a heading of its own keeps it: at the ends it clamps the road, and between
  // them curvature may jump there.
  kCurvature,
};

// What to do where the curve is tighter than the half width, so that no splitting can make it admissible.
enum class TightPolicy {
  kError,   // Error with the place, the radius and the half width
  kNarrow,  // the road is narrowed there, with a warning; Error only where less than kLeastHalfWidth_m would be left
};
inline constexpr double kLeastHalfWidth_m = 0.25;
// Beside a narrowed place the half width grows back by at most this much per metre of road (on the average between two
// joints).
inline constexpr double kNarrowingTaper = 0.25;

struct AlignmentOptions {
  Tangents tangents = Tangents::kUniform;        // Default: as in the paper
  bool closed = false;                           // the last anchor is joined to the first (do not repeat it)
  double mapping_tolerance = kMappingTolerance;  // of the half width, in (0, 1). Default: 1e-4
  TightPolicy tight = TightPolicy::kError;
  // An anchor closer than this to the one before is a repetition and dropped with a diagnostic. Default: 1 mm
  double least_distance_m = 1e-3;
};

// Headings in radians at every anchor, uniform or centripetal (kCurvature: centripetal, from which
// equalize_curvature starts); given ones are kept. At the ends of an open road the
// tangent continues the curve as a circular arc would; where the road doubles back onto the anchor before, it turns
// left. Requires: at least two anchors, no two consecutive equal.
std::vector<double> catmull_rom_headings(std::span<const Anchor> anchors, const AlignmentOptions& options);

// The road through the anchors: passes through every (non-repeated) anchor exactly, tangent continuous, every segment
// admissible; elevation C1 by the same rule (Catmull-Rom in s), half width C1 with slope 0 at the anchors and never
// above the greater of the two beside it.
// A segment between two anchors that is not admissible is split: pieces interpolate points and tangents of the
// parametric cubic through the same anchors and tangents. That is the cubic Hermite curve whose end tangents have the
// length L / cos(angle off the chord) up to 60 degrees off the chord, which makes it the graph cubic of
// shaders/lib/road.glsl, and 2 L beyond. Between two anchors the greater of their half widths decides what is tight.
// With Tangents::kCurvature the headings of all joints are solved for at once. A segment that is not admissible is halved
// on its own curve, and all headings are solved for again, until every segment is admissible.
// Diagnostics: repeated anchors that were dropped, and narrowed stretches, both as warnings.
// Errors: fewer than two distinct anchors; not finite or beyond kGreatestCoordinate_m; tight (see TightPolicy); a cusp
// (the road turns on the spot); kCurvature: headings that do not converge, with the place.
// Cost: O(n log(1/tolerance)).
Result<Road> road_from_anchors(std::span<const Anchor> anchors, const AlignmentOptions& options,
                               Diagnostics* diagnostics = nullptr);

}  // namespace roadgen
