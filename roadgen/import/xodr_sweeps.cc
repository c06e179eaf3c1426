#include "roadgen/import/xodr_sweeps.h"

#include <pugixml.hpp>

#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

constexpr double kLeastLength_m = 1e-3;
// Between a tunnel's wall and the outermost lane.
constexpr double kClearance_m = 0.3;

// Lower case without blanks and underscores.
std::string plain(const char* text) {
  std::string word;
  for (const char* c = text; *c; ++c) {
    if (*c == ' ' || *c == '_' || *c == '-') continue;
    word += *c >= 'A' && *c <= 'Z' ? static_cast<char>(*c - 'A' + 'a') : *c;
  }
  return word;
}

std::optional<SweepKind> kind_of(const pugi::xml_node& element) {
  if (element.name() == std::string_view("tunnel")) return SweepKind::kTunnel;
  if (element.name() != std::string_view("object")) return {};
  const std::string subtype = plain(element.attribute("subtype").value());
  if (element.attribute("type").value() == std::string_view("obstacle")) {
    if (subtype == "pipe") return SweepKind::kPipe;
    if (subtype == "cable") return SweepKind::kCable;
  }
  for (const char* name : {"type", "subtype", "name"}) {
    if (plain(element.attribute(name).value()).find("guardrail") != std::string::npos) return SweepKind::kGuardRail;
  }
  return {};
}

// Cuts the sweep off at the road's ends and keeps it where something is left that can be drawn.
void keep(XodrSource& source, const pugi::xml_node& element, const Road& road, XodrSweep found,
          std::vector<XodrSweep>& sweeps) {
  Sweep& sweep = found.sweep;
  if (!(sweep.s_end_m - sweep.s_start_m > 0)) {
    return source.note(element, "a structure whose length is not positive is not kept");
  }
  const double start = std::max(sweep.s_start_m, 0.0), end = std::min(sweep.s_end_m, road.length_m());
  if (start - sweep.s_start_m > kLeastLength_m || sweep.s_end_m - end > kLeastLength_m) {
    source.note(element, "structures that reach beyond their road are cut off at its end");
    sweep.t_m += sweep.t_slope * (start - sweep.s_start_m);
    sweep.s_start_m = start, sweep.s_end_m = end;
  }
  if (!(sweep.s_end_m - sweep.s_start_m > kLeastLength_m)) return;
  if (!(std::abs(sweep.t_m) <= kGreatestProfile && std::abs(sweep.t_slope) <= kGreatestProfile) ||
      !bad_numbers(road, sweep).empty()) {
    return source.note(element, "a structure with impossible sizes is not kept");
  }
  sweeps.push_back(std::move(found));
}

// Our own file's numbers, where they are whole: the shape always, the place where the element says the same.
std::optional<XodrSweep> exact_sweep(XodrSource& source, const pugi::xml_node& element, SweepKind kind,
                                     const std::function<double(double)>& station_m) {
  const std::string text = user_data(element, "roadgen:sweep");
  if (text.empty()) return {};
  constexpr std::size_t kPlace = 5, kAlbedo = 3;
  const std::vector<double> x = numbers_in(text);
  std::optional<SweepShape> shape;
  bool coloured = false;
  if (x.size() > kPlace) {
    const std::span<const double> rest = std::span(x).subspan(kPlace);
    shape = shape_from_numbers(kind, rest);
    coloured = !shape && rest.size() > kAlbedo;
    if (coloured) shape = shape_from_numbers(kind, rest.first(rest.size() - kAlbedo));
  }
  if (!shape) {
    source.note(element, "userData roadgen:sweep does not hold the numbers of its structure");
    return {};
  }
  const double s = source.number(element, "s"), length = source.number(element, "length");
  double from = x[1], to = x[2];
  if (std::abs(s - from) > kSamePlace_m || std::abs(length - (to - from)) > kSamePlace_m) {
    source.note(element, "userData roadgen:sweep does not agree with s and length, which are used");
    from = s, to = s + length;
  }
  XodrSweep found{x[0], {station_m(from), station_m(to), x[3], x[4], *shape, {}}};
  if (coloured) found.sweep.albedo = glm::dvec3(x[x.size() - 3], x[x.size() - 2], x[x.size() - 1]);
  return found;
}

// A tunnel about all lanes that it runs over.
Sweep tunnel_over(const Road& road, double s_start_m, double s_end_m) {
  double left = -1e300, right = 1e300;
  for (const Segment& segment : road.segments) {
    if (segment.s_start_m >= s_end_m || segment.s_start_m + segment.arc_m <= s_start_m) continue;
    left = std::max(left, segment.left_m.range(segment.arc_m).high);
    right = std::min(right, segment.right_m.range(segment.arc_m).low);
  }
  Tunnel tunnel;
  if (!(left > right)) left = right = 0;
  tunnel.half_width_m = std::max(tunnel.half_width_m, 0.5 * (left - right) + kClearance_m);
  tunnel.walkway_m = std::clamp(tunnel.half_width_m - 0.5 * (left - right), 0.0, tunnel.walkway_m);
  return {s_start_m, s_end_m, 0.5 * (left + right), 0, tunnel, {}};
}

// A rail at the file's height, where it says one that holds a beam.
GuardRail rail_of(XodrSource& source, const pugi::xml_node& element, const char* height, const char* offset) {
  GuardRail rail;
  const double top = source.number_or(element, height, 0) + source.number_or(element, offset, 0);
  if (top > rail.beam_height_m && top <= kGreatestProfile) rail.top_m = top;
  return rail;
}

}  // namespace

bool read_sweeps(XodrSource& source, const pugi::xml_node& element, const Road& road,
                 const std::function<double(double)>& station_m, std::vector<XodrSweep>& sweeps) {
  const std::optional<SweepKind> kind = kind_of(element);
  if (!kind) return false;
  if (auto exact = exact_sweep(source, element, *kind, station_m)) {
    keep(source, element, road, std::move(*exact), sweeps);
    return true;
  }
  if (*kind != SweepKind::kTunnel && *kind != SweepKind::kGuardRail) return false;
  const double s = source.number(element, "s");
  if (*kind == SweepKind::kTunnel) {
    const double length = source.number(element, "length");
    keep(source, element, road, {.sweep = tunnel_over(road, station_m(s), station_m(s + length))}, sweeps);
    return true;
  }
  const double t = source.number(element, "t");
  bool repeated = false;
  for (const pugi::xml_node repeat : element.children("repeat")) {
    const double from = source.number(repeat, "s"), length = source.number(repeat, "length");
    const double first = source.number_or(repeat, "tStart", t), last = source.number_or(repeat, "tEnd", first);
    const GuardRail rail = rail_of(source, repeat, "heightStart", "zOffsetStart");
    const double slope = length > 0 ? (last - first) / length : 0;
    keep(source, repeat, road, {.sweep = {station_m(from), station_m(from + length), first, slope, rail, {}}}, sweeps);
    repeated = true;
  }
  if (repeated) return true;
  // A box about its middle, if it lies along the road.
  const double half = 0.5 * source.number_or(element, "length", 0);
  const double heading = std::remainder(source.number_or(element, "hdg", 0), M_PI);
  if (!(half > 0) || std::abs(heading) > 0.1) return false;
  const GuardRail rail = rail_of(source, element, "height", "zOffset");
  keep(source, element, road, {.sweep = {station_m(s - half), station_m(s + half), t, 0, rail, {}}}, sweeps);
  return true;
}

}  // namespace roadgen
