#include "roadgen/road/junction.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <numeric>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kGreatestTurn_rad = kPi / 6;  // of one piece
constexpr double kTurnOver = 0.03;         // part of it that an arc may turn more than its pieces: near right angles
constexpr double kBend_rad = kPi / 6;      // a corner that turns by more has a circular arc between straights
constexpr double kLeastStraight_m = 0.05;  // shorter ones become part of the arc
constexpr double kNoStraight_m = 1e-3;     // still shorter ones are none: the arc's last cubic takes them up
constexpr double kMappedBand_m = 0.5;      // half width of the pieces as segments: what is certified

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * kPi); }
glm::dvec2 direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }
glm::dvec2 left_of(glm::dvec2 d) { return {-d.y, d.x}; }
double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

std::string name_of(const JunctionArm& arm) { return "road " + arm.road + (arm.at_end ? " (end)" : " (start)"); }

std::string metres(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2f m", x);
  return text;
}

bool is_finite(const JunctionArm& a) {
  return std::isfinite(a.position_m.x + a.position_m.y + a.heading_rad + a.left_m + a.right_m + a.elevation_m +
                       a.grade + a.tilt + a.crossfall_left + a.crossfall_right);
}

// A place on a corner curve, and its direction of travel.
struct Node {
  glm::dvec2 p;
  double heading_rad;
};

// What the edges of two neighbouring arms ask of the corner curve between them.
struct CornerEnds {
  Node from, to;
  CornerEnds(const JunctionArm& arm, const JunctionArm& next)
      : from{cut_point_m(arm, arm.right_m), arm.heading_rad},
        to{cut_point_m(next, next.left_m), next.heading_rad + kPi} {}
};

// The angle from the direction of travel to the straight way to q.
double chord_angle(const Node& node, glm::dvec2 q) {
  const glm::dvec2 d = q - node.p;
  return wrapped(std::atan2(d.y, d.x) - node.heading_rad);
}

// Appends the nodes after the first of the circular arc from a node to a point. By headings and chords, so that a
// straight is an arc like any other.
void append_arc(std::vector<Node>& nodes, glm::dvec2 end) {
  const Node start = nodes.back();
  const double half_turn = chord_angle(start, end), length = glm::length(end - start.p);
  const int pieces = std::max(1, static_cast<int>(std::ceil(2 * std::abs(half_turn) / kGreatestTurn_rad - kTurnOver)));
  const double turn = 2 * half_turn / pieces;
  const double chord = pieces == 1 ? length : length * std::sin(turn / 2) / std::sin(half_turn);
  for (int i = 1; i < pieces; ++i) {
    const Node& last = nodes.back();
    nodes.push_back({last.p + chord * direction(last.heading_rad + turn / 2), start.heading_rad + i * turn});
  }
  nodes.push_back({end, start.heading_rad + 2 * half_turn});
}

// The joint of the biarc between two nodes, with tangents of equal length on both sides.
// Source: K. Bolton, Biarc curves, 1975. None where the curve would have to turn back on itself.
std::optional<glm::dvec2> biarc_joint(const Node& from, const Node& to) {
  const glm::dvec2 v = to.p - from.p, p = direction(from.heading_rad), q = direction(to.heading_rad);
  const double b = glm::dot(v, p + q), c = 2 * (1 - glm::dot(p, q)), square = glm::dot(v, v);
  const double root = std::sqrt(b * b + c * square);
  const double tangent = b > 0 ? square / (b + root) : (root - b) / c;
  if (!(tangent > 0) || !(tangent < 1e3 * std::sqrt(square))) return std::nullopt;
  return 0.5 * (from.p + tangent * p + to.p - tangent * q);
}

// Radius of the arc from a node to a point.
double arc_radius(const Node& node, glm::dvec2 end) {
  return 0.5 * glm::length(end - node.p) / std::abs(std::sin(chord_angle(node, end)));
}

struct Curve {
  std::vector<Node> nodes;
  double least_radius_m = 0;
};

