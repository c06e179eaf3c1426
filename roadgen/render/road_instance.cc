#include "roadgen/render/road_instance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <tuple>

#include <glm/packing.hpp>

#include "roadgen/road/crossing.h"

namespace roadgen {
namespace {

constexpr std::size_t kLevels = 4;  // LEVELS of shaders/sections.glsl

// What a strip is, in one float; unpacked by shaders/sections.glsl.
float strip_code(const Lane& lane, std::size_t right_level, std::size_t left_level) {
  const bool driving = lane.type == LaneType::kDriving || lane.type == LaneType::kBidirectional ||
                       lane.type == LaneType::kBus || lane.type == LaneType::kTaxi || lane.type == LaneType::kHov;
  return static_cast<float>(static_cast<std::size_t>(lane.material) + 8 * right_level + 32 * left_level +
                            (driving ? 128 : 0));
}

float mark_code(const Mark& mark) {
  return static_cast<float>(static_cast<int>(mark.kind) + 8 * static_cast<int>(mark.color));
}

// The heights that a section's strips lie at, the road surface's first; the nearest held one where there are too many.
class Levels {
 public:
  std::size_t index(double height_m) {
    std::size_t best = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if (std::abs(heights_[i] - height_m) < std::abs(heights_[best] - height_m)) best = i;
    }
    if (std::abs(heights_[best] - height_m) < 1e-4 || count_ == kLevels) return best;
    heights_[count_] = height_m;
    return count_++;
  }
  std::size_t count() const { return count_; }
  const std::array<double, kLevels>& heights() const { return heights_; }

 private:
  std::array<double, kLevels> heights_{};
  std::size_t count_ = 1;
};

glm::vec4 row(const Cubic& c) { return glm::dvec4(c.c0, c.c1, c.c2, c.c3); }

Table section_rows(const LaneSection& section) {
  const std::vector<Cubic> borders = section.borders_m();
  Levels levels;
  Table rows(2);
  float reach = 0, grass = 0;
  for (std::size_t i = 0; i < borders.size(); ++i) {
    const std::size_t right = section.right.size();
    // The mark of a border belongs to the lane inside of it; the strip to the left of it is its own lane.
    const Mark& mark = i < right ? section.right[right - 1 - i].mark
                                 : (i == right ? section.center_mark : section.left[i - right - 1].mark);
    reach = std::max(reach, static_cast<float>(mark.width_m + std::max(mark.space_m, 0.0)));
    glm::vec4 strip(static_cast<float>(mark.off_m), 0, 0, static_cast<float>(mark.phase_m));
    if (i + 1 < borders.size()) {
      const bool is_right = i < right;
      const Lane& lane = is_right ? section.right[right - 1 - i] : section.left[i - right];
      if (lane.material == Material::kGrass) grass = 1;
      const std::size_t inner = levels.index(lane.inner_height_m), outer = levels.index(lane.outer_height_m);
      strip.y = strip_code(lane, is_right ? outer : inner, is_right ? inner : outer);
      strip.z = static_cast<float>(is_right ? static_cast<int>(i) - static_cast<int>(right)
                                            : static_cast<int>(i - right) + 1);
    }
    rows.push_back(row(borders[i]));
    rows.push_back(glm::dvec4(mark_code(mark), mark.width_m, mark.space_m, mark.on_m));
    rows.push_back(strip);
  }
  rows[0] = glm::vec4(static_cast<float>(borders.size()), static_cast<float>(levels.count()), reach, grass);
  const auto& h = levels.heights();
  rows[1] = glm::dvec4(h[0], h[1], h[2], h[3]);
  return rows;
}

// Sections that look the same are held once.
class SectionTable {
 public:
  explicit SectionTable(Table& data) : data_(data) {}
  std::uint32_t add(const LaneSection& section) {
    Table rows = section_rows(section);
    std::string key(reinterpret_cast<const char*>(rows.data()), rows.size() * sizeof rows[0]);
    const auto [at, is_new] = known_.try_emplace(std::move(key), static_cast<std::uint32_t>(data_.size()));
    if (is_new) data_.insert(data_.end(), rows.begin(), rows.end());
    return at->second;
  }

