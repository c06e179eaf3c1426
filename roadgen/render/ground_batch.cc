#include "roadgen/render/ground_batch.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>
#include <numeric>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace roadgen {
namespace {

// The layout that shaders/terrain.frag declares.
struct HollowInstance {
  glm::vec4 start, shape, arc, axis, place, box, vault;
};
static_assert(sizeof(HollowInstance) == 112);

HollowInstance instance(const Hollow& hollow, glm::dvec3 origin_m) {
  const Lib::SweepPiece& p = hollow.piece;
  const Lib::SweepPath& r = p.path;
  return {glm::dvec4(hollow.start_m - origin_m, 0),
          glm::dvec4(hollow.segment.chord_m(), r.a, r.b),
          glm::dvec4(r.arc, r.c0, r.c1, p.profile.p4),
          glm::dvec4(r.z0, r.z1, r.z2, r.z3),
          glm::dvec4(r.n0, r.n1, p.u0, p.u1),
          glm::dvec4(p.y0, p.y1, p.z0, p.z1),
          glm::dvec4(p.profile.p0, p.profile.p1, p.profile.p2, 0)};
}

constexpr std::uint32_t kPageVertices = 32;  // few: a far tile has some ten
struct Vertex {
  glm::vec3 position_m, normal;
  float road_m;
};
static_assert(sizeof(Vertex) == 28);
constexpr std::size_t kVertexPageBytes = kPageVertices * sizeof(Vertex);
constexpr std::size_t kTriangleBytes = 3 * sizeof(std::uint32_t);

std::uint32_t pages(std::size_t vertices) {
  return static_cast<std::uint32_t>((vertices + kPageVertices - 1) / kPageVertices);
}

// Reads Vertex from binding 0, and the tile's place from the eye from binding 1, once per instance.
gl::VertexArray vertex_array() {
  gl::VertexArray array = gl::VertexArray::create();
  const auto attribute = [&](GLuint location, GLint components, std::size_t offset, GLuint binding) {
    glEnableVertexArrayAttrib(array.id(), location);
    glVertexArrayAttribFormat(array.id(), location, components, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
    glVertexArrayAttribBinding(array.id(), location, binding);
  };
  attribute(0, 3, offsetof(Vertex, position_m), 0);
  attribute(1, 3, offsetof(Vertex, normal), 0);
  attribute(2, 1, offsetof(Vertex, road_m), 0);
  attribute(3, 3, 0, 1);
  glVertexArrayBindingDivisor(array.id(), 1, 1);
  return array;
}

// Whether a point is over or under a tile that has levels of detail.
bool is_over(const GroundTile& tile, glm::dvec3 point_m) {
  const glm::dvec3 p = point_m - tile.origin_m;
  return !tile.nodes.empty() && p.x >= tile.low_m.x && p.x <= tile.high_m.x && p.y >= tile.low_m.y &&
         p.y <= tile.high_m.y;
}

// As glMultiDrawElementsIndirect reads it.
struct DrawCommand {
  std::uint32_t elements, instances, first_element, first_vertex, first_instance;
};

}  // namespace

GroundBatch::GroundBatch(std::shared_ptr<const GroundSource> source, std::size_t budget_bytes)
    : loader_(std::make_unique<GroundLoader>(std::move(source))),
      budget_bytes_(budget_bytes),
      vertex_array_(roadgen::vertex_array()),
      origins_(gl::Buffer::create()),
      commands_(gl::Buffer::create()) {
  assert(budget_bytes >= kLeastGroundBytes);
  std::uint32_t page_count = 0;
  std::vector<HollowInstance> hollows;
  low_m_ = std::numeric_limits<double>::max();
  high_m_ = -low_m_;
  for (const GroundTile& tile : loader_->source().tiles()) {
    Tile& made = tiles_.emplace_back();
    made.first_page = page_count;
    made.first_hollow = static_cast<GLuint>(hollows.size());
    page_count += pages(tile.bands.back().vertices);
    for (const TerrainMesh::Cut& cut : tile.cuts) {
      for (const std::uint32_t i : cut.hollows) hollows.push_back(instance(tile.hollows[i], tile.origin_m));
    }
    low_m_ = std::min(low_m_, tile.origin_m.z + tile.low_m.z);
    high_m_ = std::max(high_m_, tile.origin_m.z + tile.high_m.z);
    statistics_.triangles += tile.triangle_count();
  }
  statistics_.tiles = tiles_.size();
  const auto& sources = loader_->source().tiles();
  has_cuts_ = std::any_of(sources.begin(), sources.end(), [](const GroundTile& tile) { return !tile.cuts.empty(); });
  if (tiles_.empty()) {
    low_m_ = high_m_ = 0;
    return;
  }
  // Half for vertices, a quarter for the indices of the picture and one for those of the channels: of a whole mesh, two
  // triangles a vertex, these take 28 bytes and 24 each.
  const auto slots = static_cast<std::uint32_t>(std::min<std::size_t>(page_count, budget_bytes / 2 / kVertexPageBytes));
  index_bytes_ = (budget_bytes - slots * kVertexPageBytes) / 2 / kTriangleBytes * kTriangleBytes;
  pages_ = PagePool(page_count, slots);
  filled_.assign(slots, 0);
  pool_ = gl::Buffer::with_data(static_cast<GLsizeiptr>(slots * kVertexPageBytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  glVertexArrayVertexBuffer(vertex_array_.id(), 0, pool_.id(), 0, sizeof(Vertex));
  glVertexArrayVertexBuffer(vertex_array_.id(), 1, origins_.id(), 0, sizeof(glm::vec3));
  if (!hollows.empty()) {
    hollows_ = gl::Buffer::with_data(static_cast<GLsizeiptr>(hollows.size() * sizeof hollows[0]), hollows.data());
  }
  statistics_.gpu_bytes = slots * kVertexPageBytes;
}

// The tiles in view, and from how many of their bands they are drawn; `detail` gets the gaps.
std::vector<GroundBatch::Seen> GroundBatch::see(const GroundView& view, Detail& detail) {
  std::vector<Seen> seen;
  const std::span<const GroundTile> tiles = loader_->source().tiles();
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const GroundTile& tile = tiles[i];
    if (!view.may_see(tile.center_m() - view.eye_m, tile.radius_m())) continue;
    const std::uint32_t needed = bands_needed(tile, detail);
    const std::uint32_t bands = view.waits ? needed : std::min(needed, std::max(loader_->loaded(i), 1u));
    seen.push_back({i, bands});
    if (bands < needed) detail.gaps.push_back(gap_of(tile, bands));
  }
  // From near to far: what is hidden is then known before it is shaded.
  const auto away = [&](const Seen& s) { return glm::length(glm::dvec2(tiles[s.tile].center_m() - view.eye_m)); };
  std::stable_sort(seen.begin(), seen.end(), [&](const Seen& a, const Seen& b) { return away(a) < away(b); });
  return seen;
}

// Wishes for what is in view, the nearest first, then for what would be if the eye turned.
Status GroundBatch::read_ahead(glm::dvec3 eye_m, const std::vector<Seen>& seen, const Detail& detail) {
  const std::span<const GroundTile> tiles = loader_->source().tiles();
  std::vector<bool> is_seen(tiles.size(), false);
  for (const Seen& s : seen) is_seen[s.tile] = true;
  std::vector<double> away(tiles.size());
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    away[i] = glm::length(tiles[i].center_m() - eye_m) - tiles[i].radius_m();
  }
  std::vector<GroundLoader::Wish> wishes;
  for (std::size_t i = 0; i < tiles.size(); ++i) wishes.push_back({i, bands_needed(tiles[i], detail)});
  std::stable_sort(wishes.begin(), wishes.end(), [&](const auto& a, const auto& b) {
    return is_seen[a.tile] != is_seen[b.tile] ? is_seen[a.tile] : away[a.tile] < away[b.tile];
  });
  return loader_->wish(wishes, budget_bytes_);
}

// Where a vertex lies in the pool; false: there is no room in this batch.
bool GroundBatch::place(std::size_t tile, std::uint32_t vertex, std::uint32_t& index) {
  const std::uint32_t page = vertex / kPageVertices, in_page = vertex % kPageVertices;
  const std::optional<PagePool::Placed> at = pages_.place(tiles_[tile].first_page + page);
  if (!at) return false;
  std::uint32_t& filled = filled_[at->slot];
  if (at->is_new) filled = 0;
  if (in_page >= filled) {
    const GroundTile& t = loader_->source().tiles()[tile];
    // As much of the page as is at hand.
    const std::uint32_t first = page * kPageVertices;
    filled = std::min(kPageVertices, t.bands[loader_->loaded(tile) - 1].vertices - first);
    Vertex vertices[kPageVertices];
    for (std::uint32_t i = 0; i < filled; ++i) {
      vertices[i] = {t.positions_m[first + i], t.normals[first + i],
                     t.road_m.empty() ? static_cast<float>(TerrainMesh::kVerge_m) : t.road_m[first + i]};
    }
    glNamedBufferSubData(pool_.id(), static_cast<GLintptr>(at->slot * kVertexPageBytes),
                         static_cast<GLsizeiptr>(filled * sizeof(Vertex)), vertices);
    statistics_.uploaded_bytes += filled * sizeof(Vertex);
  }
  index = at->slot * kPageVertices + in_page;
  return true;
}

void GroundBatch::add(Drawing& drawing, std::uint32_t place_in_view, std::span<const std::uint32_t> triangles,
                      const Command& as, const std::function<void()>& flush) {
  const std::size_t tile = drawing.seen[place_in_view].tile;
  const auto begin = [&] {
    drawing.commands.push_back(as);
    drawing.commands.back().first = static_cast<std::uint32_t>(indices_.size());
    drawing.commands.back().place = place_in_view;
    drawing.commands.back().count = 0;
  };
  if (triangles.empty()) return;
  begin();
  statistics_.drawn_triangles += triangles.size() / 3;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    std::uint32_t corners[3];
    const auto fits = [&] {
      return (indices_.size() + 3) * sizeof(indices_[0]) <= index_bytes_ && place(tile, triangles[i], corners[0]) &&
             place(tile, triangles[i + 1], corners[1]) && place(tile, triangles[i + 2], corners[2]);
    };
    while (!fits()) {
      // The batch's own pages fill the pool, or its triangles the indices: draw them first.
      flush();
      begin();
    }
    indices_.insert(indices_.end(), corners, corners + 3);
    drawing.commands.back().count += 3;
  }
}