// One cubic where the way is nearly straight, otherwise two arcs. Appended to nodes, whose last one is its start.
bool append_curve(Curve& curve, const Node& to) {
  const Node from = curve.nodes.back();
  const double leave = chord_angle(from, to.p), arrive = wrapped(chord_angle({from.p, to.heading_rad}, to.p));
  if (std::max(std::abs(leave), std::abs(arrive)) <= kGreatestTurn_rad / 2) {
    const double bend =
        4 * std::max(std::abs(leave), std::abs(arrive)) + 2 * std::min(std::abs(leave), std::abs(arrive));
    curve.least_radius_m = glm::length(to.p - from.p) / bend;
    curve.nodes.push_back(to);
    return true;
  }
  const auto joint = biarc_joint(from, to);
  if (!joint) return false;
  curve.least_radius_m = arc_radius(from, *joint);
  append_arc(curve.nodes, *joint);
  curve.least_radius_m = std::min(curve.least_radius_m, arc_radius(curve.nodes.back(), to.p));
  append_arc(curve.nodes, to.p);
  // The same direction as it is given, to the bit, so that the arm's edge goes straight on.
  curve.nodes.back() = to;
  return true;
}

// Straight, arc of the given radius or the greatest that fits, straight. None where the edges do not meet ahead
// of both cuts.
std::optional<Curve> bend_curve(const CornerEnds& ends, double radius_m) {
  const glm::dvec2 p = direction(ends.from.heading_rad), q = direction(ends.to.heading_rad);
  const double turn = std::abs(wrapped(ends.to.heading_rad - ends.from.heading_rad));
  const double sine = cross(p, q);
  if (std::abs(sine) < 1e-3) return std::nullopt;
  const glm::dvec2 v = ends.to.p - ends.from.p;
  const double ahead = cross(v, q) / sine, behind = cross(p, v) / sine;
  const double tangent = std::min({radius_m * std::tan(turn / 2), ahead, behind});
  if (!(tangent > 0)) return std::nullopt;
  Curve curve;
  curve.nodes.push_back(ends.from);
  if (ahead - tangent > kLeastStraight_m) {
    curve.nodes.push_back({ends.from.p + (ahead - tangent) * p, ends.from.heading_rad});
  }
  const bool straight_on = behind - tangent > kLeastStraight_m;
  const Node arrival = straight_on ? Node{ends.to.p - (behind - tangent) * q, ends.to.heading_rad} : ends.to;
  const auto is_whole = [](double straight) { return straight > kLeastStraight_m || straight < kNoStraight_m; };
  if (is_whole(ahead - tangent) && is_whole(behind - tangent)) {
    append_arc(curve.nodes, arrival.p);
    curve.nodes.back() = arrival;
  } else if (!append_curve(curve, arrival)) {
    return std::nullopt;
  }
  if (straight_on) curve.nodes.push_back(ends.to);
  curve.least_radius_m = tangent / std::tan(turn / 2);
  return curve;
}

// The curve of a corner. None where there is none.
std::optional<Curve> corner_curve(const JunctionArm& arm, const JunctionArm& next, double radius_m) {
  const CornerEnds ends(arm, next);
  const double turn = wrapped(ends.to.heading_rad - ends.from.heading_rad);
  // On the outside of a bend the radius is that of the inside and the carriageway's width.
  if (turn > 0) radius_m += std::max(arm.left_m - arm.right_m, next.left_m - next.right_m);
  std::optional<Curve> bend;
  if (std::abs(turn) > kBend_rad) bend = bend_curve(ends, radius_m);
  if (bend && bend->least_radius_m >= std::min(radius_m, 1.0)) return bend;
  Curve free;
  free.nodes.push_back(ends.from);
  if (!append_curve(free, ends.to)) return bend;
  return bend && bend->least_radius_m >= free.least_radius_m ? bend : free;
}

// Height of the arm's edge continued as a plane by grade and tilt, and its gradient.
struct Plane {
  double z;
  glm::dvec2 gradient;
};
Plane edge_plane(const JunctionArm& arm, double edge_m, glm::dvec2 p) {
  const glm::dvec2 d = direction(arm.heading_rad);
  const glm::dvec2 gradient = d * arm.grade + left_of(d) * arm.tilt;
  return {cut_height_m(arm, edge_m) + glm::dot(gradient, p - cut_point_m(arm, edge_m)), gradient};
}

