#include "roadgen/import/osm_overlaps.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kCell_m = 64, kStep_m = 32;
constexpr double kReach_m = 20;  // beyond which no two carriageways overlap
constexpr int kMostSteps = 200;  // along one leg

struct Leg {
  std::uint32_t line, way;
  double at_m;  // of its start, along the line
  glm::dvec2 a, b;
  float half_m;
};

struct Near {
  double distance_m, first, second;  // and the parts of both legs where they are that close
};

// Of segments that do not cross, one end is nearest.
Near nearest(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c, glm::dvec2 d) {
  const auto cross = [](glm::dvec2 p, glm::dvec2 q) { return p.x * q.y - p.y * q.x; };
  const glm::dvec2 u = b - a, v = d - c;
  const double sine = cross(u, v);
  if (sine != 0) {
    const double s = cross(c - a, v) / sine, t = cross(c - a, u) / sine;
    if (s >= 0 && s <= 1 && t >= 0 && t <= 1) return {0, s, t};
  }
  const auto part = [](glm::dvec2 p, glm::dvec2 from, glm::dvec2 along) {
    const double square = glm::dot(along, along);
    return square > 0 ? std::clamp(glm::dot(p - from, along) / square, 0.0, 1.0) : 0.0;
  };
  Near best{1e300, 0, 0};
  const auto take = [&](double s, double t) {
    const double distance = glm::length(a + s * u - c - t * v);
    if (distance < best.distance_m) best = {distance, s, t};
  };
  take(0, part(a, c, v));
  take(1, part(b, c, v));
  take(part(c, a, u), 0);
  take(part(d, a, u), 1);
  return best;
}

class OverlapFinder {
 public:
  OverlapFinder(const OsmScene& scene, const OsmJunctions& junctions, const std::vector<HeightProfile>& heights,
                ElementFindings& findings)
      : scene_(scene), junctions_(junctions), heights_(heights), findings_(findings) {}

  void run() {
    find_junctions();
    take_legs();
    std::sort(cells_.begin(), cells_.end());
    for (std::size_t begin = 0; begin < cells_.size();) {
      std::size_t end = begin + 1;
      while (end < cells_.size() && cells_[end].first == cells_[begin].first) ++end;
      const std::size_t last = std::min(end, begin + kMostCrowded);
      for (std::size_t i = begin; i < last; ++i) {
        for (std::size_t k = i + 1; k < last; ++k) test(legs_[cells_[i].second], legs_[cells_[k].second]);
      }
      begin = end;
    }
  }

 private:
  // What meets at each end: the junction that has an area, or else the node.
  void find_junctions() {
    at_end_.resize(2 * scene_.graph.lines.size());
    has_area_.assign(at_end_.size(), 0);
    for (std::size_t i = 0; i < scene_.graph.lines.size(); ++i) {
      at_end_[2 * i] = scene_.graph.lines[i].node_start;
      at_end_[2 * i + 1] = scene_.graph.lines[i].node_end;
    }
    for (const OsmJunction& junction : junctions_.all) {
      for (const LineEnd end : junction.ends) at_end_[end] = junction.node, has_area_[end] = 1;
    }
  }

  void take_legs() {
    Course course;
    for (std::size_t i = 0; i < scene_.graph.lines.size(); ++i) {
      if (junctions_.absorbed[i]) continue;
      load_course(scene_, scene_.graph.lines[i], course);
      if (course.points_m.empty()) continue;
      lengths_.resize(i + 1, 0);
      lengths_[i] = static_cast<float>(course.length_m());
      for (std::size_t p = 0; p < course.pieces.size(); ++p) {
        const std::uint32_t way = course.pieces[p].way;
        const SectionEdges edges = edges_of_way(scene_.data.ways[way].tags, course.pieces[p].along(), scene_.keep_left);
        for (std::size_t k = course.starts[p]; k < course.starts[p + 1]; ++k) {
          add(Leg{static_cast<std::uint32_t>(i), way, course.at_m[k], course.points_m[k], course.points_m[k + 1],
                  static_cast<float>(0.5 * (edges.left_m - edges.right_m))});
        }
      }
    }
    lengths_.resize(scene_.graph.lines.size(), 0);
  }

