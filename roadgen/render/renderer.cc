#include "roadgen/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <span>
#include <string>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "roadgen/render/environment.h"
#include "roadgen/render/frustum.h"
#include "roadgen/render/gl.h"
#include "roadgen/render/ground_batch.h"
#include "roadgen/render/ground_textures.h"
#include "roadgen/render/junction_batch.h"
#include "roadgen/render/object_batch.h"
#include "roadgen/render/program.h"
#include "roadgen/render/render_target.h"
#include "roadgen/render/road_tiles.h"
#include "roadgen/render/sun_grid.h"
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

glm::dvec3 direction(double azimuth_deg, double elevation_deg) {
  const double azimuth = azimuth_deg * std::numbers::pi / 180, elevation = elevation_deg * std::numbers::pi / 180;
  return glm::dvec3(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                    std::sin(elevation));
}

// The programs of one kind of output.
struct Programs {
  LazyProgram ground, ground_at_tunnels;
  std::array<LazyProgram, kRoadKinds> roads;
  LazyProgram junction, sky, sweep;
};

Result<Programs> read_programs(const ShaderDefines& defines) {
  Programs made;
  const auto with = [&](std::initializer_list<const char*> more) {
    ShaderDefines all = defines;
    for (const char* name : more) all.push_back({name, ""});
    return all;
  };
  Status status = Done{};
  const auto read = [&](LazyProgram& program, const std::string& vertex, const std::string& fragment,
                        const ShaderDefines& all) {
    if (!status) return;
    auto files = LazyProgram::graphics(vertex, fragment, all);
    if (files) {
      program = std::move(*files);
    } else {
      status = files.error();
    }
  };
  read(made.ground, "terrain.vert", "terrain.frag", defines);
  read(made.ground_at_tunnels, "terrain.vert", "terrain.frag", with({"HOLLOWS"}));
  read(made.roads[0], "road.vert", "road.frag", defines);
  read(made.roads[1], "road.vert", "road.frag", with({"RELIEF"}));
  read(made.roads[2], "road.vert", "road.frag", with({"RELIEF", "DETAILED"}));
  read(made.junction, "junction.vert", "junction.frag", defines);
  read(made.sky, "sky.vert", "sky.frag", defines);
  read(made.sweep, "sweep.vert", "sweep.frag", defines);
  if (!status) return status.error();
  return made;
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
  State(Context& c, const RendererOptions& o, Programs for_picture, Programs for_data)
      : context(c), options(o), picture(std::move(for_picture)), data(std::move(for_data)) {}

  Context& context;
  RendererOptions options;
  Programs picture, data;
  gl::Buffer frame_uniforms;
  gl::VertexArray empty;
  RoadTiles roads;
  JunctionBatch junctions;
  SweepBatch sweeps;
  GroundBatch ground;
  ObjectBatch objects;
  std::uint32_t first_object = 1;  // of the instance channel
  GroundTextures ground_textures;
  Lighting lighting;
  SunGrid sun_grid;
  unsigned shadow_kinds = 0;  // for which picture is compiled
  Environment environment;
  bool has_panorama = false;     // else the environment is the sky's, or none yet
  glm::vec3 environment_sun{0};  // under which it is that
  Program panorama_sky;
  RenderTarget drawn, resolved, channels, ground_depth;

  void upload_frame(const Camera& camera, int width, int height);
  // Compiles what a frame needs.
  Status need(Programs& programs) const;
  // least_contribution and ground_error_pixels: as in RendererOptions; waits: for all ground to be read.
  Status draw_scene(Programs& programs, const Camera& camera, int width, int height, int samples,
                    double least_contribution, double ground_error_pixels, bool waits);
  Status draw_picture(const Camera& camera, int width, int height, int samples, bool waits);
  void show_ground_to_roads();
  Status light_objects(glm::dvec3 eye_m);
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
  u.up = glm::dvec4(axes.up, std::min<double>(camera.far_m, std::numeric_limits<float>::max()));
  u.sun = glm::dvec4(direction(lighting.sun_azimuth_deg, lighting.sun_elevation_deg), lighting.haze_range_m);
  u.ground = glm::dvec4(ground.low_m() - camera.position_m.z,
                        1 / std::max(kLeastRelief_m, ground.high_m() - ground.low_m()), ground_textures.mask(), 0);
  glNamedBufferSubData(frame_uniforms.id(), 0, sizeof u, &u);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, frame_uniforms.id());
}

