// What solver.cc finds in the library of the fit.
#include "roadgen/fit/solver.h"

extern "C" __attribute__((visibility("default"))) const roadgen::FitSolver roadgen_fit_solver;
const roadgen::FitSolver roadgen_fit_solver = {roadgen::solve_joints, roadgen::find_outliers};
