#include "roadgen/render/sun_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

#include "roadgen/object/primitive.h"
#include "roadgen/render/sun_shape.h"

namespace roadgen {
namespace {

constexpr int kRays = 16;
struct GridUniforms {
  glm::vec4 across, along, eye;
  glm::ivec4 grid;
  std::array<glm::vec4, kRays> rays;
};
// As shaders/shadows.glsl has it: the bits of SUN_KINDS, and the tangent of the sun's radius.
constexpr unsigned kSpheres = 1, kQuadrics = 2, kTori = 4;
constexpr double kDisc = 0.00465;

// Even over two discs, by angles of which neither follows the other.
std::array<glm::vec4, kRays> disc_rays() {
  std::array<glm::vec4, kRays> rays;
  for (int i = 0; i < kRays; ++i) {
    const double turn = 2.39996323 * i, out = std::sqrt((i + 0.5) / kRays);
    rays[static_cast<std::size_t>(i)] = glm::dvec4(out * std::cos(turn), out * std::sin(turn),
                                                   kDisc * out * std::cos(2 * turn), kDisc * out * std::sin(2 * turn));
  }
  return rays;
}

constexpr GLuint kFirstUnit = 11;  // of the three that shaders/shadows.glsl reads
constexpr std::uint32_t kSphere = 0x80000000u;
// Cells for each object, and how many there are at most; entries of all lists at most.
constexpr std::size_t kCellsAnObject = 32, kMostCells = std::size_t{1} << 22, kMostEntries = std::size_t{1} << 25;
// Of a cell, by which objects reach farther: pixels and penumbras spread by as much.
constexpr double kMargin = 0.25;

Status check_fits(std::size_t texels) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (texels <= static_cast<std::size_t>(most)) return Done{};
  return Error{ErrorCode::kData, "the shadows of the objects take " + std::to_string(texels) +
                                     " texels, more than this OpenGL driver's buffers of " + std::to_string(most) +
                                     "; draw the objects without shadows"};
}

// A buffer that is never empty.
template <class T>
gl::Buffer buffer_of(const std::vector<T>& data) {
  static constexpr T kNone{};
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(std::max<std::size_t>(data.size(), 1) * sizeof(T)),
                               data.empty() ? &kNone : data.data());
}

}  // namespace

