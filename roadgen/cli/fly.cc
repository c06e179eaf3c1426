// roadgen fly: along a road, as a video or single pictures, with a contact sheet.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "roadgen/cli/command.h"
#include "roadgen/cli/scene.h"
#include "roadgen/cli/video.h"
#include "roadgen/export/atomic_file.h"
#include "roadgen/import/opendrive.h"
#include "roadgen/render/flight.h"

namespace roadgen::cli {
namespace {

constexpr const char* kName = "roadgen fly";

struct FlyOptions {
  SceneOptions scene;
  std::string follow, size = "1280x720", output, contact_sheet;
  int frames = 240, frames_per_second = 24;
  double fov_deg = 55;
  FlightOptions flight;
};

constexpr int kSheetColumns = 4, kSheetRows = 3;

// Puts a picture, shrunk by averaging `factor` x `factor` pixels, into one cell of the sheet.
void place_on_sheet(Image8& sheet, const Image8& picture, int cell, int factor) {
  const int width = picture.width / factor, height = picture.height / factor;
  const int left = cell % kSheetColumns * width, top = cell / kSheetColumns * height;
  // Averages are of light, not of code values.
  const auto linear = [](int c) { return std::pow(c / 255.0, 2.2); };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) {
        double sum = 0;
        for (int j = 0; j < factor; ++j) {
          for (int i = 0; i < factor; ++i) sum += linear(picture.at(x * factor + i, y * factor + j, c));
        }
        sheet.at(left + x, top + y, c) =
            static_cast<std::uint8_t>(std::lround(255 * std::pow(sum / (factor * factor), 1 / 2.2)));
      }
      sheet.at(left + x, top + y, 3) = 255;
    }
  }
}

// Where the pictures go: a video, a folder, or only a window.
class Sink {
 public:
  static Result<Sink> open(const FlyOptions& options, PictureSize size) {
    Sink sink;
    if (options.output.empty()) return sink;
    if (std::filesystem::path(options.output).extension() == ".mp4") {
      auto video = VideoWriter::open(options.output, size.width, size.height, options.frames_per_second);
      if (!video) return video.error();
      sink.video_.emplace(std::move(*video));
      return sink;
    }
    std::error_code fault;
    std::filesystem::create_directories(options.output, fault);
    if (fault) return Error{ErrorCode::kIo, "cannot make the folder: " + fault.message(), options.output};
    sink.folder_ = options.output;
    return sink;
  }
  Status add(const Image8& picture, int index) {
    if (video_) return video_->add(picture);
    if (folder_.empty()) return Done{};
    char name[32];
    std::snprintf(name, sizeof name, "/%05d.png", index);
    return write_png(folder_ + name, picture);
  }
  Status finish() { return video_ ? video_->finish() : Status(Done{}); }

 private:
  std::optional<VideoWriter> video_;
  std::string folder_;
};

// The named road, or the longest one.
Result<const Road*> road_to_follow(const Network& network, const std::string& id) {
  if (!id.empty()) return named_road(network, id);
  if (network.roads.empty()) return Error{ErrorCode::kData, "the network has no road to fly along"};
  return &*std::max_element(network.roads.begin(), network.roads.end(),
                            [](const Road& a, const Road& b) { return a.length_m() < b.length_m(); });
}

// Whether the output can be written, before the work rather than after it.
Status check_output(const std::string& path) {
  if (path.empty() || std::filesystem::is_directory(path)) return Done{};
  return check_writable(path);
}

Status check_options(const FlyOptions& options) {
  const auto usage = [](const char* text) { return Error{ErrorCode::kUsage, text}; };
  if (options.frames < 1) return usage("--frames must be 1 or more");
  if (options.frames_per_second < 1 || options.frames_per_second > 240) return usage("--fps must lie in 1 to 240");
  if (options.output.empty() && options.scene.context != "window") return usage("-o DIR or FILE.mp4 is required");
  if (!options.contact_sheet.empty()) return check_writable(options.contact_sheet);
  return Done{};
}

