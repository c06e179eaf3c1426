#include "roadgen/fit/catmull_rom.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include <glm/geometric.hpp>

#include "roadgen/fit/curvature.h"
#include "roadgen/fit/stretch.h"

namespace roadgen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Pieces whose width changed after the division (narrowed neighbours, tapers) are divided again, this often at most.
constexpr int kMostWidthRounds = 8;
// Curvature: before the first solve tangents are at most this far off their chords (34 degrees); pieces that are bent
// more than kGentleSlope are halved where there is no solution.
constexpr double kMostFirstSlope = 0.67;
constexpr double kGentleSlope = 0.05;
constexpr int kMostCurvatureRounds = 40;

template <class... Numbers>
std::string text(const char* format, Numbers... numbers) {
  char buffer[512];
  std::snprintf(buffer, sizeof buffer, format, numbers...);
  return buffer;
}

bool is_usable(const Anchor& a) {
  for (const double x : {a.position_m.x, a.position_m.y, a.elevation_m, a.half_width_m, a.heading_rad.value_or(0),
                         a.grade.value_or(0)}) {
    if (!(std::abs(x) <= kGreatestCoordinate_m)) return false;
  }
  return true;
}

// The part of a cubic that starts at s_m, as a cubic of its own arc length.

// Builds one road: the state that the steps of road_from_anchors share.
class Alignment {
 public:
  Alignment(const AlignmentOptions& options, Diagnostics* diagnostics) : options_(options), diagnostics_(diagnostics) {}

  Result<Road> run(std::span<const Anchor> given);

 private:
  std::size_t stretch_count() const { return options_.closed ? anchors_.size() : anchors_.size() - 1; }
  const Anchor& anchor_after(std::size_t i) const { return anchors_[i + 1 == anchors_.size() ? 0 : i + 1]; }
  std::string place(std::size_t stretch) const;

  Status take_anchors(std::span<const Anchor> given);
  void report_repeats(std::size_t first, std::size_t count) const;
  Status divide_all();
  Status divide_part(std::size_t stretch, double t0, double t1, double half_width_m, std::vector<Piece>& pieces) const;
  Status divide_smoothly();
  Status divide_for_angles();
  Status cusp_error(std::size_t stretch, double s_m) const;
  std::optional<std::size_t> solve_headings();
  Status halve_inadmissible(bool& halved, bool& capped);
  bool halve_bent();
  void halve(const Piece& piece, std::vector<Piece>& pieces) const;
  void chain_pieces();
  Status tight_error(const Piece& piece, double half_width_m) const;
  Status settle_widths();
  void set_widths();
  std::vector<double> width_limits() const;
  void set_stretch_widths(std::size_t first, std::size_t last, const std::vector<double>& limit_m);
  void report_narrowing() const;
  void set_elevations();
  std::size_t stretch_end(std::size_t first_piece) const;
  double arc_of(std::size_t first_piece, std::size_t last_piece) const;

  AlignmentOptions options_;
  Diagnostics* diagnostics_;
  std::vector<Anchor> anchors_;      // without repetitions
  std::vector<std::size_t> origin_;  // index of each as it was given
  std::vector<Stretch> stretches_;
  std::vector<Piece> pieces_;
  std::vector<double> desired_m_, width_m_;  // half width at joint 0 ... pieces_.size(), before and after narrowing
};

Result<Road> Alignment::run(std::span<const Anchor> given) {
  if (Status s = take_anchors(given); !s) return s.error();
  if (options_.tangents == Tangents::kCurvature) {
    if (Status s = divide_smoothly(); !s) return s.error();
  } else {
    if (Status s = divide_all(); !s) return s.error();
    if (Status s = settle_widths(); !s) return s.error();
  }
  report_narrowing();
  set_elevations();
  Road road;
  road.closed = options_.closed;
  road.segments.reserve(pieces_.size());
  for (const Piece& piece : pieces_) road.segments.push_back(piece.segment);
  chain_arc_lengths(road);
  two_lane_sections(road);
  return road;
}

