#include "roadgen/import/xodr_objects.h"

#include <numbers>
#include <pugixml.hpp>

#include <glm/common.hpp>

#include "roadgen/import/xodr_records.h"
#include "roadgen/import/xodr_sweeps.h"

namespace roadgen {
namespace {

constexpr double kSkew_rad = 0.1;
// Of a stop line, along the road (StVO sign 294).
constexpr double kStopLine_m = 0.5;

std::string lower(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

bool has(const std::string& text, std::string_view part) { return text.find(part) != text.npos; }

std::optional<PaintKind> arrow_kind(const std::string& word) {
  const bool left = has(word, "left"), right = has(word, "right"), straight = has(word, "straight");
  if ((left && right) || has(word, "merge") || has(word, "turn around")) return {};
  if (left) return straight ? PaintKind::kArrowStraightLeft : PaintKind::kArrowLeft;
  if (right) return straight ? PaintKind::kArrowStraightRight : PaintKind::kArrowRight;
  return PaintKind::kArrow;
}

std::optional<PaintKind> paint_kind(const pugi::xml_node& object) {
  const std::string type = lower(object.attribute("type").value()), name = lower(object.attribute("name").value());
  const std::string subtype = lower(object.attribute("subtype").value());
  if (type == "crosswalk" || has(name, "crosswalk") || has(name, "zebra")) return PaintKind::kZebra;
  if (subtype == "signallines" || has(name, "stopline") || has(name, "stop line") || has(name, "stop_line")) {
    return PaintKind::kLine;
  }
  if (subtype.starts_with("arrow")) return arrow_kind(subtype);
  if (has(name, "arrow")) return arrow_kind(name);
  return {};
}

// The box around an object's outline, in its own axes from its own place.
struct Box {
  glm::dvec2 low{1e300}, high{-1e300};
};

Box outline_box(XodrSource& source, const pugi::xml_node& object, glm::dvec2 place, glm::dvec2 ahead) {
  Box box;
  const auto add = [&](const pugi::xml_node& outline) {
    for (const pugi::xml_node corner : outline.children()) {
      glm::dvec2 p;
      if (corner.name() == std::string_view("cornerLocal")) {
        p = {source.number(corner, "u"), source.number(corner, "v")};
      } else if (corner.name() == std::string_view("cornerRoad")) {
        const glm::dvec2 d = glm::dvec2(source.number(corner, "s"), source.number(corner, "t")) - place;
        p = {ahead.x * d.x + ahead.y * d.y, ahead.x * d.y - ahead.y * d.x};
      } else {
        continue;
      }
      box.low = glm::min(box.low, p);
      box.high = glm::max(box.high, p);
    }
  };
  add(object.child("outline"));
  add(object.child("outlines").child("outline"));
  return box;
}

// Our own files carry what the standard has no place for: the colour and the zebra's stripe.
void take_exact_paint(XodrSource& source, const pugi::xml_node& object, Paint& paint) {
  const std::string text = user_data(object, "roadgen:paint");
  if (text.empty()) return;
  const std::vector<double> x = numbers_in(text);
  if (x.size() != 2 || x[0] != std::round(x[0]) || x[0] < 0 || x[0] > static_cast<int>(PaintColor::kOrange)) {
    return source.note(object, "userData roadgen:paint is not a colour's number and a stripe's width");
  }
  paint.color = static_cast<PaintColor>(static_cast<int>(x[0]));
  paint.stripe_m = x[1];
}

std::optional<Paint> object_paint(XodrSource& source, const pugi::xml_node& object) {
  const std::optional<PaintKind> kind = paint_kind(object);
  if (!kind) return {};
  Paint paint;
  paint.kind = *kind;
  paint.s_m = source.number(object, "s");
  paint.t_m = source.number(object, "t");
  const double heading = source.number_or(object, "hdg", 0);
  const double quarter = std::round(heading / (0.5 * std::numbers::pi));
  if (std::abs(heading - quarter * 0.5 * std::numbers::pi) > kSkew_rad) return {};
  const int turns = static_cast<int>(quarter - 4 * std::floor(quarter / 4));
  constexpr glm::dvec2 kAhead[] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  const glm::dvec2 ahead = kAhead[turns];

  const Box box = outline_box(source, object, {paint.s_m, paint.t_m}, ahead);
  glm::dvec2 size;
  if (box.low.x <= box.high.x) {
    size = box.high - box.low;
    const glm::dvec2 middle = 0.5 * (box.low + box.high);
    paint.s_m += ahead.x * middle.x - ahead.y * middle.y;
    paint.t_m += ahead.y * middle.x + ahead.x * middle.y;
  } else {
    if (!object.attribute("length") || !object.attribute("width")) return {};
    size = {source.number(object, "length"), source.number(object, "width")};
  }
  paint.length_m = turns % 2 == 0 ? size.x : size.y;
  paint.width_m = turns % 2 == 0 ? size.y : size.x;
  const std::string_view orientation = object.attribute("orientation").value();
  paint.against = orientation == "-" || (orientation != "+" && turns == 2);
  take_exact_paint(source, object, paint);
  for (const double x : {paint.s_m, paint.t_m, paint.length_m, paint.width_m, paint.stripe_m}) {
    if (!(std::abs(x) <= kGreatestProfile)) source.fail(ErrorCode::kData, object, "the object is beyond 1e6 m");
  }
  return paint;
}

bool is_driven(LaneType type) {
  return type == LaneType::kDriving || type == LaneType::kBidirectional || type == LaneType::kBus ||
         type == LaneType::kTaxi || type == LaneType::kHov || type == LaneType::kEntry || type == LaneType::kExit;
}

// A stop line across the lanes that a signal is valid for, or all of its direction. Needs the road's own s.
std::optional<Paint> stop_line(XodrSource& source, const pugi::xml_node& signal, const Road& road, double s_m) {
  if (!(s_m >= 0 && s_m <= road.length_m())) return {};
  const std::string_view orientation = signal.attribute("orientation").value();
  double from = orientation == "-" ? 1 : -1e6, to = orientation == "+" ? -1 : 1e6;
  if (const pugi::xml_node validity = signal.child("validity")) {
    from = source.number(validity, "fromLane");
    to = source.number(validity, "toLane");
    if (from > to) std::swap(from, to);
  }
  const LaneSection& section = road.sections[road.segments[segment_at(road, s_m)].section];
  const std::vector<Cubic> borders = section.borders_m();
  const int rights = static_cast<int>(section.right.size());
  double low = 1e300, high = -1e300;
  for (int i = 0; i + 1 < static_cast<int>(borders.size()); ++i) {
    const int id = i < rights ? i - rights : i - rights + 1;
    const Lane& lane = id < 0 ? section.right[-id - 1] : section.left[id - 1];
    if (id < from || id > to || !is_driven(lane.type)) continue;
    low = std::min(low, borders[i].value(s_m - section.s_m));
    high = std::max(high, borders[i + 1].value(s_m - section.s_m));
  }
  if (!(low < high)) return {};
  return Paint{.s_m = s_m,
               .t_m = 0.5 * (low + high),
               .length_m = kStopLine_m,
               .width_m = high - low,
               .against = orientation == "-"};
}

}  // namespace

void read_objects(XodrSource& source, const pugi::xml_node& node, Road& road, const StationMap& station_m) {
  std::vector<XodrSweep> sweeps;
  RoadRecords records = *road.records;
  const pugi::xml_node objects = node.child("objects");
  // What read_sweeps leaves of tunnels has no length to be drawn along.
  for (const pugi::xml_node object : objects.children()) {
    if (object.type() != pugi::node_element || read_sweeps(source, object, road, station_m, sweeps)) continue;
    if (object.name() == std::string_view("bridge")) {
      if (auto bridge = read_bridge(source, object, road.length_m(), station_m)) road.bridges.push_back(*bridge);
    }
    if (object.name() != std::string_view("object")) continue;
    if (std::optional<Paint> paint = object_paint(source, object)) {
      if (object.child("repeat")) source.note(object, "<repeat> of paint is not kept");
      paint->s_m = station_m(paint->s_m);
      road.paint.push_back(*paint);
      continue;
    }
    if (paint_kind(object))
      source.note(object, "paint askew to its road or without a size is kept, but is not painted");
    if (auto record = read_object(source, object, station_m)) records.objects.push_back(std::move(*record));
  }
  records.other_objects_xml =
      other_xml(source, objects, "objects of roads", {"objectReference"}, {"object", "tunnel", "bridge", "userData"});
  std::stable_sort(sweeps.begin(), sweeps.end(),
                   [](const XodrSweep& a, const XodrSweep& b) { return a.order < b.order; });
  for (XodrSweep& found : sweeps) road.sweeps.push_back(std::move(found.sweep));

  const pugi::xml_node signals = node.child("signals");
  for (const pugi::xml_node signal : signals.children("signal")) {
    const bool is_stop_line = signal.attribute("type").value() == std::string_view("294");
    const double s_m = is_stop_line ? station_m(source.number(signal, "s")) : 0;
    auto record = read_signal(source, signal, station_m);
    if (is_stop_line && !(record && record->is_painted)) {
      const std::optional<Paint> paint = stop_line(source, signal, road, s_m);
      if (paint) road.paint.push_back(*paint);
      if (record) record->is_painted = paint.has_value();
    }
    if (record) records.signals.push_back(std::move(*record));
  }
  records.other_signals_xml = other_xml(source, signals, "signals of roads",
                                        {"signalReference", "staticBoard", "vmsBoard"}, {"signal", "userData"});
  records.other_xml = other_xml(
      source, node, "roads", {"surface", "railroad"},
      {"link", "type", "planView", "elevationProfile", "lateralProfile", "lanes", "objects", "signals", "userData"});
  records.types = read_types(source, node, station_m);
  if (records != *road.records) road.records.edit() = std::move(records);
}

}  // namespace roadgen
