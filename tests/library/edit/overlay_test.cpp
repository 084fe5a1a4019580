// SPDX-License-Identifier: MIT
// What programs draw over the terrain: before it and behind it in every kind of depth, and what is left.
#include "app/overlay/overlay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "tests/library/host.h"

namespace karst {
namespace {

using app::Overlay;
using app::OverlayMesh;
using app::Rgba;

constexpr int kWidth = 160, kHeight = 90;

class OverlayTest : public testing::Test {
 protected:
  static Needs needs() {
    Needs needs;
    needs.queries = 1;
    needs.shadow_maps = 0;
    needs.deferred_width = kWidth;
    needs.deferred_height = kHeight;
    return needs;
  }
  // From above the hills; what is met in the picture's middle.
  ViewState view(double near_m, double far_m, bool reversed) {
    ViewState view = test::looking(*host_.world, {20, 30, 50}, {20, 9, 14}, kWidth, kHeight);
    view.reversed_depth = reversed;
    set_perspective(view, 60, near_m, far_m);
    return view;
  }
  static Vec3 on_the_way(Vec3 a, Vec3 b, double part) {
    return {a.x + (b.x - a.x) * part, a.y + (b.y - a.y) * part, a.z + (b.z - a.z) * part};
  }

  // Draws the terrain, and over it a line on the ground across the picture's middle, and one behind the
  // ground a quarter below; how the middle pixels of both come out.
  void expect_lines(Shading shading, GLenum depth, double near_m, double far_m, bool reversed,
                    bool two_ranges) {
    test::HostPicture picture(kWidth, kHeight, depth);
    GlOptions options;
    options.shading = shading;
    Renderer* renderer = nullptr;
    ASSERT_TRUE(Renderer::create(*host_.world, picture.loader(), options, renderer).ok());
    const ViewState seen = view(near_m, far_m, reversed);
    Target target;
    target.viewport = {0, 0, kWidth, kHeight};
    target.framebuffer = picture.name();
    target.depth_zero_to_one = reversed;
    target.two_ranges = two_ranges;
    test::draw_frame(*renderer, picture, {seen}, 0, &target);
    const test::Pixels before = picture.read();
    picture.bind();
    Overlay overlay;
    ASSERT_TRUE(overlay.create(picture.loader()).ok());
    OverlayMesh mesh;
    mesh.start(seen, 0);
    Query* query = nullptr;
    ASSERT_TRUE(host_.world->take_query(query).ok());
    Hit hit;
    ASSERT_TRUE(query->ray(seen.eye, on_the_way(seen.eye, {20, 9, 14}, 3), Wait::for_file, hit));
    mesh.line({hit.place.x - 4, hit.place.y + 0.05, hit.place.z},
              {hit.place.x + 4, hit.place.y + 0.05, hit.place.z}, Rgba{255, 0, 0, 255}, 3);
    const Vec3 behind = on_the_way(seen.eye, hit.place, 1.2);
    mesh.line({behind.x - 20, behind.y, behind.z}, {behind.x - 7, behind.y, behind.z}, Rgba{0, 0, 255, 255},
              3);
    mesh.box(0, 0, 10, 6, Rgba{0, 255, 0, 255});
    overlay.draw(mesh, seen, two_ranges);
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    expect_initial_state();
    const test::Pixels after = picture.read();
    const int middle = kHeight / 2;
    const std::uint8_t* const on = after.at(kWidth / 2 + 4, middle);
    EXPECT_GT(on[0], 250) << "shading " << static_cast<int>(shading);
    EXPECT_LT(on[1], 5);
    // To the left of it what is hidden is a quarter of its colour.
    int faint = 0;
    for (int y = 0; y < kHeight; ++y) {
      const std::uint8_t *const now = after.at(kWidth / 2 - 16, y), *const was =
                                                                        before.at(kWidth / 2 - 16, y);
      const int wanted = was[2] + (255 - was[2]) / 4;
      faint += std::abs(now[2] - wanted) <= 2 && now[2] > was[2] + 8 && now[0] < was[0];
      EXPECT_LT(now[2], 250);
    }
    EXPECT_GE(faint, 1);
    const std::uint8_t* const corner = after.at(5, kHeight - 4);
    EXPECT_TRUE(corner[0] == 0 && corner[1] == 255 && corner[2] == 0);
    const std::uint8_t *const a = after.at(40, 5), *const b = before.at(40, 5);
    EXPECT_TRUE(a[0] == b[0] && a[1] == b[1] && a[2] == b[2]);
    host_.world->release(query);
    overlay.destroy();
    renderer->destroy();
  }

