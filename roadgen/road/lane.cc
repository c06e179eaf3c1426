#include "roadgen/road/lane.h"

#include <algorithm>
#include <array>

namespace roadgen {
namespace {

struct TypeRow {
  std::string_view name;
  Material material;
};
// In the order of LaneType.
constexpr std::array<TypeRow, kLaneTypes> kTypes = {{
    {"none", Material::kGrass},
    {"driving", Material::kAsphalt},
    {"shoulder", Material::kAsphalt},
    {"border", Material::kAsphalt},
    {"stop", Material::kAsphalt},
    {"restricted", Material::kAsphalt},
    {"parking", Material::kAsphalt},
    {"median", Material::kGrass},
    {"biking", Material::kAsphalt},
    {"sidewalk", Material::kPaving},
    {"curb", Material::kCurbstone},
    {"exit", Material::kAsphalt},
    {"entry", Material::kAsphalt},
    {"onRamp", Material::kAsphalt},
    {"offRamp", Material::kAsphalt},
    {"connectingRamp", Material::kAsphalt},
    {"bidirectional", Material::kAsphalt},
    {"slipLane", Material::kAsphalt},
    {"bus", Material::kAsphalt},
    {"taxi", Material::kAsphalt},
    {"HOV", Material::kAsphalt},
    {"rail", Material::kGravel},
    {"tram", Material::kConcrete},
    {"roadWorks", Material::kGravel},
}};

// The lane at (ds, t) and how far across it lies, 0 at its inner border to 1 at its outer one.
struct Across {
  const Lane* lane = nullptr;
  int id = 0;
  double part = 0;
};

Across find_side(const std::vector<Lane>& lanes, int sign, double ds_m, double from_center_m) {
  double border = 0;
  for (std::size_t i = 0; i < lanes.size(); ++i) {
    const double width = std::max(lanes[i].width_m.value(ds_m), 0.0);
    if (width > 0 && from_center_m <= border + width) {
      return {&lanes[i], sign * (static_cast<int>(i) + 1), (from_center_m - border) / width};
    }
    border += width;
  }
  return {};
}

Across find(const LaneSection& section, double ds_m, double t_m) {
  const double from_center = t_m - section.offset_m.value(ds_m);
  return from_center >= 0 ? find_side(section.left, 1, ds_m, from_center)
                          : find_side(section.right, -1, ds_m, -from_center);
}

}  // namespace

std::string_view lane_type_name(LaneType type) { return kTypes[static_cast<std::size_t>(type)].name; }

LaneType lane_type(std::string_view name) {
  const auto at = std::find_if(kTypes.begin(), kTypes.end(), [&](const TypeRow& row) { return row.name == name; });
  return at == kTypes.end() ? LaneType::kNone : static_cast<LaneType>(at - kTypes.begin());
}

Material default_material(LaneType type) { return kTypes[static_cast<std::size_t>(type)].material; }

std::vector<Cubic> LaneSection::borders_m() const {
  std::vector<Cubic> borders(right.size() + left.size() + 1);
  Cubic t = offset_m;
  borders[right.size()] = t;
  for (std::size_t i = 0; i < right.size(); ++i) borders[right.size() - 1 - i] = t = t - right[i].width_m;
  t = offset_m;
  for (std::size_t i = 0; i < left.size(); ++i) borders[right.size() + 1 + i] = t = t + left[i].width_m;
  return borders;
}

int lane_at(const LaneSection& section, double ds_m, double t_m) { return find(section, ds_m, t_m).id; }

double lane_height_m(const LaneSection& section, double ds_m, double t_m) {
  const Across at = find(section, ds_m, t_m);
  return at.lane ? at.lane->inner_height_m + at.part * (at.lane->outer_height_m - at.lane->inner_height_m) : 0;
}

LaneSurface lane_surface(const LaneSection& section, double ds_m, double t_m) {
  const Across at = find(section, ds_m, t_m);
  if (!at.lane) return {};
  const double rise = at.lane->outer_height_m - at.lane->inner_height_m;
  if (rise == 0) return {at.lane->inner_height_m, 0, 0};
  // The lane's inner border and its width change with s.
  const double sign = at.id > 0 ? 1 : -1;
  double border = sign * section.offset_m.slope(ds_m);
  for (const Lane* lane = (at.id > 0 ? section.left : section.right).data(); lane != at.lane; ++lane) {
    if (lane->width_m.value(ds_m) > 0) border += lane->width_m.slope(ds_m);
  }
  const double width = at.lane->width_m.value(ds_m);
  return {at.lane->inner_height_m + at.part * rise, -(border + at.part * at.lane->width_m.slope(ds_m)) / width * rise,
          sign / width * rise};
}

Cubic::Range lane_height_range_m(const LaneSection& section) {
  Cubic::Range range{0, 0};
  for (const auto* side : {&section.left, &section.right}) {
    for (const Lane& lane : *side) {
      range.low = std::min({range.low, lane.inner_height_m, lane.outer_height_m});
      range.high = std::max({range.high, lane.inner_height_m, lane.outer_height_m});
    }
  }
  return range;
}

}  // namespace roadgen
