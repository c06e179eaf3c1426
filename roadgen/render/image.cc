#include "roadgen/render/image.h"

#include <OpenImageIO/imageio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace roadgen {
namespace {

// Beside the target, so that the rename stays within one file system; unique among processes and threads.
std::filesystem::path temporary_beside(const std::filesystem::path& path) {
  static std::atomic<unsigned> counter{0};
  std::filesystem::path name = ".";
  name += path.filename();
  name += "." + std::to_string(getpid()) + "-" + std::to_string(counter++) + ".tmp";
  return path.parent_path() / name;
}

Error io_error(const std::filesystem::path& path, const std::string& what, std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return Error{ErrorCode::kIo, what + (reason.empty() ? "" : ": " + reason), path.string()};
}

// Why no file can be made there, in the system's words; OpenImageIO's are vague. Empty where there is no obstacle.
std::string obstacle(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, error)) return "the folder " + folder.string() + " does not exist";
  if (std::filesystem::is_directory(path, error)) return "it is a folder";
  if (access(folder.c_str(), W_OK) != 0) return "the folder " + folder.string() + " is not writable";
  return "";
}

template <class T>
Status check_shape(const std::filesystem::path& path, const Image<T>& image) {
  const size_t count =
      static_cast<size_t>(image.width) * static_cast<size_t>(image.height) * static_cast<size_t>(image.channels);
  if (image.width < 1 || image.height < 1 || image.channels < 1 || image.pixels.size() != count ||
      (!image.channel_names.empty() && image.channel_names.size() != static_cast<size_t>(image.channels))) {
    return Error{ErrorCode::kData, "the picture has no pixels, or not as many as its size says", path.string()};
  }
  return Done{};
}

template <class T>
Status write(const std::filesystem::path& path, const Image<T>& image, const char* format, OIIO::ImageSpec spec) {
  if (const Status status = check_shape(path, image); !status) return status.error();
  if (const std::string reason = obstacle(path); !reason.empty()) return io_error(path, "cannot write", reason);
  if (!image.channel_names.empty()) spec.channelnames = image.channel_names;

  const std::filesystem::path temporary = temporary_beside(path);
  const auto output = OIIO::ImageOutput::create(format);
  if (!output) return io_error(path, "cannot write", OIIO::geterror());
  const bool written = output->open(temporary.string(), spec) &&
                       output->write_image(OIIO::BaseTypeFromC<T>::value, image.pixels.data()) && output->close();
  std::error_code error;
  if (!written) {
    const std::string reason = output->geterror();
    std::filesystem::remove(temporary, error);
    return io_error(path, "cannot write", reason);
  }
  std::filesystem::rename(temporary, path, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(temporary, error);
    return io_error(path, "cannot write", reason);
  }
  return Done{};
}

template <class T>
Result<Image<T>> read(const std::filesystem::path& path) {
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;  // leave colours as they are in the file
  const auto input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) return io_error(path, "cannot read", OIIO::geterror());
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width < 1 || spec.height < 1 || spec.depth != 1) return io_error(path, "cannot read", "not a flat picture");
  Image<T> image(spec.width, spec.height, spec.nchannels);
  image.channel_names = spec.channelnames;
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::BaseTypeFromC<T>::value, image.pixels.data())) {
    return io_error(path, "cannot read", input->geterror());
  }
  return image;
}

// |a - b|, where an infinity or NaN equals only its like.
double difference(double a, double b) {
  if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
  const double d = std::abs(a - b);
  return std::isnan(d) ? std::numeric_limits<double>::infinity() : d;
}

}  // namespace

Status write_png(const std::filesystem::path& path, const Image8& image) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec["oiio:ColorSpace"] = "sRGB";
  spec["oiio:UnassociatedAlpha"] = 1;  // otherwise the colours are divided by alpha
  if (image.channels > 4) return Error{ErrorCode::kData, "a PNG has at most 4 channels", path.string()};
  return write(path, image, "png", spec);
}

Status write_exr(const std::filesystem::path& path, const ImageF& image) {
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::FLOAT);
  spec["compression"] = "zip";
  spec["oiio:ColorSpace"] = "Linear";
  return write(path, image, "openexr", spec);
}

Result<Image8> read_image8(const std::filesystem::path& path) { return read<std::uint8_t>(path); }
Result<ImageF> read_image_float(const std::filesystem::path& path) { return read<float>(path); }

template <class T>
void flip(Image<T>& image) {
  const auto row = static_cast<std::ptrdiff_t>(image.width) * image.channels;
  auto top = image.pixels.begin(), below = image.pixels.end();
  for (int y = 0; y < image.height / 2; ++y, top += row) {
    below -= row;
    std::swap_ranges(top, top + row, below);
  }
}

template <class T>
Result<ImageDifference> compare(const Image<T>& a, const Image<T>& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels) {
    const auto shape = [](const Image<T>& i) {
      return std::to_string(i.width) + "x" + std::to_string(i.height) + "x" + std::to_string(i.channels);
    };
    return Error{ErrorCode::kData, "the pictures differ in shape: " + shape(a) + " and " + shape(b)};
  }
  ImageDifference result;
  double sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i) {
    const double d = difference(static_cast<double>(a.pixels[i]), static_cast<double>(b.pixels[i]));
    sum += d;
    if (d > result.max) {
      const size_t pixel = i / static_cast<size_t>(a.channels);
      result.max = d;
      result.x = static_cast<int>(pixel % static_cast<size_t>(a.width));
      result.y = static_cast<int>(pixel / static_cast<size_t>(a.width));
    }
  }
  if (!a.pixels.empty()) result.mean = sum / static_cast<double>(a.pixels.size());
  return result;
}

template void flip(Image8&);
template void flip(ImageF&);
template Result<ImageDifference> compare(const Image8&, const Image8&);
template Result<ImageDifference> compare(const ImageF&, const ImageF&);

}  // namespace roadgen
