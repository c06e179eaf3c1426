#include "roadgen/render/road_tiles.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <utility>

namespace roadgen {
namespace {

std::uint32_t pages(std::size_t segments) {
  return static_cast<std::uint32_t>((segments + kPageSegments - 1) / kPageSegments);
}

// A table that the shaders read; never empty, so that it can be bound.
gl::Buffer table_buffer(const Table& rows) {
  const glm::vec4 none(0);
  return rows.empty() ? gl::Buffer::with_data(sizeof none, &none)
                      : gl::Buffer::with_data(static_cast<GLsizeiptr>(rows.size() * sizeof rows[0]), rows.data());
}

// Reads RoadInstance from binding 0, once per instance.
gl::VertexArray instance_array() {
  struct Field {
    GLint components;
    GLenum type;
    std::size_t offset;
  };
  constexpr Field kFields[] = {
      {3, GL_FLOAT, offsetof(RoadInstance, start)},     {1, GL_UNSIGNED_INT, offsetof(RoadInstance, tile)},
      {4, GL_FLOAT, offsetof(RoadInstance, shape)},     {4, GL_FLOAT, offsetof(RoadInstance, arc)},
      {4, GL_FLOAT, offsetof(RoadInstance, height)},    {4, GL_FLOAT, offsetof(RoadInstance, superelevation)},
      {4, GL_FLOAT, offsetof(RoadInstance, box)},       {4, GL_UNSIGNED_INT, offsetof(RoadInstance, road)},
      {1, GL_FLOAT, offsetof(RoadInstance, section_s)}, {2, GL_UNSIGNED_INT, offsetof(RoadInstance, crossfall_left)},
  };
  gl::VertexArray array = gl::VertexArray::create();
  glVertexArrayBindingDivisor(array.id(), 0, 1);
  for (GLuint location = 0; location < std::size(kFields); ++location) {
    const auto [components, type, offset] = kFields[location];
    glEnableVertexArrayAttrib(array.id(), location);
    if (type == GL_FLOAT) {
      glVertexArrayAttribFormat(array.id(), location, components, type, GL_FALSE, static_cast<GLuint>(offset));
    } else {
      glVertexArrayAttribIFormat(array.id(), location, components, type, static_cast<GLuint>(offset));
    }
    glVertexArrayAttribBinding(array.id(), location, 0);
  }
  return array;
}

}  // namespace

RoadTiles::RoadTiles(RoadScene scene, std::size_t budget_bytes)
    : scene_(std::move(scene)), index_(scene_.tiles), vertex_array_(instance_array()), commands_(gl::Buffer::create()) {
  std::uint32_t page_count = 0;
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
    first_page_[kind] = page_count;
    page_count += pages(scene_.instances[kind].size());
    statistics_.segments += scene_.instances[kind].size();
  }
  const std::size_t slot_count = std::min<std::size_t>(page_count, budget_bytes / kPageBytes);
  assert(page_count == 0 || slot_count > 0);
  pages_ = PagePool(page_count, static_cast<std::uint32_t>(slot_count));
  Table origins;
  for (const RoadTile& tile : scene_.tiles) {
    const SplitPosition origin = split(tile.origin_m);
    origins.emplace_back(origin.high, 0);
    origins.emplace_back(origin.low, 0);
  }
  tiles_ = table_buffer(origins);
  sections_ = table_buffer(scene_.sections);
  section_texels_ = gl::Texture::of_buffer(GL_RGBA32F, sections_);
  paint_ = table_buffer(scene_.paint);
  if (slot_count > 0) {
    pool_ = gl::Buffer::with_data(static_cast<GLsizeiptr>(slot_count * kPageBytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
    glVertexArrayVertexBuffer(vertex_array_.id(), 0, pool_.id(), 0, sizeof(RoadInstance));
  }
  bind_strips(vertex_array_, elements_);
  statistics_.tiles = scene_.tiles.size();
  statistics_.instance_bytes = statistics_.segments * sizeof(RoadInstance);
  statistics_.pool_bytes = slot_count * kPageBytes;
  statistics_.table_bytes = (origins.size() + scene_.sections.size() + scene_.paint.size()) * sizeof(glm::vec4);
  // On the GPU now.
  scene_.sections = scene_.paint = {};
}

void RoadTiles::draw(const TileView& view, bool cull, const std::array<LazyProgram, kRoadKinds>& programs) {
  statistics_.drawn_segments = statistics_.batches = statistics_.uploaded_bytes = 0;
  if (scene_.tiles.empty()) return;
  if (cull) {
    index_.select(view, visible_);
  } else {
    index_.select_all(view, visible_);
  }
  statistics_.drawn_tiles = visible_.size();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, tiles_.id());
  glBindTextureUnit(1, section_texels_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, paint_.id());
  glBindVertexArray(vertex_array_.id());
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
    if (!has(kind)) continue;
    const bool is_box = kind != kPlanar;
    if (is_box) {
      // Back faces only: one ray per pixel, also with the eye inside the box.
      glEnable(GL_CULL_FACE);
      glCullFace(GL_FRONT);
    }
    programs[kind]->use();
    for (const std::uint32_t i : visible_) {
      const RoadTile::Range range = scene_.tiles[i].ranges[kind];
      add(scene_.instances[kind], first_page_[kind], range.first, range.count, is_box ? kBoxStrip : kQuadStrip);
    }
    flush();
    glDisable(GL_CULL_FACE);
  }
}

void RoadTiles::add(std::span<const RoadInstance> data, std::uint32_t first_page, std::uint32_t first,
                    std::uint32_t count, ElementRange strip) {
  statistics_.drawn_segments += count;
  while (count > 0) {
    const std::uint32_t in_data = first / kPageSegments, in_page = first % kPageSegments;
    const std::uint32_t here = std::min(count, kPageSegments - in_page);
    const auto page = data.subspan(std::size_t{in_data} * kPageSegments);
    const std::uint32_t at = place(first_page + in_data, page.first(std::min<std::size_t>(page.size(), kPageSegments)));
    pending_.push_back({strip.count, here, strip.first, 0, at * kPageSegments + in_page});
    first += here;
    count -= here;
  }
}

std::uint32_t RoadTiles::place(std::uint32_t page, std::span<const RoadInstance> data) {
  std::optional<PagePool::Placed> at = pages_.place(page);
  if (!at) {
    // The batch's own pages fill the pool: draw them first. What is written after a draw does not change it.
    flush();
    at = pages_.place(page);
  }
  if (at->is_new) {
    glNamedBufferSubData(pool_.id(), static_cast<GLintptr>(at->slot * kPageBytes),
                         static_cast<GLsizeiptr>(data.size_bytes()), data.data());
    statistics_.uploaded_bytes += data.size_bytes();
  }
  return at->slot;
}

void RoadTiles::flush() {
  pages_.begin_batch();
  if (pending_.empty()) return;
  // A new store each time: the one before may still be read.
  glNamedBufferData(commands_.id(), static_cast<GLsizeiptr>(pending_.size() * sizeof pending_[0]), pending_.data(),
                    GL_STREAM_DRAW);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.id());
  glMultiDrawElementsIndirect(GL_TRIANGLE_STRIP, GL_UNSIGNED_SHORT, nullptr, static_cast<GLsizei>(pending_.size()), 0);
  pending_.clear();
  ++statistics_.batches;
}

}  // namespace roadgen
