// SPDX-License-Identifier: MIT
// The parts of a world that edits make: regions in the memory that is set aside for them.
#include <algorithm>
#include <array>
#include <cmath>
#include <new>

#include <glm/common.hpp>

#include "terrain/base/check.h"
#include "terrain/surface/bezier/extract_surface.h"
#include "terrain/world/world.h"

namespace karst::core {
namespace {

// Room for as many columns as patches, and twice as tall as wide, up to here.
constexpr int kSpareTall = 128;

SkyBox spare_box(const Config& config) {
  const int side =
      std::max(static_cast<int>(std::ceil(std::sqrt(static_cast<double>(config.region_patches)))), 2);
  return {glm::ivec3(0), {side, std::min(2 * side, kSpareTall), side}};
}

}  // namespace

bool World::has_spares(const GroundInfo& ground, const Config& config) {
  return ground.can_be_dug && config.spare_regions > 0 && config.edit_patches > 0;
}

std::size_t World::slot_parts_of(const WorldInfo& info, const GroundInfo& ground, const Config& config) {
  if (!has_spares(ground, config)) return info.regions;
  return std::min<std::size_t>(ground.regions().size() + config.spare_regions, kMostRegions);
}

// Of all octrees, or what there is room for. Where regions lie apart from the world's corner there are two
// at least, so that each is looked up by its own.
std::size_t World::sky_boxes(const WorldInfo& info, const GroundInfo& ground, const Config& config,
                             std::span<SkyBox, kMostRegions> boxes) {
  if (ground.region_count < 2 && !ground.can_be_dug) {
    boxes[0] = {glm::ivec3(0), glm::max(info.extent, glm::ivec3(1))};
    return 1;
  }
  std::size_t count = 0;
  for (const GroundRegion& region : ground.regions()) boxes[count++] = {region.corner, region.extent};
  while (count < slot_parts_of(info, ground, config))
    boxes[count++] = has_spares(ground, config) ? spare_box(config) : SkyBox{glm::ivec3(0), info.extent};
  while (count < 2) boxes[count++] = SkyBox();
  return count;
}

std::uint32_t World::spare_rim_edges(const Config& config) {
  return 16 * static_cast<std::uint32_t>(std::sqrt(static_cast<double>(config.region_patches)));
}

SkyAtlas World::sky_atlas_for(const WorldInfo& info, const GroundInfo& ground, const Config& config) {
  std::array<SkyBox, kMostRegions> boxes;
  const std::size_t count = sky_boxes(info, ground, config, boxes);
  SkyAtlas atlas = SkyAtlas::of(std::span(boxes).first(count), config.sky_words);
  // Nothing is looked up in those that are not there.
  const std::size_t there = ground.can_be_dug ? ground.regions().size() : count;
  for (std::size_t n = there; n < count; ++n) atlas.places[n].box.extent = glm::ivec3(0);
  return atlas;
}

World::Counts World::spare_counts(const Config& config) {
  return {4 * config.region_patches + kEditPathOctets, config.region_patches, config.region_patches};
}

void World::add_dig_room(const WorldInfo& info, const GroundInfo& ground, std::uint32_t regions,
                         std::uint32_t patches, Config& config) {
  const auto there = static_cast<std::uint32_t>(ground.region_count);
  const std::uint32_t spares = std::min(regions, kMostRegions - there);
  if (!ground.can_be_dug || spares == 0) return;
  config.spare_regions = spares;
  config.region_patches = patches;
  config.max_regions = there + spares;
  config.max_depth = kMaxDepth;
  const Counts own = spare_counts(config);
  const auto add = [&](std::uint32_t& limit, std::uint64_t more, std::uint32_t most) {
    limit = static_cast<std::uint32_t>(std::min<std::uint64_t>(limit + spares * more, most));
  };
  add(config.max_octets, own.octets, kFullTreeOctets);
  add(config.max_volumes, own.volumes, kMostPatches);
  add(config.max_patches, own.patches, kMostPatches);
  add(config.rim_edges, spare_rim_edges(config), kMostRimEdges);
  add(config.max_draw_items, patches, kMostPages);
  config.max_resident_patches = config.max_draw_items;
  add(config.gpu_vertex_pages, 2 * std::uint64_t{patches}, kMostPages);
  std::size_t occluder_words = 0;
  std::array<SkyBox, kMostRegions> boxes;
  Config edited = config;
  edited.edit_patches = 1;
  const auto octrees = std::span(boxes).first(sky_boxes(info, ground, edited, boxes));
  for (const SkyBox& box : octrees)
    occluder_words += Occluders::word_count(box.extent, Occluders::kLeastCellLog2);
  config.occluder_words = static_cast<std::uint32_t>(std::min(occluder_words, kMostOccluderWords));
  config.sky_words = static_cast<std::uint32_t>(SkyAtlas::word_count(octrees));
}

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

void World::stage_region(const GroundRegion& region) {
  KARST_ASSERT(!state_.staged.exists);
  const Spare made = spare();
  const std::size_t n = made.region;
  state_.staged.region = region;
  state_.staged.exists = true;
  WorldPart& part = state_.staged.part = parts_[n];
  part.octree = &octrees_[n];
  part.tree = &trees_[n];
  part.occluders = &occluders_[n];
  part.sky = &skies_[n];
  part.rim = &rims_[n];
  part.surface = {made.volumes, made.patches};
  part.corner = region.corner;
  part.extent = region.extent;
  part.boxes =
      blocks_.patch_boxes.subspan(static_cast<std::size_t>(part.boxes.data() - blocks_.patch_boxes.data()),
                                  PatchBoxes::count_for(part.patches()));
  set_spans(part);
}

void World::build_staged() {
  const WorldPart& part = state_.staged.part;
  const std::size_t n = ground_.regions().size();
  const Editable all = edit(n);
  const Status built = trees_[n].build(part.surface, part.bounds);
  KARST_ASSERT(built.ok());
  static_cast<void>(built);
  fill_patch_boxes(part.surface, part.bounds, 0, part.patches(), all.boxes);
  occluders_[n].build(octrees_[n], part.extent, part.surface, part.bounds);
  SkyAtlas::Place place = sky_atlas_.places[n];
  place.take({part.corner, part.extent});
  skies_[n].set_least_cell(place.grid.cell_log2);
  skies_[n].build(octrees_[n], part.extent, true);
}

void World::open_region() {
  KARST_ASSERT(state_.staged.exists);
  const std::size_t n = ground_.regions().size();
  parts_[n] = state_.staged.part;
  state_.staged.exists = false;
  const GroundRegion& region = ground_.region_list[n] = state_.staged.region;
  ++ground_.region_count;
  const bool placed = place_regions(ground_);
  KARST_ASSERT(placed);
  static_cast<void>(placed);
  part_count_ = ground_.regions().size();
  // Whoever loads a file of it has belts of its rims.
  for (std::size_t k = 0; k < part_count_; ++k) find_belt(k);
  sky_atlas_.places[n].take({region.corner, region.extent});
  info_.extent = glm::max(info_.extent, region.extent);
  info_.depth = std::max(info_.depth, region.depth);
}

void World::unstage_region() {
  KARST_ASSERT(state_.staged.exists);
  state_.staged.exists = false;
}

}  // namespace karst::core