Status Renderer::State::need(Programs& programs) const {
  std::vector<LazyProgram*> needed = {&programs.sky};
  if (!ground.empty()) needed.push_back(&programs.ground);
  if (ground.has_cuts()) needed.push_back(&programs.ground_at_tunnels);
  for (std::size_t kind = 0; kind < kRoadKinds; ++kind) {
    if (roads.has(kind)) needed.push_back(&programs.roads[kind]);
  }
  if (!junctions.empty()) needed.push_back(&programs.junction);
  if (!sweeps.empty()) needed.push_back(&programs.sweep);
  for (LazyProgram* program : needed) {
    if (Status s = program->need(); !s) return s;
  }
  return Done{};
}

Status Renderer::State::draw_scene(Programs& programs, const Camera& camera, int width, int height, int samples,
                                   double least_contribution, double ground_error_pixels, bool waits) {
  if (Status s = need(programs); !s) return s;
  upload_frame(camera, width, height);
  if (&programs == &picture) {
    if (Status s = light_objects(camera.position_m); !s) return s;
  }
  glViewport(0, 0, width, height);
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);  // reversed
  glDepthMask(GL_TRUE);
  glDisable(GL_CULL_FACE);

  const Frustum frustum(camera, static_cast<double>(width) / height);
  const std::function<bool(glm::dvec3, double)> may_see = [&](glm::dvec3 center, double radius) {
    return frustum.may_see(center, radius);
  };
  const double pixel = 2 * std::tan(camera.fov_deg * std::numbers::pi / 360) / height;
  // Ground and objects hide what is behind them, sample by sample; what is drawn after them fades over them.
  const bool blended = glIsEnabled(GL_BLEND);
  glDisable(GL_BLEND);
  ground_textures.bind();
  // At the picture's corners what is on the near plane is farther away.
  const double side = 0.5 * pixel * width, top = 0.5 * pixel * height;
  const GroundView ground_view = {.eye_m = camera.position_m,
                                  .part = ground_error_pixels * pixel,
                                  .waits = waits,
                                  .leaves_out_hidden = options.cull,
                                  .pixel_rad = pixel,
                                  .nearest_drawn_m = camera.near_m * std::sqrt(1 + side * side + top * top),
                                  .may_see = may_see};
  if (!ground.empty()) {
    if (Status s = ground.draw(*programs.ground, *programs.ground_at_tunnels, ground_view); !s) return s;
  }
  if (&programs == &picture) show_ground_to_roads();
  const RenderTarget& target = &programs == &data ? channels : drawn;
  const ObjectView view = {
      camera, width, height, samples, &programs == &data, first_object, target.framebuffer(), target.depth()};
  if (Status s = objects.draw(view); !s) return s;
  if (blended) glEnable(GL_BLEND);
  glDepthFunc(GL_GEQUAL);
  glDepthMask(GL_FALSE);
  (has_panorama && &programs == &picture ? panorama_sky : *programs.sky).use();
  glBindVertexArray(empty.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_GREATER);
  // Roads last: their antialiased edges fade over what lies behind; junctions first, since the corners' strips lie on
  // their edges.
  if (!junctions.empty()) {
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    programs.junction->use();
    junctions.draw();
    glDisable(GL_CULL_FACE);
  }
  roads.draw({camera, width, height, lighting.haze_range_m, least_contribution}, options.cull, programs.roads);
  // After the sky and the roads: thin cables fade over them.
  if (!sweeps.empty()) sweeps.draw(*programs.sweep, camera.position_m, may_see);
  glBindVertexArray(0);
  glUseProgram(0);
  return Done{};
}

// Only scenes with objects pay for an environment.
Status Renderer::State::light_objects(glm::dvec3 eye_m) {
  if (objects.empty() && !has_panorama) return Done{};
  const glm::vec3 toward_sun = direction(lighting.sun_azimuth_deg, lighting.sun_elevation_deg);
  if (!environment || (!has_panorama && environment_sun != toward_sun)) {
    auto made = Environment::of_sky(toward_sun);
    if (!made) return made.error();
    environment = std::move(*made);
    environment_sun = toward_sun;
  }
  environment.bind();
  if (sun_grid.empty()) return Done{};
  return sun_grid.bind(direction(lighting.sun_azimuth_deg, lighting.sun_elevation_deg), eye_m);
}

