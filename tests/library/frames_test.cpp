// SPDX-License-Identifier: MIT
// Frames through the public headers: several views under one governor, cameras of any kind, placements.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>

#include "tests/library/host.h"

namespace karst {
namespace {

using test::Pixels;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

class Frames : public test::HostTest {
 protected:
  Frames() : HostTest(kWidth, kHeight) {}

  // From beside the world over it; terrain fills most of the picture.
  ViewState view(double turn = 0) const {
    const WorldInfo& info = host_->world->info();
    const Vec3 middle{(info.low_m.x + info.high_m.x) / 2, (info.low_m.y + info.high_m.y) / 2,
                      (info.low_m.z + info.high_m.z) / 2};
    const double away = 0.5 * (info.high_m.x - info.low_m.x);
    const Vec3 eye{middle.x + away * std::cos(turn), info.high_m.y + 0.3 * away,
                   middle.z + away * std::sin(turn)};
    return test::looking(*host_->world, eye, middle, kWidth, kHeight);
  }
  Pixels shot(const ViewState& view) {
    test::draw_frame(*renderer_, picture_, {view});
    return picture_.read();
  }
};

TEST_F(Frames, ThePlanIsWhatIsTaken) {
  open();
  const DeviceInfo device = device_info(*renderer_);
  EXPECT_EQ(device.cpu_bytes, host_->plan.cpu_bytes);
  EXPECT_EQ(device.gpu_bytes, host_->plan.gpu_bytes);
  std::uint64_t cpu = 0;
  std::uint64_t gpu = 0;
  for (std::uint32_t n = 0; n < host_->plan.term_count; ++n) {
    (host_->plan.terms[n].gpu ? gpu : cpu) += host_->plan.terms[n].bytes;
  }
  EXPECT_EQ(cpu, host_->plan.cpu_bytes);
  EXPECT_EQ(gpu, host_->plan.gpu_bytes);
}

TEST_F(Frames, TwoStillViewsThatFitMakeNothing) {
  Needs needs;
  needs.views = 2;
  open(needs);
  std::vector<ViewState> views = {view(0.3), view(2.5)};
  // Different optics: thresholds of their own.
  set_perspective(views[1], 20, 1, 2000);
  // What lies about the views is made ahead of need, a share a frame.
  // Enough time for all of a frame's share, whatever else the machine does.
  constexpr double kPlentyMs = 1e4;
  for (int n = 0; n < 30; ++n) test::draw_frame(*renderer_, picture_, views, kPlentyMs);
  for (int n = 0; n < 20; ++n) {
    const FrameResult result = test::draw_frame(*renderer_, picture_, views, kPlentyMs);
    EXPECT_EQ(costs(*renderer_).generated, 0u) << "frame " << n;
    EXPECT_EQ(costs(*renderer_).morph_bytes, 0u) << "frame " << n;
    EXPECT_EQ(costs(*renderer_).cascades_drawn, 0u) << "frame " << n;
    EXPECT_TRUE(result.complete);
    for (int v = 0; v < 2; ++v) EXPECT_LE(result.error_px[v], 4.0);
  }
}

TEST_F(Frames, TwoViewsThatDoNotFitShareOneBoundAndSettle) {
  Needs needs;
  needs.views = 2;
  open(needs);
  const std::uint64_t coarse = std::uint64_t{host_->world->info().patches} * 512;
  close();
  needs.vertex_bytes = coarse + coarse / 4;
  needs.shadow_maps = 0;
  open(needs);
  std::vector<ViewState> views = {view(0.3), view(2.5)};
  for (ViewState& v : views) v.error_px = 0.05;
  FrameResult result;
  int last_made = 0;
  for (int n = 0; n < 60; ++n) {
    result = test::draw_frame(*renderer_, picture_, views, 1e4);
    if (costs(*renderer_).generated > 0) last_made = n;
  }
  EXPECT_LT(last_made, 40) << "vertices are remade for ever";
  EXPECT_NE(result.limits & kLimitVertexMemory, 0u);
  EXPECT_GT(result.error_px[0], 0.05);
  EXPECT_LE(result.error_px[0], 0.05 * static_cast<double>(costs(*renderer_).error_scale) * 1.001);
  EXPECT_LE(result.error_px[1], 0.05 * static_cast<double>(costs(*renderer_).error_scale) * 1.001);
}

// Heights that are not in memory: the least that the world can do with.
Needs few_heights(std::uint32_t shadow_maps = 0) {
  Needs needs;
  needs.vertex_bytes = 16 << 20;  // as much as is wanted
  needs.shadow_maps = shadow_maps;
  return test::without_heights(needs);
}

// A frame with time for all of its work.
constexpr double kPatientMs = 1e4;

TEST_F(Frames, AFileThatCannotBeReadMakesThePictureCoarserUntilItCan) {
  open(few_heights());
  ASSERT_FALSE(host_->plan.holds_all_heights);
  ViewState near = view(2.5);
  near.error_px = 1;
  const Pixels right = shot(near);
  close();

  open(few_heights());
  test::draw_frame(*renderer_, picture_, {view(0.3)}, kPatientMs);
  host_->file.fails = true;
  FrameResult result;
  for (int n = 0; n < 10; ++n) result = test::draw_frame(*renderer_, picture_, {near}, kPatientMs);
  EXPECT_NE(result.limits & kLimitFile, 0u);
  EXPECT_FALSE(result.complete);
  EXPECT_NE(picture_.read().rgba, right.rgba);
  // It is asked for now and then, not by each frame.
  const std::uint64_t reads = host_->file.reads();
  for (int n = 0; n < 10; ++n) test::draw_frame(*renderer_, picture_, {near}, kPatientMs);
  EXPECT_LE(host_->file.reads(), reads + 10);

  host_->file.fails = false;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  for (int n = 0; n < 10; ++n) result = test::draw_frame(*renderer_, picture_, {near}, kPatientMs);
  EXPECT_EQ(result.limits, 0u);
  EXPECT_TRUE(result.complete);
  EXPECT_EQ(picture_.read().rgba, right.rgba);
}

TEST_F(Frames, AFirstFrameWithoutAFileIsDrawnToo) {
  open(few_heights(2));
  host_->file.fails = true;
  FrameResult result = test::draw_frame(*renderer_, picture_, {view(0.3)}, kPatientMs);
  EXPECT_NE(result.limits & kLimitFile, 0u);
  host_->file.fails = false;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  for (int n = 0; n < 10; ++n) result = test::draw_frame(*renderer_, picture_, {view(0.3)}, kPatientMs);
  EXPECT_TRUE(result.complete);
}

// Who waits for all of a picture does not get a part of it for the whole.
TEST_F(Frames, APictureThatIsToBeCompleteFailsWithoutItsFile) {
  open(few_heights());
  host_->file.fails = true;
  const ViewState one = view(0.3);
  FrameInput input;
  input.views = {&one, 1};
  input.work_ms = 0;
  FrameResult result;
  EXPECT_EQ(renderer_->begin_frame(input, result).code(), StatusCode::io);
}

TEST_F(Frames, AViewIsTheSameBesideAnother) {
  Needs needs;
  needs.views = 2;
  needs.shadow_maps = 0;  // which are around one of them
  open(needs);
  const Pixels alone = shot(view(0.3));
  test::draw_frame(*renderer_, picture_, {view(2.5), view(0.3)});
  EXPECT_EQ(test::largest_difference(alone, picture_.read()), 0);
}

TEST_F(Frames, PlacementsShowTheSameWorld) {
  open({}, {Axes::east_up_south, {}, 0});
  const Pixels plain = shot(view());
  const Vec3 sun = Sun().towards;
  static_cast<void>(sun);
  for (const Axes axes : {Axes::east_north_up, Axes::north_east_down}) {
    for (const double turn : {0.0, 90.0, -33.0}) {
      close();
      open({}, {axes, {1000, -2000, 50}, turn});
      // The same sun, in this frame.
      FrameInput input;
      const ViewState there = view();
      input.views = {&there, 1};
      input.work_ms = 0;
      const Vec3 zero = host_->world->from_world({0, 0, 0});
      const Vec3 tip = host_->world->from_world(Sun().towards);
      input.sun.towards = {tip.x - zero.x, tip.y - zero.y, tip.z - zero.z};
      FrameResult result;
      ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
      picture_.clear();
      ASSERT_TRUE(renderer_->draw(0, {.viewport = {0, 0, kWidth, kHeight}}).ok());
      ASSERT_TRUE(renderer_->end_frame().ok());
      // Rotations round: a few pixels at edges may differ.
      EXPECT_LE(test::share_beyond(plain, picture_.read(), 2), 0.01)
          << static_cast<int>(axes) << " turned by " << turn;
    }
  }
}

TEST_F(Frames, RolledByHalfATurnIsUpsideDown) {
  open();
  ViewState upright = view();
  const Pixels plain = shot(upright);
  // Half a turn about the view's axis: x and y change sign.
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 2; ++row) upright.view_from_world[column * 3 + row] *= -1;
  }
  Pixels turned = shot(upright);
  Pixels back = turned;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      std::copy_n(turned.at(kWidth - 1 - x, kHeight - 1 - y), 4,
                  back.rgba.data() + (back.at(x, y) - back.rgba.data()));
    }
  }
  EXPECT_LE(test::share_beyond(plain, back, 4), 0.02);
}

