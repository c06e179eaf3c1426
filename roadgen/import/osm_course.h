// The course of a line of OSM ways: its points, and where its tags change. Internal to roadgen/import.
#pragma once

#include <vector>

#include <glm/vec2.hpp>

#include "roadgen/import/osm_graph.h"

namespace roadgen {

// All that the steps of an import of OSM share.
struct OsmScene {
  const OsmData& data;
  const std::vector<glm::dvec2>& positions_m;  // of the nodes
  const OsmGraph& graph;
  bool keep_left = false;
};

// A polyline with the distance of every point from its start.
struct Course {
  std::vector<glm::dvec2> points_m;
  std::vector<double> at_m;           // increasing from 0
  std::vector<std::uint32_t> nodes;   // at each point
  std::vector<std::uint32_t> starts;  // index of each piece's first point; and of the last point
  std::vector<OsmPiece> pieces;

  double length_m() const { return at_m.back(); }
  // Of the leg that holds the distance, which is clamped.
  std::size_t leg_at(double distance_m) const;
  glm::dvec2 point_at(double distance_m) const;
  glm::dvec2 direction_at(double distance_m) const;
  std::size_t piece_at(double distance_m) const;
};

// Points that repeat the one before, to a millimetre, are left out. A closed line starts in the middle of its longest
// leg, whose node is that of the leg's start. Where fewer than two points are left the course has none.
void load_course(const OsmScene& scene, const OsmLine& line, Course& course);

inline constexpr double kLookAhead_m = 4;

// A course seen from one of its ends.
class EndView {
 public:
  EndView(const OsmScene& scene, const Course& course, bool at_end)
      : scene_(&scene), course_(&course), at_end_(at_end) {}

  double length_m() const { return course_->length_m(); }
  glm::dvec2 point_at(double from_end_m) const { return course_->point_at(place(from_end_m)); }
  glm::dvec2 outward_at(double from_end_m) const {
    const glm::dvec2 d = course_->direction_at(place(from_end_m));
    return at_end_ ? -d : d;
  }
  // The direction of a road that is cut off here: over the next kLookAhead_m, since a node may lie close by.
  glm::dvec2 outward_of_cut(double from_end_m) const;
  // Widths of the carriageway to the left and right of one who looks outward, from the end.
  struct Widths {
    double left_m, right_m;
  };
  Widths widths_at(double from_end_m) const;
  const WayTags& tags_at(double from_end_m) const {
    return scene_->data.ways[course_->pieces[course_->piece_at(place(from_end_m))].way].tags;
  }

 private:
  double place(double from_end_m) const { return at_end_ ? length_m() - from_end_m : from_end_m; }
  const OsmScene* scene_;
  const Course* course_;
  bool at_end_;
};

}  // namespace roadgen