  static void expect_initial_state() {
    for (const int name : {GL_BLEND, GL_DEPTH_TEST, GL_CULL_FACE, GL_SCISSOR_TEST})
      EXPECT_FALSE(glIsEnabled(static_cast<GLenum>(name)));
    const auto number = [](int name) {
      GLint value = -1;
      glGetIntegerv(static_cast<GLenum>(name), &value);
      return value;
    };
    for (const int name :
         {GL_CURRENT_PROGRAM, GL_VERTEX_ARRAY_BINDING, GL_ARRAY_BUFFER_BINDING, GL_TEXTURE_BINDING_2D})
      EXPECT_EQ(number(name), 0) << name;
    EXPECT_EQ(number(GL_ACTIVE_TEXTURE), GL_TEXTURE0);
    EXPECT_EQ(number(GL_DEPTH_FUNC), GL_LESS);
    EXPECT_EQ(number(GL_DEPTH_WRITEMASK), GL_TRUE);
    EXPECT_EQ(number(GL_BLEND_SRC_RGB), GL_ONE);
    EXPECT_EQ(number(GL_BLEND_DST_ALPHA), GL_ZERO);
    GLfloat range[2] = {};
    glGetFloatv(GL_DEPTH_RANGE, range);
    EXPECT_TRUE(range[0] == 0 && range[1] == 1);
  }

  test::HostWorld host_{needs(), {.axes = Axes::east_up_south}};
};

TEST_F(OverlayTest, LinesLieOnTheGroundAndShineThroughIt) {
  for (const Shading shading : {Shading::forward, Shading::deferred}) {
    expect_lines(shading, GL_DEPTH_COMPONENT24, 0.5, 200, false, false);
    // Depth in two ranges: 0.05 m to 2 km.
    expect_lines(shading, GL_DEPTH_COMPONENT24, 0.05, 2000, false, true);
    expect_lines(shading, GL_DEPTH_COMPONENT24, 0.5, 200, false, true);
  }
}

TEST_F(OverlayTest, InReversedDepthToo) {
  {
    test::HostPicture picture(kWidth, kHeight, GL_DEPTH_COMPONENT32F);
    Renderer* renderer = nullptr;
    ASSERT_TRUE(Renderer::create(*host_.world, picture.loader(), {}, renderer).ok());
    const bool has = device_info(*renderer).clip_control;
    renderer->destroy();
    if (!has) GTEST_SKIP() << "the device has no clip control";
  }
  for (const Shading shading : {Shading::forward, Shading::deferred})
    expect_lines(shading, GL_DEPTH_COMPONENT32F, 0.05, 50'000, true, false);
}

// A host's lost context: nothing is called.
TEST_F(OverlayTest, ForgetsWithoutCalling) {
  Overlay overlay;
  overlay.destroy();
  overlay.forget();
  static int calls = 0;
  calls = 0;
  const GlLoader none{[](void*, const char*) -> void (*)() {
    ++calls;
    return nullptr;
  }};
  EXPECT_EQ(overlay.create(none).code(), StatusCode::unsupported);
  EXPECT_GT(calls, 30);
  overlay.destroy();
}

}  // namespace
}  // namespace karst
