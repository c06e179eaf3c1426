#include "roadgen/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/render/gl.h"
#include "roadgen/render/program.h"
#include "roadgen/render/render_target.h"
#include "roadgen/render/road_instance.h"
#include "roadgen/render/sweep_batch.h"

namespace roadgen {
namespace {

// The uniform block of shaders/frame.glsl, std140.
struct FrameUniforms {
  glm::mat4 clip_from_relative;
  glm::vec4 eye_high, eye_low, eye_phase, forward, right, up, sun, ground;
};
static_assert(sizeof(FrameUniforms) == 64 + 8 * 16);

// Materials go by height within the ground's relief; hills lower than this stay green.
constexpr double kLeastRelief_m = 600;

glm::vec3 direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180, elevation = elevation_deg * std::numbers::pi / 180;
  return glm::dvec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                    std::sin(elevation));
}

// The segments of one program: an instance buffer and the vertex array that reads it once per instance.
struct RoadBatch {
  gl::VertexArray vertex_array;
  gl::Buffer instances;
  GLsizei count = 0;

  void upload(std::span<const RoadInstance> data) {
    vertex_array = gl::VertexArray::create();
    count = static_cast<GLsizei>(data.size());
    if (data.empty()) return;
    instances = gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size_bytes()), data.data());
    glVertexArrayVertexBuffer(vertex_array.id(), 0, instances.id(), 0, sizeof(RoadInstance));
    glVertexArrayBindingDivisor(vertex_array.id(), 0, 1);
    constexpr GLint kComponents[] = {3, 3, 4, 4, 4, 4, 4, 2};
    GLuint offset = 0;
    for (GLuint location = 0; location < std::size(kComponents); ++location) {
      glEnableVertexArrayAttrib(vertex_array.id(), location);
      glVertexArrayAttribFormat(vertex_array.id(), location, kComponents[location], GL_FLOAT, GL_FALSE, offset);
      glVertexArrayAttribBinding(vertex_array.id(), location, 0);
      offset += static_cast<GLuint>(kComponents[location]) * sizeof(float);
    }
  }
};

struct GroundBatch {
  gl::VertexArray vertex_array;
  gl::Buffer positions, normals, triangles;
  GLsizei indices = 0;
  glm::dvec3 origin_m{0, 0, 0};
  glm::vec3 center_m{0, 0, 0};  // of the bounding sphere, from the origin
  float radius_m = 0;

  void upload(const TerrainMesh& mesh) {
    vertex_array = gl::VertexArray::create();
    origin_m = mesh.origin_m;
    glm::vec3 low(std::numeric_limits<float>::max()), high(-std::numeric_limits<float>::max());
    for (const glm::vec3& p : mesh.positions_m) low = glm::min(low, p), high = glm::max(high, p);
    center_m = 0.5f * (low + high);
    radius_m = 0.5f * glm::length(high - low);
    indices = static_cast<GLsizei>(mesh.triangles.size());
    if (mesh.triangles.empty()) return;
    const auto buffer = [](const auto& data) {
      return gl::Buffer::with_data(static_cast<GLsizeiptr>(data.size() * sizeof(data[0])), data.data());
    };
    positions = buffer(mesh.positions_m);
    normals = buffer(mesh.normals);
    triangles = buffer(mesh.triangles);
    glVertexArrayElementBuffer(vertex_array.id(), triangles.id());
    for (GLuint i = 0; i < 2; ++i) {
      glVertexArrayVertexBuffer(vertex_array.id(), i, (i == 0 ? positions : normals).id(), 0, sizeof(glm::vec3));
      glEnableVertexArrayAttrib(vertex_array.id(), i);
      glVertexArrayAttribFormat(vertex_array.id(), i, 3, GL_FLOAT, GL_FALSE, 0);
      glVertexArrayAttribBinding(vertex_array.id(), i, i);
    }
  }
};