void GroundBatch::upload_indices(Drawing& drawing) {
  const std::size_t bytes = indices_.size() * sizeof(indices_[0]);
  if (bytes > drawing.capacity) {
    statistics_.gpu_bytes -= drawing.capacity;
    drawing.indices.reset();
    drawing.capacity = std::min(std::max(bytes, 2 * drawing.capacity), index_bytes_);
    drawing.indices = gl::Buffer::with_data(static_cast<GLsizeiptr>(drawing.capacity), nullptr, GL_DYNAMIC_STORAGE_BIT);
    statistics_.gpu_bytes += drawing.capacity;
  }
  if (bytes > 0) glNamedBufferSubData(drawing.indices.id(), 0, static_cast<GLsizeiptr>(bytes), indices_.data());
}

void GroundBatch::issue(const Drawing& drawing, const Program& ground, const Program& at_tunnels) {
  ++statistics_.batches;
  glVertexArrayElementBuffer(vertex_array_.id(), drawing.indices.id());
  glBindVertexArray(vertex_array_.id());
  std::vector<DrawCommand> whole;
  for (const Command& c : drawing.commands) {
    if (c.hollow_count == 0 && c.count > 0) whole.push_back({c.count, 1, c.first, 0, c.place});
  }
  if (!whole.empty()) {
    ground.use();
    glUniform3f(0, place_from_eye_.x, place_from_eye_.y, place_from_eye_.z);
    glNamedBufferData(commands_.id(), static_cast<GLsizeiptr>(whole.size() * sizeof whole[0]), whole.data(),
                      GL_STREAM_DRAW);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.id());
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(whole.size()), 0);
  }
  const bool has_cut = std::any_of(drawing.commands.begin(), drawing.commands.end(),
                                   [](const Command& c) { return c.hollow_count > 0 && c.count > 0; });
  if (!has_cut) return;
  at_tunnels.use();
  glUniform3f(0, place_from_eye_.x, place_from_eye_.y, place_from_eye_.z);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, hollows_.id());
  for (const Command& c : drawing.commands) {
    if (c.hollow_count == 0 || c.count == 0) continue;
    glUniform2ui(1, c.first_hollow, c.hollow_count);
    glDrawElementsInstancedBaseInstance(GL_TRIANGLES, static_cast<GLsizei>(c.count), GL_UNSIGNED_INT,
                                        reinterpret_cast<const void*>(c.first * sizeof(std::uint32_t)), 1, c.place);
  }
}

