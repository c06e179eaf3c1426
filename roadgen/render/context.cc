#include "roadgen/render/context.h"

#include <glad/gl.h>

#include <atomic>
#include <cassert>
#include <mutex>
#include <optional>

#include "roadgen/render/context_backend.h"

namespace roadgen {

struct Context::State {
  ContextOptions options;
  std::unique_ptr<Backend> backend;
  std::atomic<bool> in_use = false;  // current in some thread; not every driver refuses a second one
  std::string vendor, renderer, version;
  std::mutex debug_mutex;  // a driver may report from a thread of its own
  std::vector<std::string> debug_messages;
};

namespace {

thread_local Context* current_context = nullptr;

// The kind whose functions the global pointers hold now.
std::mutex loaded_mutex;
std::optional<ContextKind> loaded_kind;

Status load_functions(ContextKind kind, const Context::Backend& backend) {
  const std::lock_guard lock(loaded_mutex);
  if (loaded_kind == kind) return Done{};
  loaded_kind.reset();
  const int version = gladLoadGL(backend.loader());
  if (version < GLAD_MAKE_VERSION(4, 5)) {
    return Error{ErrorCode::kContext, "the driver offers OpenGL " + std::to_string(GLAD_VERSION_MAJOR(version)) + "." +
                                          std::to_string(GLAD_VERSION_MINOR(version)) +
                                          ", not 4.5; use --context osmesa"};
  }
  loaded_kind = kind;
  return Done{};
}

const char* debug_type_name(GLenum type) {
  switch (type) {
    case GL_DEBUG_TYPE_ERROR: return "error";
    case GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR: return "deprecated behaviour";
    case GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR: return "undefined behaviour";
    case GL_DEBUG_TYPE_PORTABILITY: return "portability";
    case GL_DEBUG_TYPE_PERFORMANCE: return "performance";
    default: return "other";
  }
}

// What is a fault of ours; drivers also chat about performance and buffer placement. Errors of the shader compiler are
// left out, since Program returns them.
bool is_fault(GLenum source, GLenum type, GLenum severity) {
  if (source == GL_DEBUG_SOURCE_SHADER_COMPILER && type == GL_DEBUG_TYPE_ERROR) return false;
  return type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_DEPRECATED_BEHAVIOR ||
         type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR || severity == GL_DEBUG_SEVERITY_HIGH;
}

void add_message(std::mutex& mutex, std::vector<std::string>& messages, GLenum type, const char* text) {
  const std::lock_guard lock(mutex);
  if (messages.size() < Context::kMaxDebugMessages) {
    messages.push_back(std::string(debug_type_name(type)) + ": " + text);
  }
}

std::string gl_string(GLenum name) {
  const auto* text = reinterpret_cast<const char*>(glGetString(name));
  return text ? text : "";
}

Result<std::unique_ptr<Context::Backend>> make_backend(const ContextOptions& options) {
  if (options.width < 1 || options.height < 1 || options.width > 16384 || options.height > 16384) {
    return Error{ErrorCode::kUsage, "a context needs a size from 1x1 to 16384x16384 pixels, not " +
                                        std::to_string(options.width) + "x" + std::to_string(options.height)};
  }
  switch (options.kind) {
    case ContextKind::kOsmesa: return make_osmesa_backend(options);
    case ContextKind::kEgl: return make_egl_backend(options);
    case ContextKind::kWindow: return make_window_backend(options);
  }
  return Error{ErrorCode::kUsage, "unknown kind of context"};
}

}  // namespace

const char* context_kind_name(ContextKind kind) {
  switch (kind) {
    case ContextKind::kOsmesa: return "osmesa";
    case ContextKind::kEgl: return "egl";
    case ContextKind::kWindow: return "window";
  }
  return "";
}

Result<ContextKind> context_kind_from_name(const std::string& name) {
  for (const ContextKind kind : {ContextKind::kOsmesa, ContextKind::kEgl, ContextKind::kWindow}) {
    if (name == context_kind_name(kind)) return kind;
  }
  return Error{ErrorCode::kUsage, "unknown context '" + name + "'; use osmesa, egl or window"};
}

Context::Context(std::unique_ptr<State> state) : state_(std::move(state)) {}

void Context::release_current() {
  if (!current_context) return;
  current_context->state_->backend->release();
  current_context->state_->in_use = false;
  current_context = nullptr;
}

Result<std::unique_ptr<Context>> Context::create(const ContextOptions& options) {
  // GLFW makes its context current as it creates it, and GLX refuses that (BadAccess) while one of EGL is.
  Context* const former = current();
  release_current();
  Result<std::unique_ptr<Context>> created = create_current(options);
  if (!created && former) {
    if (const Status status = former->make_current(); !status) return status.error();
  }
  return created;
}

Result<std::unique_ptr<Context>> Context::create_current(const ContextOptions& options) {
  auto backend = make_backend(options);
  if (!backend) return backend.error();
  auto state = std::make_unique<State>();
  state->options = options;
  state->backend = std::move(*backend);
  std::unique_ptr<Context> context(new Context(std::move(state)));
  const Status status = context->make_current();
  if (!status) return status.error();

  State& made = *context->state_;
  made.vendor = gl_string(GL_VENDOR);
  made.renderer = gl_string(GL_RENDERER);
  made.version = gl_string(GL_VERSION);
  if (options.debug) {
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    glDebugMessageCallback(
        [](GLenum source, GLenum type, GLuint, GLenum severity, GLsizei, const GLchar* text, const void* user) {
          auto* target = static_cast<State*>(const_cast<void*>(user));
          if (is_fault(source, type, severity)) add_message(target->debug_mutex, target->debug_messages, type, text);
        },
        &made);
  }
  return context;
}

Context::~Context() {
  // Nothing is current while the driver destroys: OSMesa would put aside and restore the context of another driver.
  Context* const former = is_current() ? nullptr : current();
  if (is_current()) glFinish();
  release_current();
  state_->backend.reset();
  if (former) {
    [[maybe_unused]] const Status status = former->make_current();
    assert(status.ok());
  }
}

Status Context::make_current() {
  if (is_current()) return Done{};
  // Release first: the drivers share the thread's dispatch table, but each remembers only its own current context.
  release_current();
  const std::string name = std::string("the ") + context_kind_name(kind()) + " context";
  if (state_->in_use.exchange(true)) return Error{ErrorCode::kContext, name + " is current in another thread"};
  Status status = Done{};
  if (state_->backend->make_current()) {
    status = load_functions(kind(), *state_->backend);
    if (!status) state_->backend->release();
  } else {
    status = Error{ErrorCode::kContext, "the driver refuses to make " + name + " current"};
  }
  if (!status) {
    state_->in_use = false;
    return status;
  }
  current_context = this;
  return Done{};
}

bool Context::is_current() const { return current_context == this; }
Context* Context::current() { return current_context; }
ContextKind Context::kind() const { return state_->options.kind; }
const std::string& Context::vendor() const { return state_->vendor; }
const std::string& Context::renderer() const { return state_->renderer; }
const std::string& Context::version() const { return state_->version; }

bool Context::is_software() const {
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "Software Rasterizer"}) {
    if (state_->renderer.find(name) != std::string::npos) return true;
  }
  return false;
}

PixelSize Context::framebuffer_size() const { return state_->backend->framebuffer_size(); }

std::vector<std::string> Context::take_debug_messages() {
  const std::lock_guard lock(state_->debug_mutex);
  return std::exchange(state_->debug_messages, {});
}

void Context::swap_buffers() { state_->backend->swap_buffers(); }
void Context::poll() { state_->backend->poll(); }
bool Context::should_close() const { return state_->backend->should_close(); }
void Context::set_should_close(bool close) { state_->backend->set_should_close(close); }
bool Context::key_down(Key key) const { return state_->backend->key_down(static_cast<int>(key)); }
bool Context::key_down(char letter_or_digit) const { return state_->backend->key_down(letter_or_digit); }
bool Context::mouse_down(int button) const { return state_->backend->mouse_down(button); }
CursorPosition Context::cursor() const { return state_->backend->cursor(); }
void* Context::native_window() const { return state_->backend->native_window(); }

}  // namespace roadgen
