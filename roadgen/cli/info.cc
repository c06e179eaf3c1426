// roadgen info: what a network holds, as JSON.
#include <algorithm>
#include <set>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/import/opendrive.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen info";
using Json = nlohmann::ordered_json;

// How many lanes lie side by side where there are most of them: of any type, and for vehicles that drive.
struct LaneCount {
  std::size_t all = 0, driving = 0;
};
LaneCount lanes_of(const Road& road) {
  LaneCount most;
  for (const LaneSection& section : road.sections) {
    std::size_t driving = 0;
    for (const auto* side : {&section.left, &section.right}) {
      driving += static_cast<std::size_t>(
          std::count_if(side->begin(), side->end(), [](const Lane& lane) { return lane.type == LaneType::kDriving; }));
    }
    most.all = std::max(most.all, section.left.size() + section.right.size());
    most.driving = std::max(most.driving, driving);
  }
  return most;
}

// Of sweeps by their kind, and bridges.
Json structures_of(const Network& network) {
  std::size_t count[4] = {}, bridges = 0;
  for (const Road& road : network.roads) {
    bridges += road.bridges.size();
    for (const Sweep& sweep : road.sweeps) ++count[static_cast<std::size_t>(sweep.kind())];
  }
  return {{"tunnels", count[0]},
          {"guard_rails", count[1]},
          {"pipes", count[2]},
          {"cables", count[3]},
          {"bridges", bridges}};
}

// With an area, as a node of the road graph, or both.
std::size_t junctions_of(const Network& network) {
  std::set<std::string_view> ids;
  for (const Junction& junction : network.junctions) ids.insert(junction.id);
  for (const JunctionLinks& junction : network.junction_links) ids.insert(junction.id);
  return ids.size();
}

Json describe(const Network& network) {
  Json roads = Json::array();
  double length_m = 0;
  LaneCount lanes;
  std::size_t objects = 0, signals = 0;
  for (const Road& road : network.roads) {
    length_m += road.length_m();
    const LaneCount most = lanes_of(road);
    lanes.all += most.all;
    lanes.driving += most.driving;
    objects += road.records->objects.size(), signals += road.records->signals.size();
    roads.push_back({{"id", road.id},
                     {"name", road.name},
                     {"closed", road.closed},
                     {"length_m", road.length_m()},
                     {"segments", road.segments.size()},
                     {"lanes", most.all},
                     {"driving_lanes", most.driving},
                     {"lane_sections", road.sections.size()},
                     {"paint", road.paint.size()},
                     {"structures", road.sweeps.size()},
                     {"objects", road.records->objects.size()},
                     {"signals", road.records->signals.size()}});
  }
  const Bounds box = bounds(network);
  Json georeference = nullptr;
  if (const auto& origin = network.georeference) {
    georeference = {{"latitude_deg", origin->latitude_deg},
                    {"longitude_deg", origin->longitude_deg},
                    {"height_m", origin->height_m}};
    if (!origin->projection.empty()) {
      georeference["projection"] = origin->projection;
      georeference["offset_m"] = {origin->offset_m.x, origin->offset_m.y, origin->height_m};
      georeference["offset_heading_rad"] = origin->offset_heading_rad;
    }
  }
  return {
      {"name", network.name},
      {"roads", network.roads.size()},
      {"segments", network.segment_count()},
      {"lanes", lanes.all},
      {"driving_lanes", lanes.driving},
      {"junctions", junctions_of(network)},
      {"junction_areas", network.junctions.size()},
      {"structures", structures_of(network)},
      {"objects", objects},
      {"signals", signals},
      {"controllers", network.controllers.size()},
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
