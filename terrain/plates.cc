#include "terrain/plates.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/road/interval.h"
#include "roadgen/road/junction.h"
#include "roadgen/road/parallel.h"
#include "terrain/clipped.h"

namespace roadgen {
namespace {

using IntervalLib = glsl::Library<Interval>;

constexpr double kLongest_m = 8, kShortest_m = 0.2;
constexpr double kJunctionPart = 2;     // of the wanted error: intervals tell less of their surface
constexpr double kEnclosurePart = 0.5;  // of that: the rest is for the squares' own planes against the plate's
constexpr int kMeanRounds = 3;
constexpr double kJunctionPlate_m = 2, kShortestJunctionPlate_m = 0.5, kFinestJunctionBox_m = 0.07;  // half its side

glm::dvec2 across(glm::dvec2 axis) { return {-axis.y, axis.x}; }

Box box_of(const Plate& plate) {
  const glm::dvec2 reach = plate.half_m.x * glm::abs(plate.axis) + plate.half_m.y * glm::abs(across(plate.axis));
  return {glm::dvec3(plate.center_m - reach, 0), glm::dvec3(plate.center_m + reach, 0)};
}

Box box_of(const std::array<glm::dvec3, 3>& triangle) {
  const auto [a, b, c] = triangle;
  return {glm::dvec3(glm::dvec2(glm::min(a, glm::min(b, c))), 0),
          glm::dvec3(glm::dvec2(glm::max(a, glm::max(b, c))), 0)};
}

Interval about(double middle, double radius) { return {middle - radius, middle + radius}; }

// A stretch of one side of a road: s from the segment's start, n to the left of the reference line.
struct Patch {
  double s0, s1, n0, n1;
  Patch part(int axis, double from, double to) const {
    Patch p = *this;
    double& low = axis == 0 ? p.s0 : p.n0;
    double& high = axis == 0 ? p.s1 : p.n1;
    const double size = high - low, start = low;
    low = start + from * size;
    high = start + to * size;
    return p;
  }
};

// The tangent of the segment where its exact arc length is within the patch's, and the bounds that rest on it.
struct Stretch {
  double u0, u1;       // of the chord parameter
  Interval df;         // slope against the chord
  Interval curvature;  // 1/m
};

Stretch stretch_of(const Segment& segment, double s0, double s1) {
  const double length = segment.chord_length_m(), a = segment.slope_start, b = segment.slope_end;
  // The segment's s is off the exact arc length by at most its arc error.
  const double room = (segment.arc_error_m + 1e-9) / length;
  Stretch st;
  st.u0 = u_at_arc(segment, s0) - room;
  st.u1 = u_at_arc(segment, s1) + room;
  const double middle = 0.5 * (st.u0 + st.u1);
  const Interval ddf = hull(Interval(Lib::road_ddf(st.u0, a, b)), Interval(Lib::road_ddf(st.u1, a, b)));  // linear
  st.df = Interval(Lib::road_df(middle, a, b)) + ddf * about(0, 0.5 * (st.u1 - st.u0));
  const Interval steep = Interval(1) + square(st.df);
  st.curvature = ddf / (steep * sqrt(steep) * Interval(length));
  return st;
}

// The surface with s counted from the middle of a stretch, where intervals about 0 keep its polynomials tight.
IntervalLib::RoadSurface surface_about(const Segment& segment, double middle_s) {
  const Cubic z = segment.elevation_m.shifted(middle_s), e = segment.superelevation_rad.shifted(middle_s);
  IntervalLib::RoadSurface r;
  r.z1 = z.c1, r.z2 = z.c2, r.z3 = z.c3;
  r.e0 = e.c0, r.e1 = e.c1, r.e2 = e.c2, r.e3 = e.c3;
  r.left0 = segment.crossfall_left.value(middle_s), r.left1 = segment.crossfall_left.c1;
  r.right0 = segment.crossfall_right.value(middle_s), r.right1 = segment.crossfall_right.c1;
  return r;
}

// The plate of a patch. The gradient of the surface is ahead / (1 - n curvature) along the tangent and aside across it;
// how far these are from the plane's, along the way from the middle of the patch to any of its points (across, then along
// the road), bounds how far the surface is from the plane. The picture's v and s are off the exact ones by their own
// proven bounds, which count with the slopes.
Plate plate_of(const Segment& segment, const Patch& p, double lowest_lane_m) {
  const double s = 0.5 * (p.s0 + p.s1), n = 0.5 * (p.n0 + p.n1);
  const double half_s = 0.5 * (p.s1 - p.s0), half_n = 0.5 * (p.n1 - p.n0);
  const Stretch st = stretch_of(segment, p.s0, p.s1);
  const Interval side(p.n0, p.n1);
  const IntervalLib::SurfaceSlope slope = IntervalLib::surface_at(about(0, half_s), side, surface_about(segment, s));
  Interval room = Interval(1) - side * st.curvature;
  room.low = std::max(room.low, 0.05);  // narrower roads are refused; the shader keeps as much
  room.high = std::max(room.high, room.low);
  const Interval ahead = slope.ahead / room;
  const double length = segment.chord_length_m();
  const glm::dvec2 chord = segment.chord_m() / length;
  const auto place = [&](double u, double offset) {
    const double df = Lib::road_df(u, segment.slope_start, segment.slope_end), h = std::sqrt(1 + df * df);
    const glm::dvec2 q = glm::dvec2(u, Lib::road_f(u, segment.slope_start, segment.slope_end)) * length +
                         glm::dvec2(-df, 1) * (offset / h);
    return segment.start_m + chord * q.x + across(chord) * q.y;
  };
  Plate plate;
  const double middle_u = u_at_arc(segment, s);
  const double df = Lib::road_df(middle_u, segment.slope_start, segment.slope_end), h = std::sqrt(1 + df * df);
  plate.axis = (chord + across(chord) * df) / h;
  // The rectangle about the four corners; between them the offset curves bend away from their chords by at most their
  // length times what they turn by.
  const double along_m = 2 * half_s * room.high;
  const double bow = along_m * (st.df.high - st.df.low) + 2 * segment.arc_error_m + 1e-6;
  glm::dvec2 low(1e300), high(-1e300);
  const glm::dvec2 pivot = place(middle_u, n);
  for (const double u : {st.u0, st.u1}) {
    for (const double offset : {p.n0, p.n1}) {
      const glm::dvec2 d = place(u, offset) - pivot;
      const glm::dvec2 q(glm::dot(d, plate.axis), glm::dot(d, across(plate.axis)));
      low = glm::min(low, q - bow);
      high = glm::max(high, q + bow);
    }
  }
  const glm::dvec2 shift = 0.5 * (low + high);
  plate.half_m = 0.5 * (high - low);
  plate.center_m = pivot + shift.x * plate.axis + shift.y * across(plate.axis);

  // The plane has the surface's gradient in the middle of what it may be; axis and across are its frame there.
  plate.slope = {ahead.middle(), slope.aside.middle()};
  plate.z_m = surface_at(segment, s, n).height + glm::dot(plate.slope, shift) + lowest_lane_m;
  // The tangent's direction in that frame.
  const Interval tx = Interval(1) / sqrt(Interval(1) + square(st.df)), ty = st.df * tx;
  const Interval along = Interval(1 / h) * (tx + Interval(df) * ty), aside = Interval(1 / h) * (ty - Interval(df) * tx);
  const Interval off_along = ahead - (Interval(plate.slope.x) * along + Interval(plate.slope.y) * aside);
  const Interval off_aside = slope.aside - (Interval(plate.slope.y) * along - Interval(plate.slope.x) * aside);
  plate.error_m = off_along.magnitude() * half_s * room.high + off_aside.magnitude() * half_n +
                  slope.ahead.magnitude() * (segment.s_bound_m() + 2 * segment.arc_error_m) +
                  slope.aside.magnitude() * segment.v_bound_m() + 1e-9;
  return plate;
}

void add_divided(const Segment& segment, const Patch& p, double lowest_lane_m, double wanted_m,
                 std::vector<Plate>& plates) {
  const Plate plate = plate_of(segment, p, lowest_lane_m);
  const double along = p.s1 - p.s0, wide = p.n1 - p.n0;
  const bool divide = along > kLongest_m || plate.error_m > wanted_m || plate.half_m.x > along;
  if (!divide || std::max(along, wide) < kShortest_m) {
    plates.push_back(plate);
    return;
  }
  const int axis = along >= wide ? 0 : 1;
  add_divided(segment, p.part(axis, 0, 0.5), lowest_lane_m, wanted_m, plates);
  add_divided(segment, p.part(axis, 0.5, 1), lowest_lane_m, wanted_m, plates);
}

void add_part(const Segment& segment, const SupportedPart& part, double lowest_m, double wanted_m,
              std::vector<Plate>& plates) {
  const Cubic::Range left = segment.left_m.range(segment.arc_m), right = segment.right_m.range(segment.arc_m);
  // n = t cos(superelevation) lies between t and 0.
  const double n1 = std::max(left.high, 0.0), n0 = std::min(right.low, 0.0);
  const double s1 = std::min(part.s1_m, segment.arc_m);
  const std::size_t first = plates.size();
  if (n1 > 0) add_divided(segment, {part.s0_m, s1, 0, n1}, lowest_m, wanted_m, plates);
  if (n0 < 0) add_divided(segment, {part.s0_m, s1, n0, 0}, lowest_m, wanted_m, plates);
  for (std::size_t i = first; i < plates.size(); ++i) plates[i].set_support(part.support, part.is_assumed);
}

// One piece of a junction's surface over a small square: its weight, and how far it is from a plane.
struct Piece {
  Interval weight;
  Interval pull_x, pull_y;  // the weight's gradient by the weight
  double weight_at = 0;     // at the middle
  double off_at = 0;        // height over the plane there
  Interval tilt_x, tilt_y;  // difference of the gradients
  double slope() const { return std::hypot(tilt_x.magnitude(), tilt_y.magnitude()); }
};

// x / (x^2 + rest), rest > 0: x but once where it is not 0.
Interval part_of_sum(Interval x, Interval rest) {
  return x.holds(0) ? x / (square(x) + rest) : Interval(1) / (x + rest / x);
}

// plane: height at the square's middle, and gradient. x, y from the junction's centre.
Piece piece_of(const Lib::JunctionCut& c, glm::dvec2 middle, double half, glm::dvec3 plane) {
  const double width = c.left - c.right, nx = (c.x0 - c.x1) / width, ny = (c.y0 - c.y1) / width;
  const double reach = half * (std::abs(nx) + std::abs(ny));
  const Interval ahead = about((middle.x - c.x1) * ny - (middle.y - c.y1) * nx, reach);
  const Interval n = about((middle.x - c.x1) * nx + (middle.y - c.y1) * ny + c.right, reach);
  const Interval beyond(n.low - std::clamp(n.low, c.right, c.left), n.high - std::clamp(n.high, c.right, c.left));
  Piece piece;
  const Interval room = square(ahead) + square(beyond) + Interval(1e-6);
  piece.weight = Interval(width) / room;
  const bool is_beside = n.low >= c.right && n.high <= c.left;
  const Interval by_ahead = Interval(-2) * part_of_sum(ahead, square(beyond) + Interval(1e-6));
  const Interval by_n = is_beside ? Interval(0) : Interval(-2) * part_of_sum(beyond, square(ahead) + Interval(1e-6));
  piece.pull_x = by_ahead * Interval(ny) + by_n * Interval(nx);
  piece.pull_y = by_n * Interval(ny) - by_ahead * Interval(nx);
  Interval z_ahead = c.grade, z_n = c.tilt;
  if (c.fall_left != 0 || c.fall_right != 0) {
    const double both = c.fall_left + c.fall_right;
    const Interval soft = square(ahead) / Interval(width), hair = square(soft) + Interval(1e-12);
    const Interval at_right = sqrt(square(n - Interval(c.right)) + hair), at_middle = sqrt(square(n) + hair);
    const Interval at_left = sqrt(square(n - Interval(c.left)) + hair);
    // x / sqrt(x^2 + h) and soft / sqrt(x^2 + soft^2) lie within [-1, 1], whatever intervals make of them.
    const auto part = [](Interval x, Interval root) { return clamp(x / root, -1, 1); };
    z_n = z_n + Interval(0.5) *
                    (Interval(c.fall_right) * part(n - Interval(c.right), at_right) -
                     Interval(both) * part(n, at_middle) + Interval(c.fall_left) * part(n - Interval(c.left), at_left));
    z_ahead = z_ahead + Interval(1 / width) * ahead *
                            (Interval(c.fall_right) * part(soft, at_right) - Interval(both) * part(soft, at_middle) +
                             Interval(c.fall_left) * part(soft, at_left));
  }
  piece.tilt_x = z_ahead * Interval(ny) + z_n * Interval(nx) - Interval(plane.x);
  piece.tilt_y = z_n * Interval(ny) - z_ahead * Interval(nx) - Interval(plane.y);
  const Lib::JunctionHeight at = Lib::junction_height_add_cut(Lib::junction_height_begin(), middle.x, middle.y, c);
  piece.weight_at = at.w;
  piece.off_at = at.z - plane.z;
  return piece;
}

// A corner's rise along its curve less that of a plane, by its chord parameter, over equal parts of [0, 1]. The curve turns,
// so the rise of either changes a lot along it; the difference hardly does where the corner lies near the plane.
struct CornerRise {
  glm::dvec2 plane{0, 0};  // slopes along the chord and to its left
  std::array<Interval, 32> rise;

