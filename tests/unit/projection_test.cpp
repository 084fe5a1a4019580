// SPDX-License-Identifier: MIT
// Cameras of any rotation and projection against brute force in double: what they show, where their rays
// lead, how many pixels things cover, and which matrices are refused.
#include "terrain/view/projection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "terrain/cull/occluders.h"
#include "terrain/lod/morph.h"
#include "terrain/view/frustum.h"
#include "tests/support/any_camera.h"

namespace karst::core {
namespace {

using test::any_direction;
using test::any_matrices;
using test::AnyProjection;
using test::between;
using test::camera_of;
using test::is_parallel;
using test::kAnyProjections;
using test::Random;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kEndless = 1e9;  // voxels; rounding may make this of a plane infinitely far

// The matrices as they were given.
struct Given {
  explicit Given(const CameraMatrices& m)
      : matrices(m),
        clip_from_world(m.clip_from_view * glm::dmat4(m.view_from_world)),
        world_from_clip(glm::inverse(clip_from_world)) {}

  // p: voxels from the octree's minimum corner.
  glm::dvec4 clip(glm::dvec3 p) const { return clip_from_world * glm::dvec4(p - matrices.position, 1.0); }
  glm::dvec3 place(glm::dvec3 ndc) const {
    const glm::dvec4 p = world_from_clip * glm::dvec4(ndc, 1.0);
    return glm::dvec3(p) / p.w + matrices.position;
  }
  static bool sees(glm::dvec4 c) {
    return std::abs(c.x) <= c.w && std::abs(c.y) <= c.w && std::abs(c.z) <= c.w;
  }

  CameraMatrices matrices;
  glm::dmat4 clip_from_world, world_from_clip;
};

glm::dvec3 eye_of(const Camera& camera) {
  return eye_lattice(camera) / double{kStepsPerVoxel};
}

// A place in view; z of the picture's far end is left out, which may be infinitely far.
glm::dvec3 any_seen(Random& random, const Given& given) {
  for (;;) {
    const double z = between(random, -1, 0.999);
    const glm::dvec3 p =
        given.place({between(random, -1, 1), between(random, -1, 1), given.matrices.reversed_depth ? -z : z});
    // An oblique near plane leaves places of the picture empty: they are behind the eye.
    if (given.clip(p).w > 0.0) return p;
  }
}

template <class Look>
void for_each_camera(std::uint64_t seed, int count, const Look& look) {
  Random random{seed};
  for (const AnyProjection kind : kAnyProjections) {
    for (int n = 0; n < count; ++n) {
      CameraMatrices m = any_matrices(random, kind, std::exp2(between(random, -9, 0)), 40);
      const glm::dvec3 target(between(random, 0, 60), between(random, 0, 60), between(random, 0, 60));
      test::show(random, target, std::exp2(between(random, -2, 6)), m);
      const Camera camera = camera_of(m);
      look(random, kind, Given(m), camera);
      if (testing::Test::HasFailure()) FAIL() << "kind " << static_cast<int>(kind) << ", camera " << n;
    }
  }
}

TEST(Projection, AnglesMakeTheCameraThatTheirMatricesMake) {
  Random random{501};
  for (int n = 0; n < 300; ++n) {
    CameraSettings s;
    s.position = 100.0 * any_direction(random);
    s.yaw_deg = between(random, -400, 400);
    s.pitch_deg = between(random, -90, 90);
    s.roll_deg = n % 3 == 0 ? 0.0 : between(random, -400, 400);
    s.fov_y_deg = between(random, 1, 170);
    s.aspect = between(random, 0.2, 5);
    s.near_voxels = std::exp2(between(random, -9, 2));
    s.far_voxels = s.near_voxels * std::exp2(between(random, 1, 12));
    s.reversed_depth = n % 2 == 0;
    Camera a;
    ASSERT_TRUE(make_camera(s, a).ok());
    const Camera b =
        camera_of(CameraMatrices{s.position, a.view_from_world, a.clip_from_view, s.reversed_depth});
    EXPECT_EQ(a.voxel, b.voxel);
    EXPECT_EQ(a.fine, b.fine);
    EXPECT_EQ(a.parallel, b.parallel);
    EXPECT_EQ(a.mirrored, b.mirrored);
    EXPECT_EQ(a.reversed_depth, b.reversed_depth);
    EXPECT_NEAR(glm::distance(a.forward, b.forward), 0.0, 1e-14);
    EXPECT_NEAR(b.near_voxels / a.near_voxels, 1.0, 1e-9);
    EXPECT_NEAR(b.far_voxels / a.far_voxels, 1.0, 1e-9);
    EXPECT_NEAR(near_reach(a) * std::sqrt(corner_cos2(a)) / a.near_voxels, 1.0, 1e-9);
    EXPECT_EQ(depth_near(a), a.near_voxels);
  }
  Camera standard;
  ASSERT_TRUE(make_camera(CameraSettings{}, standard).ok());
  const Camera untouched;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      EXPECT_NEAR(untouched.clip_from_view[column][row], standard.clip_from_view[column][row], 1e-12);
    }
  }
}