// Gathers the triangles of a frame, and draws them: the last batch of them by what it leaves in `drawing`.
Status GroundBatch::make(Drawing& drawing, const GroundView& view, const Program& ground, const Program& at_tunnels) {
  const std::span<const GroundTile> tiles = loader_->source().tiles();
  const std::size_t batches = statistics_.batches;
  const auto flush = [&] {
    upload_indices(drawing);
    issue(drawing, ground, at_tunnels);
    indices_.clear();
    drawing.commands.clear();
    pages_.begin_batch();
  };
  pages_.begin_batch();
  indices_.clear();
  drawing.commands.clear();
  drawing.is_whole = false;
  statistics_.drawn_triangles = 0;
  // What is over or under the eye tells whether that is above the ground; it comes first.
  const bool hides =
      view.leaves_out_hidden && !drawing.seen.empty() && is_over(tiles[drawing.seen[0].tile], view.eye_m);
  if (hides) horizon_.begin(view.eye_m, view.pixel_rad, view.nearest_drawn_m);
  for (const bool at_cuts : {false, true}) {
    for (std::uint32_t i = 0; i < drawing.seen.size(); ++i) {
      const Seen& seen = drawing.seen[i];
      const GroundTile& tile = tiles[seen.tile];
      if (at_cuts && tile.cuts.empty()) continue;
      if (Status s = loader_->load(seen.tile, at_cuts ? 1 : seen.bands); !s) return s;
      if (!at_cuts && !tile.nodes.empty()) {
        select_triangles(tile, seen.bands, drawing.detail, chosen_, hides ? &horizon_ : nullptr);
      }
      if (!at_cuts) add(drawing, i, tile.nodes.empty() ? tile.triangles : chosen_, {}, flush);
      std::uint32_t first_hollow = tiles_[seen.tile].first_hollow;
      for (const TerrainMesh::Cut& cut : at_cuts ? tile.cuts : std::span<const TerrainMesh::Cut>()) {
        const std::size_t first = cut.first - tile.cuts.front().first;
        const auto count = static_cast<GLuint>(cut.hollows.size());
        add(drawing, i, tile.cut_triangles.subspan(first, cut.count), {0, 0, 0, first_hollow, count}, flush);
        first_hollow += count;
      }
      if (loader_->loaded_bytes() > budget_bytes_) loader_->release(seen.tile);
    }
  }
  upload_indices(drawing);
  issue(drawing, ground, at_tunnels);
  drawing.is_whole = statistics_.batches == batches + 1;
  drawing.replacements = pages_.replacements();
  return Done{};
}

