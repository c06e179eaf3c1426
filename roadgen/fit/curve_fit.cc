#include "roadgen/fit/curve_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "roadgen/fit/curvature.h"
#include "roadgen/fit/guess.h"

namespace roadgen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Samples of a segment that misses are weighted anew this often before an anchor is added.
constexpr int kMostTries = 2;
constexpr double kMostWeight = 30;
// The first guess leaves room below the error allowed, for the joints between its cubics.
constexpr double kGuessShare = 0.7;
// Nodes farther than this from a changed one stay where they are.
constexpr std::size_t kReach = 4;
// After so many rounds all samples of a segment that still misses become anchors, so that the rest ends soon.
constexpr int kPatience = 24;
constexpr int kMostRounds = 60;
// Removal: nodes on each side that may move, and how often they are weighted anew.
constexpr std::size_t kRemovalReach = 3;
constexpr int kRemovalTries = 3;
// A segment that misses by more than this, in the error allowed, is not mended by weights.
constexpr double kMendable = 3;
// Share of a segment's chord below which its end is moved rather than a node added.
constexpr double kStub = 0.15;
constexpr double kMostBendingGrowth = 1.05;

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

CurveFit::CurveFit(const FitSolver& solver, std::span<const Sample> samples, const FitOptions& options)
    : solver_(solver),
      options_(options),
      limit_m_(options.max_error_m * (1 - 1e-6)),
      origin_m_(samples.front().position_m) {
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
  const std::size_t n = count();
  if (options_.closed && sample == 0) before += n, sample += n, after += n;
  // At the edge of a run the neighbours decide, so that both sides count.
  before = std::min(before, sample > 0 ? sample - 1 : 0);
  after = std::max(after, std::min(sample + 1, position_m_.size() - 1));
  return local_heading(std::span(position_m_).subspan(before, after - before + 1), sample - before);
}

void CurveFit::place_first_nodes() {
  const std::size_t n = count();
  const std::size_t last = options_.closed ? n : n - 1;
  std::vector<std::size_t> at = thin(std::span(position_m_).first(last + 1), kGuessShare * limit_m_);
  // A loop needs three joints to have an inside.
  while (options_.closed && at.size() - 1 < std::min<std::size_t>(n, 3)) {
    std::size_t widest = 0;
    for (std::size_t i = 0; i + 1 < at.size(); ++i) {
      if (at[i + 1] - at[i] > at[widest + 1] - at[widest]) widest = i;
    }
    at.insert(at.begin() + static_cast<std::ptrdiff_t>(widest) + 1, (at[widest] + at[widest + 1]) / 2);
  }
  for (std::size_t i = 0; i < at.size() - (options_.closed ? 1 : 0); ++i) {
    Node node = new_node(at[i]);
    const bool wraps = options_.closed && i == 0;
    const std::size_t here = wraps ? n : at[i], before = wraps ? at[at.size() - 2] : at[i == 0 ? 0 : i - 1];
    const std::size_t after = wraps ? n + at[1] : at[std::min(i + 1, at.size() - 1)];
    node.joint.heading_rad = guessed_heading(before, here, after);
    nodes_.push_back(node);
  }
  if (options_.closed) return;
  nodes_.back().begin = n;
  const auto fix = [&](Node& node, const std::optional<FixedEnd>& end) {
    if (end) node.joint = {end->position_m - origin_m_, end->heading_rad, true, true};
  };
  fix(nodes_.front(), options_.start);
  fix(nodes_.back(), options_.end);
}

Division CurveFit::division(const Node& from, const Node& to) const {
  const Stretch stretch =
      make_stretch(from.joint.position_m, to.joint.position_m, from.joint.heading_rad, to.joint.heading_rad);
  return divide(stretch, 0, 1, std::max(from.half_width_m, to.half_width_m), options_.mapping_tolerance);
}

CurveFit::Miss CurveFit::measure(Node& from, const Node& to) const {
  const auto samples = samples_of(from, to);
  const Division d = division(from, to);
  from.bending = bending(d);
  from.fits = false;
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
  from.fits = worst.distance_m <= limit_m_;
  return worst;
}

// A sample belongs to the segment whose footprint holds it: to the one before a joint where it lies behind the joint's
// normal. Joints hardly slide, so that this is looked for no farther than half way to the next joint's sample.
void CurveFit::assign(std::vector<Node>& nodes, bool closed) const {
  const std::size_t m = nodes.size(), n = count();
  const auto steps = [&](const Node& from, const Node& to) { return (to.sample + n - from.sample) % n; };
  for (std::size_t k = closed ? 0 : 1; k < (closed ? m : m - 1); ++k) {
    Node& node = nodes[k];
    node.begin = node.sample;
    if (node.joint.fixed_position) continue;
    const glm::dvec2 along = direction(node.joint.heading_rad);
    const auto behind = [&](std::size_t i) { return glm::dot(position_m_[i % n] - node.joint.position_m, along) < 0; };
    const std::size_t most_back = steps(nodes[k == 0 ? m - 1 : k - 1], node) / 2;
    const std::size_t most_ahead = steps(node, nodes[k + 1 == m ? 0 : k + 1]) / 2;
    std::size_t ahead = 0, back = 0;
    while (ahead < most_ahead && behind(node.sample + ahead)) ++ahead;
    while (ahead == 0 && back < most_back && !behind(node.sample + n - back - 1)) ++back;
    node.begin = (node.sample + n + ahead - back) % n;
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
  solver_.solve_joints(joints, samples, closed, limit_m_);
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
    adopt(std::move(nodes));
  }
}