TEST(Projection, RollLowersTheRightSide) {
  Camera camera;
  ASSERT_TRUE(make_camera(CameraSettings{.roll_deg = 30}, camera).ok());
  const glm::dmat3 axes = world_from_view(camera);
  EXPECT_NEAR(glm::distance(axes[0], glm::dvec3(std::sqrt(0.75), -0.5, 0)), 0.0, 1e-15);
  EXPECT_NEAR(glm::distance(axes[1], glm::dvec3(0.5, std::sqrt(0.75), 0)), 0.0, 1e-15);
  EXPECT_EQ(axes[2], glm::dvec3(0, 0, 1));
  ASSERT_TRUE(make_camera(CameraSettings{.roll_deg = 450}, camera).ok());
  EXPECT_EQ(world_from_view(camera)[0], glm::dvec3(0, -1, 0));
}

// The float matrix shows the same picture as the matrices given, in double.
TEST(Projection, TheLatticeMatrixIsTheProjection) {
  for_each_camera(502, 200, [](Random& random, AnyProjection, const Given& given, const Camera& camera) {
    const glm::dmat4 matrix(clip_from_lattice(camera));
    for (int n = 0; n < 50; ++n) {
      const glm::dvec3 p = any_seen(random, given);
      const glm::dvec4 wanted = given.clip(p);
      const glm::dvec4 c = matrix * glm::dvec4((p - glm::dvec3(camera.voxel)) * double{kStepsPerVoxel}, 1.0);
      // The place is rounded to 1/16 step, which is more the nearer the point is.
      const double away = glm::distance(p, eye_of(camera));
      const double grid = camera.parallel ? 1e-5 : 1e-4 + 1e-4 / std::max(away, 1e-6);
      if (grid > 0.01) continue;
      ASSERT_NEAR(c.x / c.w, wanted.x / wanted.w, grid);
      ASSERT_NEAR(c.y / c.w, wanted.y / wanted.w, grid);
      ASSERT_NEAR(c.w, camera.parallel ? 1.0 : glm::dot(p - eye_of(camera), camera.forward),
                  1e-4 + 1e-6 * away);
    }
  });
}

