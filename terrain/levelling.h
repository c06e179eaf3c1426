// Cut and fill: the ground levelled along roads, so that no road is buried and none floats.
//
// Under a carriageway and its shoulders the ground is the road's surface less a gap too small to see; from there it
// departs towards the natural ground no steeper than an embankment or a cutting stands, and takes over the natural
// ground where it meets it. Between legs of road that lie close together at different heights (hairpins) the heights
// of the legs are blended by inverse distance; under overlapping carriageways the lowest wins.
// Source: Loviscach 2005, section 4 and figure 6 (level geometry along roads, a small height gap below them); weights
// of Franke and Nielson 1980 for the blending.
#pragma once

#include <cstdint>
#include <vector>

#include "roadgen/query/road_index.h"
#include "terrain/grid.h"

namespace roadgen {

struct LevellingOptions {
  double gap_m = 0.05;      // of the ground below the road's surface. > 0. Default: 5 cm, not seen even from a kerb
  double shoulder_m = 3.0;  // level strip beside the carriageway. >= 0. Default: 3 m
  double cut_slope = 1.0;   // steepest rise of a cutting, height / width. > 0. Default: 1 (rock and firm soil)
  double fill_slope = 0.7;  // steepest fall of an embankment, > 0. Default: 0.7 (2:3, loose fill)
  double reach_m = 50;      // from here on, beyond the shoulder, the ground is natural in any case. > 0
};

// Distance in metres from the centre line of the nearest road at every post of a grid shaped like the given one.
// Accuracy: a post's diagonal. Cost: O(posts).
Grid distance_from_roads(const Network& network, const Grid& like);

// The levelled ground, a function of the place. Any number of threads may ask; nothing is allocated per query.
class Levelling {
 public:
  // Requires: index and natural outlive this; at least one segment.
  Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options);

  // Height of the levelled ground. Continuous but for where three legs of road meet at different heights within
  // their shoulders. Cost: far from roads one bicubic sample; near them O(segments within reach).
  double height_m(glm::dvec2 point_m) const;

  // Distance from the nearest carriageway: exact where it is less than limit_m, else at least limit_m or, far away,
  // a lower bound. 0 on a carriageway.
  double edge_distance_m(glm::dvec2 point_m, double limit_m) const;

  const LevellingOptions& options() const { return options_; }
  const RoadIndex& index() const { return index_; }

 private:
  // What the roads around a point want of the ground there.
  struct Wish {
    double edge_m;    // from the nearest carriageway's edge
    double lowest_m;  // of the roads whose level strip the point is in; else the nearest road's height
  };
  struct Sample {
    glm::dvec2 position_m;
    double z_m, half_width_m;
  };
  // The heights of the roads around, weighted: mean and standard deviation.
  struct Blend {
    double mean_m, deviation_m;
  };
  Wish nearest_roads(glm::dvec2 point_m, double limit_m) const;
  Blend blend(glm::dvec2 point_m) const;
  double far_distance_m(glm::dvec2 point_m) const;
  std::size_t bucket(glm::dvec2 point_m, int dx, int dy) const;

  const RoadIndex& index_;
  const Grid& natural_;
  LevellingOptions options_;
  Grid distance_;
  double widest_m_ = 0;
  double slack_m_ = 0;  // how far distance_ may be off
  // Road samples in square buckets, those of a bucket side by side: first_[b] to first_[b + 1].
  glm::dvec2 bucket_origin_m_{0, 0};
  double bucket_m_ = 1;
  int bucket_columns_ = 0, bucket_rows_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<Sample> samples_;
};

}  // namespace roadgen
