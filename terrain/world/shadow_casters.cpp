// SPDX-License-Identifier: MIT
#include "terrain/world/shadow_casters.h"

#include <cstring>

#include "terrain/shadow/select_casters.h"

namespace karst::core {
namespace {

// FNV-1a over words of eight bytes.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  return (hash ^ word) * 0x100000001b3u;
}

}  // namespace

Status ShadowCasters::create(const Config& config, Arena& arena) {
  next_ = lacking_ = 0;
  return take_blocks(config, arena, blocks_);
}

Status ShadowCasters::select(const World& world, Residency& residency, const ViewState& view,
                             const Cascade& cascade, double error_texels, Result& result) {
  result = {};
  next_ = lacking_ = 0;
  if (view.threshold_set() < 0) return {StatusCode::invalid_argument, "was not selected yet", "view"};
  const std::uint32_t patches = world.patch_count();
  SelectCasters select;
  select.settings = view.settings();
  select.error_texels = error_texels;
  select.base_level = world.base_level();
  select.cascade = &cascade;
  select.surface = world.surface();
  select.bounds = world.bounds();
  select.tree = &world.tree();
  select.lods = residency.thresholds().lods(view.threshold_set());
  select.errors = world.level_errors();
  select.resident = residency.pool().levels();
  select.wanted = blocks_.wanted.first(patches);
  select.levels = blocks_.levels.first(patches);
  select.lacking = blocks_.lacking.first(patches);
  select.items = blocks_.items;
  if (const Status status = select.validate(); !status.ok()) return status;
  SelectCasters::Result selected;
  const Status status = select.run(selected);
  result.items = blocks_.items.first(selected.drawn);
  result.triangles = selected.triangles;
  result.lacking = lacking_ = selected.lacking;
  result.levels = select.levels;
  // Those that are not held come first.
  result.holes = lacking_ > 0 && residency.pool().level(blocks_.lacking[0]) == 0;
  result.hash = mix(0xcbf29ce484222325u, residency.thresholds().version(view.threshold_set()));
  for (const DrawItem& item : result.items) {
    std::uint64_t word = 0;
    std::memcpy(&word, &item, sizeof item);
    result.hash = mix(result.hash, word);
    // The GPU reads its pages in this frame: they must not be given to others while it does.
    residency.pool().see(item.patch, item.level);
  }
  return status;
}

bool ShadowCasters::generate_next(Residency& residency, PatchUpload& upload, Status& status) {
  status = {};
  ResidentPool& pool = residency.pool();
  for (; next_ < lacking_; ++next_) {
    const PatchId patch = blocks_.lacking[next_];
    const int level = blocks_.wanted[patch];
    if (pool.level(patch) >= level) continue;
    if (!pool.make_room(patch, level, true)) return false;
    const bool made = residency.make_resident(patch, level, upload, status);
    // The next ones must not take it back.
    if (made) pool.see(patch, level);
    return made;
  }
  return false;
}

}  // namespace karst::core
