// Measured samples to a road: fewest segments within a stated error, by least squares on the road function's own
// signed distance v, and a certificate of what was reached.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "roadgen/fit/catmull_rom.h"

namespace roadgen {

// A measured point of the centre line.
struct Sample {
  glm::dvec2 position_m{0, 0};  // ENU
  double elevation_m = 0;
  double half_width_m = 3.5;
};

enum class TangentSource { kFit, kCatmullRom };

// Where a road has to begin or end: at the cut of a junction, or joined to another road.
struct FixedEnd {
  glm::dvec2 position_m{0, 0};
  double heading_rad = 0;  // along the road, also at its end
};

struct FitOptions {
  double max_error_m = 0.1;  // greatest allowed horizontal distance of a sample from the curve. > 0. Default: 0.1
  double max_elevation_error_m = 1.0;  // likewise vertical; measured heights are coarse. > 0. Default: 1
  bool closed = false;                 // the last sample is joined to the first (do not repeat it). Default: no
  // Where an open road of tangents kFit begins and ends. Default: free, where its samples are best met
  std::optional<FixedEnd> start = {}, end = {};
  TangentSource tangents = TangentSource::kFit;  // kCatmullRom: anchors are thinned samples, tangents from them
  Tangents catmull_rom = Tangents::kUniform;     // which, where tangents is kCatmullRom. Default: as in the paper
  // Leave out samples that lie off the course of their neighbours by more than 3 max_error_m. Default: no
  bool reject_outliers = false;
  TightPolicy tight = TightPolicy::kNarrow;      // Default: measured hairpins are narrowed with a warning
  double mapping_tolerance = kMappingTolerance;  // of the half width, in (0, 1). Default: 1e-4
};

// What the import is worth, per road. Distances are those of the samples from the final curve, by the exact nearest
// point in double, so max_error_m is an upper bound of the true distance as it stands.
struct Certificate {
  std::string id;
  bool closed = false;
  double length_m = 0;
  std::size_t samples = 0, anchors = 0, segments = 0;
  double max_error_m = 0, rms_error_m = 0;
  double bound_m = 0;  // proven: max_error_m plus the mapping bound of the worst segment
  // Proven, for the polyline of the samples: no point of it is farther from the curve than source_to_curve_m, and none of
  // the curve farther from it than curve_to_source_m. Where samples are sparse it cuts the bends, and these are the more.
  double source_to_curve_m = 0, curve_to_source_m = 0;
  double max_elevation_error_m = 0;
  // What was left out of all of these, and how far from the road at most: see FitOptions::reject_outliers.
  std::size_t outliers = 0;
  double greatest_outlier_m = 0;
  double max_heading_jump_rad = 0, max_curvature_jump_per_m = 0;
};

struct FittedRoad {
  Road road;
  // With grades, and headings but for Tangents::kCurvature: road_from_anchors gives the road again, with the same options
  // and least_distance_m = 0.
  std::vector<Anchor> anchors;
  Certificate certificate;
};

// The certificate of any road against samples, in their order along the road: where the road crosses itself, a height
// is compared with the strand that the samples before it followed. Cost: O((samples + segments) log segments).
Certificate certify(const Road& road, std::span<const Sample> samples, std::size_t anchors);

// Thins the samples to anchors, fits positions and headings of all anchors at once (Ceres, sparse), adds anchors where
// the error is above max_error_m, and repeats until it holds everywhere; where it can't otherwise, all samples become
// anchors. Then anchors are removed again where the road keeps within the error and bends no more without them. Between
// sparse samples jumps of curvature are kept small. Heights: the stiffest profile within max_elevation_error_m, with
// knots at the anchors; heights that would make the road steeper than 0.5 are left out.
// A road begins at its first sample that is no outlier. The same samples give the same road.
// Diagnostics: samples that repeat the one before, outliers with their numbers, heights left out, narrowed stretches, and
// an error that stayed above the one allowed, as warnings.
// Errors: fewer than two distinct samples; not finite; fixed ends of a closed road or of Catmull-Rom tangents (kUsage); as
// road_from_anchors (a hairpin tighter than kLeastHalfWidth_m).
// Cost: 1e-4 s per sample on one core.
Result<FittedRoad> fit_road(std::span<const Sample> samples, const FitOptions& options,
                            Diagnostics* diagnostics = nullptr);

}  // namespace roadgen