void Alignment::report_repeats(std::size_t first, std::size_t count) const {
  if (count == 0 || !diagnostics_) return;
  const std::string which = count == 1 ? text("anchor %zu repeats its neighbour", first)
                                       : text("anchors %zu to %zu repeat their neighbour", first, first + count - 1);
  diagnostics_->push_back({Severity::kWarning, which + text(" within %g m: left out", options_.least_distance_m)});
}

Status Alignment::take_anchors(std::span<const Anchor> given) {
  const auto near = [&](const Anchor& a, const Anchor& b) {
    return !(glm::length(a.position_m - b.position_m) > options_.least_distance_m);
  };
  std::size_t repeats = 0;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const Anchor& a = given[i];
    if (!is_usable(a)) {
      return Error{ErrorCode::kData, text("anchor %zu has a coordinate, height, width or heading that is not a finite "
                                          "number below %g; correct or remove it",
                                          i, kGreatestCoordinate_m)};
    }
    if (!(a.half_width_m > 0)) {
      return Error{ErrorCode::kData,
                   text("anchor %zu has a half width of %g m; it must be positive", i, a.half_width_m)};
    }
    if (!anchors_.empty() && near(a, anchors_.back())) {
      ++repeats;
      continue;
    }
    report_repeats(i - repeats, repeats);
    repeats = 0;
    anchors_.push_back(a);
    origin_.push_back(i);
  }
  report_repeats(given.size() - repeats, repeats);
  while (options_.closed && anchors_.size() > 1 && near(anchors_.front(), anchors_.back())) {
    report_repeats(origin_.back(), 1);
    anchors_.pop_back();
    origin_.pop_back();
  }
  if (anchors_.size() < 2) {
    return Error{ErrorCode::kData, text("a road needs at least two distinct anchors; %zu given, %zu distinct",
                                        given.size(), anchors_.size())};
  }
  return Done{};
}

std::string Alignment::place(std::size_t stretch) const {
  return text("between anchors %zu and %zu", origin_[stretch],
              origin_[stretch + 1 == anchors_.size() ? 0 : stretch + 1]);
}

Status Alignment::divide_all() {
  const std::vector<double> headings = catmull_rom_headings(anchors_, options_);
  double s_m = 0;
  for (std::size_t i = 0; i < stretch_count(); ++i) {
    const Anchor &from = anchors_[i], &to = anchor_after(i);
    const std::size_t end = i + 1 == anchors_.size() ? 0 : i + 1;
    stretches_.push_back(make_stretch(from.position_m, to.position_m, headings[i], headings[end]));
    const std::size_t before = pieces_.size();
    Status status = divide_part(i, 0, 1, std::max(from.half_width_m, to.half_width_m), pieces_);
    if (!status) return status;
    for (std::size_t k = before; k < pieces_.size(); ++k) {
      pieces_[k].segment.s_start_m = s_m;
      s_m += pieces_[k].segment.arc_m;
    }
  }
  return Done{};
}

Status Alignment::divide_part(std::size_t stretch, double t0, double t1, double half_width_m,
                              std::vector<Piece>& pieces) const {
  Division division = divide(stretches_[stretch], t0, t1, half_width_m, options_.mapping_tolerance);
  double s_m = pieces.empty() ? 0 : pieces.back().segment.s_start_m + pieces.back().segment.arc_m;
  for (Piece& piece : division.pieces) {
    piece.stretch = stretch;
    piece.segment.s_start_m = s_m;
    s_m += piece.segment.arc_m;
    const bool too_tight = options_.tight == TightPolicy::kError || piece.cap_m < kLeastHalfWidth_m;
    if (piece.tight() && too_tight) return tight_error(piece, half_width_m);
    pieces.push_back(piece);
  }
  return division.cusps.empty() ? Status(Done{}) : cusp_error(stretch, s_m);
}

Status Alignment::cusp_error(std::size_t stretch, double s_m) const {
  return Error{ErrorCode::kGeometry,
               place(stretch) + text(" (s = %.3f m) the road stops or reverses on the spot; remove or move an anchor "
                                     "there, or give other headings",
                                     s_m)};
}