// What pixels of roads cost is in finding them: those behind the ground had better be known before.
void Renderer::State::show_ground_to_roads() {
  const int samples = ground.empty() ? 0 : drawn.samples();
  if (samples > 0) {
    const GLenum target = samples == 1 ? GL_TEXTURE_2D : GL_TEXTURE_2D_MULTISAMPLE;
    glCopyImageSubData(drawn.depth(), target, 0, 0, 0, 0, ground_depth.depth(), target, 0, 0, 0, 0, drawn.width(),
                       drawn.height(), 1);
    glBindTextureUnit(samples == 1 ? 2 : 3, ground_depth.depth());
  }
  for (const LazyProgram& program : picture.roads) {
    if (program->id() != 0) glProgramUniform1i(program->id(), 0, samples);
  }
}

Status Renderer::State::draw_picture(const Camera& camera, int width, int height, int samples, bool waits) {
  if (Status s = ensure(drawn, width, height, samples, {GL_SRGB8_ALPHA8}, GL_DEPTH_COMPONENT32F); !s) return s;
  if (Status s = ensure(resolved, width, height, 1, {GL_SRGB8_ALPHA8}, 0); !s) return s;
  if (Status s = ensure(ground_depth, width, height, samples, {}, GL_DEPTH_COMPONENT32F); !s) return s;
  drawn.bind();
  const float black[4] = {0, 0, 0, 1}, far[1] = {0};
  glClearBufferfv(GL_COLOR, 0, black);
  glClearBufferfv(GL_DEPTH, 0, far);
  glEnable(GL_FRAMEBUFFER_SRGB);
  // The road's edge fades over the ground drawn before it.
  glEnable(GL_BLEND);
  glBlendFuncSeparate(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  if (Status s = draw_scene(picture, camera, width, height, samples, options.least_contribution,
                            options.ground_error_pixels, waits);
      !s) {
    return s;
  }
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
  return draw_scene(data, camera, width, height, 1, 0, 0, true);
}

Renderer::Renderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() {
  // Its objects live in its context; where that can no longer be made current they are gone with it.
  if (state_) static_cast<void>(state_->context.make_current().ok());
}

Result<Renderer> Renderer::create(Context& context, const RendererOptions& options) {
  if (options.gpu_budget_bytes < kPageBytes) {
    return Error{ErrorCode::kUsage,
                 "the GPU memory for roads must be at least " + std::to_string(kPageBytes) + " bytes"};
  }
  if (options.ground_budget_bytes < kLeastGroundBytes) {
    return Error{ErrorCode::kUsage,
                 "the memory for the ground must be at least " + std::to_string(kLeastGroundBytes) + " bytes"};
  }
  if (!(options.least_contribution >= 0 && options.least_contribution <= 1)) {
    return Error{ErrorCode::kUsage, "the least contribution must lie in [0, 1]"};
  }
  if (!(options.ground_error_pixels >= 0)) {
    return Error{ErrorCode::kUsage, "the error of the ground must be at least 0 pixels"};
  }
  if (Status s = context.make_current(); !s) return s.error();
  auto picture = read_programs({});
  if (!picture) return picture.error();
  auto data = read_programs({{"CHANNELS", ""}});
  if (!data) return data.error();
  auto state = std::make_unique<State>(context, options, std::move(*picture), std::move(*data));
  state->frame_uniforms = gl::Buffer::with_data(sizeof(FrameUniforms), nullptr, GL_DYNAMIC_STORAGE_BIT);
  state->empty = gl::VertexArray::create();
  return Renderer(std::move(state));
}

namespace {

// What no picture can be made of; everything else is drawn, however odd.
Status check_drawable(const Road& road) {
  const auto refuse = [&](const char* why) { return Error{ErrorCode::kData, why, {}, 0, "road " + road.id}; };
  if (!is_finite(road)) return refuse("a number is not finite");
  for (const Segment& segment : road.segments) {
    if (!(segment.chord_length_m() > 0)) return refuse("a segment has no length");
    if (segment.section >= road.sections.size()) return refuse("a segment has no lane section");
  }
  return Done{};
}

}  // namespace

Status Renderer::load_roads(const Network& network) {
  for (const Road& road : network.roads) {
    if (Status s = check_drawable(road); !s) return s;
  }
  if (Status s = state_->context.make_current(); !s) return s;
  RoadScene scene = road_scene(network);
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (scene.sections.size() > static_cast<std::size_t>(most)) {
    return Error{ErrorCode::kData, "the roads' cross sections do not fit into a texture of this OpenGL driver: " +
                                       std::to_string(scene.sections.size()) + " rows of at most " +
                                       std::to_string(most)};
  }
  state_->roads = RoadTiles(std::move(scene), state_->options.gpu_budget_bytes);
  state_->junctions.upload(network);
  state_->sweeps.upload(network);
  state_->first_object = static_cast<std::uint32_t>(1 + network.roads.size() + network.junctions.size());
  return Done{};
}

RoadStatistics Renderer::road_statistics() const { return state_->roads.statistics(); }

Status Renderer::load_ground(std::span<const TerrainMesh> tiles) {
  return load_ground(ground_in_memory(std::make_shared<const std::vector<TerrainMesh>>(tiles.begin(), tiles.end())));
}

Status Renderer::load_ground(std::shared_ptr<const GroundSource> ground) {
  if (Status s = state_->context.make_current(); !s) return s;
  state_->ground = GroundBatch(std::move(ground), state_->options.ground_budget_bytes);
  return Done{};
}

Status Renderer::load_objects(const ObjectScene& scene, const ObjectOptions& options) {
  if (options.polygon != 0 && (options.polygon < 3 || options.polygon > 32)) {
    return Error{ErrorCode::kUsage, "the polygons around objects must have 3 to 32 corners"};
  }
  for (const Diagnostic& fault : check(scene, 1)) {
    return Error{ErrorCode::kData, fault.message, fault.file, fault.line, fault.element};
  }
  if (Status s = state_->context.make_current(); !s) return s;
  if (Status s = ObjectBatch::check_room(scene); !s) return s;
  State& state = *state_;
  SunGrid sun_grid;
  if (Status s = sun_grid.upload(options.shadows ? scene : ObjectScene{}); !s) return s;
  ObjectBatch objects;
  if (Status s = objects.upload(scene, options, sun_grid.kinds()); !s) return s;
  // Roads without objects pay nothing for shadows.
  if (sun_grid.kinds() != state.shadow_kinds) {
    ShaderDefines defines;
    add_shadows(defines, sun_grid.kinds());
    auto picture = read_programs(defines);
    if (!picture) return picture.error();
    state.picture = std::move(*picture);
    state.shadow_kinds = sun_grid.kinds();
  }
  state.sun_grid = std::move(sun_grid);
  state.objects = std::move(objects);
  return Done{};
}

Status Renderer::load_environment(const ImageF& panorama) {
  if (panorama.channels != 3 || panorama.width < 1 || panorama.height < 1) {
    return Error{ErrorCode::kData, "a panorama must have pixels of three channels"};
  }
  if (Status s = state_->context.make_current(); !s) return s;
  auto made = Environment::of_panorama(panorama);
  if (!made) return made.error();
  auto sky = Program::graphics("sky.vert", "sky.frag", {{"PANORAMA", ""}});
  if (!sky) return sky.error();
  state_->environment = std::move(*made);
  state_->panorama_sky = std::move(*sky);
  state_->has_panorama = true;
  return Done{};
}

ObjectStatistics Renderer::object_statistics() const { return state_->objects.statistics(); }

Status Renderer::set_ground_texture(GroundMaterial material, const Image8& picture) {
  if (Status s = state_->context.make_current(); !s) return s;
  return state_->ground_textures.take(material, picture);
}

GroundStatistics Renderer::ground_statistics() const { return state_->ground.statistics(); }

void Renderer::set_lighting(const Lighting& lighting) { state_->lighting = lighting; }

Result<Frame> Renderer::render(const Camera& camera, const FrameOptions& options) {
  if (Status s = check_request(camera, options.width, options.height); !s) return s.error();
  if (options.samples != 1 && options.samples != 4) return Error{ErrorCode::kUsage, "samples must be 1 or 4"};
  State& state = *state_;
  if (Status s = state.context.make_current(); !s) return s.error();
  Frame frame;
  if (options.channels & kColor) {
    if (Status s = state.draw_picture(camera, options.width, options.height, options.samples, true); !s)
      return s.error();
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
  if (Status s = state_->draw_picture(camera, width, height, samples, false); !s) return s;
  glBlitNamedFramebuffer(state_->resolved.framebuffer(), target, 0, 0, width, height, 0, 0, width, height,
                         GL_COLOR_BUFFER_BIT, GL_NEAREST);
  return Done{};
}

}  // namespace roadgen
