#include "roadgen/fit/curve_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "roadgen/fit/guess.h"

namespace roadgen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Samples of a segment that misses are weighted anew this often before an anchor is added.
constexpr int kMostTries = 2;
// Nodes farther than this from a changed one stay where they are.
constexpr std::size_t kReach = 4;
// After so many rounds all samples of a segment that still misses become anchors, so that the rest ends soon.
constexpr int kPatience = 24;
constexpr int kMostRounds = 60;
// Removal: nodes on each side that may move, and how often they are weighted anew.
constexpr std::size_t kRemovalReach = 3;
constexpr int kRemovalTries = 3;

glm::dvec2 direction(double heading_rad) { return {std::cos(heading_rad), std::sin(heading_rad)}; }

bool is_graph(const Node& from, const Node& to) {
  const glm::dvec2 chord = to.joint.position_m - from.joint.position_m;
  const double least = 0.5 * glm::length(chord);
  return glm::dot(chord, direction(from.joint.heading_rad)) > least &&
         glm::dot(chord, direction(to.joint.heading_rad)) > least;
}

double distance_m(const Division& division, glm::dvec2 point_m) {
  double least = kInfinity;
  for (const Piece& piece : division.pieces) least = std::min(least, nearest(piece.segment, point_m).distance_m);
  return least;
}

// Integral of the squared curvature, by Simpson's rule.
double bending(const Division& division) {
  double sum = 0;
  for (const Piece& piece : division.pieces) {
    const double k0 = curvature_per_m(piece.segment, 0), k = curvature_per_m(piece.segment, 0.5),
                 k1 = curvature_per_m(piece.segment, 1);
    sum += piece.segment.arc_m * (k0 * k0 + 4 * k * k + k1 * k1) / 6;
  }
  return sum;
}

}  // namespace

CurveFit::CurveFit(std::span<const Sample> samples, const FitOptions& options)
    : options_(options), limit_m_(options.max_error_m * (1 - 1e-6)), origin_m_(samples.front().position_m) {
  for (int lap = 0; lap < (options.closed ? 2 : 1); ++lap) {
    for (const Sample& s : samples) position_m_.push_back(s.position_m - origin_m_);
  }
  for (const Sample& s : samples) half_width_m_.push_back(s.half_width_m);
  weight_.assign(position_m_.size(), 1);
  taken_.assign(count(), 0);
}

void CurveFit::run() {
  place_first_nodes();
  improve_until_done();
  if (options_.tangents == TangentSource::kFit) remove_spare();
}

void CurveFit::improve_until_done() {
  for (int round = 0; round < kMostRounds; ++round) {
    if (options_.tangents == TangentSource::kFit) {
      make_graphs();
      solve_changed();
    } else {
      take_catmull_rom_headings();
    }
    if (!improve(round)) return;
  }
}

// One past the last sample of the segment; beyond all samples where a closed road wraps.
std::size_t CurveFit::end_of(const Node& from, const Node& to) const {
  return options_.closed && to.begin < from.begin ? to.begin + count() : to.begin;
}

std::span<const glm::dvec2> CurveFit::samples_of(const Node& from, const Node& to) const {
  return std::span(position_m_).subspan(from.begin, end_of(from, to) - from.begin);
}

Node CurveFit::new_node(std::size_t sample) {
  Node node;
  taken_[sample % count()] = 1;
  node.sample = node.begin = sample % count();
  node.joint.position_m = position_m_[node.sample];
  node.half_width_m = half_width_m_[node.sample];
  return node;
}

// Heading at a sample, from those between the two others. Requires: before <= sample <= after.
double CurveFit::guessed_heading(std::size_t before, std::size_t sample, std::size_t after) const {
  // At the edge of a run the neighbours decide, so that both sides count.
  if (before == sample && before > 0) --before;
  if (after == sample && after + 1 < position_m_.size()) ++after;
  return local_heading(std::span(position_m_).subspan(before, after - before + 1), sample - before);
}

