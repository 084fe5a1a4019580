// SPDX-License-Identifier: MIT
// The rim of a world: where its ground ends at the sides.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "terrain/patch/heights.h"
#include "terrain/surface/patch.h"

namespace karst::bake {
using namespace core;

// The rim as surroundings.h has it: of each side four points a voxel, vertices of the full level; where
// several lie above each other the topmost, where none is what lies between its neighbours. Empty where a
// side has none at all.
std::vector<glm::ivec3> trace_rim(const Surface& surface, const Heights& heights, glm::ivec3 extent);

}  // namespace karst::bake
