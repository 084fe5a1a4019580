// SPDX-License-Identifier: MIT
// A ground that can be dug, and holes in it.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/library/ground_file.h"
#include "tests/support/memory_ground.h"

#include "karst/karst.h"

namespace karst::test {

// Samples are half a voxel of 1 m apart, nodes of size 0 two voxels wide: 150 x 125 voxels.
inline constexpr int kWide = 301, kDeep = 251;
inline constexpr double kSpacing_m = 0.5;

inline double height(double x, double z) {
  return 12 + 5 * value_noise(9, glm::dvec3(x, 0, z) / 14.0);
}

inline std::vector<std::byte> file_to_dig(const core::WorldMaterials& materials = core::WorldMaterials()) {
  const auto ground = MemoryGround::to_dig(kWide, kDeep, 4096, [](std::int64_t i, std::int64_t k) {
    return static_cast<std::int32_t>(height(0.5 * double(i), 0.5 * double(k)) * core::kStepsPerVoxel /
                                     core::kVertexStep);
  });
  return ground_file(ground, kSpacing_m, {}, materials);
}

inline Needs needs_to_dig() {
  Needs needs;
  needs.queries = 1;
  needs.edit_patches = 1'500;
  needs.edit_tiles = 400;
  needs.undo_bytes = 1 << 20;
  needs.dig_regions = 3;
  // So few that regions and what is loaded have cells of the sky as fine as they can be.
  needs.region_patches = 1'000;
  return needs;
}

// Metres from the ground's north-western sample.
inline karst::Edit ball(const karst::World& world, double x, double z, double radius, double below = 0) {
  karst::Edit edit;
  edit.radius_m = radius;
  const Vec3 origin = world.info().origin_m;
  edit.place = world.from_world({origin.x + 0.5 + x, origin.y + height(x, z) - below, origin.z + 0.5 + z});
  return edit;
}

}  // namespace karst::test
