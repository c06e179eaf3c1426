// Segments divided so that profiles have room to bend. Internal to roadgen/fit.
#pragma once

#include "roadgen/road/network.h"

namespace roadgen {

// Divides segments longer than longest_m (> 0) into equal parts, with all profiles; but not those whose parts would leave
// the curve by more than kDividedGap_m, differ in length by more than kDividedShift_m, or not be certified.
void divide_segments(Road& road, double longest_m);
inline constexpr double kDividedGap_m = 1e-3, kDividedShift_m = 1e-7;

}  // namespace roadgen
