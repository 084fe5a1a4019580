// SPDX-License-Identifier: MIT
// Two passes over what is in view and one over the items: culling writes a key and a patch a visible patch, a
// counting sort puts them in order. A key is eight bits of distance, so that it shares 32 bits with a patch.
#include "terrain/draw/draw_list.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <glm/geometric.hpp>

#include "terrain/base/check.h"
#include "terrain/draw/index_batches.h"
#include "terrain/lod/morph.h"

namespace karst::core {
namespace {

constexpr std::uint32_t kKeyShift = 24;
constexpr std::uint32_t kPatchMask = (1u << kKeyShift) - 1;
static_assert(BoundsTree::kMaxPatches - 1 <= kPatchMask);

constexpr std::uint32_t kBands = 256;
using BandCounts = std::array<std::uint32_t, kBands>;

// Exponent and first three bits of the mantissa of the squared distance: eight bands an octave of it, sixteen
// an octave of the distance. The first band ends at 2^14 squared steps, 1/64 voxel; the last one begins near
// 2^46, 990 voxels.
std::uint32_t band(float squared_distance) {
  constexpr std::uint32_t kMantissaShift = 23 - 3;
  constexpr std::uint32_t kFirst = (127 + 14) << 3;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(squared_distance) >> kMantissaShift;
  return bits <= kFirst ? 0 : std::min(bits - kFirst, kBands - 1);
}

// Which patches are listed: all, those that face the eye, or, in a parallel view, its direction.
enum class Facing : std::uint8_t { any, eye, along };

struct Collector {
  const BuildDrawList& stage;
  Occlusion* occlusion;  // null: hides nothing
  BandCounts counts{};
  std::uint32_t visible = 0;
  std::uint32_t missing = 0;
  std::uint32_t back_facing = 0;
  std::uint32_t occluded = 0;

  // Patches of a run that are inside the planes that mask leaves out.
  template <Facing kFacing, bool kOcclusion>
  void add_run(PatchId first, PatchId last, PlaneMask mask) {
    // Copies, which the stores below cannot change.
    const Surface surface = stage.surface;
    const PatchBounds* const bounds = stage.bounds.data();
    const NormalCone* const cones = stage.cones.data();
    const std::uint8_t* const levels = stage.levels.data();
    const glm::vec3 eye(eye_lattice(*stage.camera));
    const glm::vec3 forward(stage.camera->forward);
    const float slack = back_facing_slack(eye);
    const float pixels = stage.least_pixels;
    std::uint32_t* out = stage.scratch.data() + visible;
    for (PatchId id = first; id < last; ++id) {
      const glm::ivec3 origin = patch_origin(surface.volume_of(id));
      const PatchBounds& b = bounds[id];
      const glm::ivec3 low(b.min[0], b.min[1], b.min[2]);
      const glm::ivec3 high(b.max[0], b.max[1], b.max[2]);
      const LatticeBox box{origin + low, origin + high};
      if (mask != 0 && classify(*stage.frustum, box, mask) == kOutside) continue;
      if (levels[id] == 0) {
        ++missing;
        continue;
      }
      const glm::vec3 d = glm::vec3(origin) - eye;
      if constexpr (kFacing != Facing::any) {
        // Most patches face the eye: their axes lead to it, and nothing more needs to be known.
        const NormalCone& cone = cones[id];
        constexpr bool parallel = kFacing == Facing::along;
        const glm::vec3 sight = parallel ? forward : d;
        const float along = static_cast<float>(cone.axis[0]) * sight.x +
                            static_cast<float>(cone.axis[1]) * sight.y +
                            static_cast<float>(cone.axis[2]) * sight.z;
        if (along > 0.0f && cone.sine != NormalCone::kNone) {
          const glm::vec3 centre = d + 0.5f * glm::vec3(low + high);
          const float distance = parallel ? kParallelDistance : glm::length(centre);
          const float snap = snap_sine(distance, levels[id], pixels);
          if (parallel ? is_back_facing(cone, forward, snap)
                       : is_back_facing(cone, centre, 0.5f * glm::vec3(high - low), slack, snap)) {
            ++back_facing;
            continue;
          }
        }
      }
      if constexpr (kOcclusion) {
        if (occlusion->hides_patch(id, box)) {
          ++occluded;
          continue;
        }
      }
      const std::uint32_t key = band(d.x * d.x + d.y * d.y + d.z * d.z);
      ++counts[key];
      *out++ = key << kKeyShift | id;
    }
    visible = static_cast<std::uint32_t>(out - stage.scratch.data());
  }

