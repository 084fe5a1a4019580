// SPDX-License-Identifier: MIT
// How high the ground stands in each column of voxels, for telling caves from open ground: a point well below
// the tops around it has no sky.
#pragma once

#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "terrain/voxel/octree.h"

namespace karst {

// For row z of the world's columns: out[x] = the least, over the columns up to one away in x and z, of the
// height in voxels above which the column is empty (0: all of it is). The least, so that cliffs and the
// mouths of caves count as open. out holds extent.x values; 0 <= z < extent.z; the extent lies in the octree.
void column_tops_row(const Octree& octree, glm::ivec3 extent, std::int32_t z, std::span<float> out);

}  // namespace karst