TEST_F(Frames, MirroredIsMirrored) {
  open();
  ViewState mirrored = view();
  const Pixels plain = shot(mirrored);
  for (int column = 0; column < 3; ++column) mirrored.view_from_world[column * 3] *= -1;
  const Pixels drawn = shot(mirrored);
  Pixels back = drawn;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      std::copy_n(drawn.at(kWidth - 1 - x, y), 4, back.rgba.data() + (back.at(x, y) - back.rgba.data()));
    }
  }
  EXPECT_LE(test::share_beyond(plain, back, 4), 0.02);
}

TEST_F(Frames, ReversedDepthShowsTheSame) {
  open();
  ViewState reversed = view();
  const Pixels plain = shot(reversed);
  reversed.reversed_depth = true;
  set_perspective(reversed, 60, 1, 2000);
  EXPECT_EQ(test::share_beyond(plain, shot(reversed), 0), 0.0);
}

TEST_F(Frames, OffAxisHalvesMakeTheWhole) {
  open();
  ViewState whole = view();
  const Pixels plain = shot(whole);
  // The left half of the picture, stretched over all of it by the projection: columns come in pairs.
  ViewState half = whole;
  for (int column = 0; column < 4; ++column) {
    half.clip_from_view[column * 4] =
        2 * whole.clip_from_view[column * 4] + whole.clip_from_view[column * 4 + 3];
  }
  const Pixels left = shot(half);
  std::size_t beyond = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      int least = 255;
      for (int side = 0; side < 2; ++side) {
        int most = 0;
        for (int c = 0; c < 3; ++c) {
          most = std::max(most, std::abs(int{plain.at(x, y)[c]} - int{left.at(2 * x + side, y)[c]}));
        }
        least = std::min(least, most);
      }
      beyond += least > 24;
    }
  }
  EXPECT_LE(beyond, static_cast<std::size_t>(kWidth * kHeight / 2 / 20));
}

