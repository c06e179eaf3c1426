#include "roadgen/export/mesh.h"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/export/mesh_builder.h"
#include "roadgen/export/sampling.h"

namespace roadgen {
namespace {

constexpr const char* kMaterials[] = {"asphalt", "concrete", "paving", "grass", "gravel", "curbstone"};
constexpr const char* kColors[] = {"white", "yellow", "blue", "green", "red", "orange"};

using Polygon = std::vector<glm::dvec2>;

// A lane's strip on one segment: borders as cubics from the segment's start, heights above the surface at both.
struct Strip {
  Cubic right_m, left_m;
  double right_height_m, left_height_m;
  Material material;
};

// A border's mark and the heights of the lanes on both sides of it.
struct BorderMark {
  Cubic border_m;
  Mark mark;
  double height_m, right_slope, left_slope;  // slopes: of the lanes' heights, to the left
};

// The cross section as it stands over one segment, from right to left.
struct CrossSection {
  std::vector<Strip> strips;
  std::vector<BorderMark> marks;
};

CrossSection cross_section(const LaneSection& section, const Segment& segment, double offset_m) {
  CrossSection result;
  const std::vector<Cubic> borders = section.borders_m();
  const std::size_t right = section.right.size();
  for (std::size_t i = 0; i + 1 < borders.size(); ++i) {
    const bool is_right = i < right;
    const Lane& lane = is_right ? section.right[right - 1 - i] : section.left[i - right];
    const Strip strip{borders[i].shifted(offset_m), borders[i + 1].shifted(offset_m),
                      is_right ? lane.outer_height_m : lane.inner_height_m,
                      is_right ? lane.inner_height_m : lane.outer_height_m, lane.material};
    if ((strip.left_m - strip.right_m).range(segment.arc_m).high > 0) result.strips.push_back(strip);
  }
  for (std::size_t i = 0; i < borders.size(); ++i) {
    const Mark& mark = i < right    ? section.right[right - 1 - i].mark
                       : i == right ? section.center_mark
                                    : section.left[i - right - 1].mark;
    if (mark.kind == MarkKind::kNone || mark.width_m <= 0) continue;
    BorderMark on{borders[i].shifted(offset_m), mark, 0, 0, 0};
    for (const Strip& strip : result.strips) {
      const double width = (strip.left_m - strip.right_m).value(0.5 * segment.arc_m);
      const double slope = width > 0 ? (strip.left_height_m - strip.right_height_m) / width : 0;
      const double middle = on.border_m.value(0.5 * segment.arc_m);
      if (std::abs(strip.left_m.value(0.5 * segment.arc_m) - middle) < 1e-9) {
        on.height_m = std::max(on.height_m, strip.left_height_m), on.right_slope = slope;
      } else if (std::abs(strip.right_m.value(0.5 * segment.arc_m) - middle) < 1e-9) {
        on.height_m = std::max(on.height_m, strip.right_height_m), on.left_slope = slope;
      }
    }
    result.marks.push_back(on);
  }
  return result;
}

// The surface of one segment at any (s, t).
class Place {
 public:
  explicit Place(const Segment& segment) : segment_(segment) {}

  struct Vertex {
    glm::dvec3 position_m, normal;
  };
  // lift_slope: of the lift, to the left.
  Vertex at(double s_m, double t_m, double lift_m, double lift_slope) const {
    const double u = u_at_arc(segment_, s_m), heading = heading_rad(segment_, u);
    const glm::dvec2 ahead(std::cos(heading), std::sin(heading)), left(-ahead.y, ahead.x);
    const double n = t_m * std::cos(segment_.superelevation_rad.value(s_m));
    const Lib::SurfaceSlope slope = surface_at(segment_, s_m, n);
    const double bend = std::max(1 - n * curvature_per_m(segment_, u), 0.05);
    const glm::dvec2 gradient = slope.ahead / bend * ahead + (slope.aside + lift_slope) * left;
    return {glm::dvec3(position_m(segment_, u) + n * left, slope.height + lift_m),
            glm::normalize(glm::dvec3(-gradient, 1))};
  }
  // To the left, horizontally.
  glm::dvec3 left(double s_m) const {
    const double heading = heading_rad(segment_, u_at_arc(segment_, s_m));
    return {-std::sin(heading), std::cos(heading), 0};
  }

 private:
  const Segment& segment_;
};

class RoadMesher {
 public:
  RoadMesher(const Road& road, double max_error_m, NetworkMesh& mesh)
      : road_(road), max_error_m_(max_error_m), mesh_(mesh) {}

