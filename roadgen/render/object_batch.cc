#include "roadgen/render/object_batch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include "roadgen/object/quadric_hull.h"
#include "roadgen/render/object_materials.h"
#include "roadgen/render/object_proxy.h"
#include "roadgen/render/object_textures.h"
#include "roadgen/render/sun_grid.h"

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

constexpr GLuint kTextureUnit = 8;  // as shaders/object_light.glsl says

// layer: 1 + that of its texture, 0: none.
MaterialInstance instance(const ObjectMaterial& m, int layer) {
  MaterialInstance i;
  i.base = glm::vec4(m.base_color, m.model == ObjectMaterial::Model::kPhong ? 1.0f : 0.0f);
  i.surface = glm::vec4(m.metallic, m.roughness, m.reflection, m.transmission);
  i.specular = glm::vec4(m.specular, m.shininess);
  i.more = glm::vec4(m.ior, static_cast<float>(layer), 0, 0);
  return i;
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

// Corners of what covers a primitive. Two more for the sides of a cylinder, so that its ends have what a disc has; twice as
// many for a torus, since what its polygons waste is more of the ring than it would be of a disc.
int proxy_sides(PrimitiveKind kind, const ObjectOptions& options) {
  if (kind == PrimitiveKind::kSphere && options.rectangle) return 4;
  const int sides = options.polygon == 0 ? 8 : options.polygon;
  return kind == PrimitiveKind::kCone ? sides + 2 : kind == PrimitiveKind::kTorus ? 2 * sides : sides;
}

// Of hulls of their own: a corner, and whose it is.
struct HullCorner {
  glm::vec3 corner;
  std::uint32_t index;
};
struct HullMeshes {
  std::vector<HullCorner> corners;
  std::vector<std::uint32_t> elements;
  std::vector<std::size_t> starts = {0};  // of each one's elements, and their count

  void add(const Primitive& p) {
    const ConvexHull hull = quadric_hull(p.shape);
    const auto first = static_cast<std::uint32_t>(corners.size()),
               index = static_cast<std::uint32_t>(starts.size() - 1);
    for (const glm::dvec3& corner : hull.corners) corners.push_back({glm::vec3(corner), index});
    for (const auto& triangle : hull.triangles) {
      for (const std::uint16_t i : triangle) elements.push_back(first + i);
    }
    starts.push_back(elements.size());
  }
};

template <class T>
gl::Buffer buffer_of(const std::vector<T>& data, GLbitfield flags = 0) {
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data(), flags);
}

}  // namespace

Status ObjectBatch::check_room(const ObjectScene& scene) {
  GLint most = 0, texels = 0;
  glGetIntegerv(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &most);
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  const std::string buffers = "more than this OpenGL driver's buffers of " + std::to_string(most >> 20) + " MiB hold";
  std::array<std::size_t, 16> counts{};
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const PrimitiveKind kind = primitive(scene.objects[i]).kind;
    if (++counts[static_cast<std::size_t>(kind)] * sizeof(ObjectInstance) <= static_cast<std::size_t>(most)) continue;
    return Error{ErrorCode::kData,
                 std::string("from here on the objects that are drawn as '") + primitive_row(kind).name + "' are " +
                     buffers + "; many spheres are smaller in sets",
                 {},
                 0,
                 "object " + std::to_string(i) + " (" + scene.objects[i].name + ")"};
  }
  for (std::size_t i = 0; i < scene.sphere_sets.size(); ++i) {
    const std::size_t count = scene.sphere_sets[i].items.size();
    if (count * sizeof(glm::vec4) <= static_cast<std::size_t>(most) && count <= static_cast<std::size_t>(texels)) {
      continue;
    }
    return Error{ErrorCode::kData,
                 "its " + std::to_string(count) + " spheres are " + buffers + "; split it into several sets",
                 {},
                 0,
                 "sphere set " + std::to_string(i) + " (" + scene.sphere_sets[i].name + ")"};
  }
  return Done{};
}

Status ObjectBatch::upload(const ObjectScene& scene, const ObjectOptions& options, unsigned shadow_kinds) {
  *this = {};
  options_ = options;
  shadow_kinds_ = shadow_kinds;
  std::array<std::vector<std::uint32_t>, 16> members;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    members[static_cast<std::size_t>(primitive(scene.objects[i]).kind)].push_back(i);
  }
  for (const PrimitiveRow& row : primitive_table()) {
    const auto& of_kind = members[static_cast<std::size_t>(row.kind)];
    if (of_kind.empty()) continue;
    add_kind(row.kind, scene, of_kind);
  }
  if (kinds_.empty() && scene.sphere_sets.empty()) return Done{};
  view_uniforms_ = gl::Buffer::with_data(sizeof(ViewUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT);
  std::vector<MaterialInstance> materials;
  auto textures = load_textures(scene.materials);
  if (!textures) return textures.error();
  textures_ = std::move(textures->layers);
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    materials.push_back(instance(scene.materials[i], textures->layer_of[i]));
  }
  if (materials.empty()) materials.push_back(instance(ObjectMaterial{}, 0));
  materials_ = buffer_of(materials);
  spheres_.upload(scene, static_cast<std::uint32_t>(scene.objects.size()), options, shadow_kinds, materials_,
                  sizeof(MaterialInstance));
  statistics_.spheres = spheres_.spheres();
  return Done{};
}