// Height, slope along and planar slope to the left at part t of a corner of the given length: the planes of both arms,
// mixed by smoothstep, so that one plane under both is kept and either end is the arm's own.
struct CornerProfile {
  double z, along, left;
};
CornerProfile corner_profile(const JunctionArm& arm, const JunctionArm& next, glm::dvec2 p, double heading_rad,
                             double t, double length_m) {
  const Plane a = edge_plane(arm, arm.right_m, p), b = edge_plane(next, next.left_m, p);
  const double h = t * t * (3 - 2 * t), dh = 6 * t * (1 - t) / length_m;
  const glm::dvec2 gradient = glm::mix(a.gradient, b.gradient, h), d = direction(heading_rad);
  return {a.z + h * (b.z - a.z), glm::dot(gradient, d) + dh * (b.z - a.z), glm::dot(gradient, left_of(d))};
}

std::vector<Segment> corner_segments(const JunctionArm& arm, const JunctionArm& next, const std::vector<Node>& nodes) {
  std::vector<Segment> segments;
  segments.reserve(nodes.size() - 1);
  double length = 0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double band = std::min(kMappedBand_m, 0.2 * glm::length(nodes[i + 1].p - nodes[i].p));
    segments.push_back(make_segment(nodes[i].p, nodes[i + 1].p, nodes[i].heading_rad, nodes[i + 1].heading_rad, band));
    segments.back().s_start_m = length;
    length += segments.back().arc_m;
  }
  const auto profile = [&](std::size_t i) {
    const double s = i < segments.size() ? segments[i].s_start_m : length;
    return corner_profile(arm, next, nodes[i].p, nodes[i].heading_rad, s / length, length);
  };
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const CornerProfile a = profile(i), b = profile(i + 1);
    segments[i].elevation_m = Cubic::hermite(a.z, a.along, b.z, b.along, segments[i].arc_m);
  }
  return segments;
}

// Whether two straights have a point in common. The boxes come first: of straights on one line, rounding may tell anything.
bool meet(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, glm::dvec2 d) {
  const glm::dvec2 low = glm::max(glm::min(a, b), glm::min(c, d)), high = glm::min(glm::max(a, b), glm::max(c, d));
  if (low.x > high.x || low.y > high.y) return false;
  const auto side = [](glm::dvec2 p, glm::dvec2 q, glm::dvec2 r) { return cross(q - p, r - p); };
  return side(c, d, a) * side(c, d, b) <= 0 && side(a, b, c) * side(a, b, d) <= 0;
}

// Counter-clockwise about the arms' middle, each arm looked at from a little way up its road: arms that start at one
// place are told apart by their directions.
void sort_arms(std::vector<JunctionArm>& arms) {
  const auto middle = [](const JunctionArm& a) { return cut_point_m(a, 0.5 * (a.left_m + a.right_m)); };
  glm::dvec2 center(0, 0);
  for (const JunctionArm& a : arms) center += middle(a) / static_cast<double>(arms.size());
  double reach = 0;
  for (const JunctionArm& a : arms) reach = std::max(reach, glm::length(middle(a) - center) + a.left_m - a.right_m);
  const auto bearing = [&](const JunctionArm& a) {
    const glm::dvec2 d = middle(a) - reach * direction(a.heading_rad) - center;
    return std::atan2(d.y, d.x);
  };
  std::stable_sort(arms.begin(), arms.end(),
                   [&](const JunctionArm& a, const JunctionArm& b) { return bearing(a) < bearing(b); });
}

