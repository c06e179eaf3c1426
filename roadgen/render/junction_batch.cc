#include "roadgen/render/junction_batch.h"

#include <cmath>
#include <vector>

#include <glm/vec4.hpp>

#include "roadgen/render/road_instance.h"

namespace roadgen {
namespace {

// The layout that shaders/junctions.glsl declares.
struct Header {
  glm::vec4 center_high, center_low, low, high, plane, phase;
  glm::uvec4 range, ids;
};
static_assert(sizeof(Header) == 128);

// Buffers of shaders/junctions.glsl.
constexpr GLuint kHeaders = 3, kCuts = 4, kCorners = 5;

double phase(double x) { return x - std::floor(x / kNoisePeriod_m) * kNoisePeriod_m; }

template <class T>
gl::Buffer buffer(const std::vector<T>& data) {
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(T)), data.data());
}

// Where the road's own coordinates stand at its cut: s modulo the noise's period, the direction in which s and t run
// as seen into the junction, the road's index. A road that the network lacks counts as the first.
glm::vec4 road_row(const Network& network, const RoadsById& roads, const JunctionArm& arm) {
  const auto found = roads.find(arm.road);
  if (found == roads.end()) return {0, 1, 0, 0};
  const double end = phase(network.roads[found->second].length_m());
  return glm::dvec4(arm.at_end ? end : 0.0, arm.at_end ? 1 : -1, found->second, 0);
}

}  // namespace

void JunctionBatch::upload(const Network& network) {
  count_ = static_cast<GLsizei>(network.junctions.size());
  if (network.junctions.empty()) return;
  const RoadsById roads = roads_by_id(network);
  std::vector<Header> headers;
  std::vector<glm::vec4> cuts, corners;
  for (const Junction& junction : network.junctions) {
    const JunctionSurface surface = junction_surface(junction);
    const SplitPosition center = split(surface.center_m);
    Header header{};
    header.center_high = glm::vec4(center.high, 0);
    header.center_low = glm::vec4(center.low, 0);
    header.low = glm::dvec4(surface.low_m, surface.plane_gap_m);
    header.high = glm::dvec4(surface.high_m, 0);
    header.plane = glm::dvec4(surface.plane, surface.slope_spread);
    header.phase = glm::dvec4(phase(surface.center_m.x), phase(surface.center_m.y), junction.underlap_m, 0);
    header.range = {cuts.size() / 4, surface.cuts.size(), corners.size() / 6, surface.corners.size()};
    header.ids = {headers.size(), 1 + network.roads.size() + headers.size(), 0, 0};
    headers.push_back(header);
    for (std::size_t i = 0; i < surface.cuts.size(); ++i) {
      const Lib::JunctionCut& c = surface.cuts[i];
      cuts.emplace_back(c.x0, c.y0, c.x1, c.y1);
      cuts.emplace_back(c.left, c.right, c.z, c.grade);
      cuts.emplace_back(c.tilt, c.fall_left, c.fall_right, 0);
      cuts.push_back(road_row(network, roads, junction.arms[i]));
    }
    for (const Lib::JunctionCorner& c : surface.corners) {
      corners.emplace_back(c.x0, c.y0, c.y1, c.chord);
      corners.emplace_back(c.cx, c.cy, c.a, c.b);
      corners.emplace_back(c.arc, c.c0, c.c1, c.z0);
      corners.emplace_back(c.z1, c.z2, c.z3, c.along0);
      corners.emplace_back(c.across0, c.along1, c.across1, c.fall0);
      corners.emplace_back(c.fall1, 0, 0, 0);
    }
  }
  vertex_array_ = gl::VertexArray::create();
  bind_strips(vertex_array_, elements_);
  headers_ = buffer(headers);
  cuts_ = buffer(cuts);
  corners_ = buffer(corners);
}

void JunctionBatch::draw() const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kHeaders, headers_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCuts, cuts_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kCorners, corners_.id());
  glBindVertexArray(vertex_array_.id());
  draw_boxes(count_);
}

}  // namespace roadgen
