// SPDX-License-Identifier: MIT
#include "terrain/measure/measure_patches.h"

#include <algorithm>

#include "terrain/measure/level_triangles.h"
#include "terrain/measure/shading_cone.h"
#include "terrain/patch/corner_fan.h"

namespace karst::core {
namespace {

Status refuse(const char* what, const char* field) {
  return {StatusCode::invalid_argument, what, field};
}

// Sorts entries and takes out those that are there twice; returns how many are left.
std::size_t compact(std::span<PatchId> entries) {
  std::sort(entries.begin(), entries.end());
  return static_cast<std::size_t>(std::unique(entries.begin(), entries.end()) - entries.begin());
}

}  // namespace

Status MeasurePatches::validate() const {
  const std::size_t patches = surface.patches.size();
  if (heights.level < 1 || heights.level > kMaxLevel) return refuse("not a level of detail", "heights");
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (list[i] >= patches || is_free(list[i]) || (i > 0 && list[i] <= list[i - 1]))
      return refuse("must hold patches of the surface, ascending", "list");
  }
  if (borders.size() != count()) return refuse("must hold one entry a patch that is measured", "borders");
  if (out.level_errors.size() != patches * level_error_values(heights.level))
    return refuse("must hold two values a patch and level above the first", "level_errors");
  if (out.bounds.size() != patches) return refuse("must hold one box a patch", "bounds");
  if (out.cones.size() != patches) return refuse("must hold one cone a patch", "cones");
  if (out.shading_cones.size() != patches) return refuse("must hold one cone a patch", "shading_cones");
  return {};
}

std::span<std::uint16_t> MeasurePatches::errors_of(PatchId patch) const {
  const std::size_t row = level_error_values(heights.level);
  return out.level_errors.subspan(patch * row, row);
}

// Null where the patch is not in the list.
const BorderErrors* MeasurePatches::borders_of(PatchId patch) const {
  if (list.empty()) return &borders[patch];
  const auto found = std::lower_bound(list.begin(), list.end(), patch);
  if (found == list.end() || *found != patch) return nullptr;
  return &borders[static_cast<std::size_t>(found - list.begin())];
}

void MeasurePatches::measure(std::size_t first, std::size_t last, const Room& room) const {
  GenerateVertices generate;
  generate.surface = surface;
  generate.heights = heights;
  generate.level = heights.level;
  generate.scratch = room.scratch;
  for (std::size_t i = first; i < last; ++i) {
    const PatchId patch = patch_at(i);
    if (is_free(patch)) continue;
    const LevelGrid grid(surface, heights, patch);
    measure_own_errors(grid, borders[i], errors_of(patch));
    generate.run(patch, room.vertices, &out.bounds[patch]);
    out.cones[patch] = measure_normal_cone(grid);
    out.shading_cones[patch] = measure_shading_cone(room.vertices);
  }
}

void MeasurePatches::join(std::size_t first, std::size_t last) const {
  for (std::size_t i = first; i < last; ++i) {
    const PatchId patch = patch_at(i);
    if (is_free(patch)) continue;
    BorderErrors made[4];  // of neighbours beyond the list
    const BorderErrors* theirs[4] = {};
    for (int e = 0; e < 4; ++e) {
      const PatchEdge other = surface.patches[patch].neighbour[e];
      if (!other.exists()) continue;
      theirs[e] = borders_of(other.patch());
      if (theirs[e] != nullptr) continue;
      std::uint16_t unused[level_error_values(kMaxLevel)];
      measure_own_errors(surface, heights, other.patch(), made[e], unused);
      theirs[e] = &made[e];
    }
    join_errors(surface, heights.level, patch, borders[i], theirs, errors_of(patch));
  }
}

Status find_touched(const Surface& surface, std::span<const PatchId> changed, std::span<PatchId> room,
                    std::span<const PatchId>& touched) {
  touched = {};
  std::size_t count = 0;
  Status status;
  const auto add = [&](PatchId patch) {
    if (count == room.size()) count = compact(room);
    if (count == room.size()) {
      status = {StatusCode::limit_reached, "more patches are touched than the list has room for", "room"};
      return;
    }
    room[count++] = patch;
  };
  for (const PatchId patch : changed) {
    add(patch);
    for (int corner = 0; corner < 4; ++corner) {
      PatchCorner fan[kMaxCornerFan];
      const int around = corner_fan(surface.patches, {patch, corner}, fan);
      for (int i = 1; i < around; ++i) add(fan[i].patch);
    }
    if (!status.ok()) return status;
  }
  touched = room.first(compact(room.first(count)));
  return {};
}

}  // namespace karst::core
