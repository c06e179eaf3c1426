// Internal, not installed: OpenGL and its objects as move-only handles, for the passes.
//
// Each handle is made, used and destroyed with its context current. A default-constructed handle owns nothing.
#pragma once

#include <glad/gl.h>

#include <string_view>
#include <utility>

namespace roadgen::gl {

// Kind states how a name is made and deleted, and what KHR_debug calls it.
template <class Kind>
class Handle {
 public:
  Handle() = default;
  ~Handle() { reset(); }
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, 0)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }

  GLuint id() const { return id_; }
  explicit operator bool() const { return id_ != 0; }
  void reset() {
    if (id_) Kind::destroy(id_);
    id_ = 0;
  }
  // The name that debuggers and messages of the driver show.
  void label(std::string_view text) {
    glObjectLabel(Kind::kLabel, id_, static_cast<GLsizei>(text.size()), text.data());
  }

 protected:
  explicit Handle(GLuint id) : id_(id) {}

 private:
  GLuint id_ = 0;
};

struct BufferKind {
  static constexpr GLenum kLabel = GL_BUFFER;
  static void destroy(GLuint id) { glDeleteBuffers(1, &id); }
};
class Buffer : public Handle<BufferKind> {
 public:
  Buffer() = default;
  static Buffer create() {
    GLuint id = 0;
    glCreateBuffers(1, &id);
    return Buffer(id);
  }
  // Immutable storage. flags as glNamedBufferStorage: 0 for a buffer that only the GPU writes.
  // Requires: size_bytes > 0. data may be null: then the content is undefined.
  static Buffer with_data(GLsizeiptr size_bytes, const void* data, GLbitfield flags = 0) {
    Buffer buffer = create();
    glNamedBufferStorage(buffer.id(), size_bytes, data, flags);
    return buffer;
  }

 private:
  using Handle::Handle;
};

struct TextureKind {
  static constexpr GLenum kLabel = GL_TEXTURE;
  static void destroy(GLuint id) { glDeleteTextures(1, &id); }
};
class Texture : public Handle<TextureKind> {
 public:
  Texture() = default;
  // target such as GL_TEXTURE_2D.
  static Texture create(GLenum target) {
    GLuint id = 0;
    glCreateTextures(target, 1, &id);
    return Texture(id);
  }
  // Immutable storage of a GL_TEXTURE_2D, or with samples > 1 of a GL_TEXTURE_2D_MULTISAMPLE (levels is then ignored).
  static Texture image_2d(GLenum format, GLsizei width, GLsizei height, GLsizei levels = 1, GLsizei samples = 1) {
    Texture texture = create(samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D);
    if (samples > 1) {
      glTextureStorage2DMultisample(texture.id(), samples, format, width, height, GL_TRUE);
    } else {
      glTextureStorage2D(texture.id(), levels, format, width, height);
    }
    return texture;
  }
  // A buffer's content as texels, for samplerBuffer. Requires: the buffer outlives its use.
  static Texture of_buffer(GLenum format, const Buffer& buffer) {
    Texture texture = create(GL_TEXTURE_BUFFER);
    glTextureBuffer(texture.id(), format, buffer.id());
    return texture;
  }

 private:
  using Handle::Handle;
};

struct VertexArrayKind {
  static constexpr GLenum kLabel = GL_VERTEX_ARRAY;
  static void destroy(GLuint id) { glDeleteVertexArrays(1, &id); }
};
class VertexArray : public Handle<VertexArrayKind> {
 public:
  VertexArray() = default;
  static VertexArray create() {
    GLuint id = 0;
    glCreateVertexArrays(1, &id);
    return VertexArray(id);
  }

 private:
  using Handle::Handle;
};

struct FramebufferKind {
  static constexpr GLenum kLabel = GL_FRAMEBUFFER;
  static void destroy(GLuint id) { glDeleteFramebuffers(1, &id); }
};
class Framebuffer : public Handle<FramebufferKind> {
 public:
  Framebuffer() = default;
  static Framebuffer create() {
    GLuint id = 0;
    glCreateFramebuffers(1, &id);
    return Framebuffer(id);
  }

 private:
  using Handle::Handle;
};

struct QueryKind {
  static constexpr GLenum kLabel = GL_QUERY;
  static void destroy(GLuint id) { glDeleteQueries(1, &id); }
};
class Query : public Handle<QueryKind> {
 public:
  Query() = default;
  // target such as GL_ANY_SAMPLES_PASSED.
  static Query create(GLenum target) {
    GLuint id = 0;
    glCreateQueries(target, 1, &id);
    return Query(id);
  }

 private:
  using Handle::Handle;
};

struct SamplerKind {
  static constexpr GLenum kLabel = GL_SAMPLER;
  static void destroy(GLuint id) { glDeleteSamplers(1, &id); }
};
class Sampler : public Handle<SamplerKind> {
 public:
  Sampler() = default;
  static Sampler create() {
    GLuint id = 0;
    glCreateSamplers(1, &id);
    return Sampler(id);
  }

 private:
  using Handle::Handle;
};

}  // namespace roadgen::gl