  Status run() {
    for (const Segment& segment : road_.segments) {
      if (!builder_ || glm::distance(origin_m_, segment.start_m) > kItemReach_m) {
        finish();
        origin_m_ = segment.start_m;
        builder_.emplace("road " + road_.id, glm::dvec3(origin_m_, segment.elevation_m.c0));
      }
      if (Status s = add(segment); !s) return s;
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

  Status add(const Segment& segment) {
    const CrossSection section = cross_section(section_of(road_, segment), segment, section_offset_m(road_, segment));
    const SegmentError error(segment);
    const auto worst = [&](int rows) {
      double most = 0;
      for (const Strip& strip : section.strips) {
        const double raised = strip.left_height_m - strip.right_height_m;
        most = std::max(most, error.of_strip(strip.right_m, strip.left_m, raised, segment.arc_m / rows));
      }
      return most;
    };
    const int rows = fewest_rows(segment.arc_m, max_error_m_, worst);
    if (mesh_.triangles + builder_->triangles() + 2 * section.strips.size() * static_cast<std::size_t>(rows) >
        kMostTriangles) {
      return Error{ErrorCode::kData,
                   "the mesh would have more than 50 million triangles; allow a greater error",
                   {},
                   0,
                   "road " + road_.id};
    }
    mesh_.error_m = std::max(mesh_.error_m, worst(rows));
    stations_.resize(static_cast<std::size_t>(rows) + 1);
    for (int i = 0; i <= rows; ++i) stations_[static_cast<std::size_t>(i)] = segment.arc_m * i / rows;
    const Place place(segment);
    add_strips(segment, section, place);
    for (const BorderMark& mark : section.marks) add_mark(segment, mark, place);
    for (const Paint& paint : road_.paint) add_paint(segment, paint, place);
    return Done{};
  }

  struct Edge {
    double t_m, height_m;
  };

  // A strip of quads along the stations; right and left: their edges at a station.
  template <class RightEdge, class LeftEdge>
  void band(MeshPart& part, const std::vector<double>& stations, const Place& place, RightEdge&& right,
            LeftEdge&& left) {
    std::uint32_t before[2] = {0, 0};
    for (std::size_t i = 0; i < stations.size(); ++i) {
      const Edge r = right(stations[i]), l = left(stations[i]);
      const double width = l.t_m - r.t_m, slope = width > 0 ? (l.height_m - r.height_m) / width : 0;
      const Place::Vertex a = place.at(stations[i], r.t_m, r.height_m, slope);
      const Place::Vertex b = place.at(stations[i], l.t_m, l.height_m, slope);
      const std::uint32_t now[2] = {builder_->vertex(part, a.position_m, a.normal),
                                    builder_->vertex(part, b.position_m, b.normal)};
      if (i > 0) builder_->quad(part, before[0], now[0], now[1], before[1]);
      before[0] = now[0], before[1] = now[1];
    }
  }

  void add_strips(const Segment& segment, const CrossSection& section, const Place& place) {
    const auto is_zero = [](const Linear& l) { return l.c0 == 0 && l.c1 == 0; };
    const bool has_crown = !is_zero(segment.crossfall_left) || !is_zero(segment.crossfall_right);
    double outside_m = 0;  // height of what lies to the right
    for (std::size_t i = 0; i <= section.strips.size(); ++i) {
      const bool is_last = i == section.strips.size();
      const double here_m = is_last ? 0 : section.strips[i].right_height_m;
      if (!section.strips.empty() && here_m != outside_m) {
        add_face(is_last ? section.strips.back().left_m : section.strips[i].right_m, outside_m, here_m, place);
      }
      if (is_last) break;
      const Strip& strip = section.strips[i];
      MeshPart& part = builder_->part(kMaterials[static_cast<int>(strip.material)], albedo(strip.material));
      const auto right = [&](double s) { return Edge{strip.right_m.value(s), strip.right_height_m}; };
      const auto left = [&](double s) {
        return Edge{std::max(strip.left_m.value(s), strip.right_m.value(s)), strip.left_height_m};
      };
      const auto crown = [&](double s) {
        const Edge r = right(s), l = left(s);
        const double t = std::clamp(0.0, r.t_m, l.t_m);
        const double w = l.t_m > r.t_m ? (t - r.t_m) / (l.t_m - r.t_m) : 0;
        return Edge{t, r.height_m + w * (l.height_m - r.height_m)};
      };
      const bool spans = strip.right_m.range(segment.arc_m).low < 0 && strip.left_m.range(segment.arc_m).high > 0;
      if (has_crown && spans) {
        band(part, stations_, place, right, crown);
        band(part, stations_, place, crown, left);
      } else {
        band(part, stations_, place, right, left);
      }
      outside_m = strip.left_height_m;
    }
  }

  // A vertical face along a border, open toward its lower side.
  void add_face(const Cubic& border_m, double right_height_m, double left_height_m, const Place& place) {
    MeshPart& part = builder_->part(kMaterials[static_cast<int>(Material::kCurbstone)], albedo(Material::kCurbstone));
    std::uint32_t before[2] = {0, 0};
    for (std::size_t i = 0; i < stations_.size(); ++i) {
      const double s = stations_[i], t = border_m.value(s);
      const glm::dvec3 normal = (right_height_m < left_height_m ? -1.0 : 1.0) * place.left(s);
      const std::uint32_t now[2] = {builder_->vertex(part, place.at(s, t, right_height_m, 0).position_m, normal),
                                    builder_->vertex(part, place.at(s, t, left_height_m, 0).position_m, normal)};
      // Seen from the right the left lane's edge is above where that lane is the higher, else seen from the left below:
      // the same turn either way.
      if (i > 0) builder_->quad(part, before[0], now[0], now[1], before[1]);
      before[0] = now[0], before[1] = now[1];
    }
  }

  // The part of the stations between from and to, with these.
  std::vector<double> stations_between(double from_m, double to_m) const {
    std::vector<double> part{from_m};
    for (const double s : stations_) {
      if (s > from_m && s < to_m) part.push_back(s);
    }
    part.push_back(to_m);
    return part;
  }

  void add_mark(const Segment& segment, const BorderMark& on, const Place& place) {
    const Mark& m = on.mark;
    const auto line = [&](double low, double high, bool is_broken) {
      const double offset = section_offset_m(road_, segment) + m.phase_m, period = m.on_m + m.off_m;
      const bool has_gaps = is_broken && m.off_m > 0 && m.on_m > 0;
      const double first = has_gaps ? std::floor(offset / period) : 0;
      const double last = has_gaps ? std::floor((offset + segment.arc_m) / period) : 0;
      for (double dash = first; dash <= last; ++dash) {
        const double from = has_gaps ? std::max(dash * period - offset, 0.0) : 0;
        const double to = has_gaps ? std::min(dash * period + m.on_m - offset, segment.arc_m) : segment.arc_m;
        if (to - from < 1e-3) continue;
        piece(on, low, std::min(high, 0.0), from, to, place);
        piece(on, std::max(low, 0.0), high, from, to, place);
      }
    };
    const double near = 0.5 * m.space_m;
    switch (m.kind) {
      case MarkKind::kNone: break;
      case MarkKind::kSolid:
      case MarkKind::kBroken: line(-0.5 * m.width_m, 0.5 * m.width_m, m.kind == MarkKind::kBroken); break;
      default:
        line(-near - m.width_m, -near, m.kind == MarkKind::kBrokenSolid || m.kind == MarkKind::kBrokenBroken);
        line(near, near + m.width_m, m.kind == MarkKind::kSolidBroken || m.kind == MarkKind::kBrokenBroken);
    }
  }

  // Of a mark, what lies between two offsets from the border on one side of it.
  void piece(const BorderMark& on, double low, double high, double from_m, double to_m, const Place& place) {
    if (high <= low) return;
    const double slope = low < 0 ? on.right_slope : on.left_slope;
    const auto edge = [&](double off) {
      return [&on, slope, off](double s) {
        return Edge{on.border_m.value(s) + off, on.height_m + kMarkLift_m + slope * off};
      };
    };
    const auto color = static_cast<std::size_t>(on.mark.color);
    band(builder_->part(kColors[color], Lib::marking_color(static_cast<int>(color))), stations_between(from_m, to_m),
         place, edge(low), edge(high));
  }

  static Polygon clipped(const Polygon& polygon, int axis, double limit, double sign) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const glm::dvec2 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
      const double dp = sign * (p[axis] - limit), dq = sign * (q[axis] - limit);
      if (dp >= 0) kept.push_back(p);
      if ((dp > 0 && dq < 0) || (dp < 0 && dq > 0)) kept.push_back(p + dp / (dp - dq) * (q - p));
    }
    return kept;
  }

