// roadgen render: one camera, its channels as files.
#include <algorithm>
#include <cstdio>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/cli/scene.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/render/flight.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen render";

struct RenderOptions {
  SceneOptions scene;
  std::string camera, follow, size = "1280x720", prefix;
  std::vector<std::string> channels = {"color"};
  double fov_deg = 50;
};

struct ChannelName {
  const char* name;
  Channel bit;
};
constexpr ChannelName kChannelNames[] = {{"color", kColor},       {"depth", kDepth},   {"label", kLabel},
                                         {"instance", kInstance}, {"normal", kNormal}, {"road", kRoad}};

Result<unsigned> parse_channels(const std::vector<std::string>& names) {
  unsigned bits = 0;
  for (const std::string& name : names) {
    unsigned bit = 0;
    for (const ChannelName& known : kChannelNames) bit |= name == known.name ? known.bit : 0u;
    if (bit == 0) {
      return Error{ErrorCode::kUsage,
                   "--channels '" + name + "': the channels are color, depth, label, instance, normal and road"};
    }
    bits |= bit;
  }
  return bits;
}

Result<Camera> find_camera(const RenderOptions& options, const Network& network) {
  Camera camera;
  if (!options.camera.empty()) {
    const auto n = parse_numbers(options.camera, 6, "--camera");
    if (!n) return n.error();
    camera = {{(*n)[0], (*n)[1], (*n)[2]}, (*n)[3], (*n)[4], (*n)[5]};
  } else {
    const std::size_t comma = options.follow.find(',');
    if (comma == std::string::npos) return Error{ErrorCode::kUsage, "--follow: expected ROAD,S,T,H"};
    const auto road = named_road(network, options.follow.substr(0, comma));
    if (!road) return road.error();
    const auto n = parse_numbers(options.follow.substr(comma + 1), 3, "--follow ROAD,");
    if (!n) return n.error();
    camera = drive_camera(**road, (*n)[0], (*n)[1], (*n)[2]);
  }
  camera.fov_deg = options.fov_deg;
  if (Status s = check_camera(camera); !s) return s.error();
  return camera;
}

ImageF as_float(const Image<std::uint32_t>& image, const char* name) {
  ImageF out(image.width, image.height, 1);
  out.channel_names = {name};
  std::copy(image.pixels.begin(), image.pixels.end(), out.pixels.begin());
  return out;
}

ImageF named(ImageF image, std::vector<std::string> names) {
  image.channel_names = std::move(names);
  return image;
}

// Writes every channel that the frame has; the names of the files go to `files`.
Status write_channels(const Frame& frame, const std::string& prefix, nlohmann::json& files) {
  const auto exr = [&](const char* channel, const ImageF& image) -> Status {
    if (image.pixels.empty()) return Done{};
    const std::string path = prefix + "." + channel + ".exr";
    files[channel] = path;
    return write_exr(path, image);
  };
  if (!frame.color.pixels.empty()) {
    files["color"] = prefix + ".color.png";
    if (Status s = write_png(prefix + ".color.png", frame.color); !s) return s;
  }
  if (Status s = exr("depth", named(frame.depth_m, {"Z"})); !s) return s;
  if (Status s = exr("label", as_float(frame.label, "label")); !s) return s;
  if (Status s = exr("instance", as_float(frame.instance, "instance")); !s) return s;
  if (Status s = exr("normal", named(frame.normal, {"X", "Y", "Z"})); !s) return s;
  return exr("road", named(frame.road, {"road", "s", "t", "lane"}));
}

Status render(const RenderOptions& options) {
  const auto size = parse_size(options.size);
  if (!size) return size.error();
  const auto channels = parse_channels(options.channels);
  if (!channels) return channels.error();
  if (options.camera.empty() == options.follow.empty()) {
    return Error{ErrorCode::kUsage, "give either --camera X,Y,Z,YAW,PITCH,ROLL or --follow ROAD,S,T,H"};
  }
  // Before the work, not after it.
  if (Status s = check_writable(options.prefix + ".color.png"); !s) return s;
  const auto network = read_opendrive(options.scene.network_path);
  if (!network) return network.error();
  const auto camera = find_camera(options, *network);
  if (!camera) return camera.error();
  auto scene = open_scene(options.scene, *network);
  if (!scene) return scene.error();
  const auto frame =
      scene->renderer->render(*camera, {.width = size->width, .height = size->height, .channels = *channels});
  if (!frame) return frame.error();

  nlohmann::json report;
  report["camera"] = {{"position_m", {camera->position_m.x, camera->position_m.y, camera->position_m.z}},
                      {"yaw_deg", camera->yaw_deg},
                      {"pitch_deg", camera->pitch_deg},
                      {"roll_deg", camera->roll_deg},
                      {"fov_deg", camera->fov_deg}};
  report["size"] = {size->width, size->height};
  report["renderer"] = scene->context->renderer();
  if (Status s = write_channels(*frame, options.prefix, report["files"]); !s) return s;
  return put_out(report.dump(2) + "\n", "");
}

}  // namespace

int run_render(const Arguments& arguments) {
  RenderOptions options;
  CLI::App app("Renders one camera: picture, depth, labels, normals and road coordinates.", kName);
  add_scene_options(app, options.scene);
  app.add_option("--camera", options.camera, "X,Y,Z,YAW,PITCH,ROLL: ENU metres, degrees");
  app.add_option("--follow", options.follow, "ROAD,S,T,H: on road ROAD at s, t, H metres above it, looking along it");
  app.add_option("--size", options.size, "WIDTHxHEIGHT in pixels. Default: 1280x720");
  app.add_option("--fov", options.fov_deg, "Vertical field of view in degrees, (0, 170]. Default: 50");
  app.add_option("--channels", options.channels, "color,depth,label,instance,normal,road. Default: color")
      ->delimiter(',');
  app.add_option("-o,--output", options.prefix, "PREFIX of the files: PREFIX.color.png, PREFIX.depth.exr, ...")
      ->required();
  if (const auto code = parse(app, arguments)) return *code;
  if (Status status = render(options); !status) return fail(kName, status.error());
  return kExitDone;
}

}  // namespace roadgen::cli