Status Alignment::tight_error(const Piece& piece, double half_width_m) const {
  const std::string advice = options_.tight == TightPolicy::kError
                                 ? "make the road narrower there, move the anchors, or allow narrowing"
                                 : text("less than %g m would be left; remove or move an anchor", kLeastHalfWidth_m);
  return Error{ErrorCode::kGeometry,
               place(piece.stretch) +
                   text(" (s = %.3f m) the curve has a radius of %.3f m, too tight for a half width "
                        "of %.3f m: ",
                        piece.segment.s_start_m, least_radius_m(piece.segment), half_width_m) +
                   advice};
}

// One past the last piece of the stretch that first_piece begins.
std::size_t Alignment::stretch_end(std::size_t first_piece) const {
  std::size_t end = first_piece;
  while (end < pieces_.size() && pieces_[end].stretch == pieces_[first_piece].stretch) ++end;
  return end;
}

double Alignment::arc_of(std::size_t first_piece, std::size_t last_piece) const {
  double arc_m = 0;
  for (std::size_t i = first_piece; i < last_piece; ++i) arc_m += pieces_[i].segment.arc_m;
  return arc_m;
}

void Alignment::chain_pieces() {
  double s_m = 0;
  for (Piece& piece : pieces_) {
    piece.segment.s_start_m = s_m;
    s_m += piece.segment.arc_m;
  }
}

// The road with equal curvature at the joints: all headings are solved for, then inadmissible pieces are halved on
// their own curve, which hardly moves it, and so on.
Status Alignment::divide_smoothly() {
  if (Status s = divide_for_angles(); !s) return s;
  bool solved = false;
  for (int round = 0; round < kMostCurvatureRounds; ++round) {
    if (!solved) {
      const std::optional<std::size_t> jump = solve_headings();
      if (jump && halve_bent()) continue;
      if (jump) {
        return Error{ErrorCode::kGeometry, place(pieces_[std::min(*jump, pieces_.size() - 1)].stretch) +
                                               " no headings make the curvature continuous; add anchors there, or "
                                               "choose other tangents"};
      }
    }
    chain_pieces();
    set_widths();
    bool halved = false, capped = false;
    if (Status s = halve_inadmissible(halved, capped); !s) return s;
    if (!halved && !capped) return Done{};
    solved = !halved;
  }
  return Error{ErrorCode::kGeometry, "the division for continuous curvature does not end; choose other tangents"};
}

Status Alignment::divide_for_angles() {
  const std::vector<double> headings = catmull_rom_headings(anchors_, options_);
  double s_m = 0;
  for (std::size_t i = 0; i < stretch_count(); ++i) {
    const std::size_t end = i + 1 == anchors_.size() ? 0 : i + 1;
    const Division division = divide_into_graphs(
        make_stretch(anchors_[i].position_m, anchors_[end].position_m, headings[i], headings[end]), kMostFirstSlope);
    for (Piece piece : division.pieces) {
      piece.stretch = i;
      set_arc(piece.segment);
      s_m += piece.segment.arc_m;
      pieces_.push_back(piece);
    }
    if (!division.cusps.empty()) return cusp_error(i, s_m);
  }
  return Done{};
}

