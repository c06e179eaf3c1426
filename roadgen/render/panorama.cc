#include "roadgen/render/panorama.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

namespace roadgen {

Result<ImageF> read_panorama(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending != ".exr" && ending != ".hdr") {
    return Error{ErrorCode::kUsage, "an environment is a panorama in an .exr or .hdr file", path.string()};
  }
  const auto read = read_image_float(path);
  if (!read) return read.error();
  const auto refuse = [&](const std::string& why) { return Error{ErrorCode::kData, why, path.string()}; };
  if (read->width > 16384 || read->width < 4 || std::abs(read->width - 2 * read->height) > read->height / 8) {
    return refuse("a panorama must be twice as wide as high and at most 16384 pixels wide, this is " +
                  std::to_string(read->width) + " x " + std::to_string(read->height));
  }
  int channel[3] = {read->channel_index("R"), read->channel_index("G"), read->channel_index("B")};
  if (*std::min_element(channel, channel + 3) < 0) {
    if (read->channels < 3) return refuse("a panorama must have the channels R, G and B");
    for (int c = 0; c < 3; ++c) channel[c] = c;
  }
  ImageF image(read->width, read->height, 3);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float value = read->at(x, y, channel[c]);
        image.at(x, y, c) = value > 0 && std::isfinite(value) ? std::min(value, 60000.0f) : 0.0f;
      }
    }
  }
  return image;
}

}  // namespace roadgen