  void add_paint(const Segment& segment, const Paint& paint, const Place& place) {
    const double from = paint.s_m - segment.s_start_m - 0.5 * paint.length_m;
    if (from > segment.arc_m || from + paint.length_m < 0) return;
    const LaneSection& section = section_of(road_, segment);
    const double offset = section_offset_m(road_, segment);
    const auto color = static_cast<std::size_t>(paint.color);
    MeshPart& part = builder_->part(kColors[color], Lib::marking_color(static_cast<int>(color)));
    for (Polygon whole : outlines(paint)) {
      for (glm::dvec2& p : whole) p += glm::dvec2(paint.s_m - segment.s_start_m, paint.t_m);
      for (std::size_t i = 0; i + 1 < stations_.size(); ++i) {
        const Polygon slab = clipped(clipped(whole, 0, stations_[i], 1), 0, stations_[i + 1], -1);
        for (const double side : {-1.0, 1.0}) {
          const Polygon half = clipped(slab, 1, 0, side);
          std::vector<std::uint32_t> ring;
          for (const glm::dvec2& p : half) {
            const double lift = lane_height_m(section, offset + p.x, p.y) + kMarkLift_m;
            const Place::Vertex v = place.at(p.x, p.y, lift, 0);
            ring.push_back(builder_->vertex(part, v.position_m, v.normal));
          }
          for (std::size_t k = 2; k < ring.size(); ++k) builder_->triangle(part, ring[0], ring[k - 1], ring[k]);
        }
      }
    }
  }

