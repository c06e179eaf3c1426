// Contexts by OSMesa: llvmpipe into a buffer of our own.
#include <GL/osmesa.h>

#include <vector>

#include "roadgen/render/context_backend.h"

namespace roadgen {
namespace {

class OsmesaBackend : public Context::Backend {
 public:
  OsmesaBackend(OSMesaContext context, int width, int height)
      : context_(context), width_(width), height_(height), pixels_(4 * static_cast<size_t>(width) * height) {}
  ~OsmesaBackend() override { OSMesaDestroyContext(context_); }

  bool make_current() override {
    return OSMesaMakeCurrent(context_, pixels_.data(), GL_UNSIGNED_BYTE, width_, height_) == GL_TRUE;
  }
  void release() override { OSMesaMakeCurrent(nullptr, nullptr, GL_UNSIGNED_BYTE, 0, 0); }
  GlFunction (*loader() const)(const char*) override {
    return [](const char* name) { return reinterpret_cast<GlFunction>(OSMesaGetProcAddress(name)); };
  }
  PixelSize framebuffer_size() const override { return {width_, height_}; }

 private:
  OSMesaContext context_;
  int width_, height_;
  std::vector<unsigned char> pixels_;
};

}  // namespace

Result<std::unique_ptr<Context::Backend>> make_osmesa_backend(const ContextOptions& options) {
  // No depth or stencil buffer: passes bring their own framebuffer objects.
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            4,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            5,
                            0};
  const OSMesaContext context = OSMesaCreateContextAttribs(attributes, nullptr);
  if (!context) {
    return Error{ErrorCode::kContext,
                 "OSMesa cannot create an OpenGL 4.5 core context; it needs OSMesa of Mesa 20 or later (package "
                 "libosmesa6), built with llvmpipe"};
  }
  return std::unique_ptr<Context::Backend>(new OsmesaBackend(context, options.width, options.height));
}

}  // namespace roadgen