// What is wrong with the arms themselves; empty where nothing is.
std::string arms_fault(const std::vector<JunctionArm>& arms) {
  if (arms.size() < 2) return "has " + std::to_string(arms.size()) + " arm" + (arms.empty() ? "s" : "") + ", needs two";
  for (const JunctionArm& a : arms) {
    if (!is_finite(a)) return name_of(a) + ": a number is not finite";
    if (!(a.left_m >= 0 && a.right_m <= 0 && a.left_m - a.right_m > 1e-3)) {
      return name_of(a) + ": the carriageway's edges must lie left and right of the reference line";
    }
  }
  std::vector<glm::dvec2> left, right;  // ends of the cuts
  for (const JunctionArm& a : arms) {
    left.push_back(cut_point_m(a, a.left_m));
    right.push_back(cut_point_m(a, a.right_m));
  }
  for (std::size_t i = 0; i < arms.size(); ++i) {
    for (std::size_t j = i + 1; j < arms.size(); ++j) {
      if (meet(left[i], right[i], left[j], right[j])) {
        return "the ends of " + name_of(arms[i]) + " and " + name_of(arms[j]) + " overlap: shorten one of them";
      }
    }
  }
  return {};
}

// Why no area came about: an arm that has all others behind it, or else what was found.
std::string explained(const std::vector<JunctionArm>& arms, const std::string& found) {
  for (const JunctionArm& a : arms) {
    const bool is_lost = std::all_of(arms.begin(), arms.end(), [&](const JunctionArm& b) {
      return glm::dot(direction(a.heading_rad), b.position_m - a.position_m) <= 0;
    });
    if (is_lost) return name_of(a) + " points away from the other arms";
  }
  return found;
}

// The boundary as a polygon, counter-clockwise for a sound junction; owner[k]: the arm whose cut or corner edge k is.
struct Outline {
  std::vector<glm::dvec2> points;
  std::vector<std::size_t> owner;
};
Outline outline(const Junction& junction) {
  constexpr int kSteps = 8;
  Outline o;
  for (std::size_t i = 0; i < junction.corners.size(); ++i) {
    o.points.push_back(cut_point_m(junction.arms[i], junction.arms[i].left_m));
    o.owner.push_back(i);
    for (const Segment& s : junction.corners[i]) {
      const int steps = s.slope_start == 0 && s.slope_end == 0 ? 1 : kSteps;
      for (int k = 0; k < steps; ++k) {
        o.points.push_back(position_m(s, static_cast<double>(k) / steps));
        o.owner.push_back(i);
      }
    }
  }
  return o;
}

// What is wrong with the boundary as a whole.
std::string outline_fault(const Junction& junction) {
  Outline o = outline(junction);
  const std::size_t n = o.points.size();
  o.points.push_back(o.points.front());
  const std::vector<glm::dvec2>& point = o.points;
  // Runs of edges first, by their boxes; then an edge against those of a run whose box it touches.
  constexpr std::size_t kRun = 8;
  struct Box {
    glm::dvec2 low{1e300, 1e300}, high{-1e300, -1e300};
    bool touches(const Box& other) const {
      return low.x <= other.high.x && low.y <= other.high.y && high.x >= other.low.x && high.y >= other.low.y;
    }
  };
  std::vector<Box> boxes((n + kRun - 1) / kRun);
  for (std::size_t i = 0; i < n; ++i) {
    Box& box = boxes[i / kRun];
    box.low = glm::min(box.low, glm::min(point[i], point[i + 1]));
    box.high = glm::max(box.high, glm::max(point[i], point[i + 1]));
  }
  const auto fault_between = [&](std::size_t i, std::size_t run) -> std::string {
    const Box edge{glm::min(point[i], point[i + 1]), glm::max(point[i], point[i + 1])};
    if (!edge.touches(boxes[run])) return {};
    for (std::size_t j = std::max(i + 2, run * kRun); j < std::min(n, (run + 1) * kRun); ++j) {
      if (i == 0 && j == n - 1) continue;  // neighbours
      if (!meet(point[i], point[i + 1], point[j], point[j + 1])) continue;
      const JunctionArm &a = junction.arms[o.owner[i]], &b = junction.arms[o.owner[j]];
      return explained(junction.arms, "the area's edges cross at " + name_of(a) +
                                          (&a == &b ? "" : " and " + name_of(b)) +
                                          ": move the ends apart or turn them toward one another");
    }
    return {};
  };
  for (std::size_t from = 0; from < boxes.size(); ++from) {
    for (std::size_t to = from; to < boxes.size(); ++to) {
      if (!boxes[from].touches(boxes[to])) continue;
      for (std::size_t i = from * kRun; i < std::min(n, (from + 1) * kRun); ++i) {
        if (std::string fault = fault_between(i, to); !fault.empty()) return fault;
      }
    }
  }
  double area = 0;
  for (std::size_t i = 0; i < n; ++i) area += 0.5 * cross(point[i] - point[0], point[i + 1] - point[0]);
  if (area > 0) return {};
  return explained(junction.arms, "the area of " + name_of(junction.arms[0]) + " and " + name_of(junction.arms[1]) +
                                      " runs clockwise: turn them toward one another");
}

