#include "roadgen/import/osm_road.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <glm/geometric.hpp>

#include "roadgen/import/osm_structures.h"

namespace roadgen {
namespace {

constexpr double kSmoothTurn_rad = std::numbers::pi / 4;  // at nodes that follow a bend
constexpr double kSmoothBulge_m = 1;                      // of a bend beside the straight line between nodes
constexpr double kBulge = 4.0 / 27;                       // max of x (1 - x)^2: of a cubic of slope 1 at one end
constexpr double kCornerError_m = 0.8 * kNodeError_m;     // the rest is for cubics and thinning
constexpr double kLongestTaper_m = 30;
constexpr double kLeastPiece_m = 0.05;  // between places where something changes
constexpr int kMostNarrowings = 6;
constexpr double kVault_m = 1.5,
                 kVaultRadius = 1.6;  // of a vault beyond the edges; and its bends' radius over its half width
constexpr double kLeastPart = 0.05;   // of the half width that the mapping is certified for
constexpr double kArcTurn_rad = std::numbers::pi / 3;  // of one cubic of a corner
// Points within the first of these of the straight line without them are left out; where no road can be, the next ones.
constexpr double kThinning_m[] = {0.15, 0.5, 1, 2};

double heading(glm::dvec2 d) { return std::atan2(d.y, d.x); }
double turn(glm::dvec2 a, glm::dvec2 b) { return std::atan2(a.x * b.y - a.y * b.x, glm::dot(a, b)); }

// A point that the road turns at, or where something changes.
struct Vertex {
  glm::dvec2 p;
  double at_m;        // along the course
  bool keep = false;  // not to be left out
};

// A stretch of equal tags.
struct Part {
  std::size_t piece = 0;          // the first of the course's
  double start_m = 0, end_m = 0;  // along the course
  double taper_start_m = 0, taper_end_m = 0;
  LaneSection section;
  double half_m = 0;      // greatest |t|
  double least_part = 1;  // of half_m that it tapers to
  double factor = 1;      // of its widths
};

bool is_driven(LaneType type) { return type == LaneType::kDriving || type == LaneType::kBidirectional; }

constexpr std::size_t kNoLane = static_cast<std::size_t>(-1);

// For each lane of a side the one of the other part that it goes on as, or kNoLane.
std::vector<std::size_t> matching_lanes(const std::vector<Lane>& own, const std::vector<Lane>& other) {
  std::vector<std::size_t> match(own.size(), kNoLane);
  std::size_t next = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    std::size_t k = next;
    while (k < other.size() && other[k].type != own[i].type && !(is_driven(other[k].type) && is_driven(own[i].type)))
      ++k;
    if (k == other.size()) continue;
    match[i] = k;
    next = k + 1;
  }
  return match;
}

// Widths of matching lanes at the joint of two parts: the lesser one, or 0 where there is none.
std::vector<double> joint_widths(const std::vector<Lane>& own, const std::vector<Lane>& other) {
  const std::vector<std::size_t> match = matching_lanes(own, other);
  std::vector<double> widths(own.size(), 0);
  for (std::size_t i = 0; i < own.size(); ++i) {
    if (match[i] != kNoLane) widths[i] = std::min(own[i].width_m.c0, other[match[i]].width_m.c0);
  }
  return widths;
}

// Whether a lane goes on from one section to the other.
bool go_on(const LaneSection& a, const LaneSection& b) {
  const auto driven = [](const std::vector<Lane>& side) { return !side.empty() && is_driven(side.front().type); };
  return (driven(a.left) && driven(b.left)) || (driven(a.right) && driven(b.right));
}

// t of lane 0 at the joint of two sections.
double joint_offset_m(const LaneSection& a, const LaneSection& b) { return 0.5 * (a.offset_m.c0 + b.offset_m.c0); }

// Greatest |t| at the joint of two sections.
double joint_half_m(const LaneSection& a, const LaneSection& b) {
  const auto sum = [](const std::vector<double>& widths) { return std::accumulate(widths.begin(), widths.end(), 0.0); };
  const double offset = joint_offset_m(a, b);
  return std::max(offset + sum(joint_widths(a.left, b.left)), sum(joint_widths(a.right, b.right)) - offset);
}

class LineMaker {
 public:
  LineMaker(const OsmScene& scene, const Course& course, const OsmLine& line, const LinePlan& plan,
            ElementFindings& findings)
      : scene_(scene), course_(course), line_(line), plan_(plan), findings_(findings) {}
  Result<LineRoads> run();

