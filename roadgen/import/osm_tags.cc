#include "roadgen/import/osm_tags.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "roadgen/import/text_file.h"

namespace roadgen {
namespace {

constexpr double kKerb_m = 0.12, kKerbWidth_m = 0.15, kSidewalk_m = 2, kParking_m = 2;
constexpr double kEdgeRoom_m = 0.25;  // of pavement outside an edge line
constexpr double kLeastLane_m = 2, kGreatestLane_m = 6, kGreatestCarriageway_m = 60;
constexpr int kMostLanes = 16, kMostLayers = 5;

// Numbers of lanes: OSM wiki, Key:lanes (assumptions) and Tag:highway=*. Widths: RAA 2008 (motorways), RAL 2012
// (rural roads EKL 1 to 4), RASt 06 (3.25 m with buses, 2.75 m and no lines on residential streets, 6.5 m and 5.5 m of
// carriageway). Corner radii: RASt 06, 6.3.6, for cars (4 to 6 m), lorries (8 to 10 m) and fast ramps. Grades: RAA and
// RAL, table of greatest longitudinal grades.
constexpr std::array<HighwayClass, 18> kClasses = {{
    {"motorway", 2, 2, 3.75, 2.5, true, true, true, 20, 0.04},
    {"motorway_link", 1, 1, 3.75, 1.5, true, true, true, 20, 0.06},
    {"trunk", 2, 1, 3.5, 1, true, true, false, 15, 0.045},
    {"trunk_link", 1, 1, 3.5, 1, true, true, true, 15, 0.06},
    {"primary", 2, 1, 3.5, kEdgeRoom_m, true, true, false, 10, 0.055},
    {"primary_link", 1, 1, 3.5, kEdgeRoom_m, true, true, true, 10, 0.06},
    {"secondary", 1, 1, 3.25, kEdgeRoom_m, true, true, false, 8, 0.06},
    {"secondary_link", 1, 1, 3.25, kEdgeRoom_m, true, true, true, 8, 0.06},
    {"tertiary", 1, 1, 3, kEdgeRoom_m, true, true, false, 7, 0.07},
    {"tertiary_link", 1, 1, 3, kEdgeRoom_m, true, true, true, 7, 0.07},
    {"unclassified", 1, 1, 2.75, 0, false, false, false, 6, 0.08},
    {"residential", 1, 1, 2.75, 0, false, false, false, 5, 0.08},
    {"living_street", 1, 0, 4, 0, false, false, false, 4, 0.08},
    {"service", 1, 0, 3.5, 0, false, false, false, 3, 0.08},
    {"track", 1, 0, 3, 0, false, false, false, 4, 0.08},
    {"road", 1, 1, 3, 0, false, false, false, 6, 0.06},
    {"busway", 1, 1, 3.25, 0, true, false, false, 10, 0.06},
    {"raceway", 2, 1, 5, kEdgeRoom_m, false, true, true, 15, 0.08},
}};

bool is_any(std::string_view value, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), value) != words.end();
}

// Reads a way's tags.
class Parser {
 public:
  explicit Parser(const TagLookup& lookup) : lookup_(lookup) {}
  ParsedTags run();

 private:
  std::string_view value(const char* key) const {
    const char* text = lookup_(key);
    return text ? std::string_view(text) : std::string_view();
  }
  std::optional<double> number(const char* key, double least, double greatest);
  std::optional<int> count(const char* key);
  Sides sides(std::initializer_list<const char*> keys) const;
  void read_lanes();
  void read_width();
  void read_levels();
  void read_surface();

  const TagLookup& lookup_;
  ParsedTags parsed_;
  bool oneway_ = false;
};

// A plain number, in metres where a unit follows, or in feet.
std::optional<double> Parser::number(const char* key, double least, double greatest) {
  std::string_view text = value(key);
  if (text.empty()) return std::nullopt;
  double unit = 1;
  const auto strip = [&](std::string_view suffix, double factor) {
    if (!text.ends_with(suffix)) return false;
    text.remove_suffix(suffix.size());
    while (text.ends_with(' ')) text.remove_suffix(1);
    unit = factor;
    return true;
  };
  (void)(strip("m", 1) || strip("'", 0.3048) || strip("ft", 0.3048));
  const std::optional<double> found = parse_number(text);
  if (found && *found * unit >= least && *found * unit <= greatest) return *found * unit;
  parsed_.faults.push_back(std::string(key) + "=" + std::string(value(key).substr(0, 40)) + " makes no sense");
  return std::nullopt;
}

std::optional<int> Parser::count(const char* key) {
  const std::optional<double> n = number(key, 0, kMostLanes);
  return n ? std::optional<int>(static_cast<int>(std::floor(*n))) : std::nullopt;
}

Sides Parser::sides(std::initializer_list<const char*> keys) const {
  Sides found;
  const auto absent = [](std::string_view v) { return v.empty() || is_any(v, {"no", "none", "separate", "unknown"}); };
  for (const char* key : keys) {
    const std::string_view plain = value(key);
    const std::string prefix = std::string(key) + ":";
    const bool both = is_any(plain, {"both", "yes"}) || !absent(value((prefix + "both").c_str()));
    found.left |= both || plain == "left" || !absent(value((prefix + "left").c_str()));
    found.right |= both || plain == "right" || !absent(value((prefix + "right").c_str()));
  }
  return found;
}

