// SPDX-License-Identifier: MIT
#include "bake/voxels/voxel_surface.h"

#include <algorithm>
#include <atomic>
#include <utility>

#include "bake/base/parallel.h"
#include "bake/voxels/repair_folds.h"
#include "bake/voxels/settle_voxels.h"
#include "terrain/base/check.h"
#include "terrain/base/config.h"
#include "terrain/field/voxelize.h"
#include "terrain/measure/measure_patches.h"
#include "terrain/patch/fit_heights.h"
#include "terrain/patch/generate_vertices.h"
#include "terrain/surface/bezier/extract_surface.h"

namespace karst::bake {
namespace {

constexpr std::size_t kMaxHeightBytes = 4ull << 30;  // of all patches: a host's memory

// Pages of vertices that a patch takes on the GPU: the default level lets a GPU hold all of a world.
std::uint32_t pages_of(int level) {
  return (static_cast<std::uint32_t>(patch_vertices(level)) + kPageVertices - 1) / kPageVertices;
}

// What leaves a world of so many patches within the limits.
std::string fewer(std::size_t patches) {
  int level = kMaxLevel;
  const auto bytes = [&] { return patches * static_cast<std::size_t>(patch_vertices(level)) * 2; };
  while (level > 0 && bytes() > kMaxHeightBytes) --level;
  return patches <= kMostPatches && level > 0 ? "try --levels " + std::to_string(level)
                                              : std::string("use a larger --voxel");
}

struct FieldContext {
  const Solid* solid;
  const WorldGrid* grid;
};
double field_value(const void* context, glm::dvec3 position) {
  const auto& c = *static_cast<const FieldContext*>(context);
  return c.solid->value_m(c.grid->to_m(position));
}

// Of one thread.
struct MeasureRoom {
  std::vector<std::byte> memory;
  std::vector<GpuVertex> vertices;
  PatchScratch* scratch = nullptr;