// Whose corner it is from `indices`, one an instance or one a corner; corners are `stride` bytes apart.
void ObjectBatch::set_arrays(const Kind& kind, const gl::Buffer& indices, GLintptr offset, GLuint divisor,
                             GLsizei stride) {
  const GLuint array = kind.vertex_array.id();
  glVertexArrayElementBuffer(array, kind.elements.id());
  glVertexArrayVertexBuffer(array, 0, indices.id(), offset, divisor == 1 ? sizeof(std::uint32_t) : stride);
  glVertexArrayBindingDivisor(array, 0, divisor);
  glEnableVertexArrayAttrib(array, 0);
  glVertexArrayAttribIFormat(array, 0, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(array, 0, 0);
  glVertexArrayVertexBuffer(array, 1, kind.corners.id(), 0, stride);
  glEnableVertexArrayAttrib(array, 1);
  glVertexArrayAttribFormat(array, 1, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(array, 1, 1);
}

void ObjectBatch::add_kind(PrimitiveKind kind, const ObjectScene& scene, std::span<const std::uint32_t> members) {
  const PrimitiveRow& row = primitive_row(kind);
  std::vector<glm::dvec3> centers;
  for (const std::uint32_t i : members) centers.push_back(primitive(scene.objects[i]).center_m);
  std::vector<ObjectInstance> instances;
  std::vector<glm::dvec3> sorted;
  std::vector<double> radii;
  HullMeshes hulls;
  Kind made;
  made.kind = kind;
  for (const std::uint32_t place : space_order(centers)) {
    const std::uint32_t i = members[place];
    const Primitive p = primitive(scene.objects[i]);
    const double ball = ball_radius(p);
    if (row.proxy == Proxy::kHull) hulls.add(p);
    instances.push_back(instance(p, ball, i, scene.objects[i].material));
    sorted.push_back(p.center_m);
    radii.push_back(ball);
  }
  for (const std::uint32_t i : members) made.materials |= material_parts(scene, scene.objects[i].material);
  made.count = instances.size();
  made.groups = groups_of(sorted, radii);
  made.instances = buffer_of(instances);
  made.vertex_array = gl::VertexArray::create();
  if (row.proxy == Proxy::kHull) {
    made.hull_starts = std::move(hulls.starts);
    made.corners = buffer_of(hulls.corners);
    made.elements = buffer_of(hulls.elements);
    set_arrays(made, made.corners, offsetof(HullCorner, index), 0, sizeof(HullCorner));
  } else {
    const ProxyMesh mesh = proxy_mesh(row.proxy, proxy_sides(kind, options_));
    made.corners = buffer_of(mesh.corners);
    made.elements = buffer_of(mesh.elements);
    made.element_count = static_cast<GLsizei>(mesh.elements.size());
    made.order = gl::Buffer::with_data(static_cast<GLsizeiptr>(instances.size() * sizeof(std::uint32_t)), nullptr,
                                       GL_DYNAMIC_STORAGE_BIT);
    set_arrays(made, made.order, 0, 1, sizeof(glm::vec3));
  }
  statistics_.objects += made.count;
  kinds_.push_back(std::move(made));
}

Result<const Program*> ObjectBatch::program(const Kind& kind, const ObjectView& view) {
  const PrimitiveRow& row = primitive_row(kind.kind);
  const std::string name = row.name;
  const std::string key = name + " " + (view.channels ? "channels" : std::to_string(view.samples));
  if (const auto found = programs_.find(key); found != programs_.end()) return &found->second;
  ShaderDefines defines = {{"NAME_HITS", name + "_hits"},
                           {"NAME_NORMAL", name + "_normal"},
                           {"NAME_UV", name + "_uv"},
                           {"NAME_VALUE", name + "_value"},
                           {"SAMPLES", std::to_string(view.samples)}};
  if (row.at_eye) defines.push_back({"AT_EYE", name + "_at_eye"});
  if (row.flat) defines.push_back({"NAME_INSIDE", name + "_inside"});
  const bool outline = row.proxy == Proxy::kOutline || row.proxy == Proxy::kRing;
  const bool sphere = kind.kind == PrimitiveKind::kSphere, rectangle = sphere && options_.rectangle;
  if (outline) {
    defines.push_back({"NAME_NEAR", name + "_near"});
    defines.push_back({"NAME_OUTLINE", name + "_outline"});
  } else {
    defines.push_back({"NAME_PROXY", name + "_proxy"});
  }
  defines.push_back({rectangle  ? "PROXY_RECTANGLE"
                     : outline  ? "PROXY_OUTLINE"
                     : row.flat ? "PROXY_FLAT"
                                : "PROXY_HULL",
                     ""});
  if (options_.texture_space && (row.flat || (sphere && !rectangle))) defines.push_back({"IN_PLANE", ""});
  if (row.flat || sphere) defines.push_back({"ONE_SURFACE", ""});
  if (view.channels) defines.push_back({"CHANNELS", ""});
  if (!view.channels) {
    add_materials(defines, kind.materials);
    add_shadows(defines, shadow_kinds_);
  }
  auto made = Program::graphics("object.vert", "object.frag", defines);
  if (!made) return made.error();
  return &programs_.emplace(key, std::move(*made)).first->second;
}

void ObjectBatch::draw_kind(const Kind& kind, const ObjectView& view, const Program& program) {
  const std::vector<const ObjectGroup*> groups = visible_groups(kind.groups, view);
  if (groups.empty()) return;
  for (const ObjectGroup* group : groups) statistics_.drawn_objects += group->count;
  program.use();
  glUniform1ui(1, view.first_instance);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, kind.instances.id());
  glBindVertexArray(kind.vertex_array.id());
  const PrimitiveRow& row = primitive_row(kind.kind);
  const bool hull = !row.flat && row.proxy != Proxy::kOutline && row.proxy != Proxy::kRing;
  if (hull) {
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
  }
  if (row.proxy == Proxy::kHull) {
    std::vector<GLsizei> counts;
    std::vector<const void*> offsets;
    for (const ObjectGroup* group : groups) {
      const std::size_t from = kind.hull_starts[group->first], to = kind.hull_starts[group->first + group->count];
      counts.push_back(static_cast<GLsizei>(to - from));
      offsets.push_back(reinterpret_cast<const void*>(from * sizeof(std::uint32_t)));
    }
    glMultiDrawElements(GL_TRIANGLES, counts.data(), GL_UNSIGNED_INT, offsets.data(),
                        static_cast<GLsizei>(counts.size()));
  } else {
    std::vector<std::uint32_t> order;
    for (const ObjectGroup* group : groups) {
      for (std::uint32_t i = 0; i < group->count; ++i) order.push_back(group->first + i);
    }
    glNamedBufferSubData(kind.order.id(), 0, static_cast<GLsizeiptr>(order.size() * sizeof order[0]), order.data());
    glDrawElementsInstanced(GL_TRIANGLES, kind.element_count, GL_UNSIGNED_SHORT, nullptr,
                            static_cast<GLsizei>(order.size()));
  }
  if (hull) glDisable(GL_CULL_FACE);
}

Status ObjectBatch::draw(const ObjectView& view) {
  statistics_.drawn_objects = 0;
  if (empty()) return Done{};
  const ViewAxes axes = view_axes(view.camera);
  const glm::dvec3 eye = view.camera.position_m;
  const double pixel = 2 * std::tan(view.camera.fov_deg * std::numbers::pi / 360) / view.height;
  const ViewUniforms uniforms = {glm::dvec4(axes.right, eye.x), glm::dvec4(axes.up, eye.y),
                                 glm::dvec4(axes.forward, eye.z),
                                 glm::dvec4(0.5 * view.width, 0.5 * view.height, pixel, 1 / pixel)};
  glNamedBufferSubData(view_uniforms_.id(), 0, sizeof uniforms, &uniforms);
  glBindBufferBase(GL_UNIFORM_BUFFER, 1, view_uniforms_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, materials_.id());
  if (textures_) glBindTextureUnit(kTextureUnit, textures_.id());
  std::vector<glm::vec2> samples(static_cast<std::size_t>(view.samples));
  for (GLuint i = 0; view.samples > 1 && i < samples.size(); ++i) {
    glGetMultisamplefv(GL_SAMPLE_POSITION, i, &samples[i].x);
    samples[i] -= glm::vec2(0.5f);
  }
  for (const Kind& kind : kinds_) {
    const auto with = program(kind, view);
    if (!with) return with.error();
    if (view.samples > 1) {
      glProgramUniform1i((*with)->id(), 2, view.samples);
      glProgramUniform2fv((*with)->id(), 3, view.samples, &samples[0].x);
    }
    draw_kind(kind, view, **with);
  }
  const Status status = spheres_.draw(view, samples);
  statistics_.drawn_spheres = spheres_.drawn();
  glBindVertexArray(0);
  return status;
}

}  // namespace roadgen
