// Internal, not installed: the ground's tiles on the GPU, and their draw in the level of detail that a view needs.
//
// Vertices lie in pages of a pool of bounded size. A page is uploaded when a triangle that is drawn needs it, and the page
// used the longest time ago makes room for it; since a tile's vertices go from coarse to fine, a far tile takes a page or
// two. Where a frame needs more than fits, it is drawn in several batches, in the same order, so the picture is the same.
// Of a ground that lies in a file, what the view asks for is read by a thread beside the drawing; until it is there, the
// tile and what its neighbours share with it are drawn coarser. What is never left out is waited for.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "roadgen/render/gl.h"
#include "roadgen/render/page_pool.h"
#include "roadgen/render/program.h"
#include "roadgen/road/result.h"
#include "terrain/detail.h"
#include "terrain/ground_loader.h"
#include "terrain/ground_source.h"
#include "terrain/horizon.h"

namespace roadgen {

// The least of RendererOptions::ground_budget_bytes.
inline constexpr std::size_t kLeastGroundBytes = 64 << 10;

struct GroundView {
  glm::dvec3 eye_m{0, 0, 0};
  double part = 0;                            // of the distance by which the mesh may be off; 0: not at all
  bool waits = true;                          // for all that is to be read; else what is not there is drawn coarser
  bool leaves_out_hidden = true;              // what is behind nearer ground is not drawn
  double pixel_rad = 0, nearest_drawn_m = 0;  // as in Horizon::begin
  const std::function<bool(glm::dvec3, double)>& may_see;  // a centre from the eye, and a radius
};

class GroundBatch {
 public:
  // Owns nothing and draws nothing.
  GroundBatch() = default;
  // Requires: budget_bytes at least kLeastGroundBytes. On the GPU no more than that is taken for vertices (28 bytes each)
  // and indices; hollows and the tiles' places come to it.
  GroundBatch(std::shared_ptr<const GroundSource> source, std::size_t budget_bytes);
  bool empty() const { return tiles_.empty(); }
  bool has_cuts() const { return has_cuts_; }
  double low_m() const { return low_m_; }
  double high_m() const { return high_m_; }
  const GroundStatistics& statistics() const { return statistics_; }

  // at_tunnels is the program for what is cut away there. Requires: depth test on, the frame's uniforms bound. Errors: the
  // source's. Cost: where the view has changed, O(triangles drawn) on the CPU.
  Status draw(const Program& ground, const Program& at_tunnels, const GroundView& view);

 private:
  // How far the eye moves before another level of detail is chosen.
  static constexpr double kRoom_m = 1;

  struct Tile {
    std::uint32_t first_page = 0;
    GLuint first_hollow = 0;
  };
  // A tile in view.
  struct Seen {
    std::size_t tile;
    std::uint32_t bands;  // that are drawn
    bool operator==(const Seen&) const = default;
  };
  // Triangles of one tile: those that meet no tunnel, or of one of its cuts.
  struct Command {
    std::uint32_t count, first;         // indices
    std::uint32_t place;                // of the tile among those seen
    GLuint first_hollow, hollow_count;  // 0: no cut
  };
  // The draws of the pictures, or of the channels.
  struct Drawing {
    gl::Buffer indices;
    std::size_t capacity = 0;
    std::vector<Command> commands;
    // Of which the commands and the indices on the GPU are all; else they have to be made again.
    bool is_whole = false;
    glm::dvec3 eye_m{0, 0, 0};
    bool left_out_hidden = true;
    Detail detail;
    std::vector<Seen> seen;
    std::uint64_t replacements = 0;
  };

  std::vector<Seen> see(const GroundView& view, Detail& detail);
  Status read_ahead(glm::dvec3 eye_m, const std::vector<Seen>& seen, const Detail& detail);
  Status make(Drawing& drawing, const GroundView& view, const Program& ground, const Program& at_tunnels);
  // Adds triangles of a tile, and draws what has gathered as often as there is no more room.
  void add(Drawing& drawing, std::uint32_t place, std::span<const std::uint32_t> triangles, const Command& as,
           const std::function<void()>& flush);
  bool place(std::size_t tile, std::uint32_t vertex, std::uint32_t& index);
  void upload_indices(Drawing& drawing);
  void issue(const Drawing& drawing, const Program& ground, const Program& at_tunnels);

  std::unique_ptr<GroundLoader> loader_;
  std::size_t budget_bytes_ = 0, index_bytes_ = 0;  // of these, for the indices of each drawing
  std::vector<Tile> tiles_;
  PagePool pages_;
  std::vector<std::uint32_t> filled_;  // vertices in each slot of the pool
  gl::VertexArray vertex_array_;
  gl::Buffer pool_, origins_, hollows_, commands_;
  Drawing picture_, channels_;
  Detail detail_;  // of the picture, but for its gaps
  Horizon horizon_;
  std::vector<std::uint32_t> indices_;  // of the batch at hand
  std::vector<std::uint32_t> chosen_;   // triangles of a tile
  double low_m_ = 0, high_m_ = 0;
  bool has_cuts_ = false;
  glm::vec3 place_from_eye_{0, 0, 0};  // of the place that a frame's tiles are told from
  GroundStatistics statistics_;
};

}  // namespace roadgen