 private:
  const WayTags& tags(std::size_t piece) const { return scene_.data.ways[course_.pieces[piece].way].tags; }
  std::int64_t way_id(std::size_t piece) const { return scene_.data.ways[course_.pieces[piece].way].id; }
  std::string element() const { return "way " + std::to_string(way_id(parts_.front().piece)); }
  void find_parts();
  void find_tapers();
  void straighten_cuts(std::vector<Vertex>& all) const;
  std::vector<Vertex> vertices() const;
  std::vector<Vertex> thinned(std::vector<Vertex> all, double tolerance_m) const;
  std::vector<Anchor> anchors(const std::vector<Vertex>& v);
  void add_anchor(std::vector<Anchor>& to, glm::dvec2 p, double at_m, double heading_rad);
  double half_width_at(double at_m) const;
  // Of the middle of a bend. In tunnels the vault has to follow.
  double least_radius(double at_m) const {
    const double road = 1.1 * half_width_at(at_m) + kLeastInnerRadius_m;
    return tags(course_.piece_at(at_m)).tunnel ? std::max(road, kVaultRadius * (half_width_at(at_m) + kVault_m)) : road;
  }
  struct Range {
    std::size_t begin, end;
  };
  std::size_t anchor_near(double at_m) const;
  std::size_t segment_at(const Road& whole, double at_m) const;
  Range segments_of(const Road& whole, std::size_t part) const;
  void narrow_parts(const Road& whole);
  Result<Road> whole_road();
  LaneSection tapered(const Part& part, const Part* before, const Part* after, double from_s, double to_s,
                      double length_m) const;
  Result<Road> part_road(const Road& whole, std::size_t i);

