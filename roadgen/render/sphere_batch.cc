#include "roadgen/render/sphere_batch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include "roadgen/render/object_proxy.h"
#include "roadgen/render/sun_grid.h"

namespace roadgen {
namespace {

// Where shaders/spheres_light.frag finds the indices.
constexpr GLuint kIndexUnit = 4;
// Spheres of one draw: their vertices are counted by 16 bits, with up to 32 corners.
constexpr std::uint32_t kDrawSpheres = 2048;

template <class T>
gl::Buffer buffer_of(const std::vector<T>& data, GLbitfield flags = 0) {
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), flags);
}

}  // namespace

Status SphereBatch::upload(const ObjectScene& scene, std::uint32_t first_instance, const ObjectOptions& options,
                           unsigned shadow_kinds) {
  *this = {};
  options_ = options;
  shadow_kinds_ = shadow_kinds;
  for (const SphereSet& set : scene.sphere_sets) {
    if (!set.items.empty()) {
      if (Status s = add(set, first_instance); !s) return s;
    }
    first_instance += static_cast<std::uint32_t>(set.items.size());
  }
  if (sets_.empty()) return Done{};
  elements_ = buffer_of(polygon_elements(corners(), kDrawSpheres));
  array_ = gl::VertexArray::create();
  glVertexArrayElementBuffer(array_.id(), elements_.id());
  return Done{};
}

Status SphereBatch::add(const SphereSet& set, std::uint32_t first_instance) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (set.items.size() * sizeof(glm::vec4) > static_cast<std::size_t>(most)) {
    return Error{ErrorCode::kData,
                 "its " + std::to_string(set.items.size()) + " spheres are more than this OpenGL " +
                     "driver's buffers of " + std::to_string(most >> 20) + " MiB hold; split it into several sets",
                 {},
                 0,
                 "sphere set " + set.name};
  }
  std::vector<glm::dvec3> centers;
  for (const SphereSet::Item& item : set.items) centers.emplace_back(item.center);
  const std::vector<std::uint32_t> order = space_order(centers);
  Set made;
  std::vector<glm::uvec2> colors;
  std::vector<glm::dvec3> sorted;
  std::vector<double> radii;
  for (const std::uint32_t i : order) {
    const SphereSet::Item& item = set.items[i];
    made.data.emplace_back(item.center, item.radius);
    colors.emplace_back(std::bit_cast<std::uint32_t>(item.color), i);
    sorted.push_back(set.origin_m + centers[i]);
    radii.push_back(item.radius);
  }
  made.groups = groups_of(sorted, radii);
  made.spheres = buffer_of(made.data);
  made.colors = buffer_of(colors);
  made.order =
      gl::Buffer::with_data(static_cast<GLsizeiptr>(order.size() * sizeof order[0]), nullptr, GL_DYNAMIC_STORAGE_BIT);
  made.origin_m = set.origin_m;
  made.first_instance = first_instance;
  made.material = set.material;
  spheres_ += made.data.size();
  sets_.push_back(std::move(made));
  return Done{};
}

Result<SphereBatch::Programs*> SphereBatch::programs(const ObjectView& view) {
  for (Programs& made : programs_) {
    if (made.channels == view.channels && made.samples == view.samples) return &made;
  }
  ShaderDefines defines = {{"SAMPLES", std::to_string(view.samples)}, {"CORNERS", std::to_string(corners())}};
  if (options_.rectangle) defines.push_back({"PROXY_RECTANGLE", ""});
  if (options_.texture_space && !options_.rectangle) defines.push_back({"IN_PLANE", ""});
  const auto index_program = [&] {
    auto made = Program::graphics("spheres.vert", "spheres.frag", defines);
    if (!made || options_.rectangle) return made;
    const std::vector<glm::vec3> around = proxy_mesh(Proxy::kRound, corners()).corners;
    for (GLint i = 0; i < corners(); ++i) glProgramUniform2f(made->id(), 3 + i, around[i].x, around[i].y);
    return made;
  };
  auto index = index_program();
  if (!index) return index.error();
  defines.push_back({"NEAR", ""});
  auto index_near = index_program();
  if (!index_near) return index_near.error();
  defines.pop_back();
  if (view.channels) defines.push_back({"CHANNELS", ""});
  if (!view.channels) add_shadows(defines, shadow_kinds_);
  auto light = Program::graphics("sky.vert", "spheres_light.frag", defines);
  if (!light) return light.error();
  programs_.push_back({view.channels, view.samples, std::move(*index), std::move(*index_near), std::move(*light)});
  return &programs_.back();
}

