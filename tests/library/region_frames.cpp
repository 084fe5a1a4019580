// SPDX-License-Identifier: MIT
#include "tests/library/region_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace karst::test {

ViewState RegionHostTest::view(glm::dvec3 eye, glm::dvec3 target, double fov) const {
  const auto vec = [](glm::dvec3 v) { return Vec3{v.x, v.y, v.z}; };
  ViewState shown = looking(*host_->world, vec(eye), vec(target), kWidth, kHeight);
  set_perspective(shown, fov, 0.1, 2000);
  return shown;
}

bool RegionHostTest::ends_on_ground(const RegionScene& scene, const Look& look) const {
  const glm::dvec3 ahead = glm::normalize(look.target - look.eye);
  const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 1, 0)));
  const glm::dvec3 up = glm::cross(right, ahead);
  const double y = std::tan(glm::radians(look.fov) / 2), x = y * kWidth / kHeight;
  for (int corner = 0; corner < 4; ++corner) {
    const glm::dvec3 ray = ahead + (corner % 2 == 0 ? -x : x) * right + (corner / 2 == 0 ? -y : y) * up;
    if (!(ray.y < -1e-3)) return false;
    const glm::dvec3 end = look.eye + ray * ((scene.lowest - look.eye.y) / ray.y);
    if (end.x < scene.low[0] || end.x > scene.high[0] || end.z < scene.low[1] || end.z > scene.high[1])
      return false;
  }
  return true;
}

Look RegionHostTest::random_look(const RegionScene& scene, int kind, std::mt19937& random) const {
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  Look look;
  do {
    const RegionSite& site = scene.sites[random() % scene.sites.size()];
    if (kind == 0) {
      // Away from the shaft.
      look.eye = site.chamber + glm::dvec3(between(-1, 0.5), between(-1.5, 0), between(-1, 1));
      look.target = look.eye + glm::dvec3(-4, -between(0, 3), between(-3, 3));
      return look;
    }
    if (kind == 1) {
      // Over a side, and what lies beside it.
      const bool west = random() % 2 == 0;
      look.eye = site.corner + glm::dvec3((west ? 0.5 : site.size.x - 0.5) + between(-2, 2), 0,
                                          between(2, site.size.z - 2));
      look.eye.y = scene.ground_height(look.eye.x, look.eye.z) + std::exp2(between(0, 3));
      look.target = look.eye + glm::dvec3(between(-1, 1), -2, between(-1, 1));
    } else {
      look.eye = site.corner + glm::dvec3(between(2, site.size.x - 2), 0, between(2, site.size.z - 2));
      look.eye.y = scene.highest + std::exp2(between(-1, 4));
      const double turn = between(0, 6.28);
      look.target = look.eye + glm::dvec3(std::cos(turn), -between(2.5, 4), std::sin(turn));
      look.fov = 30;
    }
  } while (!ends_on_ground(scene, look));
  return look;
}

void RegionHostTest::look_for_holes(const std::vector<std::byte>& file, const RegionScene& scene,
                                    std::span<const std::uint64_t> vertex_bytes, unsigned seed, int frames) {
  const char* const wanted = std::getenv("KARST_FRAMES");
  if (wanted != nullptr) frames = std::atoi(wanted);
  const int each = std::max(3, frames / (2 * static_cast<int>(vertex_bytes.size())));
  for (const bool deferred : {false, true}) {
    for (const std::uint64_t bytes : vertex_bytes) {
      Needs needs;
      needs.vertex_bytes = bytes;
      if (deferred) needs.deferred_width = kWidth, needs.deferred_height = kHeight;
      GlOptions options;
      options.shading = deferred ? Shading::deferred : Shading::forward;
      open(needs, {}, options, file);
      std::mt19937 random(seed);
      int with_patches = 0;
      for (int frame = 0; frame < each; ++frame) {
        const Look look = random_look(scene, frame % 3, random);
        ViewState shown = view(look.eye, look.target, look.fov);
        shown.error_px = std::exp2(std::uniform_real_distribution<double>(-1, 5)(random));
        FrameResult result;
        const double work_ms = frame % 2 == 0 ? 0 : 0.01;
        ASSERT_EQ(holes(shown, work_ms, result), 0u)
            << frame << ' ' << deferred << ' ' << bytes << ": " << look.eye.x << ' ' << look.eye.y << ' '
            << look.eye.z << " to " << look.target.x << ' ' << look.target.y << ' ' << look.target.z
            << " error " << shown.error_px;
        with_patches += costs(*renderer_).patches_drawn + costs(*renderer_).blocks_drawn > 0 ? 1 : 0;
      }
      EXPECT_GT(with_patches, each / 2);
      EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
      close();
    }
  }
}

}  // namespace karst::test