// Turns the pieces so that curvature is equal on both sides of every joint; else the joint where it jumps most.
std::optional<std::size_t> Alignment::solve_headings() {
  std::vector<glm::dvec2> points;
  std::vector<double> headings;
  std::vector<char> fixed;
  const auto add = [&](glm::dvec2 point_m, double heading, const Anchor* anchor) {
    const bool given = anchor && anchor->heading_rad;
    points.push_back(point_m);
    headings.push_back(given ? *anchor->heading_rad : heading);
    fixed.push_back(given);
  };
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    const Piece& piece = pieces_[k];
    const bool at_anchor = k == 0 || pieces_[k - 1].stretch != piece.stretch;
    add(piece.segment.start_m, heading_rad(piece.segment, 0), at_anchor ? &anchors_[piece.stretch] : nullptr);
  }
  if (!options_.closed) add(pieces_.back().segment.end_m, heading_rad(pieces_.back().segment, 1), &anchors_.back());
  const std::optional<std::size_t> jump = equalize_curvature(points, fixed, options_.closed, headings);
  if (jump) return jump;
  for (std::size_t k = 0; k < pieces_.size(); ++k) {
    Segment& s = pieces_[k].segment;
    const glm::dvec2 chord = s.chord_m();
    const double along = std::atan2(chord.y, chord.x);
    s.slope_start = std::tan(headings[k] - along);
    s.slope_end = std::tan(headings[k + 1 == headings.size() ? 0 : k + 1] - along);
    set_arc(s);
  }
  return std::nullopt;
}

Status Alignment::halve_inadmissible(bool& halved, bool& capped) {
  std::vector<Piece> pieces;
  pieces.reserve(pieces_.size());
  for (Piece& piece : pieces_) {
    Segment& s = piece.segment;
    set_bound(s);
    const double width = s.max_half_width_m();
    if (!is_admissible(s, options_.mapping_tolerance)) {
      const std::optional<double> cap_m =
          std::isfinite(s.bound.v) ? std::nullopt : tight_cap_m(s, width, options_.mapping_tolerance);
      if (!cap_m) {
        halved = true;
        halve(piece, pieces);
        continue;
      }
      capped = true;
      piece.cap_m = *cap_m;
      if (options_.tight == TightPolicy::kError || *cap_m < kLeastHalfWidth_m) return tight_error(piece, width);
    }
    pieces.push_back(piece);
  }
  pieces_ = std::move(pieces);
  return Done{};
}

bool Alignment::halve_bent() {
  std::vector<Piece> pieces;
  for (const Piece& piece : pieces_) {
    if (std::max(std::abs(piece.segment.slope_start), std::abs(piece.segment.slope_end)) > kGentleSlope) {
      halve(piece, pieces);
    } else {
      pieces.push_back(piece);
    }
  }
  std::swap(pieces_, pieces);
  return pieces_.size() > pieces.size();
}

// In two pieces that meet on the piece's own curve.
void Alignment::halve(const Piece& piece, std::vector<Piece>& pieces) const {
  const Segment& s = piece.segment;
  const glm::dvec2 middle_m = position_m(s, 0.5);
  const double heading = heading_rad(s, 0.5), t = 0.5 * (piece.t0 + piece.t1), width = s.max_half_width_m();
  Piece first = piece, second = piece;
  first.segment = make_segment(s.start_m, middle_m, heading_rad(s, 0), heading, width);
  second.segment = make_segment(middle_m, s.end_m, heading, heading_rad(s, 1), width);
  first.t1 = second.t0 = t;
  pieces.push_back(first);
  pieces.push_back(second);
}

// The widths follow from the pieces, and the pieces must be admissible for their widths: narrower pieces have a smaller
// tolerance, so some are divided once more.
Status Alignment::settle_widths() {
  for (int round = 0;; ++round) {
    set_widths();
    std::vector<Piece> pieces;
    pieces.reserve(pieces_.size());
    bool changed = false;
    for (Piece& piece : pieces_) {
      set_bound(piece.segment);
      if (is_admissible(piece.segment, options_.mapping_tolerance)) {
        pieces.push_back(piece);
        continue;
      }
      changed = true;
      const double middle = 0.5 * (piece.t0 + piece.t1), width = piece.segment.max_half_width_m();
      for (const double t : {piece.t0, middle}) {
        Status status = divide_part(piece.stretch, t, t == middle ? piece.t1 : middle, width, pieces);
        if (!status) return status;
      }
    }
    if (!changed) return Done{};
    pieces_ = std::move(pieces);
    if (round == kMostWidthRounds) {
      return Error{ErrorCode::kGeometry, "the narrowed widths do not settle; give the anchors smaller half widths"};
    }
  }
}