  const OsmScene& scene_;
  const Course& course_;
  const OsmLine& line_;
  const LinePlan& plan_;
  ElementFindings& findings_;
  double start_m_ = 0, end_m_ = 0;  // along the course, between the cuts
  std::vector<Part> parts_;
  struct VertexAnchor {
    double at_m;
    std::size_t anchor;
  };
  std::vector<VertexAnchor> vertex_anchors_;
  std::vector<glm::dvec2> anchor_p_;
};

void LineMaker::find_parts() {
  start_m_ = plan_.cut_start_m;
  end_m_ = course_.length_m() - plan_.cut_end_m;
  for (std::size_t i = 0; i < course_.pieces.size(); ++i) {
    const double from = std::max(start_m_, course_.at_m[course_.starts[i]]);
    const double to = std::min(end_m_, course_.at_m[course_.starts[i + 1]]);
    const bool is_last_hope = parts_.empty() && i + 1 == course_.pieces.size();
    if (to - from < kLeastPiece_m && !is_last_hope) continue;
    LaneSection section = section_of_way(tags(i), course_.pieces[i].along(), scene_.keep_left);
    if (!parts_.empty() && tags(parts_.back().piece) == tags(i) && parts_.back().section == section) {
      parts_.back().end_m = to;
      continue;
    }
    if (!parts_.empty()) parts_.back().end_m = from;
    Part part;
    part.piece = i;
    part.start_m = parts_.empty() ? start_m_ : from;
    part.end_m = to;
    part.section = std::move(section);
    part.half_m = edges_of_way(tags(i), course_.pieces[i].along(), scene_.keep_left).half_m;
    parts_.push_back(std::move(part));
  }
  parts_.back().end_m = end_m_;
}

void LineMaker::find_tapers() {
  for (std::size_t i = 0; i + 1 < parts_.size(); ++i) {
    Part &a = parts_[i], &b = parts_[i + 1];
    if (a.section == b.section || !go_on(a.section, b.section)) continue;
    a.taper_end_m = std::min(kLongestTaper_m, 0.45 * (a.end_m - a.start_m));
    b.taper_start_m = std::min(kLongestTaper_m, 0.45 * (b.end_m - b.start_m));
    const double joint = joint_half_m(a.section, b.section);
    for (Part* part : {&a, &b}) {
      const double least = std::min(part->least_part * part->half_m, std::min(joint, part->half_m));
      part->half_m = std::max(part->half_m, joint);
      part->least_part = least / part->half_m;
    }
  }
}

// A road leaves a junction straight on, over the length that its direction there comes from.
void LineMaker::straighten_cuts(std::vector<Vertex>& all) const {
  const auto straighten = [&](double from, double to) {
    if (course_.leg_at(from) == course_.leg_at(to)) return;
    const glm::dvec2 p = course_.point_at(from), q = course_.point_at(to);
    std::erase_if(all, [&](const Vertex& v) { return !v.keep && v.at_m > from && v.at_m < to; });
    for (Vertex& v : all) {
      if (v.at_m > from && v.at_m < to) v.p = p + (v.at_m - from) / (to - from) * (q - p);
    }
    for (const auto& [at, point] : {std::pair(from, p), {to, q}}) {
      const auto next =
          std::lower_bound(all.begin(), all.end(), at, [](const Vertex& v, double x) { return v.at_m < x - 1e-9; });
      if (next != all.end() && next->at_m < at + kLeastPiece_m) {
        next->keep = true;
      } else {
        all.insert(next, {point, at, true});
      }
    }
  };
  const double room = end_m_ - start_m_, ahead = kLookAhead_m + kLeastPiece_m;
  const bool both = plan_.joined_start && plan_.joined_end;
  if (room < (both ? 2 : 1) * ahead) {
    if (plan_.joined_start || plan_.joined_end) straighten(start_m_, end_m_);
    return;
  }
  if (plan_.joined_start) straighten(start_m_, start_m_ + kLookAhead_m);
  if (plan_.joined_end) straighten(end_m_ - kLookAhead_m, end_m_);
}

std::vector<Vertex> LineMaker::vertices() const {
  std::vector<Vertex> all;
  for (std::size_t i = 0; i < course_.points_m.size(); ++i) {
    const double at = course_.at_m[i];
    if (at > start_m_ + kLeastPiece_m && at < end_m_ - kLeastPiece_m) all.push_back({course_.points_m[i], at});
  }
  const auto keep = [&](double at) {
    const auto next =
        std::lower_bound(all.begin(), all.end(), at, [](const Vertex& v, double x) { return v.at_m < x; });
    for (auto near : {next, next == all.begin() ? next : next - 1}) {
      if (near != all.end() && std::abs(near->at_m - at) < 1e-9) {
        near->keep = true;
        return;
      }
    }
    all.insert(next, {course_.point_at(at), at, true});
  };
  keep(start_m_);
  keep(end_m_);
  for (const Part& part : parts_) {
    keep(part.start_m);
    if (part.taper_start_m > 0) keep(part.start_m + part.taper_start_m);
    if (part.taper_end_m > 0) keep(part.end_m - part.taper_end_m);
  }
  straighten_cuts(all);
  if (plan_.heights) {
    for (const double at : plan_.heights->at_m) {
      const auto near =
          std::lower_bound(all.begin(), all.end(), at - 2, [](const Vertex& v, double x) { return v.at_m < x; });
      const bool is_near = near != all.end() && near->keep && near->at_m < at + 2;
      if (at > start_m_ + 1 && at < end_m_ - 1 && !is_near) keep(at);
    }
  }
  return all;
}

// Douglas and Peucker between the points to keep.
std::vector<Vertex> LineMaker::thinned(std::vector<Vertex> all, double tolerance_m) const {
  std::vector<std::pair<std::size_t, std::size_t>> open;
  std::size_t last = 0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    if (!all[i].keep) continue;
    open.emplace_back(last, i);
    last = i;
  }
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const glm::dvec2 chord = all[b].p - all[a].p;
    const double square = glm::dot(chord, chord);
    double worst = tolerance_m;
    std::size_t at = 0;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double part = square > 0 ? std::clamp(glm::dot(all[i].p - all[a].p, chord) / square, 0.0, 1.0) : 0;
      const double off = glm::length(all[i].p - all[a].p - part * chord);
      if (off > worst) worst = off, at = i;
    }
    if (at == 0) continue;
    all[at].keep = true;
    open.emplace_back(a, at);
    open.emplace_back(at, b);
  }
  std::erase_if(all, [](const Vertex& v) { return !v.keep; });
  return all;
}

