#include "roadgen/cli/scene.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

#include <CLI/CLI.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/import/scene_file.h"
#include "roadgen/query/road_index.h"
#include "roadgen/render/panorama.h"
#include "roadgen/render/placement.h"
#include "terrain/terrain.h"
#include "terrain/terrain_file.h"

namespace roadgen::cli {

void add_scene_options(CLI::App& app, SceneOptions& options) {
  app.add_option("NET", options.network_path, "OpenDRIVE file")->required();
  app.add_option("--dem", options.dem.path,
                 "Elevation: SRTM .hgt (also zipped), GeoTIFF or ASCII grid. Default: the roads' own heights");
  add_elevation_options(app, options.dem);
  add_levelling_options(app, options.levelling);
  app.add_option("--max-triangles", options.max_triangles,
                 "The ground gets coarser, but not under roads, until it has no more triangles")
      ->capture_default_str();
  app.add_option(
      "--ground-cache", options.ground_cache_path,
      "File that keeps the ground for the next time; written where it is missing, of other inputs or damaged");
  app.add_option("--scene", options.props_path, "Scene file of objects, props.json: see README. Default: none");
  app.add_option("--environment", options.environment_path,
                 "Panorama, .exr or .hdr, that objects mirror and that is the sky. Default: the procedural sky");
  app.add_option(
      "--ground-texture", options.ground_textures,
      "grass=FILE, rock=FILE or gravel=FILE: a picture of 4 m x 4 m that shows the ground there. May be given "
      "several times");
  app.add_option("--context", options.context, "osmesa, egl or window. Default: osmesa");
  app.add_option("--egl-device", options.egl_device, "Index of the EGL device. Default: the surfaceless display");
}

namespace {

struct MaterialPicture {
  GroundMaterial material;
  Image8 picture;
};

// "grass=FILE", read. Errors: kUsage for another material; as read_image8.
Result<MaterialPicture> read_texture(const std::string& text) {
  const std::size_t at = text.find('=');
  const std::string material = text.substr(0, at);
  constexpr std::pair<const char*, GroundMaterial> kNames[] = {
      {"grass", GroundMaterial::kGrass}, {"rock", GroundMaterial::kRock}, {"gravel", GroundMaterial::kGravel}};
  for (const auto& [name, value] : kNames) {
    if (material != name || at == text.npos) continue;
    auto picture = read_image8(text.substr(at + 1));
    if (!picture) return picture.error();
    return MaterialPicture{value, std::move(*picture)};
  }
  return Error{ErrorCode::kUsage, "--ground-texture '" + text + "': expected grass=FILE, rock=FILE or gravel=FILE"};
}

// From the cache where that holds it; else built, and kept there.
Result<Terrain> ground_of(const SceneOptions& options, const Network& network, const Elevation* elevation,
                          const TerrainOptions& terrain_options) {
  if (options.ground_cache_path.empty()) return Terrain::build(network, elevation, terrain_options);
  if (Status s = check_writable(options.ground_cache_path); !s) return s.error();
  std::ifstream file(options.network_path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::uint64_t key = terrain_key(text, elevation, terrain_options);
  Result<Terrain> kept = read_terrain_file(options.ground_cache_path, key);
  if (kept) return kept;
  if (kept.error().code != ErrorCode::kIo) {
    std::fprintf(stderr, "info: %s: %s; built again\n", options.ground_cache_path.c_str(),
                 kept.error().message.c_str());
  }
  Result<Terrain> built = Terrain::build(network, elevation, terrain_options);
  if (!built) return built;
  if (Status s = write_terrain_file(*built, key, options.ground_cache_path); !s) return s.error();
  return built;
}

// The objects of the scene file, those with a place on a road on it.
Result<SceneFile> read_props(const std::string& path, const Network& network) {
  auto read = read_scene(path);
  if (read && !read->placements.empty()) {
    if (Status s = place_on_roads(read->placements, RoadIndex(network), read->scene); !s) return s.error();
  }
  return read;
}

}  // namespace

Result<Scene> open_scene(const SceneOptions& options, const Network& network) {
  Scene scene;
  const auto kind = context_kind_from_name(options.context);
  if (!kind) return kind.error();
  std::vector<MaterialPicture> textures;
  for (const std::string& text : options.ground_textures) {
    auto texture = read_texture(text);
    if (!texture) return texture.error();
    textures.push_back(std::move(*texture));
  }
  // Before the terrain, which takes longer and needs no context.
  std::optional<SceneFile> props;
  if (!options.props_path.empty()) {
    auto read = read_props(options.props_path, network);
    if (!read) return read.error();
    props.emplace(std::move(*read));
  }
  std::optional<ImageF> panorama;
  if (!options.environment_path.empty()) {
    auto read = read_panorama(options.environment_path);
    if (!read) return read.error();
    panorama.emplace(std::move(*read));
  }
  auto context = Context::create({.kind = *kind,
                                  .egl_device = options.egl_device,
                                  .width = options.width,
                                  .height = options.height,
                                  .visible = options.visible});
  if (!context) return context.error();
  scene.context = std::move(*context);

  Diagnostics diagnostics;
  std::optional<Elevation> elevation;
  if (!options.dem.path.empty()) {
    auto opened = open_elevation(options.dem, network, diagnostics);
    if (!opened) return opened.error();
    elevation.emplace(std::move(*opened));
  }
  ProgressLine progress;
  TerrainOptions terrain_options;
  terrain_options.levelling = options.levelling;
  terrain_options.max_triangles = options.max_triangles;
  terrain_options.progress = [&](double part) { progress.show(part, "terrain"); };
  const auto terrain = ground_of(options, network, elevation ? &*elevation : nullptr, terrain_options);
  progress.clear();
  print_diagnostics(diagnostics, "");
  if (!terrain) return terrain.error();

  auto renderer = Renderer::create(*scene.context);
  if (!renderer) return renderer.error();
  scene.renderer.emplace(std::move(*renderer));
  for (const MaterialPicture& texture : textures) {
    if (Status s = scene.renderer->set_ground_texture(texture.material, texture.picture); !s) return s.error();
  }
  if (Status s = scene.renderer->load_roads(network); !s) return s.error();
  if (Status s = scene.renderer->load_ground(terrain->ground()); !s) return s.error();
  if (props) {
    if (!props->placements.empty()) stand_on_ground(props->placements, RoadIndex(network), *terrain, props->scene);
    if (Status s = scene.renderer->load_objects(props->scene); !s) return s.error();
  }
  if (panorama) {
    if (Status s = scene.renderer->load_environment(*panorama); !s) return s.error();
  }
  const TerrainReport& report = terrain->report();
  std::fprintf(stderr, "terrain: %zu triangles, clearance under the roads %.3f to %.3f m, %zu voids filled, %.1f s\n",
               report.triangles, report.clearance_min_m, report.clearance_max_m, report.voids_filled, report.seconds);
  return scene;
}

Result<PictureSize> parse_size(const std::string& text) {
  PictureSize size{0, 0};
  const char* const end = text.data() + text.size();
  const auto [x, width_fault] = std::from_chars(text.data(), end, size.width);
  if (width_fault == std::errc() && x != end && *x == 'x') {
    const auto [rest, height_fault] = std::from_chars(x + 1, end, size.height);
    if (height_fault == std::errc() && rest == end && size.width > 0 && size.height > 0) return size;
  }
  return Error{ErrorCode::kUsage, "--size '" + text + "': expected WIDTHxHEIGHT in pixels, such as 1280x720"};
}

Result<std::vector<double>> parse_numbers(const std::string& text, std::size_t count, const std::string& what) {
  std::vector<double> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (numbers.size() < count) {
    double x = 0;
    const auto [rest, fault] = std::from_chars(at, end, x);
    if (fault != std::errc() || !std::isfinite(x)) break;
    numbers.push_back(x);
    at = rest;
    if (numbers.size() < count && (at == end || *at++ != ',')) break;
  }
  if (numbers.size() == count && at == end) return numbers;
  return Error{ErrorCode::kUsage,
               what + " '" + text + "': expected " + std::to_string(count) + " numbers with commas between"};
}

Result<const Road*> named_road(const Network& network, const std::string& id) {
  if (const Road* road = network.find_road(id)) return road;
  std::string known;
  for (std::size_t i = 0; i < network.roads.size() && i < 5; ++i) known += (i ? ", " : "") + network.roads[i].id;
  if (network.roads.size() > 5) known += ", ...";
  return Error{ErrorCode::kUsage, "there is no road '" + id + "' in the network; its roads are: " + known};
}

}  // namespace roadgen::cli
