#include "roadgen/import/osm_junctions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include <glm/geometric.hpp>

#include "roadgen/road/parallel.h"

namespace roadgen {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kLeastCut_m = 1;           // so that an area has a length
constexpr double kLeastRoad_m = 1;          // of what is left between two areas
constexpr double kWantedRoad_m = 6;         // likewise, where corners may be smaller for it
constexpr double kLeastRadius_m = 1;        // of a corner where space is short
constexpr double kGore_rad = kPi / 7;       // lines that part at less have a gore between them
constexpr double kGoreNose_m = 0.6;         // its width where the roads end
constexpr double kLongestGore_m = 80;       // from the node
constexpr double kStraight_rad = kPi / 12;  // what goes on with less of a turn has no corner
// A line longer than this stays, whatever its ends ask for.
constexpr double kLongestVanishing_m = 30;
constexpr int kMostMergings = 12;
// What cuts are tried, as parts of those asked for.
constexpr double kTries[] = {1, 1.3, 1.7, 2.2, 0.75, 0.5};
constexpr double kMostGrowth_m = 30;
constexpr double kCoverStep_m = 6;    // between places where an area is looked at
constexpr double kLeastCover = 0.25;  // of a carriageway's half that the area must hold
constexpr std::size_t kChunk = 512;
constexpr std::string_view kNameless = "junction : ";

glm::dvec2 left_of(glm::dvec2 d) { return {-d.y, d.x}; }
double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

// An end of a line at a junction, and what is to be cut off it.
struct Arm {
  LineEnd end;
  Course course;
  double bearing_rad = 0;
  double least_m = kLeastCut_m, wanted_m = kLeastCut_m;
};

EndView view(const OsmScene& scene, const Arm& arm) { return {scene, arm.course, is_at_end(arm.end)}; }

struct PairCut {
  double first_m, second_m;
};

// Where two lines that part are so far apart that a nose fits between their carriageways, side by side.
PairCut gore_cut(const EndView& a, const EndView& b) {
  const double most_a = std::min(kLongestGore_m, a.length_m()), most_b = std::min(kLongestGore_m, b.length_m());
  PairCut cut{kLeastCut_m, kLeastCut_m};
  constexpr double kStep_m = 0.5;
  while (cut.first_m < most_a && cut.second_m < most_b) {
    const glm::dvec2 ahead = a.outward_of_cut(cut.first_m) + b.outward_of_cut(cut.second_m);
    const glm::dvec2 apart = a.point_at(cut.first_m) - b.point_at(cut.second_m);
    // Lines that turn against one another have parted.
    if (glm::length(ahead) < 0.5) break;
    const double before = glm::dot(apart, ahead) / glm::length(ahead);
    const double needed = a.widths_at(cut.first_m).left_m + b.widths_at(cut.second_m).right_m + kGoreNose_m;
    const double beside = std::sqrt(std::max(0.0, glm::dot(apart, apart) - before * before));
    if (std::abs(before) <= kStep_m && beside >= needed) break;
    if (before <= kStep_m) cut.first_m += kStep_m;
    if (before >= -kStep_m) cut.second_m += kStep_m;
  }
  return cut;
}

// What the corner from line a to its neighbour b, counter-clockwise, asks for.
PairCut corner_cut(const EndView& a, const EndView& b, double radius_m) {
  double xa = std::min(5.0, 0.5 * a.length_m()), xb = std::min(5.0, 0.5 * b.length_m());
  PairCut cut{kLeastCut_m, kLeastCut_m};
  for (int round = 0; round < 2; ++round) {
    const glm::dvec2 da = a.outward_at(xa), db = b.outward_at(xb);
    double angle = std::atan2(cross(da, db), glm::dot(da, db));
    if (angle < 0) angle += 2 * kPi;
    if (angle > kPi - kStraight_rad) return cut;
    if (angle < kGore_rad) return gore_cut(a, b);
    const glm::dvec2 ea = a.point_at(xa) + a.widths_at(xa).left_m * left_of(da);
    const glm::dvec2 eb = b.point_at(xb) - b.widths_at(xb).right_m * left_of(db);
    const double sine = cross(da, db), tangent = radius_m / std::tan(angle / 2);
    cut.first_m = std::clamp(xa + cross(eb - ea, db) / sine + tangent, kLeastCut_m, a.length_m());
    cut.second_m = std::clamp(xb + cross(eb - ea, da) / sine + tangent, kLeastCut_m, b.length_m());
    xa = cut.first_m;
    xb = cut.second_m;
  }
  return cut;
}

double radius_between(const EndView& a, const EndView& b) {
  return std::min(highway_class(a.tags_at(0).highway).corner_radius_m,
                  highway_class(b.tags_at(0).highway).corner_radius_m);
}

class Placer {
 public:
  Placer(const OsmScene& scene, ElementFindings& findings) : scene_(scene), findings_(findings) {}
  OsmJunctions run();