TEST_F(Frames, ParallelProjectionFromAbove) {
  open();
  const WorldInfo& info = host_->world->info();
  ViewState map;
  map.width_px = kWidth;
  map.height_px = kHeight;
  const Vec3 eye{(info.low_m.x + info.high_m.x) / 2, info.high_m.y + 100, (info.low_m.z + info.high_m.z) / 2};
  map.eye = host_->world->from_world(eye);
  const Vec3 north = host_->world->from_world({eye.x, eye.y, eye.z - 1});
  ASSERT_TRUE(look_at(map, host_->world->from_world({eye.x, 0, eye.z}),
                      {north.x - map.eye.x, north.y - map.eye.y, north.z - map.eye.z}));
  const double half_height = (info.high_m.z - info.low_m.z) / 2;
  const double half_width = half_height * kWidth / kHeight;
  for (double& entry : map.clip_from_view) entry = 0;
  map.clip_from_view[0] = 1 / half_width;
  map.clip_from_view[5] = 1 / half_height;
  map.clip_from_view[10] = -2.0 / 400;
  map.clip_from_view[14] = -1;
  map.clip_from_view[15] = 1;
  FrameResult result = test::draw_frame(*renderer_, picture_, {map});
  EXPECT_TRUE(result.complete);
  EXPECT_LE(result.error_px[0], 4.0);
  EXPECT_GT(result.triangles, 100u);
  // Without the sky, every pixel well inside is terrain.
  picture_.clear(1, {1, 0, 1});
  const Target target{{0, 0, kWidth, kHeight}, false, Output::display};
  const float magenta[3] = {1, 0, 1};
  FrameInput input;
  input.views = {&map, 1};
  input.work_ms = 0;
  ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
  picture_.clear(1, magenta);
  ASSERT_TRUE(renderer_->draw(0, target).ok());
  ASSERT_TRUE(renderer_->end_frame().ok());
  const Pixels pixels = picture_.read();
  int holes = 0;
  for (int y = kHeight / 8; y < kHeight * 7 / 8; ++y) {
    for (int x = kWidth / 4; x < kWidth * 3 / 4; ++x) {
      const std::uint8_t* p = pixels.at(x, y);
      holes += p[0] == 255 && p[1] == 0 && p[2] == 255;
    }
  }
  EXPECT_EQ(holes, 0);
}

