// The paper's Fig. 13: time per frame of cookie-cut roads, of tessellated ones and of the ground alone, from one copy of
// the base scene to 25 x 25.
//   build/release/bin/figure13_bench --out figure13       writes figure13.svg, figure13.csv; prints the table
//   ffmpeg -i figure13.svg figure13.png
// Every method of a row is measured in turn, again and again, so that what else the machine does meets all alike.
#include <cstdio>
#include <fstream>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "roadgen/render/render_target.h"
#include "roadgen/render/renderer.h"
#include "tests/bench/gpu_clock.h"
#include "tests/bench/plot.h"
#include "tests/bench/road_mesh.h"

namespace roadgen::bench {
namespace {

constexpr int kWidth = 1280, kHeight = 1024;

struct Options {
  std::vector<int> sizes = {1, 3, 5, 9, 13, 19, 25};
  int views = 4, repeats = 5, samples = 4, device = -1;
  double hills_m = 6;
  Clock clock = Clock::kWall;
  std::string context = "osmesa", out = {};
};

struct Method {
  std::string name;
  bool cookie_cut;
  MeshMethod mesh;      // culling holds for both
  bool single = false;  // one copy, whatever the row: what this machine does at that time
};

std::vector<Method> methods() {
  std::vector<Method> list = {{"cookie-cut", true, {}}};
  for (int turn = 0; turn < kPaperTurns; ++turn) {
    list.push_back({fmt::format("{:g} degree{}", kTurns_deg[turn], kTurns_deg[turn] == 1 ? "" : "s"),
                    false,
                    {MeshMethod::kTurn, turn, false}});
  }
  list.push_back({"ground alone", false, {}});
  list.push_back({"cookie-cut, culled", true, {MeshMethod::kNoRoad, 0, true}});
  list.push_back({"1 degree, culled", false, {MeshMethod::kTurn, 0, true}});
  list.push_back({"level of detail, culled", false, {MeshMethod::kLevelOfDetail, 0, true}});
  list.push_back({"one copy, cookie-cut, culled", true, {MeshMethod::kNoRoad, 0, true}, true});
  return list;
}

Result<Renderer> loaded_renderer(Context& context, const BaseScene& scene, std::span<const glm::dvec3> origins,
                                 bool cull) {
  auto renderer = Renderer::create(context, {.least_contribution = 0, .cull = cull});
  if (!renderer) return renderer.error();
  if (Status s = renderer->load_roads(copies_of(scene.road, origins)); !s) return s.error();
  if (Status s = renderer->load_ground(copies_of(scene.ground, origins)); !s) return s.error();
  return renderer;
}

// Milliseconds of every method: the mean over the views of the medians over the repeats.
Result<std::vector<double>> measure(Context& context, const BaseScene& scene, int n, const Options& options,
                                    unsigned target) {
  const std::vector<glm::dvec3> origins = copy_origins(n);
  auto whole = loaded_renderer(context, scene, origins, false);
  if (!whole) return whole.error();
  auto culled = loaded_renderer(context, scene, origins, true);
  if (!culled) return culled.error();
  auto single = loaded_renderer(context, scene, copy_origins(1), true);
  if (!single) return single.error();
  auto mesh = MeshScene::create(scene, origins);
  if (!mesh) return mesh.error();
  const std::vector<Method> all = methods();
  const std::vector<Camera> cameras = views(scene, options.views);
  std::vector<double> means(all.size());
  for (const Camera& camera : cameras) {
    std::vector<std::vector<double>> times(all.size());
    for (int repeat = -1; repeat < options.repeats; ++repeat) {  // the first warms up
      for (std::size_t i = 0; i < all.size(); ++i) {
        Status status = Done{};
        const double time = milliseconds(context, options.clock, [&] {
          Renderer& renderer = all[i].single ? *single : (all[i].mesh.culling ? *culled : *whole);
          status = all[i].cookie_cut ? renderer.draw(camera, kWidth, kHeight, options.samples, target)
                                     : mesh->draw(camera, kWidth, kHeight, options.samples, target, all[i].mesh);
        });
        if (!status) return status.error();
        if (repeat >= 0) times[i].push_back(time);
      }
    }
    for (std::size_t i = 0; i < all.size(); ++i) means[i] += median(times[i]) / static_cast<double>(cameras.size());
  }
  return means;
}

// Both ways draw the same roads: prints how far the pictures of cookie-cut roads and of the finest tessellation differ.
Status compare_pictures(Context& context, const BaseScene& scene, const Options& options, const RenderTarget& shown) {
  const std::vector<glm::dvec3> origins = copy_origins(1);
  auto renderer = loaded_renderer(context, scene, origins, true);
  if (!renderer) return renderer.error();
  auto mesh = MeshScene::create(scene, origins);
  if (!mesh) return mesh.error();
  const MeshMethod finest{MeshMethod::kTurn, static_cast<int>(std::size(kTurns_deg)) - 1, false};
  int index = 0;
  for (const Camera& camera : views(scene, options.views)) {
    if (Status s = renderer->draw(camera, kWidth, kHeight, options.samples, shown.framebuffer()); !s) return s;
    const Image8 cut = shown.read_rgba8();
    if (Status s = mesh->draw(camera, kWidth, kHeight, options.samples, shown.framebuffer(), finest); !s) return s;
    const Image8 tessellated = shown.read_rgba8();
    const auto difference = compare(cut, tessellated);
    if (!difference) return difference.error();
    std::printf("view %d: cookie-cut and %g degrees differ by %.3f/255 in the mean\n", index, kTurns_deg[finest.turn],
                difference->mean);
    if (!options.out.empty()) {
      if (Status s = write_png(fmt::format("{}.view{}.cut.png", options.out, index), cut); !s) return s;
      if (Status s = write_png(fmt::format("{}.view{}.mesh.png", options.out, index), tessellated); !s) return s;
    }
    ++index;
  }
  return Done{};
}

Status run(const Options& options) {
  const auto kind = context_kind_from_name(options.context);
  if (!kind) return kind.error();
  auto context = Context::create({.kind = *kind, .egl_device = options.device, .width = kWidth, .height = kHeight});
  if (!context) return context.error();
  auto scene = base_scene(options.hills_m);
  if (!scene) return scene.error();
  auto shown = RenderTarget::create({kWidth, kHeight, {GL_SRGB8_ALPHA8}, 0, 1});
  if (!shown) return shown.error();
  const std::vector<Method> all = methods();
  const auto mesh = MeshScene::create(*scene, copy_origins(1));
  if (!mesh) return mesh.error();
  std::printf(
      "%s, %dx%d, %d samples, %d views; %zu segments, %.0f m of road, %zu triangles of ground; triangles of road:",
      (*context)->renderer().c_str(), kWidth, kHeight, options.samples, options.views, scene->road.segments.size(),
      scene->road.length_m(), scene->ground.triangles.size() / 3);
  for (int turn = 0; turn < kPaperTurns; ++turn) std::printf(" %zu", mesh->triangles(turn));
  std::printf("\n");
  if (Status s = compare_pictures(**context, *scene, options, *shown); !s) return s;
  std::string header = "| copies |", rule = "|---|", csv = "copies";
  for (const Method& method : all) header += " " + method.name + " |", rule += "---|", csv += "," + method.name;
  std::printf("\nms per frame\n\n%s\n%s\n", header.c_str(), rule.c_str());
  std::vector<Curve> curves;
  for (const Method& method : all) curves.push_back({method.name, {}, {}, method.mesh.culling});
  for (const int n : options.sizes) {
    const auto times = measure(**context, *scene, n, options, shown->framebuffer());
    if (!times) return times.error();
    std::string row = fmt::format("| {0}x{0} |", n);
    csv += fmt::format("\n{}", n * n);
    for (std::size_t i = 0; i < all.size(); ++i) {
      row += fmt::format(" {:.1f} |", (*times)[i]);
      csv += fmt::format(",{:.3f}", (*times)[i]);
      curves[i].x.push_back(n * n);
      curves[i].y.push_back((*times)[i]);
    }
    const auto ratio = [&](std::size_t i, std::size_t j) { return (*times)[i] / (*times)[j]; };
    const std::size_t culled = kPaperTurns + 2;
    std::printf("%s  cookie-cut / 1 degree %.2f; culled / level of detail %.2f, / one copy %.2f\n", row.c_str(),
                ratio(0, 1), ratio(culled, culled + 2), ratio(culled, culled + 3));
    std::fflush(stdout);
  }
  if (options.out.empty()) return Done{};
  std::ofstream(options.out + ".csv") << csv << '\n';
  std::ofstream(options.out + ".svg") << log_log_svg(fmt::format("Time per frame, {}", (*context)->renderer()),
                                                     "copies of the base scene", "ms per frame", curves);
  return Done{};
}

}  // namespace
}  // namespace roadgen::bench

