// Sweeps as meshes. A profile becomes a polygon whose corners lie on its edge and whose chords are within half of the
// allowed error of it; the polygon is swept along the road in steps that keep to the other half (SegmentError::of_sweep).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

#include <glm/geometric.hpp>

#include "roadgen/export/mesh_builder.h"
#include "roadgen/export/sampling.h"
#include "roadgen/export/triangulate.h"
#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

constexpr double kTurn = 2 * M_PI;

// A side of a profile between two corners (n, h), with the profile's outward normals there.
struct Side {
  glm::dvec2 from, to, from_normal, to_normal;
};

// A closed polygon, counter-clockwise in (n, h), put together from straight sides and arcs.
class Outline {
 public:
  explicit Outline(double error_m) : error_m_(error_m) {}

  // A straight side from where the outline ends.
  void line(glm::dvec2 to) {
    const glm::dvec2 along = to - ends_.back();
    if (glm::length(along) < 1e-9) return;
    const glm::dvec2 out = glm::normalize(glm::dvec2(along.y, -along.x));
    sides_.push_back({ends_.back(), to, out, out});
    ends_.push_back(to);
  }
  // Around the centre, from one angle to another; outward: whether the normal points away from the centre.
  void arc(glm::dvec2 centre, double radius, double from, double to) {
    if (radius < 1e-9 || std::abs(to - from) < 1e-9) return;
    const double sign = to > from ? 1 : -1;
    const double step = 2 * std::acos(std::max(1 - error_m_ / radius, 0.5));
    const int count = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / step)));
    const auto out = [&](int i) {
      const double angle = from + (to - from) * i / count;
      return glm::dvec2(std::cos(angle), std::sin(angle));
    };
    if (ends_.empty()) start(centre + radius * out(0));
    for (int i = 1; i <= count; ++i) {
      const glm::dvec2 p = centre + radius * out(i);
      sides_.push_back({ends_.back(), p, sign * out(i - 1), sign * out(i)});
      ends_.push_back(p);
    }
  }
  void start(glm::dvec2 at) { ends_ = {at}; }
  // Ends at the start, which rounding may have missed.
  std::vector<Side> take() {
    line(ends_.front());
    sides_.back().to = sides_.front().from;
    return std::move(sides_);
  }

 private:
  double error_m_;
  std::vector<glm::dvec2> ends_;
  std::vector<Side> sides_;
};

std::vector<Side> circle(double radius, double error_m) {
  Outline outline(error_m);
  outline.arc({0, 0}, radius, 0, kTurn);
  return outline.take();
}

// Around the zigzag of the sheet at half its thickness: along one side, around the end, and back.
std::vector<Side> beam(const Lib::SweepProfile& p, double error_m) {
  std::vector<glm::dvec2> middle;
  for (int i = -5; i <= 5; ++i) {
    if (i == 0) continue;  // on the straight part between its neighbours
    const glm::dvec2 corner = Lib::sweep_beam_corner(std::abs(i));
    middle.emplace_back(p.p3 * corner.x * p.p1, (i < 0 ? -1 : 1) * corner.y * p.p0);
  }
  const double thick = p.p2;
  Outline outline(error_m);
  const auto angle_of = [](glm::dvec2 out) { return std::atan2(out.y, out.x); };
  for (const bool back : {false, true}) {
    const auto at = [&](std::size_t i) { return back ? middle[middle.size() - 1 - i] : middle[i]; };
    const auto out = [&](std::size_t i) {
      const glm::dvec2 along = glm::normalize(at(i + 1) - at(i));
      return glm::dvec2(along.y, -along.x);
    };
    if (!back) outline.start(at(0) + thick * out(0));
    for (std::size_t i = 1; i + 1 < middle.size(); ++i) {
      const glm::dvec2 before = out(i - 1), after = out(i);
      const double turn = std::asin(std::clamp(before.x * after.y - before.y * after.x, -1.0, 1.0));
      if (turn > 0) {
        outline.line(at(i) + thick * before);
        outline.arc(at(i), thick, angle_of(before), angle_of(before) + turn);
      } else {
        outline.line(at(i) + thick * (before + after) / (1 + glm::dot(before, after)));
      }
    }
    const std::size_t last = middle.size() - 1;
    outline.line(at(last) + thick * out(last - 1));
    outline.arc(at(last), thick, angle_of(out(last - 1)), angle_of(out(last - 1)) + M_PI);
  }
  return outline.take();
}

