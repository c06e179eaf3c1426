#include "tests/gl/gl_fixture.h"

#include <fcntl.h>
#include <glad/gl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <string>

namespace roadgen::test {
namespace {

// An Xvfb process; it picks a free display number itself and tells it through a pipe.
class Xvfb {
 public:
  Xvfb() {
    int pipe_ends[2];
    if (pipe(pipe_ends) != 0) return;
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGTERM);
      close(pipe_ends[0]);
      const int nowhere = open("/dev/null", O_WRONLY);
      dup2(nowhere, STDOUT_FILENO);
      dup2(nowhere, STDERR_FILENO);
      const std::string end = std::to_string(pipe_ends[1]);
      execlp("Xvfb", "Xvfb", "-displayfd", end.c_str(), "-screen", "0", "1280x1024x24", "-nolisten", "tcp", nullptr);
      _exit(127);
    }
    close(pipe_ends[1]);
    char character = 0;
    while (read(pipe_ends[0], &character, 1) == 1 && character != '\n') number_ += character;
    close(pipe_ends[0]);
  }
  ~Xvfb() {
    if (process_ <= 0) return;
    kill(process_, SIGTERM);
    waitpid(process_, nullptr, 0);
  }
  Xvfb(const Xvfb&) = delete;
  Xvfb& operator=(const Xvfb&) = delete;

  const std::string& number() const { return number_; }

 private:
  pid_t process_ = -1;
  std::string number_;  // empty if it did not start
};

}  // namespace

bool ensure_display() {
  if (getenv("DISPLAY")) return true;
  static const Xvfb server;
  if (server.number().empty()) return false;
  setenv("DISPLAY", (":" + server.number()).c_str(), 1);
  return true;
}

ContextOptions test_options(ContextKind kind) {
  ContextOptions options;
  options.kind = kind;
  options.width = 64;
  options.height = 48;
  options.visible = false;
  options.vsync = false;
  options.debug = true;
  if (const char* device = getenv("ROADGEN_TEST_EGL_DEVICE")) options.egl_device = atoi(device);
  return options;
}

Context* GlTest::make_context(ContextKind kind) {
  const auto skip = [kind](const std::string& why) { GTEST_SKIP() << context_kind_name(kind) << ": " << why; };
  if (kind == ContextKind::kWindow && !ensure_display()) {
    skip("no display and no Xvfb");
    return nullptr;
  }
  Result<std::unique_ptr<Context>> context = Context::create(test_options(kind));
  if (!context) {
    if (kind == ContextKind::kOsmesa) {
      ADD_FAILURE() << context.error().text();
    } else {
      skip(context.error().text());
    }
    return nullptr;
  }
  contexts_.push_back(std::move(*context));
  return contexts_.back().get();
}

void GlTest::expect_no_complaints() {
  for (const auto& context : contexts_) {
    const Status status = context->make_current();
    ASSERT_TRUE(status.ok()) << status.error().text();
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR)) << context_kind_name(context->kind());
    for (const std::string& message : context->take_debug_messages()) {
      ADD_FAILURE() << context_kind_name(context->kind()) << ": " << message;
    }
  }
}

void GlTest::TearDown() {
  expect_no_complaints();
  contexts_.clear();
}

}  // namespace roadgen::test
