// Contexts by EGL without a surface: Mesa's surfaceless platform, or a device that EGL enumerates.
#define EGL_NO_X11
#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <string>
#include <string_view>
#include <vector>

#include "roadgen/render/context_backend.h"

namespace roadgen {
namespace {

class EglBackend : public Context::Backend {
 public:
  EglBackend(EGLDisplay display, EGLContext context) : display_(display), context_(context) {}
  // The display stays initialized: EGL has one per process and platform, and others may be using it.
  ~EglBackend() override { eglDestroyContext(display_, context_); }

  bool make_current() override {
    eglBindAPI(EGL_OPENGL_API);  // a state of the thread
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  void release() override {
    eglBindAPI(EGL_OPENGL_API);
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  GlFunction (*loader() const)(const char*) override {
    return [](const char* name) { return reinterpret_cast<GlFunction>(eglGetProcAddress(name)); };
  }
  PixelSize framebuffer_size() const override { return {0, 0}; }

 private:
  EGLDisplay display_;
  EGLContext context_;
};

Error egl_error(const std::string& what, const std::string& advice) {
  static const char* const kNames[] = {"success",       "not initialized", "bad access",        "bad alloc",
                                       "bad attribute", "bad config",      "bad context",       "bad current surface",
                                       "bad display",   "bad match",       "bad native pixmap", "bad native window",
                                       "bad parameter", "bad surface",     "context lost"};
  const EGLint code = eglGetError();
  std::string message = "EGL: " + what;
  if (code > EGL_SUCCESS && code <= EGL_CONTEXT_LOST) message += std::string(" (") + kNames[code - EGL_SUCCESS] + ")";
  return Error{ErrorCode::kContext, message + "; " + advice};
}

bool has_extension(EGLDisplay display, std::string_view name) {
  const char* list = eglQueryString(display, EGL_EXTENSIONS);
  if (!list) {
    eglGetError();  // EGL without client extensions; forget its complaint
    return false;
  }
  return (" " + std::string(list) + " ").find(" " + std::string(name) + " ") != std::string::npos;
}

Result<EGLDisplay> device_display(int index) {
  const auto query = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
  const bool enumerates = has_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration") ||
                          has_extension(EGL_NO_DISPLAY, "EGL_EXT_device_base");
  if (!enumerates || !query || !has_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device")) {
    return egl_error("this EGL does not enumerate devices", "use device -1 or --context osmesa");
  }
  EGLint count = 0;
  query(0, nullptr, &count);
  std::vector<EGLDeviceEXT> devices(static_cast<size_t>(count));
  if (count > 0) query(count, devices.data(), &count);
  if (index >= count) {
    return egl_error("there is no device " + std::to_string(index) + " among the " + std::to_string(count),
                     "choose another, numbered from 0, or -1, or use --context osmesa");
  }
  return eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[static_cast<size_t>(index)], nullptr);
}

Result<EGLDisplay> surfaceless_display() {
  if (!has_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
    return egl_error("no surfaceless platform (it is Mesa's)", "choose a device from 0 up, or --context osmesa");
  }
  return eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
}

}  // namespace

Result<std::unique_ptr<Context::Backend>> make_egl_backend(const ContextOptions& options) {
  const std::string advice = "check the driver, or use --context osmesa";
  const int device = options.egl_device;
  const Result<EGLDisplay> display = device < 0 ? surfaceless_display() : device_display(device);
  if (!display) return display.error();
  if (*display == EGL_NO_DISPLAY) return egl_error("no display", advice);
  if (!eglInitialize(*display, nullptr, nullptr)) return egl_error("the display cannot be initialized", advice);
  if (!eglBindAPI(EGL_OPENGL_API)) return egl_error("no desktop OpenGL", advice);
  if (!has_extension(*display, "EGL_KHR_no_config_context") ||
      !has_extension(*display, "EGL_KHR_surfaceless_context")) {
    return egl_error("no contexts without a surface", advice);
  }
  const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                               4,
                               EGL_CONTEXT_MINOR_VERSION,
                               5,
                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                               EGL_CONTEXT_OPENGL_DEBUG,
                               options.debug ? EGL_TRUE : EGL_FALSE,
                               EGL_NONE};
  const EGLContext context = eglCreateContext(*display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
  if (context == EGL_NO_CONTEXT) return egl_error("no OpenGL 4.5 core context", advice);
  return std::unique_ptr<Context::Backend>(new EglBackend(*display, context));
}

}  // namespace roadgen
