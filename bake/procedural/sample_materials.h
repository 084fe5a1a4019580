// SPDX-License-Identifier: MIT
// Procedural materials, so that worlds need no image files: grass, rock, strata, sand, snow, ceiling. The
// same bits on every compiler.
#pragma once

#include "bake/textures/material_image.h"

#include <string_view>

namespace karst::bake {

bool is_sample_material(std::string_view name);

// side: a power of two, 16..1024. Precondition: is_sample_material(name).
MaterialImage make_sample_material(std::string_view name, int side);

}  // namespace karst::bake