TEST(Projection, RaysLeadToWhatIsSeen) {
  for_each_camera(503, 300, [](Random& random, AnyProjection kind, const Given& given, const Camera& camera) {
    ASSERT_EQ(camera.parallel, is_parallel(kind));
    ASSERT_NEAR(glm::length(camera.forward), 1.0, 1e-14);
    const ViewRays rays = view_rays(camera);
    const glm::dvec3 eye = eye_of(camera);
    double least = kInf;
    double most = -kInf;
    double widest = 1.0;
    for (int n = 0; n < 60; ++n) {
      const glm::dvec3 p = any_seen(random, given);
      const glm::dvec4 c = given.clip(p);
      const double depth = glm::dot(p - eye, camera.forward);
      const glm::dvec3 aside = rays.right * (c.x / c.w) + rays.up * (c.y / c.w);
      const glm::dvec3 found =
          camera.parallel ? rays.start + aside + rays.middle * depth : (rays.middle + aside) * depth;
      ASSERT_LT(glm::distance(found, p - eye), 1e-4 + 1e-9 * std::abs(depth));
      least = std::min(least, depth);
      most = std::max(most, depth);
      if (!camera.parallel) widest = std::min(widest, depth * depth / glm::dot(p - eye, p - eye));
    }
    const double slack = 1e-4 + 1e-6 * std::abs(most);
    ASSERT_GE(least, camera.near_voxels - slack);
    ASSERT_LE(most, camera.far_voxels + slack);
    ASSERT_GE(widest, corner_cos2(camera) * (1 - 1e-2) - 1e-9);
  });
}

// Corners of the near and the far plane, by the inverse matrix.
TEST(Projection, NearAndFarAreThoseOfTheCorners) {
  int finite = 0;
  int endless = 0;
  for_each_camera(504, 300, [&](Random&, AnyProjection, const Given& given, const Camera& camera) {
    const double nearest = camera.reversed_depth ? 1.0 : -1.0;
    for (const bool is_near : {true, false}) {
      double least = kInf;
      double most = -kInf;
      double reach = 0.0;
      bool all = true;
      for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec4 q =
            given.world_from_clip * glm::dvec4((corner & 1) != 0 ? 1 : -1, (corner & 2) != 0 ? 1 : -1,
                                               is_near ? nearest : -nearest, 1.0);
        // 1 / w of what is there: at most 0 where the plane does not meet the corner's ray in front of the
        // eye.
        if (q.w * kEndless <= glm::length(glm::dvec3(q))) {
          all = false;
          continue;
        }
        const glm::dvec3 p = glm::dvec3(q) / q.w + given.matrices.position - eye_of(camera);
        least = std::min(least, glm::dot(p, camera.forward));
        most = std::max(most, glm::dot(p, camera.forward));
        reach = std::max(reach, glm::length(p));
      }
      const double slack = 1e-4 * (1.0 + reach);
      if (is_near) {
        ASSERT_NEAR(camera.near_voxels, least, slack);
      } else if (all) {
        ASSERT_NEAR(camera.far_voxels, most, slack);
      } else {
        ASSERT_GT(camera.far_voxels, kEndless);
      }
      const double found = is_near ? near_reach(camera) : far_reach(camera);
      if (all) {
        ASSERT_NEAR(found, reach, slack);
      } else {
        ASSERT_GT(found, kEndless);
      }
      (all ? finite : endless) += 1;
    }
  });
  EXPECT_GT(finite, 1000);
  EXPECT_GT(endless, 200);
}

