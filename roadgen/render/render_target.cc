#include "roadgen/render/render_target.h"

#include <cassert>
#include <string>
#include <utility>

namespace roadgen {
namespace {

std::string shape_text(const RenderTargetOptions& options) {
  return std::to_string(options.width) + "x" + std::to_string(options.height) + " with " +
         std::to_string(options.samples) + " samples";
}

Status check_limits(const RenderTargetOptions& options) {
  GLint size = 0, samples = 0, colors = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &size);
  glGetIntegerv(GL_MAX_COLOR_TEXTURE_SAMPLES, &samples);
  glGetIntegerv(GL_MAX_COLOR_ATTACHMENTS, &colors);
  if (options.width < 1 || options.height < 1 || options.width > size || options.height > size || options.samples < 1 ||
      options.samples > samples || options.color_formats.size() > static_cast<size_t>(colors)) {
    return Error{ErrorCode::kContext, "no picture of " + shape_text(options) + "; this driver allows up to " +
                                          std::to_string(size) + "x" + std::to_string(size) + " with " +
                                          std::to_string(samples) + " samples"};
  }
  return Done{};
}

// Reads a level-0 texture into the image and turns it upright.
template <class T>
Image<T> read_texture(GLuint texture, int width, int height, int channels, GLenum format, GLenum type) {
  Image<T> image(width, height, channels);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glGetTextureImage(texture, 0, format, type, static_cast<GLsizei>(image.pixels.size() * sizeof(T)),
                    image.pixels.data());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  flip(image);
  return image;
}

}  // namespace

Result<RenderTarget> RenderTarget::create(const RenderTargetOptions& options) {
  if (const Status status = check_limits(options); !status) return status.error();
  RenderTarget target;
  target.options_ = options;
  target.framebuffer_ = gl::Framebuffer::create();
  const GLuint framebuffer = target.framebuffer_.id();
  std::vector<GLenum> draw_buffers;
  for (const GLenum format : options.color_formats) {
    const GLenum attachment = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(draw_buffers.size());
    target.colors_.push_back(gl::Texture::image_2d(format, options.width, options.height, 1, options.samples));
    glNamedFramebufferTexture(framebuffer, attachment, target.colors_.back().id(), 0);
    draw_buffers.push_back(attachment);
  }
  glNamedFramebufferDrawBuffers(framebuffer, static_cast<GLsizei>(draw_buffers.size()), draw_buffers.data());
  if (options.depth_format) {
    target.depth_ = gl::Texture::image_2d(options.depth_format, options.width, options.height, 1, options.samples);
    glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, target.depth_.id(), 0);
  }
  if (glCheckNamedFramebufferStatus(framebuffer, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    return Error{ErrorCode::kContext,
                 "this driver cannot render to a picture of " + shape_text(options) + " in the chosen formats"};
  }
  return target;
}

void RenderTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glViewport(0, 0, options_.width, options_.height);
}

void RenderTarget::resolve_into(RenderTarget& other) const {
  assert(other.width() == width() && other.height() == height() && other.samples() == 1);
  const auto blit = [&](GLbitfield mask) {
    glBlitNamedFramebuffer(framebuffer_.id(), other.framebuffer_.id(), 0, 0, width(), height(), 0, 0, width(), height(),
                           mask, GL_NEAREST);
  };
  for (GLenum i = 0; i < colors_.size(); ++i) {
    glNamedFramebufferReadBuffer(framebuffer_.id(), GL_COLOR_ATTACHMENT0 + i);
    glNamedFramebufferDrawBuffer(other.framebuffer_.id(), GL_COLOR_ATTACHMENT0 + i);
    blit(GL_COLOR_BUFFER_BIT);
  }
  std::vector<GLenum> draw_buffers;
  for (GLenum i = 0; i < colors_.size(); ++i) draw_buffers.push_back(GL_COLOR_ATTACHMENT0 + i);
  glNamedFramebufferDrawBuffers(other.framebuffer_.id(), static_cast<GLsizei>(draw_buffers.size()),
                                draw_buffers.data());
  if (depth_ && other.depth_) blit(GL_DEPTH_BUFFER_BIT);
}

Image8 RenderTarget::read_rgba8(size_t index) const {
  assert(samples() == 1);
  return read_texture<std::uint8_t>(color(index), width(), height(), 4, GL_RGBA, GL_UNSIGNED_BYTE);
}

ImageF RenderTarget::read_float(size_t index, int channels) const {
  assert(samples() == 1 && channels >= 1 && channels <= 4);
  static constexpr GLenum kFormats[] = {GL_RED, GL_RG, GL_RGB, GL_RGBA};
  return read_texture<float>(color(index), width(), height(), channels, kFormats[channels - 1], GL_FLOAT);
}

ImageF RenderTarget::read_depth() const {
  assert(samples() == 1);
  return read_texture<float>(depth(), width(), height(), 1, GL_DEPTH_COMPONENT, GL_FLOAT);
}

}  // namespace roadgen
