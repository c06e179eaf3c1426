#include "roadgen/import/xodr_lateral.h"

#include <pugixml.hpp>

#include "roadgen/road/crossfall.h"

namespace roadgen {
namespace {

// At a station one record ends and the next begins.
enum class Limit { kBefore, kAfter };

double height_across(const XodrShape& shape, double t_m) {
  const auto after = std::partition_point(shape.across.begin(), shape.across.end(),
                                          [&](const From<Cubic>& record) { return record.s_m <= t_m; });
  const From<Cubic>& record = after == shape.across.begin() ? *after : *(after - 1);
  return record.value.value(t_m - record.s_m);
}

// The file's height over the plane of the cross section; from and to are the stations around s.
class Across {
 public:
  Across(const XodrLateral& lateral, const Stations& stations, double from_m)
      : lateral_(lateral),
        stations_(stations),
        from_m_(from_m),
        left_rad_(cubic_from(lateral.crossfall_left, from_m, stations)),
        right_rad_(cubic_from(lateral.crossfall_right, from_m, stations)) {}

  double height_m(double s_m, double t_m, Limit limit) const {
    const Cubic& fall = t_m > 0 ? left_rad_ : right_rad_;
    return shape_m(s_m, t_m, limit) - std::abs(t_m) * tilt_slope(fall.value(s_m - from_m_));
  }

  // The slope, falling outward, of the least-squares line over the side from t = 0 to edge_m.
  double fall(double s_m, double edge_m, Limit limit) const {
    const double zero = height_m(s_m, 0, limit);
    double along = 0, square = 0;
    for (int i = 1; i <= kSamples; ++i) {
      const double t = edge_m * i / kSamples;
      along -= std::abs(t) * (height_m(s_m, t, limit) - zero);
      square += t * t;
    }
    return along / square;
  }

  static constexpr int kSamples = 16;

 private:
  double shape_m(double s_m, double t_m, Limit limit) const {
    const auto& shapes = lateral_.shapes;
    const auto after = std::partition_point(shapes.begin(), shapes.end(), [&](const XodrShape& shape) {
      const double at = stations_.snapped(shape.s_m);
      return limit == Limit::kBefore ? at < s_m : at <= s_m;
    });
    if (after == shapes.begin()) return 0;
    const double height = height_across(*(after - 1), t_m);
    if (after == shapes.end()) return height;
    const double from = stations_.snapped((after - 1)->s_m), to = stations_.snapped(after->s_m);
    return height + (height_across(*after, t_m) - height) * (s_m - from) / (to - from);
  }