// Takes nodes in the order of their samples; new ones may lie before the joint whose segment missed their sample.
void CurveFit::adopt(std::vector<Node> nodes) {
  nodes_ = std::move(nodes);
  std::stable_sort(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) { return a.sample < b.sample; });
  assign(nodes_, options_.closed);
}

void CurveFit::take_catmull_rom_headings() {
  std::vector<Anchor> at;
  for (const Node& node : nodes_) at.push_back({node.joint.position_m});
  AlignmentOptions options;
  options.tangents = options_.catmull_rom;
  options.closed = options_.closed;
  std::vector<double> headings = catmull_rom_headings(at, options);
  if (options_.catmull_rom == Tangents::kCurvature) {
    std::vector<glm::dvec2> points;
    for (const Anchor& anchor : at) points.push_back(anchor.position_m);
    // Where there is no solution the final road has more joints.
    equalize_curvature(points, std::vector<char>(points.size(), 0), options_.closed, headings);
  }
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
    set_weight(k, std::min(weight_[k] * (1 + share * share), kMostWeight));
  }
}

void CurveFit::set_weight(std::size_t sample, double weight) {
  for (std::size_t k = sample % count(); k < weight_.size(); k += count()) weight_[k] = weight;
}

// Puts a node on its sample for good; where that was not enough, turns it as the samples beside it say, for good too.
bool CurveFit::settle(Node& node) {
  Joint& joint = node.joint;
  if (joint.fixed_position && joint.fixed_heading) return false;
  if (joint.fixed_position) {
    joint.fixed_heading = true;
    joint.heading_rad = guessed_heading(node.sample, node.sample, node.sample);
  }
  joint.position_m = position_m_[node.sample];
  joint.fixed_position = node.changed = true;
  return true;
}

// Adds what helps a segment that misses: weights, an anchor, or all its samples. False where nothing is left to do.
bool CurveFit::improve_segment(Node& from, Node& to, int round, std::vector<Node>& added) {
  const Miss worst = measure(from, to);
  if (from.fits) return false;
  const std::size_t size = samples_of(from, to).size(), sample = worst.sample % count();
  const bool fit = options_.tangents == TangentSource::kFit;
  if (fit && from.tries < kMostTries && size > 2 && worst.distance_m < kMendable * limit_m_) {
    ++from.tries;
    from.changed = to.changed = true;
    weigh(from, to);
    return true;
  }
  from.tries = 0;
  if (round >= kPatience) return insert_all(from, to, added);
  if (taken_[sample] || size == 0) {
    // Its node slid away from it, or an end of a segment without samples is wrong.
    bool any = false;
    for (Node& node : nodes_) {
      const bool guilty = size == 0 ? &node == &from || &node == &to : node.sample == sample;
      if (guilty) any = settle(node) || any;
    }
    return any;
  }
  if (reseat(from, to, sample)) return true;
  added.push_back(new_node(worst.sample));
  added.back().joint.heading_rad = guessed_heading(from.begin, worst.sample, from.begin + size - 1);
  return true;
}

// Makes all samples of a segment anchors that stay on them.
bool CurveFit::insert_all(Node& from, Node& to, std::vector<Node>& added) {
  bool any = false;
  for (std::size_t i = from.begin; i < end_of(from, to); ++i) {
    if (taken_[i % count()]) continue;
    added.push_back(new_node(i));
    added.back().joint.heading_rad = guessed_heading(i, i, i);
    settle(added.back());
    any = true;
  }
  for (Node* node : {&from, &to}) any = settle(*node) || any;
  return any;
}

// Puts the nearer end of the segment on a sample beside it, where a node of its own would make a stub and a kink.
bool CurveFit::reseat(Node& from, Node& to, std::size_t sample) {
  const double stub_m = kStub * glm::length(to.joint.position_m - from.joint.position_m);
  for (Node* node : {&from, &to}) {
    const bool at_end = node == &nodes_.front() || (!options_.closed && node == &nodes_.back());
    if (at_end || node->joint.fixed_position) continue;
    if (glm::length(node->joint.position_m - position_m_[sample]) > stub_m) continue;
    taken_[node->sample] = 0;
    taken_[sample] = 1;
    node->sample = sample;
    return settle(*node);
  }
  return false;
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
  adopt(std::move(nodes));
  return any;
}