  static glm::dvec3 albedo(Material material) {
    return Lib::material_albedo(static_cast<int>(material), 0.3, 0.3, 0, 0, 1000, 1000);
  }

  const Road& road_;
  double max_error_m_;
  NetworkMesh& mesh_;
  std::optional<MeshBuilder> builder_;
  glm::dvec2 origin_m_{0, 0};
  std::vector<double> stations_;  // of the segment at hand, from its start
};

Polygon box(double x0, double x1, double y0, double y1) { return {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}; }

}  // namespace

std::vector<std::vector<glm::dvec2>> outlines(const Paint& paint) {
  const double length = paint.length_m, width = paint.width_m;
  std::vector<Polygon> result;
  if (paint.kind == PaintKind::kLine) return {box(-0.5 * length, 0.5 * length, -0.5 * width, 0.5 * width)};
  if (paint.kind == PaintKind::kZebra) {
    // A stripe in the middle, then gaps and stripes outward by turns.
    const int most = static_cast<int>(std::min(0.25 * width / paint.stripe_m + 1, 1e4));
    for (int i = -most; i <= most; ++i) {
      const double low = std::max((2 * i - 0.5) * paint.stripe_m, -0.5 * width);
      const double high = std::min((2 * i + 0.5) * paint.stripe_m, 0.5 * width);
      if (low < high) result.push_back(box(-0.5 * length, 0.5 * length, low, high));
    }
    return result;
  }
  // As marking_arrow of shaders/lib/marking.glsl has it.
  const bool left = paint.kind == PaintKind::kArrowLeft || paint.kind == PaintKind::kArrowStraightLeft;
  const bool right = paint.kind == PaintKind::kArrowRight || paint.kind == PaintKind::kArrowStraightRight;
  const bool straight = paint.kind != PaintKind::kArrowLeft && paint.kind != PaintKind::kArrowRight;
  const double shaft = 0.09 * width + 0.02 * length, head = 0.36 * length;
  if (straight) {
    result.push_back(box(-0.5 * length, 0.5 * length - head, -shaft, shaft));
    result.push_back({{0.5 * length, 0}, {0.5 * length - head, 0.3 * width}, {0.5 * length - head, -0.3 * width}});
  }
  if (left || right) {
    const double x = straight ? -0.14 * length : 0.26 * length, reach = 0.5 * width, tip = 0.42 * reach;
    std::vector<Polygon> branch = {box(x - shaft, x + shaft, -shaft, reach - tip + shaft),
                                   {{x, reach}, {x - 0.16 * length, reach - tip}, {x + 0.16 * length, reach - tip}}};
    if (!straight) branch.push_back(box(-0.5 * length - shaft, x + shaft, -shaft, shaft));
    for (Polygon& polygon : branch) {
      if (right) {
        for (glm::dvec2& p : polygon) p.y = -p.y;
        std::reverse(polygon.begin(), polygon.end());
      }
      result.push_back(std::move(polygon));
    }
  }
  if (paint.against) {
    for (Polygon& polygon : result) {
      for (glm::dvec2& p : polygon) p = -p;
    }
  }
  return result;
}

Result<NetworkMesh> tessellate(const Network& network, const MeshOptions& options) {
  if (!(options.max_error_m >= kLeastMeshError_m && options.max_error_m <= 1)) {
    return Error{ErrorCode::kUsage, "the error of a mesh must be from 0.0001 to 1 m"};
  }
  NetworkMesh mesh;
  const std::vector<bool> in_area = roads_in_areas(network);
  for (const Road& road : network.roads) {
    if (in_area[static_cast<std::size_t>(&road - network.roads.data())]) continue;  // the area is drawn
    if (Status s = RoadMesher(road, options.max_error_m, mesh).run(); !s) return s.error();
    if (Status s = add_sweeps(road, options.max_error_m, mesh); !s) return s.error();
  }
  for (const Junction& junction : network.junctions) {
    if (Status s = add_junction(junction, options.max_error_m, mesh); !s) return s.error();
  }
  return mesh;
}

}  // namespace roadgen
