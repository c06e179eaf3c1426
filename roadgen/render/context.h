// OpenGL 4.5 core contexts, headless or in a window, behind one type.
//
// Every context loads the same global OpenGL functions from its own driver, so callers write glClear(...) whatever the
// kind. Contexts of several kinds may live in one process; make_current() reloads the functions when the kind changes.
// Hence, at any one time, only contexts of one kind may be current in the threads of a process.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "roadgen/road/result.h"

namespace roadgen {

enum class ContextKind {
  kOsmesa,  // off-screen, in memory, on the CPU: needs neither a GPU nor a display
  kEgl,     // off-screen, by EGL: on a GPU where there is one
  kWindow,  // a GLFW window: needs a display; main thread only
};

// "osmesa", "egl" or "window", as on the command line; and back, with Errors: kUsage.
const char* context_kind_name(ContextKind kind);
Result<ContextKind> context_kind_from_name(const std::string& name);

struct ContextOptions {
  ContextKind kind = ContextKind::kOsmesa;
  // kEgl: -1 for the surfaceless default display (Mesa), or an index >= 0 into the devices that EGL enumerates.
  int egl_device = -1;
  // Pixels of the default framebuffer (kWindow: of the client area, in screen units). kEgl has none and ignores them;
  // passes render to framebuffer objects of any size.
  int width = 1280;
  int height = 720;
  std::string title = "roadgen";  // kWindow only, as are:
  bool visible = true;
  bool vsync = true;
  // Collect KHR_debug messages, synchronously. Costs a little speed.
  bool debug = false;
};

// Keys that Context::key_down knows; letters and digits are passed as their upper-case characters.
enum class Key : int {
  kEscape = 256,
  kEnter,
  kTab,
  kSpace,
  kLeft,
  kRight,
  kUp,
  kDown,
  kShift,
  kControl,
  kPageUp,
  kPageDown
};

struct PixelSize {
  int width, height;
};
struct CursorPosition {
  double x_px, y_px;
};  // from the top left corner of the picture

class Context {
 public:
  // A new OpenGL 4.5 core context, current in this thread; on failure, the former one stays current. No state is
  // changed from OpenGL's defaults but debug output.
  // Errors: kContext: what failed and what to do.
  static Result<std::unique_ptr<Context>> create(const ContextOptions& options);

  // Ends the context; OpenGL objects made in it are gone. If another one is current, it stays so.
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  // Makes the context current in this thread, releasing the thread's former one. No cost if it is current already;
  // reloads about 1000 function pointers if the last one was of another kind.
  // Errors: kContext: it is current in another thread, or the driver refuses; then this thread has no current context.
  Status make_current();
  // Leaves this thread without a current context, so that another thread may have it.
  static void release_current();
  bool is_current() const;
  // The context that was last made current in this thread, or null.
  static Context* current();

  ContextKind kind() const;
  const std::string& vendor() const;
  const std::string& renderer() const;  // such as "llvmpipe (LLVM 15.0.6, 256 bits)"
  const std::string& version() const;   // such as "4.5 (Core Profile) Mesa 22.3.6"
  // Whether pixels are computed by the CPU (llvmpipe, softpipe, swrast).
  bool is_software() const;

  // The size of the default framebuffer in pixels; 0 x 0 for kEgl.
  PixelSize framebuffer_size() const;

  // Messages of KHR_debug since the last call, oldest first, at most kMaxDebugMessages: errors, undefined and
  // deprecated behaviour, and all of high severity; but for failures to compile a shader, which Program returns. Needs
  // options.debug. Tests assert that there are none.
  static constexpr int kMaxDebugMessages = 1000;
  std::vector<std::string> take_debug_messages();

  // Of a window; the other kinds do nothing, never close and have no input.
  void swap_buffers();
  void poll();                // handles pending input events
  bool should_close() const;  // the user asked to close the window
  void set_should_close(bool close);
  bool key_down(Key key) const;
  bool key_down(char letter_or_digit) const;
  bool mouse_down(int button) const;  // 0 left, 1 right, 2 middle
  CursorPosition cursor() const;
  // The GLFWwindow* of a window, for user interface toolkits; null for the other kinds.
  void* native_window() const;

  class Backend;  // internal: one of the three kinds

 private:
  struct State;
  explicit Context(std::unique_ptr<State> state);
  static Result<std::unique_ptr<Context>> create_current(const ContextOptions& options);
  std::unique_ptr<State> state_;
};

}  // namespace roadgen