 private:
  struct Ask {
    float least_m = 0, wanted_m = 0;
  };
  void gather();
  std::uint32_t root(std::uint32_t group);
  void ask_all();
  bool merge_vanishing();
  void settle();
  void try_all();
  bool try_one(OsmJunction& junction, std::string& why);
  void give_up(OsmJunction& junction);
  std::vector<Arm> arms_of(const OsmJunction& junction) const;
  double length_m(std::size_t line) const { return length_m_[line]; }

  const OsmScene& scene_;
  ElementFindings& findings_;
  OsmJunctions made_;
  std::vector<std::uint32_t> parent_;  // of each node of the graph: union-find
  std::vector<std::uint32_t> group_;   // [LineEnd]: index of the graph's node there, or none
  std::vector<Ask> ask_;               // [LineEnd]
  std::vector<float> limit_m_;         // [LineEnd]
  std::vector<float> length_m_;        // [line]
  std::vector<char> dirty_;            // of each junction: ask again
};
constexpr std::uint32_t kNone = 0xFFFFFFFFu;

std::uint32_t Placer::root(std::uint32_t group) {
  while (parent_[group] != group) group = parent_[group] = parent_[parent_[group]];
  return group;
}

void Placer::gather() {
  const OsmGraph& graph = scene_.graph;
  const std::size_t lines = graph.lines.size();
  length_m_.assign(lines, 0);
  for_chunks(lines, kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    Course course;
    for (std::size_t i = begin; i < end; ++i) {
      load_course(scene_, graph.lines[i], course);
      length_m_[i] = course.points_m.empty() ? 0 : static_cast<float>(course.length_m());
    }
  });
  group_.assign(2 * lines, kNone);
  ask_.assign(2 * lines, {});
  limit_m_.assign(2 * lines, 0);
  made_.cut_m.assign(2 * lines, 0);
  made_.absorbed.assign(lines, 0);
  parent_.resize(graph.nodes.size());
  std::iota(parent_.begin(), parent_.end(), 0u);
  made_.all.resize(graph.nodes.size());
  dirty_.assign(graph.nodes.size(), 1);
  for (std::size_t k = 0; k < graph.nodes.size(); ++k) {
    made_.all[k].node = graph.nodes[k];
    for (std::size_t e = graph.first_end[k]; e < graph.first_end[k + 1]; ++e) {
      // A line of no length has no end.
      if (length_m(line_of(graph.ends[e])) <= 0) continue;
      made_.all[k].ends.push_back(graph.ends[e]);
      group_[graph.ends[e]] = static_cast<std::uint32_t>(k);
    }
  }
}

// Counter-clockwise by the place a little way out.
std::vector<Arm> Placer::arms_of(const OsmJunction& junction) const {
  std::vector<Arm> arms(junction.ends.size());
  glm::dvec2 center(0, 0);
  for (std::size_t i = 0; i < arms.size(); ++i) {
    arms[i].end = junction.ends[i];
    load_course(scene_, scene_.graph.lines[line_of(arms[i].end)], arms[i].course);
    center += view(scene_, arms[i]).point_at(0) / static_cast<double>(arms.size());
  }
  double spread = 0;
  for (const Arm& arm : arms) spread = std::max(spread, glm::length(view(scene_, arm).point_at(0) - center));
  for (Arm& arm : arms) {
    const EndView v = view(scene_, arm);
    const double out = std::min(8 + spread, 0.5 * v.length_m());
    const glm::dvec2 d = v.point_at(out) - center;
    arm.bearing_rad = std::atan2(d.y, d.x);
  }
  std::stable_sort(arms.begin(), arms.end(), [](const Arm& a, const Arm& b) { return a.bearing_rad < b.bearing_rad; });
  return arms;
}

