#include "tests/bench/road_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numbers>
#include <tuple>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/render/gl.h"
#include "roadgen/render/program.h"
#include "roadgen/render/render_target.h"
#include "roadgen/render/road_instance.h"

namespace roadgen::bench {
namespace {

constexpr std::size_t kLevels = std::size(kTurns_deg);

struct Vertex {
  glm::vec3 position;
  glm::vec2 st;
  glm::vec4 frame;  // left, grade, outward
};

// glMultiDrawElementsIndirect's.
struct Command {
  GLuint count, instances, first, base_vertex, base_instance;
};

// Triangles of one tile at one level.
struct Range {
  GLuint first = 0, count = 0;
  double error_m = 0;  // greatest distance of the road's edges and middle from the mesh's
};

struct Tile {
  Bounds bounds;
  std::array<Range, kLevels> levels;
};

struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<GLuint> triangles;
  std::vector<Tile> tiles;
};

// How far the heading and the pitch have turned up to each of 65 places of the segment.
std::array<double, 65> turning(const Road& road, const Segment& segment) {
  std::array<double, 65> turned{};
  const auto pose = [&](std::size_t i) {
    return pose_at(road, segment.s_start_m + segment.arc_m * (0.001 + 0.998 * static_cast<double>(i) / 64), 0);
  };
  RoadPose before = pose(0);
  for (std::size_t i = 1; i < turned.size(); ++i) {
    const RoadPose now = pose(i);
    const double heading = std::remainder(now.heading_rad - before.heading_rad, 2 * std::numbers::pi);
    turned[i] = turned[i - 1] + std::abs(heading) + std::abs(now.pitch_rad - before.pitch_rad);
    before = now;
  }
  return turned;
}

// Arc lengths of the rows that a segment is cut at, from its start up to but without its end.
std::vector<double> rows_of(const Road& road, const Segment& segment, double turn_rad) {
  const auto turned = turning(road, segment);
  const int count = std::max(1, static_cast<int>(std::ceil(turned.back() / turn_rad)));
  std::vector<double> rows;
  std::size_t at = 0;
  for (int i = 0; i < count; ++i) {
    const double wanted = turned.back() * i / count;
    while (at + 2 < turned.size() && turned[at + 1] < wanted) ++at;
    const double step = turned[at + 1] - turned[at];
    const double part = step > 0 ? std::clamp((wanted - turned[at]) / step, 0.0, 1.0) : 0.0;
    rows.push_back(segment.s_start_m + segment.arc_m * (static_cast<double>(at) + part) / 64);
  }
  return rows;
}

double distance_to_line(glm::dvec3 p, glm::dvec3 a, glm::dvec3 b) {
  return glm::length(glm::cross(p - a, glm::normalize(b - a)));
}

double chord_error_m(const Road& road, double from_m, double to_m, double half_width_m) {
  double worst = 0;
  for (const double t : {-half_width_m, 0.0, half_width_m}) {
    const glm::dvec3 a = pose_at(road, from_m, t).position_m, b = pose_at(road, to_m, t).position_m;
    for (const double part : {0.25, 0.5, 0.75}) {
      const glm::dvec3 p = pose_at(road, from_m + part * (to_m - from_m), t).position_m;
      worst = std::max(worst, distance_to_line(p, a, b));
    }
  }
  return worst;
}

void add_row(Mesh& mesh, const Road& road, double s_m, double t_right_m, double t_left_m) {
  const RoadPose pose = pose_at(road, s_m, 0);
  const glm::vec2 left(-std::sin(pose.heading_rad), std::cos(pose.heading_rad));
  for (const bool is_left : {false, true}) {
    const double t = is_left ? t_left_m : t_right_m;
    mesh.vertices.push_back({pose_at(road, s_m, t).position_m, glm::vec2(s_m, t),
                             glm::vec4(left, std::tan(pose.pitch_rad), is_left ? 1 : -1)});
  }
}

// Returns the error of the triangles added, m.
double add_segment(Mesh& mesh, const Road& road, const Segment& segment, double turn_rad) {
  const double right = segment.right_m.c0, left = segment.left_m.c0;
  std::vector<double> rows = rows_of(road, segment, turn_rad);
  rows.push_back(segment.s_start_m + segment.arc_m * (1 - 1e-9));  // before a closed road begins again
  double error = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto v = static_cast<GLuint>(mesh.vertices.size());
    add_row(mesh, road, rows[i], right, left);
    if (i + 1 == rows.size()) continue;
    mesh.triangles.insert(mesh.triangles.end(), {v, v + 2, v + 1, v + 1, v + 2, v + 3});
    error = std::max(error, chord_error_m(road, rows[i], rows[i + 1], left));
  }
  return error;
}

