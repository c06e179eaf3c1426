// Internal: what a kind of context must do. One file per kind implements it.
#pragma once

#include <memory>

#include "roadgen/render/context.h"

namespace roadgen {

using GlFunction = void (*)();

class Context::Backend {
 public:
  virtual ~Backend() = default;

  virtual bool make_current() = 0;
  virtual void release() = 0;  // leaves this thread without a current context
  // OpenGL functions by name, the same for every context of a kind.
  virtual GlFunction (*loader() const)(const char* name) = 0;

  virtual PixelSize framebuffer_size() const = 0;
  virtual void swap_buffers() {}
  virtual void poll() {}
  virtual bool should_close() const { return false; }
  virtual void set_should_close(bool) {}
  virtual bool key_down(int) const { return false; }  // a Key or an upper-case character
  virtual bool mouse_down(int) const { return false; }
  virtual CursorPosition cursor() const { return {0, 0}; }
  virtual void* native_window() const { return nullptr; }
};

// Errors: kContext.
Result<std::unique_ptr<Context::Backend>> make_osmesa_backend(const ContextOptions& options);
Result<std::unique_ptr<Context::Backend>> make_egl_backend(const ContextOptions& options);
Result<std::unique_ptr<Context::Backend>> make_window_backend(const ContextOptions& options);

}  // namespace roadgen