// Nodes that the others can do without are taken out, each with a solve around it.
void CurveFit::remove_spare() {
  // A closed road keeps its first node too, so that it begins where the samples do.
  const std::size_t least = options_.closed ? 4 : 3, end_margin = options_.closed ? 0 : 1;
  for (bool again = true; again;) {
    again = false;
    for (std::size_t k = 1; k + end_margin < nodes_.size();) {
      if (nodes_.size() < least) return;
      // Once in vain is enough, unless a neighbour went since.
      const bool removed = !nodes_[k].stays && try_remove(k);
      again = again || removed;
      if (!removed) nodes_[k++].stays = true;
    }
  }
}

// The nodes around one that is to go, without it; they are indices into nodes_.
CurveFit::Window CurveFit::window_around(std::size_t node) const {
  const std::size_t m = nodes_.size(), reach = kRemovalReach + 1;
  Window window;
  window.whole = options_.closed && m <= 2 * reach + 1;
  for (std::size_t k = 0; k < (window.whole ? m : 2 * reach + 1); ++k) {
    if (!options_.closed && (node + k < reach || node + k - reach >= m)) continue;
    const std::size_t i = window.whole ? k : (node + k + m - reach) % m;
    if (i + 1 != m || options_.closed) window.bending += nodes_[i].bending;
    if (i != node) window.at.push_back(i);
  }
  window.front_stays = !window.whole && (options_.closed || window.at.front() != 0);
  window.back_stays = !window.whole && (options_.closed || window.at.back() + 1 != m);
  if (window.back_stays) window.bending -= nodes_[window.at.back()].bending;  // of the segment beyond
  return window;
}

bool CurveFit::try_remove(std::size_t node) {
  const std::size_t before = node == 0 ? nodes_.size() - 1 : node - 1;
  if (!is_graph(nodes_[before], nodes_[following(node)])) return false;
  const ChordFit guess = chord_fit(samples_of(nodes_[before], nodes_[following(node)]));
  if (guess.error_m > kMendable * limit_m_) return false;

  const Window window = window_around(node);
  std::vector<Node> nodes;
  for (const std::size_t i : window.at) nodes.push_back(nodes_[i]);
  const Node front = nodes.front(), back = nodes.back();
  if (window.front_stays) nodes.front().joint.fixed_position = nodes.front().joint.fixed_heading = true;
  if (window.back_stays) nodes.back().joint.fixed_position = nodes.back().joint.fixed_heading = true;
  if (!fits_without(nodes, window)) return false;
  if (window.front_stays) nodes.front().joint = front.joint;
  if (window.back_stays) nodes.back() = back;
  for (std::size_t k = 0; k < window.at.size(); ++k) {
    nodes_[window.at[k]] = nodes[k];
    nodes_[window.at[k]].stays = false;
  }
  taken_[nodes_[node].sample] = 0;
  nodes_.erase(nodes_.begin() + static_cast<std::ptrdiff_t>(node));
  return true;
}

// Solves for the nodes of a window, with new weights where that may help; true where all samples are within the error.
bool CurveFit::fits_without(std::vector<Node>& nodes, const Window& window) {
  const std::size_t segments = nodes.size() - (window.whole ? 0 : 1), begin = nodes.front().begin;
  const auto after = [&](std::size_t k) -> Node& { return nodes[k + 1 == nodes.size() ? 0 : k + 1]; };
  const std::vector<double> weights = weights_of(nodes, window.whole);
  for (int tries = 0; tries < kRemovalTries; ++tries) {
    solve(nodes, window.whole);
    double worst = 0, bending = 0;
    for (std::size_t k = 0; k < segments && worst <= kMendable * limit_m_; ++k) {
      worst = std::max(worst, measure(nodes[k], after(k)).distance_m);
      bending += nodes[k].bending;
    }
    // Bent more than before, it would swing between the samples.
    if (worst <= limit_m_ && bending <= kMostBendingGrowth * window.bending) return true;
    if (worst <= limit_m_ || worst > kMendable * limit_m_) break;
    for (std::size_t k = 0; k < segments; ++k) weigh(nodes[k], after(k));
  }
  for (std::size_t i = 0; i < weights.size(); ++i) set_weight(begin + i, weights[i]);
  return false;
}

// Weights of all samples of a run of nodes, from the first one's begin on.
std::vector<double> CurveFit::weights_of(const std::vector<Node>& nodes, bool whole) const {
  const std::size_t begin = nodes.front().begin, end = whole ? begin + count() : end_of(nodes.front(), nodes.back());
  return {weight_.begin() + static_cast<std::ptrdiff_t>(begin), weight_.begin() + static_cast<std::ptrdiff_t>(end)};
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
  adopt(std::move(nodes));
  improve_until_done();
}

std::vector<Anchor> CurveFit::anchors() const {
  // Headings of equal curvature depend on the joints inside, which the final road adds.
  const bool solves_itself =
      options_.tangents == TangentSource::kCatmullRom && options_.catmull_rom == Tangents::kCurvature;
  std::vector<Anchor> anchors;
  for (const Node& node : nodes_) {
    anchors.push_back({node.joint.position_m + origin_m_, 0, node.half_width_m});
    if (!solves_itself) anchors.back().heading_rad = node.joint.heading_rad;
  }
  return anchors;
}

}  // namespace roadgen
