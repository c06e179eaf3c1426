// The paper's Fig. 10, texture anisotropy, against the analytic filter: markings and wheel tracks of a road to the
// horizon from a texture at anisotropy 1, 2 and 4 (as GL_EXT_texture_filter_anisotropic describes it, and as the driver
// does), and by roadgen's integrals over the pixel. Edges and grain are the same functions in all. Error against 64 times
// supersampling, and time per frame.
//   build/release/bin/figure10_bench --out figure10.png    prints the table; writes the pictures, one below the other
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "roadgen/fit/catmull_rom.h"
#include "roadgen/render/flight.h"
#include "roadgen/render/render_target.h"
#include "roadgen/render/renderer.h"
#include "tests/bench/gpu_clock.h"
#include "tests/bench/road_mesh.h"

namespace roadgen::bench {
namespace {

constexpr int kWidth = 640, kHeight = 360, kSupersampling = 8, kRepeats = 9;
constexpr int kTexels = 1024;

// A level road of 3 km in long bends, and a plain under it.
Result<BaseScene> plain_scene() {
  std::vector<Anchor> anchors;
  for (double x = 0; x <= 3000; x += 60) anchors.push_back({.position_m = {x, 40 * std::sin(x / 350)}});
  auto road = road_from_anchors(anchors, {});
  if (!road) return road.error();
  TerrainMesh ground;
  ground.positions_m = {{-500, -3000, -0.1f}, {6000, -3000, -0.1f}, {6000, 3000, -0.1f}, {-500, 3000, -0.1f}};
  ground.normals.assign(4, {0, 0, 1});
  ground.triangles = {0, 1, 2, 0, 2, 3};
  return BaseScene{std::move(*road), std::move(ground)};
}

// One period of the section's markings along s, its whole width across: paint and wear, each texel's mean.
struct Markings {
  double length_m, width_m;
  std::vector<std::uint8_t> texels;  // two bytes each
};

Markings bake(const LaneSection& section) {
  const std::vector<Cubic> borders = section.borders_m();
  Markings m{section.center_mark.on_m + section.center_mark.off_m, borders.back().c0 - borders.front().c0, {}};
  const double ds = m.length_m / kTexels, dt = m.width_m / kTexels;
  for (int j = 0; j < kTexels; ++j) {
    for (int i = 0; i < kTexels; ++i) {
      const double s = (i + 0.5) * ds, t = (j + 0.5) * dt - 0.5 * m.width_m;
      double paint = 0, wear = 0;
      for (std::size_t k = 0; k < borders.size(); ++k) {
        const std::size_t right = section.right.size();
        const Mark& mark = k < right ? section.right[right - 1 - k].mark
                                     : (k == right ? section.center_mark : section.left[k - right - 1].mark);
        if (mark.kind != MarkKind::kNone) {
          paint += Lib::marking_border(static_cast<int>(mark.kind), t - borders[k].c0, s, mark.width_m, mark.space_m,
                                       mark.on_m, mark.off_m, 0.0, dt, ds, 0.0, 0.0, 0.0);
        }
        if (k + 1 == borders.size() || t < borders[k].c0 || t >= borders[k + 1].c0) continue;
        const Lane& lane = k < right ? section.right[right - 1 - k] : section.left[k - right];
        const double off = std::abs(t - 0.5 * (borders[k].c0 + borders[k + 1].c0)) - 0.8;
        if (lane.type == LaneType::kDriving) wear = std::exp(-6 * off * off);
      }
      m.texels.push_back(static_cast<std::uint8_t>(std::lround(255 * std::min(paint, 1.0))));
      m.texels.push_back(static_cast<std::uint8_t>(std::lround(255 * wear)));
    }
  }
  return m;
}

gl::Texture upload(const Markings& markings) {
  gl::Texture texture = gl::Texture::image_2d(GL_RG8, kTexels, kTexels, 11);
  glTextureSubImage2D(texture.id(), 0, 0, 0, kTexels, kTexels, GL_RG, GL_UNSIGNED_BYTE, markings.texels.data());
  glGenerateTextureMipmap(texture.id());
  glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

double linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}
double encoded(double light) { return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055; }

// Means of squares of kSupersampling pixels, as light.
Image8 shrunk(const Image8& fine) {
  Image8 image(kWidth, kHeight, 4);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (int i = 0; i < kSupersampling * kSupersampling; ++i) {
          sum += linear(fine.at(x * kSupersampling + i % kSupersampling, y * kSupersampling + i / kSupersampling, c) /
                        255.0);
        }
        const double mean = sum / (kSupersampling * kSupersampling);
        image.at(x, y, c) = static_cast<std::uint8_t>(std::lround(255 * encoded(mean)));
      }
    }
  }
  return image;
}