  CornerRise(const Lib::JunctionCorner& c, glm::dvec3 around) {
    plane = {around.x * c.cx + around.y * c.cy, around.y * c.cx - around.x * c.cy};
    constexpr int kFine = 16;  // of each part
    const double step = 1 / static_cast<double>(kFine * rise.size());
    for (std::size_t i = 0; i < rise.size(); ++i) {
      for (int k = 0; k < kFine; ++k) {
        const double u = step * static_cast<double>(kFine * i + static_cast<std::size_t>(k));
        const Interval part(u, u + step), near = about(0, 0.5 * step);
        const double um = part.middle(), inverse = 1 / c.chord;
        const Interval darc = IntervalLib::road_darc(part, c.a, c.b, c.arc * inverse, c.c0, c.c1);
        const Interval s =
            Interval(c.chord) * (Interval(Lib::road_arc(um, c.a, c.b, c.arc * inverse, c.c0, c.c1)) + darc * near);
        const Interval df = hull(Interval(Lib::road_df(u, c.a, c.b)), Interval(Lib::road_df(u + step, c.a, c.b))) +
                            about(0, step * step * (std::abs(c.a) + std::abs(c.b)) * 3);
        const Interval here =
            IntervalLib::road_dcubic(s, c.z1, c.z2, c.z3) * darc - Interval(plane.x) - Interval(plane.y) * df;
        rise[i] = k == 0 ? here : hull(rise[i], here);
      }
    }
  }

