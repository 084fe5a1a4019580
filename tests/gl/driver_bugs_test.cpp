// SPDX-License-Identifier: MIT
// The bugs that gl_caps.h works around, seen in the driver itself: a test that fails tells that a work-around
// can go.
#include <cstring>
#include <utility>

#include <gtest/gtest.h>

#include "platform/headless/headless_display.h"
#include "renderer/gl/gl_caps.h"
#include "tests/gl/gl_fixture.h"

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

constexpr const char kPlaces[] = R"(#version 300 es
// As they stood in a frame of a region: two vertices that move to the same place have all but met. Then a
// triangle that is partly beyond the picture.
const vec4 kPlaces[6] = vec4[6](
    vec4(3.6270833015441895, -0.9231255054473877, 3.8008551597595215, 4.000464916229248),
    vec4(3.528625249862671, -0.5851953029632568, 3.8704185485839844, 4.070021629333496),
    vec4(3.5284435749053955, -0.584571123123169, 3.87054705619812, 4.070149898529053),
    vec4(-2.0, -0.8, 0.0, 1.0), vec4(-0.8, -0.8, 0.0, 1.0), vec4(-0.8, -0.7, 0.0, 1.0));
void main() { gl_Position = kPlaces[gl_VertexID]; })";
constexpr const char kWhite[] = R"(#version 300 es
precision mediump float;
out vec4 colour;
void main() { colour = vec4(1.0); })";

// Whether the sliver covers its pixel, where it is drawn alone or with the clipped triangle.
bool covers(test::GlContext& context, int vertices, bool cull) {
  const Gl& gl = context.gl();
  constexpr int kWidth = 160, kHeight = 120;
  GLuint texture = 0, framebuffer = 0, array = 0;
  gl.GenTextures(1, &texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexStorage2D(GL_TEXTURE_2D, 1, GL_RGBA8, kWidth, kHeight);
  gl.GenFramebuffers(1, &framebuffer);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  gl.GenVertexArrays(1, &array);
  gl.BindVertexArray(array);
  const GLuint program = gl.CreateProgram();
  for (const auto& [stage, text] :
       {std::pair(GL_VERTEX_SHADER, kPlaces), std::pair(GL_FRAGMENT_SHADER, kWhite)}) {
    const GLuint shader = gl.CreateShader(static_cast<GLenum>(stage));
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.DeleteShader(shader);
  }
  gl.LinkProgram(program);
  gl.UseProgram(program);
  gl.Viewport(0, 0, kWidth, kHeight);
  const GLfloat black[4] = {};
  gl.ClearBufferfv(GL_COLOR, 0, black);
  if (cull) gl.Enable(GL_CULL_FACE);
  gl.DrawArrays(GL_TRIANGLES, 0, vertices);
  gl.Disable(GL_CULL_FACE);
  std::uint8_t pixel[4] = {};
  context.function<PFNGLREADPIXELSPROC>("glReadPixels")(150, 49, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
  EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
  gl.UseProgram(0);
  gl.DeleteProgram(program);
  gl.DeleteVertexArrays(1, &array);
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl.DeleteFramebuffers(1, &framebuffer);
  gl.DeleteTextures(1, &texture);
  return pixel[0] == 255;
}

TEST(DriverBugs, LlvmpipeCullsByCornersBeforeItRoundsThem) {
  test::GlContext& context = test::GlContext::get();
  ASSERT_TRUE(context.ok());
  GlCaps caps;
  ASSERT_TRUE(query_gl_caps(context.gl(), false, caps).ok());
  if (!caps.culls_unrounded) GTEST_SKIP() << "not llvmpipe: " << caps.renderer;
  EXPECT_TRUE(covers(context, 3, false));
  EXPECT_TRUE(covers(context, 6, false));
  EXPECT_TRUE(covers(context, 3, true));
  EXPECT_FALSE(covers(context, 6, true));
}

}  // namespace
}  // namespace karst::core