// The four planes of the view's sides, through the eye, pointing inward.
struct ViewSides {
  glm::dvec3 normal[4];
  ViewSides(const Camera& camera, double aspect) {
    const ViewAxes axes = view_axes(camera);
    const double y = std::tan(camera.fov_deg * std::numbers::pi / 360), x = y * aspect;
    normal[0] = glm::normalize(axes.forward * x + axes.right);
    normal[1] = glm::normalize(axes.forward * x - axes.right);
    normal[2] = glm::normalize(axes.forward * y + axes.up);
    normal[3] = glm::normalize(axes.forward * y - axes.up);
  }
  bool may_see(glm::dvec3 center, double radius) const {
    return std::all_of(std::begin(normal), std::end(normal),
                       [&](const glm::dvec3& n) { return glm::dot(n, center) >= -radius; });
  }
};

// The programs of one kind of output.
struct Programs {
  Program ground, road_planar, road_relief, sky, sweep;
};

Result<Programs> compile(const ShaderDefines& defines) {
  ShaderDefines with_relief = defines;
  with_relief.push_back({"RELIEF", ""});
  auto ground = Program::graphics("terrain.vert", "terrain.frag", defines);
  if (!ground) return ground.error();
  auto planar = Program::graphics("road.vert", "road.frag", defines);
  if (!planar) return planar.error();
  auto relief = Program::graphics("road.vert", "road.frag", with_relief);
  if (!relief) return relief.error();
  auto sky = Program::graphics("sky.vert", "sky.frag", defines);
  if (!sky) return sky.error();
  auto sweep = Program::graphics("sweep.vert", "sweep.frag", defines);
  if (!sweep) return sweep.error();
  return Programs{std::move(*ground), std::move(*planar), std::move(*relief), std::move(*sky), std::move(*sweep)};
}

// The target of a size, made anew when the size changes.
Status ensure(RenderTarget& target, int width, int height, int samples, std::vector<GLenum> colors, GLenum depth) {
  if (target.framebuffer() != 0 && target.width() == width && target.height() == height &&
      target.samples() == samples) {
    return Done{};
  }
  auto made = RenderTarget::create({width, height, std::move(colors), depth, samples});
  if (!made) return made.error();
  target = std::move(*made);
  return Done{};
}

Image<std::uint32_t> channel(const ImageF& image, int index) {
  Image<std::uint32_t> values(image.width, image.height, 1);
  for (std::size_t i = 0; i < values.pixels.size(); ++i) {
    values.pixels[i] = static_cast<std::uint32_t>(
        image.pixels[i * static_cast<std::size_t>(image.channels) + static_cast<std::size_t>(index)]);
  }
  return values;
}

Status check_request(const Camera& camera, int width, int height) {
  if (width < 1 || height < 1 || width > 16384 || height > 16384) {
    return Error{ErrorCode::kUsage, "the picture's size must lie in 1 to 16384 pixels each way"};
  }
  return check_camera(camera);
}

}  // namespace

struct Renderer::State {
  State(Context& c, Programs for_picture, Programs for_data)
      : context(c), picture(std::move(for_picture)), data(std::move(for_data)) {}

  Context& context;
  Programs picture, data;
  gl::Buffer frame_uniforms;
  gl::VertexArray empty;
  RoadBatch planar, relief;
  SweepBatch sweeps;
  std::vector<GroundBatch> ground;
  double ground_low_m = 0, ground_relief_m = 1;
  Lighting lighting;
  RenderTarget drawn, resolved, channels;

  void upload_frame(const Camera& camera, int width, int height);
  void draw_scene(const Programs& programs, const Camera& camera, int width, int height);
  Status draw_picture(const Camera& camera, int width, int height, int samples);
  Status draw_channels(const Camera& camera, int width, int height);
};