Mesh tessellate(const Road& road) {
  Mesh mesh;
  // The Renderer's tiles.
  std::map<std::tuple<double, double>, std::vector<const Segment*>> by_tile;
  for (const Segment& segment : road.segments) {
    const glm::dvec2 tile = glm::floor(segment.start_m / kTileSize_m);
    by_tile[{tile.x, tile.y}].push_back(&segment);
  }
  for (const auto& [key, segments] : by_tile) {
    Tile& tile = mesh.tiles.emplace_back();
    for (const Segment* segment : segments) {
      tile.bounds.add(bounds(*segment).low_m);
      tile.bounds.add(bounds(*segment).high_m);
    }
  }
  // By level, then by tile: a whole level is one range.
  for (std::size_t level = 0; level < kLevels; ++level) {
    const double turn_rad = kTurns_deg[level] * std::numbers::pi / 180;
    auto tile = mesh.tiles.begin();
    for (const auto& [key, segments] : by_tile) {
      Range& range = (tile++)->levels[level];
      range.first = static_cast<GLuint>(mesh.triangles.size());
      for (const Segment* segment : segments)
        range.error_m = std::max(range.error_m, add_segment(mesh, road, *segment, turn_rad));
      range.count = static_cast<GLuint>(mesh.triangles.size()) - range.first;
    }
  }
  return mesh;
}

// The planes of the view through the eye, and the far one, as inward normals.
struct View {
  glm::dvec3 normals[4];
  glm::dvec3 forward;
  double far_m;
  View(const Camera& camera, double aspect) : far_m(camera.far_m) {
    const ViewAxes axes = view_axes(camera);
    const double y = std::tan(camera.fov_deg * std::numbers::pi / 360), x = y * aspect;
    normals[0] = glm::normalize(axes.forward * x + axes.right);
    normals[1] = glm::normalize(axes.forward * x - axes.right);
    normals[2] = glm::normalize(axes.forward * y + axes.up);
    normals[3] = glm::normalize(axes.forward * y - axes.up);
    forward = axes.forward;
  }
  // A box relative to the eye.
  bool may_see(glm::dvec3 low, glm::dvec3 high) const {
    const glm::dvec3 center = 0.5 * (low + high), half = 0.5 * (high - low);
    const auto reach = [&](const glm::dvec3& n) { return glm::dot(glm::abs(n), half); };
    if (glm::dot(forward, center) - reach(forward) > far_m) return false;
    return std::all_of(std::begin(normals), std::end(normals),
                       [&](const glm::dvec3& n) { return glm::dot(n, center) >= -reach(n); });
  }
};

template <class T>
gl::Buffer buffer_of(const std::vector<T>& data, GLbitfield flags = 0) {
  return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof data[0]), data.data(), flags);
}

void attribute(GLuint array, GLuint location, GLuint binding, GLint components, std::size_t offset) {
  glEnableVertexArrayAttrib(array, location);
  glVertexArrayAttribFormat(array, location, components, GL_FLOAT, GL_FALSE, static_cast<GLuint>(offset));
  glVertexArrayAttribBinding(array, location, binding);
}

}  // namespace

struct MeshScene::State {
  Program ground_program, sky_program, road_program;
  std::vector<glm::dvec3> origins;
  Mesh mesh;
  gl::VertexArray ground, roads, empty;
  gl::Buffer ground_positions, ground_normals, ground_triangles, vertices, triangles, copies, commands;
  GLsizei ground_indices = 0;
  Bounds ground_bounds;
  RenderTarget drawn, resolved;
  std::size_t drawn_triangles = 0;

  void upload(const BaseScene& scene);
  void draw_ground(const Camera& camera, const View& view);
  std::vector<Command> road_commands(const Camera& camera, const View& view, int height, const MeshMethod& method);
  int level_for(const Tile& tile, glm::dvec3 low, glm::dvec3 high, double pixel) const;
};

