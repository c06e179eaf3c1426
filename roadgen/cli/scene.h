// A network file as something to draw: what `render` and `fly` share.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "roadgen/cli/ground.h"
#include "roadgen/render/context.h"
#include "roadgen/render/renderer.h"
#include "roadgen/road/network.h"

namespace CLI {
class App;
}

namespace roadgen::cli {

struct SceneOptions {
  std::string network_path;
  ElevationRequest dem;  // no path: ground from the roads' own heights
  LevellingOptions levelling;
  std::size_t max_triangles = 400000;  // of the ground
  std::string ground_cache_path;       // empty: the ground is built every time
  std::string props_path;              // a scene file of objects; empty: none
  std::string environment_path;        // a panorama; empty: the procedural sky
  std::vector<std::string> ground_textures;
  std::string context = "osmesa";
  int egl_device = -1;
  int width = 1280, height = 720;
  bool visible = false;  // of a window
};

// Declares the options of SceneOptions that users give.
void add_scene_options(CLI::App& app, SceneOptions& options);

struct Scene {
  std::unique_ptr<Context> context;
  std::optional<Renderer> renderer;  // after the context: destroyed before it
};

// Opens the context, builds the terrain and loads both into a renderer; messages about the terrain on stderr.
// Errors: of any of the three; kUsage for an unknown context.
Result<Scene> open_scene(const SceneOptions& options, const Network& network);

// "1280x720" to two positive integers. Errors: kUsage.
struct PictureSize {
  int width, height;
};
Result<PictureSize> parse_size(const std::string& text);

// Numbers between commas, exactly `count` of them, finite. what names the option in the message. Errors: kUsage.
Result<std::vector<double>> parse_numbers(const std::string& text, std::size_t count, const std::string& what);

// The road that the user names, or an Error that lists a few that there are.
Result<const Road*> named_road(const Network& network, const std::string& id);

}  // namespace roadgen::cli