void Renderer::State::upload_frame(const Camera& camera, int width, int height) {
  const ViewAxes axes = view_axes(camera);
  const double pixel = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / height;
  const SplitPosition eye = split(camera.position_m);
  const auto phase = [](double x) { return x - std::floor(x / kNoisePeriod_m) * kNoisePeriod_m; };
  FrameUniforms u;
  u.clip_from_relative = glm::mat4(clip_from_relative(camera, static_cast<double>(width) / height));
  u.eye_high = glm::vec4(eye.high, 0);
  u.eye_low = glm::vec4(eye.low, 0);
  u.eye_phase =
      glm::dvec4(phase(camera.position_m.x), phase(camera.position_m.y), 0.5 * pixel * width, 0.5 * pixel * height);
  u.forward = glm::dvec4(axes.forward, camera.near_m);
  u.right = glm::dvec4(axes.right, pixel);
  u.up = glm::dvec4(axes.up, 0);
  u.sun = glm::vec4(direction(lighting.sun_azimuth_deg, lighting.sun_elevation_deg),
                    static_cast<float>(lighting.haze_range_m));
  u.ground = glm::dvec4(ground_low_m - camera.position_m.z, 1 / ground_relief_m, 0, 0);
  glNamedBufferSubData(frame_uniforms.id(), 0, sizeof u, &u);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_uniforms.id());
}

void Renderer::State::draw_scene(const Programs& programs, const Camera& camera, int width, int height) {
  upload_frame(camera, width, height);
  glViewport(0, 0, width, height);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);  // reversed
  glDepthMask(GL_TRUE);
  glDisable(GL_CULL_FACE);

  const ViewSides sides(camera, static_cast<double>(width) / height);
  if (!ground.empty()) programs.ground.use();
  for (const GroundBatch& batch : ground) {
    const glm::dvec3 tile = batch.origin_m - camera.position_m;
    if (!sides.may_see(tile + glm::dvec3(batch.center_m), batch.radius_m)) continue;
    glUniform3f(0, static_cast<float>(tile.x), static_cast<float>(tile.y), static_cast<float>(tile.z));
    glBindVertexArray(batch.vertex_array.id());
    glDrawElements(GL_TRIANGLES, batch.indices, GL_UNSIGNED_INT, nullptr);
  }
  if (planar.count > 0) {
    programs.road_planar.use();
    glBindVertexArray(planar.vertex_array.id());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, planar.count);
  }
  if (relief.count > 0) {
    // Back faces only: one ray per pixel, also with the eye inside the box.
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    programs.road_relief.use();
    glBindVertexArray(relief.vertex_array.id());
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 14, relief.count);
    glDisable(GL_CULL_FACE);
  }
  glDepthFunc(GL_GEQUAL);
  glDepthMask(GL_FALSE);
  programs.sky.use();
  glBindVertexArray(empty.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  // After the sky: thin cables fade over it.
  glDepthFunc(GL_GREATER);
  sweeps.draw(programs.sweep, camera.position_m,
              [&](glm::dvec3 center, double radius) { return sides.may_see(center, radius); });
  glBindVertexArray(0);
  glUseProgram(0);
}