// Half width that the joints beside narrowed pieces may have at most; infinite far from them.
std::vector<double> Alignment::width_limits() const {
  const std::size_t count = pieces_.size();
  std::vector<double> limit(count + 1, kInfinity);
  for (std::size_t i = 0; i < count; ++i) {
    limit[i] = std::min(limit[i], pieces_[i].cap_m);
    limit[i + 1] = std::min(limit[i + 1], pieces_[i].cap_m);
  }
  // Twice around where the road is closed: a taper may pass the first anchor.
  for (int lap = 0; lap < (options_.closed ? 2 : 1); ++lap) {
    if (options_.closed) limit.front() = limit.back() = std::min(limit.front(), limit.back());
    for (std::size_t i = 0; i < count; ++i) {
      limit[i + 1] = std::min(limit[i + 1], limit[i] + kNarrowingTaper * pieces_[i].segment.arc_m);
    }
    for (std::size_t i = count; i-- > 0;) {
      limit[i] = std::min(limit[i], limit[i + 1] + kNarrowingTaper * pieces_[i].segment.arc_m);
    }
  }
  return limit;
}

void Alignment::set_widths() {
  desired_m_.assign(pieces_.size() + 1, 0);
  width_m_ = desired_m_;
  const std::vector<double> limit = width_limits();
  for (std::size_t first = 0; first < pieces_.size(); first = stretch_end(first)) {
    set_stretch_widths(first, stretch_end(first), limit);
  }
}

void Alignment::set_stretch_widths(std::size_t first, std::size_t last, const std::vector<double>& limit_m) {
  const std::size_t stretch = pieces_[first].stretch;
  const double from = anchors_[stretch].half_width_m, to = anchor_after(stretch).half_width_m;
  const Cubic whole = Cubic::hermite(from, 0, to, 0, arc_of(first, last));
  double s = 0;
  bool narrowed = false;
  for (std::size_t i = first; i <= last; ++i) {
    desired_m_[i] = i == first ? from : i == last ? to : whole.value(s);
    width_m_[i] = std::min(desired_m_[i], limit_m[i]);
    narrowed = narrowed || width_m_[i] < desired_m_[i];
    if (i < last) s += pieces_[i].segment.arc_m;
  }
  s = 0;
  for (std::size_t i = first; i < last; ++i) {
    Segment& segment = pieces_[i].segment;
    segment.set_half_width_m(narrowed ? Cubic::hermite(width_m_[i], 0, width_m_[i + 1], 0, segment.arc_m)
                                      : whole.shifted(s));
    s += segment.arc_m;
  }
}

void Alignment::report_narrowing() const {
  if (!diagnostics_) return;
  double s = 0;
  for (std::size_t i = 0; i < pieces_.size();) {
    if (!(width_m_[i] < desired_m_[i] || width_m_[i + 1] < desired_m_[i + 1])) {
      s += pieces_[i++].segment.arc_m;
      continue;
    }
    const double start = s;
    double least = kInfinity, radius = kInfinity, wanted = 0;
    for (; i < pieces_.size() && (width_m_[i] < desired_m_[i] || width_m_[i + 1] < desired_m_[i + 1]); ++i) {
      least = std::min({least, width_m_[i], width_m_[i + 1]});
      wanted = std::max({wanted, desired_m_[i], desired_m_[i + 1]});
      radius = std::min(radius, least_radius_m(pieces_[i].segment));
      s += pieces_[i].segment.arc_m;
    }
    diagnostics_->push_back(
        {Severity::kWarning, text("narrowed from s = %.3f m to %.3f m: the curve has a radius of %.3f m, too tight for "
                                  "a half width of %.3f m; %.3f m is left",
                                  start, s, radius, wanted, least)});
  }
}