 private:
  Table& data_;
  std::map<std::string, std::uint32_t> known_;
};

// A dash pattern that all of a section's marks share, so that s may be reduced by it; 0 where there is none or where
// widths depend on s.
double common_period_m(const LaneSection& section) {
  double period = 0;
  const auto fits = [&](const Mark& mark) {
    const bool broken = mark.kind == MarkKind::kBroken || mark.kind >= MarkKind::kSolidBroken;
    if (!broken) return true;
    const double own = mark.on_m + mark.off_m;
    if (period == 0) period = own;
    return period == own;
  };
  bool all = section.offset_m.is_constant() && fits(section.center_mark);
  for (const auto* side : {&section.left, &section.right}) {
    for (const Lane& lane : *side) all = all && lane.width_m.is_constant() && fits(lane.mark);
  }
  if (!all) return 0;
  return period > 0 ? period : 1;
}

bool is_raised(const LaneSection& section) {
  const auto any = [](const std::vector<Lane>& lanes) {
    return std::any_of(lanes.begin(), lanes.end(),
                       [](const Lane& l) { return l.inner_height_m != 0 || l.outer_height_m != 0; });
  };
  return any(section.left) || any(section.right);
}

// A road's sections as they stand in the table.
struct PlacedSection {
  std::uint32_t offset = 0;
  double period_m = 0;
  bool raised = false;
  Cubic::Range heights{0, 0};
};

struct PlacedSegment {
  const Segment* segment;
  std::uint32_t road;
  const PlacedSection* section;
  glm::ivec3 tile;
  double z_m;
  bool planar;
  std::uint32_t flags;
};

glm::ivec3 tile_of(const Segment& s) {
  return glm::ivec3(glm::floor(glm::dvec3(s.start_m, s.elevation_m.c0) / kTileSize_m));
}

std::uint32_t halves(const Linear& fall, double length_m) {
  return glm::packHalf2x16(glm::vec2(static_cast<float>(fall.c0), static_cast<float>(fall.value(length_m))));
}

RoadInstance instance(const PlacedSegment& placed, const LaneSection& section, std::uint32_t tile,
                      glm::dvec3 origin_m) {
  const Segment& segment = *placed.segment;
  const Cubic &z = segment.elevation_m, &e = segment.superelevation_rad;
  RoadInstance r{};
  r.start = glm::dvec3(segment.start_m, z.c0) - origin_m;
  r.tile = tile;
  r.shape = glm::dvec4(segment.chord_m(), segment.slope_start, segment.slope_end);
  r.arc = glm::dvec4(segment.arc_m, segment.arc_c0, segment.arc_c1, segment.s_start_m);
  r.height = glm::dvec4(z.c1, z.c2, z.c3, segment.s_start_m - static_cast<double>(r.arc.w));
  r.superelevation = row(e);
  const Quad quad = fitted_quad(segment);
  const Cubic::Range range = planar_deviation_m(segment);
  r.box = glm::dvec4(quad.y_low, quad.y_high, range.low + placed.section->heights.low,
                     range.high + placed.section->heights.high);
  r.road = placed.road;
  r.section = placed.section->offset;
  r.flags = placed.flags;
  const double offset = segment.s_start_m - section.s_m, period = placed.section->period_m;
  r.section_s = static_cast<float>(period > 0 ? std::fmod(offset, period) : offset);
  r.crossfall_left = halves(segment.crossfall_left, segment.arc_m);
  r.crossfall_right = halves(segment.crossfall_right, segment.arc_m);
  return r;
}

// Appends the paint that touches the segment, placed from the segment's start, and returns where it is.
std::uint32_t add_paint(const Road& road, const Segment& segment, Table& table) {
  const std::size_t first = table.size() / 2;
  std::size_t count = 0;
  for (const Paint& p : road.paint) {
    const double s = p.s_m - segment.s_start_m;
    if (s + 0.5 * p.length_m < 0 || s - 0.5 * p.length_m > segment.arc_m || count == 255) continue;
    table.push_back(glm::dvec4(s, p.t_m, p.length_m, p.width_m));
    table.push_back(glm::dvec4(static_cast<int>(p.kind), static_cast<int>(p.color), p.stripe_m, p.against ? 1 : 0));
    ++count;
  }
  return count == 0 ? 0 : static_cast<std::uint32_t>(first * 256 + count);
}

}  // namespace

SplitPosition split(glm::dvec3 p) {
  const glm::vec3 high(p);
  return {high, glm::vec3(p - glm::dvec3(high))};
}

