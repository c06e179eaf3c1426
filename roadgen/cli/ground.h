// What the commands that need an elevation file or make ground of it share: their options, and the reading of the file.
#pragma once

#include <string>

#include "roadgen/road/network.h"
#include "terrain/elevation.h"
#include "terrain/levelling.h"

namespace CLI {
class App;
}

namespace roadgen::cli {

struct ElevationRequest {
  std::string path;
  std::string encoding = "heights";
  std::string datum = "file", road_datum = "file";
  std::string geoid_path;  // empty: what PROJ has
};

// Declares --dem-encoding, --dem-datum, --road-datum and --geoid.
void add_elevation_options(CLI::App& app, ElevationRequest& request);

// Declares --shoulder, --cut-slope, --fill-slope, --cover and those of ditches.
void add_levelling_options(CLI::App& app, LevellingOptions& options);

// Opens the file, its heights in the datum of the network's. Errors: as Elevation::open; kUsage for unknown names.
Result<Elevation> open_elevation(const ElevationRequest& request, const Network& network, Diagnostics& diagnostics);

}  // namespace roadgen::cli