  // Over all of u, within [0, 1].
  Interval over(Interval u) const {
    const auto part = [&](double at) {
      return std::min(static_cast<std::size_t>(at * static_cast<double>(rise.size())), rise.size() - 1);
    };
    Interval found = rise[part(u.low)];
    for (std::size_t i = part(u.low) + 1; i <= part(u.high); ++i) found = hull(found, rise[i]);
    return found;
  }
};

Piece piece_of(const Lib::JunctionCorner& c, const CornerRise& rise, glm::dvec2 middle, double half, glm::dvec3 plane) {
  const double inverse = 1 / c.chord, reach = half * (std::abs(c.cx) + std::abs(c.cy)) * inverse;
  const Interval px = about(((middle.x - c.x0) * c.cx + (middle.y - c.y0) * c.cy) * inverse, reach);
  const Interval py = about(((middle.y - c.y0) * c.cx - (middle.x - c.x0) * c.cy) * inverse, reach);
  const Interval u = clamp(px, 0, 1), du(u.low == px.low && u.high == px.high ? 1 : 0, u.high > u.low ? 1 : 0);
  const Interval over(px.low - u.low, px.high - u.high);
  const double um = u.middle();
  const Interval near = about(0, u.radius());
  const Interval ddf = hull(Interval(Lib::road_ddf(u.low, c.a, c.b)), Interval(Lib::road_ddf(u.high, c.a, c.b)));
  const Interval df = Interval(Lib::road_df(um, c.a, c.b)) + ddf * near;
  const Interval f = Interval(Lib::road_f(um, c.a, c.b)) + df * near;
  const Interval off = py - f - df * over;
  const Interval chord(c.chord), along_u = Interval(1) - du;
  const Interval t = u * u * (Interval(3) - Interval(2) * u), dt = Interval(6) * u * (Interval(1) - u) * du;
  const Interval along = Interval(c.along0) + Interval(c.along1 - c.along0) * t;
  const Interval across_it = Interval(c.across0) + Interval(c.across1 - c.across0) * t;
  // Along the chord, less the plane's: beside the curve, and how much else it is where the square is beyond an end of it.
  const Interval inside = rise.over(u) - (across_it - Interval(rise.plane.y)) * df;
  const Interval outside = along - Interval(rise.plane.x);
  Interval z_x = chord * (outside + du * (inside - outside) + Interval(c.across1 - c.across0) * dt * (py - f));
  Interval z_y = chord * (across_it - Interval(rise.plane.y));
  if (c.fall0 != 0 || c.fall1 != 0) {
    const Interval v = chord * off, level = Interval(3.5) / (Interval(3.5) + abs(v));
    const Interval fall = Interval(c.fall0) + Interval(c.fall1 - c.fall0) * t;
    z_x = z_x + Interval(c.fall1 - c.fall0) * dt * v * level - fall * square(level) * chord * df;
    z_y = z_y + fall * square(level) * chord;
  }
  Piece piece;
  const Interval room = square(chord) * (square(off) + square(over)) + Interval(1e-6);
  piece.weight = Interval(c.arc) / room;
  const Interval hair = Interval(1e-6) / square(chord);
  const Interval by_off = Interval(-2) * part_of_sum(off, square(over) + hair);
  const Interval by_over = Interval(-2) * part_of_sum(over, square(off) + hair);
  const Interval pull_px = by_over * along_u - by_off * (df + ddf * du * over);
  piece.pull_x = (pull_px * Interval(c.cx) - by_off * Interval(c.cy)) * Interval(inverse);
  piece.pull_y = (pull_px * Interval(c.cy) + by_off * Interval(c.cx)) * Interval(inverse);
  const glm::dvec2 rest(plane.x - (rise.plane.x * c.cx - rise.plane.y * c.cy),
                        plane.y - (rise.plane.x * c.cy + rise.plane.y * c.cx));
  piece.tilt_x = (z_x * Interval(c.cx) - z_y * Interval(c.cy)) * Interval(inverse) - Interval(rest.x);
  piece.tilt_y = (z_x * Interval(c.cy) + z_y * Interval(c.cx)) * Interval(inverse) - Interval(rest.y);
  const Lib::JunctionHeight at = Lib::junction_height_add_corner(Lib::junction_height_begin(), middle.x, middle.y, c);
  piece.weight_at = at.w;
  piece.off_at = at.z - plane.z;
  return piece;
}

// How far the surface may be from its tangent plane at the middle of a square, by the lesser of two bounds. The surface is
// the mean of the pieces' by their shares p, so over the plane it is the sum of p times each one's height over it, D.
//
// At the middle that is 0; so elsewhere it is the sum of (p - p at the middle) D at the middle, and of p times what D has
// changed by. That tells most near the area's boundary, where one piece has all the share.
//
// And it changes by its gradient, which is the sum of p (D's gradient + (D - the mean) times the weight's gradient by the
// weight), and 0 at the middle: half the square's size times its greatest value is of second order in the size.
double off_plane_m(const JunctionSurface& surface, const std::vector<CornerRise>& rises, glm::dvec2 middle, double half,
                   glm::dvec3 plane, std::vector<Piece>& pieces) {
  pieces.clear();
  for (const auto& cut : surface.cuts) pieces.push_back(piece_of(cut, middle, half, plane));
  for (std::size_t i = 0; i < surface.corners.size(); ++i) {
    pieces.push_back(piece_of(surface.corners[i], rises[i], middle, half, plane));
  }
  double low = 0, high = 0, at = 0;
  for (const Piece& p : pieces) low += p.weight.low, high += p.weight.high, at += p.weight_at;
  const auto share = [&](const Piece& p) {
    return Interval(p.weight.low / (p.weight.low + (high - p.weight.high)),
                    p.weight.high / (p.weight.high + (low - p.weight.low)));
  };
  double off = 0, largest = 0;
  for (const Piece& p : pieces) {
    const Interval part = share(p);
    const double now = p.weight_at / at, reach = p.slope() * std::numbers::sqrt2 * half;
    off += std::max(part.high - now, now - part.low) * std::abs(p.off_at) + part.high * reach;
    largest = std::max(largest, std::abs(p.off_at) + reach);
  }
  off = std::min(off, largest);  // no mean is beyond all its parts
  // The mean is no farther from the plane than is known of it so far: each time that is less, more is known.
  for (int round = 0; round < kMeanRounds; ++round) {
    Interval gx(0), gy(0);
    for (const Piece& p : pieces) {
      const Interval part = share(p), by_x = about(0, half);
      const Interval over = Interval(p.off_at) + p.tilt_x * by_x + p.tilt_y * by_x - about(0, off);
      gx = gx + part * (p.tilt_x + over * p.pull_x);
      gy = gy + part * (p.tilt_y + over * p.pull_y);
    }
    const double found = half * (gx.magnitude() + gy.magnitude());
    if (!(found < off)) break;
    off = found;
  }
  return off + 1e-9;
}

// The surface over a small square: its tangent plane at the middle (gradient, height), and how far it may be from that.
struct Enclosure {
  glm::dvec2 middle;
  double half;
  glm::dvec3 tangent;
  double off_m;
};

// The plates of a junction's area: of squares of kJunctionPlate_m, quartered where the surface is not flat enough and at
// the area's border, beyond which they would claim what is no road. What is proven of the smallest squares serves all
// larger ones.
class AreaPlates {
 public:
  AreaPlates(const Junction& junction, double wanted_m)
      : surface_(junction_surface(junction)), underlap_m_(junction.underlap_m), wanted_m_(wanted_m) {
    for (const Lib::JunctionCorner& corner : surface_.corners) rises_.emplace_back(corner, surface_.plane);
  }
  void add_to(std::vector<Plate>& plates);

