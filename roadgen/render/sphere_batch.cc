#include "roadgen/render/sphere_batch.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>

#include "roadgen/render/object_materials.h"
#include "roadgen/render/object_proxy.h"
#include "roadgen/render/sun_grid.h"

namespace roadgen {
namespace {

// Where shaders/spheres_light.frag finds the indices, and shaders/spheres.glsl what is drawn.
constexpr GLuint kIndexUnit = 4, kPlacesUnit = 9, kLooksUnit = 10;
// Elements of one draw: llvmpipe's memory for the vertices of more comes from the system, and goes back to it, each time.
constexpr std::uint32_t kDrawElements = 1020;
// After so many draws the pixels may begin: llvmpipe keeps what it has set up in memory that comes from the system, too.
constexpr std::size_t kFlushDraws = 12;
// Up to these radii on the screen, in pixels, spheres are drawn by triangles and by squares: what setting up more
// triangles costs is more than the pixels that they spare.
constexpr double kTriangle_px = 5, kSquare_px = 24;

template <class T>
gl::Buffer buffer_of(const std::vector<T>& data, GLbitfield flags = 0) {
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), flags);
}

// What is drawn at the picture's edges stands apart: llvmpipe draws all that it takes at once far slower where it must
// clip any of it.
constexpr std::size_t kLarge = 2, kAtEdge = 3, kNear = 4;

int elements_of(int corners) { return 3 * (corners - 2); }
std::uint32_t spheres_a_draw(int corners) { return kDrawElements / static_cast<std::uint32_t>(elements_of(corners)); }

// Of the polygons of one draw, and of one more: llvmpipe copies those one by one that end with the buffer.
gl::Buffer draw_elements(int corners) { return buffer_of(polygon_elements(corners, spheres_a_draw(corners) + 1)); }

}  // namespace

void SphereBatch::upload(const ObjectScene& scene, std::uint32_t first_instance, const ObjectOptions& options,
                         unsigned shadow_kinds, const gl::Buffer& materials, std::size_t material_bytes) {
  *this = {};
  options_ = options;
  shadow_kinds_ = shadow_kinds;
  for (const SphereSet& set : scene.sphere_sets) {
    if (!set.items.empty()) {
      add(scene, set, first_instance);
      const auto bytes = static_cast<GLsizeiptr>(material_bytes);
      sets_.back().material = gl::Buffer::with_data(bytes, nullptr, 0);
      glCopyNamedBufferSubData(materials.id(), sets_.back().material.id(), static_cast<GLintptr>(set.material) * bytes,
                               0, bytes);
    }
    first_instance += static_cast<std::uint32_t>(set.items.size());
  }
  if (sets_.empty()) return;
  elements_ = {draw_elements(4), draw_elements(corners_of(2))};
  array_ = gl::VertexArray::create();
}

void SphereBatch::add(const ObjectScene& scene, const SphereSet& set, std::uint32_t first_instance) {
  std::vector<glm::dvec3> centers;
  for (const SphereSet::Item& item : set.items) centers.emplace_back(item.center);
  const std::vector<std::uint32_t> order = space_order(centers);
  Set made;
  std::vector<glm::dvec3> sorted;
  std::vector<double> radii;
  for (const std::uint32_t i : order) {
    const SphereSet::Item& item = set.items[i];
    made.data.emplace_back(item.center, item.radius);
    made.looks.emplace_back(std::bit_cast<std::uint32_t>(item.color), i);
    sorted.push_back(set.origin_m + centers[i]);
    radii.push_back(item.radius);
    made.largest_m = std::max(made.largest_m, radii.back());
    made.extent_m = std::max(made.extent_m, glm::length(centers[i]));
  }
  made.groups = groups_of(sorted, radii);
  made.origin_m = set.origin_m;
  made.first_instance = first_instance;
  made.parts = material_parts(scene, set.material);
  spheres_ += made.data.size();
  sets_.push_back(std::move(made));
}

