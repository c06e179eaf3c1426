#include "roadgen/road/records.h"

#include <algorithm>
#include <cmath>

namespace roadgen {
namespace {

constexpr double kMostPlaces = 0x1p53;

// Copies lie at s, s + distance, ... up to the length; a nanometre is for rounding.
std::uint64_t copies(const ObjectRepeat& repeat) {
  if (!(repeat.distance_m > 0)) return 1;
  return static_cast<std::uint64_t>(
             std::min(std::floor((repeat.length_m + 1e-9) / repeat.distance_m), kMostPlaces - 1)) +
         1;
}

bool is_sound(const ObjectSize& size) {
  const double sum = size.length_m + size.width_m + size.height_m + size.radius_m;
  return std::isfinite(sum) && std::min({size.length_m, size.width_m, size.height_m, size.radius_m}) >= 0;
}

bool is_sound(const ObjectRepeat& r) {
  return std::isfinite(r.s_m + r.t_start_m + r.t_end_m + r.z_offset_start_m + r.z_offset_end_m) && r.length_m >= 0 &&
         r.distance_m >= 0 && std::isfinite(r.length_m + r.distance_m) && is_sound(r.start) && is_sound(r.end);
}

bool is_sound(const Outline& outline) {
  return std::all_of(outline.corners.begin(), outline.corners.end(), [](const OutlineCorner& c) {
    return std::isfinite(c.along_m + c.across_m + c.up_m + c.height_m);
  });
}

}  // namespace

std::optional<double> SpeedLimit::metres_per_second() const {
  if (kind != Kind::kMax) return {};
  switch (unit) {
    case Unit::kMetresPerSecond: return value;
    case Unit::kKilometresPerHour: return value / 3.6;
    case Unit::kMilesPerHour: return value * 0.44704;
  }
  return {};
}

bool is_sound(const RoadObject& o) {
  const auto sound = [](const auto& part) { return is_sound(part); };
  const double sum = o.s_m + o.t_m + o.z_offset_m + o.heading_rad + o.pitch_rad + o.roll_rad + o.valid_length_m;
  return std::isfinite(sum) && o.valid_length_m >= 0 && is_sound(o.size) &&
         std::all_of(o.repeats.begin(), o.repeats.end(), sound) &&
         std::all_of(o.outlines.begin(), o.outlines.end(), sound);
}

bool is_sound(const RoadSignal& s) {
  const double sum = s.s_m + s.t_m + s.z_offset_m + s.heading_rad + s.pitch_rad + s.roll_rad + s.value.value_or(0) +
                     s.length_m + s.width_m + s.height_m;
  return std::isfinite(sum) && std::min({s.length_m, s.width_m, s.height_m}) >= 0;
}

bool is_sound(const RoadRecords& records) {
  const auto sound = [](const auto& x) { return is_sound(x); };
  const auto is_limit = [](const SpeedLimit& speed) { return std::isfinite(speed.value) && speed.value >= 0; };
  return std::all_of(records.objects.begin(), records.objects.end(), sound) &&
         std::all_of(records.signals.begin(), records.signals.end(), sound) &&
         std::all_of(records.types.begin(), records.types.end(),
                     [&](const RoadType& t) { return std::isfinite(t.s_m) && is_limit(t.speed); }) &&
         std::all_of(records.lanes.begin(), records.lanes.end(),
                     [&](const LaneRecord& l) { return is_limit(l.speed); });
}

std::uint64_t place_count(const RoadObject& object) {
  if (object.repeats.empty()) return 1;
  double count = 0;
  for (const ObjectRepeat& repeat : object.repeats) count += static_cast<double>(copies(repeat));
  return static_cast<std::uint64_t>(std::min(count, kMostPlaces));
}

ObjectPlace place_of(const RoadObject& object, std::uint64_t index) {
  for (const ObjectRepeat& r : object.repeats) {
    const std::uint64_t count = copies(r);
    if (index >= count) {
      index -= count;
      continue;
    }
    const double along = static_cast<double>(index) * r.distance_m, part = r.length_m > 0 ? along / r.length_m : 0;
    const auto mixed = [&](double from, double to) { return from + part * (to - from); };
    return {r.s_m + along,
            mixed(r.t_start_m, r.t_end_m),
            mixed(r.z_offset_start_m, r.z_offset_end_m),
            {mixed(r.start.length_m, r.end.length_m), mixed(r.start.width_m, r.end.width_m),
             mixed(r.start.height_m, r.end.height_m), mixed(r.start.radius_m, r.end.radius_m)}};
  }
  return {object.s_m, object.t_m, object.z_offset_m, object.size};
}

}  // namespace roadgen
