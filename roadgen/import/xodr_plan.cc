#include "roadgen/import/xodr_plan.h"

#include <cmath>
#include <cstring>
#include <pugixml.hpp>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

// Greatest break in s from one geometry to the next; less than kLeastPiece_m.
constexpr double kSameStation_m = 1e-3;
constexpr double kGreatest_m = 1e9;
// A spiral or arc that turns more often than this is a mistake.
constexpr double kMostTurning_rad = 100;
// What a foreign curve is certified for where its road is narrower.
constexpr double kLeastHalfWidth_m = 0.5;

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * M_PI); }

// How far a foreign file's geometries may miss one another at a joint that is closed.
constexpr double kClosedGap_m = 0.01;
constexpr double kClosedTurn_rad = 1e-3;

constexpr double kMostShift = 0.1;  // of the length of the segment that is moved

// Gives the segment these ends and headings.
void lay(Segment& segment, glm::dvec2 start_m, glm::dvec2 end_m, double start_rad, double end_rad) {
  segment.start_m = start_m, segment.end_m = end_m;
  const glm::dvec2 chord = segment.chord_m();
  const double chord_rad = std::atan2(chord.y, chord.x);
  segment.slope_start = std::tan(start_rad - chord_rad);
  segment.slope_end = std::tan(end_rad - chord_rad);
  set_arc(segment);
}

// Moves the end onto the next segment's start, and its heading onto the next one's, where they are closer than this; the
// heading at the segment's own start stays. Where the segment is too short for that, the next one's start is moved.
// Returns the gap that was closed.
double join(Segment& segment, Segment& next, double most_m, double most_rad) {
  const double gap_m = glm::length(segment.end_m - next.start_m);
  const double start_rad = heading_rad(segment, 0), end_rad = heading_rad(segment, 1), next_rad = heading_rad(next, 0);
  const double turn_rad = wrapped(next_rad - end_rad);
  const bool turns = std::abs(turn_rad) > 1e-12 && std::abs(turn_rad) <= most_rad;
  if (gap_m > most_m || (gap_m == 0 && !turns)) return 0;
  if (gap_m <= kMostShift * segment.chord_length_m()) {
    lay(segment, segment.start_m, next.start_m, start_rad, end_rad + (turns ? turn_rad : 0));
  } else if (gap_m <= kMostShift * next.chord_length_m()) {
    lay(next, segment.end_m, next.end_m, next_rad - (turns ? turn_rad : 0), heading_rad(next, 1));
  } else {
    return 0;
  }
  return gap_m;
}

// The greatest |t| of the road's edges over [from_m, to_m], which lies in one section.
double half_width_m(const std::vector<LaneSection>& sections, double from_m, double to_m) {
  const auto after = std::partition_point(sections.begin(), sections.end(),
                                          [&](const LaneSection& section) { return section.s_m <= from_m; });
  const LaneSection& section = after == sections.begin() ? *after : *(after - 1);
  const std::vector<Cubic> borders = section.borders_m();
  double most = kLeastHalfWidth_m;
  for (const Cubic& edge : {borders.front(), borders.back()}) {
    const Cubic::Range range = edge.shifted(from_m - section.s_m).range(to_m - from_m);
    most = std::max({most, range.high, -range.low});
  }
  return most;
}

std::optional<PlanCurve> read_param_poly3(XodrSource& source, pugi::xml_node shape, glm::dvec2 start_m,
                                          double heading_rad, double length_m) {
  const glm::dvec2 offset(source.number(shape, "aU"), source.number(shape, "aV"));
  ParametricCubic curve{offset,
                        {source.number(shape, "bU"), source.number(shape, "bV")},
                        {source.number(shape, "cU"), source.number(shape, "cV")},
                        {source.number(shape, "dU"), source.number(shape, "dV")}};
  const std::string range = shape.attribute("pRange").as_string("arcLength");  // the default of OpenDRIVE 1.4
  if (range == "arcLength")
    curve = curve.rescaled(length_m);
  else if (range != "normalized")
    source.fail(ErrorCode::kParse, shape, "pRange=\"" + range + "\" is neither arcLength nor normalized");
  curve = curve.turned(heading_rad);
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  curve.start_m = start_m + glm::dvec2(c * offset.x - s * offset.y, s * offset.x + c * offset.y);
  return curve;
}

