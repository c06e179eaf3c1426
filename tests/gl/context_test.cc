// Contexts of every kind, alone and together in one process.
#include "roadgen/render/context.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include "roadgen/render/gl.h"
#include "roadgen/render/program.h"
#include "roadgen/render/render_target.h"
#include "tests/gl/gl_fixture.h"

namespace roadgen::test {
namespace {

constexpr ContextKind kKinds[] = {ContextKind::kOsmesa, ContextKind::kEgl, ContextKind::kWindow};

// The test's own shaders stand in the override folder.
class ContextTest : public GlTest {
 protected:
  ContextTest() { setenv("ROADGEN_SHADER_DIR", ROADGEN_SOURCE_DIR "/tests/gl/shaders", 1); }
};

// Reversed z: near is 1, far is 0.
void clear_reversed() {
  glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glClearDepth(0);
  glClearColor(0.2f, 0.3f, 0.5f, 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

struct Picture {
  Image8 color;
  ImageF depth;
};

Picture draw_scene() {
  Picture picture;
  Result<RenderTarget> target = RenderTarget::create({.width = 320, .height = 240});
  Result<Program> program = Program::graphics("scene.vert", "scene.frag");
  EXPECT_TRUE(target.ok()) << target.error().text();
  EXPECT_TRUE(program.ok()) << program.error().text();
  if (!target || !program) return picture;
  const gl::VertexArray no_vertices = gl::VertexArray::create();
  target->bind();
  glEnable(GL_FRAMEBUFFER_SRGB);  // clearing heeds it too
  clear_reversed();
  glBindVertexArray(no_vertices.id());
  program->use();
  glDrawArraysInstanced(GL_TRIANGLES, 0, 3, 40);
  picture = {target->read_rgba8(), target->read_depth()};
  glUseProgram(0);
  glBindVertexArray(0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  return picture;
}

// Mean and greatest difference of 8-bit colours. One renderer draws the same picture in every kind of context. Two
// renderers may disagree on pixels at silhouettes, which is a pixel's whole difference, and round otherwise elsewhere.
void expect_same_picture(const Picture& a, const Picture& b, bool same_renderer) {
  const Result<ImageDifference> color = compare(a.color, b.color), depth = compare(a.depth, b.depth);
  ASSERT_TRUE(color.ok() && depth.ok());
  std::printf("color: max %g, mean %g; depth: max %g, mean %g\n", color->max, color->mean, depth->max, depth->mean);
  EXPECT_LE(color->max, same_renderer ? 0 : 255);
  EXPECT_LE(color->mean, same_renderer ? 0 : 0.5);
  EXPECT_LE(depth->mean, same_renderer ? 0 : 2e-3);
}

class ContextOfKind : public ContextTest, public ::testing::WithParamInterface<ContextKind> {};

TEST_P(ContextOfKind, IsOpenGl45Core) {
  Context* context = make_context(GetParam());
  if (!context) return;
  EXPECT_EQ(context->kind(), GetParam());
  EXPECT_TRUE(context->is_current());
  EXPECT_EQ(Context::current(), context);
  GLint major = 0, minor = 0, profile = 0;
  glGetIntegerv(GL_MAJOR_VERSION, &major);
  glGetIntegerv(GL_MINOR_VERSION, &minor);
  glGetIntegerv(GL_CONTEXT_PROFILE_MASK, &profile);
  EXPECT_GE(10 * major + minor, 45);
  EXPECT_EQ(profile, GL_CONTEXT_CORE_PROFILE_BIT);
  std::printf("%s: %s, %s\n", context_kind_name(GetParam()), context->renderer().c_str(), context->version().c_str());
  EXPECT_FALSE(context->vendor().empty());
  EXPECT_EQ(context->is_software(), context->renderer().find("llvmpipe") != std::string::npos);
}

TEST_P(ContextOfKind, DrawsWithReversedDepth) {
  if (!make_context(GetParam())) return;
  Result<RenderTarget> target = RenderTarget::create({.width = 16, .height = 8, .color_formats = {GL_RGBA8}});
  ASSERT_TRUE(target.ok()) << target.error().text();
  Result<Program> program = Program::graphics("layer.vert", "layer.frag");
  ASSERT_TRUE(program.ok()) << program.error().text();
  const gl::VertexArray no_vertices = gl::VertexArray::create();
  target->bind();
  clear_reversed();
  glBindVertexArray(no_vertices.id());
  program->use();
  const auto layer = [&](float z, glm::vec3 color) {
    program->set("z", z);
    program->set("color", color);
    glDrawArrays(GL_TRIANGLES, 0, 3);
  };
  layer(0.25f, {1, 0, 0});
  layer(0.75f, {0, 1, 0});
  layer(0.5f, {0, 0, 1});
  const Image8 color = target->read_rgba8();
  EXPECT_EQ(color.at(3, 3, 0), 0);
  EXPECT_EQ(color.at(3, 3, 1), 255);
  EXPECT_EQ(color.at(3, 3, 2), 0);
  EXPECT_EQ(target->read_depth().at(15, 7, 0), 0.75f);
}

TEST_P(ContextOfKind, ReportsOpenGlErrors) {
  Context* context = make_context(GetParam());
  if (!context) return;
  glBindTexture(GL_TRIANGLES, 0);
  EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_INVALID_ENUM));
  const std::vector<std::string> messages = context->take_debug_messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].rfind("error: ", 0), 0u) << messages[0];
  EXPECT_TRUE(context->take_debug_messages().empty());
}

TEST_P(ContextOfKind, ResolvesSamples) {
  if (!make_context(GetParam())) return;
  const RenderTargetOptions options{.width = 8, .height = 8, .samples = 4};
  Result<RenderTarget> target = RenderTarget::create(options);
  ASSERT_TRUE(target.ok()) << target.error().text();
  RenderTargetOptions flat = options;
  flat.samples = 1;
  Result<RenderTarget> resolved = RenderTarget::create(flat);
  ASSERT_TRUE(resolved.ok()) << resolved.error().text();
  target->bind();
  glClearColor(0, 1, 0, 1);
  glClearDepth(0.5);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  target->resolve_into(*resolved);
  EXPECT_EQ(resolved->read_rgba8().at(4, 4, 1), 255);
  EXPECT_EQ(resolved->read_depth().at(4, 4, 0), 0.5f);
}

INSTANTIATE_TEST_SUITE_P(, ContextOfKind, ::testing::ValuesIn(kKinds),
                         [](const auto& test) { return context_kind_name(test.param); });

TEST_F(ContextTest, PicturesOfAllKindsAgree) {
  Context* const reference = make_context(ContextKind::kOsmesa);
  ASSERT_TRUE(reference);
  const Picture expected = draw_scene();
  int colors = 0;  // the scene shows something
  for (size_t i = 4; i < expected.color.pixels.size(); i += 4) {
    colors += expected.color.pixels[i] != expected.color.pixels[i - 4];
  }
  EXPECT_GT(colors, 1000);
  for (const ContextKind kind : {ContextKind::kEgl, ContextKind::kWindow}) {
    Context* const context = make_context(kind);
    if (!context) continue;
    expect_same_picture(expected, draw_scene(), context->renderer() == reference->renderer());
  }
}

TEST_F(ContextTest, KindsAlternateInOneProcess) {
  for (int round = 0; round < 2; ++round) {
    for (const ContextKind kind : kKinds) make_context(kind);
  }
  std::vector<Picture> first;
  for (const auto& context : contexts_) {
    ASSERT_TRUE(context->make_current().ok());
    first.push_back(draw_scene());
  }
  for (int round = 0; round < 3; ++round) {
    for (size_t i = 0; i < contexts_.size(); ++i) {
      const Status status = contexts_[i]->make_current();
      ASSERT_TRUE(status.ok()) << status.error().text();
      expect_same_picture(first[i], draw_scene(), true);
    }
  }
  // In any order of ends, the others go on.
  while (contexts_.size() > 1) {
    expect_no_complaints();
    contexts_.erase(contexts_.begin() + static_cast<std::ptrdiff_t>(contexts_.size() / 2));
    ASSERT_TRUE(contexts_.front()->make_current().ok());
    expect_same_picture(first.front(), draw_scene(), true);
  }
}

TEST_F(ContextTest, WindowWithoutADisplayIsAClearErrorAndKeepsTheFormerContext) {
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  Context* const former = make_context(ContextKind::kOsmesa);
  ASSERT_TRUE(former);
  const auto window = Context::create(test_options(ContextKind::kWindow));
  ASSERT_FALSE(window.ok());
  EXPECT_EQ(window.error().code, ErrorCode::kContext);
  EXPECT_NE(window.error().message.find("set DISPLAY"), std::string::npos) << window.error().text();
  EXPECT_NE(window.error().message.find("--context osmesa"), std::string::npos) << window.error().text();
  EXPECT_EQ(Context::current(), former);
  EXPECT_FALSE(draw_scene().color.pixels.empty());
}

TEST_F(ContextTest, EglDeviceOutOfRangeIsAClearError) {
  ContextOptions options = test_options(ContextKind::kEgl);
  options.egl_device = 1000;
  const auto context = Context::create(options);
  ASSERT_FALSE(context.ok());
  EXPECT_EQ(context.error().code, ErrorCode::kContext);
  EXPECT_FALSE(Context::current());
}

TEST_F(ContextTest, EveryEglDeviceEitherWorksOrSaysWhyNot) {
  ContextOptions options = test_options(ContextKind::kEgl);
  for (options.egl_device = 0; options.egl_device < 8; ++options.egl_device) {
    const auto context = Context::create(options);
    std::printf("device %d: %s\n", options.egl_device,
                context.ok() ? (*context)->renderer().c_str() : context.error().text().c_str());
    if (context.ok()) {
      EXPECT_FALSE(draw_scene().color.pixels.empty());
    }
  }
}

TEST_F(ContextTest, SizeOutOfRangeIsAnError) {
  ContextOptions options = test_options(ContextKind::kOsmesa);
  options.width = 0;
  const auto context = Context::create(options);
  ASSERT_FALSE(context.ok());
  EXPECT_EQ(context.error().code, ErrorCode::kUsage);
}

TEST_F(ContextTest, NamesOfKindsRoundTrip) {
  for (const ContextKind kind : kKinds) {
    const auto parsed = context_kind_from_name(context_kind_name(kind));
    ASSERT_TRUE(parsed.ok());
    EXPECT_EQ(*parsed, kind);
  }
  EXPECT_FALSE(context_kind_from_name("glx").ok());
}

TEST_F(ContextTest, IsCurrentInOneThreadAtATime) {
  Context* const context = make_context(ContextKind::kOsmesa);
  ASSERT_TRUE(context);
  const Picture expected = draw_scene();
  std::thread([&] { EXPECT_FALSE(context->make_current().ok()); }).join();
  Context::release_current();
  EXPECT_FALSE(Context::current());
  std::thread([&] {
    ASSERT_TRUE(context->make_current().ok());
    expect_same_picture(expected, draw_scene(), true);
    Context::release_current();
  }).join();
}

TEST_F(ContextTest, WindowHasASizeAndSwapsAndHasNoInput) {
  Context* const context = make_context(ContextKind::kWindow);
  if (!context) return;
  EXPECT_EQ(context->framebuffer_size().width, 64);
  EXPECT_EQ(context->framebuffer_size().height, 48);
  EXPECT_TRUE(context->native_window());
  context->swap_buffers();
  context->poll();
  EXPECT_FALSE(context->key_down(Key::kEscape));
  EXPECT_FALSE(context->key_down('W'));
  EXPECT_FALSE(context->mouse_down(0));
  EXPECT_FALSE(context->should_close());
  context->set_should_close(true);
  EXPECT_TRUE(context->should_close());
}

}  // namespace
}  // namespace roadgen::test
