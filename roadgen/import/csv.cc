#include "roadgen/import/csv.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <initializer_list>
#include <map>

#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

enum Column { kLatitude, kLongitude, kX, kY, kHeight, kWidth, kLanes, kColumns };

const std::map<std::string, Column, std::less<>>& column_names() {
  static const std::map<std::string, Column, std::less<>> names = {{"lat", kLatitude},
                                                                   {"latitude", kLatitude},
                                                                   {"lon", kLongitude},
                                                                   {"lng", kLongitude},
                                                                   {"long", kLongitude},
                                                                   {"longitude", kLongitude},
                                                                   {"x", kX},
                                                                   {"x_m", kX},
                                                                   {"east", kX},
                                                                   {"easting", kX},
                                                                   {"y", kY},
                                                                   {"y_m", kY},
                                                                   {"north", kY},
                                                                   {"northing", kY},
                                                                   {"height", kHeight},
                                                                   {"h", kHeight},
                                                                   {"z", kHeight},
                                                                   {"z_m", kHeight},
                                                                   {"ele", kHeight},
                                                                   {"elev", kHeight},
                                                                   {"elevation", kHeight},
                                                                   {"alt", kHeight},
                                                                   {"altitude", kHeight},
                                                                   {"width", kWidth},
                                                                   {"w", kWidth},
                                                                   {"width_m", kWidth}};
  return names;
}

// Where each column stands in a row, or -1.
struct Header {
  std::array<int, kColumns> at;
  std::size_t cells = 0;
  char separator = ',';
  bool geodetic = true;

  int x() const { return at[geodetic ? kLongitude : kX]; }
  int y() const { return at[geodetic ? kLatitude : kY]; }
};

std::vector<std::string_view> split(std::string_view row, char separator) {
  std::vector<std::string_view> cells;
  while (true) {
    const std::size_t end = row.find(separator);
    std::string_view cell = trimmed(row.substr(0, end));
    if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = trimmed(cell.substr(1, cell.size() - 2));
    cells.push_back(cell);
    if (end == std::string_view::npos) return cells;
    row.remove_prefix(end + 1);
  }
}

char separator_of(std::string_view row) {
  for (const char candidate : {';', '\t'}) {
    if (row.find(candidate) != std::string_view::npos) return candidate;
  }
  return ',';
}

std::string lowered(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

Result<Header> parse_header(std::string_view row, const std::string& file, int line, const FieldNames& fields,
                            Diagnostics& diagnostics) {
  const auto bad = [&](const std::string& message) { return Error{ErrorCode::kParse, message, file, line}; };
  if (row.starts_with('#')) row.remove_prefix(1);
  Header header;
  header.at.fill(-1);
  header.separator = separator_of(row);
  const std::vector<std::string_view> names = split(row, header.separator);
  header.cells = names.size();

  // The columns that the caller names stand for what others are known for.
  std::array<std::string, kColumns> named;
  named[kWidth] = lowered(fields.width), named[kLanes] = lowered(fields.lanes), named[kHeight] = lowered(fields.height);
  const auto column_of = [&](std::string_view name) -> std::optional<Column> {
    const std::string key = lowered(name);
    const auto given = std::find(named.begin(), named.end(), key);
    if (!key.empty() && given != named.end()) return static_cast<Column>(given - named.begin());
    const auto known = column_names().find(key);
    if (known == column_names().end() || !named[known->second].empty()) return {};
    return known->second;
  };

  std::string ignored;
  bool all_numbers = true;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!names[i].empty() && !parse_number(names[i])) all_numbers = false;
    const std::optional<Column> column = column_of(names[i]);
    if (!column) {
      ignored += (ignored.empty() ? "" : ", ") + std::string(names[i]);
      continue;
    }
    if (header.at[*column] >= 0)
      return bad("the header names the column '" + std::string(names[i]) + "' or its like twice");
    header.at[*column] = static_cast<int>(i);
  }
  if (all_numbers) return bad("there is no header line; begin the file with 'lat,lon' or 'x,y' [,height][,width]");

  const auto has = [&](Column column) { return header.at[column] >= 0; };
  header.geodetic = has(kLatitude) || has(kLongitude);
  if (header.x() < 0 || header.y() < 0) {
    return bad("the header names no position; it needs the columns lat and lon, or x and y");
  }
  if (header.geodetic && (has(kX) || has(kY)))
    ignored += (ignored.empty() ? "" : ", ") + std::string("x and y, since lat and lon are there");
  for (const Column column : {kWidth, kLanes, kHeight}) {
    if (named[column].empty() || has(column)) continue;
    return Error{ErrorCode::kData, "has no column '" + named[column] + "'", file, line};
  }
  if (!ignored.empty()) diagnostics.push_back({Severity::kInfo, "columns not used: " + ignored, file, line});
  return header;
}