  explicit MeasureRoom(int level)
      : memory(patch_scratch_bytes() + Arena::kAlignment),
        vertices(static_cast<std::size_t>(patch_vertices(level))) {
    const auto at = reinterpret_cast<std::uintptr_t>(memory.data());
    const std::size_t skip = (Arena::kAlignment - at % Arena::kAlignment) % Arena::kAlignment;
    scratch = make_patch_scratch(std::span(memory).subspan(skip));
  }
};

}  // namespace

Error failure(const Status& status, const char* stage) {
  if (status.ok()) return {};
  return std::string(stage) + ": " + status.field() + ": " + status.what();
}

Error VoxelSurface::make_octree(std::uint32_t max_octets) {
  // Uninitialised: pages are touched as octets are used.
  const std::size_t bytes = Octree::bytes_for(max_octets) + Arena::kAlignment;
  memory_.reset(new std::byte[bytes]);
  void* aligned = memory_.get();
  std::size_t space = bytes;
  std::align(Arena::kAlignment, bytes - Arena::kAlignment, aligned, space);
  Arena arena({static_cast<std::byte*>(aligned), bytes - Arena::kAlignment});
  octree_ = Octree();
  return failure(octree_.create(arena, grid_.depth, max_octets), "octree");
}

Error VoxelSurface::fill_below(std::span<const float> tops) {
  const VoxelizeHeights voxelize{grid_.extent, tops};
  Error error = make_octree(std::max(1u, voxelize.count_octets(grid_.depth)));
  return error.ok() ? failure(voxelize.run(octree_), "voxels") : error;
}

Error VoxelSurface::fill(const Solid& solid) {
  const glm::ivec3 extent = grid_.extent;
  const auto row = static_cast<std::size_t>(extent.x), slice = row * static_cast<std::size_t>(extent.y);
  std::vector<float> values(slice * static_cast<std::size_t>(extent.z), -1.0f);
  parallel_chunks(static_cast<std::size_t>(extent.z), 1, threads_, [&](std::size_t z, std::size_t, int) {
    for (std::size_t k = 0; k < slice - row; ++k) {
      const glm::dvec3 corner(static_cast<double>(k % row), static_cast<double>(k / row),
                              static_cast<double>(z));
      values[z * slice + k] = static_cast<float>(solid.value_m(grid_.to_m(corner + 0.5)));
    }
  });
  settled_ = SettleVoxels{extent, values}.run();
  const auto is_filled = [&](glm::ivec3 v, bool) {
    return values[static_cast<std::size_t>(v.z) * slice + static_cast<std::size_t>(v.y) * row +
                  static_cast<std::size_t>(v.x)] > 0;
  };
  const VoxelizePredicate voxelize{extent, VoxelFunction(is_filled)};
  const std::uint32_t full_tree = ((1u << (3 * grid_.depth)) - 1) / 7;
  for (std::uint32_t octets = std::min(1u << 16, full_tree);; octets = std::min(4 * octets, full_tree)) {
    if (Error error = make_octree(octets); !error.ok()) return error;
    const Status status = voxelize.run(octree_);
    if (status.code() == StatusCode::limit_reached && octets < full_tree) continue;
    return failure(status, "voxels");
  }
}

Error VoxelSurface::extract(int level, bool may_lower) {
  level_ = level;
  ExtractSurface extract;
  extract.octree = &octree_;
  extract.extent = grid_.extent;
  extract.mirrors = mirrors_;
  ExtractSurface::Result counts;
  if (Error error = failure(extract.count(counts), "surface"); !error.ok()) return error;
  if (counts.patches == 0) return "the world has no surface: nothing, or everything, is filled";
  while (may_lower && level_ > 1 && counts.patches > kMostPages / pages_of(level_)) --level_;
  const std::size_t samples = counts.patches * static_cast<std::size_t>(patch_vertices(level_));
  if (counts.patches > kMostPatches || samples * sizeof(std::int16_t) > kMaxHeightBytes) {
    return "--levels: " + std::to_string(counts.patches) + " patches at level " + std::to_string(level_) +
           " are more than a world holds, " + std::to_string(kMostPatches) + " and 4 GiB of heights; " +
           fewer(counts.patches);
  }
  volumes_.resize(counts.volumes);
  patches_.resize(counts.patches);
  std::vector<std::uint32_t> scratch(ExtractSurface::scratch_size(counts.volumes));
  extract.volumes = volumes_;
  extract.patches = patches_;
  extract.scratch = scratch;
  if (Error error = failure(extract.run(counts), "surface"); !error.ok()) return error;
  for (std::uint32_t p = 0; p < patches_.size(); ++p) patches_[p].height_block = p;
  heights_.resize(samples);
  return {};
}

Error VoxelSurface::fit(const Solid& solid, bool is_height_field, const Judge& judge, Fit& made) {
  made = {};
  const FieldContext context{&solid, &grid_};
  FitHeights fit;
  fit.surface = {volumes_, patches_};
  fit.field = {field_value, &context};
  fit.level = level_;
  fit.heights = heights_;
  KARST_ASSERT(fit.validate().ok());
  std::atomic<std::uint64_t> done = 0;
  const std::size_t count = patches_.size(), chunks = (count + kFitChunk - 1) / kFitChunk;
  for (const bool tried : {true, false}) {
    std::vector<FitHeights::Result> results(static_cast<std::size_t>(threads_));
    parallel_chunks(chunks, 1, threads_, [&](std::size_t chunk, std::size_t, int worker) {
      if ((chunk % kTriedChunks == 0) != tried) return;
      const std::size_t first = chunk * kFitChunk, last = std::min(first + kFitChunk, count);
      fit.run(static_cast<PatchId>(first), static_cast<PatchId>(last),
              results[static_cast<std::size_t>(worker)]);
      const std::uint64_t now = done += last - first;
      if (worker == 0 && *progress_) (*progress_)("heights", now, count);
    });
    for (const FitHeights::Result& r : results) {
      made.vertices += r.vertices;
      made.misses += r.misses;
    }
    if (!tried || !judge) continue;
    if (Error error = judge(); !error.ok()) return error;
  }
  RepairFolds repair;
  repair.surface = fit.surface;
  repair.level = level_;
  repair.heights = heights_;
  repair.height_field = is_height_field;
  KARST_ASSERT(repair.validate().ok());
  const RepairFolds::Result folds = repair.run();
  made.folds_repaired = folds.folded_before - std::min(folds.folded_before, folds.folded_after);
  made.folds_left = folds.folded_after;
  return {};
}

VoxelSurface::Measures VoxelSurface::measure() const {
  const std::size_t count = patches_.size();
  Measures made{std::vector<std::uint16_t>(count * level_error_values(level_)),
                std::vector<PatchBounds>(count), std::vector<NormalCone>(count),
                std::vector<NormalCone>(count)};
  std::vector<BorderErrors> borders(count);
  MeasurePatches measure;
  measure.surface = {volumes_, patches_};
  measure.heights = {level_, heights_};
  measure.borders = borders;
  measure.out = {made.level_errors, made.bounds, made.cones, made.shading_cones};
  KARST_ASSERT(measure.validate().ok());
  std::vector<std::unique_ptr<MeasureRoom>> rooms;
  for (int t = 0; t < threads_; ++t) rooms.push_back(std::make_unique<MeasureRoom>(level_));
  parallel_chunks(count, kFitChunk, threads_, [&](std::size_t first, std::size_t last, int worker) {
    const std::unique_ptr<MeasureRoom>& room = rooms[static_cast<std::size_t>(worker)];
    measure.measure(first, last, {room->scratch, room->vertices});
  });
  parallel_chunks(count, kFitChunk, threads_,
                  [&](std::size_t first, std::size_t last, int) { measure.join(first, last); });
  return made;
}

std::vector<PatchKey> VoxelSurface::keys(std::uint32_t region) const {
  std::vector<PatchKey> keys;
  for (PatchId p = 0; p < patches_.size(); ++p) keys.push_back(key_of(surface(), p, region));
  return keys;
}

std::vector<std::byte> VoxelSurface::mask() const {
  std::vector<std::byte> mask((patches_.size() + 7) / 8, std::byte{0});
  for (std::size_t p = 0; p < patches_.size(); ++p) mask[p / 8] |= std::byte{1} << (p % 8);
  return mask;
}

void VoxelSurface::tell(WorldInfo& info) const {
  info.voxel_size_m = grid_.voxel_m;
  for (int k = 0; k < 3; ++k) info.origin_m[k] = grid_.origin_m[k];
  info.extent = grid_.extent;
  info.depth = grid_.depth;
  info.level = level_;
  info.octets = octree_.octets_used();
  info.volumes = static_cast<std::uint32_t>(volumes_.size());
  info.patches = info.height_blocks = static_cast<std::uint32_t>(patches_.size());
}

}  // namespace karst::bake
