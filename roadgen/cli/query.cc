// roadgen query: world to road and road to world, rows of CSV from standard input to standard output.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <unordered_map>

#include "roadgen/cli/command.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/import/text_file.h"
#include "roadgen/query/road_index.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen query";
constexpr const char* kInput = "standard input";
constexpr const char* kHelp =
    "Where on which road points lie, or where in the world places of roads lie. Reads rows of CSV from standard input, "
    "with or without a header row that names the columns (further ones are then ignored), and writes as many rows, "
    "after "
    "a header row, to standard output. Metres and radians; x east, y north, z up; s along the road, t to the left. A "
    "bad "
    "row is named by its line, nothing is written then, and the exit code is 1.";
constexpr const char* kFooter =
    "--to-road: x,y[,z] -> road,s,t,lane,x,y,z,heading,pitch,roll,curvature,distance\n"
    "  The road (its id) that the point belongs to: one whose carriageway holds it, else the nearest; z, where given,\n"
    "  tells a bridge from the road below. lane: its id, 0 beside all lanes. x to curvature: the pose of the surface "
    "at\n"
    "  s and t. distance: from the carriageway, horizontally; 0 on it. On a junction's area the pose is the area's and "
    "the\n"
    "  road one that leads through. All cells are empty where no road is in reach.\n"
    "--to-world: road,s,t -> x,y,z,heading,pitch,roll\n"
    "  s in [0, length]; on closed roads any s, which wraps.";

struct Options {
  std::string network_path;
  bool to_road = false, to_world = false, all = false;
  double reach_m = std::numeric_limits<double>::infinity();
};

// ---- Rows ----

Error bad_row(int line, std::string message) { return {ErrorCode::kParse, std::move(message), kInput, line}; }

// Cells between commas; in quotes they may hold commas, and quotes twice.
std::vector<std::string> split(std::string_view row) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (row[i] == '"') {
      const bool twice = quoted && i + 1 < row.size() && row[i + 1] == '"';
      if (twice) cells.back() += row[i++];
      quoted = twice || !quoted;
    } else if (row[i] == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back() += row[i];
    }
  }
  for (std::string& cell : cells) cell = trimmed(cell);
  return cells;
}

std::string quoted_where_needed(const std::string& cell) {
  if (cell.find_first_of(",\"\n\r") == std::string::npos && trimmed(cell) == cell) return cell;
  std::string quoted = "\"";
  for (const char c : cell) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

// Where the wanted columns stand in a row; the first `required` of them must.
struct Columns {
  std::array<const char*, 3> names;
  std::size_t required;
  std::array<std::size_t, 3> at = {0, 1, 2};
  std::size_t cells = 0;  // of the header; 0 where there is none

  // Whether the row is a header: names all that are required. Takes its order then.
  bool read_header(const std::vector<std::string>& row) {
    std::array<std::size_t, 3> found;
    for (std::size_t i = 0; i < names.size(); ++i) {
      found[i] = static_cast<std::size_t>(std::find(row.begin(), row.end(), names[i]) - row.begin());
      if (found[i] == row.size() && i < required) return false;
    }
    at = found;
    cells = row.size();
    return true;
  }

  // Errors: kParse, a row of another length.
  Status check(const std::vector<std::string>& row, int line) const {
    const bool fits = cells > 0 ? row.size() == cells : row.size() >= required && row.size() <= names.size();
    if (fits) return Done{};
    std::string wanted = cells > 0
                             ? fmt::format("the header has {}", cells)
                             : fmt::format("{} make a row", fmt::join(names.begin(), names.begin() + required, ","));
    if (cells == 0 && required < names.size()) wanted += fmt::format(", or with {}", names.back());
    return bad_row(line, fmt::format("the row has {} cell{} where {}", row.size(), row.size() == 1 ? "" : "s", wanted));
  }

  // The cell of a column; nothing where there is none or it is empty.
  const std::string* cell(const std::vector<std::string>& row, std::size_t column) const {
    return at[column] < row.size() && !row[at[column]].empty() ? &row[at[column]] : nullptr;
  }
  // Errors: kParse where the cell is missing or not a finite number.
  Result<double> number(const std::vector<std::string>& row, std::size_t column, int line) const {
    const std::string* text = cell(row, column);
    if (!text) return bad_row(line, fmt::format("{} is missing", names[column]));
    const std::optional<double> value = parse_number(*text);
    if (value && std::isfinite(*value)) return *value;
    return bad_row(line, fmt::format("{} is '{}', not a finite number", names[column], text->substr(0, 40)));
  }
};

// Calls answer(row, line) for every row below the header, which returns a Status.
template <class Answer>
Status for_each_row(std::string_view text, Columns& columns, Answer&& answer) {
  if (Status status = check_utf8(text, kInput); !status) return status.error();
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  bool first = true;
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view whole = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (trimmed(whole).empty()) continue;
    const std::vector<std::string> row = split(whole);
    if (std::exchange(first, false) && columns.read_header(row)) continue;
    if (Status status = columns.check(row, line); !status) return status.error();
    if (Status status = answer(row, line); !status) return status.error();
  }
  return Done{};
}