TEST_F(Frames, TheScaleIsBackWithinTenFrames) {
  Needs needs;
  open(needs);
  const std::uint64_t coarse = std::uint64_t{host_->world->info().patches} * 512;
  close();
  needs.vertex_bytes = coarse + coarse / 8;
  needs.shadow_maps = 0;
  open(needs);
  ViewState hard = view();
  hard.error_px = 0.02;
  ViewState easy = view();
  easy.error_px = 50;
  test::draw_frame(*renderer_, picture_, {easy}, 1e4);
  for (int n = 0; n < 5; ++n) test::draw_frame(*renderer_, picture_, {hard}, 1e4);
  EXPECT_GT(costs(*renderer_).error_scale, 1.0f);
  for (int n = 0; n < 10; ++n) test::draw_frame(*renderer_, picture_, {easy}, 1e4);
  EXPECT_EQ(costs(*renderer_).error_scale, 1.0f);
}

// What the host drew before, at a depth amid the terrain, hides what is behind it: the same pixels whichever
// way pixels are shaded.
TEST_F(Frames, TheHostsThingsHideTerrainAlikeInBothWays) {
  Needs needs;
  needs.deferred_width = kWidth;
  needs.deferred_height = kHeight;
  std::vector<bool> hidden[2];
  for (const bool deferred : {false, true}) {
    open(needs, {}, {.shading = deferred ? Shading::deferred : Shading::forward});
    EXPECT_EQ(device_info(*renderer_).deferred, deferred);
    const ViewState v = view();
    FrameInput input;
    input.views = {&v, 1};
    input.work_ms = 0;
    FrameResult result;
    ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
    // A sheet across the view, at half of the middle's distance more: a fifth to four fifths are behind it.
    const WorldInfo& info = host_->world->info();
    const double distance = 0.62 * (info.high_m.x - info.low_m.x);
    const double depth = 0.5 + 0.5 * (-v.clip_from_view[10] * distance + v.clip_from_view[14]) / distance;
    picture_.clear(static_cast<float>(depth), {1, 0, 1});
    Target target;
    target.viewport = {0, 0, kWidth, kHeight};
    target.sky = false;
    target.framebuffer = picture_.name();
    ASSERT_TRUE(renderer_->draw(0, target).ok());
    ASSERT_TRUE(renderer_->end_frame().ok());
    const Pixels pixels = picture_.read();
    for (std::size_t n = 0; n < pixels.rgba.size(); n += 4) {
      hidden[deferred].push_back(pixels.rgba[n] == 255 && pixels.rgba[n + 1] == 0 &&
                                 pixels.rgba[n + 2] == 255);
    }
    close();
  }
  const auto sheet = std::count(hidden[0].begin(), hidden[0].end(), true);
  EXPECT_GT(sheet, kWidth * kHeight / 5);
  EXPECT_LT(sheet, kWidth * kHeight * 4 / 5);
  int differ = 0;
  for (std::size_t n = 0; n < hidden[0].size(); ++n) differ += hidden[0][n] != hidden[1][n];
  EXPECT_LE(differ, kWidth * kHeight / 2000);
}

// With smooth edges and without, either way of depth, with the sky and without.
TEST_F(Frames, ASharedDepthShowsTheSame) {
  Needs needs;
  needs.deferred_width = kWidth + 7;
  needs.deferred_height = kHeight;
  for (const bool edges : {false, true}) {
    std::vector<Pixels> pictures[2];
    for (const bool shared : {false, true}) {
      open(needs, {}, {.shading = Shading::deferred, .smooth_edges = edges, .share_depth = shared});
      const GLuint depth = device_info(*renderer_).depth_texture;
      EXPECT_EQ(depth != 0, shared);
      picture_.use_depth(depth);
      for (const bool reversed : {false, true}) {
        for (const bool sky : {false, true}) {
          ViewState v = view(reversed ? 1 : 2);
          v.reversed_depth = reversed;
          if (reversed) set_perspective(v, 60, 1, 2000);
          Target target{.viewport = {0, 0, kWidth, kHeight}, .sky = sky};
          target.framebuffer = picture_.name();
          FrameInput input;
          input.views = {&v, 1};
          input.work_ms = 0;
          FrameResult result;
          ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
          // No colour that shading what is not there may come to.
          picture_.clear(reversed ? 0.0f : 1.0f, {0, 1, 0});
          ASSERT_TRUE(renderer_->draw(0, target).ok());
          ASSERT_TRUE(renderer_->end_frame().ok());
          pictures[shared].push_back(picture_.read());
        }
      }
      picture_.use_depth(0);
      close();
    }
    for (std::size_t n = 0; n < 4; ++n) {
      EXPECT_EQ(largest_difference(pictures[0][n], pictures[1][n]), 0) << edges << " " << n;
      EXPECT_GT(share_beyond(pictures[0][n],
                             Pixels{kWidth, kHeight, std::vector<std::uint8_t>(kWidth * kHeight * 4)}, 9),
                0.3);
    }
  }
}