  template <Facing kFacing>
  void add_facing(PatchId first, PatchId last, PlaneMask mask) {
    occlusion != nullptr ? add_run<kFacing, true>(first, last, mask)
                         : add_run<kFacing, false>(first, last, mask);
  }

  void add(PatchId first, PatchId last, PlaneMask mask) {
    if (stage.cones.empty()) {
      add_facing<Facing::any>(first, last, mask);
    } else if (stage.camera->parallel) {
      add_facing<Facing::along>(first, last, mask);
    } else {
      add_facing<Facing::eye>(first, last, mask);
    }
  }

  void descend(int row, std::uint32_t n, PlaneMask mask) {
    const BoundsTree& tree = *stage.tree;
    mask = classify(*stage.frustum, tree.node(row, n), mask);
    if (mask == kOutside) return;
    const PatchId first = tree.first_patch(row, n);
    const PatchId last = first + tree.patch_count(row, n);
    if (occlusion != nullptr && row < Occlusion::kRows && occlusion->hides_node(tree, row, n)) {
      occluded += last - first;
      return;
    }
    if (row == 0 || (mask == 0 && occlusion == nullptr)) {
      add(first, last, mask);
    } else {
      const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, tree.nodes(row - 1));
      for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child) descend(row - 1, child, mask);
    }
  }
};

}  // namespace

DrawItem make_draw_item(const Surface& surface, std::span<const std::uint8_t> levels, PatchId id) {
  const Patch& patch = surface.patches[id];
  const std::uint8_t level = levels[id];
  unsigned lower = 0;
  for (unsigned e = 0; e < 4; ++e) {
    const PatchEdge other = patch.neighbour[e];
    // Two levels apart they cannot both be in view (SelectLod::levels).
    if (level > 1 && other.exists() && levels[other.patch()] == level - 1) lower |= 1u << e;
  }
  const unsigned skipped = patch.collapsed != 0 ? 1u << 3 : 0u;
  return {id, level, static_cast<std::uint8_t>(lower), static_cast<std::uint8_t>(skipped)};
}

Status BuildDrawList::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const std::size_t patches = surface.patches.size();
  if (patches > BoundsTree::kMaxPatches) return refuse("more than 2^24 patches", "surface");
  if (frustum_culling && frustum == nullptr) return refuse("missing", "frustum");
  if (camera == nullptr) return refuse("missing", "camera");
  if (bounds.size() != patches) return refuse("must hold one box a patch", "bounds");
  if (frustum_culling && tree == nullptr) return refuse("missing", "tree");
  if (frustum_culling && tree->patches() != patches) return refuse("not built over the surface", "tree");
  if (levels.size() != patches) return refuse("must hold one byte a patch", "levels");
  if (!cones.empty() && cones.size() != patches) return refuse("must hold one cone a patch", "cones");
  if (scratch.size() < patches) return refuse("must hold one value a patch", "scratch");
  return {};
}

Status BuildDrawList::run(Result& result) const {
  KARST_ASSERT(validate().ok());
  result = {};
  const auto patches = static_cast<std::uint32_t>(surface.patches.size());
  if (patches == 0) return {};
  Collector seen{*this, occlusion != nullptr && occlusion->active() ? occlusion : nullptr};
  if (frustum_culling) {
    seen.descend(tree->rows() - 1, 0, kAllPlanes);
  } else {
    seen.add(0, patches, 0);
  }

  BandCounts position;  // where the next item of a band goes
  std::uint32_t next = 0;
  for (std::uint32_t b = 0; b < kBands; ++b) {
    position[b] = next;
    next += seen.counts[b];
  }
  for (const std::uint32_t entry : scratch.first(seen.visible)) {
    const std::uint32_t at = position[entry >> kKeyShift]++;
    if (at >= items.size()) continue;
    const DrawItem item = make_draw_item(surface, levels, entry & kPatchMask);
    items[at] = item;
    result.at_level[item.level] += 1;
    result.triangles += patch_index_count(item.level, item.lower_edges, item.skipped_edges) / 3;
  }

  result.drawn = items.size() < seen.visible ? static_cast<std::uint32_t>(items.size()) : seen.visible;
  result.dropped = seen.visible - result.drawn;
  result.culled_frustum = patches - seen.visible - seen.missing - seen.back_facing - seen.occluded;
  result.culled_occluded = seen.occluded;
  result.culled_backface = seen.back_facing;
  result.missing = seen.missing;
  if (result.dropped > 0) {
    return {StatusCode::limit_reached, "more patches in view than draw items", "max_draw_items",
            seen.visible};
  }
  return {};
}

}  // namespace karst::core
