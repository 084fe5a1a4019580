// SPDX-License-Identifier: MIT
#include "terrain/shading/patch_shading.h"

#include <algorithm>
#include <cmath>

#include "terrain/base/check.h"
#include "terrain/base/lattice.h"
#include "terrain/cull/bounds_tree.h"

namespace karst::core {
namespace {

// Beyond what rounding does to normals and heights.
constexpr float kSlack = 2e-3f;

struct Range {
  float low, high;
};

Range range_along(const NormalCone& cone, glm::vec3 direction) {
  return {-most_along(cone, -direction) - kSlack, most_along(cone, direction) + kSlack};
}

// Whether a value of the range may be covered, or all of them are, wherever noise moves the limits.
bool may_cover(Range v, float low, float high, float soft, float fray) {
  const float moves = fray * soft + kSlack;
  return v.high + moves > low - soft && v.low - moves < high + soft;
}
bool covers_all(Range v, float low, float high, float soft, float fray) {
  const float moves = fray * soft + kSlack;
  return v.low - moves >= low + soft && v.high + moves <= high - soft;
}

}  // namespace

Status FindPatchShading::validate() const {
  const auto wrong = [](const char* field) {
    return Status{StatusCode::invalid_argument, "of another size than the surface", field};
  };
  if (materials == nullptr || sky == nullptr) {
    return {StatusCode::invalid_argument, "missing", materials == nullptr ? "materials" : "sky"};
  }
  if (bounds.size() != surface.patches.size()) return wrong("bounds");
  if (cones.size() != surface.patches.size()) return wrong("cones");
  if (out.size() != surface.patches.size()) return wrong("out");
  if (!overrides.empty() && overrides.size() != surface.patches.size()) return wrong("overrides");
  return {};
}

void FindPatchShading::run() const {
  KARST_ASSERT(validate().ok());
  for (PatchId p = 0; p < out.size(); ++p) run(p);
}

void FindPatchShading::run(PatchId p) const {
  out[p] = {};
  if (surface.is_free(p)) return;
  const bool cave = may_be_cave(p);
  unsigned needs = cave || !skips.cave || lit_by_lamp(p) ? unsigned{kShadeCave} : 0u;
  const std::uint8_t given = overrides.empty() ? std::uint8_t{0} : overrides[p];
  const bool painted = given == kPaintedByMap;
  out[p].material = painted ? std::uint8_t{0} : given;
  const int sole = painted ? -1 : given != 0 ? given - 1 : sole_material(p, cave);
  if (sole >= 0 && skips.material) out[p].material = static_cast<std::uint8_t>(sole + 1);
  if (out[p].material == 0 || !skips.material) needs |= kShadeBlend;
  out[p].needs = static_cast<std::uint8_t>(needs);
}

// The sky is looked up a cell away from the surface, along the normal.
bool FindPatchShading::may_be_cave(PatchId patch) const {
  const LatticeBox box = patch_box(surface, bounds, patch);
  glm::vec3 low = glm::vec3(box.min) / static_cast<float>(kStepsPerVoxel);
  glm::vec3 high = glm::vec3(box.max) / static_cast<float>(kStepsPerVoxel);
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 direction(0.0f);
    direction[axis] = 1.0f;
    const Range normal = range_along(cones[patch], direction);
    low[axis] += normal.low * sky->grid().cell_voxels() - kSlack;
    high[axis] += normal.high * sky->grid().cell_voxels() + kSlack;
  }
  return static_cast<float>(sky->least_in(low, high)) / 255.0f < kCaveBegins + kSlack;
}

bool FindPatchShading::lit_by_lamp(PatchId patch) const {
  const LatticeBox box = patch_box(surface, bounds, patch);
  const glm::vec3 low = glm::vec3(corner) + glm::vec3(box.min) / static_cast<float>(kStepsPerVoxel);
  const glm::vec3 high = glm::vec3(corner) + glm::vec3(box.max) / static_cast<float>(kStepsPerVoxel);
  return std::any_of(lights.begin(), lights.end(), [&](const PointLight& light) {
    float distance2 = 0.0f;
    for (int k = 0; k < 3; ++k) {
      const float outside = std::max({low[k] - light.position[k], light.position[k] - high[k], 0.0f});
      distance2 += outside * outside;
    }
    const float reach = light.radius * (1.0f + kSlack);
    return distance2 <= reach * reach;
  });
}

int FindPatchShading::sole_material(PatchId patch, bool cave) const {
  const Range slope = range_along(cones[patch], {0.0f, 1.0f, 0.0f});
  const LatticeBox box = patch_box(surface, bounds, patch);
  const auto base = static_cast<float>(corner.y);
  const Range height = {base + static_cast<float>(box.min.y) / static_cast<float>(kStepsPerVoxel) - kSlack,
                        base + static_cast<float>(box.max.y) / static_cast<float>(kStepsPerVoxel) + kSlack};
  int found = -1;
  for (int m = static_cast<int>(materials->count) - 1; m > 0; --m) {
    const Material& r = materials->materials[m];
    const bool may =
        (cave && r.cave > 0.0f) || (may_cover(slope, r.slope_low, r.slope_high, r.slope_soft, r.fray) &&
                                    may_cover(height, r.height_low, r.height_high, r.height_soft, r.fray));
    if (!may) continue;
    if (found >= 0) return -1;
    found = m;
    if (covers_all(slope, r.slope_low, r.slope_high, r.slope_soft, r.fray) &&
        covers_all(height, r.height_low, r.height_high, r.height_soft, r.fray)) {
      return found;
    }
  }
  return found < 0 ? 0 : -1;
}

}  // namespace karst::core