Status GroundBatch::draw(const Program& ground, const Program& at_tunnels, const GroundView& view) {
  statistics_.drawn_tiles = statistics_.batches = statistics_.uploaded_bytes = 0;
  if (tiles_.empty()) return Done{};
  const bool of_picture = view.part > 0;
  if (of_picture && (view.part != detail_.part || glm::length(view.eye_m - detail_.eye_m) > detail_.room_m)) {
    detail_ = {view.eye_m, kRoom_m, view.part};
  }
  Detail detail = of_picture ? detail_ : Detail{view.eye_m, 0, 0};
  std::vector<Seen> seen = see(view, detail);
  std::vector<glm::vec3> origins;
  // Near the eye, but on the quanta of the mesh: its vertices from there are exact in single precision up to 16 km.
  constexpr double kQuantum_m = TerrainMesh::kQuantum_m;
  const glm::dvec3 place = kQuantum_m * glm::round(view.eye_m / kQuantum_m);
  place_from_eye_ = place - view.eye_m;
  for (const Seen& s : seen) origins.emplace_back(loader_->source().tiles()[s.tile].origin_m - place);
  if (!origins.empty()) {
    glNamedBufferData(origins_.id(), static_cast<GLsizeiptr>(origins.size() * sizeof origins[0]), origins.data(),
                      GL_STREAM_DRAW);
  }
  statistics_.drawn_tiles = seen.size();
  statistics_.waiting_tiles = detail.gaps.size();
  Drawing& drawing = of_picture ? picture_ : channels_;
  const bool is_same = drawing.is_whole && drawing.replacements == pages_.replacements() && drawing.seen == seen &&
                       drawing.detail.part == detail.part && drawing.detail.gaps == detail.gaps &&
                       drawing.detail.eye_m == detail.eye_m && drawing.eye_m == view.eye_m &&
                       drawing.left_out_hidden == view.leaves_out_hidden;
  Status drawn = Done{};
  if (is_same) {
    statistics_.drawn_triangles = 0;
    for (const Command& c : drawing.commands) statistics_.drawn_triangles += c.count / 3;
    issue(drawing, ground, at_tunnels);
  } else {
    drawing.seen = std::move(seen);
    drawing.detail = std::move(detail);
    drawing.eye_m = view.eye_m;
    drawing.left_out_hidden = view.leaves_out_hidden;
    drawn = make(drawing, view, ground, at_tunnels);
  }
  statistics_.loaded_bytes = loader_->loaded_bytes();
  if (!drawn || loader_->source().is_in_memory()) return drawn;
  return read_ahead(view.eye_m, drawing.seen, of_picture ? detail_ : drawing.detail);
}

}  // namespace roadgen
