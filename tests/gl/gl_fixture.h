// Fixture of the tests that need OpenGL: contexts of every kind, a display if there is none, and no complaint of the
// driver left unseen.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "roadgen/render/context.h"

namespace roadgen::test {

// Sets DISPLAY to an X server in memory (Xvfb) that lives as long as this process, unless DISPLAY is set already.
// False if neither is to be had.
bool ensure_display();

// Options of a debug context of a small size. The environment variable ROADGEN_TEST_EGL_DEVICE chooses kEgl's device.
ContextOptions test_options(ContextKind kind);

// Fails if, after a test, a context that it made has a message of KHR_debug or a pending OpenGL error.
class GlTest : public ::testing::Test {
 protected:
  // A new current context. Null, with the test marked as skipped, if this machine has no such kind; OSMesa must be had.
  Context* make_context(ContextKind kind);
  void TearDown() override;
  // Asserts that no context has complained so far.
  void expect_no_complaints();

  std::vector<std::unique_ptr<Context>> contexts_;
};

}  // namespace roadgen::test