  const XodrLateral& lateral_;
  const Stations& stations_;
  double from_m_;
  Cubic left_rad_, right_rad_;
};

// Where to look at the side: its edge, or 1 m where there is less.
double edge_at(const Segment& segment, double s_m, double side) {
  return side > 0 ? std::max(segment.left_m.value(s_m), 1.0) : std::min(segment.right_m.value(s_m), -1.0);
}

// What the file's slopes are at both ends of a segment, in the tilted cross section.
struct Falls {
  double left0, left1, right0, right1;
};

// Our own files carry the slopes unrounded; true where they are those of the shape.
bool take_exact_crossfall(XodrSource& source, const XodrLateral& lateral, double from_m, const Falls& file,
                          Segment& segment) {
  const auto at = std::find_if(lateral.exact.begin(), lateral.exact.end(),
                               [&](const auto& record) { return std::abs(record.s_m - from_m) <= kSamePlace_m; });
  if (at == lateral.exact.end()) return false;
  const Linear left{at->value[0], at->value[1]}, right{at->value[2], at->value[3]};
  const auto same = [&](const Linear& exact, double side, double fall0, double fall1) {
    const auto differs = [&](double local, double fall) {
      const double written = tilted_fall(exact.value(local), segment.superelevation_rad.value(local), side);
      return !(std::abs(written - fall) <= 1e-6 * (1 + std::abs(fall)));
    };
    return !differs(0, fall0) && !differs(segment.arc_m, fall1);
  };
  if (!same(left, 1, file.left0, file.left1) || !same(right, -1, file.right0, file.right1)) {
    source.note(at->line, "userData roadgen:crossfall does not agree with the shape, which is used");
    return false;
  }
  segment.crossfall_left = left;
  segment.crossfall_right = right;
  return true;
}

double deviation_m(const Across& across, const Segment& segment, double from_m, double to_m) {
  double worst = 0;
  for (int i = 0; i <= 4; ++i) {
    const double part = 0.25 * i, local = part * segment.arc_m, s = from_m + part * (to_m - from_m);
    const double e = segment.superelevation_rad.value(local);
    const Limit limit = i == 4 ? Limit::kBefore : Limit::kAfter;
    const double zero =
        across.height_m(from_m, 0, Limit::kAfter) * (1 - part) + across.height_m(to_m, 0, Limit::kBefore) * part;
    for (const double side : {-1.0, 1.0}) {
      const Linear& fall = side > 0 ? segment.crossfall_left : segment.crossfall_right;
      const double slope = tilted_fall(fall.value(local), e, side);
      for (int k = 0; k <= Across::kSamples; ++k) {
        const double t = (side > 0 ? segment.left_m : segment.right_m).value(local) * k / Across::kSamples;
        if (t * side < 0) continue;
        worst = std::max(worst, std::abs(across.height_m(s, t, limit) - (zero - std::abs(t) * slope)));
      }
    }
  }
  return worst;
}

}  // namespace

std::vector<double> XodrLateral::changes_m() const {
  std::vector<double> changes;
  for (const Profile* profile : {&superelevation, &crossfall_left, &crossfall_right}) {
    for (const auto& record : *profile) changes.push_back(record.s_m);
  }
  for (const XodrShape& shape : shapes) changes.push_back(shape.s_m);
  return changes;
}

int XodrLateral::first_line() const {
  if (!shapes.empty()) return shapes.front().across.front().line;
  const Profile& fall = crossfall_left.empty() ? crossfall_right : crossfall_left;
  return fall.empty() ? 0 : fall.front().line;
}

XodrLateral read_lateral(XodrSource& source, const pugi::xml_node& road) {
  XodrLateral lateral;
  const pugi::xml_node node = road.child("lateralProfile");
  lateral.superelevation = read_profile(source, node, "superelevation", "s");
  for (const pugi::xml_node record : node.children("crossfall")) {
    const std::string side = record.attribute("side").as_string("both");
    const From<Cubic> fall{source.number(record, "s"), source.cubic(record), source.line(record)};
    if (side != "left" && side != "right" && side != "both") {
      source.fail(ErrorCode::kParse, record, "<crossfall> has side=\"" + side + "\", not left, right or both");
    }
    if (side != "right") lateral.crossfall_left.push_back(fall);
    if (side != "left") lateral.crossfall_right.push_back(fall);
  }
  expect_order(source, lateral.crossfall_left, "<crossfall>");
  expect_order(source, lateral.crossfall_right, "<crossfall>");

  for (const pugi::xml_node record : node.children("shape")) {
    const double s = source.number(record, "s"), t = source.number(record, "t");
    if (lateral.shapes.empty() || s != lateral.shapes.back().s_m) lateral.shapes.push_back({s, {}});
    const std::size_t count = lateral.shapes.size();
    if (count > 1 && s < lateral.shapes[count - 2].s_m) {
      source.fail(ErrorCode::kParse, record, "<shape> records are not in order of s");
    }
    lateral.shapes.back().across.push_back({t, source.cubic(record), source.line(record)});
    expect_order(source, lateral.shapes.back().across, "<shape>");
    if (source.failed()) return lateral;
  }
  for (const pugi::xml_node data : node.children("userData")) {
    if (data.attribute("code").value() != std::string_view("roadgen:crossfall")) continue;
    const std::vector<double> x = numbers_in(data.attribute("value").value());
    if (x.size() == 5) lateral.exact.push_back({x[0], {x[1], x[2], x[3], x[4]}, source.line(data)});
  }
  return lateral;
}

double set_lateral(XodrSource& source, const XodrLateral& lateral, const Stations& stations, double from_m, double to_m,
                   double length_m, Segment& segment) {
  const double arc = segment.arc_m;
  segment.superelevation_rad = scaled(cubic_from(lateral.superelevation, from_m, stations), length_m, arc);
  const Cubic::Range range = segment.superelevation_rad.range(arc);
  if (!(range.low >= -kGreatestProfile && range.high <= kGreatestProfile)) {
    source.fail(ErrorCode::kData, lateral.superelevation.front().line, "the superelevation is beyond 1e6 rad");
    return 0;
  }
  if (lateral.crossfall_left.empty() && lateral.crossfall_right.empty() && lateral.shapes.empty()) return 0;

  const Across across(lateral, stations, from_m);
  const auto fall_before = [&](double side) { return across.fall(to_m, edge_at(segment, arc, side), Limit::kBefore); };
  const auto fall_after = [&](double side) { return across.fall(from_m, edge_at(segment, 0, side), Limit::kAfter); };
  const Falls file{fall_after(1), fall_before(1), fall_after(-1), fall_before(-1)};
  const auto level = [&](double side, double fall0, double fall1) {
    const double level0 = level_fall(fall0, segment.superelevation_rad.c0, side);
    const double level1 = level_fall(fall1, segment.superelevation_rad.value(arc), side);
    return Linear{level0, (level1 - level0) / arc};
  };
  segment.crossfall_left = level(1, file.left0, file.left1);
  segment.crossfall_right = level(-1, file.right0, file.right1);
  const auto lift = [&](double s, double local, Limit limit) {
    return across.height_m(s, 0, limit) * std::cos(segment.superelevation_rad.value(local));
  };
  const double lift0 = lift(from_m, 0, Limit::kAfter), lift1 = lift(to_m, arc, Limit::kBefore);
  if (lift0 != 0 || lift1 != 0) {
    segment.elevation_m.c0 += lift0;
    segment.elevation_m.c1 += (lift1 - lift0) / arc;
  }
  bool usable = std::abs(lift0) <= kGreatestProfile && std::abs(lift1) <= kGreatestProfile;
  for (const Linear& fall : {segment.crossfall_left, segment.crossfall_right}) {
    usable = usable && std::abs(fall.c0) <= kGreatestProfile && std::abs(fall.value(arc)) <= kGreatestProfile;
  }
  if (!usable) {
    source.fail(ErrorCode::kData, lateral.first_line(), "the crossfall or shape is beyond 1e6");
    return 0;
  }
  if (take_exact_crossfall(source, lateral, from_m, file, segment)) return 0;
  return deviation_m(across, segment, from_m, to_m);
}

}  // namespace roadgen
