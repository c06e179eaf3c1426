#include "roadgen/import/xodr_lanes.h"

#include <array>
#include <cstring>
#include <limits>
#include <pugixml.hpp>

#include "roadgen/import/xodr_records.h"

namespace roadgen {
namespace {

enum class Side { kRight = -1, kCenter = 0, kLeft = 1 };

struct KindName {
  std::string_view name;
  MarkKind kind;
};
// Of two lines the first is the right one.
constexpr KindName kKinds[] = {
    {"none", MarkKind::kNone},
    {"solid", MarkKind::kSolid},
    {"broken", MarkKind::kBroken},
    {"solid solid", MarkKind::kSolidSolid},
    {"solid broken", MarkKind::kSolidBroken},
    {"broken solid", MarkKind::kBrokenSolid},
    {"broken broken", MarkKind::kBrokenBroken},
};

bool is_double(MarkKind kind) { return kind >= MarkKind::kSolidSolid; }
bool has_dashes(MarkKind kind) { return kind == MarkKind::kBroken || kind >= MarkKind::kSolidBroken; }

MarkKind mirrored(MarkKind kind) {
  if (kind == MarkKind::kSolidBroken) return MarkKind::kBrokenSolid;
  return kind == MarkKind::kBrokenSolid ? MarkKind::kSolidBroken : kind;
}

PaintColor mark_color(XodrSource& source, const pugi::xml_node& node) {
  constexpr std::array<std::string_view, 6> kColors = {"white", "yellow", "blue", "green", "red", "orange"};
  const std::string color = node.attribute("color").as_string("standard");
  const auto at = std::find(kColors.begin(), kColors.end(), color);
  if (at != kColors.end()) return static_cast<PaintColor>(at - kColors.begin());
  if (color != "standard") source.note(node, "the mark colour \"" + color + "\" is read as white");
  return PaintColor::kWhite;
}

double not_negative(XodrSource& source, const pugi::xml_node& node, const char* name, double fallback) {
  const double x = source.number_or(node, name, fallback);
  if (x >= 0) return x;
  source.fail(ErrorCode::kParse, node,
              std::string("<") + node.name() + "> has " + name + "=\"" + node.attribute(name).value() +
                  "\"; it must not be negative");
  return fallback;
}

struct Line {
  double t_m, width_m, length_m, space_m, start_m;
};

std::vector<Line> read_lines(XodrSource& source, const pugi::xml_node& type, double width_m) {
  std::vector<Line> lines;
  for (const pugi::xml_node line : type.children("line")) {
    lines.push_back({source.number_or(line, "tOffset", 0), not_negative(source, line, "width", width_m),
                     not_negative(source, line, "length", 0), not_negative(source, line, "space", 0),
                     source.number_or(line, "sOffset", 0)});
  }
  std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.t_m < b.t_m; });
  return lines;
}

MarkKind kind_of_lines(const std::vector<Line>& lines) {
  const auto broken = [&](std::size_t i) { return lines[i].space_m > 0; };
  if (lines.empty()) return MarkKind::kNone;
  if (lines.size() == 1) return broken(0) ? MarkKind::kBroken : MarkKind::kSolid;
  if (broken(0)) return broken(1) ? MarkKind::kBrokenBroken : MarkKind::kBrokenSolid;
  return broken(1) ? MarkKind::kSolidBroken : MarkKind::kSolidSolid;
}

MarkKind mark_kind(XodrSource& source, const pugi::xml_node& node, Side side, const std::vector<Line>& lines) {
  const std::string type = source.word(node, "type");
  const auto* at =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const KindName& k) { return k.name == type; });
  // "inside/outside, exception: center lane - from left to right" (e_roadMarkType): inside is right on left lanes only.
  if (at != std::end(kKinds)) return side == Side::kLeft ? at->kind : mirrored(at->kind);
  const MarkKind kind = kind_of_lines(lines);
  if (kind == MarkKind::kNone && !source.failed())
    source.note(node, "road marks of type \"" + type + "\" are not kept");
  return kind;
}

// gone_m of the dash pattern, less whole periods.
double dash_phase_m(const Mark& mark, double gone_m) {
  const double period = mark.on_m + mark.off_m;
  const double phase = std::fmod(gone_m, period);
  return phase < 0 ? phase + period : phase;
}

