#include "roadgen/render/ground_textures.h"

#include <algorithm>
#include <bit>

namespace roadgen {
namespace {

constexpr GLuint kFirstUnit = 5;  // of terrain.frag's ground_textures

}  // namespace

Status GroundTextures::take(GroundMaterial material, const Image8& picture) {
  if (picture.width < 1 || picture.height < 1) return Error{ErrorCode::kData, "the texture has no pixels"};
  Image8 rgba(picture.width, picture.height, 4);
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      for (int c = 0; c < 3; ++c) rgba.at(x, y, c) = picture.at(x, y, picture.channels >= 3 ? c : 0);
      rgba.at(x, y, 3) = 255;
    }
  }
  const auto longer = static_cast<unsigned>(std::max(picture.width, picture.height));
  gl::Texture texture = gl::Texture::image_2d(GL_SRGB8_ALPHA8, picture.width, picture.height,
                                              static_cast<GLsizei>(std::bit_width(longer)));
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.id(), 0, 0, 0, picture.width, picture.height, GL_RGBA, GL_UNSIGNED_BYTE,
                      rgba.pixels.data());
  glGenerateTextureMipmap(texture.id());
  glTextureParameteri(texture.id(), GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTextureParameteri(texture.id(), GL_TEXTURE_WRAP_T, GL_REPEAT);
  const auto i = static_cast<std::size_t>(material);
  textures_[i] = std::move(texture);
  mask_ |= 1u << i;
  return Done{};
}

void GroundTextures::bind() const {
  for (GLuint i = 0; i < textures_.size(); ++i) {
    if (mask_ & (1u << i)) glBindTextureUnit(kFirstUnit + i, textures_[i].id());
  }
}

}  // namespace roadgen