std::optional<PlanCurve> read_shape(XodrSource& source, pugi::xml_node node, double heading_rad, double length_m) {
  const glm::dvec2 start(source.number(node, "x"), source.number(node, "y"));
  const pugi::xml_node shape = node.find_child(
      [](pugi::xml_node n) { return n.type() == pugi::node_element && std::strcmp(n.name(), "userData") != 0; });
  const std::string kind = shape.name();
  if (kind == "line") return Clothoid{start, heading_rad, length_m, 0, 0};
  if (kind == "arc" || kind == "spiral") {
    const bool arc = kind == "arc";
    const double first = source.number(shape, arc ? "curvature" : "curvStart");
    const double last = arc ? first : source.number(shape, "curvEnd");
    if (length_m * std::max(std::abs(first), std::abs(last)) > kMostTurning_rad) {
      source.fail(ErrorCode::kData, shape, "the geometry turns by more than 100 rad");
    }
    return Clothoid{start, heading_rad, length_m, first, last};
  }
  if (kind == "poly3") {
    const Cubic v = source.cubic(shape);
    for (const double x : {v.c0, v.c1, v.c2, v.c3}) {
      if (std::abs(x) > kGreatest_m) source.fail(ErrorCode::kGeometry, shape, "the geometry is beyond 1e9 m");
    }
    if (source.failed()) return {};
    return PlanCurve::poly3(start, heading_rad, v, length_m);
  }
  if (kind == "paramPoly3") return read_param_poly3(source, shape, start, heading_rad, length_m);
  if (shape)
    source.fail(ErrorCode::kData, shape, "the geometry <" + kind + "> is not known");
  else
    source.fail(ErrorCode::kParse, node, "<geometry> has no shape");
  return {};
}

// Our own files carry the anchors and slopes unrounded; they count only where they agree with the shape.
std::optional<Segment> exact_segment(XodrSource& source, pugi::xml_node node, const PlanCurve& curve) {
  const std::string text = user_data(node, "roadgen:chord");
  if (text.empty() || !curve.parametric()) return {};
  const std::vector<double> chord = numbers_in(text);
  const Result<Segment> rounded = segment_from_cubic(*curve.parametric());
  if (chord.size() != 4 || !rounded || glm::length(glm::dvec2(chord[0], chord[1]) - rounded->end_m) > kSamePlace_m ||
      std::abs(chord[2] - rounded->slope_start) > 1e-6 || std::abs(chord[3] - rounded->slope_end) > 1e-6) {
    source.note(node, "userData roadgen:chord does not agree with the geometry, which is used");
    return {};
  }
  Segment segment = *rounded;
  if (!(glm::length(glm::dvec2(chord[0], chord[1]) - segment.start_m) > 0)) return segment;
  segment.end_m = {chord[0], chord[1]};
  segment.slope_start = chord[2];
  segment.slope_end = chord[3];
  set_arc(segment);
  return segment;
}

XodrGeometry read_geometry(XodrSource& source, pugi::xml_node node) {
  XodrGeometry geometry;
  geometry.s_m = source.number(node, "s");
  geometry.length_m = source.number(node, "length");
  geometry.line = source.line(node);
  const double heading = source.number(node, "hdg");
  if (source.failed()) return geometry;
  if (!(geometry.length_m > 0)) {
    source.fail(ErrorCode::kParse, node,
                "<geometry> has length=\"" + std::string(node.attribute("length").value()) + "\"; it must be positive");
    return geometry;
  }
  const std::optional<PlanCurve> curve = read_shape(source, node, heading, geometry.length_m);
  if (source.failed()) return geometry;
  geometry.curve = *curve;
  for (const double p : {0.0, 0.5, 1.0}) {
    const glm::dvec2 at = curve->position_m(p), along = curve->derivative_m(p);
    const bool usable = std::max({std::abs(at.x), std::abs(at.y), std::abs(along.x), std::abs(along.y)}) <= kGreatest_m;
    if (!usable) source.fail(ErrorCode::kGeometry, node, "the geometry is beyond 1e9 m");
  }
  geometry.arc_m = curve->arc_m(0, 1);
  if (!source.failed() && !(geometry.arc_m > 1e-9 && geometry.arc_m <= 4 * kGreatest_m)) {
    source.fail(ErrorCode::kGeometry, node, "the geometry starts and ends at the same point, or is beyond 1e9 m");
  }
  if (source.failed()) return geometry;
  geometry.own = exact_segment(source, node, *curve);
  const double arc = geometry.own ? geometry.own->arc_m : geometry.arc_m;
  if (std::abs(arc - geometry.length_m) > kSamePlace_m * (1 + geometry.length_m)) {
    source.note(node, "the length of a geometry is not the arc length of its curve, which is used");
  }
  return geometry;
}

}  // namespace

