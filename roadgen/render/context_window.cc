// Contexts in a window, by GLFW.
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "roadgen/render/context_backend.h"

namespace roadgen {
namespace {

int windows_open = 0;  // GLFW is initialized while there is one; main thread only

int glfw_key(int key) {
  switch (static_cast<Key>(key)) {
    case Key::kEscape: return GLFW_KEY_ESCAPE;
    case Key::kEnter: return GLFW_KEY_ENTER;
    case Key::kTab: return GLFW_KEY_TAB;
    case Key::kSpace: return GLFW_KEY_SPACE;
    case Key::kLeft: return GLFW_KEY_LEFT;
    case Key::kRight: return GLFW_KEY_RIGHT;
    case Key::kUp: return GLFW_KEY_UP;
    case Key::kDown: return GLFW_KEY_DOWN;
    case Key::kShift: return GLFW_KEY_LEFT_SHIFT;
    case Key::kControl: return GLFW_KEY_LEFT_CONTROL;
    case Key::kPageUp: return GLFW_KEY_PAGE_UP;
    case Key::kPageDown: return GLFW_KEY_PAGE_DOWN;
  }
  return key;  // GLFW's codes of letters and digits are their characters
}

void close_glfw() {
  if (windows_open == 0) glfwTerminate();
}

class WindowBackend : public Context::Backend {
 public:
  WindowBackend(GLFWwindow* window, bool vsync) : window_(window), vsync_(vsync) { ++windows_open; }
  ~WindowBackend() override {
    glfwDestroyWindow(window_);
    --windows_open;
    close_glfw();
  }

  bool make_current() override {
    glfwMakeContextCurrent(window_);
    if (glfwGetCurrentContext() != window_) return false;
    if (!interval_set_) glfwSwapInterval(vsync_ ? 1 : 0);
    interval_set_ = true;
    return true;
  }
  void release() override { glfwMakeContextCurrent(nullptr); }
  GlFunction (*loader() const)(const char*) override { return glfwGetProcAddress; }
  PixelSize framebuffer_size() const override {
    PixelSize size{0, 0};
    glfwGetFramebufferSize(window_, &size.width, &size.height);
    return size;
  }
  void swap_buffers() override { glfwSwapBuffers(window_); }
  void poll() override { glfwPollEvents(); }
  bool should_close() const override { return glfwWindowShouldClose(window_); }
  void set_should_close(bool close) override { glfwSetWindowShouldClose(window_, close); }
  bool key_down(int key) const override { return glfwGetKey(window_, glfw_key(key)) == GLFW_PRESS; }
  bool mouse_down(int button) const override { return glfwGetMouseButton(window_, button) == GLFW_PRESS; }
  CursorPosition cursor() const override {
    // GLFW reports screen units, the picture has pixels.
    CursorPosition position{0, 0};
    glfwGetCursorPos(window_, &position.x_px, &position.y_px);
    int width = 0, height = 0;
    glfwGetWindowSize(window_, &width, &height);
    const PixelSize size = framebuffer_size();
    if (width > 0 && height > 0) {
      position.x_px *= static_cast<double>(size.width) / width;
      position.y_px *= static_cast<double>(size.height) / height;
    }
    return position;
  }
  void* native_window() const override { return window_; }

 private:
  GLFWwindow* window_;
  bool vsync_;
  bool interval_set_ = false;
};

Error glfw_error(const std::string& what) {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return Error{ErrorCode::kContext, what + (reason ? std::string(" (") + reason + ")" : std::string()) +
                                        "; set DISPLAY to a running X server, or use --context osmesa"};
}

}  // namespace

Result<std::unique_ptr<Context::Backend>> make_window_backend(const ContextOptions& options) {
  if (!glfwInit()) return glfw_error("no window: there is no display");
  glfwDefaultWindowHints();
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, options.debug ? GLFW_TRUE : GLFW_FALSE);
  glfwWindowHint(GLFW_VISIBLE, options.visible ? GLFW_TRUE : GLFW_FALSE);
  GLFWwindow* window = glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (!window) {
    const Error error = glfw_error("no window with an OpenGL 4.5 core context");
    close_glfw();
    return error;
  }
  return std::unique_ptr<Context::Backend>(new WindowBackend(window, options.vsync));
}

}  // namespace roadgen
