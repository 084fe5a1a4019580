// SPDX-License-Identifier: MIT
// A cone around the normals that shading a patch can meet: of its vertices, at home and where they morph to,
// and, because it is convex, of everything between them. Unlike NormalCone's triangles these normals are
// averages over neighbouring patches, too, and quantised as the GPU decodes them.
#pragma once

#include <span>

#include "terrain/measure/normal_cone.h"
#include "terrain/patch/gpu_vertex.h"

namespace karst::core {

// vertices: of a whole patch at its full level. kNone where they do not lie within a half-space.
NormalCone measure_shading_cone(std::span<const GpuVertex> vertices);

}  // namespace karst::core