double LineMaker::half_width_at(double at_m) const {
  double half = 0;
  for (const Part& part : parts_) {
    if (at_m >= part.start_m - 1e-9 && at_m <= part.end_m + 1e-9) half = std::max(half, part.half_m);
  }
  return std::max(half, kLeastHalfWidth_m);
}

void LineMaker::add_anchor(std::vector<Anchor>& to, glm::dvec2 p, double at_m, double heading_rad) {
  Anchor anchor{p, 0, half_width_at(at_m), heading_rad, 0.0};
  if (plan_.heights) {
    const HeightProfile::Value h = plan_.heights->value(at_m);
    anchor.elevation_m = h.z_m;
    anchor.grade = h.grade;
  }
  to.push_back(anchor);
  anchor_p_.push_back(p);
}

// Every anchor with its heading, so that no two steps disagree about the curve.
std::vector<Anchor> LineMaker::anchors(const std::vector<Vertex>& v) {
  const std::size_t n = v.size();
  std::vector<double> turn_at(n, 0), smooth_heading(n, 0);
  std::vector<char> is_smooth(n, 0);
  const auto leg = [&](std::size_t i) { return v[i + 1].p - v[i].p; };
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const glm::dvec2 in = leg(i - 1), out = leg(i), tangent = in + out;
    turn_at[i] = turn(in, out);
    const double off_in = std::abs(turn(in, tangent)), off_out = std::abs(turn(tangent, out));
    smooth_heading[i] = heading(tangent);
    const double bend_in = std::tan(off_in), bend_out = std::tan(off_out);
    const double least_m = least_radius(v[i].at_m);
    is_smooth[i] = std::abs(turn_at[i]) <= kSmoothTurn_rad &&
                   kBulge * std::max(bend_in * glm::length(in), bend_out * glm::length(out)) <= kSmoothBulge_m &&
                   glm::length(in) >= 4 * bend_in * least_m && glm::length(out) >= 4 * bend_out * least_m;
  }
  vertex_anchors_.clear();
  anchor_p_.clear();
  std::vector<Anchor> all;
  // A dead end goes on with the bend, a cut as the junction has it.
  const double first = heading(leg(0)), last = heading(leg(n - 2));
  const auto end_heading = [&](double chord, std::size_t next) {
    const bool straight = line_.closed || n < 3 || !is_smooth[next];
    return straight ? chord : chord - std::remainder(smooth_heading[next] - chord, 2 * std::numbers::pi);
  };
  const EndView start_view(scene_, course_, false), end_view(scene_, course_, true);
  vertex_anchors_.push_back({v[0].at_m, 0});
  add_anchor(all, v[0].p, v[0].at_m,
             plan_.joined_start ? heading(start_view.outward_of_cut(plan_.cut_start_m)) : end_heading(first, 1));
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (is_smooth[i]) {
      vertex_anchors_.push_back({v[i].at_m, all.size()});
      add_anchor(all, v[i].p, v[i].at_m, smooth_heading[i]);
      continue;
    }
    const glm::dvec2 in = glm::normalize(leg(i - 1)), out = glm::normalize(leg(i));
    const double half_turn = 0.5 * std::abs(turn_at[i]);
    const double radius = std::max(least_radius(v[i].at_m), kCornerError_m / (1 / std::cos(half_turn) - 1));
    const auto share = [&](std::size_t other, double length) {
      return length * (is_smooth[other] || other == 0 || other + 1 == n ? 0.8 : 0.49);
    };
    const double tangent = std::min(
        {radius * std::tan(half_turn), share(i - 1, glm::length(leg(i - 1))), share(i + 1, glm::length(leg(i)))});
    add_anchor(all, v[i].p - tangent * in, v[i].at_m - tangent, heading(in));
    if (v[i].keep || std::abs(turn_at[i]) > kArcTurn_rad) {
      vertex_anchors_.push_back({v[i].at_m, all.size()});
      const glm::dvec2 middle = v[i].p + tangent * std::tan(0.5 * half_turn) * glm::normalize(out - in);
      add_anchor(all, middle, v[i].at_m, heading(in + out));
    }
    add_anchor(all, v[i].p + tangent * out, v[i].at_m + tangent, heading(out));
  }
  vertex_anchors_.push_back({v[n - 1].at_m, all.size()});
  add_anchor(all, v[n - 1].p, v[n - 1].at_m,
             plan_.joined_end ? heading(-end_view.outward_of_cut(plan_.cut_end_m)) : end_heading(last, n - 2));
  return all;
}

