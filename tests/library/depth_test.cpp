// SPDX-License-Identifier: MIT
// Depth over a range of a million: as an eye at a person's height over a world of 100 km has it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/library/host.h"
#include "tests/support/hilly_world.h"

namespace karst {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 180;
constexpr double kNearOfFar = 1e-6;  // 0.1 m of 100 km
constexpr double kPlainNear = 0.2;   // m; less than the way to anything that the views see
constexpr int kViews = 16;

// Views along the ground from one side to another, ridge behind ridge.
ViewState along_the_ground(const World& world, int n) {
  const WorldInfo& info = world.info();
  const Vec3 middle{(info.low_m.x + info.high_m.x) / 2, 0, (info.low_m.z + info.high_m.z) / 2};
  const double angle = n * (6.283185307179586 / kViews);
  const double radius = 0.45 * (info.high_m.x - info.low_m.x);
  const Vec3 eye{middle.x + radius * std::cos(angle), info.high_m.y + 0.5,
                 middle.z + radius * std::sin(angle)};
  return test::looking(world, eye, {middle.x, info.high_m.y - 2, middle.z}, kWidth, kHeight);
}

// Just beyond the world's farthest corner on the ground.
double far_of(const World& world, const ViewState& view) {
  const WorldInfo& info = world.info();
  double farthest = 0;
  for (const double x : {info.low_m.x, info.high_m.x}) {
    for (const double z : {info.low_m.z, info.high_m.z}) {
      farthest = std::max(farthest, std::hypot(x - view.eye.x, z - view.eye.z));
    }
  }
  return 1.01 * farthest;
}

class Depth : public testing::Test {
 protected:
  test::Pixels shot(const test::HostPicture& picture, Renderer& renderer, int n, double near_m, double far_m,
                    bool reversed, bool two_ranges = false) const {
    ViewState view = along_the_ground(*host_.world, n);
    view.reversed_depth = reversed;
    set_perspective(view, 60, near_m, far_m);
    Target target;
    target.viewport = {0, 0, kWidth, kHeight};
    target.depth_zero_to_one = reversed;
    target.two_ranges = two_ranges;
    target.framebuffer = picture.name();
    test::draw_frame(renderer, picture, {view}, 0, &target);
    return picture.read();
  }
  // Pixels of all views that show another surface than with a near plane further away.
  std::size_t order_errors(GLenum format, bool reversed, double near_of_far, bool two_ranges = false,
                           Shading shading = Shading::forward, int step = 1) {
    test::HostPicture picture(kWidth, kHeight, format);
    Renderer* renderer = nullptr;
    GlOptions options;
    options.shading = shading;
    EXPECT_TRUE(Renderer::create(*host_.world, picture.loader(), options, renderer).ok());
    if (renderer == nullptr) return 0;
    double errors = 0;
    for (int n = 0; n < kViews; n += step) {
      const double far_m = far_of(*host_.world, along_the_ground(*host_.world, n));
      const test::Pixels plain = shot(picture, *renderer, n, kPlainNear, far_m, false);
      errors += test::share_beyond(
          plain, shot(picture, *renderer, n, near_of_far * far_m, far_m, reversed, two_ranges), 0);
    }
    renderer->destroy();
    return static_cast<std::size_t>(errors * kWidth * kHeight + 0.5);
  }

  static Needs needs() {
    Needs needs;
    needs.deferred_width = kWidth;
    needs.deferred_height = kHeight;
    return needs;
  }
  test::HostWorld host_{needs(), {}, test::wide_world().file()};
};

TEST_F(Depth, ReversedFloatsHaveNoOrderErrors) {
  for (const double part : {1.0, 0.1}) {
    EXPECT_EQ(order_errors(GL_DEPTH_COMPONENT32F, true, part * kNearOfFar), 0u) << part;
  }
}

// Why docs/library.md names a format.
TEST_F(Depth, WholeNumbersHave) {
  const std::size_t errors = order_errors(GL_DEPTH_COMPONENT24, false, kNearOfFar);
  EXPECT_GT(errors, 0u);
  std::printf("%zu of %d pixels\n", errors, kViews * kWidth * kHeight);
}

// Without clip control: forward, and where pixels are shaded once.
TEST_F(Depth, TwoRangesHaveNone) {
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    EXPECT_EQ(order_errors(GL_DEPTH_COMPONENT24, false, kNearOfFar, true, shading, 2), 0u)
        << (shading == Shading::deferred);
  }
}

// Nothing is drawn twice where one range does.
TEST_F(Depth, OneRangeIsDrawnOnceWhereItDoes) {
  test::HostPicture picture(kWidth, kHeight);
  Renderer* renderer = nullptr;
  ASSERT_TRUE(Renderer::create(*host_.world, picture.loader(), {}, renderer).ok());
  // The first frame draws shadow maps too.
  shot(picture, *renderer, 0, 1, far_of(*host_.world, along_the_ground(*host_.world, 0)), false);
  std::uint64_t triangles[2][2];
  for (const bool two : {false, true}) {
    for (const bool wide : {false, true}) {
      const double far_m = far_of(*host_.world, along_the_ground(*host_.world, 0));
      shot(picture, *renderer, 0, wide ? kNearOfFar * far_m : far_m / 2000, far_m, false, two);
      triangles[two][wide] = costs(*renderer).triangles;
    }
  }
  EXPECT_EQ(triangles[0][0], triangles[1][0]);
  EXPECT_LT(triangles[0][1], triangles[1][1]);
  renderer->destroy();
}

