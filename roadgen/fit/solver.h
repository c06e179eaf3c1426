// What the fit asks of Ceres, in a library of its own that is loaded when a fit first needs it: with the 20 others that
// Ceres needs it takes as much memory as the import of a town, which most often fits nothing. Internal to roadgen/fit.
#pragma once

#include "roadgen/fit/least_squares.h"
#include "roadgen/fit/outliers.h"
#include "roadgen/road/result.h"

namespace roadgen {

struct FitSolver {
  decltype(&roadgen::solve_joints) solve_joints;
  decltype(&roadgen::find_outliers) find_outliers;
};

// It stays loaded. Error: the library is not there.
Result<const FitSolver*> fit_solver();

}  // namespace roadgen
