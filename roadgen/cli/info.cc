// roadgen info: what a network holds, as JSON.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/import/opendrive.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen info";
using Json = nlohmann::ordered_json;

Json describe(const Network& network) {
  Json roads = Json::array();
  double length_m = 0;
  for (const Road& road : network.roads) {
    length_m += road.length_m();
    roads.push_back({{"id", road.id},
                     {"name", road.name},
                     {"closed", road.closed},
                     {"length_m", road.length_m()},
                     {"segments", road.segments.size()}});
  }
  const Bounds box = bounds(network);
  Json georeference = nullptr;
  if (const auto& origin = network.georeference) {
    georeference = {{"latitude_deg", origin->latitude_deg},
                    {"longitude_deg", origin->longitude_deg},
                    {"height_m", origin->height_m}};
  }
  // One driving lane on each side of every road.
  return {
      {"name", network.name},
      {"roads", network.roads.size()},
      {"segments", network.segment_count()},
      {"lanes", 2 * network.roads.size()},
      {"junctions", 0},
      {"length_m", length_m},
      {"bounds",
       {{"low_m", {box.low_m.x, box.low_m.y, box.low_m.z}}, {"high_m", {box.high_m.x, box.high_m.y, box.high_m.z}}}},
      {"georeference", georeference},
      {"road_list", roads}};
}

}  // namespace

int run_info(const Arguments& arguments) {
  CLI::App app("Tells what an OpenDRIVE network holds, as JSON on standard output.", kName);
  std::string path;
  app.add_option("NET", path, "OpenDRIVE file")->required();
  if (const auto code = parse(app, arguments)) return *code;

  Diagnostics diagnostics;
  const Result<Network> network = read_opendrive(path, &diagnostics);
  if (!network) return fail(kName, network.error());
  print_diagnostics(diagnostics, "");
  if (Status status = put_out(describe(*network).dump(2) + "\n", ""); !status) return fail(kName, status.error());
  return kExitDone;
}

}  // namespace roadgen::cli
