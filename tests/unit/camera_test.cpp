// SPDX-License-Identifier: MIT
// The camera on the lattice: what it refuses, that metres leave no trace, and that its matrix is a
// projection.
#include "terrain/view/camera.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

namespace karst::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

Camera camera_of(const CameraSettings& settings) {
  Camera camera;
  const Status status = make_camera(settings, camera);
  EXPECT_TRUE(status.ok()) << status.field() << ": " << status.what();
  return camera;
}

// Not operator==, to which 0 and -0 are the same.
bool same_bits(const glm::mat4& a, const glm::mat4& b) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      if (std::bit_cast<std::uint32_t>(a[column][row]) != std::bit_cast<std::uint32_t>(b[column][row]))
        return false;
    }
  }
  return true;
}

TEST(Camera, RefusesOneWrongFieldAtATime) {
  using Break = std::function<void(CameraSettings&)>;
  std::vector<std::pair<const char*, Break>> cases;
  for (const double v : {kNan, kInf, -kInf, 2.0 * kCameraReach, -2.0 * kCameraReach}) {
    for (int axis = 0; axis < 3; ++axis) {
      cases.emplace_back("position", [=](CameraSettings& s) { s.position[axis] = v; });
    }
  }
  for (const double v : {kNan, kInf, 1e7}) {
    cases.emplace_back("yaw_deg", [=](CameraSettings& s) { s.yaw_deg = v; });
  }
  for (const double v : {kNan, -kInf, 90.001, -91.0}) {
    cases.emplace_back("pitch_deg", [=](CameraSettings& s) { s.pitch_deg = v; });
  }
  for (const double v : {kNan, kInf, 0.0, 0.99, 170.1, -60.0}) {
    cases.emplace_back("fov_y_deg", [=](CameraSettings& s) { s.fov_y_deg = v; });
  }
  for (const double v : {kNan, kInf, 0.0, -1.0, 65.0}) {
    cases.emplace_back("aspect", [=](CameraSettings& s) { s.aspect = v; });
  }
  for (const double v : {kNan, kInf, 0.0, -1.0}) {
    cases.emplace_back("near_voxels", [=](CameraSettings& s) { s.near_voxels = v; });
    cases.emplace_back("far_voxels", [=](CameraSettings& s) { s.far_voxels = v; });
  }
  cases.emplace_back("far_voxels", [](CameraSettings& s) { s.far_voxels = s.near_voxels; });
  cases.emplace_back("far_voxels", [](CameraSettings& s) { s.near_voxels = 2000.0; });

  for (const auto& [field, break_it] : cases) {
    CameraSettings settings;
    Camera camera = camera_of(settings);
    camera.voxel = {7, 8, 9};
    break_it(settings);
    const Status status = make_camera(settings, camera);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(status.field(), field);
    EXPECT_EQ(camera.voxel, glm::ivec3(7, 8, 9)) << "a refused camera was changed";
  }
}

TEST(Camera, RefusesAWrongFrame) {
  const auto field_of = [](WorldFrame frame, glm::dvec3 position_m) {
    glm::dvec3 voxels(5.0);
    const Status status = voxels_from_metres(frame, position_m, voxels);
    EXPECT_EQ(voxels, glm::dvec3(5.0));
    EXPECT_EQ(status.code(), StatusCode::invalid_argument);
    return status.field();
  };
  for (const double bad : {kNan, kInf, 0.0, -1.0}) EXPECT_STREQ(field_of({{}, bad}, {}), "voxel_size_m");
  for (const double bad : {kNan, kInf}) {
    EXPECT_STREQ(field_of({{0.0, bad, 0.0}, 1.0}, {}), "origin_m");
    EXPECT_STREQ(field_of({}, {0.0, 0.0, bad}), "position");
  }
  EXPECT_STREQ(field_of({{}, 1e-3}, {1e7, 0.0, 0.0}), "position");
  EXPECT_STREQ(field_of({{}, 1e-320}, {1.0, 0.0, 0.0}), "position");
}

TEST(Camera, PlaceIsRoundedToTheLattice) {
  const Camera camera = camera_of({.position = {3.25, -0.25, 1.0 - 1e-9}});
  EXPECT_EQ(camera.voxel, glm::ivec3(3, -1, 1));
  EXPECT_EQ(camera.fine, glm::vec3(2048.0f, 6144.0f, 0.0f));
  EXPECT_EQ(eye_lattice(camera), glm::dvec3(26624.0, -2048.0, 8192.0));

  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-kCameraReach, kCameraReach);
  for (int n = 0; n < 1000; ++n) {
    const glm::dvec3 p{place(random), place(random), place(random)};
    const Camera c = camera_of({.position = p});
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_GE(c.fine[axis], 0.0f);
      ASSERT_LT(c.fine[axis], static_cast<float>(kStepsPerVoxel));
      const float units = c.fine[axis] * (1 << kCameraFractionBits);
      ASSERT_EQ(units, std::floor(units));
      ASSERT_LE(std::abs(eye_lattice(c)[axis] - p[axis] * kStepsPerVoxel), 0.5 / (1 << kCameraFractionBits));
    }
  }
}