void CurveFit::place_first_nodes() {
  const std::size_t n = count();
  const std::size_t last = options_.closed ? n : n - 1;
  std::vector<std::size_t> at = thin(std::span(position_m_).first(last + 1), limit_m_);
  // A loop needs three joints to have an inside.
  while (options_.closed && at.size() - 1 < std::min<std::size_t>(n, 3)) {
    std::size_t widest = 0;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
      if (at[i + 1] - at[i] > at[widest + 1] - at[widest]) widest = i;
    }
    at.insert(at.begin() + static_cast<std::ptrdiff_t>(widest) + 1, (at[widest] + at[widest + 1]) / 2);
  }
  for (std::size_t i = 0; i < at.size() - (options_.closed ? 1 : 0); ++i) {
    const bool wraps = options_.closed && i == 0;
    Node node = new_node(at[i]);
    const std::size_t here = wraps ? n : at[i], before = wraps ? at[at.size() - 2] : at[i == 0 ? 0 : i - 1];
    const std::size_t after = wraps ? n + at[1] : at[std::min(i + 1, at.size() - 1)];
    node.joint.heading_rad = guessed_heading(before, here, after);
    nodes_.push_back(node);
  }
  if (!options_.closed) nodes_.back().begin = n;
}

Division CurveFit::division(const Node& from, const Node& to) const {
  const Stretch stretch = make_stretch(from.joint.position_m, to.joint.position_m, from.joint.heading_rad,
                                       to.joint.heading_rad);
  return divide(stretch, 0, 1, std::max(from.half_width_m, to.half_width_m), options_.mapping_tolerance);
}

CurveFit::Miss CurveFit::miss(const Node& from, const Node& to) const {
  const auto samples = samples_of(from, to);
  const Division d = division(from, to);
  const Miss impassable{kInfinity, from.begin + samples.size() / 2};
  if (!d.cusps.empty()) return impassable;
  for (const Piece& piece : d.pieces) {
    if (piece.cap_m < kLeastHalfWidth_m) return impassable;
  }
  Miss worst{0, from.begin};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double distance = distance_m(d, samples[i]);
    if (distance > worst.distance_m) worst = {distance, from.begin + i};
  }
  return worst;
}

// A sample belongs to the segment whose footprint holds it: it moves to the one before where it lies behind the normal
// of the joint.
void CurveFit::assign(std::vector<Node>& nodes, bool closed) const {
  const std::size_t m = nodes.size(), n = count();
  for (std::size_t k = closed ? 0 : 1; k < (closed ? m : m - 1); ++k) {
    Node& node = nodes[k];
    const Node &before = nodes[k == 0 ? m - 1 : k - 1], &after = nodes[k + 1 == m ? 0 : k + 1];
    const glm::dvec2 along = direction(node.joint.heading_rad);
    const auto behind = [&](std::size_t i) { return glm::dot(position_m_[i] - node.joint.position_m, along) < 0; };
    const std::size_t room_before = samples_of(before, node).size(), room_after = samples_of(node, after).size();
    std::size_t step = 0;
    while (step < room_after && behind((node.begin + step) % n)) ++step;
    if (step == 0) {
      while (step < room_before && !behind((node.begin + n - step - 1) % n)) ++step;
      node.begin = node.begin + n - step;
    } else {
      node.begin += step;
    }
    // An open road has no sample beyond the last, so that only a loop wraps.
    node.begin %= n;
  }
}

void CurveFit::solve(std::vector<Node>& nodes, bool closed) {
  const std::size_t m = nodes.size();
  std::vector<Joint> joints;
  for (const Node& node : nodes) joints.push_back(node.joint);
  std::vector<SegmentSamples> samples;
  for (std::size_t i = 0; i < (closed ? m : m - 1); ++i) {
    const auto of = samples_of(nodes[i], nodes[i + 1 == m ? 0 : i + 1]);
    samples.push_back({of, std::span(weight_).subspan(nodes[i].begin, of.size())});
  }
  solve_joints(joints, samples, closed, limit_m_);
  for (std::size_t i = 0; i < m; ++i) {
    nodes[i].joint = joints[i];
    nodes[i].fits = nodes[i].changed = false;
  }
  assign(nodes, closed);
}