std::vector<XodrGeometry> read_plan_view(XodrSource& source, pugi::xml_node node) {
  std::vector<XodrGeometry> plan;
  for (const pugi::xml_node geometry : node.child("planView").children("geometry")) {
    plan.push_back(read_geometry(source, geometry));
    if (source.failed()) return plan;
    const double expected = plan.size() == 1 ? 0 : plan[plan.size() - 2].s_m + plan[plan.size() - 2].length_m;
    if (std::abs(plan.back().s_m - expected) > kSameStation_m) {
      source.fail(ErrorCode::kParse, geometry,
                  "<geometry> does not start where the one before ends: s is off by " +
                      std::to_string(plan.back().s_m - expected) + " m");
    }
  }
  if (!source.failed() && plan.empty())
    source.fail(ErrorCode::kParse, node, "the road has no <planView> with a <geometry>");
  return plan;
}

std::vector<PlacedSegment> place_segments(XodrSource& source, const std::vector<XodrGeometry>& plan,
                                          const Stations& stations, const std::vector<LaneSection>& sections) {
  std::vector<PlacedSegment> placed;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const XodrGeometry& g = plan[i];
    std::vector<double> at = stations.between(g.s_m, i + 1 < plan.size() ? plan[i + 1].s_m : stations.end_m());
    at.push_back(i + 1 < plan.size() ? plan[i + 1].s_m : stations.end_m());
    if (at.size() == 2 && g.own) {
      placed.push_back({*g.own, at[0], at[1], g.length_m, true});
      continue;
    }
    const double scale = g.length_m / g.arc_m;
    double p0 = 0;
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
      const double p1 = k + 2 == at.size() ? 1 : g.curve.p_at_arc((at[k + 1] - g.s_m) / scale);
      std::vector<CurvePiece> pieces;
      if (!divide_curve(g.curve, p0, p1, half_width_m(sections, at[k], at[k + 1]), pieces)) {
        source.fail(ErrorCode::kGeometry, g.line, "the geometry stops or reverses on the spot");
        return placed;
      }
      double from = at[k];
      for (const CurvePiece& piece : pieces) {
        const double length = scale * g.curve.arc_m(piece.p0, piece.p1);
        const double to = &piece == &pieces.back() ? at[k + 1] : from + length;
        placed.push_back({piece.segment, from, to, length});
        from = to;
      }
      p0 = p1;
    }
  }
  return placed;
}

void join_segments(XodrSource& source, std::vector<PlacedSegment>& placed, bool closed, pugi::xml_node node) {
  double widest = 0;
  const auto join_pair = [&](PlacedSegment& before, PlacedSegment& after) {
    // What we wrote ourselves is exact.
    const bool exact = before.own && after.own;
    widest = std::max(
        widest, join(before.segment, after.segment, exact ? kSamePlace_m : kClosedGap_m, exact ? 0 : kClosedTurn_rad));
  };
  for (std::size_t i = 0; i + 1 < placed.size(); ++i) join_pair(placed[i], placed[i + 1]);
  if (closed && glm::length(placed.back().segment.end_m - placed.front().segment.start_m) > kClosedGap_m) {
    source.fail(ErrorCode::kData, node, "the road is linked to itself but does not end where it starts");
    return;
  }
  if (closed) join_pair(placed.back(), placed.front());
  if (widest > kSamePlace_m) source.note(node, "gaps between geometries of up to 0.01 m are closed");
}

}  // namespace roadgen
