// SPDX-License-Identifier: MIT
// What shading a patch may need, from what is known of it before any camera looks at it: its normals, its
// heights, the rules of the materials and where the sky is open.
#pragma once

#include <cstdint>
#include <span>

#include "karst/status.h"
#include "terrain/field/sky_visibility.h"
#include "terrain/measure/normal_cone.h"
#include "terrain/patch/bounds.h"
#include "terrain/shading/materials.h"
#include "terrain/shading/shading.h"
#include "terrain/surface/patch.h"

namespace karst::core {

// Sky visibility below which caves begin; that of gles_shaders/interface.glsl, as the renderer checks.
inline constexpr float kCaveBegins = 0.1f;

struct FindPatchShading {
  // Inputs, borrowed.
  Surface surface;
  glm::ivec3 corner{0};  // of its octree, voxels from the world's
  std::span<const PatchBounds> bounds;
  std::span<const NormalCone> cones;  // of shading normals
  const MaterialSet* materials = nullptr;
  std::span<const std::uint8_t> overrides;  // by patch: material plus 1, kPaintedByMap, or 0; empty: none
  const SkyVisibility* sky = nullptr;
  std::span<const PointLight> lights;
  ShadingSkips skips;

  // Output, borrowed: one a patch.
  std::span<PatchShading> out;

  // invalid_argument naming the first field that is missing or of another size than the surface.
  Status validate() const;
  // Precondition: validate() is ok.
  void run() const;
  // Of one patch. Same precondition.
  void run(PatchId patch) const;

 private:
  bool may_be_cave(PatchId patch) const;
  bool lit_by_lamp(PatchId patch) const;
  // The one material that can lie on the patch, or -1.
  int sole_material(PatchId patch, bool cave) const;
};

}  // namespace karst::core
