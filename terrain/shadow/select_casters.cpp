// SPDX-License-Identifier: MIT
#include "terrain/shadow/select_casters.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/draw/index_batches.h"

namespace karst::core {
namespace {

// The level that a patch's place and the map ask for.
class WantedLevel {
 public:
  explicit WantedLevel(const SelectCasters& stage)
      : stage_(stage),
        eye_(make_lod_eye(stage.cascade->eye, stage.cascade->least_cos2)),
        most_error_(stage.error_texels * stage.cascade->texel * kStepsPerVoxel) {}

  int operator()(PatchId patch) const {
    const int most = at_place(patch);
    int level = std::min(stage_.base_level, most);
    while (level < most && stage_.errors.error(patch, level) > most_error_) ++level;
    return level;
  }

 private:
  int at_place(PatchId patch) const {
    const LodSettings& settings = stage_.settings;
    const int top = settings.top_level();
    if (settings.mode == LodMode::full) return top;
    if (settings.mode == LodMode::error) {
      const PatchLod& lod = stage_.lods[patch];
      return std::min(level_at(lod, least_apparent_distance(lod, eye_)), top);
    }
    // K's formula (select_lod.h).
    const LatticeBox box = patch_box(stage_.surface, stage_.bounds, patch);
    const glm::vec3 away =
        glm::max(glm::max(glm::vec3(box.min) - eye_.eye, eye_.eye - glm::vec3(box.max)), glm::vec3(0.0f));
    const float squared = away.x * away.x + away.y * away.y + away.z * away.z;
    int level = 1;
    for (int m = 2; m <= top; ++m) {
      const auto distance = static_cast<float>(std::ldexp(settings.distance_voxels * kStepsPerVoxel, 2 - m));
      level += squared < distance * distance ? 1 : 0;
    }
    return level;
  }

  const SelectCasters& stage_;
  LodEye eye_;
  double most_error_;  // lattice steps
};

// Lists the patches in the box into stage.lacking, in their order.
class Collector {
 public:
  explicit Collector(const SelectCasters& stage) : stage_(stage) {}

  std::uint32_t run() {
    descend(stage_.tree->rows() - 1, 0, kAllPlanes);
    return count_;
  }

 private:
  void descend(int row, std::uint32_t n, PlaneMask mask) {
    const BoundsTree& tree = *stage_.tree;
    mask = classify(stage_.cascade->frustum, tree.node(row, n), mask);
    if (mask == kOutside) return;
    if (mask != 0 && row > 0) {
      const std::uint32_t end = std::min((n + 1) * BoundsTree::kFanOut, tree.nodes(row - 1));
      for (std::uint32_t child = n * BoundsTree::kFanOut; child < end; ++child) descend(row - 1, child, mask);
      return;
    }
    const PatchId first = tree.first_patch(row, n);
    const PatchId last = first + tree.patch_count(row, n);
    for (PatchId id = first; id < last; ++id) {
      if (stage_.surface.is_free(id)) continue;
      if (mask != 0 &&
          classify(stage_.cascade->frustum, patch_box(stage_.surface, stage_.bounds, id), mask) == kOutside) {
        continue;
      }
      stage_.lacking[count_++] = id;
    }
  }

  const SelectCasters& stage_;
  std::uint32_t count_ = 0;
};

// Raises neighbours in the box to one level less, finest first: what is raised raises its own neighbours
// later.
void raise_coarser(const SelectCasters& stage, std::span<const std::uint32_t> patches, int finest) {
  for (int level = finest; level > 2; --level) {
    for (const PatchId id : patches) {
      if (stage.wanted[id] != level) continue;
      for (const PatchEdge edge : stage.surface.patches[id].neighbour) {
        if (!edge.exists()) continue;
        std::uint8_t& other = stage.wanted[edge.patch()];
        if (other != 0 && other < level - 1) other = static_cast<std::uint8_t>(level - 1);
      }
    }
  }
}

// The same for what is held, by lowering the finer ones, coarsest first.
void lower_finer(const SelectCasters& stage, std::span<const std::uint32_t> patches) {
  for (int level = 1; level < stage.settings.top_level() - 1; ++level) {
    for (const PatchId id : patches) {
      if (stage.levels[id] != level) continue;
      for (const PatchEdge edge : stage.surface.patches[id].neighbour) {
        if (!edge.exists()) continue;
        std::uint8_t& other = stage.levels[edge.patch()];
        if (other > level + 1) other = static_cast<std::uint8_t>(level + 1);
      }
    }
  }
}

}  // namespace

Status SelectCasters::validate() const {
  const auto refuse = [](const char* what, const char* field) {
    return Status{StatusCode::invalid_argument, what, field};
  };
  const std::size_t patches = surface.patches.size();
  if (cascade == nullptr) return refuse("missing", "cascade");
  if (!(error_texels > 0)) return refuse("not above 0 texels", "error_texels");
  if (base_level < 1 || base_level > kMaxLevel) return refuse("not a level of detail", "base_level");
  if (bounds.size() != patches) return refuse("must hold one box a patch", "bounds");
  if (tree == nullptr) return refuse("missing", "tree");
  if (tree->patches() != patches) return refuse("not built over the surface", "tree");
  if (settings.mode == LodMode::error && lods.size() != patches) {
    return refuse("must hold one entry a patch", "lods");
  }
  if (!errors.known(patches)) return refuse("must hold the values of every patch", "errors");
  if (resident.size() != patches) return refuse("must hold one byte a patch", "resident");
  if (wanted.size() != patches) return refuse("must hold one byte a patch", "wanted");
  if (levels.size() != patches) return refuse("must hold one byte a patch", "levels");
  if (lacking.size() < patches) return refuse("must hold one value a patch", "lacking");
  return {};
}

Status SelectCasters::run(Result& result) const {
  KARST_ASSERT(validate().ok());
  result = {};
  if (levels.empty()) return {};
  std::memset(wanted.data(), 0, wanted.size());
  std::memset(levels.data(), 0, levels.size());
  const std::span<std::uint32_t> patches = lacking.first(Collector(*this).run());
  const WantedLevel wanted_level(*this);
  int finest = 1;
  for (const PatchId id : patches) {
    const int level = wanted_level(id);
    wanted[id] = static_cast<std::uint8_t>(level);
    finest = std::max(finest, level);
  }
  raise_coarser(*this, patches, finest);
  bool cut = false;
  for (const PatchId id : patches) {
    levels[id] = std::min(wanted[id], resident[id]);
    cut = cut || levels[id] < wanted[id];
  }
  if (cut) lower_finer(*this, patches);

  std::uint32_t found = 0;
  for (const PatchId id : patches) {
    if (levels[id] == 0) continue;
    if (found++ >= items.size()) continue;
    const DrawItem item = make_draw_item(surface, levels, id);
    items[result.drawn++] = item;
    result.triangles += patch_index_count(item.level, item.lower_edges, item.skipped_edges) / 3;
  }
  const auto holes =
      std::partition(patches.begin(), patches.end(), [&](PatchId id) { return resident[id] == 0; });
  const auto held =
      std::partition(holes, patches.end(), [&](PatchId id) { return resident[id] < wanted[id]; });
  result.lacking = static_cast<std::uint32_t>(held - patches.begin());
  if (found > items.size())
    return {StatusCode::limit_reached, "more patches cast than draw items", "max_draw_items", found};
  return {};
}

}  // namespace karst::core