// Our own files carry the numbers unrounded, and those that the standard has no place for.
void take_exact_mark(XodrSource& source, const pugi::xml_node& node, Mark& mark) {
  const std::string text = user_data(node, "roadgen:mark");
  if (text.empty()) return;
  const std::vector<double> exact = numbers_in(text);
  const auto differs = [](double a, double b) { return std::abs(a - b) > kSamePlace_m; };
  if (exact.size() != 5 || exact[0] < 0 || exact[1] < 0 || !(exact[2] > 0) || exact[3] < 0 || !(exact[4] >= 0) ||
      (mark.kind != MarkKind::kNone && differs(exact[0], mark.width_m)) ||
      (is_double(mark.kind) && differs(exact[1], mark.space_m)) ||
      (has_dashes(mark.kind) && (differs(exact[2], mark.on_m) || differs(exact[3], mark.off_m) ||
                                 differs(std::remainder(exact[4] - mark.phase_m, exact[2] + exact[3]), 0)))) {
    return source.note(node, "userData roadgen:mark does not agree with the road mark, which is used");
  }
  mark.width_m = exact[0], mark.space_m = exact[1], mark.on_m = exact[2], mark.off_m = exact[3],
  mark.phase_m = exact[4];
}

// Source: clause 11.8. Widths of German practice where the file gives none: 0.12 m, bold 0.25 m.
Mark read_mark(XodrSource& source, const pugi::xml_node& node, Side side) {
  Mark mark;
  mark.color = mark_color(source, node);
  const bool bold = !std::strcmp(node.attribute("weight").value(), "bold");
  mark.width_m = not_negative(source, node, "width", bold ? 0.25 : mark.width_m);
  const std::vector<Line> lines = read_lines(source, node.child("type"), mark.width_m);
  mark.kind = mark_kind(source, node, side, lines);
  if (node.child("sway") || node.child("explicit"))
    source.note(node, "<sway> and <explicit> of road marks are not kept");
  if (is_double(mark.kind)) mark.space_m = mark.width_m;
  if (mark.kind != MarkKind::kNone && !lines.empty() && lines.size() == (is_double(mark.kind) ? 2 : 1)) {
    mark.width_m = lines.front().width_m;
    if (is_double(mark.kind)) {
      mark.space_m = std::max(lines[1].t_m - lines[0].t_m - 0.5 * (lines[0].width_m + lines[1].width_m), 0.0);
    }
    const Line& dashed = mark.kind == MarkKind::kSolidBroken ? lines.back() : lines.front();
    if (has_dashes(mark.kind) && dashed.length_m > 0) {
      mark.on_m = dashed.length_m, mark.off_m = dashed.space_m;
      mark.phase_m = dash_phase_m(mark, -dashed.start_m);
    }
  } else if (!lines.empty() && mark.kind != MarkKind::kNone) {
    source.note(node, "the <line> elements of a road mark do not fit its type, which is used");
  }
  take_exact_mark(source, node, mark);
  return mark;
}

std::vector<From<Mark>> read_marks(XodrSource& source, const pugi::xml_node& lane, Side side, double base_m) {
  std::vector<From<Mark>> marks;
  for (const pugi::xml_node node : lane.children("roadMark")) {
    marks.push_back({base_m + source.number(node, "sOffset"), read_mark(source, node, side), source.line(node)});
  }
  expect_order(source, marks, "<roadMark>");
  return marks;
}

// The surface words that files use, by what they contain.
std::optional<Material> material_named(std::string_view surface) {
  struct Word {
    std::string_view part;
    Material material;
  };
  constexpr Word kWords[] = {{"asphalt", Material::kAsphalt}, {"concrete", Material::kConcrete},
                             {"pav", Material::kPaving},      {"cobble", Material::kPaving},
                             {"grass", Material::kGrass},     {"gravel", Material::kGravel},
                             {"curb", Material::kCurbstone}};
  std::string lower(surface);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const Word& word : kWords) {
    if (lower.find(word.part) != lower.npos) return word.material;
  }
  return {};
}

std::vector<From<Material>> read_materials(XodrSource& source, const pugi::xml_node& lane, LaneType type,
                                           double base_m) {
  std::vector<From<Material>> materials;
  for (const pugi::xml_node node : lane.children("material")) {
    const std::string surface = node.attribute("surface").value();
    const std::optional<Material> material = material_named(surface);
    if (!material) source.note(node, "the lane material \"" + surface + "\" is not known");
    materials.push_back(
        {base_m + source.number(node, "sOffset"), material.value_or(default_material(type)), source.line(node)});
  }
  expect_order(source, materials, "<material>");
  return materials;
}

