#include "roadgen/import/osm_course.h"

#include <algorithm>

#include <glm/geometric.hpp>

namespace roadgen {
namespace {

constexpr double kSamePlace_m = 1e-3;

// The points of a closed line again, from the middle of its longest leg.
void start_in_longest_leg(Course& course) {
  const std::size_t legs = course.points_m.size() - 1;
  std::size_t longest = 0;
  const auto leg = [&](std::size_t i) { return glm::length(course.points_m[i + 1] - course.points_m[i]); };
  for (std::size_t i = 1; i < legs; ++i) {
    if (leg(i) > leg(longest)) longest = i;
  }
  Course turned;
  const glm::dvec2 middle = 0.5 * (course.points_m[longest] + course.points_m[longest + 1]);
  const auto add = [&](glm::dvec2 p, std::uint32_t node) {
    turned.points_m.push_back(p);
    turned.nodes.push_back(node);
  };
  const auto piece_of = [&](std::size_t i) {
    return static_cast<std::size_t>(
        std::upper_bound(course.starts.begin(), course.starts.end() - 1, static_cast<std::uint32_t>(i)) -
        course.starts.begin() - 1);
  };
  turned.starts.push_back(0);
  turned.pieces.push_back(course.pieces[piece_of(longest)]);
  add(middle, course.nodes[longest]);
  for (std::size_t k = 1; k <= legs; ++k) {
    const std::size_t i = (longest + k) % legs;
    if (piece_of(i) != piece_of((i + legs - 1) % legs)) {
      turned.starts.push_back(static_cast<std::uint32_t>(turned.points_m.size()));
      turned.pieces.push_back(course.pieces[piece_of(i)]);
    }
    add(course.points_m[i], course.nodes[i]);
  }
  add(middle, course.nodes[longest]);
  turned.starts.push_back(static_cast<std::uint32_t>(turned.points_m.size() - 1));
  course = std::move(turned);
}

}  // namespace

std::size_t Course::leg_at(double distance_m) const {
  const auto after = std::upper_bound(at_m.begin() + 1, at_m.end() - 1, distance_m);
  return static_cast<std::size_t>(after - at_m.begin()) - 1;
}

glm::dvec2 Course::point_at(double distance_m) const {
  const std::size_t i = leg_at(distance_m);
  const double part = std::clamp((distance_m - at_m[i]) / (at_m[i + 1] - at_m[i]), 0.0, 1.0);
  return points_m[i] + part * (points_m[i + 1] - points_m[i]);
}

glm::dvec2 Course::direction_at(double distance_m) const {
  const std::size_t i = leg_at(distance_m);
  return (points_m[i + 1] - points_m[i]) / (at_m[i + 1] - at_m[i]);
}

std::size_t Course::piece_at(double distance_m) const {
  const auto leg = static_cast<std::uint32_t>(leg_at(distance_m));
  return static_cast<std::size_t>(std::upper_bound(starts.begin(), starts.end() - 1, leg) - starts.begin()) - 1;
}

void load_course(const OsmScene& scene, const OsmLine& line, Course& course) {
  course.points_m.clear();
  course.nodes.clear();
  course.starts.clear();
  course.pieces.clear();
  for (const OsmPiece& piece : scene.graph.pieces_of(line)) {
    const auto node = [&](std::uint32_t i) {
      return scene.data.refs[piece.along() ? piece.first + i : piece.first - i];
    };
    const std::size_t before = course.points_m.size();
    if (before == 0) {
      course.points_m.push_back(scene.positions_m[node(0)]);
      course.nodes.push_back(node(0));
    }
    const auto start = static_cast<std::uint32_t>(course.points_m.size() - 1);
    for (std::uint32_t i = 1; i <= piece.legs(); ++i) {
      const glm::dvec2 p = scene.positions_m[node(i)];
      if (!(glm::length(p - course.points_m.back()) > kSamePlace_m)) continue;
      course.points_m.push_back(p);
      course.nodes.push_back(node(i));
    }
    if (course.points_m.size() - 1 == start) continue;  // of no length
    course.starts.push_back(start);
    course.pieces.push_back(piece);
  }
  if (course.points_m.size() < 2 || (line.closed && course.points_m.size() < 4)) {
    course.points_m.clear();
    return;
  }
  course.starts.push_back(static_cast<std::uint32_t>(course.points_m.size() - 1));
  if (line.closed) start_in_longest_leg(course);
  course.at_m.assign(1, 0);
  for (std::size_t i = 1; i < course.points_m.size(); ++i) {
    course.at_m.push_back(course.at_m.back() + glm::length(course.points_m[i] - course.points_m[i - 1]));
  }
}

glm::dvec2 EndView::outward_of_cut(double from_end_m) const {
  const glm::dvec2 ahead = point_at(std::min(from_end_m + kLookAhead_m, length_m())) - point_at(from_end_m);
  // A loop may come back to the same place.
  return glm::length(ahead) > 0.25 * kLookAhead_m ? glm::normalize(ahead) : outward_at(from_end_m);
}

EndView::Widths EndView::widths_at(double from_end_m) const {
  const OsmPiece& piece = course_->pieces[course_->piece_at(place(from_end_m))];
  const SectionEdges e = edges_of_way(scene_->data.ways[piece.way].tags, piece.along(), scene_->keep_left);
  if (at_end_) return {-e.right_m, e.left_m};
  return {e.left_m, -e.right_m};
}

}  // namespace roadgen
