#include "roadgen/export/geojson.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "roadgen/export/sampling.h"
#include "roadgen/geodesy/local_frame.h"

namespace roadgen {
namespace {

constexpr double kGreatestStep_m = 100;

const char* mark_name(MarkKind kind) {
  switch (kind) {
    case MarkKind::kNone: return "none";
    case MarkKind::kSolid: return "solid";
    case MarkKind::kBroken: return "broken";
    case MarkKind::kSolidSolid: return "solid solid";
    case MarkKind::kSolidBroken: return "solid broken";
    case MarkKind::kBrokenSolid: return "broken solid";
    case MarkKind::kBrokenBroken: return "broken broken";
  }
  return "none";
}

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

class Writer {
 public:
  Writer(const Network& network, double max_error_m) : frame_(*network.georeference), max_error_m_(max_error_m) {}

  void add(const Road& road) {
    line(road, "reference line", 0, road.segments.size(), {}, [](const Segment&) { return Cubic{0, 0, 0, 0}; });
    for (std::size_t first = 0; first < road.segments.size();) {
      std::size_t end = first;
      while (end < road.segments.size() && road.segments[end].section == road.segments[first].section) ++end;
      const LaneSection& section = section_of(road, road.segments[first]);
      const std::vector<Cubic> borders = section.borders_m();
      const auto right = static_cast<int>(section.right.size());
      for (int i = 0; i < static_cast<int>(borders.size()); ++i) {
        const int lane = i - right;
        const Mark& mark = lane < 0    ? section.right[static_cast<std::size_t>(-lane - 1)].mark
                           : lane == 0 ? section.center_mark
                                       : section.left[static_cast<std::size_t>(lane - 1)].mark;
        const std::string more = fmt::format(R"(,"lane":{},"mark":"{}")", lane, mark_name(mark.kind));
        line(road, "lane border", first, end, more, [&](const Segment& segment) {
          return borders[static_cast<std::size_t>(i)].shifted(section_offset_m(road, segment));
        });
      }
      first = end;
    }
  }

  std::string text() && { return R"({"type":"FeatureCollection","features":[)" + features_ + "\n]}\n"; }

 private:
  template <class Offset>
  void line(const Road& road, const char* kind, std::size_t first, std::size_t end, const std::string& more,
            Offset&& offset) {
    features_ += features_.empty() ? "\n" : ",\n";
    features_ += fmt::format(R"({{"type":"Feature","properties":{{"road":{},"name":{},"kind":"{}"{}}},)",
                             quoted(road.id), quoted(road.name), kind, more);
    features_ += R"("geometry":{"type":"LineString","coordinates":[)";
    for (std::size_t i = first; i < end; ++i) {
      const Segment& segment = road.segments[i];
      const Cubic t = offset(segment);
      const SegmentError error(segment);
      const int least = static_cast<int>(std::ceil(segment.arc_m / kGreatestStep_m));
      const int rows = std::max(
          least, fewest_rows(segment.arc_m, max_error_m_, [&](int n) { return error.of_line(t, segment.arc_m / n); }));
      for (int k = i == first ? 0 : 1; k <= rows; ++k) {
        const double s = segment.arc_m * k / rows;
        const Geodetic p = frame_.to_geodetic(place(road, segment, s, t.value(s)));
        features_ += fmt::format("{}[{:.9f},{:.9f},{:.4f}]", i == first && k == 0 ? "" : ",", p.longitude_deg,
                                 p.latitude_deg, p.height_m);
      }
    }
    features_ += "]}}";
  }

  static glm::dvec3 place(const Road& road, const Segment& segment, double s_m, double t_m) {
    const double u = u_at_arc(segment, s_m), heading = heading_rad(segment, u);
    const double n = t_m * std::cos(segment.superelevation_rad.value(s_m));
    return {position_m(segment, u) + n * glm::dvec2(-std::sin(heading), std::cos(heading)),
            surface_height_m(road, segment, s_m, t_m)};
  }

  LocalFrame frame_;
  double max_error_m_;
  std::string features_;
};

}  // namespace

Result<std::string> geojson_text(const Network& network, double max_error_m) {
  if (!(max_error_m >= 1e-4 && max_error_m <= 1e3)) {
    return Error{ErrorCode::kUsage, "the error of lines must be from 0.0001 to 1000 m"};
  }
  if (!network.georeference) {
    return Error{ErrorCode::kData,
                 "the network has no georeference, which GeoJSON needs; import it from latitudes and "
                 "longitudes"};
  }
  Writer writer(network, max_error_m);
  for (const Road& road : network.roads) writer.add(road);
  return std::move(writer).text();
}

}  // namespace roadgen