std::vector<From<LaneHeights>> read_heights(XodrSource& source, const pugi::xml_node& lane, double base_m) {
  std::vector<From<LaneHeights>> heights;
  for (const pugi::xml_node node : lane.children("height")) {
    const LaneHeights h{source.number_or(node, "inner", 0), source.number_or(node, "outer", 0)};
    if (!node.attribute("inner") || !node.attribute("outer")) {
      source.note(node, "a lane <height> without inner or outer height counts as 0 there");
    }
    if (std::abs(h.inner_m) > kGreatestProfile || std::abs(h.outer_m) > kGreatestProfile) {
      source.fail(ErrorCode::kData, node, "the height of a lane is beyond 1e6 m");
    }
    heights.push_back({base_m + source.number(node, "sOffset"), h, source.line(node)});
  }
  expect_order(source, heights, "<height>");
  return heights;
}

std::vector<From<SpeedLimit>> read_speeds(XodrSource& source, const pugi::xml_node& lane, double base_m) {
  std::vector<From<SpeedLimit>> speeds;
  for (const pugi::xml_node node : lane.children("speed")) {
    speeds.push_back({base_m + source.number(node, "sOffset"), read_speed(source, node), source.line(node)});
  }
  expect_order(source, speeds, "<speed>");
  return speeds;
}

// Those that begin at one place hold together, until others begin.
std::vector<From<std::string>> read_texts(XodrSource& source, const pugi::xml_node& lane, const char* name,
                                          double base_m) {
  std::vector<From<std::string>> texts;
  pugi::xml_document copy;
  for (const pugi::xml_node node : lane.children(name)) {
    const double s_m = base_m + source.number(node, "sOffset");
    copy.reset();
    pugi::xml_node from_here = copy.append_copy(node);
    from_here.attribute("sOffset").set_value("0");
    if (texts.empty() || texts.back().s_m != s_m) texts.push_back({s_m, {}, source.line(node)});
    texts.back().value += element_xml(from_here);
  }
  expect_order(source, texts, "<" + std::string(name) + ">");
  return texts;
}

void note_unkept(XodrSource& source, const pugi::xml_node& lane) {
  note_others(source, lane, "lanes",
              {"width", "border", "roadMark", "height", "material", "speed", "access", "rule", "link", "userData"});
  const std::string level = lane.attribute("level").value();
  if (level == "true" || level == "1") source.note(lane, "lanes that stay level (level=\"true\") tilt with the road");
}

XodrLane read_lane(XodrSource& source, const pugi::xml_node& node, Side side, double base_m) {
  XodrLane lane;
  const double id = source.number(node, "id");
  if (id != std::round(id) || std::abs(id) > 1e6) source.fail(ErrorCode::kParse, node, "the lane id is not an integer");
  lane.id = source.failed() ? 0 : static_cast<int>(id);
  lane.line = source.line(node);
  const std::string type = source.word(node, "type");
  lane.type = lane_type(type);
  if (lane.type == LaneType::kNone && type != "none" && !type.empty()) {
    source.note(node, "the lane type \"" + type + "\" is read as none");
  }
  lane.widths = read_profile(source, node, "width", "sOffset", base_m);
  lane.borders = read_profile(source, node, "border", "sOffset", base_m);
  lane.marks = read_marks(source, node, side, base_m);
  lane.heights = read_heights(source, node, base_m);
  lane.materials = read_materials(source, node, lane.type, base_m);
  lane.speeds = read_speeds(source, node, base_m);
  lane.accesses = read_texts(source, node, "access", base_m);
  lane.rules = read_texts(source, node, "rule", base_m);
  const Profile& edge = lane.widths.empty() ? lane.borders : lane.widths;
  if (edge.empty() || edge.front().s_m > base_m + kSamePlace_m) {
    source.note(node, "a lane has no <width> at its start, where it counts as 0");
  }
  note_unkept(source, node);
  return lane;
}