// Points left out for want of a position, as one diagnostic for each run of lines.
class LeftOut {
 public:
  LeftOut(const std::string& file, Diagnostics& diagnostics) : file_(file), diagnostics_(diagnostics) {}
  ~LeftOut() { flush(); }

  void add(int line) {
    if (count_ > 0 && line != last_ + 1) flush();
    if (count_++ == 0) first_ = line;
    last_ = line;
  }

 private:
  void flush() {
    if (count_ == 0) return;
    const std::string lines =
        count_ == 1 ? "" : " (lines " + std::to_string(first_) + "-" + std::to_string(last_) + ")";
    diagnostics_.push_back(
        {Severity::kWarning, "position missing or not finite: point left out" + lines, file_, first_});
    count_ = 0;
  }

  const std::string& file_;
  Diagnostics& diagnostics_;
  int first_ = 0, last_ = 0, count_ = 0;
};

// An empty cell is NaN here, and nowhere else.
Result<double> cell_number(const std::vector<std::string_view>& cells, int at, const std::string& file, int line) {
  if (at < 0 || cells[at].empty()) return std::nan("");
  const std::optional<double> value = parse_number(cells[at]);
  if (!value)
    return Error{ErrorCode::kParse, "'" + std::string(cells[at].substr(0, 40)) + "' is not a number", file, line};
  return *value;
}

struct Row {
  TrackPoint point;
  std::optional<double> lanes;
};

Result<Row> parse_row(std::string_view row, const Header& header, const std::string& file, int line) {
  const std::vector<std::string_view> cells = split(row, header.separator);
  if (cells.size() != header.cells) {
    return Error{ErrorCode::kParse,
                 "the line has " + std::to_string(cells.size()) + " cells where the header has " +
                     std::to_string(header.cells) + "; the file may be truncated",
                 file, line};
  }
  std::array<double, 5> value{};
  const std::array<int, 5> at = {header.x(), header.y(), header.at[kHeight], header.at[kWidth], header.at[kLanes]};
  for (std::size_t i = 0; i < at.size(); ++i) {
    const Result<double> number = cell_number(cells, at[i], file, line);
    if (!number) return number.error();
    value[i] = *number;
  }
  Row parsed;
  TrackPoint& point = parsed.point;
  point.x = value[0], point.y = value[1];
  if (!std::isnan(value[2])) point.height_m = value[2];
  if (!std::isnan(value[3])) point.width_m = value[3];
  if (!std::isnan(value[4])) parsed.lanes = value[4];
  point.line = line;
  return parsed;
}

}  // namespace

Result<std::vector<Track>> parse_csv(std::string_view text, const std::string& file, const FieldNames& fields,
                                     Diagnostics& diagnostics) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (Status status = check_utf8(text, file); !status) return status.error();

  Track track{file, "", stem(file)};
  std::optional<Header> header;
  bool lanes_known = false;
  LeftOut left_out(file, diagnostics);
  for (int line = 1; !text.empty(); ++line) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view row = text.substr(0, end);
    if (row.ends_with('\r')) row.remove_suffix(1);  // not tabs, which may bound empty cells
    text.remove_prefix(std::min(end + 1, text.size()));
    const bool is_comment = row.starts_with('#');
    if (trimmed(row).empty() || (header && is_comment)) continue;
    if (!header) {
      Result<Header> parsed = parse_header(row, file, line, fields, diagnostics);
      if (!parsed && is_comment) continue;
      if (!parsed) return parsed.error();
      header = *parsed;
      track.geodetic = header->geodetic;
      continue;
    }
    Result<Row> parsed = parse_row(row, *header, file, line);
    if (!parsed) return parsed.error();
    TrackPoint* const point = &parsed->point;
    if (parsed->lanes && !lanes_known) {
      track.lanes = lane_count(*parsed->lanes, file, line, "", diagnostics);
      lanes_known = true;
    }
    point->index = static_cast<int>(track.points.size()) + 1;
    if (std::isfinite(point->x) && std::isfinite(point->y))
      track.points.push_back(*point);
    else
      left_out.add(line);
  }
  if (!header) return Error{ErrorCode::kParse, "holds no header and no points", file};
  if (track.points.empty()) return Error{ErrorCode::kData, "holds no points with a position", file};
  return std::vector<Track>{std::move(track)};
}

Result<std::vector<Track>> read_csv(const std::string& path, const FieldNames& fields, Diagnostics& diagnostics) {
  const Result<std::string> text = read_file(path);
  if (!text) return text.error();
  return parse_csv(*text, path, fields, diagnostics);
}

}  // namespace roadgen
