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

// Behind heights of columns; stays until all is fitted.
std::span<float> samples_room(const World::Spare& spare, glm::ivec3 extent) {
  return spare.room->tops.subspan(static_cast<std::size_t>(extent.x) * static_cast<std::size_t>(extent.z));
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

void MakeRegion::fit(PatchId first, PatchId end) const {
  const World::Spare spare = world->spare();
  const WorldPart& part = world->part(spare.region);
  RegionHeights heights(world->ground(), nodes);
  heights.use(samples_room(spare, part.extent));
  const int level = world->info().level;
  const std::span<std::int16_t> block = spare.heights->block(spare.first);
  FitHeights fit;
  fit.surface = {spare.volumes, spare.patches.first(patches)};
  fit.field = {below_ground, &heights};
  fit.level = level;
  fit.step_voxels = kStep;
  fit.heights = {block.data(), patches * block.size()};
  KARST_ASSERT(fit.validate().ok());
  FitHeights::Result result;
  fit.run(first, end, result);
}

// Of neighbours in another step one has the other's bounds, whichever is first.
void MakeRegion::measure(PatchId first, PatchId end) const {
  const World::Spare spare = world->spare();
  PatchScratch* const scratch = make_patch_scratch(spare.room->scratch);
  const std::span<GridRows> rows = spare.room->rows;
  const std::span<PatchId> all = spare.room->touched;
  for (PatchId at = first; at < end;) {
    const std::size_t some = std::min<std::size_t>(end - at, std::min(rows.size(), all.size()));
    std::iota(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(some), at);
    std::ranges::fill(rows.first(some), GridRows::all(world->info().level));
    spare.queue->add({spare.volumes, spare.patches}, spare.heights->heights(), all.first(some),
                     all.first(some), rows.first(some), scratch, spare.measures);
    at += static_cast<PatchId>(some);
  }
}

Status MakeRegion::begin() {
  KARST_ASSERT(world->ground().can_be_dug);
  patches = fitted = measured = 0;
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
  if (status.ok()) status = ground->add_region(info);
  if (!status.ok()) {
    empty(spare);
    return status;
  }
  patches = region.patches;
  world->stage_region(region);
  return {};
}

bool MakeRegion::step() {
  const auto of_patch = static_cast<std::uint32_t>(patch_vertices(world->info().level));
  const auto next = [&](PatchId& done, std::uint32_t vertices) {
    const PatchId first = done;
    done = std::min(patches, first + std::max(1u, vertices / of_patch));
    return first;
  };
  if (fitted < patches) {
    const PatchId first = next(fitted, kFitted);
    fit(first, fitted);
  } else if (measured < patches) {
    const PatchId first = next(measured, kBounded);
    measure(first, measured);
  } else {
    world->build_staged();
    return true;
  }
  return false;
}

Status MakeRegion::run() {
  if (const Status status = begin(); !status.ok()) return status;
  while (!step()) {
  }
  world->open_region();
  return {};
}

void MakeRegion::take_back() {
  world->unstage_region();
  ground->drop_region(world->ground());
  empty(world->spare());
}

}  // namespace karst::core
