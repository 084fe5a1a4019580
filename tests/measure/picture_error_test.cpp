// SPDX-License-Identifier: MIT
// Errors of pictures whose depth is computed here, of planes and steps whose errors are known.
#include "bench/measure/picture_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <glm/matrix.hpp>
#include <glm/vec4.hpp>

namespace karst::bench {
using namespace core;
namespace {

constexpr int kWidth = 160, kHeight = 90;
constexpr double kStep = kStepsPerVoxel;

Camera test_camera() {
  CameraSettings settings;
  settings.position = {20.25, 16.5, 30.75};
  settings.yaw_deg = 25;
  settings.pitch_deg = -30;
  settings.near_voxels = 0.5;
  settings.far_voxels = 200;
  Camera camera;
  EXPECT_TRUE(make_camera(settings, camera).ok());
  return camera;
}

// The depth of what ground(x, z) says the height is, voxels, by marching along each pixel's ray.
template <class Ground>
std::vector<float> draw(const Camera& camera, Ground ground) {
  const glm::dmat4 clip(clip_from_lattice(camera));
  const glm::dmat4 inverse = glm::inverse(clip);
  const auto at = [&](glm::dvec2 ndc, double depth) {
    const glm::dvec4 p = inverse * glm::dvec4(ndc, depth * 2 - 1, 1.0);
    return glm::dvec3(p) / p.w / kStep + glm::dvec3(camera.voxel);
  };
  std::vector<float> depth;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec2 ndc((x + 0.5) / kWidth * 2 - 1, 1 - (y + 0.5) / kHeight * 2);
      const glm::dvec3 eye = at(ndc, 0), end = at(ndc, 1);
      double hit = 1;
      for (double s = 0; s < 1 && hit == 1; s += 0.0005) {
        const glm::dvec3 p = eye + (end - eye) * s;
        if (p.y > ground(p.x, p.z)) continue;
        double low = s - 0.0005, high = s;
        for (int i = 0; i < 40; ++i) {
          const double middle = 0.5 * (low + high);
          const glm::dvec3 q = eye + (end - eye) * middle;
          (q.y > ground(q.x, q.z) ? low : high) = middle;
        }
        const glm::dvec3 q = (eye + (end - eye) * high - glm::dvec3(camera.voxel)) * kStep;
        const glm::dvec4 c = clip * glm::dvec4(q, 1.0);
        hit = c.z / c.w * 0.5 + 0.5;
      }
      depth.push_back(static_cast<float>(std::round(hit * 16777215.0) / 16777215.0));
    }
  }
  return depth;
}

DepthPicture picture_of(const Camera& camera, const std::vector<float>& depth) {
  return {camera, kWidth, kHeight, depth};
}

// 4 m voxels, world origin so that the grid's centre lies in the middle of 40 x 40 voxels.
WorldFrame frame() {
  return {{-80, -8, -80}, 4.0};
}

ElevationGrid flat_grid(double height_m) {
  ElevationGrid grid;
  grid.columns = grid.rows = 101;
  grid.spacing_x_m = grid.spacing_z_m = 4;
  grid.heights_m.assign(101 * 101, static_cast<float>(height_m));
  return grid;
}

TEST(ErrorsAgainstElevation, NoneOnTheElevationItself) {
  const Camera camera = test_camera();
  const auto depth = draw(camera, [](double, double) { return 10.0; });
  std::vector<float> px;
  errors_against_elevation(picture_of(camera, depth), frame(), flat_grid(10 * 4 - 8), px);
  const ErrorSummary summary = summarise_errors(px);
  EXPECT_GT(summary.pixels, 4000u);
  EXPECT_LT(summary.max, 0.01);
}

TEST(ErrorsAgainstElevation, AreTheHeightsDifferenceOnTheScreen) {
  const Camera camera = test_camera();
  // Half a voxel too high. Straight ahead the ground is seen at 30 degrees from 6 voxels above it: at the
  // distance of 12 voxels, where a voxel is 45 / tan(30) / 12 pixels, and the difference is foreshortened by
  // cos(30) but for perspective.
  const auto depth = draw(camera, [](double, double) { return 10.5; });
  std::vector<float> centre;
  DepthPicture middle = picture_of(camera, depth);
  std::vector<float> only(depth.size(), 1.0f);
  only[kHeight / 2 * kWidth + kWidth / 2] = depth[kHeight / 2 * kWidth + kWidth / 2];
  middle.depth = only;
  errors_against_elevation(middle, frame(), flat_grid(10 * 4 - 8), centre);
  ASSERT_EQ(centre.size(), 1u);
  const double pixels_per_radian = 0.5 * kHeight / std::tan(30 * 3.14159265358979 / 180);
  EXPECT_NEAR(double{centre[0]}, 0.5 * std::cos(3.14159265358979 / 6) * pixels_per_radian / 12, 0.1);
}

