// SPDX-License-Identifier: MIT
// The boxes of shadow maps: what they cover, and that they stay where they are.
#include "terrain/shadow/cascades.h"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/vec4.hpp>

#include "terrain/lod/morph.h"
#include "tests/support/test_world.h"

namespace karst::core {
namespace {

using test::Random;

double between(Random& random, double low, double high) {
  return low + (high - low) * random.unit();
}

glm::dvec3 direction(Random& random) {
  for (;;) {
    const glm::dvec3 v(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    if (glm::dot(v, v) < 1 && glm::dot(v, v) > 0.01) return glm::normalize(v);
  }
}

struct Fitted {
  LightSpace light;
  std::vector<Cascade> cascades{kMostCascades};
};

class Cascades : public testing::Test {
 protected:
  FitCascades stage(Fitted& out, const Camera& camera) const {
    FitCascades fit;
    fit.settings = settings_;
    fit.camera = &camera;
    fit.to_sun = sun_;
    fit.world = world_;
    fit.light = &out.light;
    fit.cascades = out.cascades;
    return fit;
  }
  Fitted fit(const CameraSettings& settings) const {
    Camera camera;
    EXPECT_TRUE(make_camera(settings, camera).ok());
    Fitted out;
    const FitCascades fit = stage(out, camera);
    EXPECT_TRUE(fit.validate().ok());
    fit.run();
    out.cascades.resize(static_cast<std::size_t>(settings_.count));
    return out;
  }
  Fitted fit_at(glm::dvec3 eye) const {
    CameraSettings settings;
    settings.position = eye;
    return fit(settings);
  }

  CascadeSettings settings_{.count = 3, .size = 1024, .reach_voxels = 100};
  glm::dvec3 sun_ = glm::normalize(glm::dvec3(0.5, 0.6, -0.3));
  LatticeBox world_{glm::ivec3(0), glm::ivec3(400, 60, 300) * kStepsPerVoxel};
};

glm::dvec2 in_map(const Fitted& f, const Cascade& c, glm::dvec3 p) {
  return (glm::dvec2(glm::dot(f.light.x, p), glm::dot(f.light.y, p)) - c.low) / c.side;
}

TEST_F(Cascades, EachCoversABallAroundTheEyeAndGrows) {
  Random random{1};
  for (int n = 0; n < 200; ++n) {
    sun_ = direction(random);
    const glm::dvec3 eye(between(random, -50, 450), between(random, -50, 100), between(random, -50, 350));
    const Fitted f = fit_at(eye);
    double before = 0;
    for (const Cascade& c : f.cascades) {
      // seven eighths of half the side are the radius; in the middle half a step is lost.
      const double radius = c.side * 7 / 16;
      EXPECT_GT(radius, before * 1.5);
      before = radius;
      for (int turn = 0; turn < 20; ++turn) {
        const glm::dvec2 at = in_map(f, c, eye + direction(random) * radius * 0.98);
        for (const double v : {at.x, at.y}) {
          EXPECT_GT(v, kCascadeBorder / 1024.0);
          EXPECT_LT(v, 1 - kCascadeBorder / 1024.0);
        }
      }
    }
    EXPECT_NEAR(before, settings_.reach_voxels, 1e-9);
  }
}

// The sun's axes are a right-handed basis, and the world's depth lies within 0..1 in every map.
TEST_F(Cascades, MatricesMapTheWorldAsTheyShould) {
  Random random{2};
  for (int n = 0; n < 200; ++n) {
    sun_ = n == 0 ? glm::dvec3(0, 1, 0) : direction(random);
    const glm::dvec3 eye(between(random, 0, 400), between(random, 0, 60), between(random, 0, 300));
    const Fitted f = fit_at(eye);
    EXPECT_NEAR(glm::dot(glm::cross(f.light.x, f.light.y), f.light.z), 1, 1e-12);
    EXPECT_EQ(f.light.z, sun_);
    for (const Cascade& c : f.cascades) {
      for (int k = 0; k < 20; ++k) {
        const glm::dvec3 p(between(random, 0, 400), between(random, 0, 60), between(random, 0, 300));
        const glm::vec4 from_voxel((p - glm::dvec3(c.eye.voxel)) * double{kStepsPerVoxel}, 1.0f);
        const glm::vec4 clip = c.clip_from_lattice * from_voxel;
        const glm::dvec2 at = in_map(f, c, p);
        const double depth = (f.light.near_z - glm::dot(f.light.z, p)) / (f.light.near_z - f.light.far_z);
        // A hundredth of a texel near the box, and float's share of the distance outside it.
        const double off = 2e-5 + 1e-6 * glm::length(at);
        EXPECT_NEAR(clip.x, 2 * at.x - 1, off);
        EXPECT_NEAR(clip.y, 2 * at.y - 1, off);
        EXPECT_NEAR(clip.z, 2 * depth - 1, 1e-5);
        EXPECT_EQ(clip.w, 1.0f);
        EXPECT_GE(depth, 0);
        EXPECT_LE(depth, 1);
        // Casters: everything that the map can show, however far towards the sun, is in the frustum.
        const LatticeBox box{glm::ivec3(p * double{kStepsPerVoxel}), glm::ivec3(p * double{kStepsPerVoxel})};
        const bool in_box = at.x > 0 && at.x < 1 && at.y > 0 && at.y < 1;
        EXPECT_TRUE(!in_box || classify(c.frustum, box, kAllPlanes) != kOutside);
        const double border = (kCascadeBorder + 2.0) / settings_.size + 0.03 / c.side;
        const bool far_outside = at.x < -border || at.x > 1 + border || at.y < -border || at.y > 1 + border;
        EXPECT_TRUE(!far_outside || classify(c.frustum, box, kAllPlanes) == kOutside);
        if (classify(c.inner, box, kAllPlanes) == 0) {
          EXPECT_GT(std::min({at.x, at.y, 1 - at.x, 1 - at.y}), kCascadeBorder / 1024.0);
        }
      }
    }
  }
}

TEST_F(Cascades, TurningChangesNothing) {
  Random random{3};
  CameraSettings settings;
  settings.position = {123.4, 45.6, 78.9};
  const Fitted before = fit(settings);
  for (int n = 0; n < 50; ++n) {
    settings.yaw_deg = between(random, -180, 180);
    settings.pitch_deg = between(random, -90, 90);
    settings.fov_y_deg = between(random, 20, 120);
    const Fitted now = fit(settings);
    for (std::size_t c = 0; c < 3; ++c) EXPECT_TRUE(now.cascades[c].same_as(before.cascades[c]));
  }
}

// Surfaces in maps are those of the picture: of a parallel view, at its constant distance.
TEST_F(Cascades, OfParallelViewsHaveTheirDistance) {
  CameraMatrices matrices;
  matrices.position = {123.4, 45.6, 78.9};
  matrices.clip_from_view = glm::dmat4(0.05, 0, 0, 0, 0, 0.05, 0, 0, 0, 0, -0.01, 0, 0, 0, 0, 1);
  Camera camera;
  ASSERT_TRUE(make_camera(matrices, camera).ok());
  Fitted parallel;
  stage(parallel, camera).run();
  const Fitted perspective = fit_at(matrices.position);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_EQ(parallel.cascades[c].least_cos2, make_error_scale(camera, 100, 100, 1).least_cos2);
    EXPECT_EQ(perspective.cascades[c].least_cos2, 1.0f);
    EXPECT_FALSE(parallel.cascades[c].same_as(perspective.cascades[c]));
  }
}

// Wherever the camera goes, a point of the world keeps its place within a texel, and boxes seldom move.
TEST_F(Cascades, MovingKeepsTheGridOfTexels) {
  const glm::dvec3 p(200, 30, 150);
  const Fitted first = fit_at(p);
  Fitted last = first;
  int moves = 0;
  constexpr int kFrames = 2000;
  for (int n = 1; n <= kFrames; ++n) {
    const glm::dvec3 eye = p + glm::dvec3(0.05, 0.002, 0.02) * double(n);
    const Fitted now = fit_at(eye);
    for (std::size_t c = 0; c < 3; ++c) {
      const Cascade& cascade = now.cascades[c];
      EXPECT_EQ(cascade.texel, first.cascades[c].texel);
      const glm::dvec2 texels = (cascade.low - first.cascades[c].low) / cascade.texel;
      EXPECT_NEAR(texels.x, std::round(texels.x), 1e-6);
      EXPECT_NEAR(texels.y, std::round(texels.y), 1e-6);
      moves += cascade.same_as(last.cascades[c]) ? 0 : 1;
    }
    last = now;
  }
  EXPECT_GT(moves, 10);
  EXPECT_LT(moves, kFrames / 20);
}

TEST_F(Cascades, TheLastOneCoversASmallWorld) {
  world_.max = glm::ivec3(40, 20, 50) * kStepsPerVoxel;
  Random random{5};
  glm::dvec2 low(0);
  for (int n = 0; n < 50; ++n) {
    const Fitted f =
        fit_at({between(random, -200, 200), between(random, -20, 100), between(random, -200, 200)});
    const Cascade& last = f.cascades.back();
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p((corner & 1) * 40, (corner & 2) / 2 * 20, (corner & 4) / 4 * 50);
      const glm::dvec2 at = in_map(f, last, p);
      EXPECT_GT(std::min({at.x, at.y, 1 - at.x, 1 - at.y}), kCascadeBorder / 1024.0);
    }
    EXPECT_TRUE(n == 0 || last.low == low);
    low = last.low;
    EXPECT_LT(last.side, 80);
  }
}

TEST_F(Cascades, RefusesOneWrongFieldAtATime) {
  Camera camera;
  Fitted out;
  const std::vector<std::pair<const char*, std::function<void(FitCascades&)>>> cases = {
      {"count", [](FitCascades& f) { f.settings.count = -1; }},
      {"count", [](FitCascades& f) { f.settings.count = kMostCascades + 1; }},
      {"size", [](FitCascades& f) { f.settings.size = 511; }},
      {"size", [](FitCascades& f) { f.settings.size = 1000; }},
      {"size", [](FitCascades& f) { f.settings.size = 2064; }},
      {"reach_voxels", [](FitCascades& f) { f.settings.reach_voxels = 3.9; }},
      {"reach_voxels", [](FitCascades& f) { f.settings.reach_voxels = NAN; }},
      {"camera", [](FitCascades& f) { f.camera = nullptr; }},
      {"to_sun", [](FitCascades& f) { f.to_sun.x = std::numeric_limits<double>::quiet_NaN(); }},
      {"to_sun", [](FitCascades& f) { f.to_sun *= 1.1; }},
      {"world", [](FitCascades& f) { f.world.max.y = -1; }},
      {"light", [](FitCascades& f) { f.light = nullptr; }},
      {"cascades", [](FitCascades& f) { f.cascades = f.cascades.first(2); }},
  };
  for (const auto& [field, spoil] : cases) {
    FitCascades fit = stage(out, camera);
    EXPECT_TRUE(fit.validate().ok());
    spoil(fit);
    EXPECT_EQ(fit.validate().code(), StatusCode::invalid_argument) << field;
    EXPECT_STREQ(fit.validate().field(), field);
  }
}

}  // namespace
}  // namespace karst::core