// Over a vault from its right side to its left, seen from outside (a lining's outer face), or back under it. at_n: where
// its sides begin.
void over_vault(Outline& outline, double at_n, double centre, double radius, bool back) {
  const double rise = std::sqrt(std::max(radius * radius - at_n * at_n, 0.0)), angle = std::atan2(rise, at_n);
  outline.line({back ? -at_n : at_n, centre + rise});
  outline.arc({0, centre}, radius, back ? M_PI - angle : angle, back ? angle : M_PI - angle);
}

std::vector<Side> lining(const Lib::SweepProfile& p, double error_m) {
  Outline outline(error_m);
  const double out = p.p0 + p.p3;
  outline.start({out, -p.p4});
  over_vault(outline, out, p.p1, p.p2 + p.p3, false);
  outline.line({-out, -p.p4});
  // The walkways, which a low arch may cut short.
  const double rise = std::max(SWEEP_WALKWAY - p.p1, 0.0);
  const double top_n = std::min(p.p0, std::sqrt(std::max(p.p2 * p.p2 - rise * rise, 0.0)));
  const bool seen = p.p5 < top_n;
  outline.line({-p.p5, -p.p4});
  if (seen) {
    outline.line({-p.p5, SWEEP_WALKWAY});
    outline.line({-top_n, SWEEP_WALKWAY});
  }
  over_vault(outline, seen ? top_n : p.p5, p.p1, p.p2, true);
  if (seen) {
    outline.line({top_n, SWEEP_WALKWAY});
    outline.line({p.p5, SWEEP_WALKWAY});
  }
  outline.line({p.p5, -p.p4});
  return outline.take();
}

std::vector<Side> head_wall(const Lib::SweepProfile& p, double error_m) {
  Outline outline(error_m);
  outline.start({p.p3, -p.p4});
  outline.line({p.p3, p.p5});
  outline.line({-p.p3, p.p5});
  outline.line({-p.p3, -p.p4});
  outline.line({-p.p0, -p.p4});
  over_vault(outline, p.p0, p.p1, p.p2, true);
  outline.line({p.p0, -p.p4});
  return outline.take();
}

std::vector<Side> profile_sides(const Lib::SweepProfile& profile, double error_m) {
  switch (profile.kind) {
    case SWEEP_TUBE: return circle(profile.p0, error_m);
    case SWEEP_BEAM: return beam(profile, error_m);
    case SWEEP_LINING: return lining(profile, error_m);
    default: return head_wall(profile, error_m);
  }
}

std::string part_name(const Sweep& sweep) {
  constexpr const char* kNames[] = {"tunnel", "guard rail", "pipe", "cable"};
  const char* const kind = kNames[static_cast<std::size_t>(sweep.kind())];
  if (!sweep.albedo) return kind;
  char text[96];
  std::snprintf(text, sizeof text, "%s %.9g %.9g %.9g", kind, sweep.albedo->x, sweep.albedo->y, sweep.albedo->z);
  return text;
}

// A piece's cross sections in the world.
class Course {
 public:
  Course(const Segment& segment, const Lib::SweepPath& path) : segment_(segment), path_(path) {}

  // At s from the segment's start: point (0, 0) of the profile, and the directions ahead and to the left.
  struct Section {
    glm::dvec3 origin_m, ahead, left;
    double along_n = 0, along_h = 0;  // slopes of the axis per metre of s, aside and up
    double curvature = 0, n_m = 0;    // of the centre line, and the axis from it
  };
  Section at(double s_m) const {
    const double u = u_at_arc(segment_, s_m), heading = heading_rad(segment_, u);
    const glm::dvec3 ahead(std::cos(heading), std::sin(heading), 0), left(-ahead.y, ahead.x, 0);
    const double n = path_.n0 + path_.n1 * s_m;
    const double z = segment_.elevation_m.c0 + Lib::road_cubic(s_m, path_.z0, path_.z1, path_.z2, path_.z3);
    return {glm::dvec3(position_m(segment_, u), z) + n * left,
            ahead,
            left,
            path_.n1,
            Lib::road_dcubic(s_m, path_.z1, path_.z2, path_.z3),
            curvature_per_m(segment_, u),
            n};
  }
  static glm::dvec3 point(const Section& c, glm::dvec2 p) { return c.origin_m + p.x * c.left + glm::dvec3(0, 0, p.y); }
  // Of the swept surface, from the profile's: the gradient of D(n, h) in space.
  static glm::dvec3 normal(const Section& c, glm::dvec2 p, glm::dvec2 m) {
    const double stretch = std::max(1 - (c.n_m + p.x) * c.curvature, 0.05);
    const double along = -(m.x * c.along_n + m.y * c.along_h) / stretch;
    return glm::normalize(along * c.ahead + m.x * c.left + glm::dvec3(0, 0, m.y));
  }