std::vector<XodrLane> read_side(XodrSource& source, const pugi::xml_node& section, const char* name, Side side,
                                double base_m) {
  std::vector<XodrLane> lanes;
  for (const pugi::xml_node node : section.child(name).children("lane")) {
    lanes.push_back(read_lane(source, node, side, base_m));
    if (source.failed()) return lanes;
  }
  const auto nearer = [](const XodrLane& a, const XodrLane& b) { return std::abs(a.id) < std::abs(b.id); };
  std::stable_sort(lanes.begin(), lanes.end(), nearer);
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const int expected = static_cast<int>(side) * (static_cast<int>(i) + 1);
    if (lanes[i].id == expected) continue;
    source.fail(ErrorCode::kParse, lanes[i].line,
                "the lane ids on the " + std::string(name) + " are not " + (side == Side::kLeft ? "1, 2" : "-1, -2") +
                    ", ...: " + std::to_string(expected) + " is missing or " + std::to_string(lanes[i].id) +
                    " stands twice");
    break;
  }
  return lanes;
}

XodrLaneSection read_section(XodrSource& source, const pugi::xml_node& node) {
  XodrLaneSection section;
  section.s_m = source.number(node, "s");
  section.line = source.line(node);
  const std::string single = node.attribute("singleSide").value();
  section.single_side = single == "true" || single == "1";
  section.left = read_side(source, node, "left", Side::kLeft, section.s_m);
  section.right = read_side(source, node, "right", Side::kRight, section.s_m);
  const pugi::xml_node center = node.child("center").child("lane");
  section.center_marks = read_marks(source, center, Side::kCenter, section.s_m);
  if (center.child("height")) source.note(center, "<height> of the centre lane is not kept");
  return section;
}

// The section that speaks of a side from station s_m on.
const XodrLaneSection* section_of(const XodrLanes& lanes, double s_m, const Stations& stations,
                                  std::vector<XodrLane> XodrLaneSection::*side) {
  const XodrLaneSection* found = nullptr;
  for (const XodrLaneSection& section : lanes.sections) {
    if (stations.snapped(section.s_m) > s_m) break;
    if (!section.single_side || side == nullptr || !(section.*side).empty()) found = &section;
  }
  return found;
}

// The mark that holds at a station, its dashes going on from where it began.
Mark mark_at(const std::vector<From<Mark>>& marks, double s_m, const Stations& stations) {
  const From<Mark>* from = holding(marks, s_m, stations);
  if (!from) return {};
  Mark mark = from->value;
  const double gone_m = s_m - stations.snapped(from->s_m);
  if (has_dashes(mark.kind) && gone_m > 0) mark.phase_m = dash_phase_m(mark, mark.phase_m + gone_m);
  return mark;
}

// The lanes of one side at a station; border is the t of lane 0 there.
std::vector<Lane> lanes_at(XodrSource& source, const std::vector<XodrLane>& lanes, double sign, Cubic border,
                           double s_m, double length_m, const Stations& stations) {
  std::vector<Lane> result;
  for (const XodrLane& from : lanes) {
    Lane lane;
    lane.type = from.type;
    lane.material = default_material(from.type);
    if (const auto* material = holding(from.materials, s_m, stations)) lane.material = material->value;
    lane.mark = mark_at(from.marks, s_m, stations);
    if (const auto* heights = holding(from.heights, s_m, stations)) {
      lane.inner_height_m = heights->value.inner_m;
      lane.outer_height_m = heights->value.outer_m;
    }
    if (!from.widths.empty() || from.borders.empty()) {
      lane.width_m = cubic_from(from.widths, s_m, stations);
      border = sign > 0 ? border + lane.width_m : border - lane.width_m;
    } else {
      const Cubic outer = cubic_from(from.borders, s_m, stations);
      lane.width_m = sign > 0 ? outer - border : border - outer;
      border = outer;
    }
    const Cubic::Range range = border.range(length_m);
    if (!(range.low >= -kGreatestProfile && range.high <= kGreatestProfile)) {
      source.fail(ErrorCode::kData, from.line, "the width is beyond 1e6 m");
    }
    result.push_back(lane);
  }
  return result;
}

