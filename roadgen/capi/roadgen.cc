#include "roadgen/capi/roadgen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "roadgen/import/opendrive.h"
#include "roadgen/import/scene_file.h"
#include "roadgen/query/road_index.h"
#include "roadgen/render/panorama.h"
#include "roadgen/render/placement.h"
#include "roadgen/render/renderer.h"
#include "terrain/terrain.h"

struct roadgen_network {
  roadgen::Network network;
  roadgen::RoadIndex index{network};
  explicit roadgen_network(roadgen::Network n) : network(std::move(n)) {}
};

struct roadgen_renderer {
  std::unique_ptr<roadgen::Context> context;
  std::optional<roadgen::Renderer> renderer;  // after the context: destroyed before it
  std::optional<roadgen::Terrain> terrain;    // that objects beside roads stand on
  roadgen::Camera camera;
};

namespace {

using roadgen::Error;
using roadgen::ErrorCode;

thread_local std::string last_error;

roadgen_status fail(roadgen_status status, std::string text) {
  last_error = std::move(text);
  return status;
}

roadgen_status fail(const Error& error) {
  roadgen_status status = ROADGEN_DATA_ERROR;
  if (error.code == ErrorCode::kUsage) status = ROADGEN_USAGE_ERROR;
  if (error.code == ErrorCode::kContext || error.code == ErrorCode::kShader) status = ROADGEN_CONTEXT_ERROR;
  return fail(status, error.text());
}

// Runs the body; what the libraries below might throw (memory, mostly) becomes a status.
template <class Body>
roadgen_status guarded(Body&& body) {
  try {
    return body();
  } catch (const std::exception& exception) {
    return fail(ROADGEN_DATA_ERROR, exception.what());
  } catch (...) {
    return fail(ROADGEN_DATA_ERROR, "unknown fault");
  }
}

constexpr roadgen_road_point kNoRoad = {-1, -1, 0, 0, 0, 0, 0};

// Points that are answered at once, on the stack.
constexpr size_t kBlock = 64;

glm::dvec3 point_at(const double* xyz) { return {xyz[0], xyz[1], xyz[2]}; }

roadgen_road_point to_c(const roadgen::RoadPoint& point) {
  return {point.has_road() ? static_cast<int64_t>(point.at.road) : -1,
          point.junction,
          point.lane,
          point.s_m,
          point.t_m,
          point.height_m,
          point.outside_m};
}

roadgen_pose to_c(const roadgen::RoadPose& pose) {
  return {{pose.position_m.x, pose.position_m.y, pose.position_m.z},
          pose.heading_rad,
          pose.pitch_rad,
          pose.roll_rad,
          pose.curvature_per_m,
          pose.grade,
          {pose.normal.x, pose.normal.y, pose.normal.z}};
}

}  // namespace

const char* roadgen_last_error(void) { return last_error.c_str(); }

const char* roadgen_version(void) { return ROADGEN_VERSION; }

roadgen_status roadgen_network_load(const char* path, roadgen_network** network) {
  if (!network) return fail(ROADGEN_USAGE_ERROR, "network must not be NULL");
  *network = nullptr;
  if (!path) return fail(ROADGEN_USAGE_ERROR, "path must not be NULL");
  return guarded([&] {
    auto read = roadgen::read_opendrive(path);
    if (!read) return fail(read.error());
    *network = new roadgen_network(std::move(*read));
    return ROADGEN_OK;
  });
}

void roadgen_network_free(roadgen_network* network) { delete network; }

size_t roadgen_road_count(const roadgen_network* network) { return network ? network->network.roads.size() : 0; }

const char* roadgen_road_id(const roadgen_network* network, size_t index) {
  return index < roadgen_road_count(network) ? network->network.roads[index].id.c_str() : nullptr;
}

double roadgen_road_length_m(const roadgen_network* network, size_t index) {
  return index < roadgen_road_count(network) ? network->network.roads[index].length_m() : 0;
}

roadgen_status roadgen_to_road(const roadgen_network* network, size_t count, const double* xyz, double reach_m,
                               roadgen_road_point* points) {
  return roadgen_to_road_near(network, count, xyz, reach_m, nullptr, points, nullptr);
}

