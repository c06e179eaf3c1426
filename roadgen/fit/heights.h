// The heights of a whole network, fitted to the ground at once: roads lie on it as smoothly as traffic needs.
//
//   HeightFitOptions options;
//   auto report = fit_heights(network, [&](glm::dvec2 p) { return std::optional(height_of_the_ground(p)); }, options);
//
// One sparse problem of least squares over the heights and grades at all joints. The ground pulls where a road lies on it,
// in the manner of Huber, so that steps and towers in the elevation do not bend the road; bridges and tunnels are pulled
// by nothing but their stiffness. Roads that meet share a plane: its height and slopes are three unknowns of the
// junction, and every arm begins on it, with its grade. Where one road passed over another it still does.
// Between two joints z is a cubic, whose grade is within those of three numbers (its Bernstein coefficients) and whose
// second derivative is within that at both ends: the limits are linear in the unknowns, and hold everywhere on the cubic.
// Tunnels keep below the ground by their vault where grades allow.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <glm/vec2.hpp>

#include "roadgen/fit/divide.h"
#include "roadgen/road/network.h"
#include "roadgen/road/result.h"

namespace roadgen {

// What a road's profile keeps to.
struct HeightLimits {
  double grade = 0.15;                 // |dz/ds| at most
  double curvature_per_m = 1.0 / 250;  // |d2z/ds2| at most: crests and sags of this radius or more
};
// By Road::road_class, a value of OSM's highway=*; those above for other ones. They are what is found in hilly towns, not what
// new roads are designed to, lest streets that are steep be cut deeply into the ground.
HeightLimits height_limits(std::string_view road_class);

struct HeightFitOptions {
  // In place of the classes', for all roads. > 0
  std::optional<double> max_grade = {};
  std::optional<double> max_curvature_per_m = {};
  // Waves of the ground shorter than about six times this are smoothed away. > 0. Default: 20 m
  double smoothing_m = 20;
  // Differences from the ground beyond this count linearly, not squared. > 0. Default: 2 m
  double doubt_m = 2;
  // What a road keeps above another, or as much as it had if that is less. >= 0. Default: 5.5 m, see osm_heights.h
  double clearance_m = 5.5;
};

// A place where a number was found.
struct AtRoad {
  std::string road = {};
  double s_m = 0;
};

struct HeightFitReport {
  std::size_t samples = 0;          // of the ground, under roads that lie on it
  std::size_t samples_missing = 0;  // where it is not known
  double rms_m = 0;                 // of road above ground
  double mean_abs_m = 0;
  double highest_fill_m = 0, deepest_cut_m = 0;
  AtRoad highest_fill_at, deepest_cut_at;
  // Of all profiles, exactly: extremes of the cubics, not samples.
  double max_grade = 0, max_curvature_per_m = 0;
  AtRoad max_grade_at, max_curvature_at;
  std::size_t roads = 0;
  // Of roads that exceed their limits: where junctions, crossings and limits contradict one another.
  std::size_t over_grade = 0, over_curvature = 0;
  std::size_t passings = 0;        // of one road over another
  std::size_t passings_short = 0;  // that have less than they should by more than kShortPassing_m
  double least_passing_m = 0;      // of all of them; 0 where there are none
};
inline constexpr double kShortPassing_m = 0.05;

// Height of the ground at a place of the network's plane, as z of its frame; none where it is not known.
using GroundHeight = std::function<std::optional<double>(glm::dvec2)>;

// Gives all roads and areas the heights that lie naturally on the ground; those they had tell what passes over what, and
// are else forgotten. Long segments are divided, which moves the centre line by at most
// kDividedGap_m. Areas get the tilt of their plane, and roads that have neither
// superelevation nor crossfall lean into it over their last 30 m.
// Diagnostics (where wanted): roads that exceed their limits, passings that are too low, areas that cannot be made again.
// Errors: kUsage for options out of range; kData for a network without roads, or ground that is known under none of them.
// Cost: about 10 ms a km of streets.
// Limits hold to kLimitPart of themselves.
Result<HeightFitReport> fit_heights(Network& network, const GroundHeight& ground, const HeightFitOptions& options = {},
                                    Diagnostics* diagnostics = nullptr);
inline constexpr double kLimitPart = 1e-3;

}  // namespace roadgen