// What else holds for the lanes of one side, by ids that fall.
void add_records(std::vector<LaneRecord>& records, std::size_t section, const std::vector<XodrLane>& lanes, double s_m,
                 const Stations& stations) {
  std::vector<LaneRecord> found;
  for (const XodrLane& lane : lanes) {
    LaneRecord record{.section = static_cast<std::uint32_t>(section), .lane = lane.id};
    if (const auto* speed = holding(lane.speeds, s_m, stations)) record.speed = speed->value;
    if (const auto* access = holding(lane.accesses, s_m, stations)) record.access_xml = access->value;
    if (const auto* rule = holding(lane.rules, s_m, stations)) record.rule_xml = rule->value;
    const LaneRecord none{.section = record.section, .lane = record.lane};
    if (record != none) found.push_back(std::move(record));
  }
  std::sort(found.begin(), found.end(), [](const LaneRecord& a, const LaneRecord& b) { return a.lane > b.lane; });
  for (LaneRecord& record : found) records.push_back(std::move(record));
}

}  // namespace

std::vector<double> XodrLanes::changes_m() const {
  std::vector<double> changes;
  for (const From<Cubic>& record : offsets) changes.push_back(record.s_m);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    const XodrLaneSection& section = sections[i];
    changes.push_back(section.s_m);
    const double end_m = i + 1 < sections.size() ? sections[i + 1].s_m : std::numeric_limits<double>::infinity();
    const auto add = [&](const auto& records) {
      for (const auto& record : records) {
        if (record.s_m > section.s_m && record.s_m < end_m) changes.push_back(record.s_m);
      }
    };
    add(section.center_marks);
    for (const auto* side : {&section.left, &section.right}) {
      for (const XodrLane& lane : *side) {
        add(lane.widths), add(lane.borders), add(lane.marks), add(lane.heights), add(lane.materials);
        add(lane.speeds), add(lane.accesses), add(lane.rules);
      }
    }
  }
  return changes;
}

XodrLanes read_lanes(XodrSource& source, const pugi::xml_node& road) {
  XodrLanes lanes;
  const pugi::xml_node node = road.child("lanes");
  if (!node.child("laneSection")) {
    source.fail(ErrorCode::kParse, node ? node : road, "the road has no <laneSection>");
    return lanes;
  }
  lanes.offsets = read_profile(source, node, "laneOffset", "s");
  for (const pugi::xml_node section : node.children("laneSection")) {
    lanes.sections.push_back(read_section(source, section));
    if (source.failed()) return lanes;
    if (lanes.sections.size() > 1 && lanes.sections.back().s_m < lanes.sections[lanes.sections.size() - 2].s_m) {
      source.fail(ErrorCode::kParse, section, "<laneSection> records are not in order");
    }
  }
  return lanes;
}

LaneSections lane_sections(XodrSource& source, const XodrLanes& lanes, const Stations& stations, double start_m) {
  std::vector<double> starts{start_m};
  for (const double s : lanes.changes_m()) {
    const double snapped = stations.snapped(s);
    if (snapped > start_m && snapped < stations.end_m() - kLeastPiece_m) starts.push_back(snapped);
  }
  std::sort(starts.begin(), starts.end());
  starts.erase(std::unique(starts.begin(), starts.end()), starts.end());

  LaneSections found;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const double s = starts[i], length = (i + 1 < starts.size() ? starts[i + 1] : stations.end_m()) - s;
    const XodrLaneSection* whole = section_of(lanes, s, stations, nullptr);
    const XodrLaneSection* left = section_of(lanes, s, stations, &XodrLaneSection::left);
    const XodrLaneSection* right = section_of(lanes, s, stations, &XodrLaneSection::right);
    if (!whole) {
      source.fail(ErrorCode::kParse, lanes.sections.front().line, "no <laneSection> starts at s = 0");
      return {};
    }
    LaneSection section;
    section.s_m = s;
    section.offset_m = cubic_from(lanes.offsets, s, stations);
    const Cubic::Range offset = section.offset_m.range(length);
    if (!(offset.low >= -kGreatestProfile && offset.high <= kGreatestProfile)) {
      source.fail(ErrorCode::kData, holding(lanes.offsets, s, stations)->line, "the lane offset is beyond 1e6 m");
    }
    section.center_mark = mark_at(whole->center_marks, s, stations);
    if (left) section.left = lanes_at(source, left->left, 1, section.offset_m, s, length, stations);
    if (right) section.right = lanes_at(source, right->right, -1, section.offset_m, s, length, stations);
    if (source.failed()) return {};
    for (const auto& [from, side] : {std::pair(left, &XodrLaneSection::left), {right, &XodrLaneSection::right}}) {
      if (from) add_records(found.records, i, from->*side, s, stations);
    }
    found.sections.push_back(std::move(section));
  }
  return found;
}

}  // namespace roadgen