// The gap between where a curve is and where it ought to be; empty within the limits of problems().
std::string gap(glm::dvec2 p, double heading, double z, double grade, glm::dvec2 p_due, double heading_due,
                double z_due, double grade_due, double shortest_m) {
  char text[64];
  const double size = std::max({std::abs(p.x), std::abs(p.y), 1.0});
  const auto found = [&](const char* what, double x, double limit) {
    if (x <= limit) return false;
    std::snprintf(text, sizeof text, what, x);
    return true;
  };
  if (found("position gap of %.3g m", glm::length(p - p_due), 1e-9 + 1e-15 * size) ||
      found("heading gap of %.3g rad", std::abs(wrapped(heading - heading_due)), 1e-9 + 1e-15 * size / shortest_m) ||
      found("elevation gap of %.3g m", std::abs(z - z_due), 1e-6) ||
      found("grade gap of %.3g", std::abs(grade - grade_due), 1e-6)) {
    return text;
  }
  return {};
}

bool is_sound(const Segment& s) {
  const double sum = s.start_m.x + s.start_m.y + s.end_m.x + s.end_m.y + s.slope_start + s.slope_end + s.arc_m +
                     s.elevation_m.c0 + s.elevation_m.c1 + s.elevation_m.c2 + s.elevation_m.c3;
  return std::isfinite(sum) && s.start_m != s.end_m && s.arc_m > 0;
}

// Faults of one corner curve: of its pieces, at its joints, and against the arms at both ends.
void check_corner(const Junction& junction, std::size_t i, std::vector<std::string>& found) {
  const std::vector<Segment>& pieces = junction.corners[i];
  const JunctionArm &arm = junction.arms[i], &next = junction.arms[(i + 1) % junction.arms.size()];
  const auto add = [&](const std::string& fault) {
    if (fault.empty()) return;
    found.push_back("junction " + junction.id + ": corner from " + name_of(arm) + " to " + name_of(next) + ": " +
                    fault);
  };
  if (pieces.empty() || !std::all_of(pieces.begin(), pieces.end(), is_sound)) {
    return add(pieces.empty() ? "no pieces" : "a piece has no length or is not finite");
  }
  const Segment &first = pieces.front(), &last = pieces.back();
  add(gap(first.start_m, heading_rad(first, 0), first.elevation_m.value(0), first.elevation_m.slope(0),
          cut_point_m(arm, arm.right_m), arm.heading_rad, cut_height_m(arm, arm.right_m), arm.grade,
          first.chord_length_m()));
  add(gap(last.end_m, heading_rad(last, 1), last.elevation_m.value(last.arc_m), last.elevation_m.slope(last.arc_m),
          cut_point_m(next, next.left_m), next.heading_rad + kPi, cut_height_m(next, next.left_m), -next.grade,
          last.chord_length_m()));
  for (std::size_t k = 0; k + 1 < pieces.size(); ++k) {
    const Segment &a = pieces[k], &b = pieces[k + 1];
    add(gap(a.end_m, heading_rad(a, 1), a.elevation_m.value(a.arc_m), a.elevation_m.slope(a.arc_m), b.start_m,
            heading_rad(b, 0), b.elevation_m.value(0), b.elevation_m.slope(0),
            std::min(a.chord_length_m(), b.chord_length_m())));
  }
}