// ---- The two ways ----

class ToRoad {
 public:
  ToRoad(const RoadIndex& index, const Options& options) : index_(index), options_(options) {}

  // Errors: kParse.
  Result<std::string> answers(std::string_view text) {
    Columns columns{{"x", "y", "z"}, 2};
    out_ = options_.all ? "point," : "";
    out_ += "road,s,t,lane,x,y,z,heading,pitch,roll,curvature,distance\n";
    const Status status = for_each_row(text, columns, [&](const auto& row, int line) -> Status {
      const Result<double> x = columns.number(row, 0, line), y = columns.number(row, 1, line);
      if (!x) return x.error();
      if (!y) return y.error();
      ++points_;
      if (!columns.cell(row, 2)) {
        add(glm::dvec2(*x, *y));
        return Done{};
      }
      const Result<double> z = columns.number(row, 2, line);
      if (!z) return z.error();
      add(glm::dvec3(*x, *y, *z));
      return Done{};
    });
    if (!status) return status.error();
    return std::move(out_);
  }

 private:
  template <class Point>
  void add(Point point_m) {
    if (options_.all) {
      std::size_t count = index_.candidates(point_m, options_.reach_m, room_);
      if (count > room_.size()) {
        room_.resize(count);
        count = index_.candidates(point_m, options_.reach_m, room_);
      }
      for (std::size_t i = 0; i < count; ++i) {
        out_ += fmt::format("{},", points_);
        add_place(room_[i], glm::dvec2(point_m));
      }
      return;
    }
    if (const auto found = index_.to_road(point_m, options_.reach_m)) {
      add_place(*found, glm::dvec2(point_m));
    } else {
      out_ += ",,,,,,,,,,,\n";
    }
  }

  void add_place(const RoadPoint& place, glm::dvec2 point_m) {
    const RoadPose pose = index_.pose(place, point_m);
    if (place.has_road()) {
      const std::string& id = index_.network().roads[place.at.road].id;
      fmt::format_to(std::back_inserter(out_), "{},{},{},{},", quoted_where_needed(id), place.s_m, place.t_m,
                     place.lane);
    } else {
      out_ += ",,,0,";
    }
    const glm::dvec3 p = pose.position_m;
    fmt::format_to(std::back_inserter(out_), "{},{},{},{},{},{},{},{}\n", p.x, p.y, p.z, pose.heading_rad,
                   pose.pitch_rad, pose.roll_rad, pose.curvature_per_m, place.outside_m);
  }

  const RoadIndex& index_;
  const Options& options_;
  std::string out_;
  std::size_t points_ = 0;
  std::vector<RoadPoint> room_ = std::vector<RoadPoint>(16);
};

