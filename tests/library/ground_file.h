// SPDX-License-Identifier: MIT
// World files that are a ground, with a region of voxels or without.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tests/support/memory_ground.h"
#include "tests/support/test_world.h"

namespace karst::test {

// Images over a ground, of 8 bits: red, green, blue and how much they cover at a place in samples, as sRGB
// has them. at: also of texels beside the ground.
struct GroundImages {
  std::function<std::array<std::uint8_t, 4>(double column, double row)> at = {};
  int least_size = 0;
  // Whether there are tiles of the two least sizes over a place in samples; none: there are everywhere.
  std::function<bool(double column, double row)> is_fine = {};
};

// spacing_m: from one sample to the next, along x. The north-west sample lies at (0, 0, 0) where its height
// is 0.
std::vector<std::byte> ground_file(const MemoryGround& ground, double spacing_m,
                                   const GroundImages& images = {},
                                   const core::WorldMaterials& materials = core::WorldMaterials());
// The same of a ground with a region, which the voxels are, with heights of all patches. The corner of the
// voxels lies at (0, 0, 0).
std::vector<std::byte> ground_file(const MemoryGround& ground, const TestWorld& voxels,
                                   const GroundImages& images = {});
// The same of several regions, in their order.
std::vector<std::byte> ground_file(const MemoryGround& ground, std::span<const TestWorld* const> regions,
                                   const GroundImages& images = {},
                                   const core::WorldMaterials& materials = core::WorldMaterials());

// The same of a region whose surface is a field's; the voxels are what its sky is seen of. rim_edges: room
// for those of its rim.
std::vector<std::byte> ground_file(const MemoryGround& ground, const TestWorld& voxels,
                                   const core::FieldBlocks& field, std::uint32_t rim_edges);

// Ridges and valleys up to 60 m over 600 x 480 samples of 10 m, rough by up to a metre.
MemoryGround::Heights rough_heights();
MemoryGround rough_ground();
inline constexpr double kRoughSpacing_m = 10;

}  // namespace karst::test