template <class T>
void SphereBatch::FrameBuffer::bind(GLuint unit, GLenum format, const std::vector<T>& data) {
  const auto bytes = static_cast<GLsizeiptr>(data.size() * sizeof(T));
  if (bytes > room) {
    room = bytes + bytes / 2;
    buffer = gl::Buffer::with_data(room, nullptr, GL_DYNAMIC_STORAGE_BIT);
    texels = gl::Texture::create(GL_TEXTURE_BUFFER);
  }
  glNamedBufferSubData(buffer.id(), 0, bytes, data.data());
  // No more than this: what lies behind is of other frames.
  glTextureBufferRange(texels.id(), format, buffer.id(), 0, bytes);
  glBindTextureUnit(unit, texels.id());
}

Result<const SphereBatch::IndexPrograms*> SphereBatch::index_programs(int samples) {
  for (const IndexPrograms& made : index_programs_) {
    if (made.samples == samples) return &made;
  }
  IndexPrograms made{samples, {}, {}, {}};
  const auto compile = [&](Program& program, const char* define) -> Status {
    ShaderDefines defines = {{"SAMPLES", std::to_string(samples)}, {define, ""}};
    if (options_.texture_space) defines.push_back({"IN_PLANE", ""});
    auto compiled = Program::graphics("spheres.vert", "spheres.frag", defines);
    if (!compiled) return compiled.error();
    program = std::move(*compiled);
    return Done{};
  };
  if (Status s = compile(made.far, "FAR"); !s) return s.error();
  if (Status s = compile(made.near, "NEAR"); !s) return s.error();
  if (options_.rectangle) {
    if (Status s = compile(made.rectangle, "PROXY_RECTANGLE"); !s) return s.error();
  }
  index_programs_.push_back(std::move(made));
  return &index_programs_.back();
}