TEST(Projection, PlanesKeepWhatIsSeenAndCullTheRest) {
  int seen = 0;
  int unseen = 0;
  int culled = 0;
  for_each_camera(505, 300, [&](Random& random, AnyProjection, const Given& given, const Camera& camera) {
    const Frustum frustum = make_frustum(camera);
    const glm::mat4 matrix = clip_from_lattice(camera);
    for (int n = 0; n < 200; ++n) {
      glm::dvec3 p = any_seen(random, given);
      if (n % 2 != 0)
        p = {between(random, -100, 200), between(random, -100, 200), between(random, -100, 200)};
      if (!(glm::length(p) < 500)) continue;
      const glm::ivec3 q = glm::ivec3(glm::round(p * double{kStepsPerVoxel}));
      const bool kept = classify(frustum, {q, q}, kAllPlanes) != kOutside;
      const glm::dvec4 c = given.clip(glm::dvec3(q) / double{kStepsPerVoxel});
      const glm::vec4 drawn = matrix * glm::vec4(glm::vec3(q - camera.voxel * kStepsPerVoxel), 1.0f);
      if (Given::sees(c) || Given::sees(glm::dvec4(drawn))) {
        ++seen;
        ASSERT_TRUE(kept);
      } else if (std::max(std::abs(c.x), std::abs(c.y)) > 1.02 * std::abs(c.w)) {
        ++unseen;
        culled += kept ? 0 : 1;
      }
    }
  });
  EXPECT_GT(seen, 100'000);
  EXPECT_GT(unseen, 50'000);
  EXPECT_GT(culled, unseen * 0.995);
}

// A triangle that faces the eye is counter-clockwise, unless the picture is mirrored.
TEST(Projection, MirroredIsTheOtherWayRound) {
  int mirrored = 0;
  int upright = 0;
  for_each_camera(506, 200, [&](Random& random, AnyProjection, const Given& given, const Camera& camera) {
    for (int n = 0; n < 20; ++n) {
      const glm::dvec3 p = any_seen(random, given);
      const glm::dvec3 sight = camera.parallel ? camera.forward : p - eye_of(camera);
      const double size = camera.parallel ? 1e-3 : 1e-3 * glm::length(sight);
      if (!camera.parallel && glm::length(sight) < 0.02) continue;
      const glm::dvec3 u = glm::normalize(glm::cross(any_direction(random), sight));
      const glm::dvec3 v = glm::normalize(glm::cross(u, -sight)) * -1.0;  // u x v is towards the eye
      ASSERT_LT(glm::dot(glm::cross(u, v), sight), 0.0);
      const auto ndc = [&](glm::dvec3 at) {
        const glm::dvec4 c = given.clip(at);
        return glm::dvec2(c.x, c.y) / c.w;
      };
      const glm::dvec2 a = ndc(p + size * u) - ndc(p);
      const glm::dvec2 b = ndc(p + size * v) - ndc(p);
      ASSERT_EQ(a.x * b.y - a.y * b.x < 0.0, camera.mirrored);
    }
    (camera.mirrored ? mirrored : upright) += 1;
  });
  EXPECT_GT(mirrored, 300);
  EXPECT_GT(upright, 300);
}

// Lengths across forward, where it meets the picture.
TEST(Projection, PixelScalesAreTheMostAndTheFewest) {
  for_each_camera(507, 60, [](Random& random, AnyProjection, const Given& given, const Camera& camera) {
    const int width = 100 + random.below(2000);
    const int height = 100 + random.below(2000);
    const PixelScale scale = pixel_scale(camera, width, height);
    const glm::dvec3 on_axis = eye_of(camera) + camera.forward * 10.0;
    const auto pixels = [&](glm::dvec3 at) {
      const glm::dvec4 c = given.clip(at);
      return glm::dvec2(c.x * width, c.y * height) * (0.5 / c.w);
    };
    double most = 0.0;
    double least = kInf;
    double up = 0.0;
    for (int n = 0; n < 400; ++n) {
      const glm::dvec3 way = 1e-3 * glm::normalize(glm::cross(any_direction(random), camera.forward));
      const glm::dvec2 covered = (pixels(on_axis + way) - pixels(on_axis)) / (camera.parallel ? 1e-3 : 1e-4);
      most = std::max(most, glm::length(covered));
      least = std::min(least, glm::length(covered));
      up = std::max(up, std::abs(covered.y) / (0.5 * height));
    }
    // Where the axis leaves the picture far to the side, the place's rounding counts.
    ASSERT_LE(most, scale.most * 1.001);
    ASSERT_GE(most, scale.most * 0.99);
    ASSERT_GE(least, scale.least * 0.999);
    ASSERT_LE(least, std::max(scale.least * 1.02, scale.least + scale.most * 0.02));
    ASSERT_NEAR(up / vertical_scale(camera), 1.0, 0.01);
  });
}

// Two points e apart, one of them in the picture: at most S e / (rho - e) pixels (morph.h).
TEST(Projection, ApparentDistanceBoundsPixels) {
  double closest[std::size(kAnyProjections)] = {};
  for_each_camera(
      508, 300, [&](Random& random, AnyProjection kind, const Given& given, const Camera& camera) {
        const int width = 100 + random.below(2000);
        const int height = 100 + random.below(2000);
        const ErrorScale scale = make_error_scale(camera, width, height, 1.0);
        const auto pixels = [&](glm::dvec3 at) {
          const glm::dvec4 c = given.clip(at);
          return glm::dvec2(c.x * width, c.y * height) * (0.5 / c.w);
        };
        for (int n = 0; n < 100; ++n) {
          const glm::dvec3 p = any_seen(random, given);
          const glm::dvec3 from_eye = (p - eye_of(camera)) * double{kStepsPerVoxel};
          if (glm::length(from_eye) < 2000) continue;  // of which the place's rounding is a part in 10^5
          const double rho =
              apparent_distance(glm::vec3(from_eye), glm::vec3(camera.forward), scale.least_cos2);
          const double e = camera.parallel ? std::exp2(between(random, 0, 17)) : rho * 0.9 * random.unit();
          const glm::dvec3 other = p + e / kStepsPerVoxel * any_direction(random);
          if (!camera.parallel && !(given.clip(other).w > 0.0)) {
            ADD_FAILURE() << "behind the eye";
            return;
          }
          const double px = glm::distance(pixels(p), pixels(other));
          const double bound = scale.pixels * e / (rho - e);
          ASSERT_LE(px, bound * (1 + 1e-4));
          double& most = closest[static_cast<std::size_t>(kind)];
          most = std::max(most, px / bound);
        }
      });
  for (const double share : closest) EXPECT_GT(share, 0.95);
}

// As far as rock hides (occluders.h), depths half a voxel apart are more than one of 2^24 apart.
TEST(Projection, DepthTellsPlacesApartUpToItsReach) {
  int looked = 0;
  for_each_camera(509, 300, [&](Random& random, AnyProjection, const Given& given, const Camera& camera) {
    if (camera.parallel) return;
    const double reach = reach_of_depth(depth_near(camera)) / kStepsPerVoxel;
    const ViewRays rays = view_rays(camera);
    for (int n = 0; n < 20; ++n) {
      const glm::dvec3 ray = glm::normalize(rays.middle + rays.right * between(random, -1, 1) +
                                            rays.up * between(random, -1, 1));
      const double distance = reach * random.unit();
      const glm::dvec4 a = given.clip(eye_of(camera) + ray * distance);
      const glm::dvec4 b = given.clip(eye_of(camera) + ray * (distance + 0.5));
      if (!Given::sees(a) || !Given::sees(b)) continue;
      ASSERT_GT(std::abs(a.z / a.w - b.z / b.w), 0x1p-23);
      ++looked;
    }
  });
  EXPECT_GT(looked, 1000);
}

TEST(Projection, SquarePixelsHaveOneScale) {
  Random random{510};
  for (int n = 0; n < 1000; ++n) {
    const int width = 1 + random.below(4000);
    const int height = 1 + random.below(4000);
    CameraSettings s;
    s.aspect = static_cast<double>(width) / height;
    if (s.aspect < 1.0 / 64 || s.aspect > 64) continue;
    s.fov_y_deg = between(random, 1, 170);
    Camera camera;
    ASSERT_TRUE(make_camera(s, camera).ok());
    const PixelScale scale = pixel_scale(camera, width, height);
    EXPECT_EQ(scale.most, 0.5 * height * camera.clip_from_view[1][1]);
    EXPECT_EQ(scale.most, scale.least);
    EXPECT_EQ(vertical_scale(camera), camera.clip_from_view[1][1]);
  }
}

TEST(Projection, RefusesOneWrongFieldAtATime) {
  CameraSettings settings;
  Camera plain;
  ASSERT_TRUE(make_camera(settings, plain).ok());
  const CameraMatrices good{{1, 2, 3}, plain.view_from_world, plain.clip_from_view, false};
  CameraMatrices flat = good;
  flat.clip_from_view = glm::dmat4(0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, -0.01, 0, 0, 0, 0, 1);
  using Break = std::function<void(CameraMatrices&)>;
  std::vector<std::pair<const char*, Break>> cases;
  for (const double bad : {kNan, kInf, 2.0 * kCameraReach}) {
    cases.emplace_back("position", [=](CameraMatrices& m) { m.position.y = bad; });
  }
  // A centre that far away.
  cases.emplace_back("position", [=](CameraMatrices& m) {
    m.clip_from_view[3] = m.clip_from_view * glm::dvec4(0, 0, 3.0 * kCameraReach, 1);
  });
  for (int column = 0; column < 3; ++column) {
    for (int row = 0; row < 3; ++row) {
      for (const double off : {kNan, kInf, 1e-3, -1e-3}) {
        cases.emplace_back("view_from_world",
                           [=](CameraMatrices& m) { m.view_from_world[column][row] += off; });
      }
    }
  }
  cases.emplace_back("view_from_world", [](CameraMatrices& m) { m.view_from_world *= 2.0; });
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      for (const double bad : {kNan, kInf}) {
        cases.emplace_back("clip_from_view", [=](CameraMatrices& m) { m.clip_from_view[column][row] = bad; });
      }
    }
  }
  const auto projection = [&](const char* field, const Break& edit) { cases.emplace_back(field, edit); };
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view = glm::dmat4(0.0); });
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[0][0] = 0.0; });
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[0][0] = 1e-4; });   // too wide
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[1][1] = 1e7; });    // too narrow
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[2][0] = 2e3; });    // too far aside
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[3][2] = 0.0; });    // no depth
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[3][2] = -1e-9; });  // too near
  projection("clip_from_view", [](CameraMatrices& m) { m.clip_from_view[2][2] = 1.5; });    // all behind near
  projection("clip_from_view", [=](CameraMatrices& m) { m.clip_from_view = -flat.clip_from_view; });
  projection("clip_from_view", [=](CameraMatrices& m) {
    m.clip_from_view = flat.clip_from_view;
    m.clip_from_view[2][2] = 0.0;
  });
  projection("reversed_depth", [](CameraMatrices& m) { m.reversed_depth = true; });
  projection("reversed_depth", [](CameraMatrices& m) { m.clip_from_view[3][2] = 0.25; });

  std::size_t number = 0;
  for (const auto& [field, break_it] : cases) {
    CameraMatrices matrices = good;
    Camera camera = camera_of(matrices);
    camera.voxel = {7, 8, 9};
    break_it(matrices);
    const Status status = make_camera(matrices, camera);
    EXPECT_EQ(status.code(), StatusCode::invalid_argument) << field << ", case " << number;
    EXPECT_STREQ(status.field(), field) << "case " << number << ": " << status.what();
    EXPECT_EQ(camera.voxel, glm::ivec3(7, 8, 9)) << "a refused camera was changed";
    ++number;
  }
  CameraSettings rolled;
  rolled.roll_deg = kNan;
  Camera camera;
  EXPECT_STREQ(make_camera(rolled, camera).field(), "roll_deg");
  EXPECT_TRUE(make_camera(flat, camera).ok());
  EXPECT_TRUE(camera.parallel);
}

// What floats leave of a rotation is taken, and made exact.
TEST(Projection, RotationsAreMadeExact) {
  Random random{511};
  for (int n = 0; n < 500; ++n) {
    CameraMatrices m = any_matrices(random, AnyProjection::plain, 0.1, 1);
    const glm::dmat3 exact = m.view_from_world;
    m.view_from_world = glm::dmat3(glm::mat3(m.view_from_world));
    const Camera camera = camera_of(m);
    const glm::dmat3 product = camera.view_from_world * glm::transpose(camera.view_from_world);
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        ASSERT_NEAR(product[column][row], column == row ? 1.0 : 0.0, 1e-15);
        ASSERT_NEAR(camera.view_from_world[column][row], exact[column][row], 1e-6);
      }
    }
    ASSERT_EQ(glm::determinant(camera.view_from_world) < 0, glm::determinant(exact) < 0);
  }
}

}  // namespace
}  // namespace karst::core
