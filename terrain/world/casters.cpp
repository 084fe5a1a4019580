// SPDX-License-Identifier: MIT
// What casts into a cascade's shadow map (terrain/view/cascades.h). A patch casts no finer than the map can
// show: at the coarsest level that is off by a texel at most, if its place does not ask for a coarser one.
// That is mostly a level that every resident patch has, so what streams in and out while the camera turns
// leaves maps as they are; and a map costs fewer triangles than the picture.
#include <algorithm>
#include <cstring>

#include "terrain/world/terrain.h"

namespace karst {
namespace {

// FNV-1a over words of eight bytes.
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  return (hash ^ word) * 0x100000001b3u;
}

}  // namespace

Status Terrain::select_casters(const Cascade& cascade, Casters& casters) {
  casters = {};
  SelectLod lod;
  lod.settings = lod_settings_;
  lod.camera = &cascade.eye;
  lod.surface = surface();
  lod.bounds = bounds();
  lod.tree = &tree_;
  lod.frustum = &cascade.frustum;
  lod.scale = scale_;
  lod.scale.least_cos2 = 1.0f;
  lod.lods = lods();
  lod.errors = level_errors();
  const double texel = cascade.texel * kStepsPerVoxel;
  const LevelErrors all_errors = level_errors();
  for (PatchId p = 0; p < info_.patches; ++p) {
    int level = base_level();
    while (level < info_.level && all_errors.error(p, level) > texel) ++level;
    caster_held_[p] = static_cast<std::uint8_t>(std::min(level, pool_.level(p)));
  }
  lod.resident = caster_held_.first(info_.patches);
  lod.levels = caster_levels_.first(info_.patches);
  if (const Status status = lod.validate(); !status.ok()) return status;
  casters.missing = lod.run().missing;

  BuildDrawList list;
  list.frustum = &cascade.frustum;
  list.eye = glm::vec3(eye_lattice(cascade.eye));
  list.surface = surface();
  list.bounds = bounds();
  list.tree = &tree_;
  list.levels = caster_levels_.first(info_.patches);
  list.scratch = list_scratch_.first(info_.patches);
  list.items = caster_items_;
  if (const Status status = list.validate(); !status.ok()) return status;
  BuildDrawList::Result result;
  const Status status = list.run(result);
  casters.items = caster_items_.first(result.drawn);
  casters.hash = mix(0xcbf29ce484222325u, thresholds_version_);
  for (const DrawItem& item : casters.items) {
    std::uint64_t word = 0;
    std::memcpy(&word, &item, sizeof item);
    casters.hash = mix(casters.hash, word);
    // The GPU reads its pages in this frame: they must not be given to others while it does.
    if (pool_.row_at(pool_.row(item.patch)).last_seen != pool_.frame()) pool_.see(item.patch, item.level);
  }
  return status;
}

bool Terrain::generate_next_caster(const Cascade& cascade, PatchUpload& upload, Status& status) {
  status = {};
  for (std::uint32_t n = 0; n < info_.patches; ++n) {
    if (next_caster_ >= info_.patches) next_caster_ = 0;
    const PatchId patch = next_caster_++;
    if (pool_.level(patch) > 0 ||
        classify(cascade.frustum, patch_box(surface(), bounds(), patch), kAllPlanes) == kOutside) {
      continue;
    }
    if (!pool_.make_room(patch, base_level())) return false;
    return make_resident(patch, base_level(), upload, status);
  }
  return false;
}

}  // namespace karst
