// What carries each part of a road: the ground, which is levelled to it, a bridge, which leaves the ground alone, or a
// tunnel under ground that is higher, which is kept.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "roadgen/query/footprint.h"
#include "roadgen/road/network.h"
#include "terrain/hall.h"
#include "terrain/hollow.h"

namespace roadgen {

enum class Support { kGround, kBridge, kTunnel };

// A part of one segment that has one support.
struct SupportedPart {
  Support support = Support::kGround;
  bool is_assumed = false;                      // a bridge that the network does not know of
  double s0_m = 0, s1_m = 0;                    // from the segment's start; s1_m may lie beyond its end
  double u0 = 0, u1 = 1;                        // the same of the chord parameter
  bool starts_here = false, ends_here = false;  // not where a neighbour with the same support goes on
};

struct AssumedBridges;

// Of every road and junction area of a network. A default-constructed one knows nothing but ground.
class Supports {
 public:
  Supports() = default;
  // By Road::bridges, cut off at the road's ends. A junction area is a bridge's where all its arms are on bridges.
  // Tunnels: where the ground without them, seen every metre, is cover_m higher than the vault's crown over all of its width
  // and the carriageway is within its walls, for at least least_m or all of the road. Elsewhere a tunnel's road lies on
  // the ground, which is cut open for it. A junction area is a tunnel's where all its arms end in tunnels under a hill that
  // covers the area too.
  // Requires: the network outlives this and stays unchanged. Cost: O(roads + metres of tunnels).
  // assumed: bridges that the network does not know of; none where there is another support.
  using Ground = std::function<double(glm::dvec2)>;
  Supports(const Network& network, const Ground& ground_m, double cover_m, double least_m,
           const AssumedBridges& assumed);
  Supports(const Network& network, const Ground& ground_m, double cover_m, double least_m);

  // In the order of s, without gaps. Cost: O(1).
  std::span<const SupportedPart> of(const Network& network, SegmentRef at) const;
  Support of_junction(std::size_t junction) const {
    return junction < junctions_.size() ? junctions_[junction] : Support::kGround;
  }
  bool is_assumed(std::size_t junction) const { return junction < assumed_.size() && assumed_[junction] != 0; }

  // How many parts of roads have a support, but for assumed bridges, and their length.
  std::size_t parts(Support support) const { return count_[static_cast<std::size_t>(support)]; }
  double length_m(Support support) const { return length_m_[static_cast<std::size_t>(support)]; }
  std::size_t assumed_parts() const { return assumed_count_; }
  double assumed_m() const { return assumed_length_m_; }
  // The clear spaces of all parts in tunnels.
  const std::vector<Hollow>& hollows() const { return hollows_; }
  // The junction areas in tunnels.
  const std::vector<Hall>& halls() const { return halls_; }

  // A part of a road.
  struct Part {
    Support support;
    double s_start_m, s_end_m;
    bool is_assumed = false;
  };

 private:
  void add_tunnels(const Road& road, const Ground& ground_m, double cover_m, double least_m, std::vector<Part>& raised);
  void cut(const Road& road, const std::vector<Part>& parts);
  void add_junctions(const Network& network, const Ground& ground_m, double cover_m, const AssumedBridges& assumed);

  static constexpr std::uint32_t kPlain = 0xffffffffu;
  std::vector<std::uint32_t> first_;  // of each road: the place of its first segment in segments_, or kPlain
  struct Range {
    std::uint32_t first, count;
  };
  std::vector<Range> segments_;  // of stretches_
  std::vector<SupportedPart> stretches_;
  std::vector<Support> junctions_;
  std::vector<Hollow> hollows_;
  std::vector<Hall> halls_;
  std::array<std::size_t, 3> count_{};  // of roads that are not on the ground as a whole
  std::array<double, 3> length_m_{};
  std::vector<char> assumed_;  // [junction]
  std::size_t assumed_count_ = 0;
  double assumed_length_m_ = 0;
};

// Bridges that a network does not know of.
struct AssumedBridges {
  std::vector<std::vector<Supports::Part>> of_road;  // parts of roads, on bridges
  std::vector<char> junctions;                       // areas that are
};

}  // namespace roadgen
