#include "roadgen/import/osm_heights.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <queue>
#include <unordered_map>

#include <glm/geometric.hpp>

#include "roadgen/road/cubic.h"

namespace roadgen {
namespace {

constexpr double kCell_m = 64;
constexpr double kEnough_m = 0.05;    // less is no lack of clearance
constexpr double kSteeper = 1.3;      // of grades where there is no room, each round
constexpr int kPatientRounds = 3;     // before ramps become steeper
constexpr double kLeastKnot_m = 0.5;  // between knots

double cross(glm::dvec2 a, glm::dvec2 b) { return a.x * b.y - a.y * b.x; }

struct Leg {
  std::uint32_t line, way;
  double at_m;  // of its start
  glm::dvec2 a, b;
  std::uint32_t node_a, node_b;
};

// Where one line passes over another.
struct Crossing {
  std::uint32_t upper, lower;  // lines
  std::uint32_t upper_way, lower_way;
  double upper_at_m, lower_at_m;
  double upper_half_m, lower_half_m;  // half of the length over which one is above the other, along each
  bool sinks;                         // the lower one goes down
};

// A height that a line has at least (or, sunk, at most) from begin to end.
struct Seed {
  std::uint32_t crossing;
  double begin_m, end_m;
  double height_m = 0;
};

// One of the two fields: how far lines rise, or how far they sink; both counted positive.
struct Field {
  std::map<std::uint32_t, std::vector<Seed>> seeds;  // of lines, by place
  std::vector<double> at_group_m;                    // of the groups of nodes
};

class HeightFinder {
 public:
  HeightFinder(const OsmScene& scene, const OsmJunctions& junctions, ElementFindings& findings)
      : scene_(scene), junctions_(junctions), findings_(findings) {}
  std::vector<HeightProfile> run();

 private:
  const WayTags& tags(std::uint32_t way) const { return scene_.data.ways[way].tags; }
  template <class Visit>
  void for_each_leg(const Visit& visit) const;
  void measure_lines();
  void find_groups();
  void find_crossings();
  void test(const Leg& layered, const Leg& other);
  void plant();
  void spread(Field& field);
  double height(const Field& field, std::uint32_t line, double at_m) const;
  double z(std::uint32_t line, double at_m) const { return height(rise_, line, at_m) - height(sink_, line, at_m); }
  double clearance_m(const Crossing& c) const { return z(c.upper, c.upper_at_m) - z(c.lower, c.lower_at_m); }
  std::vector<std::pair<double, double>> knots(const Field& field, std::uint32_t line) const;
  bool grow(bool steeper);
  void steepen(std::uint32_t line);
  void report() const;
  HeightProfile profile(std::uint32_t line) const;
  // Index of a line's node among the graph's, or none.
  std::size_t node_index(std::uint32_t node) const;
  // The group of nodes that it is in, or none.
  std::size_t group_of(std::uint32_t node) const;
  template <class Visit>
  void for_each_end(std::size_t group, const Visit& visit) const;

