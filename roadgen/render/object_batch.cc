#include "roadgen/render/object_batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/object_proxy.h"

namespace roadgen {
namespace {

// The layouts that shaders/objects.glsl declares.
struct ViewUniforms {
  glm::dvec4 right, up, forward, size;
};
struct ObjectInstance {
  glm::dvec4 center;
  glm::dvec4 inverse[3];
  glm::vec4 axes[3];
  glm::vec4 numbers[3];
};
static_assert(sizeof(ObjectInstance) == 224);
struct MaterialInstance {
  glm::vec4 base, surface, specular, more;
};

constexpr std::uint32_t kGroup = 256;  // objects, or spheres

float bits(std::uint32_t x) { return std::bit_cast<float>(x); }

ObjectInstance instance(const Primitive& p, double radius_m, std::uint32_t number, std::uint32_t material) {
  const glm::dmat3 inverse = glm::inverse(p.axes);
  const ObjectLib::ObjectShape& s = p.shape;
  ObjectInstance i;
  i.center = glm::dvec4(p.center_m, radius_m);
  for (int row = 0; row < 3; ++row) {
    i.inverse[row] = glm::dvec4(inverse[0][row], inverse[1][row], inverse[2][row], 0);
    i.axes[row] = glm::vec4(glm::vec3(p.axes[row]), 0);
  }
  i.axes[0].w = bits(number);
  i.axes[1].w = bits(material);
  i.numbers[0] = glm::dvec4(s.p0, s.p1, s.p2, s.p3);
  i.numbers[1] = glm::dvec4(s.p4, s.p5, s.p6, s.p7);
  i.numbers[2] = glm::dvec4(s.p8, s.p9, s.flags, 0);
  return i;
}

MaterialInstance instance(const ObjectMaterial& m) {
  MaterialInstance i;
  i.base = glm::vec4(m.base_color, m.model == ObjectMaterial::Model::kPhong ? 1.0f : 0.0f);
  i.surface = glm::vec4(m.metallic, m.roughness, m.reflection, m.transmission);
  i.specular = glm::vec4(m.specular, m.shininess);
  i.more = glm::vec4(m.ior, 0, 0, 0);
  return i;
}

// Every third bit of 21.
std::uint64_t spread(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

// An order in which neighbours in the list are neighbours in space (Morton's).
std::vector<std::uint32_t> space_order(std::span<const glm::dvec3> centers) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const glm::dvec3& c : centers) low = glm::min(low, c), high = glm::max(high, c);
  const glm::dvec3 size = glm::max(high - low, glm::dvec3(1e-30));
  const double scale = 2097151 / std::max({size.x, size.y, size.z});
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(centers.size());
  for (std::uint32_t i = 0; i < centers.size(); ++i) {
    const glm::dvec3 at = (centers[i] - low) * scale;
    keys[i] = {spread(static_cast<std::uint64_t>(at.x)) | spread(static_cast<std::uint64_t>(at.y)) << 1 |
                   spread(static_cast<std::uint64_t>(at.z)) << 2,
               i};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(centers.size());
  std::transform(keys.begin(), keys.end(), order.begin(), [](const auto& k) { return k.second; });
  return order;
}

// A ball around balls.
std::pair<glm::dvec3, double> around(std::span<const glm::dvec3> centers, std::span<const double> radii) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (std::size_t i = 0; i < centers.size(); ++i) {
    low = glm::min(low, centers[i] - radii[i]);
    high = glm::max(high, centers[i] + radii[i]);
  }
  const glm::dvec3 middle = 0.5 * (low + high);
  double radius = 0;
  for (std::size_t i = 0; i < centers.size(); ++i) {
    radius = std::max(radius, glm::length(centers[i] - middle) + radii[i]);
  }
  return {middle, radius};
}

// Of a ball around the primitive's centre. Exact for a sphere and for an ellipsoid whose axes are perpendicular: the
// square of the greatest singular value is at most the greatest sum of a row of A^T A.
double ball_radius(const Primitive& p) {
  if (p.kind == PrimitiveKind::kSphere) {
    const glm::dmat3 m = glm::transpose(p.axes) * p.axes;
    double greatest = 0;
    for (int i = 0; i < 3; ++i) greatest = std::max(greatest, std::abs(m[i].x) + std::abs(m[i].y) + std::abs(m[i].z));
    return std::sqrt(greatest);
  }
  const ObjectBounds box = bounds(p);
  return glm::length(glm::max(box.high_m - p.center_m, p.center_m - box.low_m));
}

template <class T>
gl::Buffer buffer_of(const std::vector<T>& data, GLbitfield flags = 0) {
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), flags);
}