void MeshScene::State::upload(const BaseScene& scene) {
  ground = gl::VertexArray::create();
  ground_positions = buffer_of(scene.ground.positions_m);
  ground_normals = buffer_of(scene.ground.normals);
  ground_triangles = buffer_of(scene.ground.triangles);
  ground_indices = static_cast<GLsizei>(scene.ground.triangles.size());
  for (const glm::vec3& p : scene.ground.positions_m) ground_bounds.add(p);
  glVertexArrayVertexBuffer(ground.id(), 0, ground_positions.id(), 0, sizeof(glm::vec3));
  glVertexArrayVertexBuffer(ground.id(), 1, ground_normals.id(), 0, sizeof(glm::vec3));
  glVertexArrayElementBuffer(ground.id(), ground_triangles.id());
  for (GLuint i = 0; i < 2; ++i) attribute(ground.id(), i, i, 3, 0);

  mesh = tessellate(scene.road);
  std::vector<glm::vec4> places;
  for (std::size_t i = 0; i < origins.size(); ++i) places.emplace_back(origins[i], static_cast<float>(i));
  vertices = buffer_of(mesh.vertices);
  triangles = buffer_of(mesh.triangles);
  copies = buffer_of(places);
  commands = gl::Buffer::with_data(static_cast<GLsizeiptr>(origins.size() * mesh.tiles.size() * sizeof(Command)),
                                   nullptr, GL_DYNAMIC_STORAGE_BIT);
  roads = gl::VertexArray::create();
  glVertexArrayVertexBuffer(roads.id(), 0, vertices.id(), 0, sizeof(Vertex));
  glVertexArrayVertexBuffer(roads.id(), 1, copies.id(), 0, sizeof(glm::vec4));
  glVertexArrayBindingDivisor(roads.id(), 1, 1);
  glVertexArrayElementBuffer(roads.id(), triangles.id());
  attribute(roads.id(), 0, 0, 3, offsetof(Vertex, position));
  attribute(roads.id(), 1, 0, 2, offsetof(Vertex, st));
  attribute(roads.id(), 2, 0, 4, offsetof(Vertex, frame));
  attribute(roads.id(), 3, 1, 4, 0);
  empty = gl::VertexArray::create();
}

void MeshScene::State::draw_ground(const Camera& camera, const View& view) {
  ground_program.use();
  glBindVertexArray(ground.id());
  for (const glm::dvec3& origin : origins) {
    const glm::dvec3 from = origin - camera.position_m;
    if (!view.may_see(from + ground_bounds.low_m, from + ground_bounds.high_m)) continue;
    glUniform3f(0, static_cast<float>(from.x), static_cast<float>(from.y), static_cast<float>(from.z));
    glDrawElements(GL_TRIANGLES, ground_indices, GL_UNSIGNED_INT, nullptr);
  }
}

// The coarsest level whose error is at most kLodError_px at the box's nearest point.
int MeshScene::State::level_for(const Tile& tile, glm::dvec3 low, glm::dvec3 high, double pixel) const {
  const double nearest_m = glm::length(glm::clamp(glm::dvec3(0), low, high));
  int best = static_cast<int>(kLevels) - 1;
  for (int level = 0; level < static_cast<int>(kLevels); ++level) {
    const bool fits = tile.levels[static_cast<std::size_t>(level)].error_m <= kLodError_px * pixel * nearest_m;
    if (fits && kTurns_deg[level] > kTurns_deg[best]) best = level;
  }
  return best;
}

std::vector<Command> MeshScene::State::road_commands(const Camera& camera, const View& view, int height,
                                                     const MeshMethod& method) {
  const double pixel = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / height;
  std::vector<Command> list;
  drawn_triangles = 0;
  if (method.kind == MeshMethod::kTurn && !method.culling) {
    const auto level = static_cast<std::size_t>(method.turn);
    const Range &first = mesh.tiles.front().levels[level], &last = mesh.tiles.back().levels[level];
    const GLuint count = last.first + last.count - first.first;
    drawn_triangles = count / 3 * origins.size();
    return {{count, static_cast<GLuint>(origins.size()), first.first, 0, 0}};
  }
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const glm::dvec3 from = origins[i] - camera.position_m;
    for (const Tile& tile : mesh.tiles) {
      const glm::dvec3 low = from + tile.bounds.low_m, high = from + tile.bounds.high_m;
      if (method.culling && !view.may_see(low, high)) continue;
      const int level = method.kind == MeshMethod::kTurn ? method.turn : level_for(tile, low, high, pixel);
      const Range& range = tile.levels[static_cast<std::size_t>(level)];
      list.push_back({range.count, 1, range.first, 0, static_cast<GLuint>(i)});
      drawn_triangles += range.count / 3;
    }
  }
  return list;
}

