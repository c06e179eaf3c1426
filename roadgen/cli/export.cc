// roadgen export: a network as a mesh or as lines, for tools that do not read OpenDRIVE.
#include <filesystem>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/export/geojson.h"
#include "roadgen/export/gltf.h"
#include "roadgen/import/opendrive.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen export";
using Json = nlohmann::ordered_json;

struct Exported {
  std::string bytes;
  Json report;
};

Result<Exported> mesh_of(const Network& network, double max_error_m) {
  const Result<NetworkMesh> mesh = tessellate(network, {.max_error_m = max_error_m});
  if (!mesh) return mesh.error();
  Result<std::string> bytes = gltf_binary(*mesh, network.georeference);
  if (!bytes) return bytes.error();
  return Exported{std::move(*bytes),
                  {{"format", "glTF 2.0"}, {"triangles", mesh->triangles}, {"error_m", mesh->error_m}}};
}

Result<Exported> lines_of(const Network& network, double max_error_m) {
  Result<std::string> text = geojson_text(network, max_error_m);
  if (!text) return text.error();
  return Exported{std::move(*text), {{"format", "GeoJSON"}, {"error_m", max_error_m}}};
}

}  // namespace

int run_export(const Arguments& arguments) {
  CLI::App app("Writes a network as a binary glTF mesh (.glb) or as the lines of its lanes (.geojson).", kName);
  std::string path, output;
  double max_error_m = 0.01;
  app.add_option("NET", path, "OpenDRIVE file")->required();
  app.add_option("-o,--output", output, "Ends in .glb or .geojson")->required();
  app.add_option("--max-error", max_error_m, "Greatest distance of the triangles or lines from the road, m")
      ->capture_default_str();
  if (const auto code = parse(app, arguments)) return *code;
  const std::string kind = std::filesystem::path(output).extension();
  if (kind != ".glb" && kind != ".geojson") {
    return fail(kName, {ErrorCode::kUsage, "must end in .glb or .geojson", output});
  }
  if (Status status = check_writable(output); !status) return fail(kName, status.error());

  Diagnostics diagnostics;
  const Result<Network> network = read_opendrive(path, &diagnostics);
  if (!network) return fail(kName, network.error());
  print_diagnostics(diagnostics, "");
  const Result<Exported> exported = kind == ".glb" ? mesh_of(*network, max_error_m) : lines_of(*network, max_error_m);
  if (!exported) return fail(kName, exported.error());
  if (Status status = write_file(output, exported->bytes); !status) return fail(kName, status.error());
  if (Status status = put_out(exported->report.dump(2) + "\n", ""); !status) return fail(kName, status.error());
  return kExitDone;
}

}  // namespace roadgen::cli