Status check_fits(std::size_t bytes) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  if (bytes <= static_cast<std::size_t>(most)) return Done{};
  return Error{ErrorCode::kData, "the objects of one kind take " + std::to_string(bytes >> 20) +
                                     " MiB, more than this OpenGL driver's buffers of " + std::to_string(most >> 20) +
                                     " MiB; split them into several sets"};
}

}  // namespace

Status ObjectBatch::upload(const ObjectScene& scene, const ObjectOptions& options) {
  *this = {};
  options_ = options;
  std::array<std::vector<std::uint32_t>, 16> members;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    members[static_cast<std::size_t>(primitive(scene.objects[i]).kind)].push_back(i);
  }
  for (const PrimitiveRow& row : primitive_table()) {
    const auto& of_kind = members[static_cast<std::size_t>(row.kind)];
    if (of_kind.empty()) continue;
    if (Status s = add_kind(row.kind, scene, of_kind); !s) return s;
  }
  std::uint32_t first = static_cast<std::uint32_t>(scene.objects.size());
  for (const SphereSet& set : scene.sphere_sets) {
    if (!set.items.empty()) {
      if (Status s = add_set(set, first); !s) return s;
    }
    first += static_cast<std::uint32_t>(set.items.size());
  }
  if (empty()) return Done{};
  view_uniforms_ = gl::Buffer::with_data(sizeof(ViewUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT);
  std::vector<MaterialInstance> materials;
  for (const ObjectMaterial& material : scene.materials) materials.push_back(instance(material));
  if (materials.empty()) materials.push_back(instance(ObjectMaterial{}));
  materials_ = buffer_of(materials);
  if (!sets_.empty()) {
    const int corners = options_.rectangle ? 4 : options_.polygon;
    sphere_elements_ = buffer_of(polygon_elements(corners, kGroup));
    sphere_array_ = gl::VertexArray::create();
    glVertexArrayElementBuffer(sphere_array_.id(), sphere_elements_.id());
  }
  return Done{};
}

