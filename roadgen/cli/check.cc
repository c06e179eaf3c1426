// roadgen check: whether a network keeps what roadgen promises, as JSON.
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/import/opendrive.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen check";

std::string describe(const CheckReport& report, const Network& network) {
  const JointGap& worst = report.worst;
  const nlohmann::ordered_json json = {{"ok", report.ok()},
                                       {"roads", network.roads.size()},
                                       {"segments", network.segment_count()},
                                       {"joints", report.joints},
                                       {"max_position_gap_m", worst.position_m},
                                       {"max_heading_gap_rad", worst.heading_rad},
                                       {"max_curvature_gap_per_m", worst.curvature_per_m},
                                       {"max_elevation_gap_m", worst.elevation_m},
                                       {"max_grade_gap", worst.grade},
                                       {"max_edge_gap_m", worst.edge_m},
                                       {"max_mapping_bound_m", report.max_mapping_bound_m},
                                       {"max_s_bound_m", report.max_s_bound_m},
                                       {"max_arc_error_m", report.max_arc_error_m},
                                       {"problems", report.problems},
                                       {"warnings", report.warnings}};
  return json.dump(2) + "\n";
}

}  // namespace

int run_check(const Arguments& arguments) {
  CLI::App app(
      "Checks continuity at every joint, the mapping bound of every segment, lanes, profiles, bends and paint. JSON on "
      "standard output; exit code 1 where there are problems.",
      kName);
  std::string path, report_path;
  app.add_option("NET", path, "OpenDRIVE file")->required();
  app.add_option("--report", report_path, "JSON file instead of standard output");
  if (const auto code = parse(app, arguments)) return *code;
  if (!report_path.empty() && report_path != "-") {
    if (Status status = check_writable(report_path); !status) return fail(kName, status.error());
  }

  Diagnostics diagnostics;
  const Result<Network> network = read_opendrive(path, &diagnostics);
  if (!network) return fail(kName, network.error());
  print_diagnostics(diagnostics, "");
  const CheckReport report = check(*network);
  if (Status status = put_out(describe(report, *network), report_path); !status) return fail(kName, status.error());
  if (report.ok()) return kExitDone;
  const std::string more =
      report.problems.size() > 1 ? " (and " + std::to_string(report.problems.size() - 1) + " more)" : "";
  return fail(kName, {ErrorCode::kData, report.problems.front() + more, path});
}

}  // namespace roadgen::cli
