// SPDX-License-Identifier: MIT
// What casts into a cascade's shadow map (terrain/view/cascades.h). A patch casts no finer than the map can
// show: at the coarsest level that is off by a texel at most, if its place does not ask for a coarser one.
// Patches out of view are made resident at that level, too: as long as the pool has room, maps depend neither
// on where the camera looks nor on what it saw before, and cost fewer triangles than the picture.
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

int Terrain::caster_level(const Cascade& cascade, const LodEye& eye, PatchId patch) const {
  int wanted = lod_settings_.top_level();
  if (lod_settings_.mode == LodMode::error) {
    const PatchLod& lod = lods_[patch];
    wanted = level_at(lod, least_apparent_distance(lod, eye));
  }
  const LevelErrors errors = level_errors();
  const double texel = cascade.texel * kStepsPerVoxel;
  int level = base_level();
  while (level < wanted && errors.error(patch, level) > texel) ++level;
  return level;
}

Status Terrain::select_casters(const Cascade& cascade, Casters& casters) {
  casters = {};
  caster_pass_ = 0;
  next_caster_ = 0;
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
  const LodEye eye = make_lod_eye(cascade.eye, 1.0f);
  std::uint32_t lacking = 0;
  for (PatchId p = 0; p < info_.patches; ++p) {
    const int level = caster_level(cascade, eye, p);
    int held = pool_.level(p);
    if (held < level) {
      // Out of the box nothing is drawn, and must not lower what is: it counts as held.
      if (classify(cascade.frustum, patch_box(surface(), bounds(), p), kAllPlanes) == kOutside) {
        held = level;
      } else {
        ++lacking;
      }
    }
    caster_held_[p] = static_cast<std::uint8_t>(std::min(level, held));
  }
  lod.resident = caster_held_.first(info_.patches);
  lod.levels = caster_levels_.first(info_.patches);
  if (const Status status = lod.validate(); !status.ok()) return status;
  lod.run();
  casters.lacking = lacking;

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
  const LodEye eye = make_lod_eye(cascade.eye, 1.0f);
  // What is not there at all comes first.
  for (; caster_pass_ < 2; ++caster_pass_, next_caster_ = 0) {
    const bool holes = caster_pass_ == 0;
    while (next_caster_ < info_.patches) {
      const PatchId patch = next_caster_++;
      const int level = holes ? base_level() : caster_level(cascade, eye, patch);
      if (pool_.level(patch) >= level || (holes && pool_.level(patch) > 0)) continue;
      if (classify(cascade.frustum, patch_box(surface(), bounds(), patch), kAllPlanes) == kOutside) continue;
      if (!pool_.make_room(patch, level)) return false;
      return make_resident(patch, level, upload, status);
    }
  }
  return false;
}

}  // namespace karst