Status Renderer::State::draw_picture(const Camera& camera, int width, int height, int samples) {
  if (Status s = ensure(drawn, width, height, samples, {GL_SRGB8_ALPHA8}, GL_DEPTH_COMPONENT32F); !s) return s;
  if (Status s = ensure(resolved, width, height, 1, {GL_SRGB8_ALPHA8}, 0); !s) return s;
  drawn.bind();
  const float black[4] = {0, 0, 0, 1}, far[1] = {0};
  glClearBufferfv(GL_COLOR, 0, black);
  glClearBufferfv(GL_DEPTH, 0, far);
  glEnable(GL_FRAMEBUFFER_SRGB);
  // The road's edge fades over the ground drawn before it.
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  draw_scene(picture, camera, width, height);
  glDisable(GL_BLEND);
  glBlitNamedFramebuffer(drawn.framebuffer(), resolved.framebuffer(), 0, 0, width, height, 0, 0, width, height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glDisable(GL_FRAMEBUFFER_SRGB);
  return Done{};
}

Status Renderer::State::draw_channels(const Camera& camera, int width, int height) {
  if (Status s = ensure(channels, width, height, 1, {GL_RGBA32F, GL_RGBA32F, GL_RG32F}, GL_DEPTH_COMPONENT32F); !s) {
    return s;
  }
  channels.bind();
  const float off_road[4] = {-1, 0, 0, 0}, none[4] = {0, 0, 0, 0};
  glClearBufferfv(GL_COLOR, 0, off_road);
  glClearBufferfv(GL_COLOR, 1, none);
  glClearBufferfv(GL_COLOR, 2, none);
  glClearBufferfv(GL_DEPTH, 0, none);
  draw_scene(data, camera, width, height);
  return Done{};
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() {
  // Its objects live in its context; where that can no longer be made current they are gone with it.
  if (state_) static_cast<void>(state_->context.make_current().ok());
}

Result<Renderer> Renderer::create(Context& context) {
  if (Status s = context.make_current(); !s) return s.error();
  auto picture = compile({});
  if (!picture) return picture.error();
  auto data = compile({{"CHANNELS", ""}});
  if (!data) return data.error();
  auto state = std::make_unique<State>(context, std::move(*picture), std::move(*data));
  state->frame_uniforms = gl::Buffer::with_data(sizeof(FrameUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT);
  state->empty = gl::VertexArray::create();
  return Renderer(std::move(state));
}

Status Renderer::load_roads(const Network& network) {
  if (Status s = state_->context.make_current(); !s) return s;
  std::vector<RoadInstance> planar, relief;
  for (std::size_t i = 0; i < network.roads.size(); ++i) {
    for (const Segment& segment : network.roads[i].segments) {
      (planar_deviation_m(segment) <= kPlanarTolerance_m ? planar : relief).push_back(road_instance(segment, i));
    }
  }
  state_->planar.upload(planar);
  state_->relief.upload(relief);
  state_->sweeps.upload(network);
  return Done{};
}

Status Renderer::load_ground(std::span<const TerrainMesh> tiles) {
  if (Status s = state_->context.make_current(); !s) return s;
  state_->ground.clear();
  double low = std::numeric_limits<double>::max(), high = -low;
  for (const TerrainMesh& tile : tiles) {
    if (tile.triangles.empty()) continue;
    state_->ground.emplace_back().upload(tile);
    for (const glm::vec3& p : tile.positions_m) {
      low = std::min(low, tile.origin_m.z + p.z);
      high = std::max(high, tile.origin_m.z + p.z);
    }
  }
  if (state_->ground.empty()) return Done{};
  state_->ground_low_m = low;
  state_->ground_relief_m = std::max(kLeastRelief_m, high - low);
  return Done{};
}

void Renderer::set_lighting(const Lighting& lighting) { state_->lighting = lighting; }

Result<Frame> Renderer::render(const Camera& camera, const FrameOptions& options) {
  if (Status s = check_request(camera, options.width, options.height); !s) return s.error();
  if (options.samples != 1 && options.samples != 4) return Error{ErrorCode::kUsage, "samples must be 1 or 4"};
  State& state = *state_;
  if (Status s = state.context.make_current(); !s) return s.error();
  Frame frame;
  if (options.channels & kColor) {
    if (Status s = state.draw_picture(camera, options.width, options.height, options.samples); !s) return s.error();
    frame.color = state.resolved.read_rgba8();
  }
  if ((options.channels & ~kColor) == 0) return frame;

  if (Status s = state.draw_channels(camera, options.width, options.height); !s) return s.error();
  if (options.channels & kDepth) {
    frame.depth_m = state.channels.read_depth();
    for (float& d : frame.depth_m.pixels) {
      d = d > 0 ? static_cast<float>(camera.near_m / d) : std::numeric_limits<float>::infinity();
    }
  }
  if (options.channels & kRoad) frame.road = state.channels.read_float(0, 4);
  if (options.channels & kNormal) frame.normal = state.channels.read_float(1, 3);
  if (options.channels & (kLabel | kInstance)) {
    const ImageF ids = state.channels.read_float(2, 2);
    if (options.channels & kLabel) frame.label = channel(ids, 0);
    if (options.channels & kInstance) frame.instance = channel(ids, 1);
  }
  return frame;
}

Status Renderer::draw(const Camera& camera, int width, int height, int samples, unsigned target) {
  if (Status s = check_request(camera, width, height); !s) return s;
  if (Status s = state_->context.make_current(); !s) return s;
  if (Status s = state_->draw_picture(camera, width, height, samples); !s) return s;
  glBlitNamedFramebuffer(state_->resolved.framebuffer(), target, 0, 0, width, height, 0, 0, width, height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return Done{};
}

}  // namespace roadgen