roadgen_status roadgen_to_road_near(const roadgen_network* network, size_t count, const double* xyz, double reach_m,
                                    roadgen_hint* hint, roadgen_road_point* points, roadgen_pose* poses) {
  if (!network || (count > 0 && (!xyz || !points))) return fail(ROADGEN_USAGE_ERROR, "a pointer is NULL");
  if (!(reach_m >= 0)) return fail(ROADGEN_USAGE_ERROR, "reach_m must be 0 or more");
  return guarded([&] {
    roadgen::RoadHint near;
    if (hint) near.at = {hint->road, hint->segment};
    std::array<glm::dvec3, kBlock> asked;
    std::array<std::optional<roadgen::RoadPoint>, kBlock> found;
    for (size_t begin = 0; begin < count; begin += kBlock) {
      const size_t block = std::min(kBlock, count - begin);
      for (size_t i = 0; i < block; ++i) asked[i] = point_at(xyz + 3 * (begin + i));
      network->index.to_road(std::span<const glm::dvec3>(asked).first(block), reach_m, std::span(found).first(block),
                             hint ? &near : nullptr);
      for (size_t i = 0; i < block; ++i) {
        points[begin + i] = found[i] ? to_c(*found[i]) : kNoRoad;
        if (!poses) continue;
        poses[begin + i] = found[i] ? to_c(network->index.pose(*found[i], glm::dvec2(asked[i]))) : roadgen_pose{};
      }
    }
    if (hint) *hint = {near.at.road, near.at.segment};
    return ROADGEN_OK;
  });
}

roadgen_status roadgen_candidates(const roadgen_network* network, const double* xyz, double reach_m, size_t room,
                                  roadgen_road_point* points, size_t* count) {
  if (!network || !xyz || !count || (room > 0 && !points)) return fail(ROADGEN_USAGE_ERROR, "a pointer is NULL");
  if (!(reach_m >= 0)) return fail(ROADGEN_USAGE_ERROR, "reach_m must be 0 or more");
  *count = 0;
  return guarded([&] {
    std::array<roadgen::RoadPoint, kBlock> few;
    std::vector<roadgen::RoadPoint> many(room > kBlock ? room : 0);
    const std::span<roadgen::RoadPoint> found = room > kBlock ? std::span(many) : std::span(few).first(room);
    *count = network->index.candidates(point_at(xyz), reach_m, found);
    for (size_t i = 0; i < std::min(*count, room); ++i) points[i] = to_c(found[i]);
    return ROADGEN_OK;
  });
}

roadgen_status roadgen_to_world(const roadgen_network* network, size_t count, const int64_t* road, const double* s_m,
                                const double* t_m, roadgen_pose* poses) {
  if (!network || (count > 0 && (!road || !s_m || !t_m || !poses))) {
    return fail(ROADGEN_USAGE_ERROR, "a pointer is NULL");
  }
  return guarded([&] {
    for (size_t i = 0; i < count; ++i) {
      if (road[i] < 0 || static_cast<size_t>(road[i]) >= network->network.roads.size()) {
        return fail(ROADGEN_USAGE_ERROR, "there is no road of index " + std::to_string(road[i]));
      }
      if (!std::isfinite(s_m[i]) || !std::isfinite(t_m[i])) {
        return fail(ROADGEN_USAGE_ERROR, "s and t must be finite numbers");
      }
    }
    std::array<roadgen::RoadPlace, kBlock> places;
    std::array<roadgen::RoadPose, kBlock> found;
    for (size_t begin = 0; begin < count; begin += kBlock) {
      const size_t block = std::min(kBlock, count - begin);
      for (size_t i = 0; i < block; ++i) {
        places[i] = {static_cast<uint32_t>(road[begin + i]), s_m[begin + i], t_m[begin + i]};
      }
      network->index.to_world(std::span(places).first(block), std::span(found).first(block));
      for (size_t i = 0; i < block; ++i) poses[begin + i] = to_c(found[i]);
    }
    return ROADGEN_OK;
  });
}