RoadScene road_scene(const Network& network) {
  RoadScene scene;
  SectionTable table(scene.sections);
  std::vector<std::vector<PlacedSection>> sections(network.roads.size());
  std::vector<PlacedSegment> all;
  all.reserve(network.segment_count());
  // Strips on the rim of a junction's area have their depth as it has, the nearest within a pixel.
  const std::vector<bool> in_area = roads_in_areas(network), on_rim = corner_roads(network);
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road& road = network.roads[i];
    if (in_area[i]) continue;  // the area is drawn
    for (const LaneSection& section : road.sections) {
      sections[i].push_back(
          {table.add(section), common_period_m(section), is_raised(section), lane_height_range_m(section)});
    }
    for (std::size_t j = 0; j < road.segments.size(); ++j) {
      const Segment& segment = road.segments[j];
      if (segment.section >= sections[i].size()) continue;  // no cross section, nothing to see
      const PlacedSection& section = sections[i][segment.section];
      const std::uint32_t flags = road.closed ? 0
                                              : (j == 0 && !road.joined_start ? kOpenStart : 0u) |
                                                    (j + 1 == road.segments.size() && !road.joined_end ? kOpenEnd : 0u);
      const Cubic::Range deviation = planar_deviation_m(segment);
      all.push_back({&segment, static_cast<std::uint32_t>(i), &section, tile_of(segment), segment.elevation_m.c0,
                     !on_rim[i] && std::max(-deviation.low, deviation.high) <= kPlanarTolerance_m, flags});
    }
  }
  // By tile; within a tile from low to high, so that a bridge's antialiased edge fades over the road below it.
  std::stable_sort(all.begin(), all.end(), [](const PlacedSegment& a, const PlacedSegment& b) {
    return std::tie(a.tile.x, a.tile.y, a.tile.z, a.z_m) < std::tie(b.tile.x, b.tile.y, b.tile.z, b.z_m);
  });
  for (std::size_t i = 0; i < all.size();) {
    RoadTile tile;
    tile.origin_m = glm::dvec3(all[i].tile) * kTileSize_m;
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      tile.ranges[kind].first = static_cast<std::uint32_t>(scene.instances[kind].size());
    }
    const glm::ivec3 key = all[i].tile;
    for (; i < all.size() && all[i].tile == key; ++i) {
      const Segment& segment = *all[i].segment;
      const Road& road = network.roads[all[i].road];
      RoadInstance r = instance(all[i], road.sections[segment.section], static_cast<std::uint32_t>(scene.tiles.size()),
                                tile.origin_m);
      r.paint = add_paint(road, segment, scene.paint);
      const bool detailed = all[i].section->raised || r.paint != 0;
      scene.instances[detailed ? kDetailed : all[i].planar ? kPlanar : kRelief].push_back(r);
      Bounds box = bounds(segment);
      box.low_m.z += all[i].section->heights.low;
      box.high_m.z += all[i].section->heights.high;
      tile.bounds.add(box.low_m);
      tile.bounds.add(box.high_m);
    }
    for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
      RoadTile::Range& range = tile.ranges[kind];
      range.count = static_cast<std::uint32_t>(scene.instances[kind].size()) - range.first;
    }
    scene.tiles.push_back(tile);
  }
  return scene;
}

Cubic::Range planar_deviation_m(const Segment& segment) {
  const double length = segment.chord_length_m(), arc = segment.arc_m;
  const Cubic &z = segment.elevation_m, &e = segment.superelevation_rad;
  const double rise = z.value(arc) - z.c0;
  const double half_width = segment.max_half_width_m();
  const double steep = std::max({std::abs(segment.slope_start), std::abs(segment.slope_end)});
  const Linear &l = segment.crossfall_left, &r = segment.crossfall_right;
  const Cubic::Range bank = e.range(arc);
  // Slopes across turn with the road and are not looked at further.
  const double across = std::tan(std::clamp(std::max(-bank.low, bank.high), 0.0, 1.4)) +
                        std::max({std::abs(l.c0), std::abs(l.value(arc)), std::abs(r.c0), std::abs(r.value(arc))});
  // Along the centre line, at u: z(s) against rise * u. First against rise * s / arc, then s / arc against u.
  Cubic off = z;
  off.c0 = 0;
  off.c1 -= rise / arc;
  const Cubic::Range along = off.range(arc);
  if (rise == 0 && along.low == 0 && along.high == 0) return {-across * half_width, across * half_width};
  // |s / arc - u| <= max |ds/du / arc - 1| / 2 <= (q - 1) / 2 with q = max sqrt(1 + f'^2); |f'| <= 4/3 max(|a|, |b|).
  const double slope = 4.0 / 3.0 * steep;
  const double stretch = 0.5 * (std::sqrt(1 + slope * slope) - 1);
  // Across: the point (u, v) lies at x = u - v f' / q.
  const double lean = half_width / length * slope;
  const double slack = std::abs(rise) * (stretch + lean) + across * half_width;
  return {along.low - slack, along.high + slack};
}

}  // namespace roadgen