// What a host draws by depth_ranges(): pairs of surfaces, one a four thousandth of its distance behind the
// other, from 0.1 m to 100 km; in how many the one behind is seen.
int pairs_out_of_order(GLenum format, bool two_ranges) {
  constexpr int kPairs = 256;
  test::HostPicture picture(kPairs, 2, format);
  const auto compile = [](GLenum kind, const char* text) {
    const GLuint shader = glCreateShader(kind);
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    return shader;
  };
  const GLuint program = glCreateProgram();
  glAttachShader(program, compile(GL_VERTEX_SHADER, R"(#version 300 es
uniform highp mat4 clip_from_view;
uniform highp float distance_m;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
  gl_Position = clip_from_view * vec4(corner * distance_m * 2.0, -distance_m, 1.0);
})"));
  glAttachShader(program, compile(GL_FRAGMENT_SHADER, R"(#version 300 es
uniform highp vec4 shown;
out highp vec4 colour;
void main() { colour = shown; })"));
  glLinkProgram(program);
  glUseProgram(program);
  GLuint array = 0;
  glGenVertexArrays(1, &array);
  glBindVertexArray(array);
  picture.clear();
  glViewport(0, 0, kPairs, 2);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_SCISSOR_TEST);
  ViewState view;
  view.width_px = view.height_px = 64;
  set_perspective(view, 60, 0.1, 1e5);
  DepthRange ranges[2];
  std::uint32_t count = depth_ranges(view, ranges);
  EXPECT_EQ(count, 2u);
  if (!two_ranges) ranges[0] = {0.1, 1e5, 0, 1}, count = 1;
  for (std::uint32_t n = 0; n < count; ++n) {
    ViewState part = view;
    set_perspective(part, 60, ranges[n].near_m, ranges[n].far_m);
    glDepthRangef(ranges[n].buffer_near, ranges[n].buffer_far);
    GLfloat clip[16];
    for (int e = 0; e < 16; ++e) clip[e] = static_cast<GLfloat>(part.clip_from_view[e]);
    glUniformMatrix4fv(glGetUniformLocation(program, "clip_from_view"), 1, GL_FALSE, clip);
    for (int pair = 0; pair < kPairs; ++pair) {
      const double front = 0.101 * std::pow(0.989e6, pair / (kPairs - 1.0));
      // Both orders, a row each.
      for (int row = 0; row < 2; ++row) {
        glScissor(pair, row, 1, 1);
        for (const int turn : {0, 1}) {
          const bool behind = turn == row;
          glUniform1f(glGetUniformLocation(program, "distance_m"),
                      static_cast<GLfloat>(behind ? front * (1 + 1.0 / 4000) : front));
          glUniform4f(glGetUniformLocation(program, "shown"), behind ? 1 : 0, behind ? 0 : 1, 0, 1);
          glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        }
      }
    }
  }
  const test::Pixels pixels = picture.read();
  int wrong = 0;
  for (int pair = 0; pair < kPairs; ++pair) {
    if (pixels.at(pair, 0)[1] != 255 || pixels.at(pair, 1)[1] != 255) ++wrong;
  }
  glDeleteVertexArrays(1, &array);
  glDeleteProgram(program);
  return wrong;
}

TEST(DepthRanges, KeepKnownSurfacesInOrder) {
  for (const GLenum format : {GLenum{GL_DEPTH_COMPONENT24}, GLenum{GL_DEPTH_COMPONENT32F}}) {
    EXPECT_EQ(pairs_out_of_order(format, true), 0) << format;
    EXPECT_GT(pairs_out_of_order(format, false), 50) << format;
  }
}

TEST(DepthRanges, AreOneWhereOneDoes) {
  ViewState view;
  view.width_px = view.height_px = 64;
  DepthRange ranges[2];
  set_perspective(view, 60, 1, 2000);
  EXPECT_EQ(depth_ranges(view, ranges), 1u);
  EXPECT_NEAR(ranges[0].near_m, 1, 1e-9);
  EXPECT_NEAR(ranges[0].far_m, 2000, 1e-6);
  set_perspective(view, 60, 0.1, 1e5);
  EXPECT_EQ(depth_ranges(view, ranges), 2u);
  EXPECT_NEAR(ranges[0].near_m, 0.1, 1e-9);
  EXPECT_NEAR(ranges[1].near_m, 100, 1e-6);
  EXPECT_NEAR(ranges[1].far_m, 1e5, 1e-3);
  EXPECT_GT(ranges[0].far_m, ranges[1].near_m);
  view.reversed_depth = true;
  set_perspective(view, 60, 0.1, 1e5);
  EXPECT_EQ(depth_ranges(view, ranges), 1u);
}

}  // namespace
}  // namespace karst
