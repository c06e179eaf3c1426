// Cut and fill: the ground levelled along roads, so that no road is buried and none floats.
//
// Under a carriageway and its shoulders the ground is the road's surface less a gap too small to see; from there it
// departs towards the natural ground no steeper than an embankment or a cutting stands, and takes over the natural
// ground where it meets it. Between legs of road that lie close together at different heights (hairpins) the heights
// of the legs are blended by inverse distance; where even their shoulders meet, the ground is each leg's at its edge and
// a wall stands between them. Under overlapping carriageways the lowest wins.
// Between shoulder and slope a ditch may run: it is cut into the ground, so where an embankment falls below its bottom
// there is none. It ends before other roads and their shoulders, junctions, bridges and tunnels.
// To bridges (Road::bridges) nothing is raised: where one begins, the road's level strip goes on for a shoulder's width
// and ends with an embankment. Ground that rises above a deck is cut.
// Over tunnels whose vault is covered, by the natural ground or by that of roads that cross above, it stays: the cutting of the road before the portal goes on for a
// shoulder's width into the tunnel, and from there on takes no ground within cover_m of the vault, nor any that a slope
// of fill from there would hold. Where no more than kMostRoof_m lack, ground is filled up over the vault.
// Source: Loviscach 2005, section 4 and figure 6 (level geometry along roads, a small height gap below them); weights
// of Franke and Nielson 1980 for the blending.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "roadgen/query/box_tree.h"
#include "roadgen/query/road_index.h"
#include "terrain/grid.h"
#include "terrain/support.h"

namespace roadgen {

// Of fill over a tunnel: more would be a dam across the country, and the elevation of towns is no better than that.
inline constexpr double kMostRoof_m = 2.5;

struct LevellingOptions {
  double gap_m = 0.05;      // of the ground below the road's surface. > 0. Default: 5 cm, not seen even from a kerb
  double shoulder_m = 3.0;  // level strip beside the carriageway. >= 0. Default: 3 m
  double cut_slope = 1.0;   // steepest rise of a cutting, height / width. > 0. Default: 1 (rock and firm soil)
  double fill_slope = 0.7;  // steepest fall of an embankment, > 0. Default: 0.7 (2:3, loose fill)
  // Ditch beyond the shoulder: its bottom's depth below the carriageway's edge, >= 0, and width, >= 0, and its slopes
  // towards the road and away from it, height / width, > 0. Default: none (no source of roads tells of ditches, and
  // streets have none); 0.5 m wide at the bottom, 1:2 and 2:3.
  double ditch_depth_m = 0;
  double ditch_bottom_m = 0.5;
  double ditch_inner_slope = 0.5;
  double ditch_outer_slope = 2.0 / 3;
  double cover_m = 0.5;  // least height of the ground over a tunnel's vault; with less it is cut open. >= 0
  double reach_m = 50;   // from here on, beyond the shoulder, the ground is natural in any case. > 0

  // From the shoulder to where the ditch has come up again to the edge's level. 0: no ditch.
  double ditch_width_m() const {
    return ditch_depth_m > 0 ? ditch_depth_m / ditch_inner_slope + ditch_bottom_m + ditch_depth_m / ditch_outer_slope
                             : 0;
  }
};

// Distance in metres from the nearest road's centre line or junction's corner at every post of a grid shaped like the
// given one.
// Accuracy: a post's diagonal. Cost: O(posts).
Grid distance_from_roads(const Network& network, const Grid& like);

// The levelled ground, a function of the place. Any number of threads may ask; nothing is allocated per query.
class Levelling {
 public:
  // Requires: index and natural outlive this; at least one segment.
  Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options);

  // Height of the levelled ground. Continuous but for the edges of carriageways that overlap at different heights, and
  // where the hill over a tunnel begins. Cost: far from roads one bicubic sample; near them O(segments within reach).
  double height_m(glm::dvec2 point_m) const;

  // Whether the place is so far from all roads that the ground there is the natural one for sure. Cost: one bilinear
  // sample.
  bool is_natural(glm::dvec2 point_m) const;

  // Distance from the nearest carriageway on the ground: exact where it is less than limit_m, else at least limit_m or,
  // far away, a lower bound. 0 on a carriageway.
  double edge_distance_m(glm::dvec2 point_m, double limit_m) const;

  const LevellingOptions& options() const { return options_; }
  const RoadIndex& index() const { return index_; }
  const Supports& supports() const { return supports_; }

 private:
  // What the roads on the ground around a point want of it there.
  struct Wish {
    double edge_m;      // from the nearest carriageway's edge
    double level_m;     // on carriageways the lowest one's height; beside them that of their edges, the nearer the more
    glm::dvec2 foot_m;  // on the nearest road's centre line; of an area the point itself
  };
  struct Sample {
    glm::dvec2 position_m;
    double z_m, half_width_m;
  };
  // The heights of the roads and areas around, weighted: mean and standard deviation.
  struct Blend {
    double mean_m, deviation_m;
  };
  // On a bridge: a part of a segment, or a junction's area.
  struct Raised {
    SegmentRef at;
    SupportedPart part;
    std::int32_t junction = -1;
  };
  Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options,
            const std::shared_ptr<const Grid>& distance);
  Levelling(const RoadIndex& index, const Grid& natural, const LevellingOptions& options,
            std::shared_ptr<const Grid> distance, Supports supports);
  static Supports find_supports(const RoadIndex& index, const Grid& natural, const LevellingOptions& options,
                                const std::shared_ptr<const Grid>& distance);
  void find_raised();
  Wish nearest_roads(glm::dvec2 point_m, double limit_m) const;
  double levelled_m(glm::dvec2 point_m, double& edge_m) const;
  double ditch_part(glm::dvec2 point_m, const Wish& wish) const;
  double below_bridges_m(glm::dvec2 point_m, double ground_m, double road_m) const;
  double over_tunnels_m(glm::dvec2 point_m) const;
  Blend blend(glm::dvec2 point_m) const;
  double far_distance_m(glm::dvec2 point_m) const;
  std::size_t bucket(glm::dvec2 point_m, int dx, int dy) const;

  const RoadIndex& index_;
  const Grid& natural_;
  LevellingOptions options_;
  std::shared_ptr<const Grid> distance_;
  double widest_m_ = 0;
  double slack_m_ = 0;  // how far distance_ may be off
  Supports supports_;
  std::vector<Raised> raised_;
  std::vector<JunctionSurface> surfaces_;  // of raised areas
  BoxTree raised_tree_, hollow_tree_;
  // Samples of roads and areas in square buckets, those of a bucket side by side: first_[b] to first_[b + 1].
  glm::dvec2 bucket_origin_m_{0, 0};
  double bucket_m_ = 1;
  int bucket_columns_ = 0, bucket_rows_ = 0;
  std::vector<std::uint32_t> first_;
  std::vector<Sample> samples_;
};

}  // namespace roadgen