void Parser::read_lanes() {
  WayTags& tags = parsed_.tags;
  const HighwayClass& by_class = highway_class(tags.highway);
  const std::optional<int> all = count("lanes"), forward = count("lanes:forward"), backward = count("lanes:backward");
  if (oneway_) {
    tags.forward = static_cast<std::uint8_t>(
        std::max(1, all.value_or(forward.value_or(tags.roundabout ? 1 : by_class.lanes_oneway))));
    tags.backward = 0;
    return;
  }
  int f = by_class.lanes_each_way, b = by_class.lanes_each_way;
  if (forward || backward) {
    // Of three numbers two give the third.
    f = forward.value_or(std::max(all.value_or(2 * *backward) - backward.value_or(0), 0));
    b = backward.value_or(std::max(all.value_or(2 * f) - f, 0));
  } else if (all) {
    f = *all == 1 ? 0 : (*all + 1) / 2;
    b = *all == 1 ? 0 : *all / 2;
  }
  tags.forward = static_cast<std::uint8_t>(f);
  tags.backward = static_cast<std::uint8_t>(b);
}

void Parser::read_width() {
  WayTags& tags = parsed_.tags;
  tags.lane_m = static_cast<float>(highway_class(tags.highway).lane_m);
  const int lanes = std::max(1, tags.forward + tags.backward);
  if (const auto width = number("width", 0.5, kGreatestCarriageway_m)) {
    const double parking = kParking_m * (tags.parking.left + tags.parking.right);
    tags.lane_m = static_cast<float>(std::clamp((*width - parking) / lanes, kLeastLane_m, kGreatestLane_m));
  }
}

void Parser::read_levels() {
  WayTags& tags = parsed_.tags;
  const auto is_set = [&](const char* key) { return !value(key).empty() && value(key) != "no"; };
  tags.bridge = is_set("bridge");
  tags.tunnel = is_set("tunnel") && !is_any(value("tunnel"), {"building_passage", "avalanche_protector"});
  const std::optional<double> layer = number("layer", -99, 99);
  const double level = layer.value_or(tags.bridge ? 1 : tags.tunnel ? -1 : 0);
  tags.layer = static_cast<std::int8_t>(std::clamp<double>(level, -kMostLayers, kMostLayers));
}

void Parser::read_surface() {
  const std::string_view v = value("surface");
  Material& m = parsed_.tags.material;
  if (v.empty()) m = parsed_.tags.highway == Highway::kTrack ? Material::kGravel : Material::kAsphalt;
  if (v.starts_with("concrete")) m = Material::kConcrete;
  if (v.starts_with("paving_stones") || is_any(v, {"sett", "cobblestone", "unhewn_cobblestone", "bricks", "brick"})) {
    m = Material::kPaving;
  }
  if (is_any(v, {"gravel", "fine_gravel", "pebblestone", "compacted", "unpaved", "dirt", "earth", "ground", "sand",
                 "mud", "rock"})) {
    m = Material::kGravel;
  }
  if (is_any(v, {"grass", "grass_paver"})) m = Material::kGrass;
}

ParsedTags Parser::run() {
  const std::string_view kind = value("highway");
  const auto row = std::find_if(kClasses.begin(), kClasses.end(), [&](const auto& c) { return kind == c.name; });
  if (kind.empty() || row == kClasses.end() || value("area") == "yes") return parsed_;
  parsed_.drivable = true;
  WayTags& tags = parsed_.tags;
  tags.highway = static_cast<Highway>(row - kClasses.begin());
  tags.roundabout = is_any(value("junction"), {"roundabout", "circular"});
  const std::string_view oneway = value("oneway");
  parsed_.reversed = is_any(oneway, {"-1", "reverse"});
  oneway_ = parsed_.reversed || is_any(oneway, {"yes", "true", "1", "reversible", "alternating"}) ||
            (oneway.empty() && (row->oneway || tags.roundabout));
  tags.sidewalk = sides({"sidewalk"});
  tags.parking = sides({"parking", "parking:lane"});
  read_lanes();
  read_width();
  read_levels();
  read_surface();
  if (parsed_.reversed) {
    std::swap(tags.sidewalk.left, tags.sidewalk.right);
    std::swap(tags.parking.left, tags.parking.right);
  }
  return std::move(parsed_);
}

// One side of the section, from lane 0 outward.
struct SidePlan {
  int lanes = 0;
  double shoulder_m = 0;
  bool sidewalk = false, parking = false;
};

struct SectionPlan {
  SidePlan left, right;
  bool shared = false;  // the one lane of both directions, on the right side
};