MeshScene::MeshScene(std::unique_ptr<State> state) : state_(std::move(state)) {}
MeshScene::MeshScene(MeshScene&&) noexcept = default;
MeshScene& MeshScene::operator=(MeshScene&&) noexcept = default;
MeshScene::~MeshScene() = default;

Result<MeshScene> MeshScene::create(const BaseScene& scene, std::span<const glm::dvec3> origins,
                                    const std::string& road_fragment, const ShaderDefines& defines) {
  setenv("ROADGEN_SHADER_DIR", ROADGEN_SOURCE_DIR "/tests/bench/shaders", 0);
  auto ground = Program::graphics("terrain.vert", "terrain.frag");
  if (!ground) return ground.error();
  auto sky = Program::graphics("sky.vert", "sky.frag");
  if (!sky) return sky.error();
  auto road = Program::graphics("road_mesh.vert", road_fragment, defines);
  if (!road) return road.error();
  auto state = std::make_unique<State>();
  state->ground_program = std::move(*ground);
  state->sky_program = std::move(*sky);
  state->road_program = std::move(*road);
  state->origins.assign(origins.begin(), origins.end());
  state->upload(scene);
  return MeshScene(std::move(state));
}

void MeshScene::set_texture(glm::dvec2 size_m, int probes) {
  state_->road_program.set("size", glm::vec2(size_m));
  state_->road_program.set("probes", probes);
}

Status MeshScene::draw(const Camera& camera, int width, int height, int samples, unsigned target,
                       const MeshMethod& method) {
  State& s = *state_;
  if (s.drawn.width() != width || s.drawn.height() != height || s.drawn.samples() != samples) {
    auto drawn = RenderTarget::create({width, height, {GL_SRGB8_ALPHA8}, GL_DEPTH_COMPONENT32F, samples});
    if (!drawn) return drawn.error();
    auto resolved = RenderTarget::create({width, height, {GL_SRGB8_ALPHA8}, 0, 1});
    if (!resolved) return resolved.error();
    s.drawn = std::move(*drawn);
    s.resolved = std::move(*resolved);
  }
  const View view(camera, static_cast<double>(width) / height);
  s.drawn.bind();
  const float black[4] = {0, 0, 0, 1}, far[1] = {0};
  glClearBufferfv(GL_COLOR, 0, black);
  glClearBufferfv(GL_DEPTH, 0, far);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  s.draw_ground(camera, view);
  glDepthFunc(GL_GEQUAL);
  glDepthMask(GL_FALSE);
  s.sky_program.use();
  glBindVertexArray(s.empty.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);
  if (method.kind != MeshMethod::kNoRoad) {
    const std::vector<Command> list = s.road_commands(camera, view, height, method);
    glNamedBufferSubData(s.commands.id(), 0, static_cast<GLsizeiptr>(list.size() * sizeof(Command)), list.data());
    s.road_program.use();
    glBindVertexArray(s.roads.id());
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, s.commands.id());
    glEnable(GL_CULL_FACE);
    glCullFace(GL_BACK);
    glEnable(GL_CLIP_DISTANCE0);  // the far plane
    glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(list.size()), 0);
    glDisable(GL_CLIP_DISTANCE0);
    glDisable(GL_CULL_FACE);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, 0);
  }
  glBindVertexArray(0);
  glUseProgram(0);
  glDisable(GL_BLEND);
  s.drawn.resolve_into(s.resolved);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glBlitNamedFramebuffer(s.resolved.framebuffer(), target, 0, 0, width, height, 0, 0, width, height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return Done{};
}

std::size_t MeshScene::triangles(int turn) const {
  std::size_t sum = 0;
  for (const Tile& tile : state_->mesh.tiles) sum += tile.levels[static_cast<std::size_t>(turn)].count / 3;
  return sum;
}

std::size_t MeshScene::triangles_drawn() const { return state_->drawn_triangles; }

}  // namespace roadgen::bench
