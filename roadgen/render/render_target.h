// Internal, not installed: an off-screen picture of any size, its colour attachments and its depth.
#pragma once

#include <vector>

#include "roadgen/render/gl.h"
#include "roadgen/render/image.h"
#include "roadgen/road/result.h"

namespace roadgen {

struct RenderTargetOptions {
  int width = 0;  // pixels, at least 1
  int height = 0;
  std::vector<GLenum> color_formats = {GL_SRGB8_ALPHA8};  // sized formats of COLOR_ATTACHMENT0, 1, ...; may be empty
  // 0 for no depth. The default is for reversed z (near is 1, far is 0), whose relative precision is even.
  GLenum depth_format = GL_DEPTH_COMPONENT32F;
  int samples = 1;  // per pixel
};

class RenderTarget {
 public:
  // Errors: kContext: larger than the driver's limits, or a combination of formats that it refuses.
  static Result<RenderTarget> create(const RenderTargetOptions& options);

  RenderTarget() = default;

  int width() const { return options_.width; }
  int height() const { return options_.height; }
  int samples() const { return options_.samples; }
  GLuint framebuffer() const { return framebuffer_.id(); }
  // GL_TEXTURE_2D, or GL_TEXTURE_2D_MULTISAMPLE with samples > 1.
  GLuint color(size_t index = 0) const { return colors_[index].id(); }
  GLuint depth() const { return depth_.id(); }

  // Draws go here, to all colour attachments; sets the viewport.
  void bind() const;

  // Resolves the samples of every colour attachment into the other target's of the same index, and depth by one sample
  // of each pixel. Colours of sRGB formats are averaged as light while GL_FRAMEBUFFER_SRGB is enabled.
  // Requires: same size and formats, the other with samples = 1.
  void resolve_into(RenderTarget& other) const;

  // The picture, rows from the top. Waits for the GPU. Requires: samples = 1.
  Image8 read_rgba8(size_t index = 0) const;                    // sRGB formats come out encoded
  ImageF read_float(size_t index = 0, int channels = 4) const;  // the first 1 to 4 channels
  ImageF read_depth() const;                                    // what the depth buffer holds, one channel

 private:
  RenderTargetOptions options_;
  gl::Framebuffer framebuffer_;
  std::vector<gl::Texture> colors_;
  gl::Texture depth_;
};

}  // namespace roadgen