int main(int argc, char** argv) {
  roadgen::bench::Options options;
  CLI::App app("Time per frame against the size of the scene: cookie-cut and tessellated roads");
  app.add_option("--sizes", options.sizes, "Copies along each side, odd")->delimiter(',');
  app.add_option("--views", options.views, "Cameras to take the mean of");
  app.add_option("--repeats", options.repeats, "Measurements of each to take the median of");
  app.add_option("--samples", options.samples, "Per pixel: 1 or 4");
  app.add_option("--hills", options.hills_m, "Amplitude of the ground's waves, m; 0 makes roads of plane segments");
  const std::map<std::string, roadgen::bench::Clock> clocks = {{"wall", roadgen::bench::Clock::kWall},
                                                               {"process", roadgen::bench::Clock::kProcess}};
  app.add_option("--clock", options.clock, "wall, or process: the CPU time of all threads; where the CPU draws")
      ->transform(CLI::CheckedTransformer(clocks));
  app.add_option("--context", options.context, "osmesa, egl or window");
  app.add_option("--device", options.device, "EGL device");
  app.add_option("--out", options.out, "Writes OUT.csv and OUT.svg");
  CLI11_PARSE(app, argc, argv);
  const roadgen::Status status = roadgen::bench::run(options);
  if (!status) std::fprintf(stderr, "figure13_bench: %s\n", status.error().text().c_str());
  return status ? 0 : 1;
}
