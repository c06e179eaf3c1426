#include "roadgen/render/sweep_batch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "roadgen/render/road_instance.h"
#include "roadgen/road/sweep_piece.h"

namespace roadgen {
namespace {

// The layout that shaders/sweep.glsl declares.
struct SweepInstance {
  glm::vec4 start_high, start_low, shape, arc, axis, place, box, profile, bends, kinds, posts, post, albedo, ends;
};
static_assert(sizeof(SweepInstance) == 224);

SweepInstance instance(const Road& road, std::size_t road_index, const SweepPart& part) {
  const Segment& segment = road.segments[part.segment];
  const Lib::SweepPiece& p = part.piece;
  const Lib::SweepPath& r = p.path;
  const SplitPosition start = split({segment.start_m, segment.elevation_m.c0});
  const bool concrete = road.sweeps[part.sweep].kind() == SweepKind::kTunnel;
  const auto& q = p.profile;
  SweepInstance i;
  i.start_high = glm::vec4(start.high, static_cast<float>(road_index));
  i.start_low = glm::vec4(start.low, static_cast<float>(part.s_from_m));
  i.shape = glm::dvec4(segment.chord_m(), r.a, r.b);
  i.arc = glm::dvec4(r.arc, r.c0, r.c1, part.lamp_spacing_m);
  i.axis = glm::dvec4(r.z0, r.z1, r.z2, r.z3);
  i.place = glm::dvec4(r.n0, r.n1, p.u0, p.u1);
  i.box = glm::dvec4(p.y0, p.y1, p.z0, p.z1);
  i.profile = glm::dvec4(q.p0, q.p1, q.p2, q.p3);
  i.bends = glm::dvec4(q.p4, q.p5, r.bend_n, r.bend_h);
  i.kinds = glm::dvec4(r.bend_s, q.kind, part.s_left_m, std::fmod(segment.s_start_m, kNoisePeriod_m));
  i.posts = glm::dvec4(p.posts.first, p.posts.spacing, p.posts.count, p.posts.half_s);
  i.post = glm::dvec4(p.posts.half_n, p.posts.n, p.posts.low, p.posts.high);
  i.albedo = glm::vec4(glm::vec3(part.albedo), concrete ? 0.0f : 1.0f);
  i.ends = glm::dvec4(p.end0, p.end1, 0, 0);
  return i;
}

}  // namespace

void SweepBatch::upload(const Network& network) {
  std::vector<SweepInstance> data;
  balls_.clear();
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    const Road& road = network.roads[i];
    for (std::size_t k = 0; k < road.sweeps.size(); ++k) {
      for (const SweepPart& part : sweep_parts(road, k)) {
        data.push_back(instance(road, i, part));
        const Segment& segment = road.segments[part.segment];
        const Lib::SweepPiece& p = part.piece;
        const double chord = segment.chord_length_m(), y = 0.5 * (p.y0 + p.y1), z = 0.5 * (p.z0 + p.z1);
        const glm::dvec2 middle = from_chord(segment, {0.5 * (p.u0 + p.u1), y / chord});
        // The ends lean from the box by the slopes.
        const double half_y = 0.5 * (p.y1 - p.y0);
        const double steep = std::max(std::abs(segment.slope_start), std::abs(segment.slope_end)) * 4 / 3;
        const double half_x = 0.5 * (p.u1 - p.u0) * chord + steep * (half_y + std::abs(y)) + steep * steep * chord;
        balls_.push_back(
            {{middle, segment.elevation_m.c0 + z}, glm::length(glm::dvec3(half_x, half_y, 0.5 * (p.z1 - p.z0))) + 0.5});
      }
    }
  }
  if (data.empty()) return;
  instances_ = gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof data[0]), data.data());
  order_ = gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(std::uint32_t)), nullptr,
                                 GL_DYNAMIC_STORAGE_BIT);
  vertex_array_ = gl::VertexArray::create();
  bind_strips(vertex_array_, elements_);
  glVertexArrayVertexBuffer(vertex_array_.id(), 0, order_.id(), 0, sizeof(std::uint32_t));
  glVertexArrayBindingDivisor(vertex_array_.id(), 0, 1);
  glEnableVertexArrayAttrib(vertex_array_.id(), 0);
  glVertexArrayAttribIFormat(vertex_array_.id(), 0, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(vertex_array_.id(), 0, 0);
}

void SweepBatch::draw(const Program& program, glm::dvec3 eye_m,
                      const std::function<bool(glm::dvec3, double)>& may_see) {
  std::vector<std::pair<double, std::uint32_t>> seen;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const glm::dvec3 center = balls_[i].center_m - eye_m;
    if (may_see(center, balls_[i].radius_m)) seen.emplace_back(glm::length(center), static_cast<std::uint32_t>(i));
  }
  if (seen.empty()) return;
  std::sort(seen.rbegin(), seen.rend());
  std::vector<std::uint32_t> order(seen.size());
  std::transform(seen.begin(), seen.end(), order.begin(), [](const auto& s) { return s.second; });
  glNamedBufferSubData(order_.id(), 0, static_cast<GLsizeiptr>(order.size() * sizeof order[0]), order.data());
  // Back faces only: one ray per pixel, also with the eye inside the box.
  glEnable(GL_CULL_FACE);
  glCullFace(GL_FRONT);
  program.use();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, instances_.id());
  glBindVertexArray(vertex_array_.id());
  draw_boxes(static_cast<GLsizei>(order.size()));
  glBindVertexArray(0);
  glDisable(GL_CULL_FACE);
}

}  // namespace roadgen