 private:
  // A square's enclosures, [first, last); those of its quarters are nodes child to child + 3.
  struct Node {
    std::size_t first = 0, last = 0, child = 0;  // child 0: none
    bool at_border = false;
  };
  void enclose(std::size_t node, glm::dvec2 middle, double half, const Enclosure* larger = nullptr);
  void choose(std::size_t node, glm::dvec2 middle, double half, std::vector<Plate>& plates) const;
  // How far inside of the area a place is. Distances are exact to first order only.
  double inside_m(glm::dvec2 middle) const {
    return signed_distance_m(surface_, glm::dvec2(surface_.center_m) + middle) + underlap_m_;
  }
  // Of a square that is farther than this from the border nothing is on the other side.
  static double reach_m(double half) { return 2 * std::numbers::sqrt2 * half; }
  static glm::dvec2 quarter(glm::dvec2 middle, double half, std::size_t i) {
    return middle + half * glm::dvec2(i % 2 == 0 ? -0.5 : 0.5, i < 2 ? -0.5 : 0.5);
  }

  JunctionSurface surface_;
  std::vector<CornerRise> rises_;  // of its corners
  double underlap_m_, wanted_m_;
  std::vector<Node> nodes_;
  std::vector<Enclosure> enclosures_;
  std::vector<Piece> pieces_;
};

// larger: one that holds the square and is close enough.
void AreaPlates::enclose(std::size_t node, glm::dvec2 middle, double half, const Enclosure* larger) {
  nodes_[node].first = nodes_[node].last = enclosures_.size();
  if (2 * half >= kShortestJunctionPlate_m) {
    const double inside = inside_m(middle);
    if (inside < -reach_m(half)) return;
    nodes_[node].at_border = 2 * half > kShortestJunctionPlate_m && inside < reach_m(half);
  }
  Enclosure own{};
  if (larger == nullptr) {
    const JunctionPoint p = height_at(surface_, glm::dvec2(surface_.center_m) + middle);
    const glm::dvec3 tangent(p.gradient, p.height_m - surface_.center_m.z);
    own = {middle, half, tangent, off_plane_m(surface_, rises_, middle, half, tangent, pieces_)};
    if (own.off_m <= kEnclosurePart * wanted_m_ || half <= kFinestJunctionBox_m) larger = &own;
  }
  if (larger != nullptr && !nodes_[node].at_border) {
    enclosures_.push_back(*larger);
  } else {
    const std::size_t child = nodes_.size();
    nodes_[node].child = child;
    nodes_.resize(child + 4);
    for (std::size_t i = 0; i < 4; ++i) enclose(child + i, quarter(middle, half, i), 0.5 * half, larger);
  }
  nodes_[node].last = enclosures_.size();
}

void AreaPlates::choose(std::size_t node, glm::dvec2 middle, double half, std::vector<Plate>& plates) const {
  const auto [first, last, child, at_border] = nodes_[node];
  if (first == last) return;
  const JunctionPoint at = height_at(surface_, glm::dvec2(surface_.center_m) + middle);
  double off = 0;
  for (std::size_t i = first; i < last; ++i) {
    const Enclosure& e = enclosures_[i];
    const glm::dvec2 tilt = glm::dvec2(e.tangent) - at.gradient;
    const double here = e.tangent.z - (at.height_m - surface_.center_m.z + glm::dot(at.gradient, e.middle - middle));
    off = std::max(off, std::abs(here) + e.half * (std::abs(tilt.x) + std::abs(tilt.y)) + e.off_m);
  }
  if ((off > wanted_m_ || at_border) && child > 0 && 2 * half > kShortestJunctionPlate_m) {
    for (std::size_t i = 0; i < 4; ++i) choose(child + i, quarter(middle, half, i), 0.5 * half, plates);
    return;
  }
  plates.push_back({.center_m = glm::dvec2(surface_.center_m) + middle,
                    .half_m = {half, half},
                    .z_m = at.height_m,
                    .slope = at.gradient,
                    .error_m = off});
}

void AreaPlates::add_to(std::vector<Plate>& plates) {
  const glm::dvec2 low = glm::dvec2(surface_.low_m) - underlap_m_;
  const glm::ivec2 count(glm::ceil((glm::dvec2(surface_.high_m) + underlap_m_ - low) / kJunctionPlate_m));
  for (int i = 0; i < count.x; ++i) {
    for (int j = 0; j < count.y; ++j) {
      const glm::dvec2 middle = low + kJunctionPlate_m * (glm::dvec2(i, j) + 0.5);
      nodes_.assign(1, {});
      enclosures_.clear();
      enclose(0, middle, 0.5 * kJunctionPlate_m);
      choose(0, middle, 0.5 * kJunctionPlate_m, plates);
    }
  }
}

}  // namespace

double lowest_lane_m(const Road& road, const Segment& segment) {
  double lowest = 0;
  if (segment.section >= road.sections.size()) return lowest;
  for (const auto* side : {&road.sections[segment.section].left, &road.sections[segment.section].right}) {
    for (const Lane& lane : *side) lowest = std::min({lowest, lane.inner_height_m, lane.outer_height_m});
  }
  return lowest;
}

glm::dvec2 Plate::gradient() const { return slope.x * axis + slope.y * across(axis); }

// In the frame of the other one, where that is a box.
Clipped Plate::above(const Plate& low) const {
  const glm::dvec2 x = half_m.x * axis, y = half_m.y * across(axis);
  std::array<glm::dvec3, 4> corners;
  std::size_t n = 0;
  for (const glm::dvec2 d : {x + y, y - x, -x - y, x - y}) {
    const glm::dvec2 p = center_m + d, q = p - low.center_m;
    corners[n++] = {glm::dot(q, low.axis), glm::dot(q, across(low.axis)), height_m(p) - low.height_m(p)};
  }
  Clipped polygon(corners);
  polygon.clip({1, 0, 0}, low.half_m.x);
  polygon.clip({-1, 0, 0}, low.half_m.x);
  polygon.clip({0, 1, 0}, low.half_m.y);
  polygon.clip({0, -1, 0}, low.half_m.y);
  for (glm::dvec3& p : polygon) p = {low.center_m + p.x * low.axis + p.y * across(low.axis), p.z};
  return polygon;
}

double Plate::height_m(glm::dvec2 point_m) const {
  const glm::dvec2 d = point_m - center_m;
  return z_m + slope.x * glm::dot(d, axis) + slope.y * glm::dot(d, across(axis));
}

Plates::Plates(const Network& network, const Supports& supports, double wanted_error_m) {
  const std::vector<bool> in_area = roads_in_areas(network);
  const std::size_t roads = network.roads.size();
  std::vector<std::vector<Plate>> parts(roads + network.junctions.size());
  for_chunks(parts.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
    if (i >= roads) {
      if (supports.of_junction(i - roads) == Support::kTunnel) return;
      AreaPlates(network.junctions[i - roads], kJunctionPart * wanted_error_m).add_to(parts[i]);
      for (Plate& plate : parts[i]) plate.set_support(supports.of_junction(i - roads), supports.is_assumed(i - roads));
    } else if (!in_area[i]) {
      const Road& road = network.roads[i];
      for (SegmentRef at{static_cast<std::uint32_t>(i), 0}; at.segment < road.segments.size(); ++at.segment) {
        const Segment& segment = road.segments[at.segment];
        for (const SupportedPart& part : supports.of(network, at)) {
          if (part.support == Support::kTunnel) continue;
          add_part(segment, part, lowest_lane_m(road, segment), wanted_error_m, parts[i]);
        }
      }
    }
  });
  for (const std::vector<Plate>& part : parts) plates_.insert(plates_.end(), part.begin(), part.end());
  std::vector<Box> boxes;
  boxes.reserve(plates_.size());
  for (const Plate& plate : plates_) boxes.push_back(box_of(plate));
  tree_ = BoxTree(boxes);
}

