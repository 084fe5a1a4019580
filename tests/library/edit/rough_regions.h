// SPDX-License-Identifier: MIT
// A rough ground with up to three regions, which edits may change: 241 x 201 samples, nodes of size 0 are two
// voxels wide.
#pragma once

#include <cstddef>
#include <vector>

#include "terrain/base/lattice.h"
#include "tests/library/ground_file.h"
#include "tests/support/memory_ground.h"

namespace karst::test {

inline constexpr std::size_t kMostRoughRegions = 3;
// What the file says of how far a region is from the ground; lattice steps.
inline constexpr double kRegionError = 4.0 * core::kStepsPerVoxel;

// Of a place, voxels from the corner of the first region.
double rough_regions_height(double x, double z);
MemoryGround rough_regions_ground(std::size_t regions);
std::vector<std::byte> rough_regions_file(std::size_t regions,
                                          const core::WorldMaterials& materials = core::WorldMaterials());

}  // namespace karst::test
