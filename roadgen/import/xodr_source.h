// What all parts of the OpenDRIVE reader share: attributes with their errors, notes, and records along a road. Internal
// to roadgen/import.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/import/text_file.h"
#include "roadgen/road/cubic.h"
#include "roadgen/road/result.h"

namespace pugi {
class xml_node;
}

namespace roadgen {

// Files write s and coordinates with few digits: what counts as the same place.
inline constexpr double kSamePlace_m = 1e-6;
// Greatest absolute value of a profile, in metres or radians.
inline constexpr double kGreatestProfile = 1e6;

// A document, or a part of one, that is being read. The first error stops everything: callers return early once failed().
class XodrSource {
 public:
  // first_line: of the text in its file.
  XodrSource(std::string_view text, std::string file, int first_line = 1)
      : lines_(text), first_line_(first_line), file_(std::move(file)) {}

  // The road or other element that errors and notes name.
  void set_element(std::string element) { element_ = std::move(element); }
  const std::string& element() const { return element_; }
  const std::string& file() const { return file_; }

  bool failed() const { return error_.has_value(); }
  const Error& error() const { return *error_; }
  void fail(ErrorCode code, const pugi::xml_node& where, std::string message);
  void fail(ErrorCode code, int line, std::string message);

  // What is not kept: told once for each text, with how often it was met.
  void note(const pugi::xml_node& where, const std::string& what);
  void note(int line, const std::string& what);
  Diagnostics notes() const;
  // Those of a part, after what was noted before.
  void add_notes(const XodrSource& part);

  int line(const pugi::xml_node& node) const;
  int line(std::ptrdiff_t offset) const;  // of a byte of the text

  // Attributes; missing or malformed ones are errors. number_or: only malformed ones.
  double number(const pugi::xml_node& node, const char* name);
  double number_or(const pugi::xml_node& node, const char* name, double fallback);
  std::string word(const pugi::xml_node& node, const char* name);
  Cubic cubic(const pugi::xml_node& node);

 private:
  struct Note {
    int line;
    std::string element;
    int count;
  };

  LineIndex lines_;
  int first_line_;
  std::string file_, element_;
  std::optional<Error> error_;
  std::map<std::string, Note> notes_;
};

// Numbers with blanks between; empty where one is malformed or not finite.
std::vector<double> numbers_in(std::string_view text);
// The value of the node's <userData code=CODE>, or empty.
std::string user_data(const pugi::xml_node& parent, const char* code);

// Notes the children of other names: "<NAME> of WHERE is not kept".
void note_others(XodrSource& source, const pugi::xml_node& node, const std::string& where,
                 std::initializer_list<std::string_view> known);

// Something that holds from s on.
template <class T>
struct From {
  double s_m = 0;
  T value{};
  int line = 0;
};
using Profile = std::vector<From<Cubic>>;

// The cubics of all children of that name, from the attribute `position` plus base_m on. Errors: kParse where they are
// out of order.
Profile read_profile(XodrSource& source, const pugi::xml_node& parent, const char* name, const char* position,
                     double base_m = 0);

// Fails where a record stands before the one that precedes it in the list.
template <class T>
void expect_order(XodrSource& source, const std::vector<From<T>>& records, const std::string& what) {
  const auto before = [](const From<T>& a, const From<T>& b) { return a.s_m < b.s_m; };
  const auto at = std::is_sorted_until(records.begin(), records.end(), before);
  if (at != records.end()) source.fail(ErrorCode::kParse, at->line, what + " records are not in order");
}

// The places of a road where a segment must start, in the file's s: where geometries do, and where records do. Records
// closer than kLeastPiece_m to one of the others are moved there.
class Stations {
 public:
  // Requires: geometries in order.
  Stations(const std::vector<double>& geometries_m, double end_m)
      : all_(geometries_m.begin(), geometries_m.end()), end_m_(end_m) {}
  void add(double s_m);
  // The station that s was moved to, or s.
  double snapped(double s_m) const;
  // Those with from_m <= s < to_m.
  std::vector<double> between(double from_m, double to_m) const;
  double end_m() const { return end_m_; }

 private:
  std::set<double> all_;
  double end_m_;
};
inline constexpr double kLeastPiece_m = 2e-3;

// The record that holds from station s_m on, or null.
template <class T>
const From<T>* holding(const std::vector<From<T>>& records, double s_m, const Stations& stations) {
  const auto after = std::partition_point(records.begin(), records.end(),
                                          [&](const From<T>& r) { return stations.snapped(r.s_m) <= s_m; });
  return after == records.begin() ? nullptr : &*(after - 1);
}

// The profile's cubic from station s_m on, over s - s_m; 0 where none holds.
Cubic cubic_from(const Profile& profile, double s_m, const Stations& stations);

}  // namespace roadgen
