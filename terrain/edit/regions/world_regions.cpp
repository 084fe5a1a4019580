// SPDX-License-Identifier: MIT
// The parts of a world that edits make: regions in the memory that is set aside for them.
#include <algorithm>
#include <new>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/surface/bezier/extract_surface.h"
#include "terrain/world/world.h"

namespace karst::core {

World::Spare World::spare() {
  KARST_ASSERT(spare_regions() > 0);
  const std::size_t n = ground_.regions().size();
  const Counts slots = slot_counts(n);
  std::size_t first_volume = 0;
  for (std::size_t before = 0; before < n; ++before) first_volume += slot_counts(before).volumes;
  const PatchId first = parts_[n].first;
  Spare out;
  out.region = n;
  out.first = first;
  out.octree = &octrees_[n];
  out.slots = &slots_[n];
  out.rim = &rims_[n];
  out.queue = &queues_[n];
  out.heights = &cache_;
  out.volumes = blocks_.volumes.subspan(first_volume, slots.volumes);
  out.patches = blocks_.patches.subspan(first, slots.patches);
  const std::size_t values = level_error_values(info_.level);
  out.measures = {blocks_.level_errors.subspan(first * values, slots.patches * values),
                  blocks_.bounds.subspan(first, slots.patches), blocks_.cones.subspan(first, slots.patches),
                  blocks_.shading_cones.subspan(first, slots.patches)};
  out.scratch = {std::launder(reinterpret_cast<std::uint32_t*>(blocks_.scratch.data())),
                 ExtractSurface::scratch_size(config_.max_volumes)};
  out.room = &blocks_.edit;
  return out;
}

void World::open_region(const GroundRegion& region) {
  const Spare made = spare();
  const std::size_t n = made.region;
  WorldPart& part = parts_[n];
  part.surface = {made.volumes, made.patches};
  set_spans(n);
  const Status built = trees_[n].build(part.surface, part.bounds);
  KARST_ASSERT(built.ok());
  static_cast<void>(built);
  const auto boxes =
      blocks_.patch_boxes.subspan(static_cast<std::size_t>(part.boxes.data() - blocks_.patch_boxes.data()),
                                  PatchBoxes::count_for(part.patches()));
  part.boxes = boxes;
  fill_patch_boxes(part.surface, part.bounds, 0, part.patches(), boxes);
  ground_.region_list[n] = region;
  ++ground_.region_count;
  const bool placed = place_regions(ground_);
  KARST_ASSERT(placed);
  static_cast<void>(placed);
  part.corner = ground_.region_list[n].corner;
  part.extent = region.extent;
  part_count_ = ground_.regions().size();
  // Whoever loads a file of it has belts of its rims.
  for (std::size_t k = 0; k < part_count_; ++k) find_belt(k);
  occluders_[n].build(octrees_[n], part.extent, part.surface, part.bounds);
  SkyAtlas::Place& place = sky_atlas_.places[n];
  place.take({part.corner, part.extent});
  skies_[n].set_least_cell(place.grid.cell_log2);
  skies_[n].build(octrees_[n], part.extent, true);
  info_.extent = glm::max(info_.extent, part.extent);
  info_.depth = std::max(info_.depth, region.depth);
}

void World::close_region() {
  const std::size_t n = ground_.regions().size() - 1;
  WorldPart& part = parts_[n];
  part.surface = {};
  part.boxes = part.boxes.first(0);
  set_spans(n);
  part.corner = glm::ivec3(0);
  part.extent = reader_.info().extent;
  const Status built = trees_[n].build(part.surface, part.bounds);
  KARST_ASSERT(built.ok());
  static_cast<void>(built);
  --ground_.region_count;
  const bool placed = place_regions(ground_);
  KARST_ASSERT(placed);
  static_cast<void>(placed);
  part_count_ = std::max<std::size_t>(ground_.regions().size(), 1);
  for (std::size_t k = 0; k < ground_.regions().size(); ++k) find_belt(k);
  sky_atlas_.places[n] = sky_atlas_for(reader_.info(), reader_.ground(), config_).places[n];
  info_.extent = reader_.info().extent;
  info_.depth = reader_.info().depth;
  for (const GroundRegion& region : ground_.regions()) {
    info_.extent = glm::max(info_.extent, region.extent);
    info_.depth = std::max(info_.depth, region.depth);
  }
}

}  // namespace karst::core
