#include "roadgen/render/object_textures.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>

#include "roadgen/render/image.h"

namespace roadgen {
namespace {

// size x size RGBA texels, rows from the bottom. Each is the mean of what it covers of the image, or between its pixels.
std::vector<std::uint8_t> resized(const Image8& image, int size) {
  std::vector<std::uint8_t> texels(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) * 4, 255);
  const double step_x = static_cast<double>(image.width) / size, step_y = static_cast<double>(image.height) / size;
  const int parts = std::max(1, static_cast<int>(std::ceil(std::max(step_x, step_y))));
  const auto pixel = [&](double x, double y, int channel) {
    const int column = std::clamp(static_cast<int>(std::floor(x)), 0, image.width - 1);
    const int row = std::clamp(static_cast<int>(std::floor(y)), 0, image.height - 1);
    const int right = std::min(column + 1, image.width - 1), below = std::min(row + 1, image.height - 1);
    const double a = std::clamp(x - column, 0.0, 1.0), b = std::clamp(y - row, 0.0, 1.0);
    return (1 - b) * ((1 - a) * image.at(column, row, channel) + a * image.at(right, row, channel)) +
           b * ((1 - a) * image.at(column, below, channel) + a * image.at(right, below, channel));
  };
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int channel = image.channels >= 3 ? c : 0;
        double sum = 0;
        for (int i = 0; i < parts * parts; ++i) {
          const double u = x + (i % parts + 0.5) / parts, v = size - 1 - y + (i / parts + 0.5) / parts;
          sum += pixel(u * step_x - 0.5, v * step_y - 0.5, channel);
        }
        texels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(size) + static_cast<std::size_t>(x)) * 4 +
               static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(sum / (parts * parts)));
      }
    }
  }
  return texels;
}

}  // namespace

Result<ObjectTextures> load_textures(const std::vector<ObjectMaterial>& materials) {
  ObjectTextures made;
  std::map<std::string, int> layer_of;  // of each file
  std::vector<Image8> images;
  int size = 1;
  for (const ObjectMaterial& material : materials) {
    made.layer_of.push_back(0);
    if (material.texture_file.empty()) continue;
    const auto [at, is_new] = layer_of.try_emplace(material.texture_file, static_cast<int>(images.size()) + 1);
    made.layer_of.back() = at->second;
    if (!is_new) continue;
    auto image = read_image8(material.texture_file);
    if (!image) return image.error();
    if (image->channels < 1 || image->width < 1 || image->height < 1) {
      return Error{ErrorCode::kData, "has no pixels", material.texture_file};
    }
    const auto greater = static_cast<unsigned>(std::max(image->width, image->height));
    size = std::min(std::max(size, static_cast<int>(std::bit_ceil(greater))), kMostTextureSize);
    images.push_back(std::move(*image));
  }
  if (images.empty()) return made;
  GLint most = 0;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most);
  if (images.size() > static_cast<std::size_t>(most)) {
    return Error{ErrorCode::kData, "the materials have " + std::to_string(images.size()) +
                                       " different textures, this OpenGL driver takes " + std::to_string(most)};
  }
  made.layers = gl::Texture::create(GL_TEXTURE_2D_ARRAY);
  const GLuint id = made.layers.id();
  glTextureStorage3D(id, std::bit_width(static_cast<unsigned>(size)), GL_SRGB8_ALPHA8, size, size,
                     static_cast<GLsizei>(images.size()));
  for (std::size_t i = 0; i < images.size(); ++i) {
    glTextureSubImage3D(id, 0, 0, 0, static_cast<GLint>(i), size, size, 1, GL_RGBA, GL_UNSIGNED_BYTE,
                        resized(images[i], size).data());
    images[i] = {};
  }
  glGenerateTextureMipmap(id);
  glTextureParameteri(id, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTextureParameteri(id, GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTextureParameteri(id, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return made;
}

}  // namespace roadgen