void Placer::ask_all() {
  for_chunks(made_.all.size(), kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      OsmJunction& junction = made_.all[k];
      if (!dirty_[k] || junction.ends.size() < 2) continue;
      dirty_[k] = 0;
      std::vector<Arm> arms = arms_of(junction);
      junction.radius_m = kLeastRadius_m;
      for (std::size_t i = 0; i < arms.size(); ++i) {
        Arm &a = arms[i], &b = arms[(i + 1) % arms.size()];
        const EndView va = view(scene_, a), vb = view(scene_, b);
        const double radius = radius_between(va, vb);
        junction.radius_m = std::max(junction.radius_m, radius);
        const PairCut least = corner_cut(va, vb, kLeastRadius_m), wanted = corner_cut(va, vb, radius);
        a.least_m = std::max(a.least_m, least.first_m), b.least_m = std::max(b.least_m, least.second_m);
        a.wanted_m = std::max(a.wanted_m, wanted.first_m), b.wanted_m = std::max(b.wanted_m, wanted.second_m);
      }
      for (const Arm& arm : arms) {
        ask_[arm.end] = {static_cast<float>(arm.least_m), static_cast<float>(std::max(arm.least_m, arm.wanted_m))};
      }
    }
  });
}

// Junctions between which no road would be left become one. False where there are none.
bool Placer::merge_vanishing() {
  std::vector<std::size_t> vanishing;
  for (std::size_t line = 0; line < length_m_.size(); ++line) {
    const std::uint32_t a = group_[2 * line], b = group_[2 * line + 1];
    if (a == kNone || b == kNone || made_.absorbed[line] || length_m(line) > kLongestVanishing_m) continue;
    if (ask_[2 * line].least_m + ask_[2 * line + 1].least_m + kLeastRoad_m > length_m_[line]) vanishing.push_back(line);
  }
  for (const std::size_t line : vanishing) {
    const std::uint32_t a = root(group_[2 * line]), b = root(group_[2 * line + 1]);
    made_.absorbed[line] = 1;
    const std::uint32_t into = std::min(a, b), from = std::max(a, b);
    if (into != from) {
      auto &ends = made_.all[into].ends, &more = made_.all[from].ends;
      ends.insert(ends.end(), more.begin(), more.end());
      more.clear();
      made_.all[into].node = std::min(made_.all[into].node, made_.all[from].node);
      parent_[from] = into;
    }
    auto& ends = made_.all[into].ends;
    std::erase_if(ends, [&](LineEnd end) { return line_of(end) == line; });
    dirty_[into] = 1;
  }
  return !vanishing.empty();
}

// Cuts from what was asked for, and how far they may grow.
void Placer::settle() {
  for (std::size_t line = 0; line < length_m_.size(); ++line) {
    if (made_.absorbed[line]) continue;
    const std::size_t a = 2 * line, b = a + 1;
    double least = 0, wanted = 0;
    for (const std::size_t end : {a, b}) {
      if (group_[end] == kNone) continue;
      least += ask_[end].least_m;
      wanted += ask_[end].wanted_m;
    }
    if (wanted <= 0) continue;
    // A longer road can bend between its ends, where no corner needs the room.
    const double room =
        std::max(length_m(line) - kWantedRoad_m, std::min<double>(length_m(line) - kLeastRoad_m, least));
    for (const std::size_t end : {a, b}) {
      if (group_[end] == kNone) continue;
      const Ask& ask = ask_[end];
      double cut = ask.wanted_m;
      if (least > room) {
        cut = ask.least_m * room / least;
      } else if (wanted > room) {
        cut = ask.least_m + (ask.wanted_m - ask.least_m) * (room - least) / (wanted - least);
      }
      made_.cut_m[end] = cut;
      limit_m_[end] = static_cast<float>(cut + std::max(0.0, room - wanted) * cut / wanted);
    }
  }
}

// Whether the area holds what was cut off the lines, with room beside it: arms whose cuts lie far out along bends may
// have areas that leave the road or pinch it.
bool covers(const OsmScene& scene, const std::vector<Arm>& arms, const std::vector<double>& cut, const Junction& area) {
  std::vector<std::pair<glm::dvec2, glm::dvec2>> edges, kerbs;
  for (std::size_t i = 0; i < area.corners.size(); ++i) {
    glm::dvec2 last = cut_point_m(area.arms[i], area.arms[i].left_m);
    const auto add = [&](glm::dvec2 p, bool is_kerb) {
      edges.emplace_back(last, p);
      if (is_kerb) kerbs.emplace_back(last, p);
      last = p;
    };
    add(area.corners[i].front().start_m, false);
    for (const Segment& segment : area.corners[i]) {
      add(position_m(segment, 0.5), true);
      add(segment.end_m, true);
    }
  }
  const auto is_inside = [&](glm::dvec2 p) {
    bool inside = false;
    for (const auto& [a, b] : edges) {
      if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
    }
    return inside;
  };
  const auto room = [&](glm::dvec2 p) {
    double least = 1e9;
    for (const auto& [a, b] : kerbs) {
      const glm::dvec2 d = b - a;
      const double part = std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0);
      least = std::min(least, glm::length(p - a - part * d));
    }
    return least;
  };
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const EndView v = view(scene, arms[i]);
    for (double x = cut[i] - kCoverStep_m; x > kCoverStep_m; x -= kCoverStep_m) {
      const EndView::Widths widths = v.widths_at(x);
      const glm::dvec2 p = v.point_at(x);
      if (!is_inside(p) || room(p) < kLeastCover * std::min(widths.left_m, widths.right_m)) return false;
    }
  }
  return true;
}