Status ObjectBatch::add_kind(PrimitiveKind kind, const ObjectScene& scene, std::span<const std::uint32_t> members) {
  const PrimitiveRow& row = primitive_row(kind);
  if (Status s = check_fits(members.size() * sizeof(ObjectInstance)); !s) return s;
  std::vector<glm::dvec3> centers;
  for (const std::uint32_t i : members) centers.push_back(primitive(scene.objects[i]).center_m);
  std::vector<ObjectInstance> instances;
  std::vector<glm::dvec3> sorted;
  std::vector<double> radii;
  for (const std::uint32_t place : space_order(centers)) {
    const std::uint32_t i = members[place];
    const Primitive p = primitive(scene.objects[i]);
    const double ball = ball_radius(p);
    instances.push_back(instance(p, ball, i, scene.objects[i].material));
    sorted.push_back(p.center_m);
    radii.push_back(ball);
  }
  Kind made;
  made.kind = kind;
  made.count = instances.size();
  for (std::uint32_t first = 0; first < instances.size(); first += kGroup) {
    const std::size_t count = std::min<std::size_t>(kGroup, instances.size() - first);
    const auto [center, radius] =
        around(std::span(sorted).subspan(first, count), std::span(radii).subspan(first, count));
    made.groups.push_back({center, radius, first, static_cast<std::uint32_t>(count)});
  }
  made.instances = buffer_of(instances);
  made.order = gl::Buffer::with_data(static_cast<GLsizeiptr>(instances.size() * sizeof(std::uint32_t)), nullptr,
                                     GL_DYNAMIC_STORAGE_BIT);
  const ProxyMesh mesh = proxy_mesh(row.proxy, options_.rectangle ? 4 : options_.polygon);
  made.corners = buffer_of(mesh.corners);
  made.elements = buffer_of(mesh.elements);
  made.element_count = static_cast<GLsizei>(mesh.elements.size());
  made.vertex_array = gl::VertexArray::create();
  const GLuint array = made.vertex_array.id();
  glVertexArrayElementBuffer(array, made.elements.id());
  glVertexArrayVertexBuffer(array, 0, made.order.id(), 0, sizeof(std::uint32_t));
  glVertexArrayBindingDivisor(array, 0, 1);
  glEnableVertexArrayAttrib(array, 0);
  glVertexArrayAttribIFormat(array, 0, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(array, 0, 0);
  glVertexArrayVertexBuffer(array, 1, made.corners.id(), 0, sizeof(glm::vec3));
  glEnableVertexArrayAttrib(array, 1);
  glVertexArrayAttribFormat(array, 1, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(array, 1, 1);
  statistics_.objects += made.count;
  kinds_.push_back(std::move(made));
  return Done{};
}

Status ObjectBatch::add_set(const SphereSet& set, std::uint32_t first_instance) {
  if (Status s = check_fits(set.items.size() * sizeof(glm::vec4)); !s) return s;
  std::vector<glm::dvec3> centers;
  for (const SphereSet::Item& item : set.items) centers.emplace_back(item.center);
  const std::vector<std::uint32_t> order = space_order(centers);
  std::vector<glm::vec4> spheres;
  std::vector<glm::uvec2> colors;
  std::vector<glm::dvec3> sorted;
  std::vector<double> radii;
  for (const std::uint32_t i : order) {
    const SphereSet::Item& item = set.items[i];
    spheres.emplace_back(item.center, item.radius);
    colors.emplace_back(std::bit_cast<std::uint32_t>(item.color), i);
    sorted.push_back(centers[i]);
    radii.push_back(item.radius);
  }
  Set made;
  for (std::uint32_t first = 0; first < spheres.size(); first += kGroup) {
    const std::size_t count = std::min<std::size_t>(kGroup, spheres.size() - first);
    const auto [center, radius] =
        around(std::span(sorted).subspan(first, count), std::span(radii).subspan(first, count));
    made.groups.push_back({set.origin_m + center, radius, first, static_cast<std::uint32_t>(count)});
  }
  made.spheres = buffer_of(spheres);
  made.colors = buffer_of(colors);
  made.origin_m = set.origin_m;
  made.first_instance = first_instance;
  made.material = set.material;
  made.count = spheres.size();
  statistics_.spheres += made.count;
  sets_.push_back(std::move(made));
  return Done{};
}

Result<const Program*> ObjectBatch::program(const PrimitiveRow& row, bool spheres, const ObjectView& view) {
  const std::string name = row.name;
  const std::string key =
      name + (spheres ? " set " : " ") + (view.channels ? "channels" : std::to_string(view.samples));
  if (const auto found = programs_.find(key); found != programs_.end()) return &found->second;
  ShaderDefines defines = {{"NAME_HITS", name + "_hits"},   {"NAME_NORMAL", name + "_normal"},
                           {"NAME_UV", name + "_uv"},       {"NAME_VALUE", name + "_value"},
                           {"NAME_PROXY", name + "_proxy"}, {"SAMPLES", std::to_string(view.samples)}};
  if (row.at_eye) defines.push_back({"AT_EYE", name + "_at_eye"});
  if (row.flat) defines.push_back({"NAME_INSIDE", name + "_inside"});
  const bool round = row.proxy == Proxy::kRound;
  defines.push_back(
      {round ? (options_.rectangle ? "PROXY_RECTANGLE" : "PROXY_ROUND") : (row.flat ? "PROXY_FLAT" : "PROXY_HULL"),
       ""});
  if (options_.texture_space && (row.flat || (round && !options_.rectangle))) defines.push_back({"IN_PLANE", ""});
  if (view.channels) defines.push_back({"CHANNELS", ""});
  if (spheres) {
    defines.push_back({"SPHERES", ""});
    defines.push_back({"CORNERS", std::to_string(options_.rectangle ? 4 : options_.polygon)});
  }
  auto made = Program::graphics("object.vert", "object.frag", defines);
  if (!made) return made.error();
  return &programs_.emplace(key, std::move(*made)).first->second;
}

std::vector<const ObjectBatch::Group*> ObjectBatch::visible(std::span<const Group> groups,
                                                            const ObjectView& view) const {
  const Frustum frustum(view.camera, static_cast<double>(view.width) / view.height);
  std::vector<std::pair<double, const Group*>> seen;
  for (const Group& group : groups) {
    const glm::dvec3 from_eye = group.center_m - view.camera.position_m;
    if (frustum.may_see(from_eye, group.radius_m)) seen.emplace_back(glm::length(from_eye) - group.radius_m, &group);
  }
  std::sort(seen.begin(), seen.end());
  std::vector<const Group*> sorted(seen.size());
  std::transform(seen.begin(), seen.end(), sorted.begin(), [](const auto& s) { return s.second; });
  return sorted;
}

void ObjectBatch::draw_kind(const Kind& kind, const ObjectView& view, const Program& program) {
  std::vector<std::uint32_t> order;
  for (const Group* group : visible(kind.groups, view)) {
    for (std::uint32_t i = 0; i < group->count; ++i) order.push_back(group->first + i);
  }
  if (order.empty()) return;
  statistics_.drawn_objects += order.size();
  glNamedBufferSubData(kind.order.id(), 0, static_cast<GLsizeiptr>(order.size() * sizeof order[0]), order.data());
  program.use();
  glUniform1ui(1, view.first_instance);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, kind.instances.id());
  glBindVertexArray(kind.vertex_array.id());
  const PrimitiveRow& row = primitive_row(kind.kind);
  const bool hull = !row.flat && row.proxy != Proxy::kRound;
  if (hull) {
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
  }
  glDrawElementsInstanced(GL_TRIANGLES, kind.element_count, GL_UNSIGNED_SHORT, nullptr,
                          static_cast<GLsizei>(order.size()));
  if (hull) glDisable(GL_CULL_FACE);
}

void ObjectBatch::draw_set(const Set& set, const ObjectView& view, const Program& program) {
  const int corners = options_.rectangle ? 4 : options_.polygon;
  std::vector<GLsizei> counts;
  std::vector<GLint> firsts;
  for (const Group* group : visible(set.groups, view)) {
    counts.push_back(static_cast<GLsizei>(group->count) * 3 * (corners - 2));
    firsts.push_back(static_cast<GLint>(group->first) * corners);
    statistics_.drawn_spheres += group->count;
  }
  if (counts.empty()) return;
  const ViewAxes axes = view_axes(view.camera);
  const glm::dvec3 origin = set.origin_m - view.camera.position_m;
  program.use();
  glUniform3d(0, glm::dot(axes.right, origin), glm::dot(axes.up, origin), glm::dot(axes.forward, origin));
  glUniform1ui(1, view.first_instance + set.first_instance);
  if (!view.channels) glUniform1ui(2, set.material);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, set.spheres.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, set.colors.id());
  glBindVertexArray(sphere_array_.id());
  const std::vector<const void*> offsets(counts.size(), nullptr);
  glMultiDrawElementsBaseVertex(GL_TRIANGLES, counts.data(), GL_UNSIGNED_SHORT, offsets.data(),
                                static_cast<GLsizei>(counts.size()), firsts.data());
}