TEST_F(Frames, ASharedDepthBeginsWhereTheViewportDoes) {
  Needs needs;
  needs.deferred_width = kWidth;
  needs.deferred_height = kHeight;
  open(needs, {}, {.shading = Shading::deferred, .share_depth = true});
  picture_.use_depth(device_info(*renderer_).depth_texture);
  const ViewState v = view();
  FrameInput input;
  input.views = {&v, 1};
  FrameResult result;
  ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
  const Status status =
      renderer_->draw(0, {.viewport = {8, 0, kWidth - 8, kHeight}, .framebuffer = picture_.name()});
  EXPECT_EQ(status.code(), StatusCode::invalid_argument);
  EXPECT_STREQ(status.field(), "viewport");
  ASSERT_TRUE(renderer_->end_frame().ok());
  picture_.use_depth(0);
  close();
  // Without a G-buffer there is nothing to share.
  open({}, {}, {.shading = Shading::forward, .share_depth = true});
  EXPECT_EQ(device_info(*renderer_).depth_texture, 0u);
}

TEST_F(Frames, WithoutSkyTheHostsPictureStays) {
  open();
  const ViewState v = view();
  FrameInput input;
  input.views = {&v, 1};
  input.work_ms = 0;
  FrameResult result;
  ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
  picture_.clear(1, {0, 1, 0});
  ASSERT_TRUE(renderer_->draw(0, {.viewport = {0, 0, kWidth, kHeight}, .sky = false}).ok());
  ASSERT_TRUE(renderer_->end_frame().ok());
  const Pixels pixels = picture_.read();
  int green = 0;
  int other = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const std::uint8_t* p = pixels.at(x, y);
      (p[0] == 0 && p[1] == 255 && p[2] == 0 ? green : other)++;
    }
  }
  EXPECT_GT(green, 1000);
  EXPECT_GT(other, 5000);
}

TEST_F(Frames, AfterALostContextItDrawsTheSame) {
  open();
  const Pixels before = shot(view());
  renderer_->context_lost();
  renderer_ = nullptr;
  ASSERT_TRUE(Renderer::create(*host_->world, picture_.loader(), {}, renderer_).ok());
  EXPECT_EQ(test::largest_difference(before, shot(view())), 0);
}

TEST_F(Frames, WrongInputIsNamed) {
  open();
  FrameResult result;
  const auto refused = [&](const FrameInput& input) {
    const Status status = renderer_->begin_frame(input, result);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    return std::string(status.field());
  };
  FrameInput input;
  EXPECT_EQ(refused(input), "views");
  ViewState v = view();
  input.views = {&v, 1};
  input.shadow_view = 1;
  EXPECT_EQ(refused(input), "shadow_view");
  input.shadow_view = 0;
  input.work_ms = -1;
  EXPECT_EQ(refused(input), "work_ms");
  input.work_ms = 0;
  input.sun.towards = {0, 0, 0};
  EXPECT_EQ(refused(input), "towards");
  input.sun = {};
  input.sun.visibility_m = -1;
  EXPECT_EQ(refused(input), "visibility_m");
  input.sun = {};
  v.width_px = 0;
  EXPECT_EQ(refused(input), "width_px");
  v = view();
  v.error_px = 0;
  EXPECT_EQ(refused(input), "error_px");
  v = view();
  v.weight = 0;
  EXPECT_EQ(refused(input), "weight");
  v = view();
  v.eye.x = std::nan("");
  EXPECT_EQ(refused(input), "eye");
  v = view();
  v.view_from_world[0] = 5;
  EXPECT_EQ(refused(input), "view_from_world");
  v = view();
  v.clip_from_view[0] = 0;
  EXPECT_EQ(refused(input), "clip_from_view");
  v = view();
  v.reversed_depth = true;
  EXPECT_EQ(refused(input), "reversed_depth");
  v = view();
  ASSERT_TRUE(renderer_->begin_frame(input, result).ok());
  EXPECT_EQ(std::string(renderer_->draw(1, {.viewport = {0, 0, 8, 8}}).field()), "view");
}

}  // namespace
}  // namespace karst