// Solves for a run of nodes, which wraps where the road is closed, while those before and after it stay.
void CurveFit::solve_between(std::size_t first, std::size_t size) {
  const std::size_t m = nodes_.size();
  const bool at_start = !options_.closed && first == 0, at_end = !options_.closed && first + size == m;
  std::vector<std::size_t> at;
  for (std::size_t k = at_start ? 1 : 0; k < size + (at_end ? 1 : 2); ++k) at.push_back((first + k + m - 1) % m);
  std::vector<Node> nodes;
  for (const std::size_t i : at) nodes.push_back(nodes_[i]);
  const Joint front = nodes.front().joint, back = nodes.back().joint;
  if (!at_start) nodes.front().joint.fixed_position = nodes.front().joint.fixed_heading = true;
  if (!at_end) nodes.back().joint.fixed_position = nodes.back().joint.fixed_heading = true;
  const bool back_fits = nodes.back().fits;
  solve(nodes, false);
  if (!at_start) nodes.front().joint = front;
  if (!at_end) nodes.back().joint = back, nodes.back().fits = back_fits;
  for (std::size_t i = 0; i < at.size(); ++i) nodes_[at[i]] = nodes[i];
}

// Solves for all nodes within kReach of a changed one.
void CurveFit::solve_changed() {
  const std::size_t m = nodes_.size();
  std::vector<char> moves(m, 0);
  std::size_t moving = 0;
  for (std::size_t i = 0; i < m; ++i) {
    if (!nodes_[i].changed) continue;
    for (std::size_t k = 0; k <= 2 * kReach; ++k) {
      const std::size_t j = i + k;
      if (!options_.closed && (j < kReach || j - kReach >= m)) continue;
      char& move = moves[(j + kReach * m - kReach) % m];
      moving += move == 0;
      move = 1;
    }
  }
  if (2 * moving > m) return solve(nodes_, options_.closed);
  // A loop is toured from a node that stays, so that no run is cut in two.
  const std::size_t start =
      options_.closed ? static_cast<std::size_t>(std::find(moves.begin(), moves.end(), 0) - moves.begin()) : 0;
  for (std::size_t k = 0; k < m; ++k) {
    std::size_t size = 0;
    while (k + size < m && moves[(start + k + size) % m]) ++size;
    if (size == 0) continue;
    solve_between((start + k) % m, size);
    k += size;
  }
}

// Segments whose tangents turn too far off the chord for the road function are cut at their middle sample.
void CurveFit::make_graphs() {
  for (bool again = true; again;) {
    again = false;
    std::vector<Node> nodes;
    for (std::size_t k = 0; k < nodes_.size(); ++k) {
      nodes.push_back(nodes_[k]);
      if (k == segment_count()) break;
      const Node &from = nodes_[k], &to = nodes_[following(k)];
      const std::size_t size = samples_of(from, to).size();
      if (size < 3 || is_graph(from, to)) continue;
      const std::size_t middle = from.begin + size / 2;
      if (taken_[middle % count()]) continue;
      nodes.back().fits = false;
      nodes.push_back(new_node(middle));
      nodes.back().joint.heading_rad = guessed_heading(from.begin, middle, from.begin + size - 1);
      again = true;
    }
    nodes_ = std::move(nodes);
  }
}

void CurveFit::take_catmull_rom_headings() {
  std::vector<Anchor> at;
  for (const Node& node : nodes_) at.push_back({node.joint.position_m});
  AlignmentOptions options;
  options.tangents = options_.catmull_rom;
  options.closed = options_.closed;
  const std::vector<double> headings = catmull_rom_headings(at, options);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].joint.heading_rad = headings[i];
    nodes_[i].fits = false;
  }
  assign(nodes_, options_.closed);
}

// Samples far off count more in the next solve, which evens out the errors of a segment.
void CurveFit::weigh(const Node& from, const Node& to) {
  const Division d = division(from, to);
  const auto samples = samples_of(from, to);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double share = std::min(distance_m(d, samples[i]) / limit_m_, 2.0);
    const std::size_t k = from.begin + i;
    weight_[k] = std::min(weight_[k] * (1 + share * share), 30.0);
    if (options_.closed) weight_[k < count() ? k + count() : k - count()] = weight_[k];
  }
}