// C1 over the whole road: a cubic between each two anchors, cut at the joints inside.
void Alignment::set_elevations() {
  const std::size_t count = anchors_.size(), stretches = stretch_count();
  std::vector<double> arc(stretches);
  for (std::size_t first = 0; first < pieces_.size(); first = stretch_end(first)) {
    arc[pieces_[first].stretch] = arc_of(first, stretch_end(first));
  }
  std::vector<double> grade(count);
  const auto rise = [&](std::size_t i) { return (anchor_after(i).elevation_m - anchors_[i].elevation_m) / arc[i]; };
  for (std::size_t i = 0; i < count; ++i) {
    const bool inner = options_.closed || (i > 0 && i + 1 < count);
    if (!inner) continue;
    const std::size_t before = i == 0 ? count - 1 : i - 1;
    grade[i] = anchors_[i].grade.value_or((anchor_after(i).elevation_m - anchors_[before].elevation_m) /
                                          (arc[before] + arc[i]));
  }
  if (!options_.closed) {
    // The ends continue the profile as a parabola would.
    const bool two = count == 2;
    const double first = rise(0), last = rise(count - 2);
    grade[0] = anchors_[0].grade.value_or(2 * first - (two ? anchors_[1].grade.value_or(first) : grade[1]));
    grade[count - 1] = anchors_[count - 1].grade.value_or(2 * last - (two ? grade[0] : grade[count - 2]));
  }
  for (std::size_t first = 0; first < pieces_.size(); first = stretch_end(first)) {
    const std::size_t i = pieces_[first].stretch, end = i + 1 == count ? 0 : i + 1, last = stretch_end(first);
    const Cubic whole =
        Cubic::hermite(anchors_[i].elevation_m, grade[i], anchors_[end].elevation_m, grade[end], arc[i]);
    double s = 0;
    for (std::size_t k = first; k < last; ++k) {
      pieces_[k].segment.elevation_m = whole.shifted(s);
      s += pieces_[k].segment.arc_m;
    }
  }
}

}  // namespace

std::vector<double> catmull_rom_headings(std::span<const Anchor> anchors, const AlignmentOptions& options) {
  assert(anchors.size() >= 2);
  const std::size_t count = anchors.size();
  const auto heading_of = [](glm::dvec2 d) { return std::atan2(d.y, d.x); };
  std::vector<double> headings(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (anchors[i].heading_rad) headings[i] = *anchors[i].heading_rad;
    if (anchors[i].heading_rad || (!options.closed && (i == 0 || i + 1 == count))) continue;
    const glm::dvec2 in = anchors[i].position_m - anchors[i == 0 ? count - 1 : i - 1].position_m;
    const glm::dvec2 out = anchors[i + 1 == count ? 0 : i + 1].position_m - anchors[i].position_m;
    // Centripetal: parameter steps are the square roots of the distances.
    const bool uniform = options.tangents == Tangents::kUniform;
    const double h0 = uniform ? 1 : std::sqrt(glm::length(in)), h1 = uniform ? 1 : std::sqrt(glm::length(out));
    const glm::dvec2 tangent = in * (h1 / h0) + out * (h0 / h1);
    const bool reverses = !(glm::length(tangent) > 1e-9 * (glm::length(in) + glm::length(out)));
    headings[i] = heading_of(reverses ? glm::dvec2(-in.y, in.x) : tangent);
  }
  if (options.closed) return headings;
  const double first = heading_of(anchors[1].position_m - anchors[0].position_m);
  const double last = heading_of(anchors[count - 1].position_m - anchors[count - 2].position_m);
  // A circular arc leaves its chord at the angle at which it meets it, on the other side.
  const double second = count > 2 ? headings[1] : anchors[1].heading_rad.value_or(first);
  if (!anchors[0].heading_rad) headings[0] = 2 * first - second;
  const double second_last = count > 2 ? headings[count - 2] : headings[0];
  if (!anchors[count - 1].heading_rad) headings[count - 1] = 2 * last - second_last;
  return headings;
}

Result<Road> road_from_anchors(std::span<const Anchor> anchors, const AlignmentOptions& options,
                               Diagnostics* diagnostics) {
  return Alignment(options, diagnostics).run(anchors);
}

}  // namespace roadgen