void Plates::find_overlaps(double apart_m) {
  std::vector<std::vector<Overlap>> found(plates_.size());
  std::vector<std::vector<Box>> boxes(plates_.size());
  for_each_index(plates_.size(), [&](std::size_t i) {
    const Plate& high = plates_[i];
    if (!high.on_ground) return;
    tree_.search(box_of(high), {.reach_m = 0}, [&](std::uint32_t item) {
      const Plate& low = plates_[item];
      // How far the one plane is above the other at most, over all of the lower plate.
      const double tilt = glm::length(high.gradient() - low.gradient());
      if (high.height_m(low.center_m) - low.z_m + tilt * glm::length(low.half_m) <= apart_m) return;
      Overlap worst;
      Box box{glm::dvec3(1e300), glm::dvec3(-1e300)};
      for (const glm::dvec3& p : high.above(low)) {
        box.low_m = glm::min(box.low_m, glm::dvec3(glm::dvec2(p), 0));
        box.high_m = glm::max(box.high_m, glm::dvec3(glm::dvec2(p), 0));
        worst.apart_m = std::max(worst.apart_m, p.z);
      }
      if (worst.apart_m <= apart_m) return;
      worst.at_m = glm::dvec2(0.5 * (box.low_m + box.high_m));
      found[i].push_back(worst);
      boxes[i].push_back(box);
    });
  });
  std::vector<Box> all;
  overlaps_.clear();
  for (std::size_t i = 0; i < found.size(); ++i) {
    overlaps_.insert(overlaps_.end(), found[i].begin(), found[i].end());
    all.insert(all.end(), boxes[i].begin(), boxes[i].end());
  }
  overlap_tree_ = BoxTree();
  if (!all.empty()) overlap_tree_ = BoxTree(all);
}