bool Placer::try_one(OsmJunction& junction, std::string& why) {
  const std::vector<Arm> arms = arms_of(junction);
  std::vector<double> cut(arms.size());
  for (const double factor : kTries) {
    bool is_new = factor == 1;
    std::vector<JunctionArm> level;
    for (std::size_t i = 0; i < arms.size(); ++i) {
      const double settled = made_.cut_m[arms[i].end];
      const double tried =
          std::min<double>(factor * settled, std::min<double>(settled + kMostGrowth_m, limit_m_[arms[i].end]));
      is_new = is_new || std::abs(tried - settled) > 0.01;
      cut[i] = tried;
      level.push_back(level_arm(view(scene_, arms[i]), cut[i]));
      level.back().road = std::to_string(scene_.data.ways[arms[i].course.pieces[0].way].id);
      level.back().at_end = is_at_end(arms[i].end);
    }
    if (!is_new) continue;
    const Result<Junction> made = make_junction("", std::move(level), {.corner_radius_m = junction.radius_m});
    if (made && covers(scene_, arms, cut, *made)) {
      for (std::size_t i = 0; i < arms.size(); ++i) made_.cut_m[arms[i].end] = cut[i];
      return true;
    }
    if (why.empty()) why = made ? std::string("the roads bend too much on their way to it") : made.error().message;
    // The name of the junction, which has none yet.
    if (why.starts_with(kNameless)) why.erase(0, kNameless.size());
  }
  return false;
}

void Placer::try_all() {
  const std::size_t count = made_.all.size();
  std::vector<std::string> why(count);
  for_chunks(count, kChunk, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      OsmJunction& junction = made_.all[k];
      if (junction.ends.size() >= 2) junction.area = try_one(junction, why[k]);
    }
  });
  for (std::size_t k = 0; k < count; ++k) {
    if (root(static_cast<std::uint32_t>(k)) != k || made_.all[k].area) continue;
    give_up(made_.all[k]);
    findings_.add(Severity::kWarning, "junctions without an area",
                  "node " + std::to_string(scene_.data.node_ids[made_.all[k].node]),
                  "no area fits between its roads, which just touch: " +
                      (why[k].empty() ? std::string("fewer than two of them are left") : why[k]));
  }
}

void Placer::give_up(OsmJunction& junction) {
  for (const LineEnd end : junction.ends) made_.cut_m[end] = 0;
}

OsmJunctions Placer::run() {
  gather();
  for (int round = 0; round < kMostMergings; ++round) {
    ask_all();
    if (!merge_vanishing()) break;
  }
  settle();
  try_all();
  // What lies within no area is a road after all.
  for (std::size_t line = 0; line < length_m_.size(); ++line) {
    if (!made_.absorbed[line]) continue;
    OsmJunction& junction = made_.all[root(group_[2 * line])];
    if (junction.area) {
      junction.inside.push_back(static_cast<std::uint32_t>(line));
    } else {
      made_.absorbed[line] = 0;
    }
  }
  std::erase_if(made_.all, [](const OsmJunction& j) { return !j.area; });
  return std::move(made_);
}

}  // namespace

JunctionArm level_arm(const EndView& view, double cut_m) {
  const glm::dvec2 outward = view.outward_of_cut(cut_m);
  const EndView::Widths widths = view.widths_at(cut_m);
  JunctionArm arm;
  arm.position_m = view.point_at(cut_m);
  arm.heading_rad = std::atan2(-outward.y, -outward.x);
  arm.left_m = widths.right_m;
  arm.right_m = -widths.left_m;
  return arm;
}

OsmJunctions place_junctions(const OsmScene& scene, ElementFindings& findings) { return Placer(scene, findings).run(); }

}  // namespace roadgen