roadgen_status roadgen_renderer_create(const roadgen_network* network, const char* dem_path, roadgen_context context,
                                       roadgen_renderer** renderer) {
  if (!network || !renderer) return fail(ROADGEN_USAGE_ERROR, "a pointer is NULL");
  *renderer = nullptr;
  if (context < ROADGEN_CONTEXT_OSMESA || context > ROADGEN_CONTEXT_WINDOW) {
    return fail(ROADGEN_USAGE_ERROR, "there is no such kind of context");
  }
  return guarded([&] {
    std::optional<roadgen::Elevation> elevation;
    if (dem_path) {
      auto opened = roadgen::Elevation::open(dem_path);
      if (!opened) return fail(opened.error());
      elevation.emplace(std::move(*opened));
    }
    auto terrain = roadgen::Terrain::build(network->network, elevation ? &*elevation : nullptr);
    if (!terrain) return fail(terrain.error());

    auto made = std::make_unique<roadgen_renderer>();
    const auto kind = static_cast<roadgen::ContextKind>(context);
    auto opened = roadgen::Context::create({.kind = kind, .visible = false});
    if (!opened) return fail(opened.error());
    made->context = std::move(*opened);
    auto drawn_by = roadgen::Renderer::create(*made->context);
    if (!drawn_by) return fail(drawn_by.error());
    made->renderer.emplace(std::move(*drawn_by));
    if (auto s = made->renderer->load_roads(network->network); !s) return fail(s.error());
    if (auto s = made->renderer->load_ground(terrain->ground()); !s) return fail(s.error());
    made->terrain.emplace(std::move(*terrain));
    *renderer = made.release();
    return ROADGEN_OK;
  });
}

void roadgen_renderer_free(roadgen_renderer* renderer) { delete renderer; }

roadgen_status roadgen_set_camera(roadgen_renderer* renderer, const roadgen_camera* camera) {
  if (!renderer || !camera) return fail(ROADGEN_USAGE_ERROR, "a pointer is NULL");
  renderer->camera.position_m = {camera->position_m[0], camera->position_m[1], camera->position_m[2]};
  renderer->camera.yaw_deg = camera->yaw_deg;
  renderer->camera.pitch_deg = camera->pitch_deg;
  renderer->camera.roll_deg = camera->roll_deg;
  renderer->camera.fov_deg = camera->fov_deg;
  renderer->camera.far_m = camera->far_m > 0 ? camera->far_m : std::numeric_limits<double>::infinity();
  return ROADGEN_OK;
}

roadgen_status roadgen_set_props(roadgen_renderer* renderer, const roadgen_network* network, const char* path,
                                 const char* json) {
  if (!renderer) return fail(ROADGEN_USAGE_ERROR, "renderer must not be NULL");
  return guarded([&] {
    roadgen::SceneFile file;
    if (path || json) {
      auto read = json ? roadgen::parse_scene(json, path ? path : "props.json") : roadgen::read_scene(path);
      if (!read) return fail(read.error());
      file = std::move(*read);
    }
    if (!file.placements.empty()) {
      if (!network) return fail(ROADGEN_USAGE_ERROR, "network must not be NULL: objects stand on its roads");
      if (auto s = roadgen::place_on_roads(file.placements, network->index, file.scene); !s) return fail(s.error());
      roadgen::stand_on_ground(file.placements, network->index, *renderer->terrain, file.scene);
    }
    if (auto s = renderer->renderer->load_objects(file.scene); !s) return fail(s.error());
    return ROADGEN_OK;
  });
}

roadgen_status roadgen_set_environment(roadgen_renderer* renderer, const char* path) {
  if (!renderer || !path) return fail(ROADGEN_USAGE_ERROR, "a pointer is NULL");
  return guarded([&] {
    const auto panorama = roadgen::read_panorama(path);
    if (!panorama) return fail(panorama.error());
    if (auto s = renderer->renderer->load_environment(*panorama); !s) return fail(s.error());
    return ROADGEN_OK;
  });
}

roadgen_status roadgen_render(roadgen_renderer* renderer, int width, int height, uint8_t* color, float* depth_m) {
  if (!renderer) return fail(ROADGEN_USAGE_ERROR, "renderer must not be NULL");
  return guarded([&] {
    const unsigned channels = (color ? roadgen::kColor : 0u) | (depth_m ? roadgen::kDepth : 0u);
    auto frame = renderer->renderer->render(renderer->camera, {.width = width, .height = height, .channels = channels});
    if (!frame) return fail(frame.error());
    std::copy(frame->color.pixels.begin(), frame->color.pixels.end(), color);
    std::copy(frame->depth_m.pixels.begin(), frame->depth_m.pixels.end(), depth_m);
    return ROADGEN_OK;
  });
}
