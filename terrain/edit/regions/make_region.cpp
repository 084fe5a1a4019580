// SPDX-License-Identifier: MIT
#include "terrain/edit/regions/make_region.h"

#include <algorithm>
#include <numeric>

#include "terrain/base/check.h"
#include "terrain/edit/regions/region_heights.h"
#include "terrain/field/voxelize.h"
#include "terrain/patch/fit_heights.h"
#include "terrain/surface/bezier/extract_surface.h"

namespace karst::core {
namespace {

// Of looking for the ground, which is nowhere thin.
constexpr double kStep = 0.5;  // voxels

Status too_large(std::uint64_t patches) {
  return {StatusCode::limit_reached, "the region that this would make is larger than there is room for",
          "region_patches", patches};
}

std::span<float> samples_room(const World::Spare& spare, const GroundRegion& region) {
  return spare.room->tops.subspan(static_cast<std::size_t>(region.extent.x) *
                                  static_cast<std::size_t>(region.extent.z));
}

double below_ground(const void* context, glm::dvec3 at) {
  return static_cast<const RegionHeights*>(context)->at(at.x, at.z) - at.y;
}

}  // namespace

void MakeRegion::empty(const World::Spare& spare) const {
  const Status reset = spare.octree->reset(world->reader().info().depth);
  KARST_ASSERT(reset.ok());
  static_cast<void>(reset);
  spare.slots->adopt(0, 0);
  std::ranges::fill(spare.volumes, Volume{});
  Patch free{};
  free.volume = kNoVolume;
  free.height_block = kNoHeights;
  std::ranges::fill(spare.patches, free);
  spare.queue->reset();
}

Status MakeRegion::fill(const World::Spare& spare, GroundRegion& region) const {
  const GroundInfo& info = world->ground();
  const std::span<float> room = spare.room->tops;
  const auto columns = static_cast<std::size_t>(region.extent.x) * static_cast<std::size_t>(region.extent.z);
  RegionHeights heights(info, region.nodes);
  if (columns + heights.floats() > room.size()) return too_large(columns);
  if (const Status status = heights.read(*ground, bottom, room.subspan(columns)); !status.ok()) return status;
  const std::span<float> tops = room.first(columns);
  std::size_t at = 0;
  for (int z = 0; z < region.extent.z; ++z) {
    for (int x = 0; x < region.extent.x; ++x) tops[at++] = static_cast<float>(heights.at(x + 0.5, z + 0.5));
  }
  region.depth = 1;
  while ((1 << region.depth) < std::max({region.extent.x, region.extent.z, region.extent.y + 1}))
    ++region.depth;
  if (const Status status = spare.octree->reset(region.depth); !status.ok()) return status;
  const VoxelizeHeights voxelize{region.extent, tops};
  if (!voxelize.run(*spare.octree).ok()) return too_large(columns);
  region.octets = spare.octree->octets_used();
  return {};
}

Status MakeRegion::extract(const World::Spare& spare, GroundRegion& region) const {
  ExtractSurface extract;
  extract.octree = spare.octree;
  extract.extent = region.extent;
  extract.mirrors = true;
  extract.volumes = spare.volumes;
  extract.patches = spare.patches;
  extract.scratch = spare.scratch;
  ExtractSurface::Result made;
  if (const Status status = extract.run(made); !status.ok()) {
    return status.code() == StatusCode::limit_reached
               ? too_large(std::max(made.patches, spare.slots->max_volumes()))
               : status;
  }
  region.volumes = made.volumes;
  region.patches = made.patches;
  std::ranges::fill(spare.volumes.subspan(made.volumes), Volume{});
  Patch free{};
  free.volume = kNoVolume;
  free.height_block = kNoHeights;
  std::ranges::fill(spare.patches.subspan(made.patches), free);
  spare.slots->adopt(made.volumes, made.patches);
  for (PatchId id = 0; id < made.patches; ++id) spare.patches[id].height_block = spare.first + id;
  const Surface surface{spare.volumes.first(made.volumes), spare.patches.first(made.patches)};
  region.rim_edges = RegionRim::count(surface);
  const Status joined = spare.rim->build(region, world->ground().lattice_size, surface);
  if (joined.ok()) return {};
  if (joined.code() == StatusCode::limit_reached) return too_large(region.patches);
  return {StatusCode::invalid_argument, "voxels there would not meet the ground around them", "place"};
}

void MakeRegion::fit(const World::Spare& spare, const GroundRegion& region) const {
  RegionHeights heights(world->ground(), region.nodes);
  const Status status = heights.read(*ground, bottom, samples_room(spare, region));
  KARST_ASSERT(status.ok());  // they were read before
  static_cast<void>(status);
  const int level = world->info().level;
  const std::span<std::int16_t> first = spare.heights->block(spare.first);
  FitHeights fit;
  fit.surface = {spare.volumes.first(region.volumes), spare.patches.first(region.patches)};
  fit.field = {below_ground, &heights};
  fit.level = level;
  fit.step_voxels = kStep;
  fit.heights = {first.data(), region.patches * first.size()};
  KARST_ASSERT(fit.validate().ok());
  FitHeights::Result result;
  fit.run(0, region.patches, result);
}

void MakeRegion::measure(const World::Spare& spare, const GroundRegion& region) const {
  // Numbers of all patches.
  std::span<std::uint32_t> all = spare.scratch.first(region.patches);
  std::iota(all.begin(), all.end(), 0u);
  PatchScratch* const scratch = make_patch_scratch(spare.room->scratch);
  // As many at a time as there is room for.
  const std::span<GridRows> rows = spare.room->rows;
  std::ranges::fill(rows, GridRows::all(world->info().level));
  for (std::size_t first = 0; first < all.size(); first += rows.size()) {
    const auto some = all.subspan(first, std::min(rows.size(), all.size() - first));
    spare.queue->add({spare.volumes, spare.patches}, spare.heights->heights(), some, some,
                     rows.first(some.size()), scratch, spare.measures);
  }
}

Status MakeRegion::run() {
  KARST_ASSERT(world->ground().can_be_dug);
  if (world->spare_regions() == 0)
    return {StatusCode::limit_reached, "there is no room for one more region", "dig_regions",
            world->ground().regions().size() + 1};
  const World::Spare spare = world->spare();
  GroundInfo info = world->ground();
  GroundRegion& region = info.region_list[spare.region] = {};
  region.nodes = nodes;
  region.corner.y = bottom;
  const int g = info.lattice_size;
  region.extent = {((nodes.high[0] - nodes.low[0]) << g) + 1, top - bottom,
                   ((nodes.high[1] - nodes.low[1]) << g) + 1};
  ++info.region_count;
  constexpr int kMost = (1 << kMaxDepth) - 1;
  if (!place_regions(info) || region.extent.x > kMost || region.extent.z > kMost || region.extent.y > kMost)
    return {StatusCode::invalid_argument, "no region may stand there", "place"};
  Status status = fill(spare, region);
  if (status.ok()) status = extract(spare, region);
  if (status.ok()) {
    fit(spare, region);
    measure(spare, region);
    status = ground->add_region(info);
  }
  if (!status.ok()) {
    empty(spare);
    return status;
  }
  world->open_region(region);
  return {};
}

void MakeRegion::take_back() {
  const std::size_t region = world->ground().regions().size() - 1;
  world->close_region();
  ground->drop_region(world->ground());
  KARST_ASSERT(world->ground().regions().size() == region);
  empty(world->spare());
}

}  // namespace karst::core
