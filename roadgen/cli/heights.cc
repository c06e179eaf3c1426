// The step of roadgen import that fits heights to an elevation file.
#include "roadgen/cli/import_command.h"
#include "terrain/natural.h"

namespace roadgen::cli {

Result<HeightFitReport> lay_on_ground(Network& network, const HeightRequest& request, Diagnostics& diagnostics) {
  const Result<HeightEncoding> encoding = height_encoding_from_name(request.encoding);
  if (!encoding) return encoding.error();
  const Result<Elevation> elevation = Elevation::open(request.dem_path, &diagnostics, *encoding);
  if (!elevation) return elevation.error();
  if (Status covered = check_coverage(*elevation, network); !covered) return covered.error();
  return fit_heights(network, measured_ground(*elevation, network), request.fit, &diagnostics);
}

int run_import(const Arguments& arguments) { return import_command(arguments, lay_on_ground); }

}  // namespace roadgen::cli
