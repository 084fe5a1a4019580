// SPDX-License-Identifier: MIT
// Silhouettes against the sky, beside a picture of 4 x 4 samples a pixel.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "tests/gl/gl_fixture.h"

namespace karst::core {
namespace {

using test::DrawnWorld;
using test::GlContext;
using test::Picture;

constexpr int kWidth = 240;
constexpr int kHeight = 135;
constexpr int kFine = 4;  // samples a side of the reference

test::DrawnSettings settings_of(int scale, int samples) {
  test::DrawnSettings settings;
  settings.picture.width = kWidth * scale;
  settings.picture.height = kHeight * scale;
  settings.picture.samples = samples;
  settings.picture.keep_depth = samples == 1;
  settings.debug = true;
  return settings;
}

CameraSettings over_the_hills(int n) {
  CameraSettings camera;
  camera.position = {11, 14, 22};
  camera.yaw_deg = 25.0 * n - 30;
  camera.pitch_deg = -8;
  camera.roll_deg = 7.0 * n;
  return camera;
}
constexpr int kViews = 4;

// What a pixel should show, and whether a silhouette runs through it.
struct Reference {
  std::vector<double> rgb;
  std::vector<bool> silhouette;
};

Reference reference_of(DrawnWorld& world, int n) {
  EXPECT_TRUE(world.draw(over_the_hills(n)).ok());
  const Picture fine = world.picture();
  std::vector<float> depth(std::size_t{kWidth} * kHeight * kFine * kFine);
  EXPECT_TRUE(world.target().read_depth(depth).ok());
  Reference result{std::vector<double>(std::size_t{kWidth} * kHeight * 3),
                   std::vector<bool>(std::size_t{kWidth} * kHeight)};
  for (std::size_t pixel = 0; pixel < result.silhouette.size(); ++pixel) {
    int sky = 0;
    for (std::size_t s = 0; s < kFine * kFine; ++s) {
      const std::size_t x = pixel % kWidth * kFine + s % kFine;
      const std::size_t y = pixel / kWidth * kFine + s / kFine;
      const std::size_t at = y * kWidth * kFine + x;
      sky += depth[at] == 1.0f;
      for (std::size_t c = 0; c < 3; ++c) {
        result.rgb[pixel * 3 + c] += fine[at * 4 + c] / double{kFine * kFine};
      }
    }
    result.silhouette[pixel] = sky > 0 && sky < kFine * kFine;
  }
  return result;
}

// Mean difference of the pixels that a silhouette runs through, of 255.
double error_of(const Picture& picture, const Reference& reference) {
  double sum = 0;
  int count = 0;
  for (std::size_t pixel = 0; pixel < reference.silhouette.size(); ++pixel) {
    if (!reference.silhouette[pixel]) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      sum += std::abs(picture[pixel * 4 + c] - reference.rgb[pixel * 3 + c]) / 3;
    }
    ++count;
  }
  EXPECT_GT(count, kWidth / 2);
  return sum / count;
}

// Of the views, beside the reference: plain, and with these settings.
void expect_smoother(const test::DrawnSettings& settings, double factor) {
  const test::TestWorld hills = test::hills_with_cave(3);
  DrawnWorld fine(hills, GlContext::get().gl(), settings_of(kFine, 1));
  DrawnWorld plain(hills, GlContext::get().gl(), settings_of(1, 1));
  DrawnWorld smooth(hills, GlContext::get().gl(), settings);
  double before = 0;
  double after = 0;
  for (int n = 0; n < kViews; ++n) {
    const Reference reference = reference_of(fine, n);
    ASSERT_TRUE(plain.draw(over_the_hills(n)).ok());
    ASSERT_TRUE(smooth.draw(over_the_hills(n)).ok());
    before += error_of(plain.picture(), reference) / kViews;
    after += error_of(smooth.picture(), reference) / kViews;
  }
  std::printf("silhouettes: %.1f of 255 off, smoothed %.1f\n", before, after);
  EXPECT_LT(after, before / factor);
  EXPECT_EQ(take_gl_errors(GlContext::get().gl()), GLenum{GL_NO_ERROR});
}

// A host's target of several samples is drawn into like any other.
TEST(Antialias, SamplesSmoothSilhouettes) {
  expect_smoother(settings_of(1, 4), 1.7);
}

TEST(Antialias, EdgesOfTheGBufferSmoothSilhouettes) {
  test::DrawnSettings settings = settings_of(1, 1);
  settings.shading = karst::Shading::deferred;
  settings.deferred_width = kWidth;
  settings.deferred_height = kHeight;
  settings.smooth_edges = true;
  expect_smoother(settings, 1.4);
}

TEST(Antialias, MemoryOfSamplesIsCounted) {
  app::PictureSettings picture;
  picture.width = 100;
  picture.height = 10;
  EXPECT_EQ(picture.bytes(), 8000u);
  picture.own_depth = false;
  EXPECT_EQ(picture.bytes(), 4000u);
  picture.own_depth = true;
  picture.samples = 4;
  EXPECT_EQ(picture.bytes(), 36000u);
  picture.rgb565 = true;
  EXPECT_EQ(picture.bytes(), 26000u);
  picture.keep_depth = true;
  EXPECT_STREQ(picture.validate().field(), "keep_depth");
  picture.samples = 3;
  EXPECT_STREQ(picture.validate().field(), "samples");
}

}  // namespace
}  // namespace karst::core