TEST(ErrorsAgainstElevation, LeaveOutWhatLiesAtTheGridsBorder) {
  const Camera camera = test_camera();
  const auto depth = draw(camera, [](double, double) { return 10.0; });
  ElevationGrid grid = flat_grid(0);
  grid.columns = grid.rows = 5;  // less two cells a side: nothing is left
  std::vector<float> px;
  errors_against_elevation(picture_of(camera, depth), frame(), grid, px);
  EXPECT_TRUE(px.empty());
  EXPECT_TRUE(std::isnan(summarise_errors(px).mean));
}

TEST(ErrorsAgainstPicture, NoneOfThePictureItself) {
  const Camera camera = test_camera();
  const auto hills = [](double x, double z) { return 10 + std::sin(x * 0.7) * std::cos(z * 0.5); };
  const auto depth = draw(camera, hills);
  std::vector<float> px;
  errors_against_picture(picture_of(camera, depth), depth, px);
  EXPECT_GT(px.size(), 4000u);
  EXPECT_EQ(summarise_errors(px).max, 0.0);
}

TEST(ErrorsAgainstPicture, AreTheDistanceOfTwoPlanes) {
  const Camera camera = test_camera();
  const auto reference = draw(camera, [](double, double) { return 10.0; });
  const auto depth = draw(camera, [](double, double) { return 10.2; });
  std::vector<float> px;
  errors_against_picture(picture_of(camera, depth), reference, px);
  const std::size_t centre = kHeight / 2 * kWidth + kWidth / 2;
  std::size_t measured_before = 0;
  for (std::size_t i = 0; i < centre; ++i) measured_before += std::min(depth[i], reference[i]) < 1 ? 1u : 0u;
  ASSERT_GT(px.size(), measured_before);
  const double pixels_per_radian = 0.5 * kHeight / std::tan(30 * 3.14159265358979 / 180);
  // At 6.3 voxels above, 30 degrees.
  EXPECT_NEAR(double{px[measured_before]}, 0.2 * pixels_per_radian / (6.3 / 0.5), 0.03);
}

TEST(ErrorsAgainstPicture, AnOutlineThatMovedCountsAsItsWay) {
  const Camera camera = test_camera();
  // A wall whose top is a little higher: behind it the ground is far away.
  const auto wall = [](double top) {
    return [top](double, double z) { return z < 22 && z > 21 ? top : 2.0; };
  };
  const auto reference = draw(camera, wall(12.0));
  const auto depth = draw(camera, wall(12.3));
  std::vector<float> px;
  errors_against_picture(picture_of(camera, depth), reference, px);
  const ErrorSummary summary = summarise_errors(px);
  const double pixels_per_radian = 0.5 * kHeight / std::tan(30 * 3.14159265358979 / 180);
  EXPECT_GT(summary.max, 0.3 * pixels_per_radian / 20);
  EXPECT_LT(summary.max, 0.3 * pixels_per_radian / 4);  // the ground behind is 20 pixels away
}

TEST(ColourDifference, LeavesAlphaOut) {
  const std::vector<std::uint8_t> a = {10, 20, 30, 0, 255, 0, 7, 9};
  const std::vector<std::uint8_t> b = {13, 18, 30, 255, 254, 0, 7, 8};
  EXPECT_DOUBLE_EQ(mean_colour_difference(a, b), (3 + 2 + 1) / 6.0);
  EXPECT_EQ(mean_colour_difference(a, a), 0);
}

TEST(SummariseErrors, RanksAndMeans) {
  std::vector<float> px;
  for (int i = 100; i > 0; --i) px.push_back(static_cast<float>(i));
  const ErrorSummary summary = summarise_errors(px);
  EXPECT_EQ(summary.pixels, 100u);
  EXPECT_DOUBLE_EQ(summary.mean, 50.5);
  EXPECT_NEAR(summary.rms, std::sqrt(338350.0 / 100), 1e-9);
  EXPECT_EQ(summary.p50, 51);
  EXPECT_EQ(summary.p99, 100);
  EXPECT_EQ(summary.max, 100);
}

}  // namespace
}  // namespace karst::bench
