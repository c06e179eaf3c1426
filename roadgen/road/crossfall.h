// Slopes of a cross section, falling outward from the reference line, against the horizontal (Segment) and in the plane
// that superelevation tilts (OpenDRIVE's shape and crossfall).
#pragma once

#include <algorithm>
#include <cmath>

namespace roadgen {

// Steeper cross sections, by superelevation or by their sum, count as this.
inline constexpr double kSteepestTilt_rad = 1.4;

// tan of an angle, clamped to kSteepestTilt_rad.
inline double tilt_slope(double angle_rad) {
  return std::tan(std::clamp(angle_rad, -kSteepestTilt_rad, kSteepestTilt_rad));
}

// On the side of the road: 1 left, -1 right. Inverse to one another but where the tilt is clamped.
inline double level_fall(double tilted_fall, double superelevation_rad, double side) {
  const double e = side * std::clamp(superelevation_rad, -kSteepestTilt_rad, kSteepestTilt_rad);
  return std::tan(e) - tilt_slope(e - std::atan(tilted_fall));
}
inline double tilted_fall(double level_fall, double superelevation_rad, double side) {
  const double e = side * std::clamp(superelevation_rad, -kSteepestTilt_rad, kSteepestTilt_rad);
  return tilt_slope(e - std::atan(std::tan(e) - level_fall));
}

}  // namespace roadgen
