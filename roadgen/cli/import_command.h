// roadgen import, with the step that needs an elevation file: reading rasters takes the libraries of roadgen-draw.
#pragma once

#include <string>

#include "roadgen/cli/command.h"
#include "roadgen/fit/heights.h"
#include "roadgen/import/import.h"

namespace roadgen::cli {

struct HeightRequest {
  std::string dem_path;  // empty: heights stay the source's
  std::string encoding = "heights", datum = "file", road_datum = "file";
  std::string geoid_path;
  HeightFitOptions fit;
};

// Fits the network's heights to the file's. Errors: as Elevation::open, check_coverage and fit_heights.
using LayOnGround = Result<HeightFitReport> (*)(Network& network, const HeightRequest& request,
                                                Diagnostics& diagnostics);
Result<HeightFitReport> lay_on_ground(Network& network, const HeightRequest& request, Diagnostics& diagnostics);

// The subcommand. lay_on_ground may be null where no argument is --heights.
int import_command(const Arguments& arguments, LayOnGround lay_on_ground);

}  // namespace roadgen::cli