// The whole line as one road. Its sections are not yet those of the parts.
Result<Road> LineMaker::whole_road() {
  const std::vector<Vertex> all = vertices();
  AlignmentOptions options;
  options.least_distance_m = 1e-6;
  options.closed = line_.closed && parts_.size() == 1;
  // The mapping is certified to a part of the half width, which is less than the anchors' where lanes taper.
  for (const Part& part : parts_) {
    options.mapping_tolerance =
        std::min(options.mapping_tolerance, std::max(part.least_part, kLeastPart) * kMappingTolerance);
  }
  const auto road_through = [&](double tolerance_m) {
    std::vector<Anchor> through = anchors(thinned(all, tolerance_m));
    if (options.closed) through.pop_back();
    return road_from_anchors(through, options);
  };
  Result<Road> road = Error{};
  for (const double tolerance : kThinning_m) {
    options.tight = TightPolicy::kError;
    road = road_through(tolerance);
    // What can bend so tightly only where it is narrower is made so, unless leaving out a node or two helps.
    for (int round = 0; !road && tolerance == kThinning_m[std::size(kThinning_m) - 1] && round < kMostNarrowings;
         ++round) {
      options.tight = TightPolicy::kNarrow;
      const Result<Road> narrow = road_through(tolerance);
      if (!narrow) return narrow;
      narrow_parts(*narrow);
      options.tight = TightPolicy::kError;
      road = road_through(tolerance);
    }
    if (!road) continue;
    if (tolerance > kThinning_m[0]) {
      findings_.add(Severity::kWarning, "ways with bends too tight", element(),
                    "bends too tightly for its width: nodes up to " + std::to_string(tolerance).substr(0, 3) +
                        " m beside it are left out");
    }
    for (const Part& part : parts_) {
      if (part.factor == 1) continue;
      findings_.add(Severity::kWarning, "ways with bends too tight", "way " + std::to_string(way_id(part.piece)),
                    "bends too tightly for its width: its lanes are made narrower, to " +
                        std::to_string(static_cast<int>(std::round(100 * part.factor))) + " %");
    }
    break;
  }
  return road;
}

// The anchor of the vertex there.
std::size_t LineMaker::anchor_near(double at_m) const {
  const auto nearer = [&](const VertexAnchor& a, const VertexAnchor& b) {
    return std::abs(a.at_m - at_m) < std::abs(b.at_m - at_m);
  };
  return std::min_element(vertex_anchors_.begin(), vertex_anchors_.end(), nearer)->anchor;
}

// The segment of the whole road that starts at a place along the course where an anchor is.
std::size_t LineMaker::segment_at(const Road& whole, double at_m) const {
  const std::size_t anchor = anchor_near(at_m);
  if (anchor == 0) return 0;
  std::size_t k = 0;
  while (k < whole.segments.size() && whole.segments[k].start_m != anchor_p_[anchor]) ++k;
  return k;
}

