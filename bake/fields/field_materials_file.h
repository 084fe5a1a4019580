// SPDX-License-Identifier: MIT
// What the samples of a baked field are made of: from a file of a byte a sample, or as layers.
#pragma once

#include <string>

#include <glm/vec3.hpp>

#include "platform/base/error.h"
#include "terrain/isosurface/field_blocks.h"
#include "terrain/shading/materials.h"

namespace karst::bake {

inline constexpr const char* kLayers = "layers";

// Fills the materials of a field, which has room for all of its blocks. size: samples of the values that it
// was made of; beyond, materials are as at their sides.
struct FillMaterials {
  // kLayers: strata, warped, of all the materials by turns, each a twelfth of the field high. Else a file,
  // NRRD or raw: 0 is by rules, 1 and more the material of that number.
  std::string path;
  glm::ivec3 size{0};
  const core::MaterialSet* materials = nullptr;
  int threads = 1;

  // The error names the file, and the sample that has a material that is not there.
  Error run(core::FieldBlocks& field) const;
};

}  // namespace karst::bake