  // To the cells that it comes near.
  void add(const Leg& leg) {
    const double length = glm::length(leg.b - leg.a);
    const int steps = 1 + static_cast<int>(std::min(length / kStep_m, kMostSteps - 1.0));
    std::vector<std::uint64_t>& seen = seen_;
    seen.clear();
    for (int i = 0; i <= steps; ++i) {
      const glm::dvec2 p = leg.a + (leg.b - leg.a) * (static_cast<double>(i) / steps);
      for (const double dx : {-kReach_m, kReach_m}) {
        for (const double dy : {-kReach_m, kReach_m}) {
          const auto x = static_cast<std::int64_t>(std::floor((p.x + dx) / kCell_m)),
                     y = static_cast<std::int64_t>(std::floor((p.y + dy) / kCell_m));
          seen.push_back(static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y));
        }
      }
    }
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    for (const std::uint64_t cell : seen) cells_.emplace_back(cell, static_cast<std::uint32_t>(legs_.size()));
    legs_.push_back(leg);
  }

  // How much of a line lies in an area that both have.
  struct Shared {
    double start_m = 0, end_m = 0;
    bool touch = false;  // they meet at a node without an area
  };
  Shared shared(std::uint32_t line, std::uint32_t other) const {
    Shared found;
    for (const std::size_t end : {2 * std::size_t{line}, 2 * std::size_t{line} + 1}) {
      for (const std::size_t at : {2 * std::size_t{other}, 2 * std::size_t{other} + 1}) {
        if (at_end_[end] != at_end_[at]) continue;
        if (!has_area_[end] || !has_area_[at]) found.touch = true;
        (end % 2 == 0 ? found.start_m : found.end_m) = junctions_.cut_m[end];
      }
    }
    return found;
  }

  double height_m(std::uint32_t line, double at_m) const {
    return heights_.empty() ? 0 : heights_[line].value(at_m).z_m;
  }

  void test(const Leg& x, const Leg& y) {
    if (x.line == y.line) return;
    const double needed = kOverlap * (x.half_m + y.half_m);
    const auto apart = [&](double a, double b, double c, double d) {
      return std::min(a, b) - needed > std::max(c, d) || std::max(a, b) + needed < std::min(c, d);
    };
    if (apart(x.a.x, x.b.x, y.a.x, y.b.x) || apart(x.a.y, x.b.y, y.a.y, y.b.y)) return;
    const Shared of_x = shared(x.line, y.line), of_y = shared(y.line, x.line);
    if (of_x.touch || of_y.touch) return;
    glm::dvec2 ends[4];
    double at[2][2];
    const auto clip = [&](const Leg& leg, const Shared& by, glm::dvec2* to, double* range) {
      const double length = glm::length(leg.b - leg.a);
      range[0] = std::max(leg.at_m, by.start_m);
      range[1] = std::min(leg.at_m + length, lengths_[leg.line] - by.end_m);
      if (!(range[0] < range[1])) return false;
      const glm::dvec2 along = (leg.b - leg.a) / length;
      to[0] = leg.a + (range[0] - leg.at_m) * along;
      to[1] = leg.a + (range[1] - leg.at_m) * along;
      return true;
    };
    if (!clip(x, of_x, ends, at[0]) || !clip(y, of_y, ends + 2, at[1])) return;
    const Near near = nearest(ends[0], ends[1], ends[2], ends[3]);
    if (near.distance_m >= needed) return;
    const double dz = height_m(x.line, at[0][0] + near.first * (at[0][1] - at[0][0])) -
                      height_m(y.line, at[1][0] + near.second * (at[1][1] - at[1][0]));
    if (std::abs(dz) >= 0.5 * kLevel_m) return;
    if (!told_.emplace(std::min(x.line, y.line), std::max(x.line, y.line)).second) return;
    const std::int64_t own = scene_.data.ways[x.way].id, other = scene_.data.ways[y.way].id;
    const std::string what = own == other ? "itself" : "way " + std::to_string(other);
    char distance[32];
    std::snprintf(distance, sizeof distance, "lies %.1f m beside ", near.distance_m);
    findings_.add(Severity::kWarning, "ways that overlap", "way " + std::to_string(own),
                  near.distance_m == 0 ? "crosses " + what + " at its height without a node: the roads overlap"
                                       : distance + what + " at its height, too near for both: the roads overlap");
  }

  const OsmScene& scene_;
  const OsmJunctions& junctions_;
  const std::vector<HeightProfile>& heights_;
  ElementFindings& findings_;
  std::vector<std::uint32_t> at_end_;  // [LineEnd]
  std::vector<char> has_area_;         // [LineEnd]
  std::vector<Leg> legs_;
  std::vector<float> lengths_;  // [line]
  std::vector<std::pair<std::uint64_t, std::uint32_t>> cells_;
  std::vector<std::uint64_t> seen_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> told_;
};

}  // namespace

void find_overlaps(const OsmScene& scene, const OsmJunctions& junctions, const std::vector<HeightProfile>& heights,
                   ElementFindings& findings) {
  OverlapFinder(scene, junctions, heights, findings).run();
}

}  // namespace roadgen
