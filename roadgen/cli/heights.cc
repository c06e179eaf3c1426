// The step of roadgen import that fits heights to an elevation file.
#include "roadgen/cli/ground.h"
#include "roadgen/cli/import_command.h"
#include "terrain/natural.h"

namespace roadgen::cli {

Result<HeightFitReport> lay_on_ground(Network& network, const HeightRequest& request, Diagnostics& diagnostics) {
  const Result<Elevation> elevation =
      open_elevation({request.dem_path, request.encoding, request.datum, request.road_datum, request.geoid_path},
                     network, diagnostics);
  if (!elevation) return elevation.error();
  if (Status covered = check_coverage(*elevation, network); !covered) return covered.error();
  return fit_heights(network, measured_ground(*elevation, network), request.fit, &diagnostics);
}

int run_import(const Arguments& arguments) { return import_command(arguments, lay_on_ground); }

}  // namespace roadgen::cli