 private:
  const Segment& segment_;
  const Lib::SweepPath& path_;
};

class SweepMesher {
 public:
  SweepMesher(const Road& road, std::size_t sweep, double max_error_m, NetworkMesh& mesh)
      : road_(road), sweep_(sweep), max_error_m_(max_error_m), mesh_(mesh) {}

  Status run() {
    const std::vector<SweepPart> parts = sweep_parts(road_, sweep_);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const SweepPart& part = parts[i];
      const Segment& segment = road_.segments[part.segment];
      if (!builder_ || glm::distance(origin_m_, segment.start_m) > kItemReach_m) {
        finish();
        origin_m_ = segment.start_m;
        builder_.emplace("structure " + std::to_string(sweep_ + 1) + " of road " + road_.id,
                         glm::dvec3(origin_m_, segment.elevation_m.c0));
      }
      const bool begins = i == 0 || !goes_on(parts[i - 1], part);
      const bool ends = i + 1 == parts.size() || !goes_on(part, parts[i + 1]);
      if (Status s = add(segment, part, begins, ends); !s) return s;
    }
    finish();
    return Done{};
  }

 private:
  void finish() {
    if (!builder_) return;
    mesh_.triangles += builder_->triangles();
    mesh_.items.push_back(builder_->take());
    builder_.reset();
  }

  double s_m(const SweepPart& part, double u) const {
    const Segment& segment = road_.segments[part.segment];
    return segment.s_start_m + arc_at(segment, u);
  }
  // Whether the profile of one part goes on in the next.
  bool goes_on(const SweepPart& part, const SweepPart& next) const {
    return part.piece.profile.kind == next.piece.profile.kind &&
           std::abs(s_m(part, part.piece.u1) - s_m(next, next.piece.u0)) < 1e-6;
  }

  // begins, ends: whether there is a cap.
  Status add(const Segment& segment, const SweepPart& part, bool begins, bool ends) {
    const Lib::SweepPiece& piece = part.piece;
    const Lib::SweepPath& path = piece.path;
    const Course course(segment, path);
    const std::vector<Side> sides = profile_sides(piece.profile, 0.5 * max_error_m_);
    double most_n = 0, widest = 0;
    for (const Side& side : sides) {
      most_n = std::max(most_n, std::abs(side.from.x));
      widest = std::max(widest, std::abs(side.to.x - side.from.x));
    }
    const double s0 = arc_at(segment, piece.u0), s1 = arc_at(segment, piece.u1);
    const double n0 = std::abs(path.n0 + path.n1 * s0), n1 = std::abs(path.n0 + path.n1 * s1);
    const double second = std::max(std::abs(2 * path.z2 + 6 * path.z3 * s0), std::abs(2 * path.z2 + 6 * path.z3 * s1));
    const SegmentError error(segment);
    const auto worst = [&](int rows) {
      return error.of_sweep(std::max(n0, n1) + most_n, std::abs(path.n1), second, widest, (s1 - s0) / rows);
    };
    const int rows = fewest_rows(s1 - s0, 0.5 * max_error_m_, worst);
    const auto round = static_cast<int>(sides.size());
    const double posts = piece.posts.count * 4 * (round + 2);
    if (static_cast<double>(mesh_.triangles + builder_->triangles()) + 2.0 * rows * round + posts > kMostTriangles) {
      return Error{ErrorCode::kData,
                   "the mesh would have more than 50 million triangles; allow a greater error",
                   {},
                   0,
                   "road " + road_.id};
    }
    mesh_.error_m = std::max(mesh_.error_m, 0.5 * max_error_m_ + worst(rows));
    MeshPart& into = builder_->part(part_name(road_.sweeps[sweep_]), part.albedo);
    std::vector<std::uint32_t> before;
    for (int i = 0; i <= rows; ++i) {
      const Course::Section c = course.at(s0 + (s1 - s0) * i / rows);
      std::vector<std::uint32_t> now;
      for (const Side& side : sides) {
        now.push_back(
            builder_->vertex(into, Course::point(c, side.from), Course::normal(c, side.from, side.from_normal)));
        now.push_back(builder_->vertex(into, Course::point(c, side.to), Course::normal(c, side.to, side.to_normal)));
      }
      for (std::size_t k = 0; k < now.size() && i > 0; k += 2) {
        builder_->quad(into, before[k], before[k + 1], now[k + 1], now[k]);
      }
      before = std::move(now);
    }
    if (begins) add_cap(into, sides, course.at(s0), false);
    if (ends) add_cap(into, sides, course.at(s1), true);
    add_posts(into, course, piece);
    return Done{};
  }

  void add_cap(MeshPart& part, const std::vector<Side>& sides, const Course::Section& c, bool ahead) {
    std::vector<glm::dvec2> ring;
    for (const Side& side : sides) ring.push_back(side.from);
    const glm::dvec3 normal = ahead ? c.ahead : -c.ahead;
    for (const auto& t : triangulated(ring)) {
      std::uint32_t v[3];
      for (int k = 0; k < 3; ++k)
        v[k] = builder_->vertex(part, Course::point(c, t[static_cast<std::size_t>(k)]), normal);
      ahead ? builder_->triangle(part, v[0], v[1], v[2]) : builder_->triangle(part, v[0], v[2], v[1]);
    }
  }

  // Upright prisms over a rectangle or a circle, with tops and bottoms.
  void add_posts(MeshPart& part, const Course& course, const Lib::SweepPiece& piece) {
    const Lib::SweepPosts& posts = piece.posts;
    if (posts.count < 0.5) return;
    std::vector<Side> sides;  // ahead and to the left of the post
    if (posts.half_s < 0) {
      sides = circle(posts.half_n, max_error_m_);
    } else {
      Outline outline(max_error_m_);
      outline.start({posts.half_s, -posts.half_n});
      outline.line({posts.half_s, posts.half_n});
      outline.line({-posts.half_s, posts.half_n});
      outline.line({-posts.half_s, -posts.half_n});
      sides = outline.take();
    }
    for (int i = 0; i < static_cast<int>(posts.count); ++i) {
      const Course::Section c = course.at(posts.first + i * posts.spacing);
      const glm::dvec3 foot = Course::point(c, {posts.n, posts.low}), up(0, 0, posts.high - posts.low);
      const auto across = [&](glm::dvec2 p) { return p.x * c.ahead + p.y * c.left; };
      std::vector<std::uint32_t> tops, bottoms;
      for (const Side& side : sides) {
        const glm::dvec3 a = foot + across(side.from), b = foot + across(side.to);
        const glm::dvec3 m = across(side.from_normal), q = across(side.to_normal);
        const std::uint32_t low[2] = {builder_->vertex(part, a, m), builder_->vertex(part, b, q)};
        const std::uint32_t high[2] = {builder_->vertex(part, a + up, m), builder_->vertex(part, b + up, q)};
        builder_->quad(part, low[0], low[1], high[1], high[0]);
        bottoms.push_back(builder_->vertex(part, a, {0, 0, -1}));
        tops.push_back(builder_->vertex(part, a + up, {0, 0, 1}));
      }
      for (std::size_t k = 2; k < tops.size(); ++k) {
        builder_->triangle(part, tops[0], tops[k - 1], tops[k]);
        builder_->triangle(part, bottoms[0], bottoms[k], bottoms[k - 1]);
      }
    }
  }

  const Road& road_;
  std::size_t sweep_;
  double max_error_m_;
  NetworkMesh& mesh_;
  std::optional<MeshBuilder> builder_;
  glm::dvec2 origin_m_{0, 0};
};

}  // namespace

Status add_sweeps(const Road& road, double max_error_m, NetworkMesh& mesh) {
  for (std::size_t i = 0; i < road.sweeps.size(); ++i) {
    if (Status s = SweepMesher(road, i, max_error_m, mesh).run(); !s) return s;
  }
  return Done{};
}

}  // namespace roadgen