LineMaker::Range LineMaker::segments_of(const Road& whole, std::size_t part) const {
  return {part == 0 ? 0 : segment_at(whole, parts_[part].start_m),
          part + 1 == parts_.size() ? whole.segments.size() : segment_at(whole, parts_[part].end_m)};
}

// Makes the lanes of every part as narrow as its narrowest place, and those that taper into one another alike.
void LineMaker::narrow_parts(const Road& whole) {
  std::vector<double> factor(parts_.size(), 1);
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    double least = parts_[i].half_m;
    const Range range = segments_of(whole, i);
    for (std::size_t k = range.begin; k < range.end; ++k) {
      least = std::min(least, whole.segments[k].left_m.range(whole.segments[k].arc_m).low);
    }
    if (least < parts_[i].half_m) factor[i] = 0.97 * least / parts_[i].half_m;
    if (i > 0 && parts_[i].taper_start_m > 0) factor[i] = std::min(factor[i], factor[i - 1]);
  }
  for (std::size_t i = parts_.size() - 1; i-- > 0;) {
    if (parts_[i].taper_end_m > 0) factor[i] = std::min(factor[i], factor[i + 1]);
  }
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Part& part = parts_[i];
    part.factor *= factor[i];
    part.half_m *= factor[i];
    part.section.offset_m.c0 *= factor[i];
    for (auto* side : {&part.section.left, &part.section.right}) {
      for (Lane& lane : *side) lane.width_m.c0 *= factor[i];
    }
  }
}

// The section of a part from s = from_s to to_s, of a road of the given length: where it tapers at either end.
LaneSection LineMaker::tapered(const Part& part, const Part* before, const Part* after, double from_s, double to_s,
                               double length_m) const {
  LaneSection section = part.section;
  section.s_m = from_s;
  const bool at_start = before && part.taper_start_m > 0 && from_s == 0;
  const bool at_end = !at_start && after && part.taper_end_m > 0 && to_s == length_m;
  if (!at_start && !at_end) return section;
  const Part& other = at_start ? *before : *after;
  const double long_m = to_s - from_s;
  const auto taper = [&](double joint, double own) {
    return at_start ? Cubic::hermite(joint, 0, own, 0, long_m) : Cubic::hermite(own, 0, joint, 0, long_m);
  };
  const auto side = [&](std::vector<Lane>& lanes, const std::vector<Lane>& others) {
    const std::vector<double> widths = joint_widths(lanes, others);
    for (std::size_t i = 0; i < lanes.size(); ++i) lanes[i].width_m = taper(widths[i], lanes[i].width_m.c0);
  };
  section.offset_m = taper(joint_offset_m(section, other.section), section.offset_m.c0);
  side(section.left, other.section.left);
  side(section.right, other.section.right);
  return section;
}

Result<Road> LineMaker::part_road(const Road& whole, std::size_t i) {
  const Part& part = parts_[i];
  const auto [begin, end] = segments_of(whole, i);
  Road road;
  road.id = plan_.ids[part.piece];
  if (end <= begin) {
    return Error{ErrorCode::kGeometry, "has a stretch without length", {}, 0, element()};
  }
  const double s0 = whole.segments[begin].s_start_m;
  const auto s_of = [&](double at) { return whole.segments[segment_at(whole, at)].s_start_m - s0; };
  const WayTags& of = tags(part.piece);
  road.name = scene_.data.names[of.name];
  road.road_class = highway_class(of.highway).name;
  road.keep_left = scene_.keep_left;
  road.closed = whole.closed && parts_.size() == 1;
  road.joined_start = i > 0 || plan_.joined_start || (line_.closed && !road.closed);
  road.joined_end = i + 1 < parts_.size() || plan_.joined_end || (line_.closed && !road.closed);
  road.segments.assign(whole.segments.begin() + static_cast<std::ptrdiff_t>(begin),
                       whole.segments.begin() + static_cast<std::ptrdiff_t>(end));
  chain_arc_lengths(road);
  const double length = road.length_m();
  std::vector<double> from = {0};
  if (part.taper_start_m > 0) from.push_back(s_of(part.start_m + part.taper_start_m));
  if (part.taper_end_m > 0) from.push_back(s_of(part.end_m - part.taper_end_m));
  std::vector<LaneSection> sections;
  for (std::size_t k = 0; k < from.size(); ++k) {
    const double to = k + 1 < from.size() ? from[k + 1] : length;
    sections.push_back(tapered(part, i > 0 ? &parts_[i - 1] : nullptr, i + 1 < parts_.size() ? &parts_[i + 1] : nullptr,
                               from[k], to, length));
  }
  if (Status s = set_sections(road, std::move(sections)); !s) return s.error();
  add_structures(road, of, i == 0 && plan_.touches_start, i + 1 == parts_.size() && plan_.touches_end);
  return road;
}