Result<const Program*> SphereBatch::light_program(const ObjectView& view, unsigned parts, bool near) {
  for (const LightProgram& made : light_programs_) {
    if (made.channels == view.channels && made.samples == view.samples && made.near == near &&
        (made.channels || made.parts == parts)) {
      return &made.program;
    }
  }
  ShaderDefines defines = {{"SAMPLES", std::to_string(view.samples)}};
  if (near) defines.push_back({"NEAR", ""});
  if (view.channels) {
    defines.push_back({"CHANNELS", ""});
  } else {
    add_materials(defines, parts);
    add_shadows(defines, shadow_kinds_);
  }
  auto made = Program::graphics("spheres_light.vert", "spheres_light.frag", defines);
  if (!made) return made.error();
  light_programs_.push_back({view.channels, view.samples, parts, near, std::move(*made)});
  return &light_programs_.back().program;
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
  // At most one run a tile.
  const auto tiles = [](int pixels) { return (pixels + Occlusion::kTile_px - 1) / Occlusion::kTile_px; };
  runs_buffer_ = gl::Buffer::with_data(
      static_cast<GLsizeiptr>(tiles(width_)) * tiles(height_) * static_cast<GLsizeiptr>(sizeof(Occlusion::Run)),
      nullptr, GL_DYNAMIC_STORAGE_BIT);
  if (glCheckNamedFramebufferStatus(target_.id(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE) return Done{};
  target_ = {};
  return Error{ErrorCode::kContext, "this driver cannot draw the indices of spheres with that many samples"};
}

void SphereBatch::choose(const Set& set, const ObjectView& view) {
  const ViewAxes axes = view_axes(view.camera);
  const glm::dmat3 in_view = glm::transpose(glm::dmat3(axes.right, axes.up, axes.forward));
  const glm::dvec3 eye = view.camera.position_m;
  const glm::mat3 rows(in_view);
  const glm::vec3 origin = in_view * (set.origin_m - eye);
  for (const ObjectGroup* group : visible_groups(set.groups, view)) {
    const glm::vec3 center = in_view * (group->center_m - eye);
    if (!occlusion_.may_see(center, static_cast<float>(group->radius_m))) continue;
    occlusion_.add(std::span(set.data).subspan(group->first, group->count), group->first, rows, origin,
                   static_cast<float>(set.extent_m));
  }
  for (const Occlusion::Seen& sphere : occlusion_.finish()) {
    auto& list = list_of(static_cast<double>(sphere.image.outside), sphere.near);
    const bool whole = &list > &lists_[1] || occlusion_.within(sphere.image, &list == &lists_[0] ? 2.0f : 1.4143f);
    (whole ? list : lists_[kAtEdge]).push_back(sphere.index);
  }
  runs_ = occlusion_.touched();
}

// All of the groups that may be seen; whether spheres are small and near by what the group can hold.
void SphereBatch::choose_all(const Set& set, const ObjectView& view) {
  const ViewAxes axes = view_axes(view.camera);
  const glm::dvec3 eye = view.camera.position_m;
  const double pixel = 2 * std::tan(view.camera.fov_deg * std::numbers::pi / 360) / view.height;
  for (const ObjectGroup* group : visible_groups(set.groups, view)) {
    const glm::dvec3 center = group->center_m - eye;
    const bool far = glm::length(center) > 4 * group->radius_m &&
                     glm::dot(axes.forward, center) > 2 * (group->radius_m + view.camera.near_m);
    const double front = glm::dot(axes.forward, center) - group->radius_m;
    const double radius_px = far ? set.largest_m / (pixel * (front - set.largest_m)) : kSquare_px + 1;
    for (std::uint32_t i = group->first; i < group->first + group->count; ++i) {
      const glm::vec4& sphere = set.data[i];
      const glm::dvec3 c = set.origin_m - eye + glm::dvec3(sphere);
      const auto radius = static_cast<double>(sphere.w);
      const bool near = !far && (glm::dot(c, c) <= 9 * radius * radius ||
                                 glm::dot(axes.forward, c) <= 1.001 * (radius + view.camera.near_m));
      list_of(radius_px, near).push_back(i);
    }
  }
  runs_ = Occlusion::all_tiles(view.width, view.height);
}

std::vector<std::uint32_t>& SphereBatch::list_of(double radius_px, bool near) {
  if (near) return lists_[kNear];
  if (options_.rectangle || options_.polygon != 0 || !(radius_px <= kSquare_px)) return lists_[kLarge];
  return lists_[radius_px <= kTriangle_px ? 0 : 1];
}

int SphereBatch::corners_of(std::size_t list) const {
  if (list < 2) return list == 0 ? 3 : 4;
  return options_.rectangle ? 4 : options_.polygon == 0 ? 8 : options_.polygon;
}

// The same elements serve all draws: each begins where the one before ended.
void SphereBatch::draw_indices(const Program& program, int corners, std::size_t first, std::size_t count) const {
  if (count == 0) return;
  program.use();
  glUniform1ui(1, static_cast<GLuint>(first));
  if (program.has_uniform("corners[0]")) {
    glUniform1i(2, corners);
    const std::vector<glm::vec3> around = proxy_mesh(Proxy::kPolygon, corners).corners;
    for (std::size_t i = 0; i < around.size(); ++i) glUniform2f(3 + static_cast<GLint>(i), around[i].x, around[i].y);
  }
  if (corners > 3) glVertexArrayElementBuffer(array_.id(), elements_[corners == 4 ? 0 : 1].id());
  const std::size_t most = spheres_a_draw(corners);
  for (std::size_t at = 0; at < count; at += most) {
    const auto spheres = static_cast<GLsizei>(std::min(most, count - at));
    const auto base = static_cast<GLint>(at) * corners;
    if (corners == 3) {
      glDrawArrays(GL_TRIANGLES, base, 3 * spheres);
    } else {
      glDrawRangeElementsBaseVertex(GL_TRIANGLES, 0, static_cast<GLuint>(spheres * corners - 1),
                                    spheres * elements_of(corners), GL_UNSIGNED_SHORT, nullptr, base);
    }
    if ((at / most + 1) % kFlushDraws == 0) glFlush();
  }
}

// In double, so that a sphere 1e5 radii away, magnified, is as exact as a near one.
void SphereBatch::take_places(const Set& set, const ObjectView& view) {
  const ViewAxes axes = view_axes(view.camera);
  const glm::dvec3 from_eye = set.origin_m - view.camera.position_m;
  const glm::dvec3 origin(glm::dot(axes.right, from_eye), glm::dot(axes.up, from_eye),
                          glm::dot(axes.forward, from_eye));
  const double per_pixel = view.height / (2 * std::tan(view.camera.fov_deg * std::numbers::pi / 360));
  const glm::dvec2 middle(0.5 * view.width, 0.5 * view.height);
  places_.clear();
  looks_.clear();
  for (std::size_t list = 0; list < lists_.size(); ++list) {
    for (const std::uint32_t i : lists_[list]) {
      const glm::dvec3 p(set.data[i]);
      const float radius = set.data[i].w;
      const glm::dvec3 c =
          origin + glm::dvec3(glm::dot(axes.right, p), glm::dot(axes.up, p), glm::dot(axes.forward, p));
      if (list == kNear) {
        const glm::dvec3 eye = c * (-1 / static_cast<double>(radius));
        places_.emplace_back(glm::vec3(eye), static_cast<float>(glm::dot(eye, eye) - 1));
        looks_.emplace_back(set.looks[i], std::bit_cast<std::uint32_t>(radius), 0);
      } else {
        places_.emplace_back(glm::vec2(glm::dvec2(c) * (per_pixel / c.z) + middle), c.z, radius);
        looks_.emplace_back(set.looks[i], 0, 0);
      }
    }
  }
}

Status SphereBatch::draw_set(Set& set, const ObjectView& view, const IndexPrograms& index,
                             std::span<const glm::vec2> sample_places) {
  for (auto& list : lists_) list.clear();
  options_.occlusion ? choose(set, view) : choose_all(set, view);
  take_places(set, view);
  if (places_.empty()) return Done{};
  drawn_ += places_.size();
  const auto light = light_program(view, set.parts, !lists_[kNear].empty());
  if (!light) return light.error();
  if (view.samples > 1) {
    for (const Program* program : {&index.far, &index.near, &index.rectangle, *light}) {
      if (program->id() != 0) glProgramUniform2fv(program->id(), 40, view.samples, &sample_places[0].x);
    }
  }
  set.places.bind(kPlacesUnit, GL_RGBA32F, places_);
  set.drawn_looks.bind(kLooksUnit, GL_RGBA32UI, looks_);
  glBindVertexArray(array_.id());

  glBindFramebuffer(GL_FRAMEBUFFER, target_.id());
  const GLuint none[4] = {0, 0, 0, 0};
  glClearBufferuiv(GL_COLOR, 0, none);
  std::size_t first = 0;
  for (std::size_t list = 0; list < lists_.size(); ++list) {
    const Program& program = list == kNear ? index.near : options_.rectangle ? index.rectangle : index.far;
    draw_indices(program, corners_of(list), first, lists_[list].size());
    first += lists_[list].size();
  }
  light_tiles(set, view, **light);
  return Done{};
}

// Where nothing is drawn depth is 0, and the tiles are not in front of it.
void SphereBatch::light_tiles(const Set& set, const ObjectView& view, const Program& light) const {
  glBindFramebuffer(GL_FRAMEBUFFER, view.framebuffer);
  glDepthFunc(GL_LESS);
  glDepthMask(GL_FALSE);
  light.use();
  if (view.channels) glUniform1ui(1, view.first_instance + set.first_instance);
  glBindBufferBase(GL_UNIFORM_BUFFER, 4, set.material.id());
  glUniform2f(3, 2.0f * Occlusion::kTile_px / static_cast<float>(view.width),
              2.0f * Occlusion::kTile_px / static_cast<float>(view.height));
  glBindTextureUnit(kIndexUnit, indices_.id());
  glNamedBufferSubData(runs_buffer_.id(), 0, static_cast<GLsizeiptr>(runs_.size() * sizeof runs_[0]), runs_.data());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 5, runs_buffer_.id());
  glDrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(6 * runs_.size()));
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);
}

Status SphereBatch::draw(const ObjectView& view, std::span<const glm::vec2> sample_places) {
  drawn_ = 0;
  if (sets_.empty()) return Done{};
  const auto index = index_programs(view.samples);
  if (!index) return index.error();
  if (Status s = ensure_target(view); !s) return s;
  float reach_px = 0;
  for (const glm::vec2& place : sample_places) {
    if (view.samples > 1) reach_px = std::max({reach_px, std::abs(place.x), std::abs(place.y)});
  }
  if (options_.occlusion) occlusion_.begin(view.camera, view.width, view.height, reach_px);
  for (Set& set : sets_) {
    if (Status s = draw_set(set, view, **index, sample_places); !s) return s;
  }
  return Done{};
}

}  // namespace roadgen