// Over the pixels of the road, in 1/255.
struct Errors {
  double rms, percentile;
};
Errors errors(const Image8& image, const Image8& truth, const Image<std::uint32_t>& label) {
  std::vector<double> all;
  double sum = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (label.at(x, y, 0) < static_cast<std::uint32_t>(Label::kCarriageway)) continue;
      for (int c = 0; c < 3; ++c) {
        all.push_back(std::abs(image.at(x, y, c) - truth.at(x, y, c)));
        sum += all.back() * all.back();
      }
    }
  }
  std::sort(all.begin(), all.end());
  return {std::sqrt(sum / static_cast<double>(all.size())),
          all[static_cast<std::size_t>(0.999 * static_cast<double>(all.size() - 1))]};
}

// A part below the horizon, magnified, of every picture in turn.
Image8 strip(const std::vector<Image8>& pictures, int x0, int y0) {
  constexpr int kCutWidth = 200, kCutHeight = 36, kScale = 4, kGap = 4;
  Image8 all(kCutWidth * kScale, static_cast<int>(pictures.size()) * (kCutHeight * kScale + kGap) - kGap, 3);
  std::fill(all.pixels.begin(), all.pixels.end(), 255);
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (int y = 0; y < kCutHeight * kScale; ++y) {
      for (int x = 0; x < kCutWidth * kScale; ++x) {
        for (int c = 0; c < 3; ++c) {
          all.at(x, static_cast<int>(i) * (kCutHeight * kScale + kGap) + y, c) =
              pictures[i].at(x0 + x / kScale, y0 + y / kScale, c);
        }
      }
    }
  }
  return all;
}