Status SphereBatch::ensure_target(const ObjectView& view) {
  if (target_ && width_ == view.width && height_ == view.height && samples_ == view.samples && depth_ == view.depth) {
    return Done{};
  }
  width_ = view.width, height_ = view.height, samples_ = view.samples, depth_ = view.depth;
  indices_ = gl::Texture::image_2d(GL_R32UI, width_, height_, 1, samples_);
  if (samples_ == 1) {
    // Integers are not filtered, and a texture that asks for it holds nothing.
    glTextureParameteri(indices_.id(), GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(indices_.id(), GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  }
  target_ = gl::Framebuffer::create();
  glNamedFramebufferTexture(target_.id(), GL_COLOR_ATTACHMENT0, indices_.id(), 0);
  glNamedFramebufferTexture(target_.id(), GL_DEPTH_ATTACHMENT, depth_, 0);
  if (glCheckNamedFramebufferStatus(target_.id(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Done{};
  target_ = {};
  return Error{ErrorCode::kContext, "this driver cannot draw the indices of spheres with that many samples"};
}

std::size_t SphereBatch::choose(const Set& set, const ObjectView& view) {
  seen_.clear();
  const ViewAxes axes = view_axes(view.camera);
  const glm::dmat3 in_view = glm::transpose(glm::dmat3(axes.right, axes.up, axes.forward));
  const glm::dvec3 eye = view.camera.position_m;
  const glm::mat3 rows(in_view);
  const glm::vec3 origin = in_view * (set.origin_m - eye);
  std::vector<std::uint32_t> near;
  for (const ObjectGroup* group : visible_groups(set.groups, view)) {
    const glm::vec3 center = in_view * (group->center_m - eye);
    const auto before = static_cast<std::ptrdiff_t>(seen_.size());
    if (!options_.occlusion) {
      for (std::uint32_t i = 0; i < group->count; ++i) seen_.push_back(group->first + i);
    } else if (occlusion_.may_see(center, static_cast<float>(group->radius_m))) {
      occlusion_.add(set.data.data(), group->first, group->count, rows, origin, seen_);
    }
    // A sphere is near within 3 radii of it, or where its centre's depth is at most its radius.
    const auto radius = static_cast<float>(group->radius_m);
    if (glm::length(center) > 4 * radius && center.z > 2 * radius) continue;
    const auto is_near = [&](std::uint32_t i) {
      const glm::vec4& sphere = set.data[i];
      const glm::vec3 c = origin + rows * glm::vec3(sphere);
      return glm::dot(c, c) <= 9 * sphere.w * sphere.w || c.z <= sphere.w;
    };
    const auto end =
        std::stable_partition(seen_.begin() + before, seen_.end(), [&](std::uint32_t i) { return !is_near(i); });
    near.insert(near.end(), end, seen_.end());
    seen_.erase(end, seen_.end());
  }
  const std::size_t far = seen_.size();
  seen_.insert(seen_.end(), near.begin(), near.end());
  return far;
}

// Of seen_. The same elements serve all draws: each begins where the one before ended.
void SphereBatch::draw_indices(const Program& program, std::size_t first, std::size_t count) const {
  if (count == 0) return;
  program.use();
  glUniform1ui(1, static_cast<GLuint>(first));
  std::vector<GLsizei> counts;
  std::vector<GLint> firsts;
  for (std::size_t at = 0; at < count; at += kDrawSpheres) {
    counts.push_back(static_cast<GLsizei>(std::min<std::size_t>(kDrawSpheres, count - at)) * 3 * (corners() - 2));
    firsts.push_back(static_cast<GLint>(at) * corners());
  }
  const std::vector<const void*> offsets(counts.size(), nullptr);
  glMultiDrawElementsBaseVertex(GL_TRIANGLES, counts.data(), GL_UNSIGNED_SHORT, offsets.data(),
                                static_cast<GLsizei>(counts.size()), firsts.data());
}

void SphereBatch::draw_set(const Set& set, const ObjectView& view, const Programs& with) {
  const std::size_t far = choose(set, view);
  if (seen_.empty()) return;
  drawn_ += seen_.size();
  glNamedBufferSubData(set.order.id(), 0, static_cast<GLsizeiptr>(seen_.size() * sizeof seen_[0]), seen_.data());
  const ViewAxes axes = view_axes(view.camera);
  const glm::dvec3 origin = set.origin_m - view.camera.position_m;
  for (const Program* program : {&with.index, &with.index_near, &with.light}) {
    glProgramUniform3d(program->id(), 0, glm::dot(axes.right, origin), glm::dot(axes.up, origin),
                       glm::dot(axes.forward, origin));
  }
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, set.spheres.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, set.colors.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, set.order.id());
  glBindVertexArray(array_.id());

  glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
  const GLuint none[4] = {0, 0, 0, 0};
  glClearBufferuiv(GL_COLOR, 0, none);
  draw_indices(with.index, 0, far);
  draw_indices(with.index_near, far, seen_.size() - far);

  // The light. Depth is written by now.
  glBindFramebuffer(GL_FRAMEBUFFER, view.framebuffer);
  glDisable(GL_DEPTH_TEST);
  with.light.use();
  if (view.channels) {
    glUniform1ui(1, view.first_instance + set.first_instance);
  } else {
    glUniform1ui(2, set.material);
  }
  glBindTextureUnit(kIndexUnit, indices_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glEnable(GL_DEPTH_TEST);
}

Status SphereBatch::draw(const ObjectView& view, std::span<const glm::vec2> sample_places) {
  drawn_ = 0;
  if (sets_.empty()) return Done{};
  const auto with = programs(view);
  if (!with) return with.error();
  if (Status s = ensure_target(view); !s) return s;
  if (view.samples > 1) {
    for (const Program* program : {&(*with)->index, &(*with)->index_near, &(*with)->light}) {
      glProgramUniform2fv(program->id(), 40, view.samples, &sample_places[0].x);
    }
  }
  if (options_.occlusion) occlusion_.begin(view.camera, view.width, view.height);
  for (const Set& set : sets_) draw_set(set, view, **with);
  return Done{};
}

}  // namespace roadgen
