// Pictures in memory and in files, and how much two of them differ.
//
// A file appears whole or not at all: it is written under a temporary name in the same folder and then renamed.
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "roadgen/road/result.h"

namespace roadgen {

// Rows from the top, pixels from the left, channels of a pixel together.
template <class T>
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<T> pixels;                   // width * height * channels
  std::vector<std::string> channel_names;  // one per channel, or empty for the usual ones: Y, YA, RGB or RGBA

  Image() = default;
  // All zero. Requires: nothing negative.
  Image(int width_px, int height_px, int channel_count)
      : width(width_px),
        height(height_px),
        channels(channel_count),
        pixels(static_cast<size_t>(width_px) * static_cast<size_t>(height_px) * static_cast<size_t>(channel_count)) {}

  // Requires: in range.
  T& at(int x, int y, int channel) { return pixels[index(x, y, channel)]; }
  const T& at(int x, int y, int channel) const { return pixels[index(x, y, channel)]; }
  // The channel of that name, or -1.
  int channel_index(std::string_view name) const {
    const auto found = std::find(channel_names.begin(), channel_names.end(), name);
    return found == channel_names.end() ? -1 : static_cast<int>(found - channel_names.begin());
  }

 private:
  size_t index(int x, int y, int channel) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
               static_cast<size_t>(channels) +
           static_cast<size_t>(channel);
  }
};
using Image8 = Image<std::uint8_t>;  // sRGB-encoded colours, linear alpha, not premultiplied
using ImageF = Image<float>;         // linear, any range; infinity and NaN are kept

// An 8-bit PNG with 1 to 4 channels. The bytes are stored as they are. Errors: kIo: not writable; kData: no pixels, or
// a size that does not match.
Status write_png(const std::filesystem::path& path, const Image8& image);

// A 32-bit float OpenEXR file, losslessly compressed, with any named channels. Viewers take R, G, B and A for colour.
// The file's channel order is not kept: look channels up by name. Errors: as write_png.
Status write_exr(const std::filesystem::path& path, const ImageF& image);

// Any file that OpenImageIO reads, its first part, converted to 8 bits (values in 0..1 by 255) or to float (8-bit
// values divided by 255). No colour conversion. Errors: kIo: not readable, or not an image.
Result<Image8> read_image8(const std::filesystem::path& path);
Result<ImageF> read_image_float(const std::filesystem::path& path);

// Turns it upside down, in place: OpenGL's rows begin at the bottom.
template <class T>
void flip(Image<T>& image);

struct ImageDifference {
  double max = 0;    // of |a - b| over all pixels and channels, in the images' own units
  double mean = 0;   // likewise
  int x = 0, y = 0;  // where the greatest is, first in row order
};

// Equal infinities and two NaNs differ by 0; an infinity or NaN on one side only, by infinity.
// Errors: kData: the images differ in size or channels. Cost: linear.
template <class T>
Result<ImageDifference> compare(const Image<T>& a, const Image<T>& b);

extern template void flip(Image8&);
extern template void flip(ImageF&);
extern template Result<ImageDifference> compare(const Image8&, const Image8&);
extern template Result<ImageDifference> compare(const ImageF&, const ImageF&);

}  // namespace roadgen
