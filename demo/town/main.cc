// Builds the town, its ground and four pictures of it: the C++ interface from roads to PNG, without a file in between.
// PREFIX.xodr holds the same town, for `roadgen render` and for other programs.
//   town PREFIX     writes PREFIX.xodr, PREFIX.crossing.png, PREFIX.bend.png, PREFIX.tunnel.png, PREFIX.kerb.png
#include <cstdio>
#include <string>

#include "demo/town/town.h"
#include "roadgen/export/opendrive.h"
#include "roadgen/render/renderer.h"
#include "terrain/terrain.h"

namespace {

struct View {
  const char* name;
  roadgen::Camera camera;
};

const View kViews[] = {
    {"crossing", {.position_m = {-45, -40, 22}, .yaw_deg = 45, .pitch_deg = -25, .fov_deg = 60}},
    {"bend", {.position_m = {210, 22, 5}, .yaw_deg = 40, .pitch_deg = -6, .fov_deg = 60}},
    {"tunnel", {.position_m = {21, -110, 0}, .yaw_deg = 100, .pitch_deg = 2, .fov_deg = 60}},
    {"kerb", {.position_m = {-30, -12.4, 1.8}, .yaw_deg = 22, .pitch_deg = -12, .fov_deg = 60}},
};

int fail(const roadgen::Error& error) {
  std::fprintf(stderr, "town: error: %s\n", error.text().c_str());
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: town PREFIX\n");
    return 2;
  }
  const auto network = roadgen::demo::town();
  if (!network) return fail(network.error());
  for (const std::string& problem : roadgen::check(*network).problems) std::fprintf(stderr, "%s\n", problem.c_str());
  const std::string file = std::string(argv[1]) + ".xodr";
  if (const auto status = roadgen::write_opendrive(*network, file); !status) return fail(status.error());
  std::printf("%s\n", file.c_str());
  const auto ground = roadgen::Terrain::build(*network, nullptr);
  if (!ground) return fail(ground.error());
  auto context = roadgen::Context::create({.kind = roadgen::ContextKind::kOsmesa});
  if (!context) return fail(context.error());
  auto renderer = roadgen::Renderer::create(**context);
  if (!renderer) return fail(renderer.error());
  if (const auto status = renderer->load_roads(*network); !status) return fail(status.error());
  if (const auto status = renderer->load_ground(ground->tiles()); !status) return fail(status.error());
  for (const View& view : kViews) {
    const auto frame = renderer->render(view.camera, {.width = 960, .height = 600});
    if (!frame) return fail(frame.error());
    const std::string path = std::string(argv[1]) + "." + view.name + ".png";
    if (const auto status = roadgen::write_png(path, frame->color); !status) return fail(status.error());
    std::printf("%s\n", path.c_str());
  }
  return 0;
}