  const OsmScene& scene_;
  const OsmJunctions& junctions_;
  ElementFindings& findings_;
  std::vector<Crossing> crossings_;
  std::vector<float> length_m_, grade_;  // [line]; places along lines count from where the area at their start ends
  // Of the graph's nodes: those of one area are at one height.
  std::vector<std::uint32_t> group_;
  std::vector<std::uint32_t> members_, first_member_;  // of each group
  Field rise_, sink_;
};

template <class Visit>
void HeightFinder::for_each_leg(const Visit& visit) const {
  Course course;
  for (std::size_t i = 0; i < scene_.graph.lines.size(); ++i) {
    load_course(scene_, scene_.graph.lines[i], course);
    for (std::size_t p = 0; p < course.pieces.size() && !course.points_m.empty(); ++p) {
      for (std::size_t k = course.starts[p]; k < course.starts[p + 1]; ++k) {
        visit(Leg{static_cast<std::uint32_t>(i), course.pieces[p].way, course.at_m[k], course.points_m[k],
                  course.points_m[k + 1], course.nodes[k], course.nodes[k + 1]});
      }
    }
  }
}

void HeightFinder::test(const Leg& layered, const Leg& other) {
  const int level = tags(layered.way).layer, under = tags(other.way).layer;
  // A pair of layered ones is met twice.
  if (level == under || (under != 0 && under > level)) return;
  for (const std::uint32_t node : {other.node_a, other.node_b}) {
    if (node == layered.node_a || node == layered.node_b) return;
  }
  const glm::dvec2 d = layered.b - layered.a, e = other.b - other.a, v = other.a - layered.a;
  const double sine = cross(d, e), size = glm::length(d) * glm::length(e);
  if (std::abs(sine) < 0.02 * size) return;  // side by side
  const double s = cross(v, e) / sine, t = cross(v, d) / sine;
  if (!(s >= 0 && s < 1 && t >= 0 && t < 1)) return;
  const Leg &up = level > under ? layered : other, &low = level > under ? other : layered;
  Crossing c;
  c.upper = up.line, c.lower = low.line;
  c.upper_way = up.way, c.lower_way = low.way;
  c.upper_at_m = up.at_m + (level > under ? s : t) * glm::length(up.b - up.a);
  c.lower_at_m = low.at_m + (level > under ? t : s) * glm::length(low.b - low.a);
  const double wide_up = edges_of_way(tags(up.way), true, false).half_m;
  const double wide_low = edges_of_way(tags(low.way), true, false).half_m;
  const double oblique = std::max(std::abs(sine) / size, 0.3);
  c.upper_half_m = wide_low / oblique + 1;
  c.lower_half_m = wide_up / oblique + 1;
  c.sinks = tags(low.way).layer < 0;
  crossings_.push_back(c);
}

void HeightFinder::find_crossings() {
  const auto is_layered = [&](const OsmWay& way) { return way.tags.layer != 0; };
  if (std::none_of(scene_.data.ways.begin(), scene_.data.ways.end(), is_layered)) return;
  std::vector<Leg> layered;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells;
  const auto for_cells = [&](const Leg& leg, const auto& visit) {
    // A leg's box may be large, the cells beside the leg are few.
    const int steps = 1 + static_cast<int>(std::min(glm::length(leg.b - leg.a) / (0.5 * kCell_m), 1e4));
    std::vector<std::uint64_t> seen;
    for (int i = 0; i <= steps; ++i) {
      const glm::dvec2 p = leg.a + (leg.b - leg.a) * (static_cast<double>(i) / steps);
      const auto x = static_cast<std::int64_t>(std::floor(p.x / kCell_m)),
                 y = static_cast<std::int64_t>(std::floor(p.y / kCell_m));
      for (int dx = -1; dx <= 1; ++dx) {
        for (int dy = -1; dy <= 1; ++dy) {
          seen.push_back(static_cast<std::uint64_t>(x + dx) << 32 ^ static_cast<std::uint32_t>(y + dy));
        }
      }
    }
    std::sort(seen.begin(), seen.end());
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    for (const std::uint64_t cell : seen) visit(cell);
  };
  for_each_leg([&](const Leg& leg) {
    if (tags(leg.way).layer == 0) return;
    for_cells(leg, [&](std::uint64_t cell) { cells[cell].push_back(static_cast<std::uint32_t>(layered.size())); });
    layered.push_back(leg);
  });
  std::vector<std::uint32_t> near;
  for_each_leg([&](const Leg& leg) {
    near.clear();
    const int steps = 1 + static_cast<int>(std::min(glm::length(leg.b - leg.a) / (0.5 * kCell_m), 1e4));
    for (int i = 0; i <= steps; ++i) {
      const glm::dvec2 p = leg.a + (leg.b - leg.a) * (static_cast<double>(i) / steps);
      const auto x = static_cast<std::int64_t>(std::floor(p.x / kCell_m)),
                 y = static_cast<std::int64_t>(std::floor(p.y / kCell_m));
      const auto cell = cells.find(static_cast<std::uint64_t>(x) << 32 ^ static_cast<std::uint32_t>(y));
      if (cell != cells.end()) near.insert(near.end(), cell->second.begin(), cell->second.end());
    }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    for (const std::uint32_t k : near) test(layered[k], leg);
  });
}

std::size_t HeightFinder::node_index(std::uint32_t node) const {
  const auto& nodes = scene_.graph.nodes;
  const auto at = std::lower_bound(nodes.begin(), nodes.end(), node);
  return at != nodes.end() && *at == node ? static_cast<std::size_t>(at - nodes.begin()) : nodes.size();
}

constexpr std::size_t kNoGroup = static_cast<std::size_t>(-1);

std::size_t HeightFinder::group_of(std::uint32_t node) const {
  const std::size_t k = node_index(node);
  return k == scene_.graph.nodes.size() ? kNoGroup : group_[k];
}

template <class Visit>
void HeightFinder::for_each_end(std::size_t group, const Visit& visit) const {
  for (std::size_t m = first_member_[group]; m < first_member_[group + 1]; ++m) {
    const std::uint32_t k = members_[m];
    for (std::size_t e = scene_.graph.first_end[k]; e < scene_.graph.first_end[k + 1]; ++e) visit(scene_.graph.ends[e]);
  }
}

void HeightFinder::find_groups() {
  const std::size_t nodes = scene_.graph.nodes.size();
  constexpr std::uint32_t kNone = 0xFFFFFFFFu;
  group_.assign(nodes, kNone);
  std::uint32_t count = 0;
  for (const OsmJunction& junction : junctions_.all) {
    const auto take = [&](std::uint32_t node) {
      const std::size_t k = node_index(node);
      if (k < nodes) group_[k] = count;
    };
    for (const LineEnd end : junction.ends) {
      const OsmLine& line = scene_.graph.lines[line_of(end)];
      take(is_at_end(end) ? line.node_end : line.node_start);
    }
    for (const std::uint32_t line : junction.inside) {
      take(scene_.graph.lines[line].node_start);
      take(scene_.graph.lines[line].node_end);
    }
    ++count;
  }
  for (std::uint32_t& group : group_) {
    if (group == kNone) group = count++;
  }
  first_member_.assign(count + 1, 0);
  for (const std::uint32_t group : group_) ++first_member_[group + 1];
  for (std::uint32_t g = 0; g < count; ++g) first_member_[g + 1] += first_member_[g];
  members_.resize(nodes);
  std::vector<std::uint32_t> next(first_member_.begin(), first_member_.end() - 1);
  for (std::uint32_t k = 0; k < nodes; ++k) members_[next[group_[k]]++] = k;
}

// Lengths between areas, and crossings in terms of them; grades.
void HeightFinder::measure_lines() {
  Course course;
  for (std::size_t i = 0; i < scene_.graph.lines.size(); ++i) {
    const OsmLine& line = scene_.graph.lines[i];
    load_course(scene_, line, course);
    const double cut = junctions_.cut_m[2 * i] + junctions_.cut_m[2 * i + 1];
    const bool is_inside = junctions_.absorbed[i] || course.points_m.empty();
    length_m_.push_back(is_inside ? 0 : static_cast<float>(std::max(0.0, course.length_m() - cut)));
    grade_.push_back(static_cast<float>(highway_class(tags(scene_.graph.pieces_of(line)[0].way).highway).ramp_grade));
  }
  const auto between_areas = [&](std::uint32_t line, double& at_m) {
    at_m = std::clamp<double>(at_m - junctions_.cut_m[2 * line], 0, length_m_[line]);
  };
  for (Crossing& c : crossings_) {
    between_areas(c.upper, c.upper_at_m);
    between_areas(c.lower, c.lower_at_m);
  }
}

// A seed of the field that moves, for every crossing.
void HeightFinder::plant() {
  for (std::uint32_t i = 0; i < crossings_.size(); ++i) {
    const Crossing& c = crossings_[i];
    const std::uint32_t line = c.sinks ? c.lower : c.upper;
    const double at = c.sinks ? c.lower_at_m : c.upper_at_m, half = c.sinks ? c.lower_half_m : c.upper_half_m;
    (c.sinks ? sink_ : rise_)
        .seeds[line]
        .push_back({i, std::max(0.0, at - half), std::min<double>(length_m_[line], at + half)});
  }
  for (Field* field : {&rise_, &sink_}) {
    for (auto& [line, seeds] : field->seeds) {
      std::sort(seeds.begin(), seeds.end(), [](const Seed& a, const Seed& b) { return a.begin_m < b.begin_m; });
    }
  }
}

// Heights at the nodes, from the seeds along all lines, by Dijkstra's algorithm from the highest down.
void HeightFinder::spread(Field& field) {
  field.at_group_m.assign(first_member_.size() - 1, 0);
  std::priority_queue<std::pair<double, std::size_t>> open;
  const auto reach = [&](std::uint32_t node, double height) {
    const std::size_t group = group_of(node);
    if (group == kNoGroup || height <= field.at_group_m[group] + 1e-6) return;
    field.at_group_m[group] = height;
    open.emplace(height, group);
  };
  for (const auto& [line, seeds] : field.seeds) {
    const OsmLine& l = scene_.graph.lines[line];
    for (const Seed& seed : seeds) {
      reach(l.node_start, seed.height_m - grade_[line] * seed.begin_m);
      reach(l.node_end, seed.height_m - grade_[line] * (length_m_[line] - seed.end_m));
    }
  }
  while (!open.empty()) {
    const auto [height, group] = open.top();
    open.pop();
    if (height < field.at_group_m[group]) continue;
    for_each_end(group, [&, from = height](LineEnd end) {
      const OsmLine& l = scene_.graph.lines[line_of(end)];
      reach(is_at_end(end) ? l.node_start : l.node_end, from - grade_[line_of(end)] * length_m_[line_of(end)]);
    });
  }
}

// Heights of the field along a line, between which it is linear. Empty where all are 0.
std::vector<std::pair<double, double>> HeightFinder::knots(const Field& field, std::uint32_t line) const {
  const OsmLine& l = scene_.graph.lines[line];
  const double length = length_m_[line], grade = grade_[line];
  const auto node_height = [&](std::uint32_t node) {
    const std::size_t group = group_of(node);
    return group == kNoGroup ? -1 : field.at_group_m[group];
  };
  // Places that are as high as they are for a reason, those of one crossing together.
  std::vector<std::pair<double, double>> peaks;
  double start = node_height(l.node_start), end = node_height(l.node_end);
  const auto found = field.seeds.find(line);
  if (found == field.seeds.end() && start <= 0 && end <= 0) return {};
  // Dead ends are as high as what leads to them asks for.
  const bool free_start = start < 0, free_end = end < 0;
  if (found != field.seeds.end()) {
    for (const Seed& seed : found->second) {
      if (free_start || !(seed.begin_m > 0)) start = std::max(start, seed.height_m - grade * seed.begin_m);
      if (free_end || !(seed.end_m < length)) end = std::max(end, seed.height_m - grade * (length - seed.end_m));
    }
  }
  if (start < 0) start = std::max(0.0, end - grade * length);
  if (end < 0) end = std::max(0.0, start - grade * length);
  peaks.emplace_back(0, start);
  std::vector<char> level_before = {0};
  if (found != field.seeds.end()) {
    for (std::size_t i = 0; i < found->second.size(); ++i) {
      const Seed& seed = found->second[i];
      if (seed.height_m <= 0) continue;
      for (const double at : {seed.begin_m, seed.end_m}) {
        if (at < peaks.back().first + kLeastKnot_m) {
          peaks.back().second = std::max(peaks.back().second, seed.height_m);
          continue;
        }
        peaks.emplace_back(at, seed.height_m);
        level_before.push_back(peaks.size() > 2);
      }
    }
  }
  if (peaks.back().first > length - kLeastKnot_m && peaks.size() > 1) {
    peaks.back() = {length, std::max(end, peaks.back().second)};
  } else {
    peaks.emplace_back(length, end);
    level_before.push_back(0);
  }
  // No place is left further below its neighbours than a ramp leads.
  const auto lift = [&](std::size_t i, std::size_t from) {
    const double reached = peaks[from].second - grade * std::abs(peaks[i].first - peaks[from].first);
    if (reached <= peaks[i].second) return;
    peaks[i].second = reached;
    level_before[std::max(i, from)] = 0;
  };
  for (std::size_t i = 1; i < peaks.size(); ++i) lift(i, i - 1);
  for (std::size_t i = peaks.size() - 1; i-- > 0;) lift(i, i + 1);
  std::vector<std::pair<double, double>> all = {peaks.front()};
  for (std::size_t i = 1; i < peaks.size(); ++i) {
    const auto [xa, ha] = peaks[i - 1];
    const auto [xb, hb] = peaks[i];
    if (!level_before[i]) {
      const double down = xa + ha / grade, up = xb - hb / grade;
      if (down < up) {
        if (ha > 0) all.emplace_back(down, 0);
        if (hb > 0 && up > down + kLeastKnot_m) all.emplace_back(up, 0);
      } else {
        const double x = 0.5 * (xa + xb) + 0.5 * (ha - hb) / grade;
        if (x > xa + kLeastKnot_m && x < xb - kLeastKnot_m) all.emplace_back(x, std::max(0.0, ha - grade * (x - xa)));
      }
    }
    all.push_back(peaks[i]);
  }
  return all;
}

double linear(const std::vector<std::pair<double, double>>& knots, double at_m) {
  if (knots.empty()) return 0;
  const auto after =
      std::upper_bound(knots.begin(), knots.end(), at_m, [](double x, const auto& k) { return x < k.first; });
  if (after == knots.begin()) return knots.front().second;
  if (after == knots.end()) return knots.back().second;
  const auto before = after - 1;
  const double part = (at_m - before->first) / (after->first - before->first);
  return before->second + part * (after->second - before->second);
}

double HeightFinder::height(const Field& field, std::uint32_t line, double at_m) const {
  return linear(knots(field, line), at_m);
}

void HeightFinder::steepen(std::uint32_t line) {
  const OsmLine& l = scene_.graph.lines[line];
  const auto raise = [&](std::size_t i) {
    grade_[i] = static_cast<float>(std::min<double>(kGreatestRamp, kSteeper * grade_[i]));
  };
  raise(line);
  for (const std::uint32_t node : {l.node_start, l.node_end}) {
    const std::size_t group = group_of(node);
    if (group == kNoGroup) continue;
    for_each_end(group, [&](LineEnd end) {
      if (line_of(end) != line) raise(line_of(end));
    });
  }
}

// Raises and sinks what lacks clearance. False where nothing does.
bool HeightFinder::grow(bool steeper) {
  std::vector<double> lack(crossings_.size(), 0);
  bool any = false;
  for (std::size_t i = 0; i < crossings_.size(); ++i) {
    const Crossing& c = crossings_[i];
    lack[i] = kLevel_m - clearance_m(c);
    any = any || lack[i] > kEnough_m;
  }
  for (Field* field : {&rise_, &sink_}) {
    for (auto& [line, seeds] : field->seeds) {
      for (Seed& seed : seeds) {
        if (lack[seed.crossing] <= kEnough_m) continue;
        const Crossing& c = crossings_[seed.crossing];
        const double now = height(*field, line, field == &sink_ ? c.lower_at_m : c.upper_at_m);
        // Where lines that cross are joined nearby, the one takes the other along; no more than a level beyond its own.
        const int layer = tags(field == &sink_ ? c.lower_way : c.upper_way).layer;
        const double most = kLevel_m * (std::abs(layer) + 1);
        seed.height_m = std::min(most, std::max(seed.height_m, now + lack[seed.crossing]));
      }
    }
  }
  if (steeper) {
    for (std::size_t i = 0; i < crossings_.size(); ++i) {
      if (lack[i] <= kEnough_m) continue;
      steepen(crossings_[i].upper);
      if (crossings_[i].lower != crossings_[i].upper) steepen(crossings_[i].lower);
    }
  }
  return any;
}

void HeightFinder::report() const {
  for (const Crossing& c : crossings_) {
    const double clear = clearance_m(c);
    if (clear >= kLevel_m - 2 * kEnough_m) continue;
    char text[128];
    std::snprintf(text, sizeof text, "passes only %.2f m above way %lld: no ramp of at most %.0f %% leads higher",
                  clear, static_cast<long long>(scene_.data.ways[c.lower_way].id), 100 * kGreatestRamp);
    findings_.add(Severity::kWarning, "crossings without clearance",
                  "way " + std::to_string(scene_.data.ways[c.upper_way].id), text);
  }
}

HeightProfile HeightFinder::profile(std::uint32_t line) const {
  const auto up = knots(rise_, line), down = knots(sink_, line);
  HeightProfile p;
  if (up.empty() && down.empty()) return p;
  for (const auto* field : {&up, &down}) {
    for (const auto& [at, height] : *field) p.at_m.push_back(at);
  }
  std::sort(p.at_m.begin(), p.at_m.end());
  p.at_m.erase(std::unique(p.at_m.begin(), p.at_m.end(), [](double a, double b) { return b - a < kLeastKnot_m; }),
               p.at_m.end());
  for (double& at : p.at_m) {
    p.z_m.push_back(linear(up, at) - linear(down, at));
    at += junctions_.cut_m[2 * line];
  }
  return p;
}

std::vector<HeightProfile> HeightFinder::run() {
  find_crossings();
  const std::size_t lines = scene_.graph.lines.size();
  if (crossings_.empty()) return {};
  std::vector<HeightProfile> profiles(lines);
  measure_lines();
  find_groups();
  plant();
  spread(rise_);
  spread(sink_);
  for (int round = 0; round < kMostHeightRounds && grow(round >= kPatientRounds); ++round) {
    spread(rise_);
    spread(sink_);
  }
  report();
  for (std::uint32_t i = 0; i < lines; ++i) profiles[i] = profile(i);
  return profiles;
}

}  // namespace

HeightProfile::Value HeightProfile::value(double distance_m) const {
  if (at_m.empty()) return {};
  if (at_m.size() == 1 || distance_m < at_m.front()) return {z_m.front(), 0};
  if (distance_m > at_m.back()) return {z_m.back(), 0};
  const auto after = std::upper_bound(at_m.begin(), at_m.end() - 1, distance_m);
  const auto i = static_cast<std::size_t>(after - at_m.begin()) - 1;
  const auto rise = [&](std::size_t k) { return (z_m[k + 1] - z_m[k]) / (at_m[k + 1] - at_m[k]); };
  // Harmonic means keep the cubic monotone. Source: Fritsch and Butland 1984.
  const auto grade = [&](std::size_t k) {
    if (k == 0) return rise(0);
    if (k + 1 == z_m.size()) return rise(k - 1);
    const double a = rise(k - 1), b = rise(k);
    return a * b > 0 ? 2 * a * b / (a + b) : 0.0;
  };
  const double length = at_m[i + 1] - at_m[i];
  const Cubic c = Cubic::hermite(z_m[i], grade(i), z_m[i + 1], grade(i + 1), length);
  return {c.value(distance_m - at_m[i]), c.slope(distance_m - at_m[i])};
}

std::vector<HeightProfile> find_heights(const OsmScene& scene, const OsmJunctions& junctions,
                                        ElementFindings& findings) {
  return HeightFinder(scene, junctions, findings).run();
}

}  // namespace roadgen