Status run(const std::string& context_name, int device, Clock clock, const std::string& out) {
  const auto kind = context_kind_from_name(context_name);
  if (!kind) return kind.error();
  auto context = Context::create({.kind = *kind, .egl_device = device});
  if (!context) return context.error();
  auto scene = plain_scene();
  if (!scene) return scene.error();
  const glm::dvec3 origin(0);
  auto renderer = Renderer::create(**context);
  if (!renderer) return renderer.error();
  if (Status s = renderer->load_roads(copies_of(scene->road, {&origin, 1})); !s) return s;
  if (Status s = renderer->load_ground({&scene->ground, 1}); !s) return s;
  auto mesh = MeshScene::create(*scene, {&origin, 1}, "road_texture.frag");
  if (!mesh) return mesh.error();
  auto probed = MeshScene::create(*scene, {&origin, 1}, "road_texture.frag", {{"PROBES", ""}});
  if (!probed) return probed.error();
  const Markings markings = bake(scene->road.sections.front());
  const gl::Texture texture = upload(markings);
  glBindTextureUnit(0, texture.id());
  auto shown = RenderTarget::create({kWidth, kHeight, {GL_SRGB8_ALPHA8}, 0, 1});
  if (!shown) return shown.error();

  Camera camera = drive_camera(scene->road, 50, -1.75, 1.3);
  camera.pitch_deg -= 4;
  camera.fov_deg = 45;
  const auto data = renderer->render(camera, {.width = kWidth, .height = kHeight, .channels = kLabel});
  if (!data) return data.error();
  const auto fine = renderer->render(
      camera, {.width = kWidth * kSupersampling, .height = kHeight * kSupersampling, .channels = kColor, .samples = 1});
  if (!fine) return fine.error();
  const Image8 truth = shrunk(fine->color);

  // The mesh takes the frame's uniforms from the Renderer's last draw, which was larger.
  if (Status s = renderer->draw(camera, kWidth, kHeight, 1, shown->framebuffer()); !s) return s;
  struct Filter {
    std::string name;
    MeshScene* scene;  // null: the analytic one
    int anisotropy;
  };
  std::vector<Filter> filters;
  for (const int level : {1, 2, 4}) filters.push_back({fmt::format("anisotropy {}", level), &*probed, level});
  for (const int level : {1, 2, 4})
    filters.push_back({fmt::format("anisotropy {}, the driver's", level), &*mesh, level});
  filters.push_back({"analytic", nullptr, 1});
  std::vector<std::vector<double>> times(filters.size());
  std::vector<Image8> pictures(filters.size());
  for (int repeat = -1; repeat < kRepeats; ++repeat) {
    for (std::size_t i = 0; i < filters.size(); ++i) {
      MeshScene* textured = filters[i].scene;
      if (textured) {
        const bool by_driver = textured == &*mesh;
        glTextureParameterf(texture.id(), GL_TEXTURE_MAX_ANISOTROPY_EXT,
                            by_driver ? static_cast<float>(filters[i].anisotropy) : 1.0f);
        textured->set_texture({markings.length_m, markings.width_m}, filters[i].anisotropy);
      }
      Status status = Done{};
      const double time = milliseconds(**context, clock, [&] {
        status = textured
                     ? textured->draw(camera, kWidth, kHeight, 1, shown->framebuffer(), {MeshMethod::kTurn, 0, false})
                     : renderer->draw(camera, kWidth, kHeight, 1, shown->framebuffer());
      });
      if (!status) return status;
      if (repeat >= 0) times[i].push_back(time);
      pictures[i] = shown->read_rgba8();
    }
  }
  std::printf("%s, %dx%d\n\n| filter | RMS /255 | 99.9 %% /255 | ms per frame |\n|---|---|---|---|\n",
              (*context)->renderer().c_str(), kWidth, kHeight);
  for (std::size_t i = 0; i < filters.size(); ++i) {
    const Errors e = errors(pictures[i], truth, data->label);
    std::printf("| %s | %.2f | %.0f | %.1f |\n", filters[i].name.c_str(), e.rms, e.percentile, median(times[i]));
  }
  if (out.empty()) return Done{};
  return write_png(out, strip({pictures[0], pictures[1], pictures[2], pictures.back(), truth}, (kWidth - 200) / 2,
                              kHeight / 2 - 32));
}

}  // namespace
}  // namespace roadgen::bench

int main(int argc, char** argv) {
  using roadgen::bench::Clock;
  std::string context = "osmesa", out;
  int device = -1;
  Clock clock = Clock::kWall;
  CLI::App app("Filtering of markings toward the horizon: texture anisotropy against roadgen's analytic filter");
  const std::map<std::string, Clock> clocks = {{"wall", Clock::kWall}, {"process", Clock::kProcess}};
  app.add_option("--clock", clock, "wall, or process: the CPU time of all threads; where the CPU draws")
      ->transform(CLI::CheckedTransformer(clocks));
  app.add_option("--context", context, "osmesa, egl or window");
  app.add_option("--device", device, "EGL device");
  app.add_option("--out", out, "Writes the pictures to this PNG: anisotropy 1, 2, 4, analytic, supersampled");
  CLI11_PARSE(app, argc, argv);
  const roadgen::Status status = roadgen::bench::run(context, device, clock, out);
  if (!status) std::fprintf(stderr, "figure10_bench: %s\n", status.error().text().c_str());
  return status ? 0 : 1;
}
