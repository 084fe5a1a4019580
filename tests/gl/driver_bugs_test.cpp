// SPDX-License-Identifier: MIT
// The bugs that gl_caps.h works around, seen in the driver itself: a test that fails tells that a work-around
// can go.
#include <cstring>

#include <gtest/gtest.h>

#include "platform/headless/headless_display.h"
#include "renderer/gl/gl_caps.h"

namespace karst::core {
namespace {

TEST(DriverBugs, FirstTimerResultOfLlvmpipeIsWrong) {
  // A context of its own: the bug shows once in each.
  Error error;
  auto display = open_headless_display({}, error);
  ASSERT_NE(display, nullptr) << error.text();
  const GlLoader loader{
      .load = [](void* d, const char* name) { return static_cast<Display*>(d)->gl_function(name); },
      .user = display.get()};
  Gl gl;
  ASSERT_TRUE(load_gl(loader, false, gl).ok());
  GlCaps caps;
  ASSERT_TRUE(query_gl_caps(gl, false, caps).ok());

  double elapsed_ms = 0;
  if (caps.timer_query) {
    GLuint names[3];  // texture, framebuffer, query
    gl.GenTextures(1, &names[0]);
    gl.BindTexture(GL_TEXTURE_2D, names[0]);
    gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_DEPTH_COMPONENT24, 16, 16);
    gl.GenFramebuffers(1, &names[1]);
    gl.BindFramebuffer(GL_FRAMEBUFFER, names[1]);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, names[0], 0);
    gl.GenQueriesEXT(1, &names[2]);
    gl.BeginQueryEXT(GL_TIME_ELAPSED_EXT, names[2]);
    const GLfloat far = 1.0f;
    gl.ClearBufferfv(GL_DEPTH, 0, &far);
    gl.EndQueryEXT(GL_TIME_ELAPSED_EXT);
    gl.Finish();
    GLuint64 elapsed_ns = 0;
    gl.GetQueryObjectui64vEXT(names[2], GL_QUERY_RESULT_EXT, &elapsed_ns);
    elapsed_ms = static_cast<double>(elapsed_ns) * 1e-6;
  }
  if (!caps.first_timer_result_is_wrong || std::strstr(caps.version, "Mesa 22.3") == nullptr) {
    GTEST_SKIP() << "not llvmpipe of Mesa 22.3: " << caps.renderer << ", " << caps.version;
  }
  ASSERT_TRUE(caps.timer_query);
  EXPECT_GT(elapsed_ms, 10'000.0) << "clearing 16 x 16 pixels";
}

}  // namespace
}  // namespace karst::core
