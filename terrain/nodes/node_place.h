// SPDX-License-Identifier: MIT
// Where a vertex of a node is drawn, in float, as on the GPU (gles_shaders/terrain_vertex.glsl repeats it):
// the same bits for one place, whichever node of whichever size it is a vertex of.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

#include "terrain/ground/ground.h"
#include "terrain/lod/morph.h"

namespace karst::core {

// Lattice steps of size 0 from the corner of the camera's voxel, of which there may be any. origin: voxels of
// the size; place: steps of the size from it, an int16. The camera's voxel lies at a multiple of 2^(13 -
// size) steps of the size, so that what is in brackets is exact: 24 bits hold it up to kMostSize. The sum is
// then rounded once, and the factor is exact.
inline glm::vec3 node_place(glm::ivec3 camera_voxel, int size, glm::ivec3 origin, glm::ivec3 place) {
  const float unit = std::ldexp(1.0f, size);
  glm::vec3 result;
  for (int axis = 0; axis < 3; ++axis) {
    const int whole = camera_voxel[axis] >> size;
    const auto rest =
        static_cast<float>(camera_voxel[axis] & ((1 << size) - 1)) * (float{kStepsPerVoxel} / unit);
    const auto voxels = static_cast<float>(origin[axis] - whole);
    result[axis] = (voxels * float{kStepsPerVoxel} + (static_cast<float>(place[axis]) - rest)) * unit;
  }
  return result;
}

}  // namespace karst::core
