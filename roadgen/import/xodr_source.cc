#include "roadgen/import/xodr_source.h"

#include <iterator>
#include <pugixml.hpp>

namespace roadgen {

void XodrSource::fail(ErrorCode code, const pugi::xml_node& where, std::string message) {
  fail(code, line(where), std::move(message));
}

void XodrSource::fail(ErrorCode code, int line, std::string message) {
  if (!error_) error_ = Error{code, std::move(message), file_, line, element_};
}

void XodrSource::note(const pugi::xml_node& where, const std::string& what) {
  const auto at = notes_.find(what);
  if (at != notes_.end())
    ++at->second.count;
  else
    note(line(where), what);
}

void XodrSource::note(int line, const std::string& what) {
  ++notes_.try_emplace(what, Note{line, element_, 0}).first->second.count;
}

Diagnostics XodrSource::notes() const {
  Diagnostics diagnostics;
  for (const auto& [what, seen] : notes_) {
    const std::string times = seen.count > 1 ? " (" + std::to_string(seen.count) + " times, first here)" : "";
    diagnostics.push_back({Severity::kWarning, what + times, file_, seen.line, seen.element});
  }
  return diagnostics;
}

void XodrSource::add_notes(const XodrSource& part) {
  for (const auto& [what, seen] : part.notes_) {
    notes_.try_emplace(what, Note{seen.line, seen.element, 0}).first->second.count += seen.count;
  }
}

int XodrSource::line(const pugi::xml_node& node) const { return line(node.offset_debug()); }
int XodrSource::line(std::ptrdiff_t offset) const { return first_line_ - 1 + lines_.line(offset); }

double XodrSource::number(const pugi::xml_node& node, const char* name) {
  if (!node.attribute(name)) {
    fail(ErrorCode::kParse, node, std::string("<") + node.name() + "> lacks the attribute " + name);
    return 0;
  }
  return number_or(node, name, 0);
}

double XodrSource::number_or(const pugi::xml_node& node, const char* name, double fallback) {
  const pugi::xml_attribute attribute = node.attribute(name);
  if (!attribute) return fallback;
  const std::optional<double> value = parse_number(attribute.value());
  if (value && std::isfinite(*value)) return *value;
  fail(ErrorCode::kParse, node,
       std::string("<") + node.name() + "> has " + name + "=\"" + attribute.value() +
           "\", which is not a finite number");
  return fallback;
}

std::string XodrSource::word(const pugi::xml_node& node, const char* name) {
  const pugi::xml_attribute attribute = node.attribute(name);
  if (!attribute || !*attribute.value()) {
    fail(ErrorCode::kParse, node, std::string("<") + node.name() + "> lacks the attribute " + name);
  }
  return attribute.value();
}

Cubic XodrSource::cubic(const pugi::xml_node& node) {
  return {number(node, "a"), number(node, "b"), number(node, "c"), number(node, "d")};
}

std::vector<double> numbers_in(std::string_view text) {
  std::vector<double> numbers;
  while (!(text = trimmed(text)).empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::optional<double> x = parse_number(text.substr(0, end));
    if (!x || !std::isfinite(*x)) return {};
    numbers.push_back(*x);
    text.remove_prefix(end);
  }
  return numbers;
}

std::string user_data(const pugi::xml_node& parent, const char* code) {
  return parent.find_child_by_attribute("userData", "code", code).attribute("value").value();
}

void note_others(XodrSource& source, const pugi::xml_node& node, const std::string& where,
                 std::initializer_list<std::string_view> known) {
  for (const pugi::xml_node child : node.children()) {
    const std::string name = child.name();
    if (child.type() != pugi::node_element || std::find(known.begin(), known.end(), name) != known.end()) continue;
    source.note(child, "<" + name + "> of " + where + " is not kept");
  }
}

Profile read_profile(XodrSource& source, const pugi::xml_node& parent, const char* name, const char* position,
                     double base_m) {
  Profile records;
  for (const pugi::xml_node node : parent.children(name)) {
    records.push_back({base_m + source.number(node, position), source.cubic(node), source.line(node)});
  }
  expect_order(source, records, std::string("<") + name + ">");
  return records;
}

void Stations::add(double s_m) {
  if (s_m > 0 && s_m < end_m_ - kLeastPiece_m && snapped(s_m) == s_m) all_.insert(s_m);
}

double Stations::snapped(double s_m) const {
  const auto after = all_.lower_bound(s_m);
  double best = s_m, least = kLeastPiece_m;
  for (const auto at : {after, after == all_.begin() ? all_.end() : std::prev(after)}) {
    if (at != all_.end() && std::abs(*at - s_m) < least) best = *at, least = std::abs(*at - s_m);
  }
  return best;
}

std::vector<double> Stations::between(double from_m, double to_m) const {
  return {all_.lower_bound(from_m), all_.lower_bound(to_m)};
}

Cubic cubic_from(const Profile& profile, double s_m, const Stations& stations) {
  const From<Cubic>* record = holding(profile, s_m, stations);
  if (!record) return {};
  const double by = s_m - record->s_m;
  return record->value.shifted(std::abs(by) <= kSamePlace_m ? 0 : by);
}

}  // namespace roadgen