std::optional<Overlap> Plates::worst_overlap(const Box& about, double reach_m) const {
  std::optional<Overlap> worst;
  if (overlaps_.empty()) return worst;
  overlap_tree_.search(about, {.reach_m = reach_m}, [&](std::uint32_t item) {
    if (!worst || overlaps_[item].apart_m > worst->apart_m) worst = overlaps_[item];
  });
  return worst;
}

std::optional<Overlap> Plates::overlap(const std::array<glm::dvec3, 3>& triangle, double reach_m) const {
  return worst_overlap(box_of(triangle), reach_m);
}

std::optional<Overlap> Plates::overlap(const Plate& plate, double reach_m) const {
  return worst_overlap(box_of(plate), reach_m);
}

void Plates::find_levelled(const std::function<double(glm::dvec2)>& ground_m, double below_m, double reach_m) {
  for_each_index(plates_.size(), [&](std::size_t i) {
    Plate& plate = plates_[i];
    if (!plate.levelled || !worst_overlap(box_of(plate), reach_m)) return;
    const glm::dvec2 along = 0.9 * plate.half_m.x * plate.axis, aside = 0.9 * plate.half_m.y * across(plate.axis);
    for (const glm::dvec2 d : {glm::dvec2(0), along + aside, along - aside, aside - along, -along - aside}) {
      const glm::dvec2 p = plate.center_m + d;
      plate.levelled = plate.levelled && plate.height_m(p) - ground_m(p) <= below_m;
    }
  });
}

