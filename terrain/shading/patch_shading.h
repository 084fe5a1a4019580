// SPDX-License-Identifier: MIT
// What shading a patch may need, from what is known of it before any camera looks at it: its normals, its
// heights, the rules of the materials and where the sky is open.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/field/octree.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/shading.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// Voxels below the sky-line where caves begin; that of gles_shaders/interface.glsl, as the renderer checks.
inline constexpr float kCaveBegins = 2.0f;

struct FindPatchShading {
  // Inputs, borrowed.
  Surface surface;
  std::span<const PatchBounds> bounds;
  std::span<const NormalCone> cones;  // of shading normals
  const MaterialSet* materials = nullptr;
  std::span<const std::uint8_t> overrides;  // by patch: material plus 1, or 0; empty: none
  const Octree* octree = nullptr;
  glm::ivec3 extent{1};  // of the world, voxels
  std::span<const PointLight> lights;
  ShadingSkips skips;

  // Working memory, borrowed: extent.x * extent.z values.
  std::span<std::int16_t> sky;

  // Output, borrowed: one a patch.
  std::span<PatchShading> out;

  // invalid_argument naming the first field that is missing or of another size than the surface.
  Status validate() const;
  // Precondition: validate() is ok.
  void run() const;

 private:
  void find_sky() const;
  bool may_be_cave(PatchId patch) const;
  bool lit_by_lamp(PatchId patch) const;
  // The one material that can lie on the patch, or -1.
  int sole_material(PatchId patch, bool cave) const;
};

}  // namespace karst::core
