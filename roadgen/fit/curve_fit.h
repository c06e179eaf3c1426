// The horizontal part of the fit: which anchors, where, and with which headings. Internal to roadgen/fit.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/fit/fit.h"
#include "roadgen/fit/solver.h"
#include "roadgen/fit/stretch.h"

namespace roadgen {

// A joint of the fit, and the samples that the segment after it holds.
struct Node {
  Joint joint;
  double half_width_m = 0;
  std::size_t sample = 0;  // the sample it was placed at
  std::size_t begin = 0;   // first sample of the segment that starts here; the last node of an open road: all samples
  int tries = 0;           // how often the samples of that segment were weighted anew
  bool changed = true;     // added, pinned or weighted since the last solve
  bool stays = false;      // its removal was tried in vain
  bool fits = false;       // the segment was measured since it moved, and is within the error
  double bending = 0;      // integral of its squared curvature when it was measured
};

class CurveFit {
 public:
  // Requires: samples are finite and no two consecutive ones equal (around the end too where closed); at least two.
  CurveFit(const FitSolver& solver, std::span<const Sample> samples, const FitOptions& options);

  // Finds the nodes: afterwards every sample is within max_error_m of its segment, or is a node itself.
  void run();

  // Adds nodes on the curve beside the given samples, almost without moving it, and repairs what moved. For heights
  // that need more knots than the plan view. Requires: run() done.
  void add_on_curve(std::span<const std::size_t> samples);

  // The anchors that give the fitted road, and the samples they were placed at.
  std::vector<Anchor> anchors() const;
  std::span<const Node> nodes() const { return nodes_; }

 private:
  struct Miss {
    double distance_m = 0;   // greatest distance of the segment's samples; infinite where the segment has a cusp
    std::size_t sample = 0;  // where; up to twice the number of samples
  };

  struct Window {
    std::vector<std::size_t> at;  // indices of the nodes that stay, in order
    bool whole = false;           // all nodes of a closed road
    bool front_stays = false, back_stays = false;
    double bending = 0;  // of the segments between, before the removal
  };

  std::size_t count() const { return half_width_m_.size(); }
  std::size_t segment_count() const { return nodes_.size() - (options_.closed ? 0 : 1); }
  std::size_t following(std::size_t node) const { return node + 1 == nodes_.size() ? 0 : node + 1; }
  std::size_t end_of(const Node& from, const Node& to) const;
  std::span<const glm::dvec2> samples_of(const Node& from, const Node& to) const;
  Division division(const Node& from, const Node& to) const;
  Miss measure(Node& from, const Node& to) const;
  Node new_node(std::size_t sample);
  double guessed_heading(std::size_t before, std::size_t sample, std::size_t after) const;

  void place_first_nodes();
  void improve_until_done();
  void make_graphs();
  void take_catmull_rom_headings();
  void solve_changed();
  void solve_between(std::size_t first, std::size_t size);
  void solve(std::vector<Node>& nodes, bool closed);
  void assign(std::vector<Node>& nodes, bool closed) const;
  void adopt(std::vector<Node> nodes);
  bool improve(int round);
  bool improve_segment(Node& from, Node& to, int round, std::vector<Node>& added);
  bool settle(Node& node);
  bool reseat(Node& from, Node& to, std::size_t sample);
  bool insert_all(Node& from, Node& to, std::vector<Node>& added);
  void set_weight(std::size_t sample, double weight);
  void weigh(const Node& from, const Node& to);
  void remove_spare();
  Window window_around(std::size_t node) const;
  bool fits_without(std::vector<Node>& nodes, const Window& window);
  std::vector<double> weights_of(const std::vector<Node>& nodes, bool whole) const;
  bool try_remove(std::size_t node);

  const FitSolver& solver_;
  const FitOptions options_;
  double limit_m_;                      // max_error_m less rounding
  glm::dvec2 origin_m_;                 // positions are relative to the first sample, for precision
  std::vector<glm::dvec2> position_m_;  // of the samples; twice in a row where closed, so that ranges never wrap
  std::vector<double> weight_;          // likewise
  std::vector<double> half_width_m_;
  std::vector<char> taken_;  // samples that have a node
  std::vector<Node> nodes_;
};

}  // namespace roadgen