Result<LineRoads> LineMaker::run() {
  find_parts();
  find_tapers();
  Result<Road> whole = whole_road();
  if (!whole) {
    Error error = whole.error();
    error.element = element();
    return error;
  }
  LineRoads made;
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    Result<Road> road = part_road(*whole, i);
    if (!road) return road.error();
    std::vector<Sample> samples;
    const auto add = [&](double at) {
      samples.push_back({course_.point_at(at), plan_.heights ? plan_.heights->value(at).z_m : 0});
    };
    add(parts_[i].start_m);
    for (std::size_t k = 0; k < course_.points_m.size(); ++k) {
      if (course_.at_m[k] > parts_[i].start_m && course_.at_m[k] < parts_[i].end_m) add(course_.at_m[k]);
    }
    add(parts_[i].end_m);
    made.certificates.push_back(certify(*road, samples, anchor_p_.size()));
    made.certificates.back().id = road->id;
    made.roads.push_back(std::move(*road));
  }
  for (std::size_t i = 0; i + 1 < made.roads.size(); ++i) link_roads(made.roads[i], true, made.roads[i + 1], false);
  if (line_.closed && made.roads.size() > 1) link_roads(made.roads.back(), true, made.roads.front(), false);
  return made;
}

}  // namespace

void link_roads(Road& a, bool a_at_end, Road& b, bool b_at_end) {
  RoadLink& to = a_at_end ? a.successor : a.predecessor;
  RoadLink& back = b_at_end ? b.successor : b.predecessor;
  to = {RoadLink::To::kRoad, b.id, b_at_end};
  back = {RoadLink::To::kRoad, a.id, a_at_end};
  const LaneSection &from = a_at_end ? a.sections.back() : a.sections.front(),
                    &into = b_at_end ? b.sections.back() : b.sections.front();
  const auto side = [&](const std::vector<Lane>& own, int sign, const std::vector<Lane>& other, int other_sign) {
    const std::vector<std::size_t> match = matching_lanes(own, other);
    for (std::size_t i = 0; i < own.size(); ++i) {
      if (match[i] == kNoLane) continue;
      const int id = sign * static_cast<int>(i + 1), other_id = other_sign * static_cast<int>(match[i] + 1);
      to.lanes.push_back({id, other_id});
      back.lanes.push_back({other_id, id});
    }
  };
  // Of two ends, or two starts, the left side of the one is the right side of the other.
  const bool same = a_at_end != b_at_end;
  side(from.left, 1, same ? into.left : into.right, same ? 1 : -1);
  side(from.right, -1, same ? into.right : into.left, same ? -1 : 1);
  // From left to right, as files have them.
  for (RoadLink* link : {&to, &back}) {
    std::sort(link->lanes.begin(), link->lanes.end(),
              [](const LaneLink& x, const LaneLink& y) { return x.from > y.from; });
  }
}

Result<LineRoads> make_line_roads(const OsmScene& scene, const Course& course, const OsmLine& line,
                                  const LinePlan& plan, ElementFindings& findings) {
  return LineMaker(scene, course, line, plan, findings).run();
}

}  // namespace roadgen