SectionPlan plan(const WayTags& tags, bool along, bool keep_left) {
  const HighwayClass& by_class = highway_class(tags.highway);
  SectionPlan p;
  p.shared = tags.forward + tags.backward == 0;
  // Seen along the road.
  const int ahead = p.shared ? 1 : along ? tags.forward : tags.backward;
  const int oncoming = p.shared ? 0 : along ? tags.backward : tags.forward;
  const bool both = ahead > 0 && oncoming > 0;
  const auto side = [&](int lanes, bool outer, bool on_left) {
    const bool left_of_way = on_left == along;
    SidePlan s;
    s.lanes = lanes;
    s.shoulder_m = outer || both || p.shared ? by_class.shoulder_m : std::min(by_class.shoulder_m, kInnerShoulder_m);
    s.sidewalk = left_of_way ? tags.sidewalk.left : tags.sidewalk.right;
    s.parking = left_of_way ? tags.parking.left : tags.parking.right;
    if (s.parking) s.shoulder_m = 0;
    return s;
  };
  // Slow traffic keeps to the outer side of its direction.
  p.left = side(keep_left ? ahead : oncoming, (keep_left ? ahead : oncoming) > 0, true);
  p.right = side(keep_left ? oncoming : ahead, (keep_left ? oncoming : ahead) > 0, false);
  return p;
}

std::vector<Lane> lanes_of(const SidePlan& plan, const WayTags& tags, bool shared) {
  const HighwayClass& by_class = highway_class(tags.highway);
  const bool paved = tags.material == Material::kAsphalt || tags.material == Material::kConcrete;
  const Mark edge{.kind = by_class.edge_lines && paved ? MarkKind::kSolid : MarkKind::kNone};
  std::vector<Lane> side;
  side.reserve(static_cast<std::size_t>(plan.lanes) + (plan.shoulder_m > 0) + plan.parking + 2 * plan.sidewalk);
  for (int i = 0; i < plan.lanes; ++i) {
    Lane lane{.type = shared ? LaneType::kBidirectional : LaneType::kDriving,
              .material = tags.material,
              .width_m = {tags.lane_m},
              .mark = edge};
    if (i + 1 < plan.lanes) lane.mark = {.kind = paved ? MarkKind::kBroken : MarkKind::kNone};
    side.push_back(lane);
  }
  if (plan.shoulder_m > 0) {
    side.push_back({.type = LaneType::kShoulder, .material = tags.material, .width_m = {plan.shoulder_m}, .mark = {}});
  }
  if (plan.parking) {
    side.push_back({.type = LaneType::kParking, .material = tags.material, .width_m = {kParking_m}, .mark = {}});
  }
  if (plan.sidewalk) {
    for (const auto& [type, width] : {std::pair(LaneType::kCurb, kKerbWidth_m), {LaneType::kSidewalk, kSidewalk_m}}) {
      side.push_back({.type = type,
                      .material = default_material(type),
                      .width_m = {width},
                      .inner_height_m = kKerb_m,
                      .outer_height_m = kKerb_m,
                      .mark = {}});
    }
  }
  return side;
}

double carriageway_m(const SidePlan& s, double lane_m) {
  return s.lanes * lane_m + s.shoulder_m + (s.parking ? kParking_m : 0);
}
double beside_m(const SidePlan& s) { return s.sidewalk ? kKerbWidth_m + kSidewalk_m : 0; }
// t of lane 0.
double center_m(const SectionPlan& p, double lane_m) { return 0.5 * (p.right.lanes - p.left.lanes) * lane_m; }

}  // namespace

const HighwayClass& highway_class(Highway highway) { return kClasses[static_cast<std::size_t>(highway)]; }

ParsedTags parse_tags(const TagLookup& lookup) { return Parser(lookup).run(); }

LaneSection section_of_way(const WayTags& tags, bool along, bool keep_left) {
  const SectionPlan p = plan(tags, along, keep_left);
  const HighwayClass& by_class = highway_class(tags.highway);
  const bool paved = tags.material == Material::kAsphalt || tags.material == Material::kConcrete;
  LaneSection section;
  section.offset_m = {center_m(p, tags.lane_m)};
  section.left = lanes_of(p.left, tags, p.shared);
  section.right = lanes_of(p.right, tags, p.shared);
  if (p.left.lanes > 0 && p.right.lanes > 0) {
    const int most = std::max(p.left.lanes, p.right.lanes);
    if (paved && most >= 2) section.center_mark.kind = MarkKind::kSolidSolid;
    if (paved && most == 1 && by_class.center_line) section.center_mark.kind = MarkKind::kBroken;
  } else if (paved && by_class.edge_lines) {
    section.center_mark.kind = MarkKind::kSolid;
  }
  return section;
}

SectionEdges edges_of_way(const WayTags& tags, bool along, bool keep_left) {
  const SectionPlan p = plan(tags, along, keep_left);
  const double center = center_m(p, tags.lane_m);
  SectionEdges e;
  e.left_m = center + carriageway_m(p.left, tags.lane_m);
  e.right_m = center - carriageway_m(p.right, tags.lane_m);
  e.half_m = std::max(e.left_m + beside_m(p.left), beside_m(p.right) - e.right_m);
  return e;
}

}  // namespace roadgen