Status SunGrid::upload(const ObjectScene& scene) {
  *this = {};
  const auto transmission = [&](std::uint32_t material) {
    return scene.materials.empty() ? 0.0f : scene.materials[material].transmission;
  };
  std::size_t spheres = 0;
  for (const SphereSet& set : scene.sphere_sets) spheres += transmission(set.material) > 0.5f ? 0 : set.items.size();
  if (Status s = check_fits(std::max(7 * scene.objects.size(), spheres)); !s) return s;
  // The middle of all that casts shadows.
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  const auto include = [&](glm::dvec3 a, glm::dvec3 b) { low = glm::min(low, a), high = glm::max(high, b); };
  std::vector<Primitive> primitives;
  std::vector<ObjectBounds> all_bounds;
  for (const Object& object : scene.objects) {
    primitives.push_back(primitive(object));
    all_bounds.push_back(bounds(primitives.back()));
    include(all_bounds.back().low_m, all_bounds.back().high_m);
  }
  for (const SphereSet& set : scene.sphere_sets) {
    if (transmission(set.material) > 0.5f) continue;
    for (const SphereSet::Item& item : set.items) {
      const glm::dvec3 center = set.origin_m + glm::dvec3(item.center);
      include(center - static_cast<double>(item.radius), center + static_cast<double>(item.radius));
    }
  }
  if (!(low.x <= high.x)) return Done{};
  origin_m_ = 0.5 * (low + high);

  std::vector<glm::vec4> rows;
  rows.reserve(7 * primitives.size());
  for (std::size_t i = 0; i < primitives.size(); ++i) {
    const SunShape p = sun_shape(primitives[i]);
    const glm::dmat3 inverse = glm::transpose(glm::inverse(p.axes));
    const glm::dvec3 reach = glm::max(all_bounds[i].high_m - p.center_m, p.center_m - all_bounds[i].low_m);
    const ObjectLib::ObjectShape& s = p.shape;
    const double opacity = 1 - static_cast<double>(transmission(scene.objects[i].material));
    rows.emplace_back(glm::dvec4(p.center_m - origin_m_, glm::length(reach)));
    rows.emplace_back(glm::dvec4(inverse[0], p.torus ? 1 : 0));
    rows.emplace_back(glm::dvec4(inverse[1], opacity));
    rows.emplace_back(glm::dvec4(inverse[2], 0));
    rows.emplace_back(glm::dvec4(s.p0, s.p1, s.p2, s.p3));
    rows.emplace_back(glm::dvec4(s.p4, s.p5, s.p6, s.p7));
    rows.emplace_back(glm::dvec4(s.p8, s.p9, s.flags, 0));
    boxes_.push_back({glm::vec3(all_bounds[i].low_m - origin_m_), glm::vec3(all_bounds[i].high_m - origin_m_)});
  }
  for (const SphereSet& set : scene.sphere_sets) {
    if (transmission(set.material) > 0.5f) continue;
    for (const SphereSet::Item& item : set.items) {
      spheres_.emplace_back(glm::vec3(set.origin_m - origin_m_ + glm::dvec3(item.center)), item.radius);
    }
  }
  objects_ = buffer_of(rows);
  sphere_buffer_ = buffer_of(spheres_);
  object_texels_ = gl::Texture::of_buffer(GL_RGBA32F, objects_);
  sphere_texels_ = gl::Texture::of_buffer(GL_RGBA32F, sphere_buffer_);
  for (const Primitive& p : primitives) kinds_ |= p.kind == PrimitiveKind::kTorus ? kTori : kQuadrics;
  if (!spheres_.empty()) kinds_ |= kSpheres;
  uniforms_ = gl::Buffer::with_data(sizeof(GridUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT);
  return Done{};
}

SunGrid::Box SunGrid::box_of(std::size_t number) const {
  if (number < boxes_.size()) return boxes_[number];
  const glm::vec4& sphere = spheres_[number - boxes_.size()];
  return {glm::vec3(sphere) - sphere.w, glm::vec3(sphere) + sphere.w};
}

SunGrid::Range SunGrid::cells_of(const Box& box) const {
  const glm::dvec3 middle = 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
  const glm::dvec3 half = 0.5 * (glm::dvec3(box.high) - glm::dvec3(box.low));
  const auto span = [&](glm::dvec3 axis, double corner, int count) {
    const double at = (glm::dot(axis, middle) - corner) / cell_m_;
    const double reach = glm::dot(glm::abs(axis), half) / cell_m_ + kMargin;
    const auto clamped = [&](double x) { return static_cast<int>(std::clamp(std::floor(x), 0.0, count - 1.0)); };
    return glm::ivec2(clamped(at - reach), clamped(at + reach));
  };
  const glm::ivec2 x = span(across_, corner_m_.x, columns_), y = span(along_, corner_m_.y, rows_);
  return {x.x, x.y, y.x, y.y};
}

Status SunGrid::sort(glm::dvec3 toward_sun) {
  toward_sun_ = toward_sun;
  across_ = glm::normalize(std::abs(toward_sun.z) < 0.999 ? glm::cross(glm::dvec3(0, 0, 1), toward_sun)
                                                          : glm::cross(glm::dvec3(0, 1, 0), toward_sun));
  along_ = glm::cross(toward_sun, across_);
  const std::size_t count = boxes_.size() + spheres_.size();
  glm::dvec2 low(std::numeric_limits<double>::max()), high(-low);
  for (std::size_t i = 0; i < count; ++i) {
    const Box box = box_of(i);
    const glm::dvec3 middle = 0.5 * (glm::dvec3(box.low) + glm::dvec3(box.high));
    const glm::dvec3 half = 0.5 * (glm::dvec3(box.high) - glm::dvec3(box.low));
    const glm::dvec2 at(glm::dot(across_, middle), glm::dot(along_, middle));
    const glm::dvec2 reach(glm::dot(glm::abs(across_), half), glm::dot(glm::abs(along_), half));
    low = glm::min(low, at - reach);
    high = glm::max(high, at + reach);
  }
  const glm::dvec2 size = glm::max(high - low, glm::dvec2(1e-6));
  std::size_t wanted = std::clamp<std::size_t>(kCellsAnObject * count, 256, kMostCells);
  // Fewer cells where objects are so large that their lists would not fit.
  std::vector<std::uint32_t> cells;
  for (;; wanted /= 4) {
    cell_m_ = std::max(std::sqrt(size.x * size.y / static_cast<double>(wanted)),
                       std::max(size.x, size.y) / static_cast<double>(std::min<std::size_t>(wanted, 8192)));
    columns_ = static_cast<int>(std::ceil(size.x / cell_m_ + 2 * kMargin));
    rows_ = static_cast<int>(std::ceil(size.y / cell_m_ + 2 * kMargin));
    corner_m_ = low - kMargin * cell_m_;
    const std::size_t cell_count = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    // How long each cell's list is, then where it begins.
    cells.assign(cell_count + 1, 0);
    std::size_t entries = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Range r = cells_of(box_of(i));
      entries += static_cast<std::size_t>(r.right - r.left + 1) * static_cast<std::size_t>(r.top - r.bottom + 1);
      if (entries > kMostEntries) break;
      for (int y = r.bottom; y <= r.top; ++y) {
        for (int x = r.left; x <= r.right; ++x) ++cells[static_cast<std::size_t>(y * columns_ + x) + 1];
      }
    }
    if (entries > kMostEntries && cell_count > 4) continue;
    cells[0] = static_cast<std::uint32_t>(cell_count + 1);
    for (std::size_t i = 1; i <= cell_count; ++i) cells[i] += cells[i - 1];
    std::vector<std::uint32_t> next(cells.begin(), cells.end() - 1);
    cells.resize(cell_count + 1 + entries);
    for (std::size_t i = 0; i < count; ++i) {
      const Range r = cells_of(box_of(i));
      const auto entry = static_cast<std::uint32_t>(i < boxes_.size() ? i : (i - boxes_.size()) | kSphere);
      for (int y = r.bottom; y <= r.top; ++y) {
        for (int x = r.left; x <= r.right; ++x) cells[next[static_cast<std::size_t>(y * columns_ + x)]++] = entry;
      }
    }
    break;
  }
  if (Status s = check_fits(cells.size()); !s) return s;
  cells_ = buffer_of(cells);
  cell_texels_ = gl::Texture::of_buffer(GL_R32UI, cells_);
  return Done{};
}

Status SunGrid::bind(glm::dvec3 toward_sun, glm::dvec3 eye_m) {
  if (!cells_ || toward_sun_ != toward_sun) {
    if (Status s = sort(toward_sun); !s) return s;
  }
  const glm::dvec3 eye = eye_m - origin_m_;
  const GridUniforms u = {glm::dvec4(across_, glm::dot(across_, eye) - corner_m_.x),
                          glm::dvec4(along_, glm::dot(along_, eye) - corner_m_.y), glm::dvec4(eye, 1 / cell_m_),
                          glm::ivec4(columns_, rows_, 0, 0), disc_rays()};
  glNamedBufferSubData(uniforms_.id(), 0, sizeof u, &u);
  glBindBufferBase(GL_UNIFORM_BUFFER, 3, uniforms_.id());
  glBindTextureUnit(kFirstUnit, cell_texels_.id());
  glBindTextureUnit(kFirstUnit + 1, object_texels_.id());
  glBindTextureUnit(kFirstUnit + 2, sphere_texels_.id());
  return Done{};
}

}  // namespace roadgen