// Errors: kParse, kData for a road that is not there or an s beyond it.
Result<std::string> worlds(const RoadIndex& index, std::string_view text) {
  constexpr double kBeyond_m = 1e-6;  // the rounding of an s at the road's end
  const std::vector<Road>& roads = index.network().roads;
  std::unordered_map<std::string_view, std::uint32_t> index_of;
  for (std::uint32_t i = 0; i < roads.size(); ++i) index_of.emplace(roads[i].id, i);

  Columns columns{{"road", "s", "t"}, 3};
  std::string out = "x,y,z,heading,pitch,roll\n";
  const Status status = for_each_row(text, columns, [&](const auto& row, int line) -> Status {
    const std::string* id = columns.cell(row, 0);
    const auto found = id ? index_of.find(*id) : index_of.end();
    if (found == index_of.end()) {
      return bad_row(line, fmt::format("there is no road '{}' in the network", id ? id->substr(0, 40) : ""));
    }
    const Result<double> s = columns.number(row, 1, line), t = columns.number(row, 2, line);
    if (!s) return s.error();
    if (!t) return t.error();
    const Road& road = roads[found->second];
    if (!road.closed && (*s < -kBeyond_m || *s > road.length_m() + kBeyond_m)) {
      return bad_row(line, fmt::format("s is {}, and road '{}' is {} m long", *s, road.id, road.length_m()));
    }
    const RoadPose pose = index.to_world({found->second, *s, *t});
    const glm::dvec3 p = pose.position_m;
    fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{}\n", p.x, p.y, p.z, pose.heading_rad, pose.pitch_rad,
                   pose.roll_rad);
    return Done{};
  });
  if (!status) return status.error();
  return out;
}

Result<std::string> read_input() {
  std::string text;
  std::array<char, 1 << 16> part;
  while (const std::size_t count = std::fread(part.data(), 1, part.size(), stdin)) text.append(part.data(), count);
  if (std::ferror(stdin)) return Error{ErrorCode::kIo, "cannot be read to its end", kInput};
  return text;
}

}  // namespace

int run_query(const Arguments& arguments) {
  CLI::App app(kHelp, kName);
  app.footer(kFooter);
  Options options;
  app.add_option("NET", options.network_path, "OpenDRIVE file")->required();
  CLI::Option_group& ways = *app.add_option_group("Direction");
  ways.add_flag("--to-road", options.to_road, "World to road: rows x,y or x,y,z");
  CLI::Option* to_world = ways.add_flag("--to-world", options.to_world, "Road to world: rows road,s,t");
  ways.require_option(1);
  CLI::Option* reach = app.add_option("--reach", options.reach_m,
                                      "With --to-road: only roads whose carriageway is this near, horizontally, m; "
                                      "without it the nearest road, however far")
                           ->excludes(to_world);
  app.add_flag(
         "--all", options.all,
         "With --to-road and --reach: all roads in reach, best first, a road that passes twice twice; a first column "
         "'point' counts the rows of the input from 1")
      ->excludes(to_world)
      ->needs(reach);
  if (const auto code = parse(app, arguments)) return *code;
  if (!(options.reach_m >= 0)) return fail(kName, {ErrorCode::kUsage, "--reach must be 0 or more"});

  Diagnostics diagnostics;
  const Result<Network> network = read_opendrive(options.network_path, &diagnostics);
  if (!network) return fail(kName, network.error());
  print_diagnostics(diagnostics, "");
  const Result<std::string> text = read_input();
  if (!text) return fail(kName, text.error());
  const RoadIndex index(*network);
  const Result<std::string> answers = options.to_road ? ToRoad(index, options).answers(*text) : worlds(index, *text);
  if (!answers) return fail(kName, answers.error());
  if (Status status = put_out(*answers, ""); !status) return fail(kName, status.error());
  return kExitDone;
}

}  // namespace roadgen::cli