Status fly(FlyOptions& options) {
  const auto size = parse_size(options.size);
  if (!size) return size.error();
  if (Status s = check_options(options); !s) return s;
  const bool window = options.scene.context == "window";
  options.scene.width = size->width;
  options.scene.height = size->height;
  options.scene.visible = window;
  const auto network = read_opendrive(options.scene.network_path);
  if (!network) return network.error();
  const auto road = road_to_follow(*network, options.follow);
  if (!road) return road.error();
  Camera camera;
  camera.fov_deg = options.fov_deg;
  if (Status s = check_camera(camera); !s) return s;
  if (Status s = check_output(options.output); !s) return s;
  auto scene = open_scene(options.scene, *network);
  if (!scene) return scene.error();
  auto sink = Sink::open(options, *size);
  if (!sink) return sink.error();

  const int factor = std::max(1, size->width / 480);
  Image8 sheet(size->width / factor * kSheetColumns, size->height / factor * kSheetRows, 4);
  int cell = 0;
  ProgressLine progress;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < options.frames; ++i) {
    camera = flight_camera(**road, (*road)->length_m() * i / options.frames, options.flight);
    camera.fov_deg = options.fov_deg;
    const auto frame = scene->renderer->render(camera, {.width = size->width, .height = size->height});
    if (!frame) return frame.error();
    if (Status s = sink->add(frame->color, i); !s) return s;
    while (cell < kSheetColumns * kSheetRows &&
           i >= (2 * cell + 1) * options.frames / (2 * kSheetColumns * kSheetRows)) {
      place_on_sheet(sheet, frame->color, cell++, factor);
    }
    if (window) {
      const PixelSize pixels = scene->context->framebuffer_size();
      if (Status s = scene->renderer->draw(camera, pixels.width, pixels.height, 4); !s) return s;
      scene->context->swap_buffers();
      scene->context->poll();
      if (scene->context->should_close() || scene->context->key_down(Key::kEscape)) break;
    }
    progress.show((i + 1.0) / options.frames, "flight");
  }
  progress.clear();
  if (Status s = sink->finish(); !s) return s;
  if (!options.contact_sheet.empty()) {
    if (Status s = write_png(options.contact_sheet, sheet); !s) return s;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  nlohmann::json report = {{"road", (*road)->id},
                           {"length_m", (*road)->length_m()},
                           {"frames", options.frames},
                           {"seconds", seconds},
                           {"renderer", scene->context->renderer()}};
  if (!options.output.empty()) report["output"] = options.output;
  if (!options.contact_sheet.empty()) report["contact_sheet"] = options.contact_sheet;
  return put_out(report.dump(2) + "\n", "");
}

}  // namespace

int run_fly(const Arguments& arguments) {
  FlyOptions options;
  CLI::App app("Flies along a road: a video, single pictures, or a window.", kName);
  add_scene_options(app, options.scene);
  app.add_option("--follow", options.follow, "Id of the road. Default: the longest");
  app.add_option("--frames", options.frames, "Number of pictures, evenly along the road. Default: 240");
  app.add_option("--fps", options.frames_per_second, "Pictures per second of the video. Default: 24");
  app.add_option("--size", options.size, "WIDTHxHEIGHT in pixels. Default: 1280x720");
  app.add_option("--fov", options.fov_deg, "Vertical field of view in degrees. Default: 55");
  app.add_option("--height", options.flight.height_m, "Metres above the road's mean course. Default: 22");
  app.add_option("--smooth", options.flight.smooth_m, "Metres of road to both sides that are averaged. Default: 90");
  app.add_option("--ahead", options.flight.ahead_m, "Metres ahead that the view points to. Default: 170");
  app.add_option("--contact-sheet", options.contact_sheet, "A .png with twelve of the pictures");
  app.add_option("-o,--output", options.output, "FILE.mp4, or a folder for 00000.png, 00001.png, ...");
  if (const auto code = parse(app, arguments)) return *code;
  if (Status status = fly(options); !status) return fail(kName, status.error());
  return kExitDone;
}

}  // namespace roadgen::cli