Lib::JunctionCut surface_cut(const JunctionArm& arm, glm::dvec3 center_m) {
  const glm::dvec2 left = cut_point_m(arm, arm.left_m) - glm::dvec2(center_m);
  const glm::dvec2 right = cut_point_m(arm, arm.right_m) - glm::dvec2(center_m);
  return {left.x,
          left.y,
          right.x,
          right.y,
          arm.left_m,
          arm.right_m,
          arm.elevation_m - center_m.z,
          arm.grade,
          arm.tilt,
          arm.crossfall_left,
          arm.crossfall_right};
}

// A piece of a corner of the given length, from start to end.
Lib::JunctionCorner surface_corner(const Segment& s, const JunctionArm& arm, const JunctionArm& next, double length_m,
                                   glm::dvec2 start, glm::dvec2 finish, double center_z_m) {
  struct End {
    double along, across, fall;
  };
  const glm::dvec2 axis = glm::normalize(s.chord_m());
  const auto end = [&](double u) {
    const double heading = heading_rad(s, u), local = u * s.arc_m, t = (s.s_start_m + local) / length_m;
    const CornerProfile profile = corner_profile(arm, next, position_m(s, u), heading, t, length_m);
    const glm::dvec2 d = direction(heading);
    const glm::dvec2 gradient = d * s.elevation_m.slope(local) + left_of(d) * profile.left;
    const double fall = arm.crossfall_right + t * t * (3 - 2 * t) * (next.crossfall_left - arm.crossfall_right);
    return End{glm::dot(gradient, axis), cross(axis, gradient), fall * glm::dot(d, axis)};
  };
  const End from = end(0), to = end(1);
  const Cubic& z = s.elevation_m;
  return {start.x,     start.y,  finish.y,  s.chord_length_m(), axis.x, axis.y, s.slope_start, s.slope_end,
          s.arc_m,     s.arc_c0, s.arc_c1,  z.c0 - center_z_m,  z.c1,   z.c2,   z.c3,          from.along,
          from.across, to.along, to.across, from.fall,          to.fall};
}

// Inline, so that the slopes cost nothing where they are not asked for.
[[gnu::always_inline]] inline Lib::JunctionHeight local_height(const JunctionSurface& surface, glm::dvec2 p) {
  Lib::JunctionHeight h = Lib::junction_height_begin();
  for (const auto& cut : surface.cuts) h = Lib::junction_height_add_cut(h, p.x, p.y, cut);
  for (const auto& corner : surface.corners) h = Lib::junction_height_add_corner(h, p.x, p.y, corner);
  return h;
}

double local_distance(const JunctionSurface& surface, glm::dvec2 p, double most_m = 1e6) {
  Lib::JunctionSide side = Lib::junction_side_begin();
  side.corner = most_m;
  for (const auto& cut : surface.cuts) side = Lib::junction_side_add_cut(side, p.x, p.y, cut);
  for (const auto& corner : surface.corners) side = Lib::junction_side_add_corner(side, p.x, p.y, corner);
  return Lib::junction_distance(side);
}

// Fills x and y of low_m and high_m.
void bound_outline(const Junction& junction, JunctionSurface& surface) {
  glm::dvec2 low(1e300), high(-1e300);
  const auto add = [&](glm::dvec2 p) {
    low = glm::min(low, p - glm::dvec2(surface.center_m));
    high = glm::max(high, p - glm::dvec2(surface.center_m));
  };
  for (std::size_t i = 0; i < junction.arms.size(); ++i) {
    add(cut_point_m(junction.arms[i], junction.arms[i].left_m));
    for (const Segment& s : junction.corners[i]) {
      // The curve lies within its chord's box, widened by the extrema of f.
      const Cubic::Range f = curve_range(s.slope_start, s.slope_end);
      for (const double x : {0.0, 1.0}) add(from_chord(s, {x, f.low})), add(from_chord(s, {x, f.high}));
    }
  }
  surface.low_m = glm::dvec3(low, 0);
  surface.high_m = glm::dvec3(high, 0);
}

