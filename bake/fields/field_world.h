// SPDX-License-Identifier: MIT
// The surface of a world's voxels, patches with heights, as distances on a grid.
#pragma once

#include <string>
#include <string_view>

#include "bake/fields/field_grid.h"
#include "platform/base/error.h"

namespace karst::bake {

// Whether a file's first bytes are those of a world.
bool is_world(std::string_view head);

// Of a world of voxels, or the only region of a ground: at the level whose vertices are as near to each other
// as samples are, from the outermost voxels' centres, where patches end, and in metres, below 0 in what is
// solid; what is further from the surface than three samples has that distance. spacing_m: between samples;
// 0: so that there are as many as vertices, but no more than eight a voxel. The error names the file.
Error read_world_surface(const std::string& path, double spacing_m, int threads, FieldGrid& grid);

}  // namespace karst::bake
