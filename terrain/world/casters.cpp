// SPDX-License-Identifier: MIT
// Casters of shadows: what a cascade wants (terrain/shadow/select_casters.h) is made resident wherever the
// picture looks. As long as the pool has room, maps depend neither on that nor on what was seen before.
#include <cstring>

#include "terrain/shadow/select_casters.h"
#include "terrain/world/terrain.h"

namespace karst::core {
namespace {

// FNV-1a over words of eight bytes.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  return (hash ^ word) * 0x100000001b3u;
}

}  // namespace

Status Terrain::select_casters(const Cascade& cascade, double error_texels, Casters& casters) {
  casters = {};
  next_caster_ = lacking_casters_ = 0;
  SelectCasters select;
  select.settings = lod_settings_;
  select.error_texels = error_texels;
  select.base_level = base_level();
  select.cascade = &cascade;
  select.surface = surface();
  select.bounds = bounds();
  select.tree = &tree_;
  select.lods = lods();
  select.errors = level_errors();
  select.resident = pool_.levels();
  select.wanted = caster_wanted_.first(info_.patches);
  select.levels = caster_levels_.first(info_.patches);
  select.lacking = list_scratch_.first(info_.patches);
  select.items = caster_items_;
  if (const Status status = select.validate(); !status.ok()) return status;
  SelectCasters::Result result;
  const Status status = select.run(result);
  casters.items = caster_items_.first(result.drawn);
  casters.triangles = result.triangles;
  casters.lacking = lacking_casters_ = result.lacking;
  casters.hash = mix(0xcbf29ce484222325u, thresholds_version_);
  for (const DrawItem& item : casters.items) {
    std::uint64_t word = 0;
    std::memcpy(&word, &item, sizeof item);
    casters.hash = mix(casters.hash, word);
    // The GPU reads its pages in this frame: they must not be given to others while it does.
    const ResidentPool::Row& row = pool_.row_at(pool_.row(item.patch));
    if (row.last_seen != pool_.frame() || row.needed < item.level) pool_.see(item.patch, item.level);
  }
  return status;
}

bool Terrain::generate_base(PatchUpload& upload, Status& status) {
  status = {};
  if (!pool_.keeps_base() || pool_.resident() == info_.patches) return false;
  for (std::uint32_t looked = 0; looked < info_.patches; ++looked) {
    if (next_base_ >= info_.patches) next_base_ = 0;
    const PatchId patch = next_base_++;
    if (pool_.level(patch) == 0) return make_resident(patch, base_level(), upload, status);
  }
  return false;
}

bool Terrain::generate_next_caster(PatchUpload& upload, Status& status) {
  status = {};
  for (; next_caster_ < lacking_casters_; ++next_caster_) {
    const PatchId patch = list_scratch_[next_caster_];
    const int level = caster_wanted_[patch];
    if (pool_.level(patch) >= level) continue;
    if (!pool_.make_room(patch, level, true)) return false;
    const bool made = make_resident(patch, level, upload, status);
    // The next ones must not take it back.
    if (made) pool_.see(patch, level);
    return made;
  }
  return false;
}

}  // namespace karst::core