// Fills z of low_m and high_m, plane, slope_spread and plane_gap_m from a grid of samples.
void measure(JunctionSurface& surface) {
  const glm::dvec2 low(surface.low_m), high(surface.high_m);
  constexpr int kSide = 40;
  const glm::dvec2 step = (high - low) / static_cast<double>(kSide);
  std::vector<Lib::JunctionHeight> samples;
  std::vector<glm::dvec2> places;
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      const glm::dvec2 p = low + step * glm::dvec2(i, j);
      if (local_distance(surface, p) < -glm::length(step)) continue;
      samples.push_back(local_height(surface, p));
      places.push_back(p);
    }
  }
  glm::dvec2 gradient(0, 0);
  for (const auto& h : samples) gradient += glm::dvec2(h.zx, h.zy) / static_cast<double>(samples.size());
  double z_low = 1e300, z_high = -1e300, steepest = 0, offset = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const glm::dvec2 slope(samples[i].zx, samples[i].zy);
    z_low = std::min(z_low, samples[i].z);
    z_high = std::max(z_high, samples[i].z);
    steepest = std::max(steepest, glm::length(slope));
    surface.slope_spread = std::max(surface.slope_spread, glm::length(slope - gradient));
    offset += (samples[i].z - glm::dot(gradient, places[i])) / static_cast<double>(samples.size());
  }
  surface.plane = glm::dvec3(gradient, offset);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double gap = samples[i].z - glm::dot(gradient, places[i]) - offset;
    surface.plane_gap_m = std::max(surface.plane_gap_m, std::abs(gap));
  }
  const double pad = steepest * 0.5 * glm::length(step) + 1e-3;
  surface.plane_gap_m += pad;
  surface.low_m = glm::dvec3(low, z_low - pad);
  surface.high_m = glm::dvec3(high, z_high + pad);
}

}  // namespace

glm::dvec2 cut_point_m(const JunctionArm& arm, double n_m) {
  return arm.position_m + n_m * left_of(direction(arm.heading_rad));
}

double cut_height_m(const JunctionArm& arm, double n_m) {
  return arm.elevation_m + n_m * arm.tilt - (n_m > 0 ? n_m * arm.crossfall_left : -n_m * arm.crossfall_right);
}

Result<Junction> make_junction(std::string id, std::vector<JunctionArm> arms, const JunctionOptions& options,
                               Diagnostics* diagnostics) {
  const auto fail = [&](const std::string& what) {
    return Error{ErrorCode::kGeometry, "junction " + id + ": " + what};
  };
  if (!(options.corner_radius_m >= kLeastCornerRadius_m) || !std::isfinite(options.corner_radius_m)) {
    return fail("the corner radius must be at least " + metres(kLeastCornerRadius_m));
  }
  if (const std::string fault = arms_fault(arms); !fault.empty()) return fail(fault);
  sort_arms(arms);
  Junction junction{id, std::move(arms), {}, options.corner_radius_m};
  for (std::size_t i = 0; i < junction.arms.size(); ++i) {
    const JunctionArm &arm = junction.arms[i], &next = junction.arms[(i + 1) % junction.arms.size()];
    const std::string between = "between " + name_of(arm) + " and " + name_of(next);
    const auto curve = corner_curve(arm, next, options.corner_radius_m);
    if (!curve || curve->least_radius_m < kLeastCornerRadius_m) {
      return fail(explained(
          junction.arms, "no corner curve fits " + between + ": shorten one of them or turn them toward one another"));
    }
    const bool is_kerb = wrapped(next.heading_rad + kPi - arm.heading_rad) < -kBend_rad;
    if (diagnostics && is_kerb && curve->least_radius_m < options.corner_radius_m * (1 - 1e-9)) {
      diagnostics->push_back({Severity::kInfo,
                              "the corner " + between + " has radius " + metres(curve->least_radius_m) +
                                  " instead of " + metres(options.corner_radius_m) + ": no more fits",
                              {},
                              0,
                              "junction " + id});
    }
    junction.corners.push_back(corner_segments(arm, next, curve->nodes));
  }
  if (const auto found = problems(junction); !found.empty()) {
    return Error{ErrorCode::kGeometry, found.front()};
  }
  return junction;
}