ClearanceBounds Plates::over(const std::array<glm::dvec3, 3>& triangle) const {
  ClearanceBounds found;
  tree_.search(box_of(triangle), {.reach_m = 0}, [&](std::uint32_t item) {
    const Plate& plate = plates_[item];
    // Into the plate's frame, z being the plane's height over the triangle's.
    std::array<glm::dvec3, 3> local;
    for (int i = 0; i < 3; ++i) {
      const glm::dvec2 d = glm::dvec2(triangle[i]) - plate.center_m;
      const glm::dvec2 q(glm::dot(d, plate.axis), glm::dot(d, across(plate.axis)));
      local[i] = {q, plate.z_m + glm::dot(plate.slope, q) - triangle[i].z};
    }
    Clipped polygon(local);
    polygon.clip({1, 0, 0}, plate.half_m.x);
    polygon.clip({-1, 0, 0}, plate.half_m.x);
    polygon.clip({0, 1, 0}, plate.half_m.y);
    polygon.clip({0, -1, 0}, plate.half_m.y);
    for (const glm::dvec3& p : polygon) {
      found.least_m = std::min(found.least_m, p.z - plate.error_m);
      if (!plate.levelled) continue;
      found.most_m = std::max(found.most_m, p.z + plate.error_m);
      found.error_m = std::max(found.error_m, plate.error_m);
    }
  });
  return found;
}

}  // namespace roadgen
