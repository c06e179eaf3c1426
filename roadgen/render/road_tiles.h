// Internal, not installed: the roads on the GPU. Per frame the tiles that the camera sees are drawn from far to near, by
// one indirect draw for each kind of segment.
//
// Instances lie in pages of a pool of bounded size: a page is uploaded when a tile in it is first seen, and the page
// seen the longest time ago makes room for it. Where the pages that one frame needs do not fit, the frame is drawn in
// several batches, in the same order, so the picture is the same.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "roadgen/render/box_strip.h"
#include "roadgen/render/page_pool.h"
#include "roadgen/render/program.h"
#include "roadgen/render/road_instance.h"
#include "roadgen/render/tile_index.h"

namespace roadgen {

// Segments in a page of the pool: 31 KiB.
inline constexpr std::uint32_t kPageSegments = 256;
inline constexpr std::size_t kPageBytes = kPageSegments * sizeof(RoadInstance);

class RoadTiles {
 public:
  // Owns nothing and draws nothing.
  RoadTiles() = default;
  // Requires: budget_bytes at least kPageBytes.
  RoadTiles(RoadScene scene, std::size_t budget_bytes);

  // Draws into the current framebuffer, with its blending and depth test. cull: false draws every tile.
  void draw(const TileView& view, bool cull, const std::array<LazyProgram, kRoadKinds>& programs);
  // Whether there are roads of the kind, whose program draw needs.
  bool has(std::size_t kind) const { return !scene_.instances[kind].empty(); }
  const RoadStatistics& statistics() const { return statistics_; }

 private:
  // As glMultiDrawElementsIndirect reads it.
  struct DrawCommand {
    std::uint32_t elements, instances, first_element, first_vertex, first_instance;
  };
  // Gathers the draws of data[first], ..., data[first + count - 1]; first_page: of data[0].
  void add(std::span<const RoadInstance> data, std::uint32_t first_page, std::uint32_t first, std::uint32_t count,
           ElementRange strip);
  // The place of a page in the pool. Uploaded there if need be, and drawn what has gathered if there is no room.
  std::uint32_t place(std::uint32_t page, std::span<const RoadInstance> data);
  // Draws what has gathered and begins a new batch.
  void flush();

  RoadScene scene_;
  TileIndex index_;
  gl::VertexArray vertex_array_;
  gl::Buffer pool_, elements_, commands_, tiles_, sections_, paint_;
  gl::Texture section_texels_;
  std::array<std::uint32_t, kRoadKinds> first_page_{};  // of each kind's instances
  PagePool pages_;
  std::vector<DrawCommand> pending_;
  std::vector<std::uint32_t> visible_;
  RoadStatistics statistics_;
};

}  // namespace roadgen