// Puts a node on its sample for good; where that was not enough, turns it as the neighbouring samples say, for good too.
bool CurveFit::settle(Node& node) {
  Joint& joint = node.joint;
  if (joint.fixed_position && joint.fixed_heading) return false;
  if (joint.fixed_position) {
    joint.fixed_heading = true;
    const std::size_t sample = options_.closed && node.sample == 0 ? count() : node.sample;
    joint.heading_rad = guessed_heading(sample, sample, sample);
  }
  joint.position_m = position_m_[node.sample];
  joint.fixed_position = node.changed = true;
  return true;
}

// Adds what helps a segment that misses: weights, an anchor, or all its samples. False where nothing is left to do.
bool CurveFit::improve_segment(Node& from, Node& to, int round, std::vector<Node>& added) {
  const Miss worst = miss(from, to);
  from.fits = worst.distance_m <= limit_m_;
  if (from.fits) return false;
  const std::size_t size = samples_of(from, to).size(), sample = worst.sample % count();
  const bool fit = options_.tangents == TangentSource::kFit;
  if (fit && from.tries < kMostTries && size > 2 && worst.distance_m < 3 * limit_m_) {
    ++from.tries;
    from.changed = to.changed = true;
    weigh(from, to);
    return true;
  }
  from.tries = 0;
  if (round >= kPatience) {
    bool any = false;
    for (std::size_t i = from.begin; i < from.begin + size; ++i) {
      if (taken_[i % count()]) continue;
      added.push_back(new_node(i));
      added.back().joint.heading_rad = guessed_heading(i, i, i);
      settle(added.back());
      any = true;
    }
    for (Node* node : {&from, &to}) any = settle(*node) || any;
    return any;
  }
  if (taken_[sample] || size == 0) {
    // Its node slid away from it, or an end of a segment without samples is wrong.
    bool any = false;
    for (Node& node : nodes_) {
      const bool guilty = size == 0 ? &node == &from || &node == &to : node.sample == sample;
      if (guilty) any = settle(node) || any;
    }
    return any;
  }
  added.push_back(new_node(worst.sample));
  added.back().joint.heading_rad = guessed_heading(from.begin, worst.sample, from.begin + size - 1);
  return true;
}

bool CurveFit::improve(int round) {
  std::vector<Node> nodes;
  bool any = false;
  const std::size_t segments = segment_count();
  std::vector<std::vector<Node>> added(nodes_.size());
  for (std::size_t k = 0; k < segments; ++k) {
    if (nodes_[k].fits) continue;
    any = improve_segment(nodes_[k], nodes_[following(k)], round, added[k]) || any;
  }
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    nodes.push_back(nodes_[k]);
    nodes.insert(nodes.end(), added[k].begin(), added[k].end());
  }
  nodes_ = std::move(nodes);
  return any;
}

// Nodes that the others can do without are taken out, each with a solve around it.
void CurveFit::remove_spare() {
  const std::size_t least = options_.closed ? 4 : 3;
  for (bool again = true; again && nodes_.size() >= least;) {
    again = false;
    for (std::size_t k = options_.closed ? 0 : 1; k + (options_.closed ? 0 : 1) < nodes_.size();) {
      if (nodes_.size() >= least && try_remove(k)) again = true;
      else ++k;
    }
  }
}

