// Time and peak memory of the import of OpenStreetMap and OpenDRIVE, side by side with SUMO's netconvert on the same
// files.
//   import_bench [FILE.osm[.gz]|FILE.xodr...] [--city WAYS...] [--repeats N] [--roadgen PROGRAM] [--netconvert PROGRAM]
//   import_bench --write-city WAYS FILE     writes a street grid, .osm, .osm.gz or .osm.pbf
//   import_bench --import FILE              imports and prints what came of it
// The programs run in turn; of each the medians of wall clock and processor time, and the greatest resident set, as the
// kernel counts them. Of OpenDRIVE the reading alone is compared, since nothing is left to be written. Cities are read as PBF by roadgen and as XML by netconvert, which knows no PBF.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "roadgen/import/import.h"
#include "roadgen/import/opendrive.h"
#include "tests/common/osm_city.h"
#include "tests/temporary_folder.h"

namespace {

using roadgen::test::TemporaryFolder;

struct Run {
  double wall_s = 0, cpu_s = 0, peak_mb = 0;
  bool ok = false;
};

// Runs a program to its end, its output thrown away.
Run run(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const auto start = std::chrono::steady_clock::now();
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    (void)!std::freopen("/dev/null", "w", stdout);
    (void)!std::freopen("/dev/null", "w", stderr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  const auto seconds = [](timeval t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
          seconds(used.ru_utime) + seconds(used.ru_stime), static_cast<double>(used.ru_maxrss) / 1024,
          WIFEXITED(status) && WEXITSTATUS(status) == 0};
}

Run median(std::vector<Run> runs) {
  const auto middle = [&](auto member) {
    std::nth_element(runs.begin(), runs.begin() + static_cast<std::ptrdiff_t>(runs.size() / 2), runs.end(),
                     [&](const Run& a, const Run& b) { return a.*member < b.*member; });
    return runs[runs.size() / 2].*member;
  };
  Run m{middle(&Run::wall_s), middle(&Run::cpu_s), middle(&Run::peak_mb), true};
  m.ok = std::all_of(runs.begin(), runs.end(), [](const Run& r) { return r.ok; });
  return m;
}

// Its own map of types is not part of every package. Lanes, directions and traffic as in SUMO's osmNetconvert.typ.xml.
std::string types_xml() {
  struct Type {
    const char* name;
    int priority, lanes;
    double speed;
    bool oneway;
  };
  constexpr Type kTypes[] = {{"motorway", 13, 2, 44.44, true},     {"motorway_link", 12, 1, 22.22, true},
                             {"trunk", 11, 2, 27.78, false},       {"trunk_link", 10, 1, 22.22, false},
                             {"primary", 9, 2, 27.78, false},      {"primary_link", 8, 1, 22.22, false},
                             {"secondary", 7, 1, 27.78, false},    {"secondary_link", 6, 1, 22.22, false},
                             {"tertiary", 6, 1, 22.22, false},     {"tertiary_link", 5, 1, 22.22, false},
                             {"unclassified", 5, 1, 13.89, false}, {"residential", 4, 1, 13.89, false},
                             {"living_street", 3, 1, 2.78, false}, {"road", 4, 1, 13.89, false},
                             {"service", 2, 1, 5.56, false},       {"track", 1, 1, 5.56, false}};
  std::string xml = "<types>\n";
  for (const Type& t : kTypes) {
    xml += fmt::format(
        "<type id=\"highway.{}\" numLanes=\"{}\" speed=\"{}\" priority=\"{}\" oneway=\"{}\" "
        "disallow=\"tram rail_urban rail rail_electric rail_fast ship\"/>\n",
        t.name, t.lanes, t.speed, t.priority, t.oneway);
  }
  return xml + "</types>\n";
}

// Likewise for the types of lanes of OpenDRIVE.
std::string lane_types_xml() {
  std::string xml = "<types>\n";
  for (const char* name : {"driving", "bidirectional", "entry", "exit", "onRamp", "offRamp", "connectingRamp"}) {
    xml += fmt::format("<type id=\"{}\" numLanes=\"1\" speed=\"13.89\" priority=\"1\"/>\n", name);
  }
  for (const char* name :
       {"shoulder", "border", "none", "sidewalk", "parking", "median", "restricted", "stop", "curb"}) {
    xml += fmt::format("<type id=\"{}\" numLanes=\"1\" speed=\"1\" priority=\"1\" discard=\"1\"/>\n", name);
  }
  return xml + "</types>\n";
}

struct Options {
  std::vector<std::string> files;
  std::vector<std::size_t> cities;
  int repeats = 3;
  std::string self, roadgen, netconvert = "netconvert", import, city_file;
};

bool is_opendrive(const std::string& path) { return path.ends_with(".xodr"); }

void compare(const Options& o, const std::string& name, const std::string& ours, const std::string& theirs) {
  const TemporaryFolder folder;
  const std::string types = folder.put("types.typ.xml", types_xml());
  const std::string lane_types = folder.put("lanes.typ.xml", lane_types_xml());
  std::vector<std::string> netconvert = {o.netconvert, "--aggregate-warnings", "1", "-o", folder.path("net.xml")};
  if (is_opendrive(theirs)) {
    netconvert.insert(netconvert.end(), {"--type-files", lane_types, "--opendrive-files", theirs});
  } else {
    netconvert.insert(netconvert.end(), {"--type-files", types, "--osm-files", theirs});
  }
  std::vector<std::vector<std::string>> commands = {netconvert, {o.self, "--import", ours}};
  if (!is_opendrive(ours)) commands.push_back({o.roadgen, "import", ours, "-o", folder.path("net.xodr")});
  const char* const titles[] = {"netconvert", "import", "roadgen import -o"};
  std::vector<std::vector<Run>> runs(commands.size());
  for (int i = 0; i < o.repeats; ++i) {
    for (std::size_t k = 0; k < commands.size(); ++k) runs[k].push_back(run(commands[k]));
  }
  const Run base = median(runs[0]);
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const Run m = median(runs[k]);
    fmt::print("| {:24} | {:17} | {:8.2f} | {:8.2f} | {:8.0f} | {:5.3f} | {:5.3f} | {:5.3f} |{}\n", name, titles[k],
               m.wall_s, m.cpu_s, m.peak_mb, m.wall_s / base.wall_s, m.cpu_s / base.cpu_s, m.peak_mb / base.peak_mb,
               m.ok ? "" : " failed");
    std::fflush(stdout);
  }
}

int import_one(const std::string& path) {
  const auto describe = [](const roadgen::Network& network) {
    fmt::print("{} roads, {} segments, {} junctions\n", network.roads.size(), network.segment_count(),
               network.junctions.size());
    return 0;
  };
  const auto fail = [](const roadgen::Error& error) {
    fmt::print(stderr, "{}\n", error.text());
    return 1;
  };
  if (is_opendrive(path)) {
    const auto network = roadgen::read_opendrive(path);
    return network ? describe(*network) : fail(network.error());
  }
  const auto result = roadgen::import_files({path}, {});
  return result ? describe(result->network) : fail(result.error());
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  o.self = std::filesystem::canonical("/proc/self/exe").string();
  o.roadgen = std::filesystem::path(o.self).replace_filename("roadgen").string();
  std::size_t write_ways = 0;
  CLI::App app("Import of OpenStreetMap against SUMO's netconvert");
  app.add_option("FILE", o.files, "OSM files that both read; with --write-city the one to write");
  app.add_option("--city", o.cities, "Street grids of so many ways");
  app.add_option("--repeats", o.repeats, "Runs of each")->check(CLI::Range(1, 99))->capture_default_str();
  app.add_option("--roadgen", o.roadgen, "The program")->capture_default_str();
  app.add_option("--netconvert", o.netconvert, "SUMO's program")->capture_default_str();
  app.add_option("--import", o.import, "Import this file, and no more");
  app.add_option("--write-city", write_ways, "Write a street grid, and no more");
  CLI11_PARSE(app, argc, argv);
  if (!o.import.empty()) return import_one(o.import);
  if (write_ways > 0) {
    for (const std::string& file : o.files) fmt::print("{} ways\n", roadgen::test::write_osm_city(file, write_ways));
    return 0;
  }
  fmt::print("| file | program | wall s | CPU s | peak MB | wall, ratio | CPU, ratio | memory, ratio |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const std::string& file : o.files) compare(o, std::filesystem::path(file).filename().string(), file, file);
  for (const std::size_t ways : o.cities) {
    const TemporaryFolder folder;
    const std::string pbf = folder.path("city.osm.pbf"), xml = folder.path("city.osm");
    const std::size_t written = roadgen::test::write_osm_city(pbf, ways);
    (void)roadgen::test::write_osm_city(xml, ways);
    compare(o, fmt::format("grid of {} ways", written), pbf, xml);
  }
  return 0;
}
