// SPDX-License-Identifier: MIT
// gles_shaders/interface.glsl and air_interface.glsl as C++: the same macros, uniform blocks as structs.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include "terrain/base/config.h"
#include "terrain/base/lattice.h"
#include "terrain/ground/demand.h"
#include "terrain/lod/morph.h"
#include "terrain/nodes/family_row.h"
#include "terrain/resident/page_table.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/patch_shading.h"
#include "terrain/shadow/cascades.h"

namespace karst::core::shader {

using mat4 = glm::mat4;
using vec4 = glm::vec4;
using ivec4 = glm::ivec4;

#include "gles_shaders/interface.glsl"
// Uses a macro of the one before.
#include "gles_shaders/air_interface.glsl"

static_assert(kPageVertices == 1u << KARST_PAGE_BITS);
static_assert(kStepsPerVoxel == static_cast<int>(KARST_STEPS_PER_VOXEL));
static_assert(kCascadeBorder == static_cast<int>(KARST_SHADOW_BORDER));
static_assert(kMorphRow == KARST_MORPH_ROW);
static_assert(kThresholdUnit == static_cast<float>(KARST_THRESHOLD_UNIT));
static_assert(kMostMorphRows == 1u << KARST_ROW_BITS);
static_assert(KARST_PLACE_BITS + KARST_ROW_BITS == KARST_MATERIAL_SHIFT);
static_assert(kMostPlaces == 1u << KARST_PLACE_BITS && kFirstGroundPlace == KARST_FIRST_GROUND_PLACE);
static_assert(kMeshPlace == KARST_MESH_PLACE && kMeshPlace < kFirstGroundPlace);
static_assert(kNodeVertices == KARST_NODE_VERTICES);
static_assert(2 * kMostPageHeight == 1 << KARST_ORIGIN_Y_BITS && kMostPageSize < 1 << KARST_SIZE_BITS);
static_assert(KARST_ORIGIN_Y_BITS + KARST_SIZE_BITS == KARST_CAVE_SHIFT);
static_assert(kLatticeBits == KARST_STEPS_LOG2);
static_assert(kMostMaterials == KARST_MOST_MATERIALS && kMostLights == KARST_MOST_LIGHTS);
static_assert(kCaveBegins == static_cast<float>(KARST_CAVE_BEGINS));
static_assert(kMorphShare == static_cast<float>(KARST_MORPH_SHARE));
static_assert(kNodeMorphShare == static_cast<float>(KARST_NODE_MORPH_SHARE));

}  // namespace karst::core::shader