Status ObjectBatch::draw(const ObjectView& view) {
  statistics_.drawn_objects = statistics_.drawn_spheres = 0;
  if (empty()) return Done{};
  const ViewAxes axes = view_axes(view.camera);
  const glm::dvec3 eye = view.camera.position_m;
  const double pixel = 2 * std::tan(view.camera.fov_deg * std::numbers::pi / 360) / view.height;
  const ViewUniforms uniforms = {glm::dvec4(axes.right, eye.x), glm::dvec4(axes.up, eye.y),
                                 glm::dvec4(axes.forward, eye.z),
                                 glm::dvec4(0.5 * view.width, 0.5 * view.height, pixel, view.camera.near_m)};
  glNamedBufferSubData(view_uniforms_.id(), 0, sizeof uniforms, &uniforms);
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, view_uniforms_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, materials_.id());
  std::vector<glm::vec2> samples(static_cast<std::size_t>(view.samples));
  for (GLuint i = 0; view.samples > 1 && i < samples.size(); ++i) {
    glGetMultisamplefv(GL_SAMPLE_POSITION, i, &samples[i].x);
    samples[i] -= glm::vec2(0.5f);
  }
  const auto prepare = [&](const PrimitiveRow& row, bool spheres) {
    auto made = program(row, spheres, view);
    if (made && view.samples > 1) {
      glProgramUniform2fv((*made)->id(), 3, view.samples, &samples[0].x);
    }
    return made;
  };
  for (const Kind& kind : kinds_) {
    const auto with = prepare(primitive_row(kind.kind), false);
    if (!with) return with.error();
    draw_kind(kind, view, **with);
  }
  for (const Set& set : sets_) {
    const auto with = prepare(primitive_row(PrimitiveKind::kSphere), true);
    if (!with) return with.error();
    draw_set(set, view, **with);
  }
  glBindVertexArray(0);
  return Done{};
}

}  // namespace roadgen