std::vector<std::string> problems(const Junction& junction) {
  const std::string name = "junction " + junction.id + ": ";
  if (const std::string fault = arms_fault(junction.arms); !fault.empty()) return {name + fault};
  if (junction.corners.size() != junction.arms.size()) return {name + "needs as many corners as arms"};
  std::vector<std::string> found;
  for (std::size_t i = 0; i < junction.corners.size(); ++i) check_corner(junction, i, found);
  if (!found.empty()) return found;
  if (const std::string fault = outline_fault(junction); !fault.empty()) return {name + fault};
  return {};
}

JunctionSurface junction_surface(const Junction& junction) {
  JunctionSurface surface = junction_pieces(junction);
  measure(surface);
  return surface;
}

JunctionSurface junction_pieces(const Junction& junction) {
  JunctionSurface surface;
  const std::size_t n = junction.arms.size();
  for (const JunctionArm& arm : junction.arms) {
    surface.center_m += glm::dvec3(arm.position_m, arm.elevation_m) / static_cast<double>(n);
  }
  for (const JunctionArm& arm : junction.arms) surface.cuts.push_back(surface_cut(arm, surface.center_m));
  for (std::size_t i = 0; i < n; ++i) {
    const std::vector<Segment>& corner = junction.corners[i];
    const Lib::JunctionCut &cut = surface.cuts[i], &next = surface.cuts[(i + 1) % n];
    const double length_m = corner.back().s_start_m + corner.back().arc_m;
    // Neighbours share their ends to the bit, for the test of what is inside.
    glm::dvec2 start(cut.x1, cut.y1);
    for (const Segment& s : corner) {
      const bool is_last = &s == &corner.back();
      const glm::dvec2 end = is_last ? glm::dvec2(next.x0, next.y0) : s.end_m - glm::dvec2(surface.center_m);
      surface.corners.push_back(
          surface_corner(s, junction.arms[i], junction.arms[(i + 1) % n], length_m, start, end, surface.center_m.z));
      start = end;
    }
  }
  bound_outline(junction, surface);
  return surface;
}

double signed_distance_m(const JunctionSurface& surface, glm::dvec2 point_m, double most_m) {
  return local_distance(surface, point_m - glm::dvec2(surface.center_m), most_m);
}

bool is_inside(const JunctionSurface& surface, glm::dvec2 point_m) {
  const glm::dvec2 p = point_m - glm::dvec2(surface.center_m);
  if (p.x < surface.low_m.x || p.y < surface.low_m.y || p.x > surface.high_m.x || p.y > surface.high_m.y) return false;
  bool inside = false;
  for (const Lib::JunctionCut& c : surface.cuts) {
    const bool on_left = (p.y - c.y0) * (c.x1 - c.x0) - (p.x - c.x0) * (c.y1 - c.y0) > 0;
    if (Lib::junction_crosses(p.y, c.y0, c.y1, on_left)) inside = !inside;
  }
  for (const Lib::JunctionCorner& c : surface.corners) {
    const glm::dvec2 d(p.x - c.x0, p.y - c.y0);
    const double px = (d.x * c.cx + d.y * c.cy) / c.chord, py = (d.y * c.cx - d.x * c.cy) / c.chord;
    if (Lib::junction_corner_crosses(p.y, px, py, c)) inside = !inside;
  }
  return inside;
}

double height_m_at(const JunctionSurface& surface, glm::dvec2 point_m) {
  return surface.center_m.z + local_height(surface, point_m - glm::dvec2(surface.center_m)).z;
}

JunctionPoint height_at(const JunctionSurface& surface, glm::dvec2 point_m) {
  const auto h = local_height(surface, point_m - glm::dvec2(surface.center_m));
  return {surface.center_m.z + h.z, {h.zx, h.zy}};
}

}  // namespace roadgen