bool CurveFit::try_remove(std::size_t node) {
  const std::size_t m = nodes_.size();
  const bool whole = options_.closed && m <= 2 * kRemovalReach + 3;
  // The window: nodes that may move, and one more on each side that stays.
  std::vector<std::size_t> at;
  const std::size_t reach = kRemovalReach + 1;
  for (std::size_t k = 0; k < (whole ? m : 2 * reach + 1); ++k) {
    if (!whole && !options_.closed && (node + k < reach || node + k - reach >= m)) continue;
    const std::size_t i = whole ? k : (node + k + m - reach) % m;
    if (i != node) at.push_back(i);
  }
  std::vector<Node> nodes;
  for (const std::size_t i : at) nodes.push_back(nodes_[i]);
  const std::size_t before = node == 0 ? m - 1 : node - 1, after = following(node);
  if (!is_graph(nodes_[before], nodes_[after])) return false;
  // bent more than before: between sparse samples that is swinging
  std::vector<Node> old;
  double most=0; { std::vector<std::size_t> all = at; 
   for (std::size_t k = 0; k < (whole ? m : 2 * reach + 1); ++k) {
    if (!whole && !options_.closed && (node + k < reach || node + k - reach >= m)) continue;
    old.push_back(nodes_[whole ? k : (node + k + m - reach) % m]); }
   for (std::size_t k = 0; k < old.size() - (whole?0:1); ++k) most += bending(division(old[k], old[k+1==old.size()?0:k+1]));
  }
  const Joint front = nodes.front().joint, back = nodes.back().joint;
  const bool front_stays = !whole && (options_.closed || at.front() != 0);
  const bool back_stays = !whole && (options_.closed || at.back() + 1 != m);
  if (front_stays) nodes.front().joint.fixed_position = nodes.front().joint.fixed_heading = true;
  if (back_stays) nodes.back().joint.fixed_position = nodes.back().joint.fixed_heading = true;
  const bool back_fits = nodes.back().fits;
  for (int tries = 0; tries < kRemovalTries; ++tries) {
    solve(nodes, whole);
    double worst = 0, bent = 0;
    const std::size_t segments = nodes.size() - (whole ? 0 : 1);
    for (std::size_t k = 0; k < segments; ++k) {
      const Node& to = nodes[k + 1 == nodes.size() ? 0 : k + 1];
      worst = std::max(worst, miss(nodes[k], to).distance_m);
      bent += bending(division(nodes[k], to));
    }
    static double B=getenv("B")?atof(getenv("B")):1.05;
    if (worst <= limit_m_ && bent > most * B + 1e-9) return false;
    if (worst <= limit_m_) {
      for (std::size_t k = 0; k < segments; ++k) nodes[k].fits = true;
      if (front_stays) nodes.front().joint = front;
      if (back_stays) nodes.back().joint = back, nodes.back().fits = back_fits;
      for (std::size_t k = 0; k < at.size(); ++k) nodes_[at[k]] = nodes[k];
      taken_[nodes_[node].sample] = 0;
      nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(node));
      return true;
    }
    if (worst > 3 * limit_m_) break;
    for (std::size_t k = 0; k < segments; ++k) weigh(nodes[k], nodes[k + 1 == nodes.size() ? 0 : k + 1]);
  }
  return false;
}

void CurveFit::add_on_curve(std::span<const std::size_t> samples) {
  std::vector<char> wanted(count(), 0);
  for (const std::size_t i : samples) wanted[i] = 1;
  std::vector<Node> nodes;
  for (std::size_t k = 0; k < nodes_.size(); ++k) {
    nodes.push_back(nodes_[k]);
    if (k == segment_count()) break;
    const Node &from = nodes_[k], &to = nodes_[following(k)];
    const Division d = division(from, to);
    for (std::size_t i = from.begin; i < end_of(from, to); ++i) {
      const std::size_t sample = i % count();
      if (!wanted[sample] || taken_[sample]) continue;
      Node node = new_node(i);
      double least = kInfinity;
      for (const Piece& piece : d.pieces) {
        const Nearest here = nearest(piece.segment, position_m_[i]);
        if (here.distance_m >= least) continue;
        least = here.distance_m;
        node.joint.position_m = roadgen::position_m(piece.segment, here.u);
        node.joint.heading_rad = heading_rad(piece.segment, here.u);
      }
      node.changed = nodes.back().fits = false;
      nodes.push_back(node);
    }
  }
  nodes_ = std::move(nodes);
  improve_until_done();
}

std::vector<Anchor> CurveFit::anchors() const {
  std::vector<Anchor> anchors;
  for (const Node& node : nodes_) {
    anchors.push_back({node.joint.position_m + origin_m_, 0, node.half_width_m, node.joint.heading_rad});
  }
  return anchors;
}

}  // namespace roadgen