// The same view, wherever the world lies and however large its voxels are: the same bits.
TEST(Camera, MetresLeaveNoTrace) {
  std::mt19937 random(2);
  std::uniform_int_distribution<std::int32_t> unit(-(1 << 26),
                                                   1 << 26);  // +-512 voxels in sixteenths of a step
  const double fraction = 1.0 / (kStepsPerVoxel << kCameraFractionBits);
  for (int n = 0; n < 500; ++n) {
    CameraSettings settings;
    settings.yaw_deg = 0.37 * n;
    settings.pitch_deg = -20.0;
    const glm::dvec3 p = fraction * glm::dvec3(unit(random), unit(random), unit(random));
    settings.position = p;
    const Camera plain = camera_of(settings);
    const glm::mat4 plain_matrix = clip_from_lattice(plain);
    for (const double voxel_size_m : {1e-3, 0.3, 1.0, 30.0, 256.0, 1e4}) {
      for (const double far_away : {0.0, 1e7, -1e7}) {
        const WorldFrame frame{{far_away, -far_away / 3, far_away * 0.7}, voxel_size_m};
        const glm::dvec3 position_m = frame.origin_m + p * voxel_size_m;
        ASSERT_TRUE(voxels_from_metres(frame, position_m, settings.position).ok());
        const Camera camera = camera_of(settings);
        ASSERT_EQ(camera.voxel, plain.voxel) << voxel_size_m << ' ' << far_away;
        ASSERT_EQ(camera.fine, plain.fine) << voxel_size_m << ' ' << far_away;
        ASSERT_TRUE(same_bits(clip_from_lattice(camera), plain_matrix));
      }
    }
  }
}

TEST(Camera, AxesFollowYawAndPitch) {
  const auto forward = [](double yaw, double pitch) {
    return -world_from_view(camera_of({.yaw_deg = yaw, .pitch_deg = pitch}))[2];
  };
  EXPECT_EQ(forward(0, 0), glm::dvec3(0, 0, -1));
  EXPECT_EQ(forward(90, 0), glm::dvec3(-1, 0, 0));
  EXPECT_EQ(forward(180, 0), glm::dvec3(0, 0, 1));
  EXPECT_EQ(forward(-90, 0), glm::dvec3(1, 0, 0));
  EXPECT_EQ(forward(270, 0), glm::dvec3(1, 0, 0));
  EXPECT_EQ(forward(0, 90), glm::dvec3(0, 1, 0));
  EXPECT_EQ(forward(30, -90), glm::dvec3(0, -1, 0));
  EXPECT_GT(forward(0, 10).y, 0.0);

  for (double yaw = -180; yaw <= 180; yaw += 15) {
    for (double pitch = -90; pitch <= 90; pitch += 15) {
      const glm::dmat3 axes = world_from_view(camera_of({.yaw_deg = yaw, .pitch_deg = pitch}));
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) EXPECT_NEAR(glm::dot(axes[a], axes[b]), a == b ? 1.0 : 0.0, 1e-15);
      }
      EXPECT_NEAR(glm::dot(glm::cross(axes[0], axes[1]), axes[2]), 1.0, 1e-15);
      EXPECT_GE(axes[1].y, 0.0) << "upside down";
    }
  }
}

TEST(Camera, MatrixIsTheProjection) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> in(-30.0, 30.0);
  for (int n = 0; n < 200; ++n) {
    CameraSettings settings;
    settings.position = {in(random), in(random), in(random)};
    settings.yaw_deg = 6.0 * in(random);
    settings.pitch_deg = 3.0 * in(random);
    settings.fov_y_deg = 50.0;
    settings.aspect = 2.0;
    settings.near_voxels = 0.5;
    settings.far_voxels = 100.0;
    const Camera camera = camera_of(settings);
    const glm::mat4 m = clip_from_lattice(camera);
    const glm::dvec3 p{in(random), in(random), in(random)};  // voxels
    const glm::dvec3 d = p - eye_lattice(camera) / static_cast<double>(kStepsPerVoxel);
    const glm::dmat3 axes = world_from_view(camera);
    const double distance = -glm::dot(d, axes[2]);
    const double t = std::tan(25.0 * 3.14159265358979323846 / 180.0);
    const glm::dvec3 steps = (p - glm::dvec3(camera.voxel)) * static_cast<double>(kStepsPerVoxel);
    const glm::dvec4 clip = glm::dmat4(m) * glm::dvec4(steps, 1.0);
    EXPECT_NEAR(clip.w, distance, 1e-4);
    EXPECT_NEAR(clip.x, glm::dot(d, axes[0]) / (2.0 * t), 1e-4);
    EXPECT_NEAR(clip.y, glm::dot(d, axes[1]) / t, 1e-4);
    EXPECT_NEAR(clip.z, (distance * 100.5 - 100.0) / 99.5, 1e-4);
    EXPECT_NEAR(camera.clip_from_view[1][1], 1.0 / t, 1e-12);
  }
}

TEST(Camera, LooksAtATarget) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> in(-1e3, 1e3);
  for (int n = 0; n < 200; ++n) {
    const glm::dvec3 eye{in(random), in(random), in(random)};
    const glm::dvec3 target{in(random), in(random), in(random)};
    CameraSettings settings;
    ASSERT_TRUE(look_at(eye, target, settings.yaw_deg, settings.pitch_deg).ok());
    const glm::dvec3 forward = -world_from_view(camera_of(settings))[2];
    EXPECT_NEAR(glm::dot(forward, glm::normalize(target - eye)), 1.0, 1e-12);
  }
  double yaw = 1.0;
  double pitch = 1.0;
  ASSERT_TRUE(look_at({0, 0, 0}, {0, -5, 0}, yaw, pitch).ok());
  EXPECT_EQ(yaw, 0.0);
  EXPECT_EQ(pitch, -90.0);
  EXPECT_STREQ(look_at({1, 2, 3}, {1, 2, 3}, yaw, pitch).field(), "target");
  EXPECT_STREQ(look_at({1, 2, 3}, {1, kNan, 3}, yaw, pitch).field(), "target");
  EXPECT_STREQ(look_at({1, 2, 3}, {1, kInf, 3}, yaw, pitch).field(), "target");
}

}  // namespace
}  // namespace karst::core
